//! `gate`: the exit code says whether the bounds hold.

use std::fmt::Write as _;

use super::args::GateArgs;
use super::exit::{self, Failure};
use super::out::say;
use crate::experiment::{Cases, Expression, Judged, Store, Verdict, judge, overall};

/// A gate, what was expected, and its judgement per scene and swept value.
struct Gate {
    text: String,
    expect: String,
    judged: Vec<Judged>,
}

/// Judges every gate; a config without gates gates on its claims.
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
    let failed_jobs = cases.failed().count();
    for gate in &gates {
        print(gate);
    }
    say!("{} gates, {failed_jobs} failed jobs", gates.len());
    if let Some(file) = &args.junit {
        std::fs::write(file, junit(&plan.name, &gates))?;
    }
    Ok(exit_code(&gates, failed_jobs))
}

fn judged(text: &str, expect: &str, scenes: &[String], cases: &Cases) -> Result<Gate, Failure> {
    let expression = Expression::parse(expect).map_err(Failure::usage)?;
    Ok(Gate {
        text: text.to_owned(),
        expect: expect.to_owned(),
        judged: judge(&expression, cases, scenes),
    })
}

fn exit_code(gates: &[Gate], failed_jobs: usize) -> u8 {
    let verdicts: Vec<Verdict> = gates.iter().map(|g| overall(&g.judged)).collect();
    if verdicts.contains(&Verdict::DoesNotHold) {
        exit::GATE_FAILED
    } else if failed_jobs > 0 {
        exit::SOME_FAILED
    } else if verdicts.is_empty() || verdicts.contains(&Verdict::NoData) {
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
    let interval = one.half_width.map_or_else(
        || "one run".to_owned(),
        |h| format!("±{h:.2e}, {} repeats", one.repeats),
    );
    format!(
        "{} {}: {} — {:.6} against {:.6} ({interval})",
        one.scene,
        one.at,
        word(one.verdict),
        one.smaller,
        one.larger
    )
}

/// One test case a gate; what is open or without data is `skipped`.
fn junit(name: &str, gates: &[Gate]) -> String {
    let count = |verdict| {
        gates
            .iter()
            .filter(|g| overall(&g.judged) == verdict)
            .count()
    };
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(
        xml,
        "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" skipped=\"{}\">",
        escape(name),
        gates.len(),
        count(Verdict::DoesNotHold),
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
    xml.push_str("</testsuite>\n");
    xml
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
