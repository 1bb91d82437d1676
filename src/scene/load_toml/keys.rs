//! Tables with places: every key that is read is remembered, every other one is an error.

use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::scene::SceneError;
use crate::scene::text::{advice, error_at};

/// The text that errors point into.
pub(super) struct Source<'a> {
    pub file: &'a Path,
    pub text: &'a str,
}

impl Source<'_> {
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> SceneError {
        error_at(self.file, self.text, span.start, message.into())
    }
}

#[cfg(test)]
thread_local! {
    /// Every key that a thread asked for, for the test of the page that lists them.
    pub(super) static ASKED: RefCell<std::collections::BTreeSet<&'static str>> = RefCell::default();
}

/// A table that is being read.
pub(super) struct Keys<'a> {
    pub source: &'a Source<'a>,
    table: &'a DeTable<'a>,
    pub span: Range<usize>,
    /// How errors call it: `[[view]]`, `material of kind plastic`.
    pub what: String,
    asked: RefCell<Vec<&'static str>>,
}

/// An item of a list of names.
pub(super) struct Name<'a> {
    pub name: &'a str,
    pub item: &'a Spanned<DeValue<'a>>,
}

impl<'a> Keys<'a> {
    pub fn new(
        source: &'a Source<'a>,
        table: &'a DeTable<'a>,
        span: Range<usize>,
        what: impl Into<String>,
    ) -> Self {
        Self {
            source,
            table,
            span,
            what: what.into(),
            asked: RefCell::default(),
        }
    }

    /// A value that must be a table.
    pub fn of(
        source: &'a Source<'a>,
        value: &'a Spanned<DeValue<'a>>,
        what: impl Into<String>,
    ) -> Result<Self, SceneError> {
        let what = what.into();
        match value.get_ref() {
            DeValue::Table(table) => Ok(Self::new(source, table, value.span(), what)),
            other => {
                let message = format!("{what}: expected a table, found {}", other.type_str());
                Err(source.error(value.span(), message))
            }
        }
    }

    /// All entries, for tables whose keys are names.
    pub fn entries(&self) -> impl Iterator<Item = (&'a str, &'a Spanned<DeValue<'a>>)> + use<'a> {
        self.table.iter().map(|(k, v)| (k.get_ref().as_ref(), v))
    }

    pub fn get(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        #[cfg(test)]
        ASKED.with_borrow_mut(|asked| asked.insert(key));
        self.asked.borrow_mut().push(key);
        self.table
            .iter()
            .find(|(k, _)| k.get_ref() == key)
            .map(|(_, v)| v)
    }

    /// An error at a value.
    pub fn wrong(&self, key: &str, value: &Spanned<DeValue>, expected: &str) -> SceneError {
        let found = match value.get_ref() {
            DeValue::Integer(i) => i.to_string(),
            DeValue::Float(f) => f.as_str().to_owned(),
            DeValue::String(s) => format!("\"{s}\""),
            DeValue::Boolean(b) => b.to_string(),
            other => format!("a value of type {}", other.type_str()),
        };
        let message = format!(
            "`{key}` of {}: expected {expected}, found {found}",
            self.what
        );
        self.source.error(value.span(), message)
    }

    /// An error at the table.
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        self.source.error(self.span.clone(), message)
    }

    /// The value of a key that must be there.
    pub fn required<T>(&self, key: &str, value: Option<T>) -> Result<T, SceneError> {
        value.ok_or_else(|| self.error(format!("{} needs `{key}`", self.what)))
    }

