//! What runs in a job: a contender, the terms it runs under, and what it gives back.

use toml::Table;

use super::{Film, Listed, Seconds, Shot, Site, Stages, Technique};
use crate::entry::{About, ParameterError};
use crate::environment::LightSet;
use crate::image::Image;
use crate::memory::{Peak, held};
use crate::scene::Scene;
use crate::trace::RayCounts;

/// A method at work. It lives for one job, is given the shots of one frame after another, and owns what it
/// remembers of them: nothing of a shot is borrowed beyond the call.
pub trait Contender: Send {
    /// Whether frames depend on those before: what it is given first then matters.
    fn remembers(&self) -> bool {
        false
    }

    /// Whether settings are picked by error, which takes references of the first frame.
    fn searches(&self) -> bool {
        false
    }

    /// How many times what the budget grants it takes, for guesses of its time.
    fn times(&self) -> f64 {
        1.0
    }

    /// Picks settings by error against the references of the first frame's shots. What that takes is in
    /// `search` of the next frame and not charged.
    ///
    /// # Errors
    /// A sentence, as for [`Contender::frame`].
    fn search(&mut self, _shots: &[Shot], _references: &[&Image]) -> Result<(), String> {
        Ok(())
    }

    /// The images of one frame, one for each of its shots (viewers), in their order.
    ///
    /// # Errors
    /// A sentence, where the contender needs what is not there.
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String>;

    /// What it remembers of the frames before, so that an interrupted sequence goes on from there. What it made of the
    /// scene of the first frame need not be part of it: see [`Contender::rebuild`].
    ///
    /// # Errors
    /// A sentence.
    fn memory(&self) -> Result<Vec<u8>, String> {
        Ok(Vec::new())
    }

    /// Makes anew what it made of the scene of the first frame, of which these are the shots. An interrupted sequence
    /// that goes on asks for it once, before [`Contender::recall`]; it is not charged again.
    ///
    /// # Errors
    /// A sentence, as for [`Contender::frame`].
    fn rebuild(&mut self, _first: &[Shot]) -> Result<(), String> {
        Ok(())
    }

    /// Remembers what [`Contender::memory`] gave; nothing where that is empty.
    ///
    /// # Errors
    /// A sentence, where it is not what this contender gave.
    fn recall(&mut self, _memory: &[u8]) -> Result<(), String> {
        Ok(())
    }

    /// Which cell of what it remembers each pixel of a shot shows, row by row: equal numbers within a cell, 0 without
    /// one. Asked of images that are kept, and not charged; `None` for methods without cells.
    fn cells(&self, _shot: &Shot) -> Option<Vec<f32>> {
        None
    }

    /// About how much memory it will take for a shot of a scene, of which no more than the positions and triangles need
    /// be loaded; `None` where it cannot tell.
    fn foreseen(&self, _scene: &Scene, _film: Film) -> Option<Foreseen> {
        None
    }

    /// What went into one pixel (row-major index) of a shot, a line each.
    ///
    /// # Errors
    /// A sentence, for contenders that cannot tell: the default.
    fn replay(&mut self, _shot: &Shot, _pixel: u32) -> Result<Vec<String>, String> {
        Err("this method keeps nothing of a pixel to replay".into())
    }
}

/// Memory that a contender is about to take, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Foreseen {
    /// What it keeps.
    pub cache: f64,
    /// What it needs beside while a frame is made.
    pub work: f64,
}

/// What a contender is granted for a job.
#[derive(Clone, Copy, Debug, Default)]
pub struct Terms {
    /// What the contenders of the technique share, in its counted unit.
    pub budget: usize,
    /// Of all that it draws at random.
    pub seed: u64,
}

/// A contender that was built, and what it is called.
pub struct Started<'a> {
    /// Canonical id.
    pub id: String,
    /// The entries it is made of.
    pub parts: Vec<&'static About>,
    /// It has seen no frame yet.
    pub contender: Box<dyn Contender + 'a>,
}

/// Builds a contender of technique `T` from its parameters.
pub type Start<T> =
    for<'a> fn(&'a T, &Table, Terms) -> Result<Box<dyn Contender + 'a>, ParameterError>;

/// A contender as its technique `T` lists it.
pub struct ContenderEntry<T: ?Sized + 'static> {
    /// What the registry says of it.
    pub about: About,
    /// Builds it from its parameters, which it checks; no ray is cast yet.
    pub start: Start<T>,
}

impl<T: ?Sized> ContenderEntry<T> {
    /// The contender, from its parameters.
    ///
    /// # Errors
    /// Unknown and unfit parameters; the key is named.
    pub fn started<'a>(
        &'static self,
        technique: &'a T,
        parameters: &Table,
        terms: Terms,
    ) -> Result<Started<'a>, ParameterError> {
        let about = &self.about;
        Ok(Started {
            id: about.id.to_owned(),
            parts: vec![about],
            contender: (self.start)(technique, parameters, terms)?,
        })
    }
}

impl<T: ?Sized> ContenderEntry<T> {
    /// As lists show it.
    pub fn listed(&'static self) -> Listed {
        Listed {
            id: self.about.id.to_owned(),
            parts: vec![&self.about],
        }
    }
}

/// A contender as a job names it.
#[derive(Clone, Copy, Debug)]
pub struct Choice<'a> {
    /// Its id, an alias, or `FIRST+REFINEMENT`, in any case of letters.
    pub method: &'a str,
    /// Those that are set; the others have their defaults.
    pub parameters: &'a Table,
    /// What it is granted.
    pub terms: Terms,
}

