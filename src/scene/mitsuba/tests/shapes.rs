//! Shapes, their transforms and instances.

use super::*;

#[test]
fn transform_steps_apply_in_order() {
    let scene = load(
        "3.0.0",
        "<shape type='cube'><transform name='to_world'><scale value='2'/><rotate z='1' angle='90'/><translate x='10'/></transform></shape>",
    );
    let moved = scene.shapes[0].to_world.transform_point3(DVec3::X);
    assert!(moved.distance(DVec3::new(10.0, 2.0, 0.0)) < 1e-12);
    let scene = load(
        "0.5.0",
        "<shape type='cube'><transform name='toWorld'><matrix value='0 -1 0 5  1 0 0 6  0 0 1 7  0 0 0 1'/></transform></shape>",
    );
    let moved = scene.shapes[0].to_world.transform_point3(DVec3::X);
    assert_eq!(moved, DVec3::new(5.0, 7.0, 7.0));
}

#[test]
fn last_rows_of_matrices_that_are_not_used_are_noted() {
    for (row, told) in [("0 0 0 1", 0), ("0 0 1 1", 1), ("0 0 0 2", 1)] {
        let scene = load(
            "3.0.0",
            &format!(
                "<shape type='cube'><transform name='to_world'><matrix value='1 0 0 5  0 1 0 6  0 0 1 7  {row}'/></transform></shape>"
            ),
        );
        let moved = scene.shapes[0].to_world.transform_point3(DVec3::ZERO);
        assert_eq!(moved, DVec3::new(5.0, 6.0, 7.0));
        assert_eq!(scene.notes.len(), told, "{row}: {:?}", scene.notes);
    }
}

#[test]
fn shapes_of_every_kind() {
    let scene = load(
        "0.5.0",
        "<shape type='obj'><string name='filename' value='m\\a.obj'/><boolean name='faceNormals' value='true'/></shape>
         <shape type='ply'><string name='filename' value='a.ply'/><boolean name='flipNormals' value='true'/></shape>
         <shape type='serialized'><string name='filename' value='a.serialized'/><integer name='shapeIndex' value='3'/></shape>
         <shape type='sphere'><point name='center' x='1' y='2' z='3'/><float name='radius' value='0.5'/></shape>
         <shape type='cylinder'><point name='p0' x='1'/><point name='p1' value='1, 0, 2'/></shape>
         <shape type='disk'/><shape type='rectangle'/>
         <shape type='hair'><string name='filename' value='x'/></shape>",
    );
    let sources: Vec<&ShapeSource> = scene.shapes.iter().map(|s| &s.source).collect();
    assert!(
        matches!(sources[0], ShapeSource::Obj { path, .. } if path == Path::new("dir/m/a.obj"))
    );
    assert!(matches!(
        sources[2],
        ShapeSource::Serialized { index: 3, .. }
    ));
    assert!(matches!(sources[3], ShapeSource::Sphere { radius, .. } if *radius == 0.5));
    assert!(
        matches!(sources[4], ShapeSource::Cylinder { to, .. } if *to == DVec3::new(1.0, 0.0, 2.0))
    );
    assert_eq!(sources.len(), 7);
    assert!(scene.shapes[0].face_normals && scene.shapes[1].flip_normals);
    assert!(!scene.shapes[0].flip_v && scene.shapes[1].flip_v && scene.shapes[6].flip_v);
    assert_eq!(scene.notes, ["shape type `hair` is left out"]);
}

#[test]
fn instances_repeat_their_group() {
    let scene = load(
        "3.0.0",
        "<shape type='shapegroup' id='g'><shape type='cube'/><shape type='disk'/></shape>
         <shape type='instance'><ref id='g'/><transform name='to_world'><translate x='1'/></transform></shape>
         <shape type='instance'><ref id='g'/></shape>",
    );
    assert_eq!(scene.shapes.len(), 4);
    assert_eq!(scene.shapes[0].to_world, DMat4::from_translation(DVec3::X));
}

