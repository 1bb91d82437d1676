//! From a config to rows: overrides, plan, run, store, claims and gates.

mod row;

pub use row::Row;
