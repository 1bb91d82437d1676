//! Scenes without any light, under techniques that show nothing else: black images of a black reference, which every
//! gate on errors would let pass.
//!
//! They are refused while planning, by what the scene declares, and again once it is loaded, by what is left of it. A
//! scene that is meant to be black says so by a constant environment of no radiance, or by the map `black`; a map or a sky
//! that a factor of 0, or the lack of sun and sky, has put out is none.

use super::sequence::Sequence;
use crate::environment::{Environment, EnvironmentDescription};
use crate::scene::{Needs, Scene, SceneDescription};

/// What a technique shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    /// What it takes of scenes.
    pub needs: Needs,
    /// Path edges after the camera, where the scene says how many.
    pub max_depth: Option<u32>,
}

impl Shown {
    /// What a technique with this id and these needs shows of a scene.
    pub fn of(technique: &str, needs: Needs, scene: &SceneDescription) -> Self {
        let follows = ["path-tracing", "radiance"].contains(&technique);
        Self {
            needs,
            max_depth: follows.then_some(scene.max_depth),
        }
    }
}

/// Refuses a scene that declares nothing from which a technique takes light, in any frame.
///
/// # Errors
/// A sentence with advice.
pub(super) fn refuse_declared(
    shown: Shown,
    scene: &SceneDescription,
    sequence: &Sequence,
) -> Result<(), String> {
    let needs = shown.needs;
    let environment = scene.environment.as_ref().filter(|_| needs.environment);
    if !takes_light(needs) || environment.is_some_and(is_meant_black) {
        return Ok(());
    }
    let lamps = match needs.emitters {
        true => Lamps::of(scene, sequence),
        false => Lamps::default(),
    };
    let seen = environment.is_some_and(shines) || lamps.shapes;
    if !seen && !lamps.points {
        return Err(refusal(&scene.name));
    }
    let name = &scene.name;
    match shown.max_depth {
        Some(0) => Err(format!(
            "scene `{name}`: paths of no edge (max_depth = 0) show nothing: set max_depth to 1 or more"
        )),
        Some(1) if !seen => Err(format!(
            "scene `{name}`: paths of one edge (max_depth = 1) show what shines alone, and its lights have no extent, so that \
             all images are black: set max_depth to 2 or more"
        )),
        _ => Ok(()),
    }
}

/// Refuses a loaded scene in which nothing that shines has an area or a strength.
///
/// # Errors
/// As [`refuse_declared`].
pub(super) fn refuse_loaded(needs: Needs, scene: &Scene) -> Result<(), String> {
    let mut shapes = scene.shapes.iter();
    let shines =
        shapes.any(|shape| shape.triangle_count > 0 && shape.emission.is_some_and(is_bright));
    let black_file = scene.environment.as_ref().and_then(Environment::black_file);
    let is_lit = !takes_light(needs)
        || scene.environment.is_some() && black_file.is_none()
        || shines
        || !scene.point_lights.is_empty()
        || !scene.directional_lights.is_empty();
    match black_file {
        _ if is_lit => Ok(()),
        Some(file) => Err(format!(
            "{}: every pixel of this map is black; {}",
            file.display(),
            refusal(&scene.name)
        )),
        None => Err(refusal(&scene.name)),
    }
}

/// Whether an environment without radiance is so by what it is called or given, and not by a factor.
fn is_meant_black(environment: &EnvironmentDescription) -> bool {
    match environment {
        EnvironmentDescription::Constant { radiance } => !is_bright(*radiance),
        EnvironmentDescription::Embedded { name, .. } => name == "black",
        EnvironmentDescription::Map { .. } | EnvironmentDescription::SunSky { .. } => false,
    }
}

/// Whether factors leave an environment any light.
fn shines(environment: &EnvironmentDescription) -> bool {
    match environment {
        EnvironmentDescription::Constant { radiance } => is_bright(*radiance),
        EnvironmentDescription::Map { scale, .. }
        | EnvironmentDescription::Embedded { scale, .. } => *scale > 0.0,
        EnvironmentDescription::SunSky {
            sun,
            sun_irradiance,
            sky,
            scale,
            ..
        } => *scale > 0.0 && (*sky || *sun && sun_irradiance.is_none_or(is_bright)),
    }
}

fn takes_light(needs: Needs) -> bool {
    needs.environment || needs.emitters
}

fn is_bright(rgb: [f32; 3]) -> bool {
    rgb.iter().any(|value| *value > 0.0)
}

fn refusal(name: &str) -> String {
    format!(
        "scene `{name}` has no light, so that all images of this technique are black: give it a light or an \
         environment, for example environment = \"afternoon\" (`lightbench list maps` shows them); if it is meant \
         to be black, environment = \"black\" says so"
    )
}

/// What shines besides the environment, in any frame.
#[derive(Clone, Copy, Debug, Default)]
struct Lamps {
    /// Shapes, which are seen.
    shapes: bool,
    /// Lights without extent, of which only what they light is seen.
    points: bool,
}

