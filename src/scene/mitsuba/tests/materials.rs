//! Materials and textures.

use super::*;

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
            nonlinear: true,
            lossless: false,
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
        "<bsdf type='hair'><float name='eumelanin' value='1'/></bsdf>",
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
fn blends_of_constant_diffuse_materials_are_their_mean() {
    let blend = |weight: &str, second: &str| {
        material(
            "3.0.0",
            &format!(
                "<bsdf type='blendbsdf'>{weight}<bsdf type='diffuse'><rgb name='reflectance' value='0.9 0.1 0.1'/></bsdf>{second}</bsdf>"
            ),
        )
    };
    let diffuse = "<bsdf type='diffuse'><rgb name='reflectance' value='0.1 0.1 0.9'/></bsdf>";
    let (mixed, notes) = blend("<float name='weight' value='0.75'/>", diffuse);
    let Bsdf::Diffuse {
        reflectance: ColourSource::Constant(mean),
    } = mixed.bsdf
    else {
        panic!("{mixed:?}");
    };
    for (found, expected) in mean.iter().zip([0.3, 0.1, 0.7]) {
        assert!((found - expected).abs() < 1e-6, "{mean:?}");
    }
    assert!(notes.is_empty(), "{notes:?}");
    // A half of the same, and a half of it with a half of grey.
    let grey = "<bsdf type='diffuse'><rgb name='reflectance' value='0.5 0.5 0.5'/></bsdf>";
    let inner =
        format!("<bsdf type='blendbsdf'><float name='weight' value='0.5'/>{diffuse}{grey}</bsdf>");
    let (mixed, notes) = blend("<float name='weight' value='0.5'/>", &inner);
    let Bsdf::Diffuse {
        reflectance: ColourSource::Constant(mean),
    } = mixed.bsdf
    else {
        panic!("{mixed:?}");
    };
    for (found, expected) in mean.iter().zip([0.6, 0.2, 0.4]) {
        assert!((found - expected).abs() < 1e-6, "{mean:?}");
    }
    assert!(notes.is_empty(), "{notes:?}");
    let (blended, notes) = blend(
        "<float name='weight' value='0.75'/>",
        "<bsdf type='plastic'/>",
    );
    let share = ColourSource::Constant([0.75; 3]);
    assert!(blended.blend.is_some_and(|blend| blend.second == share));
    assert!(notes.is_empty(), "{notes:?}");
}

/// A mixture of version 0.6 with these weights.
fn mixture(weights: &str, parts: &str) -> String {
    format!("<bsdf type='mixturebsdf'><string name='weights' value='{weights}'/>{parts}</bsdf>")
}

#[test]
fn mixtures_are_nested_blends_that_lose_what_their_weights_lack() {
    let parts = "<bsdf type='plastic'/><bsdf type='diffuse'/><bsdf type='roughconductor'/>";
    let text = mixture("0.2, 0.3, 0.4", parts);
    let scene = load("0.6.0", &format!("<shape type='cube'>{text}</shape>"));
    assert!(
        scene.notes.iter().all(|n| n.contains("copper")),
        "{:?}",
        scene.notes
    );
    // The chances along the chain: 0.2, of the rest 3/8, of that 4/5, and the last is black.
    let mut at = scene.shapes[0].material;
    let mut chances = Vec::new();
    while let Some(blend) = scene.materials[at].blend {
        let ColourSource::Constant([share, ..]) = blend.second else {
            panic!("{blend:?}");
        };
        chances.push(1.0 - share);
        at = blend.materials[1];
    }
    let expected = [0.2, 3.0 / 8.0, 4.0 / 5.0];
    assert_eq!(chances.len(), 3);
    for (found, expected) in chances.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6, "{chances:?}");
    }
    let black = Bsdf::Diffuse {
        reflectance: ColourSource::Constant([0.0; 3]),
    };
    assert_eq!(scene.materials[at].bsdf, black);
}

