use glam::DVec3;

use super::*;
use crate::environment::EnvironmentDescription;
use crate::scene::{Bsdf, ColourSource, Needs, Scene, ShapeSource, Wrap};

const VIEW: &str = "[[view]]\norigin = [0, 1, 5]\ntarget = [0, 1, 0]\nfov_deg = 45\n";
const SHAPE: &str = "[[shape]]\nkind = \"cube\"\n";

fn parse(text: &str) -> Result<SceneDescription, String> {
    parse_toml(text, Some(Path::new("dir/scene.toml")), "s").map_err(|e| e.to_string())
}

fn error(text: &str) -> String {
    match parse(text) {
        Ok(_) => panic!("should fail: {text}"),
        Err(message) => message,
    }
}

#[test]
fn everything_is_read() {
    let scene = parse(
        r#"
title = "t"
metres_per_unit = 0.01
ao_distance = 1.5
exposure = 2
max_depth = 3
[[view]]
name = "side"
origin = [0, 0, 5]
target = [0, 0, 0]
fov_deg = 45
fov_axis = "diagonal"
size = [64, 32]
[[view]]
origin = [5, 0, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov_deg = 30.5
[texture.wood]
path = "wood.png"
srgb = false
filter = "nearest"
wrap = "mirror"
uv_scale = [2, 3]
[material.stone]
kind = "diffuse"
reflectance = { texture = "wood" }
two_sided = false
[material.gold]
kind = "conductor"
alpha = 0
opacity = 0.5
[material.glass]
kind = "dielectric"
ior = 1.33
thin = true
[material.paint]
kind = "plastic"
diffuse = [0.1, 0.2, 0.3]
nonlinear = true
distribution = "beckmann"
[[shape]]
kind = "obj"
path = "a/b.obj"
part = "p"
material = "gold"
scale = 2
rotate = [[0, 0, 1, 90], [1, 0, 0, 90]]
translate = [1, 2, 3]
emission = [10, 10, 9]
[[shape]]
kind = "generated"
generator = "atrium"
parameters = { seed = 1, detail = 3.5 }
matrix = [1, 0, 0, 7,  0, 1, 0, 8,  0, 0, 1, 9,  0, 0, 0, 1]
[environment]
kind = "sky"
sun_elevation_deg = 30
sun_azimuth_deg = 90
[[light]]
kind = "directional"
direction = [0, -2, 0]
irradiance = [1, 2, 3]
"#,
    )
    .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        (scene.metres_per_unit, scene.ao_distance),
        (Some(0.01), Some(1.5))
    );
    assert_eq!((scene.exposure, scene.max_depth), (2.0, 3));
    let names: Vec<&str> = scene.views.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["side", "view2"]);
    assert_eq!(scene.views[0].right, DVec3::X);
    assert_eq!((scene.views[0].width, scene.views[1].height), (64, 1080));
    let texture = &scene.textures[0];
    assert_eq!(texture.path(), Some(Path::new("dir/wood.png")));
    assert!(texture.nearest && !texture.srgb && texture.wrap == Wrap::Mirror);
    assert_eq!(scene.materials.len(), 5);
    assert_eq!(
        scene.materials[1].bsdf,
        Bsdf::Diffuse {
            reflectance: ColourSource::Texture(0)
        }
    );
    let shape = &scene.shapes[0];
    assert_eq!(scene.materials[shape.material].name, "gold");
    assert_eq!(
        scene.materials[2].opacity,
        Some(ColourSource::Constant([0.5; 3]))
    );
    let beckmann = |m: &crate::scene::Material| {
        use crate::scene::{Bsdf::Plastic, MicrofacetDistribution::Beckmann};
        matches!(m.bsdf, Plastic { distribution, nonlinear, .. } if nonlinear && distribution == Beckmann)
    };
    assert!(beckmann(&scene.materials[4]));
    // (1,0,0) scaled by 2, turned to +y, then to +z, then moved.
    let moved = shape.to_world.transform_point3(DVec3::X);
    assert!(moved.distance(DVec3::new(1.0, 2.0, 5.0)) < 1e-12);
    assert!(
        matches!(&shape.source, ShapeSource::Obj { path, part: Some(p), .. } if path == Path::new("dir/a/b.obj") && p == "p")
    );
    assert_eq!(
        scene.shapes[1].to_world.transform_point3(DVec3::ZERO),
        DVec3::new(7.0, 8.0, 9.0)
    );
    let Some(EnvironmentDescription::SunSky { sun_direction, .. }) = scene.environment else {
        panic!("no sky");
    };
    assert!(sun_direction.distance(DVec3::new(0.75_f64.sqrt(), 0.5, 0.0)) < 1e-12);
    assert_eq!(scene.lights.len(), 1);
}

