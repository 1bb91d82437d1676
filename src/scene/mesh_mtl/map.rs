//! Pictures that materials of a library name, with their options.

use std::path::{Path, PathBuf};

use super::{named_file, split_word};

/// A picture that a material names.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct MtlMap {
    /// In the library's folder.
    pub file: PathBuf,
    /// `uv * scale + offset` is looked up.
    pub scale: [f32; 2],
    pub offset: [f32; 2],
    /// Whether it ends at its borders instead of repeating.
    pub clamp: bool,
    /// Factor on its values: the second number of `-mm`.
    pub gain: f32,
    /// Added to its values after that: the first number of `-mm`.
    pub base: f32,
    /// Options that would change the look and are left out.
    pub left_out: Vec<String>,
}

impl Default for MtlMap {
    fn default() -> Self {
        Self {
            file: PathBuf::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            clamp: false,
            gain: 1.0,
            base: 0.0,
            left_out: Vec::new(),
        }
    }
}

impl MtlMap {
    /// Options such as `-s 2 2 1` and a file, whose name may have blanks.
    pub(super) fn read(text: &str, folder: &Path) -> Result<Self, String> {
        let mut map = Self::default();
        let mut rest = text.trim();
        while let Some((option, after)) = option(rest) {
            let most = match option {
                "-o" | "-s" | "-t" => 3,
                "-mm" => 2,
                "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-clamp" | "-imfchan"
                | "-texres" | "-type" => 1,
                _ => return Err(format!("option `{option}` is unknown")),
            };
            rest = after;
            let mut numbers = Vec::new();
            let mut words = String::new();
            for count in 0..most {
                let (word, after) = split_word(rest);
                // Of three numbers the last ones may be left away.
                let number = word.parse::<f32>();
                if most > 1 && count > 0 && number.is_err() {
                    break;
                }
                words = format!("{words} {word}");
                numbers.extend(number.ok().filter(|n| n.is_finite()));
                rest = after;
                map.word(option, word);
            }
            if most > 1 && numbers.len() < words.split_whitespace().count() {
                map.left_out.push(format!(
                    "`{option}{words}` of a map is left out: expected finite numbers"
                ));
                continue;
            }
            let pair = |default: f32| [0, 1].map(|i| numbers.get(i).copied().unwrap_or(default));
            match option {
                "-s" => map.scale = pair(1.0),
                "-o" => map.offset = pair(0.0),
                "-mm" => {
                    map.gain = numbers.get(1).copied().unwrap_or(1.0);
                    map.base = numbers.first().copied().unwrap_or(0.0);
                }
                "-t" if numbers.iter().any(|&n| n != 0.0) => {
                    map.left_out
                        .push("the turbulence of `-t` is left out".into());
                }
                _ => {}
            }
        }
        match rest {
            "" => Err("a file was expected".into()),
            _ => {
                map.file = named_file(folder, rest);
                Ok(map)
            }
        }
    }
}

impl MtlMap {
    /// Whether `-mm` makes other values of those of the picture.
    pub fn changes_values(&self) -> bool {
        (self.base, self.gain) != (0.0, 1.0)
    }

    /// An option that is a word.
    fn word(&mut self, option: &str, word: &str) {
        match (option, word) {
            ("-clamp", _) => self.clamp = word == "on",
            ("-cc", "on") | ("-imfchan", "r" | "g" | "b" | "z" | "l") => {
                self.left_out
                    .push(format!("`{option} {word}` of a map is left out"));
            }
            _ => {}
        }
    }
}

/// The option that a text begins with, and what follows it.
fn option(text: &str) -> Option<(&str, &str)> {
    let (word, rest) = split_word(text);
    let letter = word.strip_prefix('-')?.chars().next()?;
    (letter.is_ascii_alphabetic() && !rest.is_empty()).then_some((word, rest))
}