impl Lamps {
    fn of(scene: &SceneDescription, sequence: &Sequence) -> Self {
        let shapes = scene.shapes.iter().enumerate();
        let shapes = shapes.filter(|(_, shape)| shape.emission.is_some_and(is_bright));
        let mut shapes = shapes.map(|(index, _)| index);
        let lights = scene.lights.iter().enumerate();
        let lights = lights.filter(|(_, light)| is_bright(*light.kind.strength()));
        let mut lights = lights.map(|(index, _)| index);
        let is_on = |moved: &dyn Fn(usize) -> bool| {
            let moving = (0..scene.motions.len()).filter(|motion| moved(*motion));
            let strengths: Vec<_> = moving.flat_map(|m| &scene.motions[m].strength).collect();
            let at = |time_s| strengths.iter().all(|strength| strength.at(time_s) > 0.0);
            let mut times_s = sequence.frames.iter().map(|frame| sequence.time_s(*frame));
            times_s.any(at)
        };
        Self {
            shapes: shapes
                .any(|index| is_on(&|motion| scene.motions[motion].shapes.contains(&index))),
            points: lights
                .any(|index| is_on(&|motion| scene.motions[motion].lights.contains(&index))),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::experiment::{Loaded, Source, build_technique, plan};

    const VIEW: &str = "[[view]]\norigin = [3, 2, 5]\ntarget = [0, 0.5, 0]\nfov_deg = 45\n";
    const FLOOR: &str = "[[shape]]\nkind = \"rectangle\"\nrotate = [1, 0, 0, -90]\nscale = 10\n";

    /// What planning says of a scene under a technique, and loading of what was planned.
    fn tried(scene: &str, technique: &str, more: &str) -> Result<(), String> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("room.toml");
        std::fs::write(&file, format!("{VIEW}{scene}")).expect("writable");
        let line = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
        std::fs::write(folder.path().join("line.obj"), line).expect("writable");
        let budget = match technique {
            "ambient-occlusion" => "caches = 10\n[[method]]\nid = \"IM\"",
            "environment-lighting" => "lights = 4\n[[method]]\nid = \"mis\"",
            "irradiance-caching" | "importance-caching" => "caches = 10\n[[method]]\nid = \"IM\"",
            "direct-lighting" => "samples = 1\n[[method]]\nid = \"rt\"",
            "radiance" | "path-tracing" => "samples = 1\n[[method]]\nid = \"paths\"",
            other => panic!("{other}"),
        };
        let text = format!(
            "name = \"t\"\ntechnique = \"{technique}\"\nsize = [8, 6]\n{budget}\n[[scene]]\nname = {:?}\n{more}",
            file.display().to_string()
        );
        let source = Source {
            file: Path::new("c.toml").into(),
            text,
        };
        let (_, plan) = plan(&source, &[]).map_err(|error| error.to_string())?;
        let technique = build_technique(&plan.jobs[0]).map_err(|error| error.to_string())?;
        let loaded = Loaded::new(&plan.jobs[0], technique.as_ref());
        loaded.map(drop).map_err(|e| format!("loading: {e}"))
    }

    #[test]
    fn a_scene_without_light_is_refused_where_light_is_shown() {
        let lit = [
            "path-tracing",
            "direct-lighting",
            "radiance",
            "irradiance-caching",
            "importance-caching",
        ];
        for technique in lit {
            let error = tried(FLOOR, technique, "").expect_err(technique);
            assert!(error.starts_with("c.toml:8:1: "), "{technique}: {error}");
            assert!(error.contains("has no light"), "{technique}: {error}");
            assert!(error.contains("environment = \"black\""), "{error}");
            tried(FLOOR, technique, "environment = \"black\"").expect("meant to be black");
            tried(&format!("{FLOOR}emission = [1, 1, 1]\n"), technique, "").expect("a lamp");
        }
        tried(FLOOR, "ambient-occlusion", "").expect("needs no light");
    }

    #[test]
    fn environments_that_factors_put_out_are_no_light() {
        let tried = |environment: &str, more: &str| {
            let scene = format!("environment = {environment}\n{FLOOR}{more}");
            // Keys of the scene stand before its tables.
            let folder = tempfile::tempdir().expect("a folder");
            let file = folder.path().join("room.toml");
            let (head, shapes) = scene.split_once('\n').expect("two parts");
            std::fs::write(&file, format!("{head}\n{VIEW}{shapes}")).expect("writable");
            let map = crate::image::Image {
                width: 2,
                height: 1,
                pixels: vec![[1.0; 3]; 2],
            };
            crate::image::write_png(&folder.path().join("m.png"), &map, 0.0).expect("writable");
            let text = format!(
                "name = \"t\"\ntechnique = \"path-tracing\"\nsize = [8, 6]\nsamples = 1\n[[method]]\nid = \"paths\"\n[[scene]]\nname = {:?}\n",
                file.display().to_string()
            );
            let file = Path::new("c.toml").into();
            let plan = plan(&Source { file, text }, &[]);
            plan.map(drop).map_err(|error| error.to_string())
        };
        for black in [
            "{ kind = \"sky\", sun = false, sky = false }",
            "{ kind = \"sky\", scale = 0 }",
            "{ kind = \"map\", path = \"m.png\", scale = 0 }",
        ] {
            let error = tried(black, "").expect_err(black);
            assert!(error.contains("has no light"), "{error}");
            tried(black, "emission = [1, 1, 1]\n").expect("a lamp");
        }
        tried("{ kind = \"constant\", radiance = 0 }", "").expect("meant to be black");
        tried("{ kind = \"sky\", sun = false }", "").expect("a sky");
    }

    #[test]
    fn paths_that_are_too_short_for_any_light_are_refused() {
        let point = "[[light]]\nkind = \"point\"\nposition = [0, 2, 0]\nintensity = 1\n";
        let lit = format!("{FLOOR}{point}");
        let lamp = format!("{FLOOR}emission = 1\n");
        for technique in ["path-tracing", "radiance"] {
            let error = tried(&lit, technique, "max_depth = 1").expect_err("a point");
            assert!(error.contains("max_depth to 2"), "{error}");
            tried(&lit, technique, "max_depth = 2").expect("a lit floor");
            tried(&lamp, technique, "max_depth = 1").expect("a lamp");
            let error = tried(&lamp, technique, "max_depth = 0").expect_err("nothing");
            assert!(error.contains("max_depth"), "{error}");
        }
        tried(&lit, "direct-lighting", "max_depth = 1").expect("takes no depth");
    }

    #[test]
    fn lights_that_never_shine_are_none() {
        let lamp = |strength: u32| {
            format!(
                "[[light]]\nkind = \"point\"\nposition = [0, 2, 0]\nintensity = [{strength}, 0, 0]\nname = \"lamp\"\n"
            )
        };
        let tried = |scene: &str, more: &str| tried(scene, "path-tracing", more);
        tried(&format!("{FLOOR}{}", lamp(1)), "").expect("a lamp");
        tried(&format!("{FLOOR}{}", lamp(0)), "").expect_err("off");
        tried(&format!("{FLOOR}emission = [0, 0, 0]\n"), "").expect_err("off");
        // On from the third second on.
        let keys = "keys = [{ time = 0, on = false }, { time = 3, on = true }]";
        let late = format!(
            "{FLOOR}{}[[motion]]\nlights = [\"lamp\"]\n{keys}\n",
            lamp(1)
        );
        tried(&late, "[sequence]\nframes = 5\nfps = 1").expect("on in the end");
        tried(&late, "[sequence]\nframes = 2\nfps = 1").expect_err("off until then");
    }

    #[test]
    fn maps_without_a_bright_texel_are_found_when_loading() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("map.png");
        let mut map = crate::image::Image::new(4, 2);
        let environment = format!("environment = {:?}\n", file.display().to_string());
        let try_map = |map: &crate::image::Image, scene: &str| {
            crate::image::write_png(&file, map, 1.0).expect("writable");
            tried(scene, "path-tracing", &environment)
        };
        let error = try_map(&map, FLOOR).expect_err("black");
        assert!(
            error.contains("map.png: every pixel of this map is black"),
            "{error}"
        );
        try_map(&map, &format!("{FLOOR}emission = [1, 1, 1]\n")).expect("a lamp");
        map.pixels[3] = [1.0; 3];
        try_map(&map, FLOOR).expect("a bright texel");
    }

