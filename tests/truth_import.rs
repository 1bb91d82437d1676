//! Small Mitsuba scenes whose light is known: what is imported shines and scatters as it must.

mod truth_support;

use std::path::Path;

use lightbench::scene::{Needs, Scene, find_scene};
use truth_support::small_render;

/// A camera far to the side that looks at the origin through a very narrow angle.
const SENSOR: &str = "<sensor type='perspective'><float name='fov' value='0.05'/>
    <transform name='to_world'><lookat origin='6, 2, 0' target='0, 0, 0' up='0, 1, 0'/></transform>
    <film type='hdrfilm'><integer name='width' value='4'/><integer name='height' value='4'/><rfilter type='box'/></film>
    </sensor>";

/// The same camera by the names of the old versions.
const OLD_SENSOR: &str = "<sensor type='perspective'><float name='fov' value='0.05'/>
    <transform name='toWorld'><lookAt origin='6 2 0' target='0 0 0' up='0 1 0'/></transform>
    <film type='hdrfilm'><integer name='width' value='4'/><integer name='height' value='4'/><rfilter type='box'/></film>
    </sensor>";

/// A horizontal white (0.5) plate about the origin, facing up.
const PLATE: &str = "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/><scale value='0.1'/></transform>
    <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>";

fn import(text: &str) -> Scene {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, text).expect("writable");
    load(&file)
}

fn load(file: &Path) -> Scene {
    let description = find_scene(&file.to_string_lossy()).expect("scene");
    Scene::build(&description, Needs::ALL).expect("scene")
}

/// Mean radiance at the origin, first channel, and its standard deviation.
fn seen(scene: &Scene, spp: u64) -> [f64; 2] {
    let rendering = small_render(scene, [4, 4], spp, scene.max_depth);
    let sum = |pixels: &[[f32; 3]]| pixels.iter().map(|p| f64::from(p[0])).sum::<f64>();
    let mean = sum(&rendering.mean.pixels) / 16.0;
    [mean, sum(&rendering.variance.pixels).sqrt() / 16.0]
}

fn assert_seen(text: &str, expected: f64, tolerance: f64) {
    let [found, sigma] = seen(&import(text), 512);
    assert!(
        (found - expected).abs() < 4.0 * sigma + tolerance * expected + 1e-6,
        "{found} ± {sigma}, expected {expected}: {text}"
    );
}

fn lit(version: &str, light: &str) -> String {
    let old = version.starts_with('0');
    let sensor = if old { OLD_SENSOR } else { SENSOR };
    let light = if old {
        light.replace("to_world", "toWorld")
    } else {
        light.to_owned()
    };
    format!("<scene version='{version}'><integrator type='direct'/>{sensor}{PLATE}{light}</scene>")
}

/// Radiance of the plate under a light of radiance 3 whose form factor from the origin is known.
fn from_form_factor(factor: f64) -> f64 {
    0.5 * 3.0 * factor
}

const EMITTER: &str = "<emitter type='area'><rgb name='radiance' value='3'/></emitter>";

#[test]
fn area_lights_of_every_shape_and_version() {
    // A disk of radius r at height h over the point: r² / (r² + h²).
    let disk = |scale: &str| {
        format!(
            "<shape type='disk'><transform name='to_world'>{scale}<rotate x='1' angle='90'/><translate y='2'/></transform>{EMITTER}</shape>"
        )
    };
    let expected = from_form_factor(0.25 / 4.25);
    for version in ["0.5.0", "0.6.0", "2.0.0", "3.0.0"] {
        assert_seen(&lit(version, &disk("<scale value='0.5'/>")), expected, 5e-3);
    }
    // Mirrors keep the emitting side; a light turned round is dark.
    let mirrored = disk("<scale x='-0.5' y='0.5' z='0.5'/>");
    assert_seen(&lit("3.0.0", &mirrored), expected, 5e-3);
    let turned = disk("<scale value='0.5'/><rotate x='1' angle='180'/>");
    assert_seen(&lit("3.0.0", &turned), 0.0, 0.0);
    // Two sides reflect but one alone emits.
    let two_sided = turned.replace(
        "</shape>",
        "<bsdf type='twosided'><bsdf type='diffuse'/></bsdf></shape>",
    );
    assert_seen(&lit("3.0.0", &two_sided), 0.0, 0.0);
    let flipped = turned.replace(
        "</shape>",
        "<boolean name='flip_normals' value='true'/></shape>",
    );
    assert_seen(&lit("3.0.0", &flipped), expected, 5e-3);
    // A sphere of radius r at distance h: r² / h².
    for sphere in [
        "<shape type='sphere'><point name='center' x='0' y='2' z='0'/><float name='radius' value='0.5'/>",
        "<shape type='sphere'><transform name='to_world'><scale value='0.5'/><translate y='2'/></transform>",
    ] {
        let light = format!("{sphere}{EMITTER}</shape>");
        assert_seen(&lit("0.6.0", &light), from_form_factor(0.0625), 5e-3);
    }
    // A square of half side a, centred at height h: 4/π · a / √(a² + h²) · atan(a / √(a² + h²)) · ½ · 2.
    let rectangle = format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='0.5'/><rotate x='1' angle='90'/><translate y='2'/></transform>{EMITTER}</shape>"
    );
    let slope = 0.5 / 4.25f64.sqrt();
    let factor = 4.0 / std::f64::consts::PI * slope * slope.atan();
    assert_seen(&lit("3.0.0", &rectangle), from_form_factor(factor), 1e-3);
}

