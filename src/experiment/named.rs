//! What a claim or gate names in parentheses: `LABEL`, `LABEL@SCENE`, and behind a semicolon swept values of its own.

use super::Swept;

/// A contender that an expression speaks of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named<'a> {
    /// Label of the method.
    pub label: &'a str,
    /// What stands behind `@`: another scene than the one at hand, or `*` for the mean over all.
    pub scene: Option<&'a str>,
    /// Swept keys and values, as text, that take the place of those at hand.
    pub at: Vec<(&'a str, &'a str)>,
}

impl<'a> Named<'a> {
    /// Reads `LABEL@SCENE; KEY=VALUE, …`.
    ///
    /// # Errors
    /// What stands behind the semicolon is no list of keys and values.
    pub fn parse(text: &'a str) -> Result<Self, String> {
        let (name, values) = match text.split_once(';') {
            None => (text, None),
            Some((name, values)) => (name.trim_end(), Some(values)),
        };
        let value = |part: &'a str| {
            let both = part.split_once('=').map(|(key, v)| (key.trim(), v.trim()));
            both.filter(|(key, value)| !key.is_empty() && !value.is_empty())
                .ok_or_else(|| {
                    format!(
                        "`{text}`: expected a swept key and its value behind `;`, such as \
                         `A@kitchen; caches=100`, not `{}`",
                        part.trim()
                    )
                })
        };
        let (label, scene) = match name.split_once('@') {
            None => (name, None),
            Some((label, scene)) => (label, Some(scene)),
        };
        Ok(Self {
            label,
            scene,
            at: values
                .into_iter()
                .flat_map(|values| values.split(','))
                .map(value)
                .collect::<Result<_, _>>()?,
        })
    }

    /// Whether it is the same at all values of a swept key.
    pub fn fixes(&self, key: &str) -> bool {
        self.at.iter().any(|(fixed, _)| *fixed == key)
    }

    /// Which of some points of a sweep it speaks of where `at` is at hand; `None` where there is none.
    pub fn point<'p>(&self, points: &'p [Swept], at: &Swept) -> Option<&'p Swept> {
        let wanted = |key: &str, value: &str| match self.at.iter().find(|(k, _)| *k == key) {
            Some((_, fixed)) => *fixed == value,
            None => at.text_of(key).is_some_and(|own| own == value),
        };
        let keys_known =
            |point: &Swept| self.at.iter().all(|(key, _)| point.text_of(key).is_some());
        points.iter().find(|point| {
            keys_known(point)
                && point.values.iter().all(|(key, _)| {
                    let value = point.text_of(key).unwrap_or_default();
                    wanted(key, &value)
                })
        })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn point(caches: u32, ratio: f64) -> Swept {
        let values = [("caches", json!(caches)), ("ratio", json!(ratio))];
        Swept::of(
            values
                .map(|(key, value)| (key.to_owned(), value))
                .into_iter(),
        )
    }

    #[test]
    fn names_have_a_label_a_scene_and_values() {
        let plain = Named::parse("VGC+DGS").expect("plain");
        assert_eq!(
            (plain.label, plain.scene, plain.at.len()),
            ("VGC+DGS", None, 0)
        );
        let whole = Named::parse("A@kitchen (top) ; caches = 100,ratio=0.5").expect("whole");
        assert_eq!((whole.label, whole.scene), ("A", Some("kitchen (top)")));
        assert_eq!(whole.at, [("caches", "100"), ("ratio", "0.5")]);
        assert!(whole.fixes("ratio") && !whole.fixes("seed"));
        for text in ["A;", "A; caches", "A; caches=", "A; =1", "A; caches=1,"] {
            let message = Named::parse(text).expect_err(text);
            assert!(message.contains("expected a swept key"), "{message}");
        }
    }

    #[test]
    fn values_take_the_place_of_those_at_hand() {
        let points = [point(100, 0.5), point(100, 1.0), point(200, 0.5)];
        let found = |name: &str, at: &Swept| {
            let named = Named::parse(name).expect("reads");
            named.point(&points, at).cloned()
        };
        assert_eq!(found("A", &points[1]), Some(point(100, 1.0)));
        assert_eq!(found("A; caches=200", &points[0]), Some(point(200, 0.5)));
        assert_eq!(found("A; caches=200", &points[1]), None, "not in the sweep");
        assert_eq!(
            found("A; caches=100, ratio=1.0", &points[2]),
            Some(point(100, 1.0))
        );
        assert_eq!(found("A; spp=1", &points[0]), None, "not swept");
    }
}