#[test]
fn defaults() {
    let scene = parse(&format!("{VIEW}{SHAPE}")).unwrap();
    assert_eq!(
        (scene.metres_per_unit, scene.exposure, scene.max_depth),
        (None, 1.0, 6)
    );
    assert_eq!(scene.ao_distance, None);
    assert_eq!(scene.views[0].name, "main");
    assert!(scene.materials[0].two_sided);
}

#[test]
fn errors_say_where_what_and_what_instead() {
    for (text, place, expected) in [
        (
            format!("titel = \"x\"\n{VIEW}{SHAPE}"),
            "1:1",
            "unknown key `titel` in the scene; did you mean `title`?",
        ),
        (
            format!("{VIEW}  fovaxis = \"x\"\n{SHAPE}"),
            "5:3",
            "did you mean `fov_axis`?",
        ),
        (
            format!("{VIEW}fov_axis = \"diag\"\n{SHAPE}"),
            "5:12",
            "`diag` is unknown",
        ),
        (
            format!("{VIEW}[[shape]]\nkind = \"cub\"\n"),
            "6:8",
            "did you mean `cube`?",
        ),
        (
            format!("{VIEW}[[shape]]\nname = \"x\"\n"),
            "5:1",
            "needs `kind`; known: obj",
        ),
        (
            format!("{VIEW}{SHAPE}material = \"stone\"\n[material.stoen]\nkind = \"diffuse\"\n"),
            "7:12",
            "did you mean `stoen`?",
        ),
        (
            format!("{VIEW}{SHAPE}radius = 2\n"),
            "7:1",
            "unknown key `radius` in shape `cube 0` (cube)",
        ),
        (
            format!("{VIEW}{SHAPE}scale = [1, 0, 1]\n"),
            "7:9",
            "none of them 0",
        ),
        (
            format!("{VIEW}{SHAPE}emission = [1, -1, 1]\n"),
            "7:12",
            "none below 0",
        ),
        (
            format!("{VIEW}{SHAPE}translate = [nan, 0, 0]\n"),
            "7:13",
            "a list of 3 finite numbers",
        ),
        (
            format!("{VIEW}{SHAPE}matrix = [1]\n"),
            "7:10",
            "a list of 16 finite numbers",
        ),
        (
            format!(
                "{VIEW}[material.m]\nkind = \"diffuse\"\nreflectance = {{ texture = \"w\" }}\n{SHAPE}"
            ),
            "7:15",
            "no texture is called `w`",
        ),
        (
            format!("{VIEW}[material.m]\nkind = \"diffuse\"\nreflectance = \"red\"\n{SHAPE}"),
            "7:15",
            "expected [r, g, b] or one number, none below 0, found \"red\"",
        ),
        (
            format!("{VIEW}[material.m]\nkind = \"diffuse\"\nreflectance = 1.5\n{SHAPE}"),
            "7:15",
            "each from 0 to 1, found 1.5",
        ),
        (
            format!("{VIEW}[material.m]\nkind = \"plastic\"\nspecular = [1, 1, 2]\n{SHAPE}"),
            "7:12",
            "each from 0 to 1",
        ),
        (
            format!("max_depth = 1.5\n{VIEW}{SHAPE}"),
            "1:13",
            "a whole number from 0",
        ),
        (
            format!("ao_distance = -1\n{VIEW}{SHAPE}"),
            "1:15",
            "a number above 0",
        ),
        (VIEW.to_owned(), "1:1", "at least one [[shape]]"),
        (SHAPE.to_owned(), "1:1", "at least one [[view]]"),
        (
            "[[view]]\norigin = [0, 0, 0]\ntarget = [0, 1, 0]\nfov_deg = 45\n".to_owned(),
            "1:1",
            "parallel",
        ),
        (
            "[[view]]\norigin = [0, 0, 0]\nfov_deg = 45\n".to_owned(),
            "1:1",
            "view `main` needs `target`",
        ),
        ("title = \n".to_owned(), "1:9", ""),
        ("[[view]\n".to_owned(), "1:", ""),
        (
            format!("view = 3\n{SHAPE}"),
            "1:8",
            "expected [[view]] tables",
        ),
    ] {
        let message = error(&text);
        assert!(
            message.starts_with(&format!("dir/scene.toml:{place}")),
            "{message} ({place})"
        );
        assert!(message.contains(expected), "{message} ({expected})");
    }
}