#[test]
fn mixtures_of_diffuse_materials_are_their_weighted_sum() {
    let diffuse = "<bsdf type='diffuse'><rgb name='reflectance' value='0.8 0.4 0.2'/></bsdf>";
    let two = format!("{diffuse}<bsdf type='diffuse'/>");
    for (weights, expected, told) in [
        ("0.5 0.25", [0.525, 0.325, 0.225], 0),
        ("1 3", [0.575, 0.475, 0.425], 1),
        ("1 0", [0.8, 0.4, 0.2], 0),
    ] {
        let (mixed, notes) = material("0.6.0", &mixture(weights, &two));
        let Bsdf::Diffuse {
            reflectance: ColourSource::Constant(sum),
        } = mixed.bsdf
        else {
            panic!("{mixed:?}");
        };
        for (found, expected) in sum.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{weights}: {sum:?}");
        }
        assert_eq!(notes.len(), told, "{notes:?}");
    }
    // Of one that weighs all nothing else is met.
    let (alone, notes) = material(
        "0.6.0",
        &mixture("1 0", "<bsdf type='plastic'/><bsdf type='diffuse'/>"),
    );
    assert!(
        matches!(alone.bsdf, Bsdf::Plastic { .. }) && alone.blend.is_none() && notes.is_empty()
    );
}

#[test]
fn weights_that_cannot_be_are_refused() {
    let parts = "<bsdf type='plastic'/><bsdf type='diffuse'/>";
    for (weights, expected) in [
        ("0.5", "2 materials and 1 weights"),
        ("0.5 -0.1", "must not be below 0"),
        ("0 0", "a sum above 0"),
        ("0.5 x", "`x`"),
        ("inf 1", "below 0"),
    ] {
        let text = format!("<shape type='cube'>{}</shape>", mixture(weights, parts));
        let error = try_load("0.6.0", &text).unwrap_err();
        assert!(error.contains(expected), "{weights}: {error}");
    }
}

#[test]
fn scales_around_textures_are_factors() {
    let bitmap = "<texture type='bitmap' id='t'><string name='filename' value='a.png'/></texture>";
    let scale = "<texture name='reflectance' type='scale'><rgb name='scale' value='0.5 0.25 1'/><ref id='t'/></texture>";
    let scene = load(
        "0.6.0",
        &format!(
            "{bitmap}<shape type='cube'><bsdf type='diffuse'>{scale}</bsdf></shape><shape type='cube'><bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf></shape>"
        ),
    );
    let factor = |i: usize| match scene.materials[scene.shapes[i].material].bsdf {
        Bsdf::Diffuse {
            reflectance: ColourSource::Texture(texture),
        } => scene.textures[texture].factor,
        ref other => panic!("{other:?}"),
    };
    assert_eq!([factor(0), factor(1)], [[0.5, 0.25, 1.0], [1.0; 3]]);
}

#[test]
fn textures_are_turned_by_their_transforms() {
    let texture = |transform: &str| {
        let transform = format!("<transform name='to_uv'>{transform}</transform>");
        let texture = format!(
            "<texture name='reflectance' type='bitmap'><string name='filename' value='a.png'/>{transform}</texture>"
        );
        let scene = load(
            "3.0.0",
            &format!("<shape type='cube'><bsdf type='diffuse'>{texture}</bsdf></shape>"),
        );
        (scene.textures[0].clone(), scene.notes)
    };
    let (turned, notes) =
        texture("<scale x='2' y='3'/><rotate z='1' angle='30'/><translate x='0.1' y='0.2'/>");
    assert!(notes.is_empty(), "{notes:?}");
    let at = |t: &crate::scene::TextureDescription, uv: [f32; 2]| {
        let scaled = glam::Vec2::from(uv) * glam::Vec2::from(t.uv_scale)
            + glam::Vec2::new(t.uv_shear * uv[1], 0.0);
        let turn = glam::Vec2::from_angle(t.uv_turn_rad);
        turn.rotate(scaled) + glam::Vec2::from(t.uv_offset)
    };
    for [u, v] in [[0.1_f32, 0.1], [0.7, 0.2], [0.3, 0.9]] {
        // In Mitsuba, with v downwards: scale, turn, shift.
        let (sine, cosine) = 30.0_f32.to_radians().sin_cos();
        let (x, y) = (2.0 * u, 3.0 * v);
        let expected = [
            cosine * x - sine * y + 0.1,
            1.0 - (sine * x + cosine * y + 0.2),
        ];
        let found = at(&turned, [u, 1.0 - v]);
        assert!(
            found.distance(expected.into()) < 1e-5,
            "{found} {expected:?}"
        );
    }
    let (sheared, notes) = texture("<matrix value='2 0.5 0 0.1 -1 3 0 0.2 0 0 1 0 0 0 0 1'/>");
    assert!(notes.is_empty(), "{notes:?}");
    for [u, v] in [[0.1_f32, 0.1], [0.7, 0.2], [0.3, 0.9]] {
        let expected = [2.0 * u + 0.5 * v + 0.1, 1.0 - (-u + 3.0 * v + 0.2)];
        let found = at(&sheared, [u, 1.0 - v]);
        assert!(
            found.distance(expected.into()) < 1e-5,
            "{found} {expected:?}"
        );
    }
    // Mitsuba 3.9.1 moves by the fourth column alone.
    let (nine, notes) = texture("<matrix value='2 0 0.25 0 3 0.5 0 0 1'/>");
    assert!(at(&nine, [0.0, 1.0]).distance(glam::Vec2::Y) < 1e-6);
    assert_eq!(notes.len(), 1);
}

