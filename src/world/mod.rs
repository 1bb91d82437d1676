//! The world in time: a scene with its trees, and what moves in it.
//!
//! A [`World`] owns both; a [`Moment`] is the world at a time. A still scene is a world in which nothing
//! moves, at no cost.

mod lamps;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use self::lamps::{Lamps, carried};
use crate::scene::motion::{MotionDescription, Placement};
use crate::scene::{LightKind, Scene, SceneDescription, SceneError};
use crate::trace::{Hit, Tracer};

/// How one shape moves.
pub struct Motion {
    /// Index into [`Scene::shapes`].
    pub shape: usize,
    /// From where the scene file puts the shape to where it is at a time in seconds, in the coordinates
    /// of the file.
    pub place: Box<dyn Fn(f64) -> DAffine3 + Send + Sync>,
}

/// A scene and its trees, moved from time to time.
pub struct World {
    scene: Scene,
    tracer: Tracer,
    moving: Vec<MovingShape>,
    /// What changes of the light, if anything does.
    lamps: Option<Lamps>,
    time_s: Option<f64>,
    /// Positions one frame earlier, as long as those of the scene; empty where nothing moves.
    before: Vec<Vec3>,
}

/// A shape that moves, as the file has it.
struct MovingShape {
    motion: Motion,
    first_vertex: usize,
    positions: Vec<DVec3>,
    /// As long as `positions`, or empty where the scene has no normals.
    normals: Vec<Vec3>,
}

/// The world at a time.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    /// Geometry, lights and environment where they are at that time.
    pub scene: &'a Scene,
    /// Answers rays against them.
    pub tracer: &'a Tracer,
    /// As camera paths and motions count it.
    pub time_s: f64,
    before: &'a [Vec3],
}

impl World {
    /// A world in which nothing moves.
    pub fn still(scene: Scene) -> Self {
        Self {
            tracer: Tracer::new(&scene.positions, &scene.triangles),
            scene,
            moving: Vec::new(),
            lamps: None,
            time_s: None,
            before: Vec::new(),
        }
    }

    /// A world with the motions that its description declares; still where it declares none. Centre and
    /// diagonal are those of everything at all times of the motions, so that they are the same for each sequence.
    ///
    /// # Errors
    /// As [`World::moving`]; a light that gets beyond that, or shines beyond it.
    pub fn declared(scene: Scene, description: &SceneDescription) -> Result<Self, SceneError> {
        if description.motions.is_empty() {
            return Ok(Self::still(scene));
        }
        let motions = with_pivots(&scene, description);
        let mut times_s: Vec<f64> = motions.iter().flat_map(|motion| motion.times_s()).collect();
        times_s.sort_by(f64::total_cmp);
        times_s.dedup();
        let shapes = shapes_in_motion(&scene, &motions);
        let lamps = Lamps::new(&scene, &description.lights, motions);
        if let Some((what, time_s)) = lamps.beyond(description) {
            return Err(too_far(&scene, &what, time_s));
        }
        let world = match shapes.is_empty() {
            true => Self::still(scene),
            false => Self::moving(scene, shapes, &times_s)?,
        };
        Ok(Self {
            lamps: Some(lamps),
            ..world
        })
    }

    /// A world whose shapes move. Centre and diagonal are those of everything at all of `times_s`, so that they
    /// do not change from frame to frame.
    ///
    /// # Errors
    /// A shape that gets beyond what single precision holds at one of the times; motions that make the scene larger
    /// than it holds.
    pub fn moving(
        mut scene: Scene,
        motions: Vec<Motion>,
        times_s: &[f64],
    ) -> Result<Self, SceneError> {
        let moving: Vec<MovingShape> = motions
            .into_iter()
            .map(|motion| MovingShape::new(&scene, motion))
            .collect();
        let mut moves = vec![false; scene.triangles.len()];
        for shape in &moving {
            moves[scene.shapes[shape.motion.shape].triangles()].fill(true);
        }
        let (low, high) = bounds(&scene, &moving, &moves, times_s)?;
        scene.enclose(low, high);
        scene.check_extent()?;
        Ok(Self {
            tracer: Tracer::with_moving(&scene.positions, &scene.triangles, &moves),
            before: scene.positions.clone(),
            scene,
            moving,
            lamps: None,
            time_s: None,
        })
    }

