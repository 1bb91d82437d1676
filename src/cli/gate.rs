//! `gate`: the exit code says whether the bounds hold.

use std::fmt::Write as _;

use super::args::GateArgs;
use super::exit::{self, Failure};
use super::number::{half_width, told};
use super::out::say;
use crate::experiment::{Cases, Expression, Judged, Plan, Store, Verdict, judge, overall};
use crate::standard_error::tell;

/// A gate, what was expected, and its judgement per scene and swept value.
struct Gate {
    text: String,
    expect: String,
    judged: Vec<Judged>,
}

/// Most failed jobs that are printed; a JUnit file has all.
const MOST_FAILURES: usize = 20;

/// What is known of the jobs that gates are judged by.
struct Jobs {
    planned: usize,
    /// Without a row.
    missing: usize,
    /// Those that failed with their reasons, a line each.
    failed: Vec<String>,
    /// What was replaced, left out or fell short, a line each.
    notes: Vec<String>,
}

/// Judges every gate; a config without gates gates on its claims. Jobs without a row, or failed, are no
/// pass, whatever the gates say of the others.
pub fn run(args: &GateArgs) -> Result<u8, Failure> {
    let store = Store::open(&args.folder)?;
    let plan = store.plan()?;
    let config = store.config()?;
    let cases = Cases::new(&plan.jobs, store.rows(&plan));
    let mut gates = Vec::new();
    for gate in &config.gate {
        gates.push(judged(&gate.text, &gate.expect, &gate.scenes, &cases)?);
    }
    if gates.is_empty() {
        for claim in &config.claim {
            gates.push(judged(&claim.text, &claim.expect, &claim.scenes, &cases)?);
        }
    }
    let jobs = Jobs {
        planned: plan.jobs.len() + plan.in_other_shards(),
        missing: cases.missing(&plan.jobs).len() + plan.in_other_shards(),
        failed: cases.failures(),
        notes: notes(&plan, &cases),
    };
    for gate in &gates {
        print(gate);
    }
    jobs.notes.iter().for_each(|note| tell!("note: {note}"));
    let some = if gates.len() == 1 { "" } else { "s" };
    say!("{} gate{some}, {}", gates.len(), jobs.describe());
    jobs.failed
        .iter()
        .take(MOST_FAILURES)
        .for_each(|job| say!("  {job}"));
    if jobs.failed.len() > MOST_FAILURES {
        say!("  and {} more", jobs.failed.len() - MOST_FAILURES);
    }
    if let Some(file) = &args.junit {
        crate::files::write(file, junit(&plan.name, &gates, &jobs))?;
    }
    Ok(exit_code(&gates, &jobs))
}

/// Notes of the plan and of the rows.
fn notes(plan: &Plan, cases: &Cases) -> Vec<String> {
    let of_rows = cases.notes();
    let of_rows = of_rows
        .iter()
        .map(|note| format!("{}: {}", note.runs.join(", "), note.text));
    let absent = match plan.in_other_shards() {
        0 => None,
        jobs => Some(format!(
            "{jobs} jobs are in shards that are not here: `merge` them first"
        )),
    };
    plan.told()
        .into_iter()
        .chain(absent)
        .chain(of_rows)
        .collect()
}

impl Jobs {
    fn all_done(&self) -> bool {
        self.missing == 0 && self.failed.is_empty()
    }

    fn describe(&self) -> String {
        format!(
            "{} of {} jobs without a result, {} failed jobs",
            self.missing,
            self.planned,
            self.failed.len()
        )
    }
}

fn judged(text: &str, expect: &str, scenes: &[String], cases: &Cases) -> Result<Gate, Failure> {
    let expression = Expression::parse(expect).map_err(Failure::usage)?;
    Ok(Gate {
        text: text.to_owned(),
        expect: expect.to_owned(),
        judged: judge(&expression, cases, scenes),
    })
}

fn exit_code(gates: &[Gate], jobs: &Jobs) -> u8 {
    let verdicts: Vec<Verdict> = gates.iter().map(|g| overall(&g.judged)).collect();
    if verdicts.contains(&Verdict::DoesNotHold) {
        exit::GATE_FAILED
    } else if !jobs.failed.is_empty() {
        exit::SOME_FAILED
    } else if jobs.missing > 0 || verdicts.is_empty() || verdicts.contains(&Verdict::NoData) {
        exit::GATE_NO_DATA
    } else if verdicts.contains(&Verdict::Inconclusive) {
        exit::GATE_INCONCLUSIVE
    } else {
        exit::OK
    }
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "pass",
        Verdict::DoesNotHold => "FAIL",
        Verdict::Inconclusive => "inconclusive",
        Verdict::NoData => "no data",
    }
}

fn print(gate: &Gate) {
    say!(
        "{:<12} {}   [{}]",
        word(overall(&gate.judged)),
        gate.text,
        gate.expect
    );
    for one in gate.judged.iter().filter(|j| j.verdict != Verdict::Holds) {
        say!("             {}", describe(one));
    }
}

fn describe(one: &Judged) -> String {
    let subject = [one.scene.as_str(), &one.at].join(" ");
    let subject = subject.trim_end();
    if one.verdict == Verdict::NoData {
        let why = match one.repeats {
            0 => "no seed has a finite value of all that is compared".to_owned(),
            n if n < one.seeds => format!(
                "only {n} of {} seeds have a finite value of all that is compared",
                one.seeds
            ),
            _ => "what is compared is no finite number: something is divided by zero, or overflows"
                .to_owned(),
        };
        return format!("{subject}: no data, because {why}");
    }
    let interval = one.half_width.map_or_else(
        || "one run".to_owned(),
        |h| format!("{}, {} repeats", half_width(h), one.repeats),
    );
    let (left, right) = one.sides();
    format!(
        "{subject}: {} — {} against {} ({interval})",
        word(one.verdict),
        told(left),
        told(right)
    )
}

