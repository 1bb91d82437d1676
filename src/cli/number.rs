//! Numbers as verbs print them.

/// Six decimals, and none of what is large: of counts, for one.
pub fn told(value: f64) -> String {
    let decimals = if value.abs() < 1000.0 { 6 } else { 0 };
    format!("{value:.decimals$}")
}

/// Half the width of an interval.
pub fn half_width(half: f64) -> String {
    match half {
        0.0 => "±0".to_owned(),
        100.0.. => format!("±{half:.0}"),
        _ => format!("±{half:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_no_decimals() {
        assert_eq!(told(0.084_34), "0.084340");
        assert_eq!(told(-1_318_751.4), "-1318751");
        assert_eq!(half_width(0.0), "±0");
        assert_eq!(half_width(593.2), "±593");
        assert_eq!(half_width(0.00138), "±1.38e-3");
    }
}
