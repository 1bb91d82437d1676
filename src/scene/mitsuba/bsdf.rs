//! Materials: the models that we have, and the nearest of them for the others.

use super::Importer;
use super::conductor::{conductor, dielectric, dielectric_names};
use super::element::Element;
use super::spectrum::colour;
use crate::scene::mesh_mtl::{coated, phong_alpha};
use crate::scene::text::advice;
use crate::scene::{Bsdf, ColourSource, Material, MicrofacetDistribution, Roughness, SceneError};

/// How deep wrappers may nest (`<ref>`s can form loops).
pub(super) const MAX_NESTING: usize = 16;

const SMOOTH: Roughness = Roughness {
    alpha: 0.0,
    distribution: MicrofacetDistribution::Ggx,
};

impl<'a> Importer<'a> {
    /// The index of the material of a `<bsdf>`.
    pub(super) fn material(&mut self, element: &'a Element) -> Result<usize, SceneError> {
        let key = std::ptr::from_ref(element);
        if let Some(&index) = self.materials.get(&key) {
            return Ok(index);
        }
        let mut material = self.bsdf(element, 0)?;
        material.name = match element.id() {
            Some(id) => id.to_owned(),
            None => format!("{} {}", element.kind(), self.scene.materials.len()),
        };
        self.scene.materials.push(material);
        let index = self.scene.materials.len() - 1;
        self.materials.insert(key, index);
        Ok(index)
    }

    pub(super) fn bsdf(
        &mut self,
        element: &'a Element,
        depth: usize,
    ) -> Result<Material, SceneError> {
        element.used.set(true);
        if depth > MAX_NESTING {
            return Err(element.error("materials refer to each other in a circle"));
        }
        let bsdf = match element.kind() {
            "twosided" => return self.two_sided(element, depth),
            "mask" => return self.mask(element, depth),
            "bumpmap" => return self.bump_map(element, depth),
            "normalmap" => return self.normal_map(element, depth),
            "coating" | "roughcoating" => {
                let kind = element.kind();
                self.note(format!("`{kind}` around a material is dropped"));
                return self.unwrapped(element, depth);
            }
            "blendbsdf" => {
                return match self.diffuse_blend(element, depth)? {
                    Some(mixed) => Ok(mixed),
                    None => self.blend(element, depth),
                };
            }
            "mixturebsdf" => return self.mixture(element, depth),
            "null" => {
                let mut material = one_sided(black());
                material.opacity = Some(ColourSource::Constant([0.0; 3]));
                return Ok(material);
            }
            "diffuse" => self.diffuse(element)?,
            "roughdiffuse" => {
                element.child("alpha");
                self.note("`roughdiffuse` becomes diffuse");
                self.diffuse(element)?
            }
            "plastic" => self.plastic(element, SMOOTH)?,
            "roughplastic" => {
                let facets = self.facets(element)?;
                self.plastic(element, facets)?
            }
            "conductor" => self.conductor(element, SMOOTH)?,
            "roughconductor" => {
                let facets = self.facets(element)?;
                self.conductor(element, facets)?
            }
            "dielectric" | "thindielectric" => self.dielectric(element, None)?,
            "roughdielectric" => {
                let facets = self.facets(element)?;
                self.dielectric(element, Some(facets))?
            }
            "phong" | "ward" => self.phong(element)?,
            "principled" | "principledthin" => self.principled(element)?,
            other => {
                element.mark_all();
                self.note(format!(
                    "material type `{other}` becomes a diffuse grey of 0.5"
                ));
                diffuse_of(ColourSource::Constant([0.5; 3]))
            }
        };
        Ok(one_sided(bsdf))
    }

    /// A material for both sides, or one for each.
    fn two_sided(&mut self, element: &'a Element, depth: usize) -> Result<Material, SceneError> {
        let nested = self.nested(element, "bsdf")?;
        let [first, second] = nested[..] else {
            let both = self.inner(element, depth)?;
            if matches!(both.bsdf, Bsdf::Dielectric { .. }) {
                self.note("`twosided` around glass is dropped, which Mitsuba refuses");
            }
            return Ok(self.around(both, |part| part.two_sided = true));
        };
        let mut front = self.bsdf(first, depth + 1)?;
        front.back = Some(self.part(second, depth)?);
        Ok(self.around(front, |side| side.two_sided = true))
    }