impl Choice<'_> {
    /// Starts the contender.
    ///
    /// # Errors
    /// A sentence, where it cannot be built.
    pub fn start<'a>(&self, technique: &'a dyn Technique) -> Result<Started<'a>, String> {
        let started = technique.start(self.method, self.parameters, self.terms);
        started.map_err(|error| error.to_string())
    }

    /// Starts the contender and plays one frame: the images of its shots, with the light that all contenders share.
    /// `references` are those of the shots, for contenders that pick settings by error; they may be missing for all
    /// others.
    ///
    /// # Errors
    /// A sentence, where the contender cannot be built or needs what is not there.
    pub fn play(
        &self,
        technique: &dyn Technique,
        shots: &[Shot],
        references: &[&Image],
    ) -> Result<Vec<Rendered>, String> {
        let mut playing = self.play_from_start(technique)?;
        if playing.contender.searches() && references.len() == shots.len() {
            playing.contender.search(shots, references)?;
        }
        playing.frame(shots)
    }

    /// Starts the contender to play frame after frame.
    ///
    /// # Errors
    /// As for [`Choice::start`].
    pub fn play_from_start<'a>(&self, technique: &'a dyn Technique) -> Result<Playing<'a>, String> {
        let before = held();
        let Started { contender, .. } = self.start(technique)?;
        Ok(Playing {
            contender,
            kept: held().saturating_sub(before),
        })
    }

    /// As [`Choice::play`], of one shot.
    ///
    /// # Errors
    /// As [`Choice::play`].
    pub fn still(
        &self,
        technique: &dyn Technique,
        shot: &Shot,
        reference: Option<&Image>,
    ) -> Result<Rendered, String> {
        let references: Vec<&Image> = reference.into_iter().collect();
        let mut images = self.play(technique, std::slice::from_ref(shot), &references)?;
        images.pop().ok_or_else(|| "no image was rendered".into())
    }
}

/// A contender at work, frame after frame.
pub struct Playing<'a> {
    /// What is asked besides frames.
    pub contender: Box<dyn Contender + 'a>,
    /// Bytes that it holds between frames: what its start took, and then what it remembers of its last frame.
    kept: usize,
}

impl Playing<'_> {
    /// The images of a frame's shots, with the light that all contenders share, and the memory that they took.
    ///
    /// # Errors
    /// Those of [`Contender::frame`].
    pub fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let peak = Peak::start();
        let mut images = self.contender.frame(shots)?;
        let most = self.kept + peak.bytes();
        let caches = images.iter().map(|rendered| rendered.bytes_cache);
        // Without a memory, what serves one viewer is given up before the next one's is made.
        let at_once = match self.contender.remembers() {
            true => {
                self.kept = caches.sum();
                self.kept
            }
            false => caches.max().unwrap_or(0),
        };
        for (shot, rendered) in shots.iter().zip(&mut images) {
            rendered.bytes_work = most.saturating_sub(at_once);
            shot.add_layer(&mut rendered.image);
        }
        Ok(images)
    }

    /// As [`Contender::recall`].
    ///
    /// # Errors
    /// Those of it.
    pub fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        let before = held();
        self.contender.recall(memory)?;
        self.kept += held().saturating_sub(before);
        Ok(())
    }
}

/// What a search for settings took; excluded from the totals of every contender.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Search {
    /// On all clocks, as of stages.
    pub seconds: Seconds,
    /// Those cast while searching.
    pub rays: RayCounts,
}

impl Search {
    /// Adds the time and rays of another search.
    pub fn add(&mut self, other: Self) {
        self.seconds += other.seconds;
        self.rays += other.rays;
    }
}

/// A record of a finished job.
#[derive(Clone, Copy, Debug)]
pub struct PlacedRecord {
    /// Where it lies on the surface.
    pub site: Site,
    /// Row-major pixel index.
    pub pixel: u32,
    /// 0 first stage, 1 refinement.
    pub stage: u8,
}

/// What a contender produced for one shot.
#[derive(Clone, Debug, Default)]
pub struct Rendered {
    /// Linear RGB, scene-referred, of the shot's size.
    pub image: Image,
    /// In order of creation; empty for methods without.
    pub records: Vec<PlacedRecord>,
    /// The lights of a global light set.
    pub lights: Option<LightSet>,
    /// The map that guided the refinement, row-major, if there was one.
    pub discontinuity: Option<Vec<f32>>,
    /// [`Contender::cells`], of images that are kept.
    pub cells: Option<Vec<f32>>,
    /// Those of the frame, without the search.
    pub rays: RayCounts,
    /// Searches for the records near a point.
    pub lookups: u64,
    /// Heap of what the method keeps: records with their search structure, lights, what it remembers of frames.
    pub bytes_cache: usize,
    /// The most that was held beyond the scene and `bytes_cache` while the frame was made, heap of the whole program.
    pub bytes_work: usize,
    /// What each stage took, in order of execution.
    pub stages: Stages,
    /// What settings took that were searched for; not in `rays` and `stages`.
    pub search: Search,
    /// Found parameters (σ_s, chosen cluster size, …).
    pub found: Vec<(&'static str, f64)>,
    /// Shortfalls and fallbacks, a sentence each.
    pub notes: Vec<String>,
    /// Samples that were kept out of the image.
    pub non_finite: u64,
}
