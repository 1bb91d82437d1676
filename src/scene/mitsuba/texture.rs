//! Textures and colours that may come from them.

use glam::{DMat4, DVec2};

use super::Importer;
use super::element::Element;
use super::spectrum::colour;
use crate::scene::{ColourSource, SceneError, TextureDescription, TextureSource, Wrap};

/// A colour or texture, and the factor of the `scale` textures around it: 1 where it is in the colour already.
pub(super) type Scaled = (ColourSource, [f32; 3]);

/// How deep textures may stand in each other.
const MAX_OPEN: usize = 64;

impl<'a> Importer<'a> {
    /// The colour parameter called by the first of `names` that is given.
    pub(super) fn colour_source(
        &mut self,
        element: &'a Element,
        names: &[&str],
        default: f32,
    ) -> Result<ColourSource, SceneError> {
        match names.iter().find_map(|name| element.child(name)) {
            Some(value) => match self.scaled_source(value)? {
                (ColourSource::Texture(index), factor) => {
                    Ok(ColourSource::Texture(self.times(index, factor)))
                }
                (ColourSource::Constant(colour), _) => Ok(ColourSource::Constant(
                    self.in_range(element, value, colour),
                )),
                (source, _) => Ok(source),
            },
            None => Ok(ColourSource::Constant([default; 3])),
        }
    }

    /// A colour of a material; what no surface reflects or lets pass is clamped.
    fn in_range(&mut self, of: &Element, parameter: &Element, colour: [f32; 3]) -> [f32; 3] {
        let name = parameter.name();
        let share = ["reflectance", "transmittance", "base_color"];
        let clamped = colour.map(|value| value.clamp(0.0, 1.0));
        if clamped == colour || of.tag != "bsdf" || !share.iter().any(|end| name.ends_with(end)) {
            return colour;
        }
        self.note(format!(
            "`{name}` of {} is out of range and clamped to [0, 1]",
            of.kind()
        ));
        clamped
    }

    /// The index of a texture times a factor.
    pub(super) fn times(&mut self, index: usize, factor: [f32; 3]) -> usize {
        if factor == [1.0; 3] {
            return index;
        }
        let mut scaled = self.scene.textures[index].clone();
        scaled.factor = std::array::from_fn(|c| scaled.factor[c] * factor[c]);
        scaled.base = scaled
            .base
            .map(|base| std::array::from_fn(|c| base[c] * factor[c]));
        let textures = &mut self.scene.textures;
        let known = textures.iter().position(|texture| *texture == scaled);
        known.unwrap_or_else(|| {
            textures.push(scaled);
            textures.len() - 1
        })
    }

    /// As [`Self::colour_source`] where no texture can be kept.
    pub(super) fn plain_colour(
        &mut self,
        element: &'a Element,
        name: &str,
        default: f32,
    ) -> Result<[f32; 3], SceneError> {
        match self.colour_source(element, &[name], default)? {
            ColourSource::Constant(value) => Ok(value),
            ColourSource::Texture(_) | ColourSource::Vertices => {
                let kind = element.kind();
                self.note(format!(
                    "the texture of `{name}` of {kind} becomes {default}"
                ));
                Ok([default; 3])
            }
        }
    }

    /// A colour or texture with what scales it.
    pub(super) fn scaled_source(&mut self, element: &'a Element) -> Result<Scaled, SceneError> {
        if self.open_textures >= MAX_OPEN {
            return Err(element.error("textures refer to each other without end"));
        }
        self.open_textures += 1;
        let source = self.source_of(element);
        self.open_textures -= 1;
        source
    }