    pub fn string(&self, key: &'static str) -> Result<Option<&'a str>, SceneError> {
        self.get(key)
            .map(|v| match v.get_ref() {
                DeValue::String(s) => Ok(s.as_ref()),
                _ => Err(self.wrong(key, v, "a string")),
            })
            .transpose()
    }

    /// A list of names, each with its place.
    pub fn names(&self, key: &'static str) -> Result<Option<Vec<Name<'a>>>, SceneError> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let items = value.get_ref().as_array();
        let items = items.ok_or_else(|| self.wrong(key, value, "a list of names"))?;
        let names = items.iter().map(|item| {
            let name = item.get_ref().as_str();
            let name = name.ok_or_else(|| self.wrong(key, item, "a name"))?;
            Ok(Name { name, item })
        });
        names.collect::<Result<_, _>>().map(Some)
    }

    pub fn boolean(&self, key: &'static str, default: bool) -> Result<bool, SceneError> {
        match self.get(key) {
            None => Ok(default),
            Some(v) => v
                .get_ref()
                .as_bool()
                .ok_or_else(|| self.wrong(key, v, "true or false")),
        }
    }

    /// A finite number of single precision.
    pub fn number(&self, key: &'static str) -> Result<Option<f64>, SceneError> {
        self.get(key)
            .map(|v| number(v.get_ref()).ok_or_else(|| self.wrong(key, v, NUMBER)))
            .transpose()
    }

    /// A number greater than zero.
    pub fn positive(&self, key: &'static str) -> Result<Option<f64>, SceneError> {
        match (self.number(key)?, self.get(key)) {
            (Some(x), Some(v)) if x <= 0.0 => Err(self.wrong(key, v, "a number above 0")),
            (x, _) => Ok(x),
        }
    }

    /// A number of at least zero.
    pub fn non_negative(&self, key: &'static str) -> Result<Option<f64>, SceneError> {
        match (self.number(key)?, self.get(key)) {
            (Some(x), Some(v)) if x < 0.0 => Err(self.wrong(key, v, "a number of at least 0")),
            (x, _) => Ok(x),
        }
    }

    /// A whole number between the bounds.
    pub fn whole(&self, key: &'static str, bounds: Range<u32>) -> Result<Option<u32>, SceneError> {
        let Some(v) = self.get(key) else {
            return Ok(None);
        };
        let integer = match v.get_ref() {
            DeValue::Integer(_) => number(v.get_ref()),
            _ => None,
        };
        match integer.filter(|x| *x >= 0.0).map(|x| x as u32) {
            Some(x) if bounds.contains(&x) => Ok(Some(x)),
            _ => {
                let expected =
                    format!("a whole number from {} to {}", bounds.start, bounds.end - 1);
                Err(self.wrong(key, v, &expected))
            }
        }
    }

    /// A list of `N` finite numbers of single precision.
    pub fn numbers<const N: usize>(
        &self,
        key: &'static str,
    ) -> Result<Option<[f64; N]>, SceneError> {
        self.get(key)
            .map(|v| {
                list(v.get_ref())
                    .and_then(|list| <[f64; N]>::try_from(list).ok())
                    .ok_or_else(|| {
                        self.wrong(
                            key,
                            v,
                            &format!("a list of {N} finite numbers of at most 3.4e38"),
                        )
                    })
            })
            .transpose()
    }

    pub fn vector(&self, key: &'static str) -> Result<Option<DVec3>, SceneError> {
        Ok(self.numbers::<3>(key)?.map(DVec3::from))
    }

    /// A colour: a list of three numbers of at least zero, or one for a grey.
    pub fn colour(&self, key: &'static str) -> Result<Option<[f32; 3]>, SceneError> {
        self.get(key).map(|v| self.colour_of(key, v)).transpose()
    }

    pub fn colour_of(&self, key: &str, v: &Spanned<DeValue>) -> Result<[f32; 3], SceneError> {
        let grey = number(v.get_ref()).map(|x| vec![x; 3]);
        grey.or_else(|| list(v.get_ref()))
            .and_then(|list| <[f64; 3]>::try_from(list).ok())
            .filter(|c| c.iter().all(|x| (0.0..=f64::from(f32::MAX)).contains(x)))
            .map(|c| c.map(|x| x as f32))
            .ok_or_else(|| self.wrong(key, v, "[r, g, b] or one number, none below 0"))
    }

    /// What share of light is kept, a channel each.
    pub fn share(&self, key: &'static str) -> Result<Option<[f32; 3]>, SceneError> {
        self.get(key).map(|v| self.share_of(key, v)).transpose()
    }

    pub fn share_of(&self, key: &str, v: &Spanned<DeValue>) -> Result<[f32; 3], SceneError> {
        let colour = self.colour_of(key, v)?;
        match colour.iter().all(|share| *share <= 1.0) {
            true => Ok(colour),
            false => Err(self.wrong(key, v, "[r, g, b] or one number, each from 0 to 1")),
        }
    }

    /// One of the words of a table, else the default (first) one.
    pub fn word<T: Copy>(&self, key: &'static str, words: &[(&str, T)]) -> Result<T, SceneError> {
        let Some(word) = self.string(key)? else {
            return Ok(words[0].1);
        };
        let known: Vec<&str> = words.iter().map(|(w, _)| *w).collect();
        words
            .iter()
            .find(|(w, _)| *w == word)
            .map(|(_, value)| *value)
            .ok_or_else(|| self.unknown(key, word, &known))
    }

    /// The kind of a table whose other keys depend on it.
    pub fn kind(&self, known: &[&str]) -> Result<&'a str, SceneError> {
        let kind = self.string("kind")?;
        let kind = kind.ok_or_else(|| {
            self.error(format!(
                "{} needs `kind`; known: {}",
                self.what,
                known.join(", ")
            ))
        })?;
        match known.contains(&kind) {
            true => Ok(kind),
            false => Err(self.unknown("kind", kind, known)),
        }
    }

