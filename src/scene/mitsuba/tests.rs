use glam::{DMat4, DVec3};

use super::element::parse_document;
use super::*;
use crate::environment::{EnvironmentDescription, EnvironmentRows};
use crate::scene::{
    Bsdf, ColourSource, FovAxis, LightKind, MicrofacetDistribution, ShapeSource, TextureSource,
    View, Wrap,
};

const SENSOR: &str = "<sensor type='perspective'><float name='fov' value='40'/></sensor>";

fn try_load(version: &str, body: &str) -> Result<SceneDescription, String> {
    let text = format!("<scene version='{version}'>{body}\n</scene>");
    let file = Path::new("dir/s.xml");
    parse_document(file, &text)
        .and_then(|document| import(&document, file, "s"))
        .map_err(|e| e.to_string())
}

fn load(version: &str, body: &str) -> SceneDescription {
    try_load(version, &format!("{SENSOR}{body}")).unwrap_or_else(|e| panic!("{e}"))
}

fn error(body: &str) -> String {
    match try_load("3.0.0", body) {
        Ok(_) => panic!("should fail: {body}"),
        Err(message) => message,
    }
}

/// The material of a shape with this bsdf inside.
fn material(version: &str, bsdf: &str) -> (Material, Vec<String>) {
    let scene = load(version, &format!("<shape type='cube'>{bsdf}</shape>"));
    (
        scene.materials[scene.shapes[0].material].clone(),
        scene.notes,
    )
}

fn camera(body: &str) -> View {
    let sensor = format!("<sensor type='perspective'>{body}</sensor>");
    try_load("3.0.0", &sensor)
        .unwrap_or_else(|e| panic!("{e}"))
        .views
        .remove(0)
}

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

#[test]
fn wrappers_and_references() {
    let (m, notes) = material(
        "0.5.0",
        "<bsdf type='mask'><rgb name='opacity' value='0.25'/><bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' value='0.1 0.2 0.3'/></bsdf></bsdf></bsdf>",
    );
    assert_eq!(m.opacity, Some(ColourSource::Constant([0.25; 3])));
    assert!(m.two_sided && notes.is_empty());
    let (m, _) = material(
        "0.5.0",
        "<bsdf type='bumpmap'><texture type='scale'><float name='scale' value='3'/><texture type='bitmap'><string name='filename' value='b.png'/></texture></texture><bsdf type='diffuse'/></bsdf>",
    );
    assert_eq!(m.bump, Some((0, 3.0)));
    assert!(!m.two_sided);
    // The id of the inner material names the inner material: no bump, and a note about the rest.
    let scene = load(
        "0.5.0",
        "<bsdf type='bumpmap'><texture name='map' type='bitmap'><string name='filename' value='b.png'/></texture><bsdf type='twosided' id='in'><bsdf type='diffuse'/></bsdf></bsdf><shape type='cube'><ref id='in'/></shape><shape type='disk'><ref id='in'/></shape>",
    );
    assert_eq!(scene.shapes[0].material, scene.shapes[1].material);
    let m = &scene.materials[scene.shapes[0].material];
    assert_eq!((m.name.as_str(), m.bump, m.two_sided), ("in", None, true));
    assert_eq!(
        scene.notes,
        ["bsdf `bumpmap` that nothing refers to is left out"]
    );
}

