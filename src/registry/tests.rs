use toml::{Table, Value};

use super::*;
use crate::entry::{Kind, Parameter, ParameterError, Range};
use crate::technique::Terms;

/// Shows every entry, with what builds it from its parameters.
fn each_entry(mut show: impl FnMut(&About, &dyn Fn(&Table) -> Result<(), ParameterError>)) {
    for entry in FIRST_STAGES {
        show(&entry.about, &|table| (entry.build)(table).map(drop));
    }
    for entry in REFINEMENTS {
        show(&entry.about, &|table| (entry.build)(table).map(drop));
    }
    for entry in INTERPOLATIONS {
        show(&entry.about, &|table| (entry.build)(table).map(drop));
    }
    for entry in ENVIRONMENT_SAMPLERS {
        show(&entry.about, &|table| (entry.build)(table).map(drop));
    }
    for entry in TECHNIQUES {
        show(&entry.about, &|table| (entry.build)(table).map(drop));
        let technique = (entry.build)(&Table::new()).expect("the defaults");
        for listed in (entry.contenders)() {
            if let [about] = listed.parts.as_slice() {
                show(about, &|table| {
                    let started = technique.start(&listed.id, table, Terms::default());
                    started.map(drop)
                });
            }
        }
    }
}

/// The parameters, those of tables among them, each with the keys of the tables that it lies in.
fn flat(parameters: &'static [Parameter]) -> Vec<(Vec<&'static str>, Parameter)> {
    let mut found = Vec::new();
    for parameter in parameters {
        match parameter.kind {
            Kind::Table(inner) => found.extend(flat(inner).into_iter().map(|(mut path, inner)| {
                path.insert(0, parameter.key);
                (path, inner)
            })),
            _ => found.push((Vec::new(), *parameter)),
        }
    }
    found
}

/// A table with one value.
fn table(path: &[&str], key: &str, value: Value) -> Table {
    let innermost = Table::from_iter([(key.to_owned(), value)]);
    path.iter().rev().fold(innermost, |inner, outer| {
        Table::from_iter([(outer.to_string(), Value::Table(inner))])
    })
}

/// Values that a parameter must refuse.
fn unfit(parameter: &Parameter) -> Vec<Value> {
    let mut outside = match parameter.range {
        Range::Any => Vec::new(),
        Range::AtLeast(least) => vec![least - 1.0],
        Range::Above(bound) => vec![bound - 1.0, bound],
        Range::Within(least, most) => vec![least - 1.0, most + 1.0],
        Range::AboveUpTo(bound, most) => vec![bound, most + 1.0],
    };
    let mut values = vec![Value::String("no such word".into())];
    if let Kind::Whole | Kind::WholeOr(_) = parameter.kind {
        values.extend(outside.drain(..).map(|x| Value::Integer(x as i64)));
        values.push(Value::Float(1.5));
    }
    outside.extend([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
    if let Kind::Numbers(count) = parameter.kind {
        for number in &outside {
            let mut numbers = vec![Value::Integer(1); count];
            numbers[count - 1] = Value::Float(*number);
            values.push(Value::Array(numbers));
        }
    }
    values.extend(outside.into_iter().map(Value::Float));
    values
}

#[test]
fn every_declared_default_is_taken_as_it_is_written() {
    each_entry(|about, build| {
        build(&Table::new()).expect(about.id);
        for (path, parameter) in flat(about.parameters) {
            let Some(text) = (parameter.default)() else {
                continue;
            };
            let value: Value = text.parse().expect(parameter.key);
            assert_eq!(value.to_string(), text, "{} {}", about.id, parameter.key);
            let given = table(&path, parameter.key, value);
            build(&given).unwrap_or_else(|error| panic!("{}: {error}", about.id));
        }
    });
}

#[test]
fn every_value_out_of_range_is_refused_with_its_key_and_what_is_expected() {
    let mut refused = 0;
    each_entry(|about, build| {
        for (path, parameter) in flat(about.parameters) {
            for value in unfit(&parameter) {
                let given = table(&path, parameter.key, value);
                let Err(error) = build(&given) else {
                    panic!("{} takes {given}", about.id);
                };
                let key = path.first().unwrap_or(&parameter.key);
                assert_eq!(error.key, *key, "{} {given}", about.id);
                for said in [parameter.key, &parameter.permitted()] {
                    assert!(error.message.contains(said), "{given}: {error}");
                }
                refused += 1;
            }
        }
    });
    assert!(refused > 500, "{refused}");
}

#[test]
fn keys_that_are_not_declared_are_refused() {
    each_entry(|about, build| {
        let key = "no_such_key";
        let error = build(&table(&[], key, Value::Boolean(true))).expect_err(about.id);
        assert_eq!(error.key, key, "{}: {error}", about.id);
    });
}

#[test]
fn every_parameter_has_a_meaning_of_one_line() {
    for (_, about) in entries() {
        for (_, parameter) in flat(about.parameters) {
            let Parameter { key, meaning, .. } = parameter;
            assert!(
                !meaning.is_empty() && !meaning.contains(['|', '\n']),
                "{key}"
            );
        }
    }
}
