//! Material libraries of OBJ files.
//!
//! Read here and not by `tobj`, whose MTL parser panics on colours with fewer than three numbers.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::obj_text::{bare, plain_obj, statements};
use super::text::{decoded, file_error};
use super::{Bsdf, ColourSource, MicrofacetDistribution, SceneError};

mod map;
mod uses;

pub(super) use map::MtlMap;
use uses::Uses;
pub(super) use uses::used_materials;

/// What is used of a `newmtl` block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlMaterial {
    pub name: String,
    /// `Kd`, if the library gives it.
    pub diffuse: Option<[f32; 3]>,
    /// `map_Kd`, which is multiplied by `Kd`.
    pub diffuse_map: Option<MtlMap>,
    /// `Ks` and `Ns`.
    pub specular: [f32; 3],
    pub exponent: f32,
    /// `d`, or one minus `Tr`.
    pub opacity: f32,
    /// `map_d`, which is multiplied by `d`.
    pub opacity_map: Option<MtlMap>,
    /// `Ke`.
    pub emission: [f32; 3],
}

/// What a library says of light that passes or is mirrored, of which nothing is built.
#[derive(Default)]
struct Optics {
    /// `Ni`.
    index: Option<f32>,
    /// `Tf`.
    filter: Option<[f32; 3]>,
    /// `illum`.
    model: Option<f32>,
}

impl MtlMaterial {
    /// A grey: what stands for a material whose library is absent.
    fn grey(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            diffuse: Some([0.5; 3]),
            diffuse_map: None,
            specular: [0.0; 3],
            exponent: 0.0,
            opacity: 1.0,
            opacity_map: None,
            emission: [0.0; 3],
        }
    }
}

/// The materials of an OBJ file.
#[derive(Debug, Default)]
pub(super) struct ObjMaterials {
    /// Those that faces use, in order of use; empty if the file is absent or names none.
    pub materials: Vec<MtlMaterial>,
    /// What is absent, or not understood.
    pub notes: Vec<String>,
    /// Libraries that cannot be read, where a face uses a material that no other one has.
    pub absent_libraries: Vec<PathBuf>,
}

/// Reads the libraries that an OBJ file names; the materials are those of its faces, or of those of a part.
pub(super) fn materials_of(obj: &Path, part: Option<&str>) -> Result<ObjMaterials, SceneError> {
    let mut notes = Vec::new();
    let mut absent_libraries = Vec::new();
    if !obj.exists() {
        return Ok(ObjMaterials::default());
    }
    let bytes = crate::files::read(obj).map_err(|e| file_error(obj, e.to_string()))?;
    let text = plain_obj(&bytes).text;
    let folder = obj.parent().unwrap_or(Path::new(""));
    let mut declared = Vec::new();
    let mut read = HashSet::new();
    for names in text.lines().filter_map(|l| value_of(l, "mtllib")) {
        for library in libraries(folder, names) {
            if !read.insert(library.clone()) {
                continue;
            }
            match crate::files::read(&library) {
                Ok(bytes) => declared.extend(parse_mtl(&decoded(&bytes), &library, &mut notes)),
                Err(error) => {
                    notes.push(format!("material library {}: {error}", library.display()));
                    absent_libraries.push(library);
                }
            }
        }
    }
    let Some(Uses {
        named: used,
        nameless,
    }) = Uses::of_part(&text, part)
    else {
        // That there is no such part is told when its faces are read.
        return Ok(ObjMaterials::default());
    };
    if used.is_empty() {
        return Ok(ObjMaterials {
            notes,
            ..ObjMaterials::default()
        });
    }
    let mut by_name = HashMap::new();
    for material in &declared {
        let first = *by_name.entry(material.name.as_str()).or_insert(material);
        if first != material && used.contains(&material.name.as_str()) {
            let name = &material.name;
            notes.push(format!(
                "material `{name}` is declared again: the first one counts"
            ));
        }
    }
    let nameless = nameless.then(|| MtlMaterial::grey(""));
    if used.iter().all(|name| by_name.contains_key(name)) {
        absent_libraries.clear();
    }
    let named = used
        .iter()
        .map(|name| match by_name.get(name) {
            Some(&material) => material.clone(),
            None => {
                notes.push(format!(
                    "material `{name}` is in no library: grey 0.5 instead"
                ));
                MtlMaterial::grey(name)
            }
        })
        .collect::<Vec<_>>();
    Ok(ObjMaterials {
        materials: nameless.into_iter().chain(named).collect(),
        notes,
        absent_libraries,
    })
}

