//! The small language of claims and gates: comparisons of metrics of methods.
//!
//! ```text
//! comparison = sum ("<" | "<=" | ">" | ">=") sum
//! sum        = product (("+" | "-") product)*
//! product    = factor (("*" | "/") factor)*
//! factor     = number | "(" sum ")" | ("min" | "max") "(" sum ("," sum)* ")" | column "(" LABEL ")"
//! ```
//! `rmse(VGC+DGS) < 0.95 * min(rmse(SD), rmse(IM))`: labels are those of the config (`LABEL@SCENE`
//! for another scene than the one at hand, `LABEL@SCENE (VIEW)` where several of its views occur, `LABEL@*`
//! for the mean over all scenes; `LABEL; KEY=VALUE, …` or `LABEL@SCENE; KEY=VALUE, …` at another swept value), columns
//! those of `rows.csv`.

use super::named::Named;

/// Longest text of a comparison, bytes.
const MAX_LENGTH: usize = 4096;

/// How deep parentheses may nest.
const MAX_DEPTH: usize = 64;

/// A parsed comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// Normalised so that the statement is `smaller < larger`, or `smaller <= larger`.
    smaller: Term,
    larger: Term,
    or_equal: bool,
    larger_first: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Term {
    Number(f64),
    Column { column: String, label: String },
    Operation(char, Box<Term>, Box<Term>),
    Extreme { largest: bool, terms: Vec<Term> },
}

/// Both sides of a comparison for one set of rows: it holds if `smaller < larger`, and with `<=` also if they are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Value of the side that is stated to be smaller.
    pub smaller: f64,
    /// Value of the other side.
    pub larger: f64,
}

impl Expression {
    /// Reads a comparison.
    ///
    /// # Errors
    /// A sentence that says what is expected, and where.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text.len() > MAX_LENGTH {
            let length = text.len();
            return Err(format!(
                "a comparison has {MAX_LENGTH} characters at most, this one {length}"
            ));
        }
        let mut parser = Parser {
            text,
            at: 0,
            depth: 0,
        };
        let left = parser.sum()?;
        parser.skip_space();
        let operator = parser
            .rest()
            .chars()
            .next()
            .filter(|c| matches!(c, '<' | '>'))
            .ok_or_else(|| parser.expected("one of < <= > >="))?;
        parser.at += 1;
        let or_equal = parser.rest().starts_with('=');
        parser.at += usize::from(or_equal);
        let right = parser.sum()?;
        parser.skip_space();
        if !parser.rest().is_empty() {
            return Err(parser.expected("the end"));
        }
        let larger_first = operator == '>';
        let (smaller, larger) = if larger_first {
            (right, left)
        } else {
            (left, right)
        };
        let parsed = Self {
            smaller,
            larger,
            or_equal,
            larger_first,
        };
        match parsed.names().is_empty() {
            true => Err(format!(
                "`{text}` compares numbers alone: name a column of a method, such as rmse(VGC)"
            )),
            false => Ok(parsed),
        }
    }

    /// Whether it holds where both sides are the same: `<=` and `>=`.
    pub fn or_equal(&self) -> bool {
        self.or_equal
    }

    /// Whether the side that is stated to be larger is written first: `>` and `>=`.
    pub fn larger_first(&self) -> bool {
        self.larger_first
    }

    /// Evaluates both sides; `value(column, label)` is `None` where there is no such row.
    pub fn measure(&self, value: &dyn Fn(&str, &str) -> Option<f64>) -> Option<Measured> {
        Some(Measured {
            smaller: self.smaller.evaluate(value)?,
            larger: self.larger.evaluate(value)?,
        })
    }

    /// Every column and label it names.
    pub fn names(&self) -> Vec<(&str, &str)> {
        let mut names = Vec::new();
        self.smaller.collect(&mut names);
        self.larger.collect(&mut names);
        names
    }
}

impl Term {
    fn evaluate(&self, value: &dyn Fn(&str, &str) -> Option<f64>) -> Option<f64> {
        match self {
            Term::Number(n) => Some(*n),
            Term::Column { column, label } => value(column, label),
            Term::Operation(operator, a, b) => {
                let (a, b) = (a.evaluate(value)?, b.evaluate(value)?);
                Some(match operator {
                    '+' => a + b,
                    '-' => a - b,
                    '*' => a * b,
                    _ => a / b,
                })
            }
            Term::Extreme { largest, terms } => terms
                .iter()
                .map(|t| t.evaluate(value))
                .collect::<Option<Vec<f64>>>()?
                .into_iter()
                .reduce(|a, b| match (a.is_nan() || b.is_nan(), largest) {
                    (true, _) => f64::NAN,
                    (false, true) => a.max(b),
                    (false, false) => a.min(b),
                }),
        }
    }

