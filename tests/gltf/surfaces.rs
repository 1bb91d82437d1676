//! Materials and textures.

use glam::Vec2;
use lightbench::scene::{
    Bsdf, ColourSource, Material, SceneDescription, ShapeDescription, Texture, Wrap,
};
use serde_json::{Value, json};

use crate::builder::{FLOAT, File, data_uri, floats};

/// Texels of a PNG file, two by two.
fn png(texels: [[u8; 4]; 4]) -> Vec<u8> {
    let image = image::RgbaImage::from_fn(2, 2, |x, y| image::Rgba(texels[(y * 2 + x) as usize]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("encodes");
    bytes.into_inner()
}

/// The triangle with texture coordinates, one material and one texture.
fn file(material: Value, texels: [[u8; 4]; 4]) -> File {
    let mut file = File::triangle().with("/meshes/0/primitives/0/material", json!(0));
    let uvs = file.accessor(&floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]), FLOAT, "VEC2", 3);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    file.push("/materials", material);
    file.set("/images", json!([{ "uri": data_uri(&png(texels)) }]));
    file.set(
        "/samplers",
        json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33071 }]),
    );
    file.set("/textures", json!([{ "source": 0, "sampler": 0 }]));
    file
}

const GREY: [[u8; 4]; 4] = [[128, 128, 128, 255]; 4];

fn mapped(material: Value) -> (Material, ShapeDescription, SceneDescription) {
    let scene = file(material, GREY).load().expect("loads");
    let shape = scene.shapes[0].clone();
    (scene.materials[shape.material].clone(), shape, scene)
}

fn has_note(scene: &SceneDescription, part: &str) -> bool {
    scene.notes.iter().any(|note| note.contains(part))
}

#[test]
fn metal_becomes_a_conductor_and_the_rest_plastic() {
    let pbr = json!({ "baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.5 });
    let (plastic, _, _) =
        mapped(json!({ "name": "red", "pbrMetallicRoughness": pbr, "doubleSided": true }));
    assert_eq!((plastic.name.as_str(), plastic.two_sided), ("red", true));
    let Bsdf::Plastic {
        diffuse,
        ior,
        alpha,
        specular,
        ..
    } = plastic.bsdf
    else {
        panic!("plastic")
    };
    assert_eq!(diffuse, ColourSource::Constant([0.5, 0.25, 1.0]));
    assert_eq!((ior, alpha, specular), (1.5, 0.25, [1.0; 3]));
    // glTF's default: white, rough, metal.
    let (metal, _, scene) = mapped(json!({}));
    let Bsdf::Conductor {
        specular, alpha, ..
    } = metal.bsdf
    else {
        panic!("metal")
    };
    assert_eq!(
        (specular, alpha, metal.two_sided),
        (ColourSource::Constant([1.0; 3]), 1.0, false)
    );
    assert!(has_note(&scene, "conductor"));
    // Texels of 128: metallic and roughness are half their factors.
    let pbr = json!({ "metallicFactor": 0.9, "metallicRoughnessTexture": { "index": 0 } });
    let (mixed, _, scene) = mapped(json!({ "pbrMetallicRoughness": pbr }));
    let Bsdf::Plastic { alpha, .. } = mixed.bsdf else {
        panic!("plastic")
    };
    assert!((alpha - (128.0_f32 / 255.0).powi(2)).abs() < 1e-5);
    assert!(has_note(&scene, "becomes its mean"));
}

#[test]
fn extensions_of_materials_are_mapped_or_named() {
    let pbr = json!({ "metallicFactor": 0, "roughnessFactor": 0 });
    let with = |extensions: Value| {
        mapped(json!({ "pbrMetallicRoughness": pbr, "extensions": extensions }))
    };
    let (glass, _, _) = with(
        json!({ "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1.3 } }),
    );
    assert!(matches!(
        glass.bsdf,
        Bsdf::Dielectric {
            ior: 1.3,
            thin: true,
            roughness: None,
            ..
        }
    ));
    let (thick, _, _) = with(json!({
        "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_volume": { "thicknessFactor": 1 },
    }));
    let clear = |bsdf: &Bsdf| {
        matches!(
            bsdf,
            Bsdf::Dielectric {
                thin: false,
                roughness: None,
                ..
            }
        )
    };
    assert!(clear(&thick.bsdf));
    let rough = json!({ "metallicFactor": 0, "roughnessFactor": 0.5 });
    let (frosted, _, _) = mapped(json!({
        "pbrMetallicRoughness": rough,
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 1 },
        },
    }));
    let Bsdf::Dielectric { roughness, .. } = frosted.bsdf else {
        panic!("glass")
    };
    assert_eq!(roughness.map(|r| r.alpha), Some(0.25));
    let (unlit, _, _) = with(json!({ "KHR_materials_unlit": {} }));
    assert!(matches!(unlit.bsdf, Bsdf::Diffuse { .. }));
    let (coated, _, scene) = with(json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1 } }));
    assert!(matches!(coated.bsdf, Bsdf::Plastic { alpha: 0.0, .. }));
    assert!(has_note(&scene, "KHR_materials_clearcoat is left out"));
    let (dull, _, _) = with(
        json!({ "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 0.5, 0] } }),
    );
    assert!(matches!(
        dull.bsdf,
        Bsdf::Plastic {
            specular: [0.5, 0.25, 0.0],
            ..
        }
    ));
    let glossy = |diffuse: f32| {
        let values = json!({
            "diffuseFactor": [diffuse, 0, 0, 1],
            "specularFactor": [0.04, 0.04, 0.04],
            "glossinessFactor": 0.5,
        });
        json!({ "KHR_materials_pbrSpecularGlossiness": values })
    };
    let (plastic, _, _) = with(glossy(0.5));
    let Bsdf::Plastic { ior, alpha, .. } = plastic.bsdf else {
        panic!("plastic")
    };
    assert!((ior - 1.5).abs() < 1e-5 && alpha == 0.25);
    assert!(matches!(with(glossy(0.0)).0.bsdf, Bsdf::Conductor { .. }));
}

#[test]
fn emission_is_factor_times_strength_times_mean() {
    let strong = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 10 } });
    let (_, shape, scene) = mapped(json!({ "emissiveFactor": [1, 0.5, 0], "extensions": strong }));
    assert_eq!(shape.emission, Some([10.0, 5.0, 0.0]));
    assert!(scene.environment.is_none());
    let (_, shape, scene) =
        mapped(json!({ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } }));
    let emission = shape.emission.expect("shines");
    assert!((emission[0] - 0.215_861).abs() < 1e-5, "{emission:?}");
    assert!(has_note(&scene, "emissiveTexture"));
    assert!(
        mapped(json!({ "emissiveTexture": { "index": 0 } }))
            .1
            .emission
            .is_none()
    );
}