#[test]
fn embedded_scenes_have_a_shown_name() {
    let message = parse_toml("x = 1", None, "statues")
        .unwrap_err()
        .to_string();
    assert!(message.starts_with("<statues>/scene.toml:1:1"), "{message}");
}

#[test]
fn last_rows_of_matrices_are_those_of_maps_of_places() {
    let load = |row: &str| {
        let text = format!(
            "[[view]]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 45\n[[shape]]\nkind = \"cube\"\nmatrix = [1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7, {row}]\n"
        );
        parse_toml(&text, Some(Path::new("scene.toml")), "s").map_err(|e| e.to_string())
    };
    load("0, 0, 0, 1").expect("a map of places");
    for row in ["0, 0, 0, 2", "0, 0, 1, 1"] {
        let error = load(row).expect_err(row);
        assert!(
            error.starts_with("scene.toml:7:10: `matrix` of shape `cube 0` (cube): expected 16"),
            "{error}"
        );
    }
}

#[test]
fn parts_without_a_material_have_those_of_their_libraries() {
    let place = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(place.path().join(name), text).expect("writable");
    };
    write(
        "m.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\nKe 3 3 3\n",
    );
    write(
        "m.obj",
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no a\nusemtl red\nf 1 2 3\nusemtl green\nf 1 2 4\nf 1 3 4\no b\nf 2 3 4\n",
    );
    let head = "[[view]]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 45\n[[shape]]\nkind = \"obj\"\nname = \"s\"\npath = \"m.obj\"\n";
    let file = place.path().join("scene.toml");
    for (part, expected) in [
        ("a", vec![("red", false, 1), ("green", true, 2)]),
        ("b", vec![("green", true, 1)]),
        ("usemtl red", vec![("red", false, 1)]),
    ] {
        let text = format!("{head}part = \"{part}\"\n");
        let description = parse_toml(&text, Some(&file), "s").expect("a scene");
        let scene = Scene::build(&description, Needs::ALL).expect("builds");
        let found: Vec<(&str, bool, u32)> = scene
            .shapes
            .iter()
            .map(|shape| {
                let material = &scene.materials[shape.material as usize].name;
                (
                    material.as_str(),
                    shape.emission.is_some(),
                    shape.triangle_count,
                )
            })
            .collect();
        assert_eq!(found, expected, "{part}");
        assert!(description.shapes.iter().all(|shape| shape.object() == "s"));
    }
    let text = format!("{head}part = \"c\"\n");
    let description = parse_toml(&text, Some(&file), "s").expect("a scene");
    let error = Scene::build(&description, Needs::ALL).expect_err("no such part");
    assert!(
        error.to_string().contains("no object or group `c`"),
        "{error}"
    );
}

#[test]
fn factors_of_libraries_stand_before_their_maps() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "m.mtl",
        "newmtl a\nmap_Kd -mm 0 0.5 a.png\nKd 1 0.5 0.2\nnewmtl b\nmap_Kd a.png\nd 0.5\nmap_d b.png\nnewmtl c\nillum 1\n",
    );
    let faces =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n";
    write("m.obj", &format!("mtllib m.mtl\n{faces}"));
    let text = "[[view]]\norigin = [0, 0, 2]\ntarget = [0, 0, 0]\nfov_deg = 40\n[[shape]]\nkind = \"obj\"\npath = \"m.obj\"\n";
    let file = folder.path().join("scene.toml");
    let scene = parse_toml(text, Some(&file), "s").unwrap();
    let texture = |source: ColourSource| match source {
        ColourSource::Texture(index) => scene.textures[index].factor,
        ref other => panic!("{other:?}"),
    };
    let diffuse = |i: usize| match scene.materials[scene.shapes[i].material].bsdf {
        Bsdf::Diffuse { reflectance } => reflectance,
        ref other => panic!("{other:?}"),
    };
    assert_eq!(texture(diffuse(0)), [0.5, 0.25, 0.1]);
    assert_eq!(texture(diffuse(1)), [1.0; 3], "without `Kd`");
    let opacity = scene.materials[scene.shapes[1].material].opacity;
    assert_eq!(texture(opacity.unwrap()), [0.5; 3]);
    assert_eq!(diffuse(2), ColourSource::Constant([0.8; 3]));
}