    /// The scene as it was moved last.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What was subtracted from all positions of the scene's file.
    pub fn origin(&self) -> DVec3 {
        self.scene.origin
    }

    /// Forgets the moment before: the next one is the first again.
    pub fn rewind(&mut self) {
        self.time_s = None;
    }

    /// Moves everything to a time. What was shown before is then one frame earlier; at the first time, and
    /// where nothing moves, that is the same. The same time again is the same moment.
    pub fn at(&mut self, time_s: f64) -> Moment<'_> {
        let is_first = self.time_s.is_none();
        if !self.moving.is_empty() && self.time_s != Some(time_s) {
            for shape in &self.moving {
                let range = shape.vertices();
                self.before[range.clone()].copy_from_slice(&self.scene.positions[range.clone()]);
                shape.put(&mut self.scene, time_s);
                if is_first {
                    self.before[range.clone()].copy_from_slice(&self.scene.positions[range]);
                }
            }
            self.tracer.moved(&self.scene.positions);
        }
        if let Some(lamps) = &self.lamps {
            lamps.put(&mut self.scene, time_s);
        }
        self.time_s = Some(time_s);
        Moment {
            scene: &self.scene,
            tracer: &self.tracer,
            time_s,
            before: &self.before,
        }
    }
}

/// The motions of a description, with pivots that nobody chose in the middle of what a motion moves.
fn with_pivots(scene: &Scene, description: &SceneDescription) -> Vec<MotionDescription> {
    let mut motions = description.motions.clone();
    for motion in &mut motions {
        if let Some(centre) = centre_of(scene, description, motion) {
            motion.placement.about(centre);
        }
    }
    motions
}

/// How each shape that has triangles and moves does so.
fn shapes_in_motion(scene: &Scene, motions: &[MotionDescription]) -> Vec<Motion> {
    let of_shape = |shape: usize| -> Vec<Placement> {
        let own = motions.iter().filter(|m| m.shapes.contains(&shape));
        let placements = own.map(|motion| motion.placement.clone());
        placements
            .filter(|placement| !placement.is_rest())
            .collect()
    };
    (0..scene.shapes.len())
        .filter(|&shape| !scene.shapes[shape].triangles().is_empty())
        .map(|shape| (shape, of_shape(shape)))
        .filter(|(_, placements)| !placements.is_empty())
        .map(|(shape, placements)| Motion {
            shape,
            place: Box::new(move |time_s| carried(&placements, time_s)),
        })
        .collect()
}

/// Centre of the box around what a motion moves, in the coordinates of the file; `None` where that is nothing.
fn centre_of(
    scene: &Scene,
    description: &SceneDescription,
    motion: &MotionDescription,
) -> Option<DVec3> {
    let shapes = motion.shapes.iter().filter_map(|&i| scene.shapes.get(i));
    let triangles = shapes.flat_map(|shape| &scene.triangles[shape.triangles()]);
    let points = triangles
        .flatten()
        .map(|&i| scene.positions[i as usize].as_dvec3() + scene.origin);
    let lights = motion
        .lights
        .iter()
        .filter_map(|&i| description.lights.get(i));
    let lights = lights.filter_map(|light| match &light.kind {
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => Some(*position),
        LightKind::Directional { .. } => None,
    });
    let bounds = points
        .chain(lights)
        .map(|point| (point, point))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    Some((bounds.0 + bounds.1) * 0.5)
}