#[test]
fn bent_normals_are_softened_where_the_file_says_nothing() {
    let bump = |inner: &str| {
        let texture = "<texture type='bitmap'><string name='filename' value='a.png'/></texture>";
        material(
            "3.0.0",
            &format!("<bsdf type='bumpmap'>{texture}{inner}<bsdf type='diffuse'/></bsdf>"),
        )
    };
    assert!(bump("").0.soft_terminators);
    assert!(
        !bump("<boolean name='use_shadowing_function' value='false'/>")
            .0
            .soft_terminators
    );
    let (_, notes) = bump("<boolean name='flip_invalid_normals' value='false'/>");
    assert_eq!(notes.len(), 1);
    let message = error(&format!(
        "{SENSOR}<shape type='cube'><bsdf type='bumpmap'><bsdf type='diffuse'/></bsdf></shape>"
    ));
    assert!(
        message.contains("`bumpmap` needs a texture inside"),
        "{message}"
    );
}

#[test]
fn reflectances_out_of_range_are_clamped() {
    let (material, notes) = material(
        "3.0.0",
        "<bsdf type='diffuse'><rgb name='reflectance' value='1.4 0.3 -0.2'/></bsdf>",
    );
    let Bsdf::Diffuse { reflectance } = material.bsdf else {
        panic!("not diffuse");
    };
    assert_eq!(reflectance, ColourSource::Constant([1.0, 0.3, 0.0]));
    assert_eq!(
        notes,
        ["`reflectance` of diffuse is out of range and clamped to [0, 1]"]
    );
}

#[test]
fn colours_that_vertices_do_not_have_are_told() {
    let scene = load(
        "3.0.0",
        "<shape type='cube'><bsdf type='diffuse'><texture name='reflectance' type='mesh_attribute'/></bsdf></shape>",
    );
    let built = crate::scene::Scene::build(&scene, crate::scene::Needs::ALL).unwrap();
    let told = "`cube 0` has no colours of vertices, which its material asks for";
    let notes = built.report.notes;
    assert!(notes.iter().any(|note| note.contains(told)), "{notes:?}");
}

#[test]
fn each_side_may_have_its_material() {
    let scene = load(
        "3.0.0",
        "<shape type='cube'><bsdf type='mask'><float name='opacity' value='0.25'/><bsdf type='twosided'>
           <bsdf type='diffuse'><rgb name='reflectance' value='0.8'/></bsdf>
           <bsdf type='diffuse'><rgb name='reflectance' value='0.1'/></bsdf></bsdf></bsdf></shape>",
    );
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
    let front = &scene.materials[scene.shapes[0].material];
    let back = &scene.materials[front.back.expect("another behind")];
    for (side, grey) in [(front, 0.8), (back, 0.1)] {
        let reflectance = ColourSource::Constant([grey; 3]);
        assert_eq!(side.bsdf, Bsdf::Diffuse { reflectance });
        assert_eq!(side.opacity, Some(ColourSource::Constant([0.25; 3])));
        assert!(side.two_sided);
    }
}
