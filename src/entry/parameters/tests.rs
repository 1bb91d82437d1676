use super::*;
use crate::entry::words;

words! {
    enum Colour {
        Red = "red",
        DeepBlue = "deep-blue",
    }
}

parameters! {
    #[derive(Debug, PartialEq, Serialize)]
    struct Inner {
        /// Least.
        least: usize = 1, Within(1.0, 8.0);
        /// Most.
        most: usize = 2, Within(1.0, 8.0);
    }
    check Inner::check;
}

impl Inner {
    fn check(&self) -> Result<(), ParameterError> {
        match self.least > self.most {
            false => Ok(()),
            true => Err(ParameterError::new("most", "most: expected at least least")),
        }
    }
}

impl Setting for Inner {
    const KIND: Kind = Kind::Table(Self::PARAMETERS);
}

parameters! {
    #[derive(Debug, PartialEq)]
    struct Outer {
        /// A share of
        /// something.
        share: f32 = 0.2, Within(0.0, 1.0);
        /// Length.
        length: f64 = 3e-4, Above(0.0), "m";
        /// Count.
        count: Option<u32> = None, AtLeast(1.0);
        /// Pair.
        pair: [f32; 2] = [1.0, 2.5], AboveUpTo(0.0, 3.0);
        /// Seed.
        seed: u64 = 7;
        /// Colour.
        colour: Colour = Colour::DeepBlue;
        /// Flag.
        flag: bool = true;
        /// Inner.
        inner: Inner = Inner::default();
    }
}

fn read(text: &str) -> Result<Outer, ParameterError> {
    Outer::read(&text.parse().expect("toml"))
}

#[test]
fn what_is_declared_is_the_default_and_reads_back() {
    let declared = Outer::default();
    assert_eq!(read("").as_ref(), Ok(&declared));
    let texts = Outer::PARAMETERS
        .iter()
        .filter_map(|p| Some(format!("{} = {}\n", p.key, (p.default)()?)));
    let texts: String = texts.collect();
    assert_eq!(read(&texts).as_ref(), Ok(&declared), "{texts}");
    assert!(texts.contains("share = 0.2\nlength = 0.0003\npair = [1.0, 2.5]\n"));
    assert!(!texts.contains("count"), "an absent value has no text");
    assert_eq!(Outer::PARAMETERS[0].meaning, "A share of something.");
    assert_eq!(Outer::PARAMETERS[1].unit, "m");
}

#[test]
fn whole_numbers_are_numbers_and_given_values_replace_defaults() {
    let text = "share = 1\ncount = 5\ncolour = 'red'\ninner.most = 3";
    let expected = Outer {
        share: 1.0,
        count: Some(5),
        colour: Colour::Red,
        inner: Inner { least: 1, most: 3 },
        ..Outer::default()
    };
    assert_eq!(read(text), Ok(expected));
}

#[test]
fn errors_name_the_key_what_was_given_and_what_is_expected() {
    for (text, key, message) in [
        (
            "share = 1.5",
            "share",
            "share = 1.5: expected a number from 0 to 1",
        ),
        (
            "share = nan",
            "share",
            "share = nan: expected a number from 0 to 1",
        ),
        (
            "length = inf",
            "length",
            "length = inf: expected a number above 0 (m)",
        ),
        (
            "length = -1e-300",
            "length",
            "length = -1e-300: expected a number above 0 (m)",
        ),
        (
            "length = 'long'",
            "length",
            "length = \"long\": expected a number above 0 (m)",
        ),
        (
            "count = 0",
            "count",
            "count = 0: expected a whole number, 1 or more",
        ),
        (
            "count = 1.5",
            "count",
            "count = 1.5: expected a whole number, 1 or more",
        ),
        (
            "pair = [1.0, 4.0]",
            "pair",
            "pair = [1.0, 4.0]: expected 2 numbers above 0 and up to 3",
        ),
        (
            "pair = [1.0]",
            "pair",
            "pair = [1.0]: expected 2 numbers above 0 and up to 3",
        ),
        ("seed = -1", "seed", "seed = -1: expected a whole number"),
        (
            "colour = 'blue'",
            "colour",
            "colour = \"blue\": expected \"red\" or \"deep-blue\"",
        ),
        ("flag = 1", "flag", "flag = 1: expected true or false"),
        (
            "inner.least = 9",
            "inner",
            "inner: least = 9: expected a whole number from 1 to 8",
        ),
        (
            "inner.least = 3",
            "inner",
            "inner: most: expected at least least",
        ),
        (
            "inner.middle = 3",
            "inner",
            "inner: unknown parameter `middle`; known: least, most",
        ),
        (
            "inner = 3",
            "inner",
            "inner: invalid type: integer `3`, expected a map",
        ),
    ] {
        let error = read(text).expect_err(text);
        assert_eq!(error, ParameterError::new(key, message));
    }
    let error = read("colours = 1").expect_err("unknown");
    assert!(error.message.starts_with("unknown parameter `colours`"));
}