impl MovingShape {
    fn new(scene: &Scene, motion: Motion) -> Self {
        let triangles = &scene.triangles[scene.shapes[motion.shape].triangles()];
        let used = || triangles.iter().flatten().map(|&i| i as usize);
        let first_vertex = used().min().unwrap_or(0);
        let range = first_vertex..used().max().map_or(first_vertex, |last| last + 1);
        let positions = scene.positions[range.clone()].iter();
        Self {
            motion,
            first_vertex,
            positions: positions.map(|p| p.as_dvec3() + scene.origin).collect(),
            normals: scene.normals.get(range).unwrap_or_default().to_vec(),
        }
    }

    /// Its vertices; no other shape has any of them.
    fn vertices(&self) -> std::ops::Range<usize> {
        self.first_vertex..self.first_vertex + self.positions.len()
    }

    /// Writes where the shape is at a time.
    fn put(&self, scene: &mut Scene, time_s: f64) {
        let place = (self.motion.place)(time_s);
        let origin = scene.origin;
        let moved = |p: &DVec3| (place.transform_point3(*p) - origin).as_vec3();
        let positions = &mut scene.positions[self.vertices()];
        for (position, at_rest) in positions.iter_mut().zip(&self.positions) {
            *position = moved(at_rest);
        }
        if !self.normals.is_empty() {
            let turn: DMat3 = place.matrix3.inverse().transpose();
            let turned = |n: &Vec3| (turn * n.as_dvec3()).normalize_or_zero().as_vec3();
            let normals = &mut scene.normals[self.vertices()];
            for (normal, at_rest) in normals.iter_mut().zip(&self.normals) {
                *normal = turned(at_rest);
            }
        }
    }
}

/// Coordinates that no scene has which single precision holds: 10⁸ times the largest diagonal.
const FARTHEST: f64 = 1e17;

/// An error of what motions take beyond that at a time.
fn too_far(scene: &Scene, what: &str, time_s: f64) -> SceneError {
    let message = format!(
        "its motions, one after another, take the {what} beyond single precision at {time_s} s: key smaller values"
    );
    SceneError::Scene {
        scene: scene.name.clone(),
        message,
    }
}

/// The box around what stands still and around what moves at each time, in the coordinates of the file.
fn bounds(
    scene: &Scene,
    moving: &[MovingShape],
    moves: &[bool],
    times_s: &[f64],
) -> Result<(DVec3, DVec3), SceneError> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut enclose = |point: DVec3| {
        (low, high) = (low.min(point), high.max(point));
        point.abs().cmple(DVec3::splat(FARTHEST)).all()
    };
    let still = scene
        .triangles
        .iter()
        .zip(moves)
        .filter(|(_, moves)| !**moves);
    for i in still.flat_map(|(triangle, _)| *triangle) {
        enclose(scene.positions[i as usize].as_dvec3() + scene.origin);
    }
    for shape in moving {
        for &time_s in times_s {
            let place = (shape.motion.place)(time_s);
            let mut points = shape.positions.iter();
            if !points.all(|p| enclose(place.transform_point3(*p))) {
                let what = format!("shape `{}`", scene.shapes[shape.motion.shape].name);
                return Err(too_far(scene, &what, time_s));
            }
        }
    }
    Ok((low, high))
}

impl<'a> Moment<'a> {
    /// The only moment of a scene in which nothing moves; `tracer` was built from its triangles.
    pub fn still(scene: &'a Scene, tracer: &'a Tracer) -> Self {
        Self {
            scene,
            tracer,
            time_s: 0.0,
            before: &[],
        }
    }

    /// Where the surface point of a hit was one frame earlier.
    pub fn before(&self, hit: &Hit) -> Vec3 {
        let positions = match self.before.is_empty() {
            true => &self.scene.positions,
            false => self.before,
        };
        let triangle = self.scene.triangles[hit.triangle as usize];
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        a + hit.u * (b - a) + hit.v * (c - a)
    }
}
