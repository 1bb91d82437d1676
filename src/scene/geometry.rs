//! One shape from its source to clean world-space triangles.

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::mesh::FileMesh;
use super::mesh_obj::ObjFile;
use super::mesh_ply::load_ply;
use super::mesh_serialized::load_serialized;
use super::{Mesh, SceneError, ShapeDescription, ShapeSource, primitive, shapes, textured_light};

/// A triangle whose height is below this fraction of its longest edge has no area (f64 geometry of
/// files with six to nine digits).
const DEGENERATE_HEIGHT: f64 = 1e-10;

/// A loaded shape, or why its file is not there.
pub(super) enum Loaded {
    World(WorldShape),
    Absent(String),
}

/// Triangles in world space (f64) without degenerate or non-finite ones.
#[derive(Default)]
pub(super) struct WorldShape {
    pub mesh: Mesh,
    pub dropped_degenerate: usize,
    pub dropped_non_finite: usize,
    pub repaired_normals: usize,
    pub reoriented: usize,
    /// What of its file was left out or replaced.
    pub notes: Vec<String>,
}

/// Shapes with their positions in the scene.
pub(super) type Numbered<'a> = (usize, &'a ShapeDescription);

/// Reads shapes that share their file, if they have one: an OBJ file is read once, however many materials it has. The
/// first that fails ends it.
pub(super) fn load_together(
    shapes: &[Numbered],
    normals: bool,
) -> Vec<(usize, Result<Loaded, SceneError>)> {
    let file = match &shapes[0].1.source {
        ShapeSource::Obj { path, .. } if path.exists() => match ObjFile::read(path) {
            Ok(file) => Some(file),
            Err(error) => return vec![(shapes[0].0, Err(error))],
        },
        _ => None,
    };
    let shapes = shapes.par_iter();
    shapes
        .map(|(index, shape)| (*index, load_shape(shape, file.as_ref(), normals)))
        .collect()
}

/// Reads, transforms and cleans a shape. Without `normals`, none are kept.
fn load_shape(
    shape: &ShapeDescription,
    file: Option<&ObjFile>,
    normals: bool,
) -> Result<Loaded, SceneError> {
    if let Some(path) = shape.source.path()
        && !path.exists()
    {
        return Ok(Loaded::Absent(format!(
            "{}: {} is absent",
            shape.name,
            path.display()
        )));
    }
    let FileMesh { mut mesh, notes } = read(shape, file)?;
    if shape.emission_texture.is_some() {
        mesh = textured_light::cut(&mesh);
    }
    Ok(Loaded::World(WorldShape {
        notes,
        ..to_world(mesh, shape, normals)
    }))
}

fn read(shape: &ShapeDescription, file: Option<&ObjFile>) -> Result<FileMesh, SceneError> {
    let mesh = match &shape.source {
        ShapeSource::Obj {
            path,
            part,
            material,
        } => {
            let (part, material) = (part.as_deref(), material.as_deref());
            return match file {
                Some(file) => file.mesh(part, material),
                None => ObjFile::read(path)?.mesh(part, material),
            };
        }
        ShapeSource::Ply { path } => return load_ply(path),
        ShapeSource::Serialized { path, index } => load_serialized(path, *index)?,
        ShapeSource::Gltf {
            file,
            mesh,
            primitive,
            uv_set,
        } => file.mesh([*mesh, *primitive], *uv_set)?,
        ShapeSource::Rectangle => primitive::rectangle(),
        ShapeSource::Cube => primitive::cube(),
        ShapeSource::Sphere { centre, radius } => primitive::sphere(*centre, *radius),
        ShapeSource::Disk => primitive::disk(),
        ShapeSource::Cylinder { from, to, radius } => primitive::cylinder([*from, *to], *radius),
        ShapeSource::Generated {
            generator,
            part,
            parameters,
        } => shapes::generate(generator, part.as_deref(), parameters).map_err(|message| {
            SceneError::Scene {
                scene: shape.name.clone(),
                message,
            }
        })?,
    };
    Ok(mesh.into())
}