#[test]
fn lamps_without_a_material_reflect_nothing() {
    // Mitsuba 3.9.1 makes them `diffuse` of 0, other shapes of 0.5.
    let scene = load(
        "3.0.0",
        "<emitter type='area' id='e'/><shape type='sphere'><ref id='e'/></shape><shape type='cube'/>
         <shape type='disk'><emitter type='area'/></shape>
         <shape type='disk'><emitter type='area'/><bsdf type='diffuse'/></shape>",
    );
    let reflectance = |i: usize| match scene.materials[scene.shapes[i].material].bsdf {
        Bsdf::Diffuse {
            reflectance: ColourSource::Constant(colour),
        } => colour,
        ref other => panic!("{other:?}"),
    };
    assert_eq!(
        [0, 1, 2, 3].map(|i| reflectance(i)[0]),
        [0.0, 0.5, 0.0, 0.5]
    );
    assert_eq!(
        scene.shapes[0].material, scene.shapes[2].material,
        "one for all"
    );
}

#[test]
fn a_shape_has_one_material_and_one_emitter_and_an_instance_none() {
    for (body, expected) in [
        (
            "<shape type='cube'><bsdf type='diffuse'/>\n<bsdf type='diffuse'/></shape>",
            "s.xml:2:1: a shape has one material",
        ),
        (
            "<shape type='cube'><emitter type='area'/>\n<emitter type='area'/></shape>",
            "s.xml:2:1: a shape has one emitter",
        ),
        (
            "<shape type='shapegroup' id='g'><shape type='cube'/></shape>\n<shape type='instance'><ref id='g'/>\n<emitter type='area'/></shape>",
            "s.xml:3:1: an instance holds a shapegroup",
        ),
    ] {
        let message = error(&format!("{SENSOR}{body}"));
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn mirrors_turn_what_they_turn_in_mitsuba() {
    // Which side emits, by Mitsuba 3.9.1: of mirrored spheres the inner one, of meshes without normals the other one.
    let scene = load(
        "3.0.0",
        "<shape type='sphere'><transform name='to_world'><scale x='-1'/></transform></shape>
         <shape type='sphere'><boolean name='flip_normals' value='true'/><transform name='to_world'><scale z='-1'/></transform></shape>
         <shape type='ply'><string name='filename' value='a.ply'/><transform name='to_world'><scale y='-1'/></transform></shape>
         <shape type='ply'><string name='filename' value='a.ply'/><transform name='to_world'><scale x='-1' y='-1'/></transform></shape>
         <shape type='rectangle'><transform name='to_world'><scale x='-1'/></transform></shape>
         <shape type='shapegroup' id='g'><shape type='ply'><string name='filename' value='a.ply'/></shape></shape>
         <shape type='instance'><ref id='g'/><transform name='to_world'><scale x='-1'/></transform></shape>",
    );
    let turned: Vec<bool> = scene
        .shapes
        .iter()
        .map(|s| s.flip_normals || s.turn_bare)
        .collect();
    assert_eq!(turned, [true, false, true, false, false, false]);
    assert!(!scene.shapes[0].turn_bare && scene.shapes[2].turn_bare);
}

#[test]
fn round_shapes_that_are_scaled_unevenly_are_told() {
    let notes = |shape: &str| load("3.0.0", shape).notes;
    let with = |kind: &str, steps: &str| {
        notes(&format!(
            "<shape type='{kind}'><transform name='to_world'>{steps}</transform></shape>"
        ))
    };
    assert!(with("sphere", "<scale x='2'/>")[0].starts_with("a sphere becomes an ellipsoid"));
    let sheared = "<matrix value='1 0.5 0 0 0 1 0 0 0 0 1 0 0 0 0 1'/>";
    assert_eq!(with("sphere", sheared).len(), 1);
    assert!(
        with(
            "sphere",
            "<scale value='3'/><rotate x='1' y='2' angle='33'/><scale x='-1'/>"
        )
        .is_empty()
    );
    assert!(with("cylinder", "<scale z='4'/><rotate y='1' angle='33'/>").is_empty());
    assert_eq!(with("cylinder", "<scale y='4'/>").len(), 1);
    assert!(with("disk", "<scale y='4'/>").is_empty());
}

#[test]
fn a_camera_without_up_is_turned_as_in_mitsuba() {
    // Mitsuba 3.9.1: left is −y, up is +x.
    let transform =
        "<transform name='to_world'><lookat origin='0,0,0' target='0,0,1'/></transform>";
    let view = camera(&format!("<float name='fov' value='40'/>{transform}"));
    assert!(view.up.distance(DVec3::X) < 1e-12 && view.right.distance(DVec3::Y) < 1e-12);
}

#[test]
fn merged_shapes_are_all_there() {
    let scene = load(
        "3.0.0",
        "<shape type='merge'><shape type='cube'/><shape type='sphere'/></shape>",
    );
    assert_eq!(scene.shapes.len(), 2);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}