/// The texture of the colour of the first shape.
fn colour_texture(file: &File) -> Texture {
    let scene = file.load().expect("loads");
    let material = &scene.materials[scene.shapes[0].material];
    let Bsdf::Plastic {
        diffuse: ColourSource::Texture(index),
        ..
    } = material.bsdf
    else {
        panic!("a texture")
    };
    Texture::load(&scene.textures[index]).expect("decodes")
}

const CORNERS: [[u8; 4]; 4] = [
    [255, 0, 0, 255],
    [0, 255, 0, 255],
    [0, 0, 255, 255],
    [255, 255, 255, 0],
];

fn textured(extra: Value) -> File {
    let mut info = json!({ "index": 0 });
    info["extensions"] = extra;
    let pbr =
        json!({ "metallicFactor": 0, "baseColorTexture": info, "baseColorFactor": [0.5, 1, 1, 1] });
    file(json!({ "pbrMetallicRoughness": pbr }), CORNERS)
}

#[test]
fn colours_come_from_texture_and_factor() {
    let texture = colour_texture(&textured(json!({})));
    // glTF's (0, 0) is the top left texel; ours has v upwards.
    assert_eq!(texture.lookup(Vec2::new(0.1, 0.9)), [0.5, 0.0, 0.0]);
    assert_eq!(texture.lookup(Vec2::new(0.9, 0.9)), [0.0, 1.0, 0.0]);
    assert_eq!(texture.lookup(Vec2::new(0.1, 0.1)), [0.0, 0.0, 1.0]);
    let scene = textured(json!({})).load().expect("loads");
    assert!(scene.textures[0].nearest && scene.textures[0].wrap == Wrap::Clamp);
}

/// The formula of `KHR_texture_transform`, in glTF's coordinates.
#[test]
fn textures_are_scaled_turned_and_moved() {
    let (offset, turn, scale) = ([0.3_f32, -0.2], 0.6_f32, [0.8_f32, 1.3]);
    let transform = json!({ "offset": offset, "rotation": turn, "scale": scale });
    let moved = colour_texture(&textured(json!({ "KHR_texture_transform": transform })));
    let plain = colour_texture(&textured(json!({})));
    for i in 0..100 {
        let [u, v] = [i % 10, i / 10].map(|k| k as f32 * 0.1 + 0.05);
        let (x, y) = (u * scale[0], v * scale[1]);
        let (sine, cosine) = turn.sin_cos();
        let there = [
            cosine * x + sine * y + offset[0],
            -sine * x + cosine * y + offset[1],
        ];
        let expected = plain.lookup(Vec2::new(there[0], 1.0 - there[1]));
        assert_eq!(moved.lookup(Vec2::new(u, 1.0 - v)), expected, "{u} {v}");
    }
}

