//! Which materials the faces of an OBJ file have.

use std::collections::HashSet;

use super::value_of;
use crate::scene::mesh_obj::names_of_several_groups;

/// The materials of some faces.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Uses<'a> {
    /// Names after `usemtl` that faces follow, each once, in order.
    pub named: Vec<&'a str>,
    /// Whether faces stand before the first `usemtl`: they have the material without a name.
    pub nameless: bool,
}

impl<'a> Uses<'a> {
    /// Those of all faces, or of the object, the group or the material (`usemtl NAME`) that `part` names; `None` where
    /// no face is of that.
    pub fn of_part(obj_text: &'a str, part: Option<&str>) -> Option<Self> {
        let Some(part) = part else {
            return Some(Self::of(obj_text, |_, _| true));
        };
        let several = names_of_several_groups(obj_text);
        let uses = Self::of(obj_text, |group, material| {
            group == part
                || several.contains(group) && group.split_whitespace().any(|name| name == part)
                || part.strip_prefix("usemtl ") == Some(material.unwrap_or(""))
        });
        (uses != Self::default()).then_some(uses)
    }

    /// Those of the faces of which it `counts`, of what group and material they are.
    fn of(obj_text: &'a str, counts: impl Fn(&str, Option<&str>) -> bool) -> Self {
        let mut uses = Self::default();
        let mut seen = HashSet::new();
        let (mut group, mut material) = (UNNAMED, None);
        // Whether the group and the material have a face already.
        let mut is_known = false;
        for line in obj_text.lines() {
            let word = line.split_whitespace().next().unwrap_or("");
            match word {
                "usemtl" => (material, is_known) = (value_of(line, word), false),
                "o" | "g" => (group, is_known) = (value_of(line, word).unwrap_or(UNNAMED), false),
                "f" if !is_known => {
                    is_known = true;
                    if !counts(group, material) {
                        continue;
                    }
                    match material {
                        Some(name) if seen.insert(name) => uses.named.push(name),
                        Some(_) => {}
                        None => uses.nameless = true,
                    }
                }
                _ => {}
            }
        }
        uses
    }
}

/// What the parser calls faces before the first `o` or `g`, or below one without a name.
const UNNAMED: &str = "unnamed_object";

/// Names after `usemtl` that faces follow, each once, in order.
pub(in crate::scene) fn used_materials(obj_text: &str) -> Vec<&str> {
    Uses::of(obj_text, |_, _| true).named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_the_materials_of_their_faces() {
        let text = "f 1 2 3\no table\nf 1 2 3\nusemtl oak\nf 1 2 3\ng legs left\nusemtl gone\nusemtl iron\nf 1 2 3\no lamp\nf 1 2 3\n";
        for (part, named, nameless) in [
            (None, vec!["oak", "iron"], true),
            (Some("table"), vec!["oak"], true),
            (Some("legs"), vec!["iron"], false),
            (Some("legs left"), vec!["iron"], false),
            (Some("lamp"), vec!["iron"], false),
            (Some("unnamed_object"), vec![], true),
            (Some("usemtl iron"), vec!["iron"], false),
            (Some("usemtl "), vec![], true),
        ] {
            let expected = Uses { named, nameless };
            assert_eq!(Uses::of_part(text, part), Some(expected), "{part:?}");
        }
        for part in ["attic", "usemtl gone"] {
            assert_eq!(Uses::of_part(text, Some(part)), None);
        }
    }
}