impl ShapeSource {
    /// What several shapes are read from, to be held while they are.
    pub(super) fn held(&self) -> Option<std::sync::Arc<super::gltf::Buffers>> {
        match self {
            ShapeSource::Gltf { file, .. } => file.buffers().ok(),
            _ => None,
        }
    }

    /// The file it is read from, if any.
    pub fn path(&self) -> Option<&std::path::Path> {
        match self {
            ShapeSource::Obj { path, .. }
            | ShapeSource::Ply { path }
            | ShapeSource::Serialized { path, .. } => Some(path),
            ShapeSource::Gltf { file, .. } => Some(file.path()),
            _ => None,
        }
    }
}

fn to_world(mesh: Mesh, shape: &ShapeDescription, want_normals: bool) -> WorldShape {
    let mut world = WorldShape {
        mesh,
        ..WorldShape::default()
    };
    let mesh = &mut world.mesh;
    if shape.face_normals {
        mesh.normals.clear();
    }
    if shape.flip_v {
        mesh.uvs.iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
    }
    transform(mesh, &shape.to_world);
    if shape.turn_bare && mesh.normals.is_empty() {
        reverse(mesh);
    }
    if shape.flip_normals {
        reverse(mesh);
        mesh.normals.iter_mut().for_each(|n| *n = -*n);
    }
    drop_bad_triangles(&mut world);
    world.reoriented = face_the_normals(&mut world.mesh);
    if !want_normals {
        world.mesh.normals.clear();
    } else if !shape.face_normals {
        repair_normals(&mut world, shape.smooth_normals);
    }
    compact(&mut world.mesh);
    world
}

/// Applies an affine transform; normals by the inverse transpose, winding reversed by mirrors so that
/// the front stays the front.
fn transform(mesh: &mut Mesh, to_world: &DMat4) {
    for p in &mut mesh.positions {
        *p = to_world.transform_point3(*p);
    }
    let linear = DMat3::from_mat4(*to_world);
    // The cofactor matrix: the inverse transpose without its division, defined for singular ones too.
    let sign = if linear.determinant() < 0.0 {
        -1.0
    } else {
        1.0
    };
    let cofactor = DMat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    ) * sign;
    for n in &mut mesh.normals {
        *n = (cofactor * n.as_dvec3()).normalize_or_zero().as_vec3();
    }
    if sign < 0.0 {
        reverse(mesh);
    }
}

fn reverse(mesh: &mut Mesh) {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
}

fn drop_bad_triangles(world: &mut WorldShape) {
    let positions = &world.mesh.positions;
    let (mut degenerate, mut non_finite) = (0, 0);
    world.mesh.triangles.retain(|t| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        // Coordinates that overflow f32 are as good as infinite.
        let finite = [a, b, c].iter().all(|p| p.as_vec3().is_finite());
        let good = finite && !is_degenerate([a, b, c]);
        non_finite += usize::from(!finite);
        degenerate += usize::from(finite && !good);
        good
    });
    world.dropped_degenerate = degenerate;
    world.dropped_non_finite = non_finite;
}

/// Whether a triangle has no area relative to its longest edge.
pub(super) fn is_degenerate([a, b, c]: [DVec3; 3]) -> bool {
    let longest = (b - a)
        .length_squared()
        .max((c - a).length_squared())
        .max((c - b).length_squared());
    let doubled_area = (b - a).cross(c - a).length();
    // Written so that NaN (overflow) counts as degenerate.
    !(doubled_area > DEGENERATE_HEIGHT * longest && longest > 0.0)
}

fn geometric_normal(mesh: &Mesh, triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
    (b - a).cross(c - a)
}

/// Turns triangles whose three vertex normals all point to the back: the vertex normals define the
/// front. Returns how many.
fn face_the_normals(mesh: &mut Mesh) -> usize {
    if mesh.normals.is_empty() {
        return 0;
    }
    let mut triangles = std::mem::take(&mut mesh.triangles);
    let mut turned = 0;
    for t in &mut triangles {
        let n = geometric_normal(mesh, t).normalize_or_zero().as_vec3();
        if t.iter().all(|&i| mesh.normals[i as usize].dot(n) < 0.0) {
            t.swap(1, 2);
            turned += 1;
        }
    }
    mesh.triangles = triangles;
    turned
}