/// Light through a pane or a mask between the eye and a sky of radiance 1.
#[test]
fn panes_and_masks_let_known_shares_pass() {
    let facing = "<transform name='to_world'><lookat origin='0, 0, 0' target='6, 2, 0' up='0, 1, 0'/></transform>";
    let scene = |integrator: &str, bsdf: &str| {
        format!(
            "<scene version='3.0.0'>{integrator}{SENSOR}<shape type='rectangle'>{facing}{bsdf}</shape>
             <emitter type='constant'><rgb name='radiance' value='1'/></emitter></scene>"
        )
    };
    let path = |depth: i32| {
        format!("<integrator type='path'><integer name='max_depth' value='{depth}'/></integrator>")
    };
    let pane = "<bsdf type='thindielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/><rgb name='specular_transmittance' value='0.5'/></bsdf>";
    // R' = 2R / (1 + R) with R = 0.04; the reflected sky counts too.
    let reflected = 0.08 / 1.04;
    for depth in [2, -1] {
        let expected = reflected + 0.5 * (1.0 - reflected);
        assert_seen(&scene(&path(depth), pane), expected, 1e-4);
    }
    assert_seen(&scene(&path(1), pane), 0.0, 0.0);
    let black = "<bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>";
    let mask = |opacity: &str| format!("<bsdf type='mask'>{opacity}{black}</bsdf>");
    let quarter = mask("<float name='opacity' value='0.25'/>");
    assert_seen(&scene(&path(2), &quarter), 0.75, 1e-4);
    // The centre of a 2×2 pattern is seen: half of it opaque.
    let checkered = mask(
        "<texture name='opacity' type='checkerboard'><rgb name='color0' value='1'/><rgb name='color1' value='0.5'/></texture>",
    );
    assert_seen(&scene(&path(2), &checkered), 0.25, 1e-2);
    let mirror = "<bsdf type='conductor'><string name='material' value='none'/><rgb name='specular_reflectance' value='0.6'/></bsdf>";
    assert_seen(&scene("<integrator type='direct'/>", mirror), 0.6, 1e-4);
    // ((n − 1)² + k²) / ((n + 1)² + k²) at normal incidence.
    let aluminium = "<bsdf type='conductor'><string name='material' value='Al'/></bsdf>";
    let (n, k) = (1.65746f64, 9.22387f64);
    let expected = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
    assert_seen(&scene(&path(2), aluminium), expected, 1e-4);
}

/// White plastics under a white sky lose only what single scattering loses: nothing when smooth, more
/// the rougher. The nonlinear one equals the linear one for white alone.
#[test]
fn plastics_of_any_index_and_roughness_conserve_energy() {
    let facing = "<transform name='to_world'><lookat origin='0, 0, 0' target='6, 2, 0' up='0, 1, 0'/></transform>";
    let albedo = |kind: &str, parameters: &str, reflectance: f64| {
        let text = format!(
            "<scene version='3.0.0'><integrator type='direct'/>{SENSOR}<shape type='rectangle'>{facing}
             <bsdf type='{kind}'>{parameters}<rgb name='diffuse_reflectance' value='{reflectance}'/></bsdf></shape>
             <emitter type='constant'><rgb name='radiance' value='1'/></emitter></scene>"
        );
        seen(&import(&text), 1024)[0]
    };
    let nonlinear = "<boolean name='nonlinear' value='true'/>";
    for ior in [1.3, 1.9] {
        let ior = format!("<float name='int_ior' value='{ior}'/><float name='ext_ior' value='1'/>");
        let smooth = albedo("plastic", &ior, 1.0);
        assert!((smooth - 1.0).abs() < 5e-3, "{ior}: {smooth}");
        for distribution in ["ggx", "beckmann"] {
            let mut last = smooth;
            for alpha in [0.02, 0.4] {
                let rough = format!(
                    "{ior}<float name='alpha' value='{alpha}'/><string name='distribution' value='{distribution}'/>"
                );
                let white = albedo("roughplastic", &rough, 1.0);
                assert!(white < last + 5e-3, "{rough}: {white} after {last}");
                assert!(alpha > 0.1 || white > 0.94, "{rough}: {white}");
                last = white;
                let shifted = albedo("roughplastic", &format!("{rough}{nonlinear}"), 1.0);
                assert!((shifted - white).abs() < 5e-3, "{rough}: {shifted} {white}");
                // Internal scattering darkens what is not white.
                let grey = albedo("roughplastic", &rough, 0.5);
                let darker = albedo("roughplastic", &format!("{rough}{nonlinear}"), 0.5);
                assert!(darker < grey && grey < white, "{rough}: {darker} {grey}");
            }
        }
    }
}