    /// What is no number or below 0 becomes 0.
    #[test]
    fn maps_without_a_usable_texel_are_found_when_loading() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("map.exr");
        let environment = format!("environment = {:?}\n", file.display().to_string());
        let mut map = crate::image::Image::new(4, 2);
        map.pixels.fill([f32::NAN, -1.0, f32::INFINITY]);
        let mut try_map = |lonely: [f32; 3]| {
            map.pixels[3] = lonely;
            let layer = crate::image::Layer::color("", map.clone());
            let written = crate::image::write_exr(&file, &[layer], &Default::default());
            written.expect("writable");
            tried(FLOOR, "path-tracing", &environment)
        };
        let error = try_map([f32::NAN; 3]).expect_err("black");
        assert!(
            error.contains("map.exr: every pixel of this map is black"),
            "{error}"
        );
        try_map([0.0, 1.0, f32::NAN]).expect("a bright texel");
    }

    #[test]
    fn lamps_without_an_area_are_found_when_loading() {
        let line = "[[shape]]\nkind = \"obj\"\npath = \"line.obj\"\nemission = [1, 1, 1]\n";
        let error = tried(&format!("{FLOOR}{line}"), "path-tracing", "").expect_err("flat");
        assert!(
            error.starts_with("loading: ") && error.contains("has no light"),
            "{error}"
        );
    }
}
