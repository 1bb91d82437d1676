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