    /// An error about a word, at the value of its key.
    pub fn unknown(&self, key: &'static str, word: &str, known: &[&str]) -> SceneError {
        let span = self.get(key).map_or(self.span.clone(), Spanned::span);
        self.unknown_at(span, key, word, known)
    }

    /// An error about a word of a list, at its place.
    pub fn unknown_at(
        &self,
        span: Range<usize>,
        key: &str,
        word: &str,
        known: &[&str],
    ) -> SceneError {
        let message = format!(
            "`{key}` of {}: `{word}` is unknown; {}",
            self.what,
            advice(word, known)
        );
        self.source.error(span, message)
    }

    /// The tables of an array of tables.
    pub fn tables(&self, key: &'static str) -> Result<Vec<Keys<'a>>, SceneError> {
        let Some(v) = self.get(key) else {
            return Ok(Vec::new());
        };
        match v.get_ref() {
            DeValue::Array(items) => items
                .iter()
                .map(|item| Keys::of(self.source, item, format!("[[{key}]]")))
                .collect(),
            _ => Err(self.wrong(key, v, &format!("[[{key}]] tables"))),
        }
    }

    /// Fails on the first key that nobody asked for.
    pub fn finish(&self) -> Result<(), SceneError> {
        let mut known = self.asked.borrow().clone();
        known.sort_unstable();
        known.dedup();
        match self
            .table
            .iter()
            .find(|(k, _)| !known.contains(&k.get_ref().as_ref()))
        {
            None => Ok(()),
            Some((key, _)) => {
                let name = key.get_ref();
                let message = format!(
                    "unknown key `{name}` in {}; {}",
                    self.what,
                    advice(name, &known)
                );
                Err(self.source.error(key.span(), message))
            }
        }
    }
}

/// What [`number`] reads.
pub(super) const NUMBER: &str = "a finite number of at most 3.4e38";

/// A number that single precision holds; TOML integers count.
pub(super) fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix())
            .ok()
            .map(|i| i as f64),
        DeValue::Float(f) => f
            .as_str()
            .parse::<f64>()
            .ok()
            .filter(|x| x.abs() <= f64::from(f32::MAX)),
        _ => None,
    }
}

/// A list of such numbers.
pub(super) fn list(value: &DeValue) -> Option<Vec<f64>> {
    value
        .as_array()?
        .iter()
        .map(|item| number(item.get_ref()))
        .collect()
}
