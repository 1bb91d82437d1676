//! Facing (a worked example): how much the surface at a pixel faces the camera, from 0 to 1, the mean over the pixel.

use glam::Vec3;

use super::{
    Contender, ContenderEntry, Passes, Rendered, SAMPLES, ShadingFunction, Shot, Started,
    Technique, TechniqueEntry, Terms, each_pixel,
};
use crate::entry::{About, Bias, ParameterError, check_keys};
use crate::scene::{Needs, Scene};
use crate::suggest::advice;
use crate::trace::{Caster, RayCounter};

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "facing",
        module: crate::entry::head_comment!("example_technique.rs"),
        aliases: &[],
        summary: "how much surfaces face the camera",
        source: "docs/adding.md",
        bias: Bias::Exact,
        version: 1,
        failures: &[],
        parameters: &[],
    },
    build: |table| {
        check_keys(table, &[])?;
        Ok(Box::new(Facing))
    },
    contenders: || CONTENDERS.iter().map(ContenderEntry::listed).collect(),
    units: &[&SAMPLES],           // What its contenders can share an amount of.
    default_method: "one-sample", // Of `lightbench render --technique facing`.
    of_contenders: &[],           // Parameters that the reference does not depend on.
};

/// What it compares.
static CONTENDERS: &[ContenderEntry<Facing>] = &[ONE_SAMPLE];

struct Facing;

impl Technique for Facing {
    /// Nothing else is read of a scene: no materials, no lights.
    fn needs(&self) -> Needs {
        Needs::GEOMETRY
    }

    fn shading_function<'a>(&'a self, shot: &'a Shot<'a>) -> Box<dyn ShadingFunction + 'a> {
        Box::new(Seen(shot))
    }

    fn exposure_stops(&self, _: &Scene) -> f32 {
        0.0
    }

    fn reference_samples(&self, spp: u32) -> u32 {
        spp
    }

    fn reference_is_random(&self) -> bool {
        false
    }

    fn rays_per_evaluation(&self) -> u64 {
        1
    }

    fn start<'a>(
        &'a self,
        id: &str,
        parameters: &toml::Table,
        terms: Terms,
    ) -> Result<Started<'a>, ParameterError> {
        match CONTENDERS.iter().find(|entry| entry.about.answers_to(id)) {
            Some(entry) => entry.started(self, parameters, terms),
            None => {
                let known: Vec<&str> = CONTENDERS.iter().map(|entry| entry.about.id).collect();
                let message = format!("no contender is called `{id}`; {}", advice(id, &known));
                Err(ParameterError::new("id", message))
            }
        }
    }
}

/// The function itself: the reference evaluates it at every sample of every pixel.
struct Seen<'a>(&'a Shot<'a>);

impl ShadingFunction for Seen<'_> {
    fn pixels(&self, caster: &Caster, first: u32, sample: u32, out: &mut [[f32; 3]]) -> u64 {
        each_pixel(first, out, |pixel| {
            match self.0.look(caster, pixel, sample) {
                Some(seen) => Vec3::splat(-seen.site.normal.dot(seen.direction)),
                None => Vec3::ZERO, // Nothing is there to face the camera.
            }
        })
    }
}

/// A contender that takes one sample of each pixel, whatever it is granted.
const ONE_SAMPLE: ContenderEntry<Facing> = ContenderEntry {
    about: About {
        id: "one-sample",
        module: "//! The first sample of each pixel.",
        aliases: &[],
        summary: "the first sample of each pixel",
        source: "docs/adding.md",
        bias: Bias::Biased,
        version: 1,
        failures: &["edges are jagged"],
        parameters: &[],
    },
    start: |technique, table, _| {
        check_keys(table, &[])?;
        Ok(Box::new(OneSample(technique)))
    },
};

struct OneSample<'a>(&'a Facing);

impl Contender for OneSample<'_> {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let render = |shot: &Shot| {
            let mut rendered = Rendered::default();
            let counter = RayCounter::default();
            let function = self.0.shading_function(shot);
            let mut passes = Passes::new(shot, function.as_ref());
            rendered.stages.time("rendering", || passes.add(&counter));
            rendered.image = passes.mean();
            rendered.rays = counter.read();
            rendered
        };
        Ok(shots.iter().map(render).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::find_scene;
    use crate::technique::{Choice, Film};
    use crate::trace::Tracer;
    use crate::world::Moment;

    #[test]
    fn surfaces_face_the_camera_by_0_to_1() {
        let technique = (ENTRY.build)(&toml::Table::new()).expect("no keys");
        let description = find_scene("cornell-curved").expect("shipped");
        let scene = Scene::build(&description, technique.needs()).expect("a scene");
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let film = Film {
            width: 8,
            height: 6,
            spp: 1,
        };
        let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
        let none = toml::Table::new();
        let choice = |method| Choice {
            method,
            parameters: &none,
            terms: Terms { budget: 1, seed: 1 },
        };
        let still = choice("one-sample").still(technique.as_ref(), &shot, None);
        let rendered = still.expect("rendered");
        assert!(
            rendered
                .image
                .pixels
                .iter()
                .all(|p| (-1e-3..1.001).contains(&p[0]))
        );
        assert!(rendered.image.pixels.iter().any(|p| p[0] > 0.5));
        assert_eq!(rendered.rays.closest, 48);
        let wrong = choice("one-sampel").still(technique.as_ref(), &shot, None);
        let wrong = wrong.expect_err("no such contender");
        assert!(wrong.contains("did you mean `one-sample`?"), "{wrong}");
    }
}
