//! From a description to triangles in f32 around the origin.

use std::collections::HashMap;
use std::ops::Range;

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::geometry::{Loaded, Numbered, WorldShape, is_degenerate, load_together};
use super::{
    BuildReport, Material, Needs, PointLight, SceneDescription, SceneError, ShapeSource, Texture,
    View,
};
use crate::environment::Environment;

/// What the diagonal of a scene is taken for whose unit nobody declares: formulas in metres then do not
/// depend on the unit, and a room of about this size gets what it would get if it were declared.
pub const ASSUMED_DIAGONAL_M: f64 = 10.0;

/// A loaded scene: world-space triangles around the centre of the bounding box, and what the
/// technique asked for. Attribute vectors that were not needed are empty.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// As in the description.
    pub name: String,
    /// Vertices in scene units, less `origin`.
    pub positions: Vec<Vec3>,
    /// Parallel to `positions` or empty; zero means "use the geometric normal".
    pub normals: Vec<Vec3>,
    /// Parallel to `positions` or empty; NaN where a shape has none.
    pub uvs: Vec<Vec2>,
    /// Colours of vertices, linear RGB; parallel to `positions`, or empty where no material asks for them.
    pub colours: Vec<[f32; 3]>,
    /// Vertex indices, all triangles finite and of positive area.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `shapes`, parallel to `triangles`.
    pub triangle_shape: Vec<u32>,
    /// Parallel to the shapes of the description.
    pub shapes: Vec<Shape>,
    /// As declared, index by index; empty where they were not needed.
    pub materials: Vec<Material>,
    /// Parallel to the textures of the description; those that no present shape uses are grey.
    pub textures: Vec<Texture>,
    /// Directions in which parallel light travels, with the irradiance of a facing surface.
    pub directional_lights: Vec<(Vec3, [f32; 3])>,
    /// Point and spot lights.
    pub point_lights: Vec<PointLight>,
    /// Light from infinity; `None` where there is none or it was not needed.
    pub environment: Option<Environment>,
    /// Views with origins moved like the geometry.
    pub views: Vec<View>,
    /// Diagonal of the bounding box of all triangles, scene units.
    pub diagonal: f32,
    /// What was subtracted from all positions.
    pub origin: DVec3,
    /// As declared, or such that the diagonal is [`ASSUMED_DIAGONAL_M`].
    pub metres_per_unit: f64,
    /// Whether nothing declares the unit.
    pub unit_is_assumed: bool,
    /// Scene units.
    pub ao_distance: f32,
    /// Factor from radiance to display-referred linear values.
    pub exposure: f32,
    /// Path edges after the camera: 1 emission only, 2 direct light, 3 one indirect bounce.
    pub max_depth: u32,
    /// Whether path tracing keeps what shines out of the camera's sight.
    pub hides_lights: bool,
    /// What loading found, repaired, dropped and cost.
    pub report: BuildReport,
    declared: DeclaredLengths,
}

/// Lengths that a scene may leave to its diagonal.
#[derive(Clone, Copy, Debug, Default)]
struct DeclaredLengths {
    ao_distance: Option<f64>,
    metres_per_unit: Option<f64>,
}

/// A shape after loading.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// As in the description.
    pub name: String,
    /// Index into the scene's materials.
    pub material: u32,
    /// On average, where a texture shines.
    pub emission: Option<[f32; 3]>,
    /// What each of its triangles emits over the mean, where a texture shines; else empty.
    pub pattern: Vec<[f32; 3]>,
    /// Index into the scene's triangles; those of a shape lie together.
    pub first_triangle: u32,
    /// How many follow from there; 0 where all were dropped or the file is absent.
    pub triangle_count: u32,
}

/// Which of what vertices carry is kept, of all shapes alike.
struct Kept {
    normals: bool,
    uvs: bool,
    colours: bool,
}

impl Shape {
    /// Its triangles, as places in those of the scene.
    pub fn triangles(&self) -> Range<usize> {
        let first = self.first_triangle as usize;
        first..first + self.triangle_count as usize
    }

    /// What one of them emits, by its place in those of the scene.
    pub fn emission_of(&self, triangle: u32) -> Option<[f32; 3]> {
        let mean = self.emission?;
        let place = triangle.checked_sub(self.first_triangle)? as usize;
        match self.pattern.get(place) {
            Some(over) => Some(std::array::from_fn(|c| mean[c] * over[c])),
            None => Some(mean),
        }
    }
}

