//! What is ignored, and what is wrong.

use super::*;

#[test]
fn what_is_ignored_is_noted_with_counts() {
    let scene = load(
        "3.0.0",
        "<shape type='cube'><bsdf type='roughdiffuse'><boolean name='use_fast_approx' value='true'/></bsdf></shape><shape type='cube'><bsdf type='roughdiffuse'><boolean name='use_fast_approx' value='true'/></bsdf></shape><bsdf type='diffuse' id='unused'/><medium type='homogeneous'/>",
    );
    assert_eq!(
        scene.notes,
        [
            "`roughdiffuse` becomes diffuse (2 times)",
            "bsdf `diffuse` that nothing refers to is left out",
            "parameter `use_fast_approx` of bsdf `roughdiffuse` is ignored (2 times)"
        ]
    );
}

#[test]
fn errors_have_places_and_advice() {
    for (body, expected) in [
        (
            format!(
                "{SENSOR}\n<bsdf type='diffuse' id='Wall'/>\n<shape type='cube'>\n<ref id='Wal'/></shape>"
            ),
            "dir/s.xml:4:1: nothing has the id `Wal`; did you mean `Wall`?",
        ),
        (
            format!("{SENSOR}\n<shape type='obj'/>"),
            "dir/s.xml:2:1: obj needs a `filename`",
        ),
        (
            format!("{SENSOR}\n<shape type='cube'><bsdf type='twosided'/></shape>"),
            "dir/s.xml:2:20: `twosided` needs a material inside",
        ),
        (
            format!(
                "{SENSOR}\n<shape type='cube'><transform name='to_world'><matrix value='1 2 3'/></transform></shape>"
            ),
            "dir/s.xml:2:47: a matrix has 16 (or 9) numbers, this one 3",
        ),
        (
            format!(
                "{SENSOR}\n<shape type='cube'><bsdf type='twosided' id='a'><ref id='a'/></bsdf></shape>"
            ),
            "dir/s.xml:2:20: materials refer to each other in a circle",
        ),
        (
            format!(
                "{SENSOR}\n<shape type='cube'><bsdf type='dielectric'><string name='int_ior' value='watre'/></bsdf></shape>"
            ),
            "no dielectric is called `watre`; did you mean `water`?",
        ),
        (
            "<shape type='cube'/>".to_owned(),
            "dir/s.xml:1:1: the scene has no perspective sensor",
        ),
    ] {
        let message = error(&body);
        assert!(message.contains(expected), "{message}\n{expected}");
    }
}