#[test]
fn materials_of_every_kind() {
    let (m, _) = material(
        "3.0.0",
        "<bsdf type='roughplastic'><float name='alpha' value='0.2'/><string name='distribution' value='ggx'/><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/><boolean name='nonlinear' value='true'/></bsdf>",
    );
    assert_eq!(
        m.bsdf,
        Bsdf::Plastic {
            diffuse: ColourSource::Constant([0.5; 3]),
            specular: [1.0; 3],
            ior: 1.5,
            alpha: 0.2,
            distribution: MicrofacetDistribution::Ggx,
            nonlinear: true
        }
    );
    let (m, _) = material(
        "0.5.0",
        "<bsdf type='dielectric'><string name='intIOR' value='water'/><float name='extIOR' value='1'/></bsdf>",
    );
    assert!(matches!(m.bsdf, Bsdf::Dielectric { ior, thin: false, .. } if ior == 1.333));
    let (m, _) = material("0.5.0", "<bsdf type='thindielectric'/>");
    assert!(matches!(m.bsdf, Bsdf::Dielectric { thin: true, .. }));
    let conductor = |version, xml: &str| match material(version, xml).0.bsdf {
        Bsdf::Conductor { eta, k, alpha, .. } => (eta, k, alpha),
        other => panic!("{other:?}"),
    };
    let (eta, k, alpha) = conductor(
        "0.5.0",
        "<bsdf type='conductor'><string name='material' value='none'/></bsdf>",
    );
    assert_eq!((eta, k, alpha), ([0.0; 3], [0.0; 3], 0.0));
    let (eta, ..) = conductor("0.5.0", "<bsdf type='conductor'/>");
    assert_eq!(
        eta,
        [0.200438, 0.924033, 1.10221],
        "copper in the old versions"
    );
    let (eta, ..) = conductor("3.0.0", "<bsdf type='conductor'/>");
    assert_eq!(eta, [0.0; 3], "a mirror in the new ones");
    let (.., alpha) = conductor(
        "3.0.0",
        "<bsdf type='roughconductor'><string name='material' value='Au'/><float name='alpha_u' value='0.1'/><float name='alpha_v' value='0.4'/><string name='distribution' value='ggx'/></bsdf>",
    );
    assert!((alpha - 0.2).abs() < 1e-6);
    let (m, notes) = material(
        "0.6.0",
        "<bsdf type='phong'><rgb name='diffuseReflectance' value='0.5'/><rgb name='specularReflectance' value='0.04'/><float name='exponent' value='48'/></bsdf>",
    );
    assert!(
        matches!(m.bsdf, Bsdf::Plastic { ior, alpha, .. } if (ior - 1.5).abs() < 1e-5 && (alpha - 0.2).abs() < 1e-6)
    );
    assert_eq!(notes.len(), 1);
    let (m, notes) = material(
        "3.0.0",
        "<bsdf type='hair'><float name='x' value='1'/></bsdf>",
    );
    assert!(matches!(m.bsdf, Bsdf::Diffuse { .. }));
    assert_eq!(
        notes,
        ["material type `hair` becomes a diffuse grey of 0.5"]
    );
    let (m, _) = material("3.0.0", "<bsdf type='null'/>");
    assert_eq!(m.opacity, Some(ColourSource::Constant([0.0; 3])));
}

#[test]
fn textures_with_their_details() {
    let scene = load(
        "3.0.0",
        "<texture type='bitmap' id='t'><string name='filename' value='a.jpg'/><boolean name='raw' value='true'/><string name='filter_type' value='nearest'/><string name='wrap_mode' value='clamp'/><transform name='to_uv'><scale x='2' y='4'/><translate x='0.1' y='0.2'/></transform></texture>
         <shape type='cube'><bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf></shape>
         <shape type='cube'><bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf></shape>
         <shape type='disk'><bsdf type='diffuse'><texture name='reflectance' type='checkerboard'><rgb name='color0' value='1'/><rgb name='color1' value='0'/></texture></bsdf></shape>",
    );
    assert_eq!(scene.textures.len(), 2, "a texture is shared");
    let t = &scene.textures[0];
    assert_eq!(t.path(), Some(Path::new("dir/a.jpg")));
    assert!(!t.srgb && t.nearest && t.wrap == Wrap::Clamp);
    assert_eq!(t.uv_scale, [2.0, 4.0]);
    // v downwards: v' = 4v + 0.2; upwards: 1 − (4(1−v) + 0.2) = 4v − 3.2.
    assert!((t.uv_offset[0] - 0.1).abs() < 1e-6 && (t.uv_offset[1] + 3.2).abs() < 1e-6);
    assert_eq!(
        scene.textures[1].source,
        TextureSource::Checkerboard([[1.0; 3], [0.0; 3]])
    );
    let old = load(
        "0.6.0",
        "<shape type='cube'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'><string name='filename' value='a.jpg'/><float name='uscale' value='3'/><float name='gamma' value='1'/><string name='filterType' value='ewa'/></texture></bsdf></shape>",
    );
    assert!(!old.textures[0].srgb && old.textures[0].uv_scale == [3.0, 1.0]);
    assert_eq!(old.notes, ["texture filter `ewa` becomes bilinear"]);
}

#[test]
fn emitters() {
    let scene = load(
        "0.5.0",
        "<shape type='cube'><emitter type='area'><rgb name='radiance' value='1 2 3'/></emitter></shape>
         <emitter type='directional'><vector name='direction' x='0' y='-2' z='0'/><rgb name='irradiance' value='4'/></emitter>
         <emitter type='sunsky'><vector name='sunDirection' x='0.88698' y='0.288862' z='0.360313'/><float name='turbidity' value='2'/><float name='skyScale' value='30'/><float name='sunScale' value='10'/></emitter>",
    );
    assert_eq!(scene.shapes[0].emission, Some([1.0, 2.0, 3.0]));
    let LightKind::Directional {
        direction,
        irradiance,
    } = &scene.lights[0].kind
    else {
        panic!("no parallel light");
    };
    assert_eq!((*direction, *irradiance), (DVec3::NEG_Y, [4.0; 3]));
    let Some(EnvironmentDescription::SunSky {
        sun: true,
        sky: true,
        scale,
        turbidity,
        ..
    }) = scene.environment
    else {
        panic!("no sky");
    };
    assert_eq!((scale, turbidity), (30.0, 2.0));
    assert_eq!(scene.notes, ["sun_scale 10 becomes the sky_scale 30"]);
    let scene = load(
        "3.0.0",
        "<emitter type='envmap'><string name='filename' value='e.exr'/><float name='scale' value='2'/><transform name='to_world'><rotate y='1' angle='90'/></transform></emitter>",
    );
    let Some(EnvironmentDescription::Map {
        path,
        scale,
        to_world,
        rows: EnvironmentRows::PoleCentred,
    }) = scene.environment
    else {
        panic!("no map");
    };
    assert_eq!((path.as_path(), scale), (Path::new("dir/e.exr"), 2.0));
    assert!(to_world.transform_vector3(DVec3::Z).distance(DVec3::X) < 1e-12);
}