impl Scene {
    /// Reads what `needs` asks for. Absent mesh or texture files are reported and left out (the
    /// texture becomes reflectance 0.5); a file that exists but is damaged is an error.
    pub fn build(description: &SceneDescription, needs: Needs) -> Result<Scene, SceneError> {
        let mut scene = Scene {
            name: description.name.clone(),
            exposure: description.exposure,
            max_depth: description.max_depth,
            hides_lights: description.hides_lights,
            declared: DeclaredLengths {
                ao_distance: description.ao_distance,
                metres_per_unit: description.metres_per_unit,
            },
            ..Scene::default()
        };
        scene.report.notes = description.notes.clone();
        let shapes = load_shapes(description, needs.normals, &mut scene.report)?;
        scene.centre(&shapes);
        scene.measure();
        scene.note_unit();
        scene.add_geometry(description, shapes, needs)?;
        scene.views = description.views.clone();
        for view in &mut scene.views {
            view.origin -= scene.origin;
        }
        let clips = description.clips.iter();
        let notes: Vec<String> = clips.filter_map(|clip| clip.note(&scene)).collect();
        scene.report.notes.extend(notes);
        scene.add_materials(description, needs)?;
        scene.add_lights(description, needs)?;
        Ok(scene)
    }

    /// Puts the origin at the centre of the bounding box of all triangles.
    fn centre(&mut self, shapes: &[Option<WorldShape>]) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in shapes.iter().flatten().flat_map(|s| &s.mesh.positions) {
            low = low.min(*p);
            high = high.max(*p);
        }
        if low.x <= high.x {
            self.origin = (low + high) * 0.5;
            self.diagonal = (high - low).length() as f32;
        }
    }

    /// Takes lengths as declared, or from the diagonal.
    fn measure(&mut self) {
        let diagonal = f64::from(self.diagonal);
        let declared = self.declared;
        self.ao_distance = declared.ao_distance.unwrap_or(0.1 * diagonal) as f32;
        self.unit_is_assumed = declared.metres_per_unit.is_none();
        let assumed = ASSUMED_DIAGONAL_M / diagonal;
        self.metres_per_unit = declared.metres_per_unit.unwrap_or(assumed);
    }

    /// Says what is assumed of an undeclared unit.
    fn note_unit(&mut self) {
        let diagonal = self.diagonal;
        if self.unit_is_assumed {
            self.report.notes.push(format!(
                "no metres_per_unit is declared: formulas in metres (Γ of VGC, λ of distances) take \
                 the diagonal, {diagonal} units, for {ASSUMED_DIAGONAL_M} m"
            ));
        }
    }

    /// Makes a box, in the coordinates of the file, the scene's: its centre the origin, and its diagonal the
    /// one that lengths follow. For shapes that move: the box of the whole sequence.
    pub(crate) fn enclose(&mut self, low: DVec3, high: DVec3) {
        let shift = (low + high) * 0.5 - self.origin;
        for position in &mut self.positions {
            *position = (position.as_dvec3() - shift).as_vec3();
        }
        for light in &mut self.point_lights {
            light.position = (light.position.as_dvec3() - shift).as_vec3();
        }
        for view in &mut self.views {
            view.origin -= shift;
        }
        self.origin += shift;
        self.diagonal = (high - low).length() as f32;
        self.measure();
    }

    fn add_geometry(
        &mut self,
        description: &SceneDescription,
        shapes: Vec<Option<WorldShape>>,
        needs: Needs,
    ) -> Result<(), SceneError> {
        let any = |has: fn(&WorldShape) -> bool| shapes.iter().flatten().any(has);
        let any_uvs = any(|s| !s.mesh.uvs.is_empty());
        let mut materials = description.materials.iter();
        let kept = Kept {
            normals: needs.normals && any(|s| !s.mesh.normals.is_empty()),
            uvs: needs.materials && any_uvs,
            colours: needs.materials && materials.any(Material::has_vertex_colours),
        };
        for (index, shape) in shapes.into_iter().enumerate() {
            let first_triangle = self.triangles.len() as u32;
            let declared = &description.shapes[index];
            if let Some(world) = shape {
                let material = description.materials.get(declared.material);
                let asks = material.is_some_and(Material::has_vertex_colours);
                if kept.colours && asks && world.mesh.colours.is_empty() {
                    let name = &declared.name;
                    self.report.notes.push(format!(
                        "`{name}` has no colours of vertices, which its material asks for: grey 0.5 instead"
                    ));
                }
                self.append(world, &kept);
            }
            let triangle_count = self.triangles.len() as u32 - first_triangle;
            self.triangle_shape
                .resize(self.triangles.len(), index as u32);
            self.shapes.push(Shape {
                name: declared.name.clone(),
                material: declared.material as u32,
                emission: declared.emission.filter(|_| needs.emitters),
                pattern: Vec::new(),
                first_triangle,
                triangle_count,
            });
        }
        if needs.emitters {
            self.shine(description)?;
        }
        self.account(any_uvs);
        self.check_size()
    }

    /// Appends a shape around the new origin, without the triangles that f32 makes degenerate.
    fn append(&mut self, world: WorldShape, with: &Kept) {
        let base = self.positions.len();
        let origin = self.origin;
        let mesh = world.mesh;
        self.positions
            .extend(mesh.positions.iter().map(|p| (*p - origin).as_vec3()));
        let count = self.positions.len();
        if with.normals {
            self.normals.extend_from_slice(&mesh.normals);
            self.normals.resize(count, Vec3::ZERO);
        }
        if with.uvs {
            self.uvs.extend_from_slice(&mesh.uvs);
            self.uvs.resize(count, Vec2::NAN);
        }
        if with.colours {
            self.colours.extend_from_slice(&mesh.colours);
            self.colours.resize(count, [0.5; 3]);
        }
        let before = mesh.triangles.len();
        let positions = &self.positions[base..];
        let solid = mesh
            .triangles
            .iter()
            .filter(|t| !is_degenerate(t.map(|i| positions[i as usize].as_dvec3())));
        let kept = self.triangles.len();
        self.triangles
            .extend(solid.map(|t| t.map(|i| i + base as u32)));
        let report = &mut self.report;
        for note in world.notes {
            // Once for all shapes of a file.
            if !report.notes.contains(&note) {
                report.notes.push(note);
            }
        }
        report.dropped_degenerate +=
            world.dropped_degenerate + before + kept - self.triangles.len();
        report.dropped_non_finite += world.dropped_non_finite;
        report.repaired_normals += world.repaired_normals;
        report.reoriented += world.reoriented;
    }

    fn account(&mut self, any_uvs: bool) {
        let report = &mut self.report;
        report.vertices = self.positions.len();
        report.triangles = self.triangles.len();
        report.cost.geometry = size_of_val(&self.positions[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.triangle_shape[..])
            + size_of_val(&self.shapes[..]);
        report.cost.normals = report.vertices * size_of::<Vec3>();
        report.cost.uvs = if any_uvs {
            report.vertices * size_of::<Vec2>()
        } else {
            0
        };
        report.geometry_bytes =
            report.cost.geometry + size_of_val(&self.normals[..]) + size_of_val(&self.uvs[..]);
        report.geometry_bytes += size_of_val(&self.colours[..]);
    }

    fn check_size(&self) -> Result<(), SceneError> {
        let fail = |message: String| {
            Err(SceneError::Scene {
                scene: self.name.clone(),
                message,
            })
        };
        let report = &self.report;
        if self.triangles.is_empty() {
            let absent = match report.absent.first() {
                Some(first) => format!(", {} absent, the first being {first}", report.absent.len()),
                None => String::new(),
            };
            return fail(format!(
                "nothing to render: no triangle with an area is left ({} degenerate, {} not \
                 finite{absent})",
                report.dropped_degenerate, report.dropped_non_finite
            ));
        }
        if self.positions.len() > u32::MAX as usize {
            return fail("more than 2³² vertices".into());
        }
        self.check_extent()
    }
}