/// The libraries that a `mtllib` names: one, whose name may have blanks, or several with blanks between them.
fn libraries(folder: &Path, names: &str) -> Vec<PathBuf> {
    let file = |name: &str| named_file(folder, name);
    let one = file(names);
    match one.exists() {
        true => vec![one],
        false => names.split_whitespace().map(file).collect(),
    }
}

/// The file of a name that may have backslashes, and quotes around it as some exporters write them.
fn named_file(folder: &Path, name: &str) -> PathBuf {
    let quoted = name.strip_prefix('"').and_then(|n| n.strip_suffix('"'));
    folder.join(quoted.unwrap_or(name).replace('\\', "/"))
}

/// The rest of a line that starts with a keyword.
fn value_of<'a>(line: &'a str, keyword: &str) -> Option<&'a str> {
    let rest = line.trim_start().strip_prefix(keyword)?;
    let value = rest.trim();
    (rest.starts_with(char::is_whitespace) && !value.is_empty()).then_some(value)
}

/// The materials of a library and what is not understood of it.
pub(super) fn read_mtl(bytes: &[u8], path: &Path) -> (Vec<MtlMaterial>, Vec<String>) {
    let mut notes = Vec::new();
    let materials = parse_mtl(&decoded(bytes), path, &mut notes);
    (materials, notes)
}

/// The materials of a library; what is not understood is noted and left out.
fn parse_mtl(text: &str, path: &Path, notes: &mut Vec<String>) -> Vec<MtlMaterial> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut materials: Vec<MtlMaterial> = Vec::new();
    let mut has_opacity = false;
    let mut optics = Optics::default();
    let mut line = 1;
    for (statement, lines) in statements(text) {
        let (keyword, rest) = split_word(&statement);
        let note = |what: &str| format!("{}:{line}: {what}", path.display());
        if keyword == "newmtl" {
            has_opacity = false;
            if let Some(before) = materials.last() {
                notes.extend(std::mem::take(&mut optics).notes(before, path));
            }
            materials.push(MtlMaterial {
                diffuse: None,
                ..MtlMaterial::grey(rest)
            });
        } else if let Some(material) = materials.last_mut() {
            let done = match keyword {
                "map_Kd" | "map_d" => MtlMap::read(rest, folder).map(|map| {
                    notes.extend(map.left_out.iter().map(|what| note(what)));
                    match keyword {
                        "map_Kd" => material.diffuse_map = Some(map),
                        _ if map.base != 0.0 => {
                            notes.push(note("the base value of `-mm` is left out"));
                            material.opacity_map = Some(map);
                        }
                        _ => material.opacity_map = Some(map),
                    }
                }),
                // Where both stand `d` decides.
                "Tr" if has_opacity => Ok(()),
                "Kd" | "Ks" | "Ke" | "Ns" | "d" | "Tr" => {
                    has_opacity |= keyword == "d";
                    colour(rest).map(|colour| {
                        let kept = in_range(keyword, colour);
                        if kept != colour {
                            notes.push(note(&format!("`{keyword}` is out of range and clamped")));
                        }
                        set(material, keyword, kept);
                    })
                }
                "Ni" => colour(rest).map(|n| optics.index = Some(n[0])),
                "Tf" => colour(rest).map(|filter| optics.filter = Some(filter)),
                "illum" => colour(rest).map(|model| optics.model = Some(model[0])),
                // What no shading here depends on.
                "Ka" | "map_Ka" | "sharpness" | "map_aat" | "" => Ok(()),
                _ => Err("only Kd, Ks, Ke, Ns, d, Tr, map_Kd and map_d are read".to_owned()),
            };
            if let Err(why) = done {
                notes.push(note(&format!("`{keyword}` is left out: {why}")));
            }
        } else if !keyword.is_empty() {
            notes.push(note(&format!(
                "`{keyword}` is left out: it stands before the first `newmtl`"
            )));
        }
        line += lines;
    }
    if let Some(last) = materials.last() {
        notes.extend(optics.notes(last, path));
    }
    materials
}

