//! Shapes, instances and the area lights on them.

use glam::{DMat3, DMat4, DVec3};

use super::Importer;
use super::element::Element;
use super::emitter::shining;
use super::transform::vector;
use crate::scene::{ColourSource, Material, SceneError, ShapeDescription, ShapeSource};

/// Relative difference of lengths up to which a scale counts as even: files have few digits.
const EVEN: f64 = 1e-4;

type Emission = (Option<[f32; 3]>, Option<usize>);

impl<'a> Importer<'a> {
    /// Adds a shape, or the shapes of an instance; `outer` is the transform of the instance.
    pub(super) fn shape(&mut self, element: &'a Element, outer: DMat4) -> Result<(), SceneError> {
        element.used.set(true);
        match element.kind() {
            // Only its instances are visible.
            "shapegroup" => return Ok(()),
            "instance" => return self.instance(element, outer),
            "merge" => {
                let mut shapes = self.nested(element, "shape")?.into_iter();
                return shapes.try_for_each(|shape| self.shape(shape, outer));
            }
            _ => {}
        }
        let Some(source) = self.source(element)? else {
            element.mark_all();
            self.note(format!("shape type `{}` is left out", element.kind()));
            return Ok(());
        };
        let to_world = match element.child("to_world") {
            Some(t) => self.transform(t)?,
            None => DMat4::IDENTITY,
        };
        self.note_uneven(&source, DMat3::from_mat4(to_world));
        let is_file = source.path().is_some();
        let mirrored = DMat3::from_mat4(to_world).determinant() < 0.0;
        // Mitsuba turns a mirrored sphere inside out.
        let turned = mirrored && matches!(source, ShapeSource::Sphere { .. });
        let is_obj = matches!(source, ShapeSource::Obj { .. });
        let name = match element.id() {
            Some(id) => id.to_owned(),
            None => format!("{} {}", element.kind(), self.scene.shapes.len()),
        };
        let face_normals = element.boolean("face_normals", false)?;
        let flip_tex_coords = element.boolean("flip_tex_coords", is_obj)?;
        if element.child("max_smooth_angle").is_some() {
            self.note("max_smooth_angle is ignored: the normals of the file are kept");
        }
        element.child("shape_name");
        let (emission, emission_texture) = self.area_emission(element)?;
        let shape = ShapeDescription {
            to_world: outer * to_world,
            material: self.shape_material(element)?,
            emission,
            emission_texture,
            flip_normals: element.boolean("flip_normals", false)? != turned,
            turn_bare: is_file && mirrored,
            face_normals,
            smooth_normals: is_file,
            // Mitsuba counts v from the top row of the image, we from the bottom.
            flip_v: !flip_tex_coords,
            ..ShapeDescription::new(&name, source)
        };
        self.scene.shapes.push(shape);
        Ok(())
    }

    fn source(&mut self, element: &Element) -> Result<Option<ShapeSource>, SceneError> {
        let number = |name: &str, default: f64| Ok(element.float(name)?.unwrap_or(default));
        let point = |name: &str, default: DVec3| match element.child(name) {
            Some(p) => vector(p, 0.0),
            None => Ok(default),
        };
        Ok(Some(match element.kind() {
            "obj" => ShapeSource::Obj {
                path: self.path(element)?,
                part: element.string("shape_name")?.map(str::to_owned),
                material: None,
            },
            "ply" => ShapeSource::Ply {
                path: self.path(element)?,
            },
            "serialized" => ShapeSource::Serialized {
                path: self.path(element)?,
                index: element.whole("shape_index")?.unwrap_or(0),
            },
            "rectangle" => ShapeSource::Rectangle,
            "cube" => ShapeSource::Cube,
            "disk" => ShapeSource::Disk,
            "sphere" => ShapeSource::Sphere {
                centre: point("center", DVec3::ZERO)?,
                radius: number("radius", 1.0)?,
            },
            "cylinder" => ShapeSource::Cylinder {
                from: point("p0", DVec3::ZERO)?,
                to: point("p1", DVec3::Z)?,
                radius: number("radius", 1.0)?,
            },
            _ => return Ok(None),
        }))
    }

