//! `run --profile`: what the stages of all jobs took, and how well threads shared the work.

use crate::experiment::{Row, SEARCH_STAGE};
use crate::technique::{Seconds, Stages};

/// A line a stage, and one for what was done besides the jobs: wall and processor seconds, threads that were busy on average,
/// and the share of processor time that one thread spent alone.
pub fn text(rows: &[Row], besides: &Stages) -> String {
    let mut stages: Vec<(&str, Seconds)> = Vec::new();
    let number = |value: Option<&serde_json::Value>| value.and_then(serde_json::Value::as_f64);
    for row in rows {
        for (stage, wall) in row
            .seconds
            .iter()
            .filter(|(stage, _)| *stage != SEARCH_STAGE)
        {
            let cpu = number(row.cpu_seconds.get(stage)).unwrap_or(0.0);
            let at = stages.iter().position(|(name, _)| name == stage);
            let at = at.unwrap_or_else(|| {
                stages.push((stage, Seconds::default()));
                stages.len() - 1
            });
            let sums = &mut stages[at].1;
            sums.wall += number(Some(wall)).unwrap_or(0.0);
            sums.cpu += cpu;
            sums.serial += cpu * number(row.serial_share.get(stage)).unwrap_or(0.0);
        }
    }
    let mut text = format!(
        "{:<20} {:>10} {:>10} {:>8} {:>8}\n",
        "stage", "wall, s", "CPU, s", "threads", "serial"
    );
    let besides = besides.0.iter().map(|stage| (stage.name, stage.seconds));
    for (stage, sums) in stages.into_iter().chain(besides) {
        let threads = sums.cpu / sums.wall.max(f64::MIN_POSITIVE);
        let serial = 100.0 * sums.serial / sums.cpu.max(f64::MIN_POSITIVE);
        text.push_str(&format!(
            "{stage:<20} {:>10.3} {:>10.3} {threads:>8.2} {serial:>6.1} %\n",
            sums.wall, sums.cpu
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_of_all_jobs_are_summed_and_searches_left_out_and_work_besides_is_added() {
        let mut row = Row::default();
        row.seconds.insert("rendering".into(), 2.0.into());
        row.cpu_seconds.insert("rendering".into(), 3.0.into());
        row.serial_share.insert("rendering".into(), 0.5.into());
        row.seconds.insert(SEARCH_STAGE.into(), 9.0.into());
        row.cpu_seconds.insert(SEARCH_STAGE.into(), 9.0.into());
        let mut besides = Stages::default();
        let loading = Seconds {
            wall: 1.0,
            cpu: 1.5,
            serial: 0.3,
        };
        besides.add("loading", loading);
        let text = text(&[row.clone(), row], &besides);
        assert!(
            text.contains("1.000      1.500     1.50   20.0 %"),
            "{text}"
        );
        assert!(
            text.contains("4.000      6.000     1.50   50.0 %"),
            "{text}"
        );
        assert!(!text.contains("search"), "{text}");
    }
}
