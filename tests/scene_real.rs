//! The published scenes, where `LIGHTBENCH_SCENES` points to them: triangles, textures, lights, notes.

use std::path::PathBuf;

use lightbench::scene::{
    Needs, Scene, SceneDescription, ShapeSource, Texture, TextureDescription, check_scene,
    find_scene_in,
};

/// Loads a scene of the search path; `None` (said aloud) where it is not there.
fn load(name: &str) -> Option<SceneDescription> {
    let list = std::env::var_os("LIGHTBENCH_SCENES").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&list).collect();
    if !folders.iter().any(|f| f.join(name).exists()) {
        eprintln!("skipped: {name} is not below LIGHTBENCH_SCENES");
        return None;
    }
    Some(find_scene_in(name, &folders).unwrap_or_else(|e| panic!("{e}")))
}

struct Expected {
    name: &'static str,
    /// In files and flat primitives, degenerate ones included; spheres are tessellated on top.
    triangles: usize,
    degenerate: usize,
    absent: usize,
    emitting_shapes: usize,
}

const fn expected(
    name: &'static str,
    [triangles, degenerate, absent, emitting_shapes]: [usize; 4],
) -> Expected {
    Expected {
        name,
        triangles,
        degenerate,
        absent,
        emitting_shapes,
    }
}

const SCENES: [Expected; 11] = [
    expected("cornell-box", [36, 0, 0, 1]),
    expected("cbox-mitsuba", [38, 0, 0, 1]),
    expected("veach-mis", [52, 0, 0, 3]),
    expected("veach-ajar", [4_546, 62, 6, 1]),
    expected("staircase", [262_663, 155, 0, 1]),
    expected("living-room", [143_163, 190, 0, 0]),
    expected("dining-room", [269_538, 0, 0, 0]),
    expected("kitchen", [1_050_941, 219, 6, 4]),
    expected("bathroom", [380_290, 282, 3, 1]),
    expected("sponza-dabrovic", [66_445, 0, 0, 1]),
    expected("sponza-dabrovic/scene_obj.xml", [66_445, 0, 0, 1]),
];

/// Triangles of one tessellated sphere.
const SPHERE: usize = 2 * 128 * 63;

#[test]
fn real_scenes_have_the_triangles_of_their_files() {
    for expected in SCENES {
        let Some(description) = load(expected.name) else {
            continue;
        };
        let scene = Scene::build(&description, Needs::GEOMETRY).unwrap_or_else(|e| panic!("{e}"));
        let is_sphere = |s: &ShapeSource| matches!(s, ShapeSource::Sphere { .. });
        let spheres = description
            .shapes
            .iter()
            .filter(|s| is_sphere(&s.source))
            .count();
        let report = &scene.report;
        let found = report.triangles + report.dropped_degenerate + report.dropped_non_finite;
        assert_eq!(
            found - spheres * SPHERE,
            expected.triangles,
            "{}",
            expected.name
        );
        assert_eq!(
            report.dropped_degenerate, expected.degenerate,
            "{}",
            expected.name
        );
        assert_eq!(report.absent.len(), expected.absent, "{:?}", report.absent);
        let emitting = description
            .shapes
            .iter()
            .filter(|s| s.emission.is_some())
            .count();
        assert_eq!(emitting, expected.emitting_shapes, "{}", expected.name);
        assert!(scene.materials.is_empty() && scene.textures.is_empty() && scene.uvs.is_empty());
        assert_eq!(scene.triangles.len(), scene.triangle_shape.len());
        assert!(scene.normals.iter().all(|n| {
            let length = n.length();
            length == 0.0 || (length - 1.0).abs() < 1e-5
        }));
    }
}

#[test]
fn everything_of_a_real_scene_loads() {
    for name in [
        "staircase",
        "living-room",
        "dining-room",
        "bathroom",
        "veach-ajar",
    ] {
        let Some(description) = load(name) else {
            continue;
        };
        let check = check_scene(&description).unwrap_or_else(|e| panic!("{e}"));
        let report = &check.report;
        assert!(report.texture_bytes > 1_000_000, "{name}");
        assert!(
            report.cost.of(Needs::GEOMETRY) * 2 < report.cost.of(Needs::ALL),
            "{name}"
        );
        let lit = check.emitting_shapes > 0 || report.environment_bytes > 0;
        let absent_map = report.absent.iter().any(|a| a.contains("environment map"));
        assert_eq!(lit, name != "dining-room", "{name}: {:?}", report.absent);
        assert_eq!(absent_map, name == "dining-room");
        assert!(serde_json::to_string(&check).is_ok());
    }
}

/// Spectra as Mitsuba's RGB mode has them: its picture of this scene shows the lamp directly, plus
/// about one per cent that the lamp reflects.
#[test]
fn the_lamp_of_the_spectral_cornell_box_is_that_of_the_reference() {
    let (Some(description), Some(references)) =
        (load("cbox-mitsuba"), std::env::var_os("LIGHTBENCH_REFS"))
    else {
        eprintln!("skipped: needs LIGHTBENCH_SCENES and LIGHTBENCH_REFS");
        return;
    };
    let lamp = description.shapes.iter().find_map(|s| s.emission).unwrap();
    let path = PathBuf::from(references).join("scenes/cbox_mean.exr");
    let picture = Texture::load(&TextureDescription::file(path)).unwrap();
    let mut brightest = [0.0_f32; 3];
    for index in 0..256 * 256 {
        let at = |i: usize| (i as f32 + 0.5) / 256.0;
        let colour = picture.lookup(glam::Vec2::new(at(index % 256), at(index / 256)));
        if colour[1] > brightest[1] {
            brightest = colour;
        }
    }
    for (ours, theirs) in lamp.iter().zip(brightest) {
        assert!(
            *ours < theirs && theirs < 1.02 * ours,
            "{lamp:?} {brightest:?}"
        );
    }
}

/// The same meshes in two formats give the same scene.
#[test]
fn serialized_and_obj_sponza_agree() {
    let (Some(a), Some(b)) = (
        load("sponza-dabrovic"),
        load("sponza-dabrovic/scene_obj.xml"),
    ) else {
        return;
    };
    let a = Scene::build(&a, Needs::GEOMETRY).unwrap();
    let b = Scene::build(&b, Needs::GEOMETRY).unwrap();
    assert_eq!(a.triangles.len(), b.triangles.len());
    assert!((a.origin - b.origin).length() < 1e-5);
    for (ta, tb) in a.triangles.iter().zip(&b.triangles) {
        for (&ia, &ib) in ta.iter().zip(tb) {
            let distance = (a.positions[ia as usize] - b.positions[ib as usize]).length();
            assert!(distance < 1e-4, "{distance}");
        }
    }
}