#[test]
fn what_is_ignored_is_noted_with_counts() {
    let scene = load(
        "3.0.0",
        "<shape type='cube'><bsdf type='diffuse'><float name='sheen' value='1'/></bsdf></shape><shape type='cube'><bsdf type='diffuse'><float name='sheen' value='1'/></bsdf></shape><bsdf type='diffuse' id='unused'/><medium type='homogeneous'/>",
    );
    assert_eq!(
        scene.notes,
        [
            "bsdf `diffuse` that nothing refers to is left out",
            "parameter `sheen` of bsdf `diffuse` is ignored (2 times)"
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

#[test]
fn microfacets_are_beckmann_where_nothing_is_said() {
    use MicrofacetDistribution::{Beckmann, Ggx};
    let facets = |version: &str, xml: &str| {
        let (material, notes) = material(version, xml);
        match material.bsdf {
            Bsdf::Conductor {
                alpha,
                distribution,
                ..
            }
            | Bsdf::Plastic {
                alpha,
                distribution,
                ..
            } => (alpha, distribution, notes.len()),
            other => panic!("{other:?}"),
        }
    };
    for version in ["0.5.0", "0.6.0", "2.0.0", "3.0.0"] {
        for kind in ["roughplastic", "roughconductor"] {
            let xml = |inner: &str| {
                let none = "<string name='material' value='none'/>";
                let none = if kind == "roughplastic" { "" } else { none };
                format!("<bsdf type='{kind}'>{none}{inner}</bsdf>")
            };
            assert_eq!(facets(version, &xml("")), (0.1, Beckmann, 0));
            let ggx = "<string name='distribution' value='GGX'/><boolean name='sampleVisible' value='false'/><float name='alpha' value='0.3'/>";
            assert_eq!(facets(version, &xml(ggx)), (0.3, Ggx, 0));
            let phong = "<string name='distribution' value='phong'/>";
            assert_eq!(facets(version, &xml(phong)), (0.1, Beckmann, 1));
            let zero = "<float name='alpha' value='0'/>";
            assert_eq!(facets(version, &xml(zero)), (1e-4, Beckmann, 0));
        }
    }
}

#[test]
fn conductors_by_their_indices_and_their_names() {
    let conductor = |version: &str, inner: &str| {
        let xml = format!("<bsdf type='conductor'>{inner}</bsdf>");
        match material(version, &xml) {
            (
                Material {
                    bsdf: Bsdf::Conductor { eta, k, .. },
                    ..
                },
                notes,
            ) => (eta, k, notes.len()),
            (other, _) => panic!("{other:?}"),
        }
    };
    let eta = "<rgb name='eta' value='0.2 0.9 1.1'/>";
    let k = "<rgb name='k' value='3 2 1'/>";
    let (given_eta, given_k) = ([0.2, 0.9, 1.1], [3.0, 2.0, 1.0]);
    assert_eq!(
        conductor("3.0.0", &format!("{eta}{k}")),
        (given_eta, given_k, 0)
    );
    assert_eq!(conductor("3.0.0", eta), (given_eta, [1.0; 3], 0));
    assert_eq!(conductor("0.6.0", &format!("{eta}{k}")).2, 0);
    assert_eq!(conductor("0.6.0", "").2, 1, "copper by default is noted");
    let named = |name: &str| {
        conductor(
            "3.0.0",
            &format!("<string name='material' value='{name}'/>"),
        )
    };
    for name in [
        "a-C", "Ag", "Al", "Au", "Be", "Cr", "Cu_palik", "Hg", "Ir", "Mo", "Rh", "V", "W",
    ] {
        let (eta, k, notes) = named(name);
        assert!(
            notes == 0 && eta.iter().chain(&k).all(|v| *v > 0.0),
            "{name}"
        );
    }
    assert_eq!(named("unobtainium").2, 1);
    let outside = format!("{eta}{k}<float name='extEta' value='2'/>");
    assert_eq!(conductor("0.5.0", &outside).0, [0.1, 0.45, 0.55]);
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
            "hide_emitters is ignored: lights are seen directly",
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
    assert_eq!(film("<rfilter type='box'/><integer name='crop_width' value='3'/><integer name='cropHeight' value='3'/>").len(), 1);
}
