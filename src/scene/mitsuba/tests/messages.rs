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
fn what_a_shape_refers_to_and_does_not_read_is_noted() {
    let scene = load(
        "3.0.0",
        "<medium type='homogeneous' id='fog'/><bsdf type='diffuse' id='white'/><shape type='cube'><ref id='white'/><ref name='interior' id='fog'/></shape>",
    );
    assert_eq!(
        scene.notes,
        ["parameter `interior` of shape `cube` is ignored"]
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

#[test]
fn ids_are_given_once() {
    let message = error(&format!(
        "{SENSOR}\n<bsdf type='diffuse' id='wall'/>\n<shape type='cube'>\n  <bsdf type='plastic' id='wall'/></shape>"
    ));
    assert!(
        message.starts_with("dir/s.xml:4:3: the id `wall` is taken already, at 2:1"),
        "{message}"
    );
    let message = error(&format!(
        "{SENSOR}<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='b'/>\n<alias id='a' as='b'/>"
    ));
    assert!(
        message.contains(":2:1: the id `b` is taken already"),
        "{message}"
    );
    let scene = load(
        "3.0.0",
        "<bsdf type='diffuse' id='a'/><alias id='a' as='c'/><shape type='cube'><ref id='c'/></shape>",
    );
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn the_longest_parameter_that_fits_is_put_in() {
    // As Mitsuba 3.9.1: radius 2, then 3.5.
    for (names, value, expected) in [
        (
            "<default name='a-b' value='2'/><default name='a' value='3'/>",
            "$a-b",
            2.0,
        ),
        ("<default name='a' value='3'/>", "$a.5", 3.5),
        (
            "<default name='a' value='3'/><default name='ab' value='7'/>",
            "$ab$a",
            73.0,
        ),
    ] {
        let sphere = format!("<shape type='sphere'><float name='radius' value='{value}'/></shape>");
        let scene = load("3.0.0", &format!("{names}{sphere}"));
        assert!(
            matches!(scene.shapes[0].source, ShapeSource::Sphere { radius, .. } if radius == expected)
        );
    }
    assert!(error("<default name='' value='3'/>").contains("a <default> needs a name"));
}

#[test]
fn whole_numbers_and_sensors_are_what_they_must_be() {
    let film = |width: &str| {
        format!(
            "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='{width}'/></film></sensor>"
        )
    };
    let mesh = |index: &str| {
        format!(
            "<shape type='serialized'><string name='filename' value='a.serialized'/><integer name='shape_index' value='{index}'/></shape>"
        )
    };
    for (text, expected) in [
        (
            film("32.5"),
            "`width` must be a whole number from 0, not 32.5",
        ),
        (film("-5"), "`width` must be a whole number"),
        (film("0"), "a film width of 0 pixels"),
        (mesh("-1"), "`shape_index` must be a whole number"),
        (mesh("0.5"), "`shape_index` must be a whole number"),
    ] {
        let told = error(&text);
        assert!(told.contains(expected), "{told}");
    }
    for (sensor, expected) in [
        ("", "it has no <sensor>"),
        (
            "<sensor type='orthographic'/>",
            "its sensor `orthographic` is not built",
        ),
    ] {
        let text = format!("<scene version='3.0.0'>{sensor}</scene>");
        let document = parse_document(Path::new("s.xml"), &text).expect("XML");
        let told = import(&document, Path::new("s.xml"), "s")
            .unwrap_err()
            .to_string();
        assert!(told.contains(expected), "{told}");
    }
}

#[test]
fn skies_that_no_model_has_are_told_with_their_place() {
    let sky = "<emitter type='sky'><float name='turbidity' value='40'/></emitter>";
    let told = error(&format!("{SENSOR}\n{sky}"));
    assert_eq!(
        told,
        "dir/s.xml:2:21: `turbidity` is a number from 1 to 10, not 40"
    );
}

#[test]
fn messages_of_the_parser_are_whole_sentences() {
    for (text, expected) in [
        (
            "<scene><shape type='cube' type='disk'/></scene>",
            "s.xml:1:27: attribute 'type' is already defined",
        ),
        (
            "<scene>\n<!-- a -- b --></scene>",
            "s.xml:2:1: comment contains '--'",
        ),
    ] {
        let told = parse_document(Path::new("s.xml"), text).map(|_| ());
        let told = told.unwrap_err().to_string();
        assert_eq!(told, expected);
    }
}

#[test]
fn what_is_around_glass_is_told() {
    let (_, notes) = material(
        "3.0.0",
        "<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>",
    );
    assert_eq!(
        notes,
        ["`twosided` around glass is dropped, which Mitsuba refuses"]
    );
}