/// Loads all shapes in parallel; the results and the first error are in the order of the description.
/// `None` stands for a shape whose file is absent.
fn load_shapes(
    description: &SceneDescription,
    normals: bool,
    report: &mut BuildReport,
) -> Result<Vec<Option<WorldShape>>, SceneError> {
    // Held until all shapes are read, so that a file of many shapes is read once.
    let _held: Vec<_> = description
        .shapes
        .iter()
        .filter_map(|shape| shape.source.held())
        .collect();
    let mut together: Vec<Vec<Numbered>> = Vec::new();
    let mut of_file = HashMap::new();
    for (index, shape) in description.shapes.iter().enumerate() {
        let group = match &shape.source {
            ShapeSource::Obj { path, .. } => *of_file.entry(path).or_insert(together.len()),
            _ => together.len(),
        };
        match together.get_mut(group) {
            Some(others) => others.push((index, shape)),
            None => together.push(vec![(index, shape)]),
        }
    }
    let together = together.par_iter();
    let mut loaded: Vec<_> = together
        .flat_map_iter(|shapes| load_together(shapes, normals))
        .collect();
    loaded.sort_by_key(|(index, _)| *index);
    let mut shapes = Vec::with_capacity(loaded.len());
    for (_, result) in loaded {
        match result? {
            Loaded::World(world) => shapes.push(Some(world)),
            Loaded::Absent(reason) => {
                report.absent.push(reason);
                shapes.push(None);
            }
        }
    }
    Ok(shapes)
}