    fn source_of(&mut self, element: &'a Element) -> Result<Scaled, SceneError> {
        let element = self.resolved(element)?;
        element.used.set(true);
        if !matches!(element.tag.as_str(), "texture") && element.kind().is_empty() {
            return Ok((ColourSource::Constant(colour(element, true)?), [1.0; 3]));
        }
        match element.kind() {
            "bitmap" | "checkerboard" => {
                let index = self.texture(element)?;
                Ok((ColourSource::Texture(index), [1.0; 3]))
            }
            "mesh_attribute" | "vertexcolors" => self.mesh_attribute(element),
            "scale" => self.scale(element),
            "srgb" | "rgb" | "uniform" | "d65" => {
                let name = if element.kind() == "uniform" {
                    "value"
                } else {
                    "color"
                };
                let value = self.colour_source(element, &[name], 1.0)?;
                Ok((value, [1.0; 3]))
            }
            "regular" | "irregular" | "blackbody" => {
                Ok((ColourSource::Constant(colour(element, true)?), [1.0; 3]))
            }
            other => {
                element.mark_all();
                self.note(format!("texture `{other}` becomes a grey of 0.5"));
                Ok((ColourSource::Constant([0.5; 3]), [1.0; 3]))
            }
        }
    }

    /// Colours of vertices; other attributes of meshes are refused.
    fn mesh_attribute(&mut self, element: &'a Element) -> Result<Scaled, SceneError> {
        let name = element.string("name")?.unwrap_or("vertex_color");
        if name != "vertex_color" {
            let message =
                format!("of the attributes of a mesh only `vertex_color` is read, not `{name}`");
            return Err(element.error(message));
        }
        match element.float("scale")?.unwrap_or(1.0) {
            1.0 => Ok((ColourSource::Vertices, [1.0; 3])),
            scale => Err(element.error(format!(
                "the colours of vertices are taken as they are; a scale of {scale} is not built"
            ))),
        }
    }

    fn scale(&mut self, element: &'a Element) -> Result<Scaled, SceneError> {
        let factor = self.plain_colour(element, "scale", 1.0)?;
        let inner = element.children.iter().find(|c| {
            (c.tag == "texture" || c.tag == "ref" || c.tag == "rgb") && c.name() != "scale"
        });
        let Some(inner) = inner else {
            return Err(element.error("a scale texture needs a texture inside"));
        };
        match self.scaled_source(inner)? {
            (ColourSource::Constant(c), _) => {
                let scaled = std::array::from_fn(|i| c[i] * factor[i]);
                Ok((ColourSource::Constant(scaled), [1.0; 3]))
            }
            (ColourSource::Vertices, _) => Err(element.error(
                "the colours of vertices are taken as they are, without a scale around them",
            )),
            (texture, outer) => {
                let both = std::array::from_fn(|c| outer[c] * factor[c]);
                Ok((texture, both))
            }
        }
    }

    /// The index of a bitmap or checkerboard.
    fn texture(&mut self, element: &'a Element) -> Result<usize, SceneError> {
        let key = std::ptr::from_ref(element);
        if let Some(&index) = self.textures.get(&key) {
            return Ok(index);
        }
        let mut description = if element.kind() == "checkerboard" {
            let colours = [
                self.plain_colour(element, "color0", 0.4)?,
                self.plain_colour(element, "color1", 0.2)?,
            ];
            TextureDescription {
                source: TextureSource::Checkerboard(colours),
                nearest: true,
                ..TextureDescription::file("".into())
            }
        } else {
            self.bitmap(element)?
        };
        self.place(element, &mut description)?;
        self.scene.textures.push(description);
        let index = self.scene.textures.len() - 1;
        self.textures.insert(key, index);
        Ok(index)
    }

