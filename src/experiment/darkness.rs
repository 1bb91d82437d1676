//! Scenes without any light, under techniques that show nothing else: black images of a black reference, which every
//! gate on errors would let pass.
//!
//! They are refused while planning, by what the scene declares, and again once it is loaded, by what is left of it. A
//! scene that is meant to be black says so by an environment of no radiance, such as the map `black`.

use super::sequence::Sequence;
use crate::environment::Environment;
use crate::scene::{Needs, Scene, SceneDescription};

/// Refuses a scene that declares nothing from which a technique with these needs takes light, in any frame.
///
/// # Errors
/// A sentence with advice.
pub(super) fn refuse_declared(
    needs: Needs,
    scene: &SceneDescription,
    sequence: &Sequence,
) -> Result<(), String> {
    let is_lit = !takes_light(needs)
        || needs.environment && scene.environment.is_some()
        || needs.emitters && has_lamp(scene, sequence);
    refuse(is_lit, &scene.name)
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
    refuse(is_lit, &scene.name).map_err(|why| match black_file {
        Some(file) => format!(
            "{}: every pixel of this map is black; {why}",
            file.display()
        ),
        None => why,
    })
}

fn takes_light(needs: Needs) -> bool {
    needs.environment || needs.emitters
}

fn is_bright(rgb: [f32; 3]) -> bool {
    rgb.iter().any(|value| *value > 0.0)
}

fn refuse(is_lit: bool, name: &str) -> Result<(), String> {
    match is_lit {
        true => Ok(()),
        false => Err(format!(
            "scene `{name}` has no light, so that all images of this technique are black: give it a light or an \
             environment, for example environment = \"afternoon\" (`lightbench list maps` shows them); if it is meant \
             to be black, environment = \"black\" says so"
        )),
    }
}

/// Whether a shape or a light without extent shines in any frame.
fn has_lamp(scene: &SceneDescription, sequence: &Sequence) -> bool {
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
    shapes.any(|index| is_on(&|motion| scene.motions[motion].shapes.contains(&index)))
        || lights.any(|index| is_on(&|motion| scene.motions[motion].lights.contains(&index)))
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