#[test]
fn alpha_is_cut_off_or_a_chance() {
    let with = |mode: &str, factor: f32| {
        let pbr =
            json!({ "baseColorTexture": { "index": 0 }, "baseColorFactor": [1, 1, 1, factor] });
        let scene = file(
            json!({ "pbrMetallicRoughness": pbr, "alphaMode": mode }),
            CORNERS,
        );
        let scene = scene.load().expect("loads");
        let Some(ColourSource::Texture(index)) = scene.materials[0].opacity else {
            panic!("a texture")
        };
        let texture = Texture::load(&scene.textures[index]).expect("decodes");
        [Vec2::new(0.1, 0.9), Vec2::new(0.9, 0.1)].map(|uv| texture.lookup(uv)[0])
    };
    assert_eq!(with("MASK", 0.5), [1.0, 0.0]);
    assert_eq!(with("MASK", 0.4), [0.0, 0.0]);
    assert_eq!(with("BLEND", 0.4), [0.4, 0.0]);
    let constant = |mode: &str| {
        mapped(json!({ "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.3] }, "alphaMode": mode })).0.opacity
    };
    assert_eq!(constant("OPAQUE"), None);
    for mode in ["MASK", "OPAQUE"] {
        let material = json!({ "alphaMode": mode, "alphaCutoff": -1 });
        let error = file(material, CORNERS).load().expect_err(mode);
        let expected = "material 0: alphaCutoff -1 is not a number of at least 0";
        assert!(error.contains(expected), "{error}");
    }
    assert_eq!(constant("MASK"), Some(ColourSource::Constant([0.0; 3])));
    assert_eq!(constant("BLEND"), Some(ColourSource::Constant([0.3; 3])));
}

#[test]
fn images_lie_in_buffers_too_and_damage_is_told_at_once() {
    let mut inside = textured(json!({}));
    let view = inside.view(&png(CORNERS));
    inside.set(
        "/images",
        json!([{ "bufferView": view, "mimeType": "image/png" }]),
    );
    assert_eq!(
        colour_texture(&inside).lookup(Vec2::new(0.1, 0.9)),
        [0.5, 0.0, 0.0]
    );
    let cut = view;
    inside.set(&format!("/bufferViews/{cut}/byteLength"), json!(20));
    assert!(inside.load().expect_err("damaged").contains("image 0"));
    let mut other = textured(json!({}));
    other.set("/images", json!([{ "uri": data_uri(b"RIFF....WEBPVP8 ") }]));
    assert!(
        other
            .load()
            .expect_err("WebP")
            .contains("image 0: is neither PNG nor JPEG")
    );
    other.set("/images", json!([{ "uri": "gone.png" }]));
    let scene = other
        .load()
        .expect("an absent texture is a matter of building");
    assert!(
        scene
            .require_files(lightbench::scene::Needs::ALL, false)
            .is_err()
    );
}

#[test]
fn second_sets_are_read_and_vertex_colours_named() {
    let mut file = textured(json!({ "KHR_texture_transform": { "texCoord": 1 } }));
    let uvs = file.accessor(&floats(&[0.5; 6]), FLOAT, "VEC2", 3);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(uvs));
    file.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(0));
    file.set("/meshes/0/primitives/0/attributes/_OWN", json!(0));
    let description = file.load().expect("loads");
    let scene = crate::reading::built(&description);
    assert_eq!(scene.uvs, [Vec2::splat(0.5); 3]);
    assert!(has_note(&description, "vertex colours") && has_note(&description, "TEXCOORD_0"));
}

#[test]
fn a_texture_without_coordinates_shows_one_texel() {
    let info = json!({ "index": 0 });
    let glossy = json!({ "diffuseTexture": info });
    for material in [
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": info } }),
        json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": glossy } }),
    ] {
        let mut file = file(material, CORNERS);
        let attributes = "/meshes/0/primitives/0/attributes";
        let positions = file
            .json
            .pointer(&format!("{attributes}/POSITION"))
            .cloned();
        file.set(attributes, json!({ "POSITION": positions }));
        let description = file.load().expect("loads");
        assert!(
            has_note(&description, "shows one texel"),
            "{:?}",
            description.notes
        );
        // glTF's (0, 0), whatever other shapes have.
        assert_eq!(crate::reading::built(&description).uvs, [Vec2::Y; 3]);
    }
}

#[test]
fn without_a_specular_part_nothing_coats_the_base() {
    let matt = json!({ "KHR_materials_specular": { "specularFactor": 0 } });
    let pbr = json!({ "metallicFactor": 0, "roughnessFactor": 0.5 });
    let (material, _, _) = mapped(json!({ "pbrMetallicRoughness": pbr, "extensions": matt }));
    assert!(matches!(material.bsdf, Bsdf::Diffuse { .. }));
}