    fn instance(&mut self, element: &'a Element, outer: DMat4) -> Result<(), SceneError> {
        let to_world = match element.child("to_world") {
            Some(t) => self.transform(t)?,
            None => DMat4::IDENTITY,
        };
        for child in &element.children {
            let held = self.resolved(child)?;
            if matches!(held.tag.as_str(), "bsdf" | "emitter" | "sensor" | "texture") {
                return Err(child.error("an instance holds a shapegroup and nothing else"));
            }
        }
        for group in self.nested(element, "shape")? {
            group.used.set(true);
            if group.kind() != "shapegroup" {
                return Err(group.error("an instance needs a shapegroup"));
            }
            for shape in group.tagged("shape") {
                if matches!(shape.kind(), "instance" | "shapegroup") {
                    return Err(shape.error("a shapegroup cannot hold instances"));
                }
                self.shape(shape, outer * to_world)?;
            }
        }
        Ok(())
    }

    fn shape_material(&mut self, element: &'a Element) -> Result<usize, SceneError> {
        match self.nested(element, "bsdf")?[..] {
            [bsdf] => self.material(bsdf),
            // A lamp that says nothing reflects nothing.
            [] if !self.nested(element, "emitter")?.is_empty() => Ok(self.black_material()),
            [] => Ok(0),
            [_, second, ..] => Err(second.error("a shape has one material")),
        }
    }

    /// The index of a material that reflects nothing.
    fn black_material(&mut self) -> usize {
        if let Some(index) = self.black {
            return index;
        }
        let mut material = Material::diffuse("black", [0.0; 3]);
        material.two_sided = false;
        self.scene.materials.push(material);
        *self.black.insert(self.scene.materials.len() - 1)
    }

    /// Says where a scale makes something else of a round shape, which Mitsuba does not expect.
    fn note_uneven(&mut self, source: &ShapeSource, linear: DMat3) {
        let kind = match source {
            ShapeSource::Sphere { .. } if !is_even(linear, &[DVec3::X, DVec3::Y, DVec3::Z]) => {
                "a sphere becomes an ellipsoid"
            }
            ShapeSource::Cylinder { from, to, .. } => {
                let (right, up) = (*to - *from).normalize_or(DVec3::Z).any_orthonormal_pair();
                match is_even(linear, &[right, up]) {
                    true => return,
                    false => "a cylinder becomes an elliptic one",
                }
            }
            _ => return,
        };
        self.note(format!(
            "{kind}: its transform scales unevenly, which Mitsuba warns of"
        ));
    }

    /// What a shape emits, and the texture that this is a factor of.
    fn area_emission(&mut self, element: &'a Element) -> Result<Emission, SceneError> {
        let emitters = self.nested(element, "emitter")?;
        let emitter = match emitters[..] {
            [] => return Ok((None, None)),
            [emitter] => emitter,
            [_, second, ..] => return Err(second.error("a shape has one emitter")),
        };
        emitter.used.set(true);
        if emitter.kind() != "area" {
            emitter.mark_all();
            self.note(format!(
                "emitter `{}` on a shape is left out",
                emitter.kind()
            ));
            return Ok((None, None));
        }
        self.sampling_weight(emitter)?;
        let Some(radiance) = emitter.child("radiance") else {
            return Ok((Some([1.0; 3]), None));
        };
        let radiance = self.resolved(radiance)?;
        let is_spectrum = matches!(radiance.kind(), "regular" | "irregular" | "blackbody");
        if radiance.tag == "texture" && !is_spectrum {
            return match self.scaled_source(radiance)? {
                (ColourSource::Constant(colour), _) => Ok((Some(colour), None)),
                (ColourSource::Texture(index), factor) => Ok((Some(factor), Some(index))),
                (ColourSource::Vertices, _) => {
                    Err(radiance.error("a light cannot have the colours of vertices"))
                }
            };
        }
        Ok((Some(shining(radiance, "radiance")?), None))
    }
}

/// Whether a linear map keeps perpendicular unit vectors perpendicular and of equal lengths.
fn is_even(linear: DMat3, axes: &[DVec3]) -> bool {
    let mapped: Vec<DVec3> = axes.iter().map(|axis| linear * *axis).collect();
    let size = mapped[0].length_squared();
    let equal = |v: &DVec3| (v.length_squared() - size).abs() <= 2.0 * EVEN * size;
    let perpendicular = |(i, v): (usize, &DVec3)| {
        let mut others = mapped[i + 1..].iter();
        others.all(|other| v.dot(*other).abs() <= EVEN * size)
    };
    mapped.iter().all(equal) && mapped.iter().enumerate().all(perpendicular)
}
