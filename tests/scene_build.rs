//! Scenes from files of every quality: what is repaired, left out or refused, and what it is called.

use std::fs;
use std::path::PathBuf;

use glam::{DVec3, Vec3};
use lightbench::scene::{Needs, Scene, SceneDescription, find_scene_in, shipped_scenes};

const HEAD: &str =
    "[[view]]\norigin = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_deg = 40\nsize = [8, 8]\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        path
    }

    fn find(&self, name: &str) -> Result<SceneDescription, String> {
        find_scene_in(name, &[self.0.path().to_owned()]).map_err(|e| e.to_string())
    }

    /// Builds a scene.toml of these shapes.
    fn build(&self, shapes: &str, needs: Needs) -> Result<Scene, String> {
        self.write("s/scene.toml", &format!("{HEAD}{shapes}"));
        Scene::build(&self.find("s")?, needs).map_err(|e| e.to_string())
    }
}

fn obj(name: &str) -> String {
    format!("[[shape]]\nkind = \"obj\"\npath = \"{name}\"\n")
}

const CUBE: &str = "[[shape]]\nkind = \"cube\"\n";

#[test]
fn names_are_folders_files_or_paths() {
    let folder = Folder::new();
    let file = folder.write("rooms/a.toml", &format!("{HEAD}{CUBE}"));
    folder.write("b/scene.toml", &format!("{HEAD}{CUBE}"));
    assert_eq!(folder.find("b").unwrap().name, "b");
    assert_eq!(folder.find("rooms/a.toml").unwrap().name, "rooms-a");
    let by_path = find_scene_in(file.to_str().unwrap(), &[]).unwrap();
    assert_eq!(by_path.name, "rooms-a");
    let by_folder = find_scene_in(
        file.parent()
            .unwrap()
            .parent()
            .unwrap()
            .join("b")
            .to_str()
            .unwrap(),
        &[],
    );
    assert_eq!(by_folder.unwrap().name, "b");
}

#[test]
fn an_unknown_scene_lists_what_was_searched_and_what_is_near() {
    let folder = Folder::new();
    folder.write("kitchen/scene.xml", "<scene version='3.0.0'/>");
    let message = folder.find("kitchn").unwrap_err();
    assert!(message.contains("did you mean `kitchen`"), "{message}");
    let looked = folder.0.path().join("kitchn");
    assert!(message.contains(looked.to_str().unwrap()), "{message}");
    assert!(message.contains("LIGHTBENCH_SCENES"), "{message}");
}