    /// The index of a material inside another one.
    pub(super) fn part(&mut self, element: &'a Element, depth: usize) -> Result<usize, SceneError> {
        let part = self.bsdf(element, depth + 1)?;
        Ok(self.part_of(part, element.kind()))
    }

    /// The index of a material that has no name of its own.
    pub(super) fn part_of(&mut self, part: Material, kind: &str) -> usize {
        let index = self.scene.materials.len();
        let name = format!("{kind} {index}");
        self.scene.materials.push(Material { name, ..part });
        index
    }

    /// Gives a material, and all that it refers to, what surrounds it.
    fn around(&mut self, mut outer: Material, wrap: impl Fn(&mut Material)) -> Material {
        wrap(&mut outer);
        let mut pending: Vec<usize> = outer.others().collect();
        while let Some(index) = pending.pop() {
            let part = &mut self.scene.materials[index];
            wrap(part);
            pending.extend(part.others());
        }
        outer
    }

    /// The first material inside a wrapper.
    fn inner(&mut self, element: &'a Element, depth: usize) -> Result<Material, SceneError> {
        let nested = self.nested(element, "bsdf")?;
        let Some(&first) = nested.first() else {
            return Err(element.error(format!("`{}` needs a material inside", element.kind())));
        };
        if nested.len() > 1 {
            nested[1..].iter().for_each(|n| n.mark_all());
            self.note(format!(
                "only the first material inside `{}` is kept",
                element.kind()
            ));
        }
        self.bsdf(first, depth + 1)
    }

    /// The first material inside a wrapper whose own parameters are dropped.
    fn unwrapped(&mut self, element: &'a Element, depth: usize) -> Result<Material, SceneError> {
        let nested = self.nested(element, "bsdf")?;
        element.mark_all();
        match nested.first() {
            Some(first) => self.bsdf(first, depth + 1),
            None => Err(element.error(format!("`{}` needs a material inside", element.kind()))),
        }
    }

    fn mask(&mut self, element: &'a Element, depth: usize) -> Result<Material, SceneError> {
        let opacity = self.colour_source(element, &["opacity"], 0.5)?;
        let inner = self.inner(element, depth)?;
        Ok(self.around(inner, |side| side.opacity = Some(opacity)))
    }

    fn bump_map(&mut self, element: &'a Element, depth: usize) -> Result<Material, SceneError> {
        let scale = element.float("scale")?.unwrap_or(1.0) as f32;
        let texture = element
            .children
            .iter()
            .find(|c| c.tag == "texture" || self.resolved(c).is_ok_and(|r| r.tag == "texture"));
        let inner = self.inner(element, depth)?;
        let bump = match texture {
            Some(texture) => match self.scaled_source(texture)? {
                (ColourSource::Texture(index), [grey, g, b]) if [g, b] == [grey; 2] => {
                    Some((index, scale * grey))
                }
                (ColourSource::Texture(index), factor) => Some((self.times(index, factor), scale)),
                (ColourSource::Constant(_), _) => {
                    self.note("a constant bump map is dropped");
                    None
                }
                (ColourSource::Vertices, _) => {
                    return Err(texture.error("colours of vertices are no bump map"));
                }
            },
            None => return Err(element.error("`bumpmap` needs a texture inside")),
        };
        let soft = self.is_softened(element)?;
        Ok(self.around(inner, |side| {
            side.bump = bump.or(side.bump);
            side.soft_terminators = soft;
        }))
    }

    fn normal_map(&mut self, element: &'a Element, depth: usize) -> Result<Material, SceneError> {
        let texture = element
            .children
            .iter()
            .find(|c| self.resolved(c).is_ok_and(|r| r.tag == "texture"));
        let inner = self.inner(element, depth)?;
        let Some(texture) = texture else {
            return Err(element.error("`normalmap` needs a texture inside"));
        };
        match self.scaled_source(texture)? {
            (ColourSource::Texture(index), [1.0, 1.0, 1.0]) => {
                let soft = self.is_softened(element)?;
                Ok(self.around(inner, |side| {
                    side.normals = Some(index);
                    side.soft_terminators = soft;
                }))
            }
            _ => Err(texture.error("normals come from a bitmap, without a scale around it")),
        }
    }

