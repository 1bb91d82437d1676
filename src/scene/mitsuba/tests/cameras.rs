//! Cameras, films and integrators.

use super::*;

#[test]
fn cameras_have_x_to_the_left() {
    // The Cornell box of the reference pictures: image right is world +x.
    let matrix = "<float name='fov' value='39.3077'/><transform name='to_world'><matrix value='-1 0 0 0 0 1 0 0 0 0 -1 3.9 0 0 0 1'/></transform>";
    let view = camera(matrix);
    assert_eq!(
        (view.right, view.up, view.forward),
        (DVec3::X, DVec3::Y, DVec3::NEG_Z)
    );
    assert_eq!(view.origin, DVec3::new(0.0, 0.0, 3.9));
    // Direction of pixel coordinates (u, v) is (-(1-2u) t, (1-2v) t, -1), normalized.
    let t = (39.3077_f64.to_radians() * 0.5).tan();
    let (u, v) = (0.125, 0.75);
    let expected = DVec3::new(-(1.0 - 2.0 * u) * t, (1.0 - 2.0 * v) * t, -1.0).normalize();
    let direction = view.direction(u * 256.0, v * 256.0, [256, 256]).as_dvec3();
    assert!(direction.distance(expected) < 1e-6);
}

#[test]
fn look_at_agrees_with_the_house_camera_and_mirrors_mirror() {
    let look = "<lookat origin='1, 2 3' target='0 0.5 0' up='0 1 0'/>";
    let fov = "<float name='fov' value='30'/>";
    let view = camera(&format!(
        "{fov}<transform name='to_world'>{look}</transform>"
    ));
    let points = [
        DVec3::new(1.0, 2.0, 3.0),
        DVec3::new(0.0, 0.5, 0.0),
        DVec3::Y,
    ];
    let house = View::look_at("main", points, 30.0, [768, 576]);
    assert!(view.right.distance(house.right) < 1e-12);
    assert!(view.up.distance(house.up) < 1e-12);
    assert!(view.forward.distance(house.forward) < 1e-12);
    let mirrored = camera(&format!(
        "{fov}<transform name='toWorld'><scale x='-1'/>{look}</transform>"
    ));
    assert!(
        mirrored.right.distance(-house.right) < 1e-12,
        "a left-handed image"
    );
    assert!(mirrored.up.distance(house.up) < 1e-12);
    let scaled = camera(&format!(
        "{fov}<transform name='to_world'><scale value='7'/>{look}</transform>"
    ));
    assert!(
        scaled.right.distance(house.right) < 1e-12,
        "scale does not matter"
    );
}

#[test]
fn fields_of_view() {
    let axis = |xml: &str| {
        let view = camera(xml);
        (view.fov_deg, view.fov_axis)
    };
    assert_eq!(axis("<float name='fov' value='30'/>"), (30.0, FovAxis::X));
    for (word, expected) in [
        ("y", FovAxis::Y),
        ("smaller", FovAxis::Smaller),
        ("larger", FovAxis::Larger),
        ("diagonal", FovAxis::Diagonal),
    ] {
        for name in ["fovAxis", "fov_axis"] {
            let xml =
                format!("<float name='fov' value='30'/><string name='{name}' value='{word}'/>");
            assert_eq!(axis(&xml).1, expected);
        }
    }
    let (fov, diagonal) = axis("<string name='focal_length' value='50mm'/>");
    assert!((fov - 46.79).abs() < 0.01 && diagonal == FovAxis::Diagonal);
    let message = error("<sensor type='perspective'><float name='fov' value='200'/></sensor>");
    assert!(message.contains("not between 0 and 180"), "{message}");
}