    fn collect<'a>(&'a self, names: &mut Vec<(&'a str, &'a str)>) {
        match self {
            Term::Number(_) => {}
            Term::Column { column, label } => names.push((column, label)),
            Term::Operation(_, a, b) => {
                a.collect(names);
                b.collect(names);
            }
            Term::Extreme { terms, .. } => terms.iter().for_each(|t| t.collect(names)),
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    /// Parentheses that are open.
    depth: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip_space(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    fn expected(&self, what: &str) -> String {
        format!("`{}`, column {}: expected {what}", self.text, self.at + 1)
    }

    fn accept(&mut self, symbols: &[char]) -> Option<char> {
        self.skip_space();
        let found = self.rest().chars().next().filter(|c| symbols.contains(c))?;
        self.at += found.len_utf8();
        Some(found)
    }

    fn sum(&mut self) -> Result<Term, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("parentheses nest more than {MAX_DEPTH} deep"));
        }
        let mut term = self.product()?;
        while let Some(operator) = self.accept(&['+', '-']) {
            term = Term::Operation(operator, Box::new(term), Box::new(self.product()?));
        }
        self.depth -= 1;
        Ok(term)
    }

    fn product(&mut self) -> Result<Term, String> {
        let mut term = self.factor()?;
        while let Some(operator) = self.accept(&['*', '/']) {
            term = Term::Operation(operator, Box::new(term), Box::new(self.factor()?));
        }
        Ok(term)
    }

    fn factor(&mut self) -> Result<Term, String> {
        if self.accept(&['(']).is_some() {
            let term = self.sum()?;
            return match self.accept(&[')']) {
                Some(_) => Ok(term),
                None => Err(self.expected("`)`")),
            };
        }
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        let word: &str = self.rest().split(|c| !is_word(c)).next().unwrap_or("");
        if word.is_empty() {
            return Err(self.expected("a number, a column such as rmse(VGC), or `(`"));
        }
        self.at += word.len();
        if let Ok(number) = word.parse() {
            return Ok(Term::Number(number));
        }
        if self.accept(&['(']).is_none() {
            return Err(self.expected("`(` and the label of a method"));
        }
        if word == "min" || word == "max" {
            return self.extreme(word == "max");
        }
        let close = closing(self.rest()).ok_or_else(|| self.expected("`)`"))?;
        let label = self.rest()[..close].trim().to_owned();
        Named::parse(&label)?;
        self.at += close + 1;
        Ok(Term::Column {
            column: word.to_owned(),
            label,
        })
    }

    fn extreme(&mut self, largest: bool) -> Result<Term, String> {
        let mut terms = vec![self.sum()?];
        while self.accept(&[',']).is_some() {
            terms.push(self.sum()?);
        }
        match self.accept(&[')']) {
            Some(_) => Ok(Term::Extreme { largest, terms }),
            None => Err(self.expected("`,` or `)`")),
        }
    }
}

/// Where the parenthesis that is open at the start of a text closes: names may hold pairs of their own,
/// as in `SD@kitchen (top)`.
fn closing(text: &str) -> Option<usize> {
    let mut open = 1;
    text.char_indices().find_map(|(at, c)| {
        match c {
            '(' => open += 1,
            ')' => open -= 1,
            _ => {}
        }
        (open == 0).then_some(at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evaluates_arithmetic_and_labels_with_plus() {
        let expression =
            Expression::parse("rmse(VGC+DGS) < 0.5 * min(rmse(SD), 3 - rmse(IM))").expect("parses");
        let value = |column: &str, label: &str| match (column, label) {
            ("rmse", "VGC+DGS") => Some(1.0),
            ("rmse", "SD") => Some(4.0),
            ("rmse", "IM") => Some(0.5),
            _ => None,
        };
        let measured = expression.measure(&value).expect("all there");
        assert_eq!(
            measured,
            Measured {
                smaller: 1.0,
                larger: 1.25
            }
        );
        assert_eq!(expression.names().len(), 3);
        let of_view = Expression::parse("rmse(A@kitchen (top)) < (rmse(B))").expect("parses");
        assert_eq!(
            of_view.names(),
            [("rmse", "A@kitchen (top)"), ("rmse", "B")]
        );
        let flipped = Expression::parse("psnr(A) >= 30").expect("parses");
        let measured = flipped.measure(&|_, _| Some(40.0)).expect("there");
        assert_eq!(
            measured,
            Measured {
                smaller: 30.0,
                larger: 40.0
            }
        );
    }

    #[test]
    fn equal_sides_count_where_it_says_so() {
        for (text, or_equal) in [
            ("rmse(A) < 1", false),
            ("rmse(A) <= 1", true),
            ("psnr(A) > 1", false),
            ("psnr(A) >= 1", true),
        ] {
            let expression = Expression::parse(text).expect("parses");
            assert_eq!(expression.or_equal(), or_equal, "{text}");
        }
    }

    #[test]
    fn comparisons_of_numbers_alone_say_nothing() {
        for text in ["1 < 2", "min(1, 2) <= 3 * 4"] {
            let message = Expression::parse(text).expect_err(text);
            assert!(message.contains("numbers alone"), "{message}");
        }
    }

    #[test]
    fn nesting_is_bounded() {
        let nested = |depth| format!("{}rmse(A){} < 1", "(".repeat(depth), ")".repeat(depth));
        Expression::parse(&nested(50)).expect("parses");
        for (depth, expected) in [(1000, "64 deep"), (200_000, "4096 characters at most")] {
            let message = Expression::parse(&nested(depth)).expect_err("too deep");
            assert!(
                message.contains(expected) && message.len() < 200,
                "{message}"
            );
        }
    }

    /// The smaller of a number and none is none: a gate must not look past it.
    #[test]
    fn extremes_do_not_leave_out_what_is_no_number() {
        let value = |column: &str, _: &str| Some(if column == "rmse" { f64::NAN } else { 0.5 });
        for text in ["max(rmse(A), mae(A)) < 1", "min(mae(A), rmse(A)) < 1"] {
            let measured = Expression::parse(text).expect("parses").measure(&value);
            assert!(measured.expect("both sides").smaller.is_nan(), "{text}");
        }
    }

    #[test]
    fn says_where_it_is_wrong() {
        for text in [
            "",
            "rmse(A)",
            "rmse(A) <",
            "rmse < 1",
            "rmse(A) < 1 1",
            "rmse(A) =< 1",
            "rmse(A) == 1",
            "rmse(A) < = 1",
            "min(rmse(A) < 1",
            "rmse(A; caches) < 1",
        ] {
            let message = Expression::parse(text).expect_err(text);
            assert!(message.contains("expected"), "{message}");
        }
    }
}