    /// Whether the shadows of bent normals are softened.
    fn is_softened(&mut self, element: &Element) -> Result<bool, SceneError> {
        if !element.boolean("flip_invalid_normals", true)? {
            self.note("bent normals that face away from the viewer are turned round, as with `flip_invalid_normals` on");
        }
        element.boolean("use_shadowing_function", true)
    }

    fn diffuse(&mut self, element: &'a Element) -> Result<Bsdf, SceneError> {
        let names = ["reflectance", "diffuse_reflectance"];
        Ok(diffuse_of(self.colour_source(element, &names, 0.5)?))
    }

    fn plastic(&mut self, element: &'a Element, facets: Roughness) -> Result<Bsdf, SceneError> {
        let ior = self.relative_ior(element, 1.49)?;
        Ok(Bsdf::Plastic {
            diffuse: self.colour_source(element, &["diffuse_reflectance"], 0.5)?,
            specular: self.plain_colour(element, "specular_reflectance", 1.0)?,
            ior,
            alpha: facets.alpha,
            distribution: facets.distribution,
            nonlinear: element.boolean("nonlinear", false)?,
            lossless: false,
        })
    }

    fn conductor(&mut self, element: &'a Element, facets: Roughness) -> Result<Bsdf, SceneError> {
        let (mut eta, mut k) = self.conductor_preset(element)?;
        if let Some(value) = element.child("eta") {
            eta = colour(self.resolved(value)?, false)?;
            if self.version.0 > 0 {
                // The default of the new versions, which have no preset beside `eta`.
                k = [1.0; 3];
            }
        }
        if let Some(value) = element.child("k") {
            k = colour(self.resolved(value)?, false)?;
        }
        let outside = self.ior(element, "ext_eta", 1.0)? as f32;
        Ok(Bsdf::Conductor {
            eta: eta.map(|v| v / outside),
            k: k.map(|v| v / outside),
            specular: self.colour_source(element, &["specular_reflectance"], 1.0)?,
            alpha: facets.alpha,
            distribution: facets.distribution,
        })
    }

    fn conductor_preset(
        &mut self,
        element: &'a Element,
    ) -> Result<([f32; 3], [f32; 3]), SceneError> {
        let default = if self.version.0 == 0 { "Cu" } else { "none" };
        let name = element.string("material")?.unwrap_or(default);
        let indices = ["eta", "k"].map(|n| element.children.iter().any(|c| c.name() == n));
        if default == "Cu" && name == default && indices == [false; 2] {
            self.note("a conductor without `material` is copper, as in version 0.x of Mitsuba");
        }
        Ok(conductor(name).unwrap_or_else(|| {
            self.note(format!(
                "conductor `{name}` is not in the table: aluminium instead"
            ));
            conductor("Al").unwrap_or_default()
        }))
    }

    fn dielectric(
        &mut self,
        element: &'a Element,
        roughness: Option<Roughness>,
    ) -> Result<Bsdf, SceneError> {
        Ok(Bsdf::Dielectric {
            ior: self.relative_ior(element, 1.5046)?,
            thin: element.kind() == "thindielectric",
            reflectance: self.plain_colour(element, "specular_reflectance", 1.0)?,
            transmittance: self.plain_colour(element, "specular_transmittance", 1.0)?,
            roughness,
        })
    }

    fn phong(&mut self, element: &'a Element) -> Result<Bsdf, SceneError> {
        let kind = element.kind();
        let specular = self.plain_colour(element, "specular_reflectance", 0.2)?;
        let diffuse = self.colour_source(element, &["diffuse_reflectance"], 0.5)?;
        let alpha = if kind == "phong" {
            phong_alpha(element.float("exponent")?.unwrap_or(30.0) as f32)
        } else {
            self.facets(element)?.alpha
        };
        self.note(format!(
            "`{kind}` becomes a rough coating of the same strength and width"
        ));
        Ok(coated(diffuse, specular, alpha))
    }