/// Normalizes vertex normals; zero or non-finite ones become the angle-weighted mean of the faces
/// around. A mesh without any gets them only if `smooth`.
fn repair_normals(world: &mut WorldShape, smooth: bool) {
    let mesh = &mut world.mesh;
    if mesh.normals.is_empty() {
        if smooth {
            mesh.normals = averaged_normals(mesh);
        }
        return;
    }
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles
        .iter()
        .flatten()
        .for_each(|&i| used[i as usize] = true);
    let mut broken = Vec::new();
    for (i, n) in mesh.normals.iter_mut().enumerate() {
        *n = n.as_dvec3().normalize_or_zero().as_vec3();
        if *n == Vec3::ZERO && used[i] {
            broken.push(i);
        }
    }
    if !broken.is_empty() {
        let averaged = averaged_normals(mesh);
        for &i in &broken {
            mesh.normals[i] = averaged[i];
        }
    }
    world.repaired_normals = broken.len();
}

/// Means of the normals of the faces around each vertex, weighted by the angle at the vertex
/// (Thürmer & Wüthrich); zero for vertices without faces.
fn averaged_normals(mesh: &Mesh) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for t in &mesh.triangles {
        let normal = geometric_normal(mesh, t).normalize_or_zero();
        for corner in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[t[(corner + k) % 3] as usize]);
            sums[t[corner] as usize] += normal * (b - a).angle_between(c - a);
        }
    }
    sums.iter()
        .map(|n| n.normalize_or_zero().as_vec3())
        .collect()
}