#[test]
fn films_give_the_size_and_integrators_the_depth() {
    let film = "<float name='fov' value='30'/><film type='hdrfilm'><integer name='width' value='64'/><integer name='height' value='32'/></film>";
    assert_eq!((camera(film).width, camera(film).height), (64, 32));
    let depth = |xml: &str| load("3.0.0", xml).max_depth;
    assert_eq!(
        depth("<integrator type='path'><integer name='maxDepth' value='7'/></integrator>"),
        7
    );
    assert_eq!(
        depth("<integrator type='path'><integer name='max_depth' value='-1'/></integrator>"),
        65
    );
    assert_eq!(depth("<integrator type='direct'/>"), 2);
    assert_eq!(
        depth(
            "<integrator type='aov'><integrator type='path'><integer name='max_depth' value='4'/></integrator></integrator>"
        ),
        4
    );
    let scene = load(
        "0.6.0",
        "<default name='d' value='5'/><integrator type='path'><integer name='maxDepth' value='$d'/></integrator>",
    );
    assert_eq!(scene.max_depth, 5);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn integrators_and_filters_that_differ_are_noted() {
    let notes = |xml: &str| load("3.0.0", xml).notes;
    assert!(notes("<integrator type='volpath'><integer name='max_depth' value='3'/><integer name='rr_depth' value='5'/></integrator>").is_empty());
    assert_eq!(
        notes(
            "<integrator type='bdpt'><integer name='max_depth' value='3'/><boolean name='hide_emitters' value='true'/></integrator>"
        ),
        [
            "hide_emitters: path tracing keeps lights out of sight, other techniques show them",
            "integrator `bdpt` becomes the path tracer"
        ]
    );
    let film = |inner: &str| {
        let sensor = format!(
            "<sensor type='perspective'><float name='fov' value='30'/><film type='hdrfilm'>{inner}</film></sensor>"
        );
        try_load("3.0.0", &sensor)
            .unwrap_or_else(|e| panic!("{e}"))
            .notes
    };
    assert!(film("<rfilter type='box'/>").is_empty());
    assert_eq!(film("<rfilter type='tent'/>").len(), 1);
    assert_eq!(film("").len(), 1);
}

#[test]
fn parts_of_films_are_parts_of_pictures() {
    let film = |film: &str| camera(&format!("<float name='fov' value='40'/>{film}"));
    let crop = "<integer name='width' value='40'/><integer name='height' value='30'/><integer name='crop_offset_x' value='20'/><integer name='crop_width' value='20'/><integer name='cropHeight' value='10'/>";
    let whole = film(
        "<film type='hdrfilm'><integer name='width' value='40'/><integer name='height' value='30'/></film>",
    );
    let part = film(&format!("<film type='hdrfilm'>{crop}</film>"));
    let expected = whole.direction(25.0, 8.0, [40, 30]);
    assert_eq!([part.width, part.height], [20, 10]);
    assert!(part.direction(5.0, 8.0, [20, 10]).distance(expected) < 1e-6);
    let moved = film(
        "<float name='principal_point_offset_x' value='0.25'/><float name='principal_point_offset_y' value='-0.5'/>",
    );
    let [wide, high] = [moved.width as f64, moved.height as f64];
    let expected = camera("<float name='fov' value='40'/>").direction(
        0.75 * wide,
        0.0,
        [moved.width, moved.height],
    );
    let middle = moved.direction(0.5 * wide, 0.5 * high, [moved.width, moved.height]);
    assert!(middle.distance(expected) < 1e-6);
    let message = error(
        "<sensor type='perspective'><float name='fov' value='40'/><film type='hdrfilm'><integer name='crop_offset_x' value='1'/></film></sensor>",
    );
    assert!(
        message.contains("the crop window is not on the film of 768x576"),
        "{message}"
    );
}

#[test]
fn what_clipping_planes_would_cut_is_told() {
    let notes = |near: f64| {
        let sensor = format!(
            "<sensor type='perspective'><float name='near_clip' value='{near}'/>\
             <film type='hdrfilm'><rfilter type='box'/></film></sensor>"
        );
        let cube =
            "<shape type='cube'><transform name='to_world'><translate z='5'/></transform></shape>";
        let integrator =
            "<integrator type='path'><integer name='max_depth' value='4'/></integrator>";
        let scene = try_load("3.0.0", &format!("{sensor}{cube}{integrator}")).unwrap();
        let built = crate::scene::Scene::build(&scene, crate::scene::Needs::GEOMETRY).unwrap();
        let notes = built.report.notes.into_iter();
        notes
            .filter(|note| note.contains("from depth"))
            .collect::<Vec<_>>()
    };
    assert!(notes(3.9).is_empty());
    let told = notes(4.5);
    assert!(
        told[0].contains("view `main` sees from depth 4.5 to 10000"),
        "{told:?}"
    );
}

#[test]
fn integrators_inside_others_count() {
    let aov = |inner: &str| {
        load(
            "3.0.0",
            &format!(
                "<integrator type='aov'><string name='aovs' value='d:depth'/>{inner}</integrator>"
            ),
        )
    };
    let hidden = aov(
        "<integrator type='path'><boolean name='hide_emitters' value='true'/><integer name='max_depth' value='4'/></integrator>",
    );
    assert!(hidden.hides_lights && hidden.max_depth == 4);
    assert_eq!(aov("<integrator type='direct'/>").max_depth, 2);
}

#[test]
fn wrong_integrators_have_places() {
    for (xml, expected) in [
        (
            "<integrator type='path'/>\n<integrator type='direct'/>",
            "dir/s.xml:3:1: a scene has one integrator",
        ),
        (
            "<integrator type='path'><integer name='max_depth' value='-2'/></integrator>",
            "dir/s.xml:2:25: `max_depth` is −1 or a whole number from 0, not -2",
        ),
        (
            "<integrator type='path'><float name='max_depth' value='2.5'/></integrator>",
            "not 2.5",
        ),
    ] {
        let message = error(&format!("{SENSOR}\n{xml}"));
        assert!(message.contains(expected), "{message}");
    }
}