#[test]
fn shipped_scenes_load() {
    for name in shipped_scenes() {
        let description = find_scene_in(name, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(description.name, name);
        assert!(!description.title.is_empty(), "{name} has no title");
        let scene = Scene::build(&description, Needs::ALL).unwrap_or_else(|e| panic!("{e}"));
        assert!(scene.report.absent.is_empty() && !scene.triangles.is_empty());
        let again = Scene::build(&description, Needs::ALL).unwrap();
        assert_eq!(
            scene.positions, again.positions,
            "{name} is not reproducible"
        );
    }
}

#[test]
fn scenes_are_centred_whatever_their_place() {
    let folder = Folder::new();
    let near = folder.build(CUBE, Needs::GEOMETRY).unwrap();
    let far = folder
        .build(
            &format!("{CUBE}translate = [10000.1, -20000.7, 30000.3]\n"),
            Needs::GEOMETRY,
        )
        .unwrap();
    assert_eq!(near.origin, DVec3::ZERO);
    for (a, b) in near.positions.iter().zip(&far.positions) {
        assert!(a.distance(*b) < 1e-6);
    }
    assert_eq!(far.views[0].origin, DVec3::new(0.0, 0.0, 5.0) - far.origin);
    assert!((near.diagonal - 12_f32.sqrt()).abs() < 1e-6);
    assert!((near.ao_distance - 0.1 * near.diagonal).abs() < 1e-7);
}

#[test]
fn sizes_from_tiny_to_huge_keep_all_triangles() {
    let folder = Folder::new();
    for scale in ["1e-3", "1e-8", "1e5", "1e8"] {
        let scene = folder
            .build(&format!("{CUBE}scale = {scale}\n"), Needs::GEOMETRY)
            .unwrap();
        assert_eq!(
            (scene.triangles.len(), scene.report.dropped_degenerate),
            (12, 0),
            "{scale}"
        );
    }
}

#[test]
fn sizes_and_places_beyond_single_precision_are_refused() {
    let folder = Folder::new();
    for (line, told) in [
        ("scale = 1e-15", "is 3.46410"),
        ("scale = 1e15", "single precision holds scenes of"),
        ("translate = [1e12, 0, 0]", "is 1e12 units from the origin"),
        ("translate = [1e30, 0, 0]", "scene"),
    ] {
        let built = folder.build(&format!("{CUBE}{line}\n"), Needs::GEOMETRY);
        let error = built.unwrap_err().to_string();
        assert!(error.contains(told), "{line}: {error}");
    }
}

#[test]
fn bad_geometry_is_dropped_and_counted() {
    let folder = Folder::new();
    folder.write(
        "s/bad.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 2 0 0\nvn 0 0 1\nvn 0 0 0\nf 1//1 2//1 3//2\nf 1//1 2//1 4//1\nf 1//1 2//1 5//1\nf 1//1 1//1 2//1\n",
    );
    let scene = folder.build(&obj("bad.obj"), Needs::GEOMETRY).unwrap();
    let report = &scene.report;
    assert_eq!(report.triangles, 1);
    assert_eq!(
        (report.dropped_degenerate, report.dropped_non_finite),
        (2, 1)
    );
    let told = report.sentences();
    for sentence in [
        "2 triangles without an area are left out",
        "1 triangles that are not finite are left out",
    ] {
        assert!(told.iter().any(|text| text == sentence), "{told:?}");
    }
    assert_eq!(report.repaired_normals, 1);
    assert_eq!(scene.normals, [Vec3::Z; 3]);
    folder.write("s/flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let message = folder.build(&obj("flat.obj"), Needs::GEOMETRY).unwrap_err();
    assert!(
        message.contains("nothing to render") && message.contains("1 degenerate"),
        "{message}"
    );
}

#[test]
fn absent_files_are_left_out_and_damaged_ones_refused() {
    let folder = Folder::new();
    let scene = folder
        .build(&format!("{CUBE}{}", obj("gone.obj")), Needs::GEOMETRY)
        .unwrap();
    assert_eq!(scene.report.absent.len(), 1);
    assert!(scene.report.absent[0].contains("gone.obj is absent"));
    assert_eq!((scene.shapes.len(), scene.shapes[1].triangle_count), (2, 0));
    folder.write("s/cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2");
    let message = folder
        .build(&format!("{CUBE}{}", obj("cut.obj")), Needs::GEOMETRY)
        .unwrap_err();
    assert!(
        message.contains("cut.obj:4:1: a face needs 3 corners"),
        "{message}"
    );
    let message = folder.build(&obj("gone.obj"), Needs::GEOMETRY).unwrap_err();
    assert!(message.contains("gone.obj is absent"), "{message}");
}

#[test]
fn the_first_damaged_file_is_named_on_any_number_of_threads() {
    let folder = Folder::new();
    let mut shapes = String::new();
    for i in 0..40 {
        folder.write(
            &format!("s/m{i}.obj"),
            if i % 7 == 5 {
                "v 0 0\n"
            } else {
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
            },
        );
        shapes += &obj(&format!("m{i}.obj"));
    }
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let message = pool
            .install(|| folder.build(&shapes, Needs::GEOMETRY))
            .unwrap_err();
        assert!(message.contains("m5.obj:"), "{message}");
    }
}

fn textured(folder: &Folder) -> String {
    let path = folder.write("s/t.png", "");
    image::RgbImage::from_pixel(4, 2, image::Rgb([255, 0, 0]))
        .save(path)
        .unwrap();
    let texture = |name: &str, file: &str| format!("[texture.{name}]\npath = \"{file}\"\n");
    let material = |name: &str| {
        format!("[material.{name}]\nkind = \"diffuse\"\nreflectance = {{ texture = \"{name}\" }}\n")
    };
    let mut text = String::new();
    for (name, file) in [
        ("red", "t.png"),
        ("gone", "gone.png"),
        ("unused", "gone2.png"),
    ] {
        text += &texture(name, file);
        text += &material(name);
    }
    text += &format!("{CUBE}material = \"red\"\nemission = [1, 2, 3]\n{CUBE}material = \"gone\"\n");
    text + "[environment]\nkind = \"map\"\npath = \"gone.hdr\"\n[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nirradiance = 2\n[[light]]\nkind = \"point\"\nposition = [0, 9, 0]\nintensity = 3\n"
}

#[test]
fn only_what_is_needed_is_read() {
    let folder = Folder::new();
    let text = textured(&folder);
    let scene = folder.build(&text, Needs::ALL).unwrap();
    assert_eq!(scene.textures.len(), 3);
    assert_eq!(
        scene.textures[0].lookup(glam::Vec2::splat(0.5)),
        [1.0, 0.0, 0.0]
    );
    assert_eq!(scene.textures[1].lookup(glam::Vec2::splat(0.5)), [0.5; 3]);
    assert_eq!(scene.report.absent.len(), 2, "{:?}", scene.report.absent);
    assert_eq!(scene.shapes[0].emission, Some([1.0, 2.0, 3.0]));
    assert_eq!(scene.directional_lights, [(Vec3::NEG_Y, [2.0; 3])]);
    let [lamp] = scene.point_lights[..] else {
        panic!("one point light");
    };
    assert_eq!(
        lamp.position,
        Vec3::new(0.0, 9.0, 0.0) - scene.origin.as_vec3()
    );
    assert_eq!(scene.uvs.len(), scene.positions.len());
    assert!(scene.environment.is_none());
    let bare = folder.build(&text, Needs::GEOMETRY).unwrap();
    assert!(bare.materials.is_empty() && bare.textures.is_empty() && bare.uvs.is_empty());
    assert!(bare.directional_lights.is_empty() && bare.point_lights.is_empty());
    assert!(bare.shapes[0].emission.is_none());
    assert!(bare.report.absent.is_empty() && bare.report.texture_bytes == 0);
    assert_eq!(
        bare.report.cost.textures,
        4 * 2 * 3,
        "known from the header"
    );
    assert_eq!(bare.positions, scene.positions);
    // A damaged texture matters only to those who need it.
    folder.write("s/t.png", "not a picture");
    assert!(folder.build(&text, Needs::GEOMETRY).is_ok());
    let message = folder.build(&text, Needs::ALL).unwrap_err();
    assert!(message.contains("t.png"), "{message}");
    let grey = Needs {
        textures: false,
        ..Needs::ALL
    };
    let scene = folder.build(&text, grey).unwrap();
    assert_eq!(scene.textures[0].lookup(glam::Vec2::ZERO), [0.5; 3]);
}

#[test]
fn shapes_own_ranges_of_triangles() {
    let folder = Folder::new();
    let scene = folder
        .build(
            &format!(
                "{CUBE}{}[[shape]]\nkind = \"rectangle\"\nscale = [-1, 1, 1]\n",
                obj("gone.obj")
            ),
            Needs::GEOMETRY,
        )
        .unwrap();
    let ranges: Vec<(u32, u32)> = scene
        .shapes
        .iter()
        .map(|s| (s.first_triangle, s.triangle_count))
        .collect();
    assert_eq!(ranges, [(0, 12), (12, 0), (12, 2)]);
    assert_eq!(scene.triangle_shape[11..], [0, 2, 2]);
    for t in &scene.triangles[12..] {
        let [a, b, c] = t.map(|i| scene.positions[i as usize]);
        assert!((b - a).cross(c - a).z > 0.0, "a mirror keeps the front");
    }
}

#[test]
fn one_scene_in_toml_and_xml_is_the_same() {
    let folder = Folder::new();
    let toml = folder
        .build("[[shape]]\nkind = \"cube\"\nscale = [1, 2, 3]\nrotate = [0, 1, 0, 30]\ntranslate = [1, 2, 3]\n", Needs::GEOMETRY)
        .unwrap();
    folder.write(
        "x/scene.xml",
        "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='40'/><transform name='to_world'><lookat origin='0 0 5' target='0 0 0' up='0 1 0'/></transform><film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/></film></sensor><shape type='cube'><transform name='to_world'><scale x='1' y='2' z='3'/><rotate y='1' angle='30'/><translate x='1' y='2' z='3'/></transform></shape></scene>",
    );
    let xml = Scene::build(&folder.find("x").unwrap(), Needs::GEOMETRY).unwrap();
    assert_eq!(
        (&toml.positions, &toml.triangles),
        (&xml.positions, &xml.triangles)
    );
    let (a, b) = (&toml.views[0], &xml.views[0]);
    assert!(a.right.distance(b.right) < 1e-12 && a.origin.distance(b.origin) < 1e-12);
    assert_eq!(
        (a.width, a.height, a.fov_axis),
        (b.width, b.height, b.fov_axis)
    );
}

#[test]
fn generated_shapes_report_unknown_generators() {
    let folder = Folder::new();
    let text = "[[shape]]\nkind = \"generated\"\ngenerator = \"no-such-thing\"\n";
    let message = folder.build(text, Needs::GEOMETRY).unwrap_err();
    assert!(message.contains("no-such-thing"), "{message}");
}

#[test]
fn obj_files_bring_their_materials() {
    let folder = Folder::new();
    folder.write("s/a.mtl", "newmtl red\nKd 1 0 0\nnewmtl lamp\nKe 5 5 5\n");
    folder.write(
        "s/a.obj",
        "mtllib a.mtl\nmtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl red\nf 1 2 3\nusemtl lamp\nf 1 2 4\nusemtl what\nf 2 3 4\nusemtl red\nf 1 3 4\n",
    );
    let scene = folder.build(&obj("a.obj"), Needs::ALL).unwrap();
    let counts: Vec<u32> = scene.shapes.iter().map(|s| s.triangle_count).collect();
    assert_eq!(counts, [2, 1, 1]);
    assert_eq!(scene.shapes[1].emission, Some([5.0; 3]));
    let name = |shape: usize| {
        scene.materials[scene.shapes[shape].material as usize]
            .name
            .as_str()
    };
    assert_eq!([name(0), name(1), name(2)], ["red", "lamp", "what"]);
    assert_eq!(scene.report.notes.len(), 3, "{:?}", scene.report.notes);
    folder.write(
        "s/b.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl red\nf 1 3 2\nf 3 2 1\n",
    );
    let scene = folder.build(&obj("b.obj"), Needs::ALL).unwrap();
    let counts: Vec<u32> = scene.shapes.iter().map(|s| s.triangle_count).collect();
    assert_eq!(counts, [1, 2], "faces before the first usemtl are kept");
    let one = folder
        .build(
            &format!(
                "{}[material.m]\nkind = \"diffuse\"\n",
                obj("a.obj") + "material = \"m\"\n"
            ),
            Needs::ALL,
        )
        .unwrap();
    assert_eq!(one.shapes.len(), 1);
}
