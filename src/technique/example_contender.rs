//! Half rate (a worked example): paths for every other frame; in between a viewer sees its last image again.

use super::path_samples::sampled;
use super::truth::Truth;
use super::{Contender, ContenderEntry, Rendered, Shot, Terms};
use crate::entry::{About, Bias, check_keys};
use crate::image::Image;

/// Entry for the list of the technique's contenders.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "half-rate",
        module: crate::entry::head_comment!("example_contender.rs"),
        aliases: &[],
        summary: "paths for every other frame, which is shown twice",
        source: "docs/adding.md",
        bias: Bias::Biased,
        version: 1,
        failures: &["all that moves is a frame late in every other frame"],
        parameters: &[],
    },
    start: |technique, table, terms| {
        check_keys(table, &[])?;
        Ok(Box::new(HalfRate {
            technique,
            terms,
            shown: Vec::new(),
        }))
    },
};

struct HalfRate<'a> {
    technique: &'a Truth,
    /// What it may spend, and the seed of its random numbers.
    terms: Terms,
    /// The last image of each viewer: owned, because nothing of a shot lives longer than its frame.
    shown: Vec<Option<Image>>,
}

impl Contender for HalfRate<'_> {
    fn remembers(&self) -> bool {
        true
    }

    fn memory(&self) -> Result<Vec<u8>, String> {
        postcard::to_allocvec(&pixels(&self.shown)).map_err(|error| error.to_string())
    }

    fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        if !memory.is_empty() {
            let kept: Kept = postcard::from_bytes(memory).map_err(|error| error.to_string())?;
            self.shown = images(kept);
        }
        Ok(())
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        Ok(shots.iter().map(|shot| self.shot(shot)).collect())
    }
}

impl HalfRate<'_> {
    fn shot(&mut self, shot: &Shot) -> Rendered {
        let viewer = usize::from(shot.viewer);
        if self.shown.len() <= viewer {
            self.shown.resize(viewer + 1, None);
        }
        if let Some(image) = self.shown[viewer].take() {
            return Rendered {
                image,
                ..Rendered::default() // No rays, no time: a row tells what was cast, not what was granted.
            };
        }
        let samples = self.terms.budget as u32;
        let paths = self.technique.contender_paths(shot, self.terms.seed);
        // Each frame takes other paths, or its noise would stick to the screen.
        let rendered = sampled(shot, &paths, shot.frame.wrapping_mul(samples), samples);
        self.shown[viewer] = Some(rendered.image.clone());
        rendered
    }
}

/// Size and pixels of each viewer's image, as they are saved.
type Kept = Vec<Option<([usize; 2], Vec<[f32; 3]>)>>;

fn pixels(images: &[Option<Image>]) -> Kept {
    let kept = |image: &Image| ([image.width, image.height], image.pixels.clone());
    images
        .iter()
        .map(|image| image.as_ref().map(kept))
        .collect()
}

fn images(kept: Kept) -> Vec<Option<Image>> {
    let image = |([width, height], pixels): ([usize; 2], Vec<[f32; 3]>)| Image {
        width,
        height,
        pixels,
    };
    kept.into_iter().map(|kept| kept.map(image)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Needs, Scene, find_scene};
    use crate::technique::Film;
    use crate::trace::Tracer;
    use crate::world::Moment;

    #[test]
    fn every_image_is_shown_twice_and_a_saved_one_too() {
        let description = find_scene("cornell-curved").expect("shipped");
        let scene = Scene::build(&description, Needs::ALL).expect("a scene");
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let film = Film {
            width: 8,
            height: 6,
            spp: 1,
        };
        let none = toml::Table::new();
        let technique = Truth::new(&none, None, &[]).expect("defaults");
        let terms = Terms { budget: 1, seed: 1 };
        let start = || (ENTRY.start)(&technique, &none, terms).expect("no keys");
        let mut contender = start();
        let mut images = Vec::new();
        for frame in 0..4 {
            if frame == 3 {
                let memory = contender.memory().expect("saved");
                contender = start();
                contender.recall(&memory).expect("its own");
            }
            let moment = Moment::still(&scene, &tracer);
            let mut shot = Shot::new(moment, &scene.views[0], film);
            shot.frame = frame;
            let rendered = contender.frame(&[shot]).expect("rendered");
            images.push(rendered[0].image.pixels.clone());
        }
        assert!(images[0] == images[1] && images[2] == images[3]);
        assert!(images[0] != images[2]);
    }
}