/// Removes vertices that no triangle uses, keeping the order.
fn compact(mesh: &mut Mesh) {
    const UNUSED: u32 = u32::MAX;
    let mut new_index = vec![UNUSED; mesh.positions.len()];
    mesh.triangles
        .iter()
        .flatten()
        .for_each(|&i| new_index[i as usize] = 0);
    let mut next = 0;
    for index in &mut new_index {
        if *index != UNUSED {
            *index = next;
            next += 1;
        }
    }
    if next as usize == mesh.positions.len() {
        return;
    }
    fn keep<T: Copy>(values: &mut Vec<T>, new_index: &[u32]) {
        let mut at = 0;
        values.retain(|_| {
            at += 1;
            new_index[at - 1] != UNUSED
        });
    }
    keep::<DVec3>(&mut mesh.positions, &new_index);
    keep::<Vec3>(&mut mesh.normals, &new_index);
    keep::<Vec2>(&mut mesh.uvs, &new_index);
    keep::<[f32; 3]>(&mut mesh.colours, &new_index);
    for t in &mut mesh.triangles {
        *t = t.map(|i| new_index[i as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(to_world: DMat4) -> ShapeDescription {
        ShapeDescription {
            to_world,
            ..ShapeDescription::new("s", ShapeSource::Rectangle)
        }
    }

    fn fronts(world: &WorldShape) -> Vec<Vec3> {
        let normal = |t| geometric_normal(&world.mesh, t).normalize().as_vec3();
        world.mesh.triangles.iter().map(normal).collect()
    }

    #[test]
    fn mirrors_keep_the_front_and_flip_turns_it() {
        let mirror = DMat4::from_scale(DVec3::new(-2.0, 1.0, 1.0));
        let world = to_world(primitive::rectangle(), &described(mirror), true);
        assert_eq!(fronts(&world), [Vec3::Z; 2]);
        assert_eq!(world.mesh.normals, [Vec3::Z; 4]);
        let mut shape = described(mirror);
        shape.flip_normals = true;
        let world = to_world(primitive::rectangle(), &shape, true);
        assert_eq!(fronts(&world), [Vec3::NEG_Z; 2]);
        assert_eq!(world.mesh.normals, [Vec3::NEG_Z; 4]);
        let mut back = described(DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)));
        back.face_normals = true;
        let world = to_world(primitive::rectangle(), &back, true);
        assert_eq!(fronts(&world), [Vec3::NEG_Z; 2], "the transformed +z");
    }

    #[test]
    fn normals_follow_the_inverse_transpose() {
        let squash = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.1));
        let world = to_world(
            primitive::sphere(DVec3::ZERO, 1.0),
            &described(squash),
            true,
        );
        for (p, n) in world.mesh.positions.iter().zip(&world.mesh.normals) {
            let expected = DVec3::new(p.x, p.y, p.z * 100.0).normalize();
            assert!(n.as_dvec3().distance(expected) < 1e-5);
        }
        assert_eq!(world.reoriented, 0);
    }

    #[test]
    fn bad_triangles_are_dropped_and_counted() {
        let mut mesh = primitive::rectangle();
        mesh.positions.push(DVec3::new(f64::NAN, 0.0, 0.0));
        mesh.positions.push(DVec3::new(1e300, 0.0, 0.0));
        mesh.positions.push(DVec3::new(0.0, -1.0, 0.0));
        mesh.normals.resize(7, Vec3::Z);
        mesh.uvs.resize(7, Vec2::ZERO);
        mesh.triangles
            .extend([[0, 1, 4], [0, 1, 5], [0, 0, 1], [0, 6, 1], [2, 2, 2]]);
        let world = to_world(mesh, &described(DMat4::IDENTITY), true);
        assert_eq!(world.dropped_non_finite, 2);
        assert_eq!(world.dropped_degenerate, 3);
        assert_eq!(world.mesh.triangles.len(), 2);
        assert_eq!(world.mesh.positions.len(), 4, "unused vertices go too");
        assert_eq!(world.mesh.normals.len(), 4);
        assert_eq!(world.mesh.uvs.len(), 4);
    }

    #[test]
    fn smallness_is_not_degeneracy() {
        for scale in [1e-12, 1e-3, 1.0, 1e5, 1e12] {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-6, 0.0)];
            assert!(!is_degenerate(corners.map(|p| p * scale)));
            assert!(is_degenerate(
                [DVec3::ZERO, DVec3::X, DVec3::X * 2.0].map(|p| p * scale)
            ));
        }
    }

    #[test]
    fn zero_and_nan_normals_are_repaired() {
        let mut mesh = primitive::rectangle();
        mesh.normals[1] = Vec3::ZERO;
        mesh.normals[3] = Vec3::splat(f32::NAN);
        let world = to_world(mesh, &described(DMat4::IDENTITY), true);
        assert_eq!(world.repaired_normals, 2);
        assert_eq!(world.mesh.normals, [Vec3::Z; 4]);
    }

    #[test]
    fn absent_normals_are_made_only_on_request() {
        let mut mesh = primitive::cube();
        mesh.normals.clear();
        let faceted = to_world(mesh.clone(), &described(DMat4::IDENTITY), true);
        assert!(faceted.mesh.normals.is_empty());
        let mut shape = described(DMat4::IDENTITY);
        shape.smooth_normals = true;
        let smooth = to_world(mesh, &shape, true);
        assert_eq!(smooth.mesh.normals.len(), 24);
        assert_eq!(smooth.mesh.normals[0], Vec3::X);
    }

    #[test]
    fn vertex_normals_define_the_front() {
        let mut mesh = primitive::rectangle();
        mesh.triangles = vec![[0, 2, 1], [0, 2, 3]];
        let world = to_world(mesh, &described(DMat4::IDENTITY), true);
        assert_eq!(world.reoriented, 1);
        assert_eq!(fronts(&world), [Vec3::Z; 2]);
    }

    #[test]
    fn mirrors_turn_faces_without_normals_where_that_is_asked_for() {
        let mut bare = primitive::rectangle();
        bare.normals.clear();
        let mut shape = described(DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
        assert_eq!(fronts(&to_world(bare.clone(), &shape, true)), [Vec3::Z; 2]);
        shape.turn_bare = true;
        assert_eq!(fronts(&to_world(bare, &shape, true)), [Vec3::NEG_Z; 2]);
        let with_normals = to_world(primitive::rectangle(), &shape, true);
        assert_eq!(fronts(&with_normals), [Vec3::Z; 2]);
    }
}
