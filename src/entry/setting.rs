//! Types of parameters.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::Parameter;

/// What a parameter takes, whatever its range.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A real number.
    Number,
    /// A number, or this word.
    NumberOr(&'static str),
    /// A whole number.
    Whole,
    /// A whole number, or this word.
    WholeOr(&'static str),
    /// An array of so many numbers.
    Numbers(usize),
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Words(&'static [&'static str]),
    /// A table of parameters of its own.
    Table(&'static [Parameter]),
}

/// A type of parameters.
pub trait Setting: Serialize + DeserializeOwned {
    /// What values look like in TOML.
    const KIND: Kind;
}

/// The kind of each type.
macro_rules! kinds {
    ($($type:ty: $kind:ident;)*) => {
        $(impl Setting for $type {
            const KIND: Kind = Kind::$kind;
        })*
    };
}

kinds! {
    f32: Number;
    f64: Number;
    i32: Whole;
    u32: Whole;
    u64: Whole;
    usize: Whole;
    bool: Flag;
}

impl<T: Setting> Setting for Option<T> {
    const KIND: Kind = T::KIND;
}

impl Setting for [f32; 2] {
    const KIND: Kind = Kind::Numbers(2);
}

impl Setting for [f32; 4] {
    const KIND: Kind = Kind::Numbers(4);
}

/// An enum whose variants are called by words.
macro_rules! words {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $name:ident {
            $($(#[$note:meta])* $variant:ident = $word:literal,)+
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
        $visibility enum $name {
            $($(#[$note])* #[serde(rename = $word)] $variant,)+
        }

        impl $crate::entry::Setting for $name {
            const KIND: $crate::entry::Kind = $crate::entry::Kind::Words(&[$($word),+]);
        }
    };
}

pub(crate) use words;