impl Optics {
    /// What is not built of it and would change the look of a material.
    fn notes(&self, material: &MtlMaterial, path: &Path) -> Vec<String> {
        let place = format!("{}: material `{}`", path.display(), material.name);
        let model = self.model.unwrap_or(2.0);
        let glass = [4.0, 6.0, 7.0, 9.0].contains(&model);
        let passes = glass || material.opacity < 1.0 || material.opacity_map.is_some();
        let mut notes = Vec::new();
        if material.diffuse_map.is_some() && material.diffuse == Some([0.0; 3]) {
            notes.push(format!("{place}: its `Kd` of 0 makes `map_Kd` black"));
        }
        if model < 2.0 && material.specular.iter().any(|&s| s > 0.0) {
            notes.push(format!(
                "{place}: `illum {model}` has no gloss, its `Ks` is kept"
            ));
        }
        if glass {
            notes.push(format!(
                "{place}: `illum {model}` asks for glass, which is not built: `d` alone counts"
            ));
        }
        if model == 10.0 {
            notes.push(format!(
                "{place}: `illum 10` shows shadows alone, here the surface as well"
            ));
        }
        if passes && !glass && self.index.is_some_and(|n| n != 1.0) {
            notes.push(format!(
                "{place}: `Ni` is left out: what passes is not bent"
            ));
        }
        if passes && self.filter.is_some_and(|filter| filter != [1.0; 3]) {
            notes.push(format!(
                "{place}: `Tf` is left out: what passes is not coloured"
            ));
        }
        notes
    }
}

/// The first word of a text, and what follows it.
fn split_word(text: &str) -> (&str, &str) {
    let text = text.trim();
    match text.split_once(char::is_whitespace) {
        Some((word, rest)) => (word, rest.trim_start()),
        None => (text, ""),
    }
}

/// A grey or a colour; what stands behind the third number, such as an alpha, does not count.
fn colour(text: &str) -> Result<[f32; 3], String> {
    let words: Vec<&str> = bare(text).split_whitespace().take(3).collect();
    let number = |word: &&str| word.parse::<f32>().ok().filter(|n| n.is_finite());
    let numbers: Option<Vec<f32>> = words.iter().map(number).collect();
    match numbers.as_deref() {
        Some([grey]) => Ok([*grey; 3]),
        Some([r, g, b]) => Ok([*r, *g, *b]),
        _ => Err(format!(
            "one or three numbers were expected, found `{text}`"
        )),
    }
}

/// A colour in the range of what it stands for.
fn in_range(keyword: &str, colour: [f32; 3]) -> [f32; 3] {
    let most = match keyword {
        "Ke" | "Ns" => f32::MAX,
        _ => 1.0,
    };
    colour.map(|value| value.clamp(0.0, most))
}

fn set(material: &mut MtlMaterial, keyword: &str, colour: [f32; 3]) {
    match keyword {
        "Kd" => material.diffuse = Some(colour),
        "Ks" => material.specular = colour,
        "Ke" => material.emission = colour,
        "Ns" => material.exponent = colour[0],
        "d" => material.opacity = colour[0],
        _ => material.opacity = 1.0 - colour[0],
    }
}

/// Diffuse plus a Phong lobe as a coated diffuse surface: α = √(2/(n+2)), and an index of refraction
/// whose reflectance at normal incidence is the strongest specular channel. Without lobe: diffuse.
pub(super) fn coated(diffuse: ColourSource, specular: [f32; 3], alpha: f32) -> Bsdf {
    let strongest = specular.iter().fold(0.0_f32, |a, &b| a.max(b)).min(0.95);
    if strongest <= 0.0 {
        return Bsdf::Diffuse {
            reflectance: diffuse,
        };
    }
    let root = strongest.sqrt();
    Bsdf::Plastic {
        diffuse,
        specular: specular.map(|s| (s / strongest).min(1.0)),
        ior: (1.0 + root) / (1.0 - root),
        alpha,
        distribution: MicrofacetDistribution::Ggx,
        nonlinear: false,
        lossless: true,
    }
}

/// GGX α of a Phong exponent.
pub(super) fn phong_alpha(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).sqrt()
}

#[cfg(test)]
mod tests;
