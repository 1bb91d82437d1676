//! Lists of a fixed length in configs: one that is longer is an error, where serde would read its beginning.

use serde::de::{Deserialize, Deserializer, Error};

/// A list of exactly `N` values.
pub(super) fn fixed<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    exactly(Vec::deserialize(deserializer)?)
}

/// As [`fixed`], for a key that may be left out.
pub(super) fn optional<'de, D, T, const N: usize>(
    deserializer: D,
) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let values: Option<Vec<T>> = Option::deserialize(deserializer)?;
    values.map(exactly).transpose()
}

/// As [`fixed`], for a list of such lists.
pub(super) fn each<'de, D, T, const N: usize>(deserializer: D) -> Result<Vec<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let lists: Vec<Vec<T>> = Vec::deserialize(deserializer)?;
    lists.into_iter().map(exactly).collect()
}

fn exactly<T, E: Error, const N: usize>(values: Vec<T>) -> Result<[T; N], E> {
    let refused =
        |values: Vec<T>| E::custom(format!("expected {N} values, found {}", values.len()));
    values.try_into().map_err(refused)
}

#[cfg(test)]
mod tests {
    use crate::experiment::{Config, Source};

    #[test]
    fn lists_that_are_too_long_or_too_short_are_refused_where_they_stand() {
        let parse = |config: &str, scene: &str, figure: &str| {
            let source = Source {
                file: "c.toml".into(),
                text: format!(
                    "name = 'n'\ntechnique = 't'\nmethod = []\n{config}\n[[scene]]\nname = 's'\n{scene}\n[[figure]]\n\
                     name = 'f'\nkind = 'side-by-side'\n{figure}\n"
                ),
            };
            source.parse::<Config>().map_err(|error| error.to_string())
        };
        let inset = "insets = [[0, 0, 1, 1]]";
        let sound = parse(
            "size = [24, 16]",
            "transform = { translate = [1, 2, 3] }",
            inset,
        );
        let sound = sound.expect("sound");
        assert_eq!(sound.size, Some([24, 16]));
        let json = serde_json::to_string(&sound).expect("writes");
        serde_json::from_str::<Config>(&json).expect("reads");
        for (config, scene, figure, line, found) in [
            ("size = [24, 16, 3]", "", inset, 4, 3),
            ("size = [24]", "", inset, 4, 1),
            ("", "size = [1, 2, 3, 4]", inset, 7, 4),
            ("", "transform = { translate = [1, 2, 3, 4] }", inset, 7, 4),
            ("", "", "insets = [[0, 0, 1, 1, 1]]", 11, 5),
        ] {
            let error = parse(config, scene, figure).expect_err("refused");
            assert!(error.starts_with(&format!("c.toml:{line}:")), "{error}");
            assert!(error.contains(&format!("found {found}")), "{error}");
        }
    }
}