    fn bitmap(&mut self, element: &Element) -> Result<TextureDescription, SceneError> {
        let mut description = TextureDescription::file(self.path(element)?);
        if element.boolean("raw", false)? {
            description.srgb = false;
        }
        match element.float("gamma")? {
            Some(1.0) => description.srgb = false,
            Some(gamma) if gamma > 0.0 && (gamma - 2.2).abs() > 0.2 => {
                self.note(format!("texture gamma {gamma} becomes the sRGB curve"));
                description.srgb = true;
            }
            _ => {}
        }
        match element.string("filter_type")?.unwrap_or("bilinear") {
            "bilinear" => {}
            "nearest" => description.nearest = true,
            other @ ("ewa" | "trilinear") => {
                self.note(format!("texture filter `{other}` becomes bilinear"));
            }
            other => {
                let known = ["bilinear", "nearest", "trilinear", "ewa"];
                return Err(Self::unknown_word(element, "texture filter", other, &known));
            }
        }
        let mut modes = Vec::new();
        for name in ["wrap_mode", "wrap_mode_u", "wrap_mode_v"] {
            modes.extend(element.string(name)?);
        }
        if modes.windows(2).any(|m| m[0] != m[1]) {
            self.note("wrap modes that differ in u and v become that of u");
        }
        description.wrap = match modes.first().copied().unwrap_or("repeat") {
            "repeat" => Wrap::Repeat,
            "mirror" => Wrap::Mirror,
            "clamp" => Wrap::Clamp,
            "zero" | "one" => {
                self.note("wrap mode `zero` or `one` becomes clamp");
                Wrap::Clamp
            }
            other => {
                let known = ["repeat", "mirror", "clamp", "zero", "one"];
                return Err(Self::unknown_word(element, "wrap mode", other, &known));
            }
        };
        for irrelevant in ["format", "accel", "cache", "max_anisotropy"] {
            element.child(irrelevant);
        }
        Ok(description)
    }

    /// Scale and offset of the texture coordinates, from Mitsuba's v (downwards) to ours (upwards):
    /// 1 − ((1 − v) s + o) = v s + (1 − s − o).
    fn place(
        &mut self,
        element: &Element,
        description: &mut TextureDescription,
    ) -> Result<(), SceneError> {
        let number = |name: &str, default: f64| Ok(element.float(name)?.unwrap_or(default));
        let mut scale = [number("uscale", 1.0)?, number("vscale", 1.0)?];
        let mut offset = [number("uoffset", 0.0)?, number("voffset", 0.0)?];
        if let Some(to_uv) = element.child("to_uv") {
            let matrix = self.transform(to_uv)?;
            if matrix.z_axis.truncate().truncate() != DVec2::ZERO {
                self.note("of the third column of a `to_uv` nothing is used, as in Mitsuba");
            }
            let map = UvMap::of(&matrix);
            description.uv_turn_rad = map.turn_rad as f32;
            description.uv_shear = map.shear as f32;
            scale = map.scale;
            let [along_v, shift] = [matrix.y_axis, matrix.w_axis];
            offset = [shift.x + along_v.x, shift.y + along_v.y - scale[1]];
        }
        description.uv_scale = scale.map(|s| s as f32);
        description.uv_offset = [offset[0] as f32, (1.0 - scale[1] - offset[1]) as f32];
        Ok(())
    }
}

/// A linear map of texture coordinates, in parts that follow one another.
struct UvMap {
    scale: [f64; 2],
    /// How much of v goes to u.
    shear: f64,
    turn_rad: f64,
}

impl UvMap {
    /// Of a transform for coordinates with v downwards, the map for those with v upwards.
    fn of(matrix: &DMat4) -> Self {
        let mirrored = DVec2::new(1.0, -1.0);
        let along_u = matrix.x_axis.truncate().truncate() * mirrored;
        let along_v = matrix.y_axis.truncate().truncate() * -mirrored;
        let size = along_u.length().max(along_v.length());
        let cleaned = |number: f64| {
            if number.abs() <= 1e-9 * size {
                0.0
            } else {
                number
            }
        };
        let (turn_rad, wide) = match cleaned(along_u.y) {
            0.0 => (0.0, along_u.x),
            _ => (along_u.y.atan2(along_u.x), along_u.length()),
        };
        let turned_back = DVec2::from_angle(-turn_rad).rotate(along_v);
        Self {
            scale: [wide, turned_back.y],
            shear: cleaned(turned_back.x),
            turn_rad,
        }
    }
}
