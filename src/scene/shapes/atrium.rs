use super::PartFunction;
pub const PARTS: &[(&str, PartFunction)] = &[];
