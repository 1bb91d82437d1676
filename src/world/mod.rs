//! The world in time: a scene with its trees, and what moves in it.
//!
//! A [`World`] owns both; a [`Moment`] is the world at a time. A still scene is a world in which nothing
//! moves, at no cost.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::scene::Scene;
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
    pub scene: &'a Scene,
    pub tracer: &'a Tracer,
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
            time_s: None,
            before: Vec::new(),
        }
    }

    /// A world whose shapes move. Centre and diagonal are those of everything at all of `times_s`, so that they
    /// do not change from frame to frame.
    pub fn moving(mut scene: Scene, motions: Vec<Motion>, times_s: &[f64]) -> Self {
        let moving: Vec<MovingShape> = motions
            .into_iter()
            .map(|motion| MovingShape::new(&scene, motion))
            .collect();
        let mut moves = vec![false; scene.triangles.len()];
        for shape in &moving {
            moves[scene.shapes[shape.motion.shape].triangles()].fill(true);
        }
        let (low, high) = bounds(&scene, &moving, &moves, times_s);
        scene.enclose(low, high);
        Self {
            tracer: Tracer::with_moving(&scene.positions, &scene.triangles, &moves),
            before: scene.positions.clone(),
            scene,
            moving,
            time_s: None,
        }
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
        self.time_s = Some(time_s);
        Moment {
            scene: &self.scene,
            tracer: &self.tracer,
            time_s,
            before: &self.before,
        }
    }
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

/// The box around what stands still and around what moves at each time, in the coordinates of the file.
fn bounds(
    scene: &Scene,
    moving: &[MovingShape],
    moves: &[bool],
    times_s: &[f64],
) -> (DVec3, DVec3) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut enclose = |point: DVec3| (low, high) = (low.min(point), high.max(point));
    let still = scene
        .triangles
        .iter()
        .zip(moves)
        .filter(|(_, moves)| !**moves);
    for i in still.flat_map(|(triangle, _)| *triangle) {
        enclose(scene.positions[i as usize].as_dvec3() + scene.origin);
    }
    for shape in moving {
        for place in times_s.iter().map(|&time_s| (shape.motion.place)(time_s)) {
            let points = shape.positions.iter();
            points.for_each(|p| enclose(place.transform_point3(*p)));
        }
    }
    (low, high)
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