/// One test case a gate; what is open or without data is `skipped`. Jobs without a result are the error
/// of a test case of their own, and what rows note stands at the end.
fn junit(name: &str, gates: &[Gate], jobs: &Jobs) -> String {
    let count = |verdict| {
        gates
            .iter()
            .filter(|g| overall(&g.judged) == verdict)
            .count()
    };
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(
        xml,
        "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">",
        escape(name),
        gates.len() + usize::from(!jobs.all_done()),
        count(Verdict::DoesNotHold),
        usize::from(!jobs.all_done()),
        count(Verdict::Inconclusive) + count(Verdict::NoData)
    );
    for gate in gates {
        let _ = write!(
            xml,
            "  <testcase classname=\"{}\" name=\"{}\">",
            escape(name),
            escape(&gate.text)
        );
        let details: Vec<String> = gate.judged.iter().map(describe).collect();
        let details = escape(&format!("{}\n{}", gate.expect, details.join("\n")));
        let _ = match overall(&gate.judged) {
            Verdict::Holds => write!(xml, "<system-out>{details}</system-out>"),
            Verdict::DoesNotHold => write!(
                xml,
                "<failure message=\"does not hold\">{details}</failure>"
            ),
            open => write!(
                xml,
                "<skipped message=\"{}\"/><system-out>{details}</system-out>",
                word(open)
            ),
        };
        xml.push_str("</testcase>\n");
    }
    if !jobs.all_done() {
        let _ = writeln!(
            xml,
            "  <testcase classname=\"{}\" name=\"every job has a result\"><error message=\"{}\">{}</error></testcase>",
            escape(name),
            escape(&jobs.describe()),
            escape(&jobs.failed.join("\n"))
        );
    }
    if !jobs.notes.is_empty() {
        let notes = escape(&jobs.notes.join("\n"));
        let _ = writeln!(xml, "  <system-out>{notes}</system-out>");
    }
    xml.push_str("</testsuite>\n");
    xml
}

fn escape(text: &str) -> String {
    crate::report::xml_text(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held() -> Gate {
        Gate {
            text: "bounded".into(),
            expect: "rmse(A) < 1".into(),
            judged: vec![Judged {
                scene: "s".into(),
                at: String::new(),
                verdict: Verdict::Holds,
                smaller: 0.1,
                larger: 1.0,
                larger_first: false,
                half_width: None,
                repeats: 1,
                seeds: 1,
            }],
        }
    }

    fn jobs(missing: usize, failed: usize) -> Jobs {
        Jobs {
            planned: 6,
            missing,
            failed: (0..failed)
                .map(|n| format!("kitchen A seed {n}: failed: no memory & no swap"))
                .collect(),
            notes: Vec::new(),
        }
    }

    #[test]
    fn jobs_without_a_result_are_no_pass() {
        let gates = [held()];
        assert_eq!(exit_code(&gates, &jobs(0, 0)), exit::OK);
        assert_eq!(exit_code(&gates, &jobs(3, 0)), exit::GATE_NO_DATA);
        assert_eq!(exit_code(&gates, &jobs(0, 1)), exit::SOME_FAILED);
        let xml = junit("x", &gates, &jobs(3, 1));
        assert!(
            xml.contains("tests=\"2\" failures=\"0\" errors=\"1\""),
            "{xml}"
        );
        let told = "3 of 6 jobs without a result, 1 failed jobs";
        assert!(xml.contains(told), "{xml}");
        assert!(
            xml.contains(">kitchen A seed 0: failed: no memory &amp; no swap</error>"),
            "{xml}"
        );
        let done = junit("x", &gates, &jobs(0, 0));
        assert!(
            done.contains("tests=\"1\" failures=\"0\" errors=\"0\""),
            "{done}"
        );
    }

    #[test]
    fn what_has_no_data_shows_no_numbers() {
        let mut one = held().judged.remove(0);
        assert_eq!(
            describe(&one),
            "s: pass — 0.100000 against 1.000000 (one run)"
        );
        one.larger_first = true;
        assert!(describe(&one).contains("1.000000 against 0.100000"));
        (one.verdict, one.smaller, one.larger) = (Verdict::NoData, -0.0, -0.0);
        let told = describe(&one);
        assert!(told.starts_with("s: no data"), "{told}");
        assert!(!told.contains("0.000"), "{told}");
        one.seeds = 3;
        assert!(describe(&one).contains("only 1 of 3 seeds have"));
    }

    #[test]
    fn control_characters_are_replaced() {
        let gate = Gate {
            text: "bell \u{7}".into(),
            ..held()
        };
        let xml = junit("x", &[gate], &jobs(0, 0));
        assert!(xml.contains("bell \u{fffd}"), "{xml}");
        assert!(!xml.contains('\u{7}'), "{xml}");
    }

    #[test]
    fn notes_of_rows_stand_in_the_file() {
        let noted = Jobs {
            notes: vec![
                "kitchen A, kitchen B: the map was not found & a grey sky stands in".into(),
            ],
            ..jobs(0, 0)
        };
        let xml = junit("x", &[held()], &noted);
        let told = "kitchen A, kitchen B: the map was not found &amp; a grey sky stands in";
        assert!(xml.contains(told), "{xml}");
    }
}