    fn principled(&mut self, element: &'a Element) -> Result<Bsdf, SceneError> {
        let base = self.colour_source(element, &["base_color"], 0.5)?;
        let mut number = |name: &str, default: f32| {
            self.plain_colour(element, name, default)
                .map(|c| (c[0] + c[1] + c[2]) / 3.0)
        };
        let metallic = number("metallic", 0.0)?;
        let transmission = number("spec_trans", 0.0)?;
        let roughness = number("roughness", 0.5)?;
        let alpha = (roughness * roughness).max(0.001);
        let ior = element.float("eta")?.unwrap_or(1.5) as f32;
        self.note("`principled` becomes plastic, metal or glass by its strongest part");
        element.mark_all();
        Ok(if transmission > 0.5 {
            Bsdf::Dielectric {
                ior,
                thin: element.kind() == "principledthin",
                reflectance: [1.0; 3],
                transmittance: [1.0; 3],
                roughness: None,
            }
        } else if metallic > 0.5 {
            Bsdf::Conductor {
                eta: [0.0; 3],
                k: [0.0; 3],
                specular: base,
                alpha,
                distribution: MicrofacetDistribution::Ggx,
            }
        } else {
            Bsdf::Plastic {
                diffuse: base,
                specular: [1.0; 3],
                ior,
                alpha,
                distribution: MicrofacetDistribution::Ggx,
                nonlinear: false,
                lossless: true,
            }
        })
    }

    /// Roughness and distribution (Beckmann where none is given); others and anisotropy are
    /// approximated. How normals are sampled (`sample_visible`) changes the noise alone.
    fn facets(&mut self, element: &'a Element) -> Result<Roughness, SceneError> {
        let word = element.string("distribution")?.unwrap_or("beckmann");
        let distribution = match word.to_ascii_lowercase().as_str() {
            "ggx" => MicrofacetDistribution::Ggx,
            "beckmann" => MicrofacetDistribution::Beckmann,
            "phong" | "as" | "ward" | "balanced" | "duer" => {
                self.note(format!(
                    "microfacets `{word}` become Beckmann of the same width"
                ));
                MicrofacetDistribution::Beckmann
            }
            _ => {
                let known = ["ggx", "beckmann", "phong", "as"];
                return Err(Self::unknown_word(element, "distribution", word, &known));
            }
        };
        element.child("sample_visible");
        let alpha = match (element.child("alpha_u"), element.child("alpha_v")) {
            (Some(_), Some(_)) => {
                let u = self.plain_colour(element, "alpha_u", 0.1)?[0];
                let v = self.plain_colour(element, "alpha_v", 0.1)?[0];
                if u != v {
                    self.note("anisotropic roughness becomes its geometric mean");
                }
                (u * v).sqrt()
            }
            _ => self.plain_colour(element, "alpha", 0.1)?[0],
        };
        if alpha >= 0.0 {
            Ok(Roughness {
                // Mitsuba's lower limit: a rough surface never becomes a mirror.
                alpha: alpha.max(1e-4),
                distribution,
            })
        } else {
            Err(element.error(format!("a roughness of {alpha} cannot be")))
        }
    }

    /// Interior over exterior index.
    fn relative_ior(&mut self, element: &'a Element, default: f64) -> Result<f32, SceneError> {
        let inside = self.ior(element, "int_ior", default)?;
        let outside = self.ior(element, "ext_ior", 1.000_277)?;
        Ok((inside / outside) as f32)
    }

    /// An index of refraction given as a number or a name.
    fn ior(&mut self, element: &Element, name: &str, default: f64) -> Result<f64, SceneError> {
        let Some(child) = element.child(name) else {
            return Ok(default);
        };
        let value = if child.tag == "string" {
            let word = child.required("value")?;
            dielectric(word)
                .or_else(|| word.parse().ok())
                .ok_or_else(|| {
                    let advice = advice(word, &dielectric_names());
                    child.error(format!("no dielectric is called `{word}`; {advice}"))
                })?
        } else {
            f64::from(colour(child, false)?[1])
        };
        if value > 0.0 {
            Ok(value)
        } else {
            Err(child.error(format!("an index of refraction of {value} cannot be")))
        }
    }
}

pub(super) fn one_sided(bsdf: Bsdf) -> Material {
    Material {
        name: String::new(),
        bsdf,
        two_sided: false,
        back: None,
        blend: None,
        opacity: None,
        bump: None,
        normals: None,
        soft_terminators: false,
    }
}

pub(super) fn diffuse_of(reflectance: ColourSource) -> Bsdf {
    Bsdf::Diffuse { reflectance }
}

pub(super) fn black() -> Bsdf {
    diffuse_of(ColourSource::Constant([0.0; 3]))
}
