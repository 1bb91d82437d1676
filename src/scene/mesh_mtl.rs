//! Material libraries of OBJ files.
//!
//! Read here and not by `tobj`, whose MTL parser panics on colours with fewer than three numbers.

use std::path::{Path, PathBuf};

use super::text::file_error;
use super::{Bsdf, ColourSource, MicrofacetDistribution, SceneError};

/// What is used of a `newmtl` block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlMaterial {
    pub name: String,
    /// `Kd`.
    pub diffuse: [f32; 3],
    /// `map_Kd`, relative to the library's folder.
    pub diffuse_map: Option<PathBuf>,
    /// `Ks` and `Ns`.
    pub specular: [f32; 3],
    pub exponent: f32,
    /// `d`, or one minus `Tr`.
    pub opacity: f32,
    /// `map_d`.
    pub opacity_map: Option<PathBuf>,
    /// `Ke`.
    pub emission: [f32; 3],
}

impl MtlMaterial {
    /// A grey: what stands for a material whose library is absent.
    fn grey(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            diffuse: [0.5; 3],
            diffuse_map: None,
            specular: [0.0; 3],
            exponent: 0.0,
            opacity: 1.0,
            opacity_map: None,
            emission: [0.0; 3],
        }
    }
}

/// The materials that the faces of an OBJ file use, in order of use, and notes on what is absent.
/// Empty if the file is absent or names no materials.
pub(super) fn materials_of(obj: &Path) -> Result<(Vec<MtlMaterial>, Vec<String>), SceneError> {
    let mut notes = Vec::new();
    if !obj.exists() {
        return Ok((Vec::new(), notes));
    }
    let bytes = std::fs::read(obj).map_err(|e| file_error(obj, e.to_string()))?;
    let text = String::from_utf8_lossy(&bytes);
    let folder = obj.parent().unwrap_or(Path::new(""));
    let mut declared = Vec::new();
    for name in text.lines().filter_map(|l| value_of(l, "mtllib")) {
        let library = folder.join(name.replace('\\', "/"));
        match std::fs::read(&library) {
            Ok(bytes) => declared.extend(parse_mtl(&String::from_utf8_lossy(&bytes), &library)?),
            Err(error) => notes.push(format!("material library {}: {error}", library.display())),
        }
    }
    let used = used_materials(&text);
    if used.is_empty() {
        return Ok((Vec::new(), notes));
    }
    let lines = text.lines().map(str::trim_start);
    let mut until_first = lines.take_while(|l| value_of(l, "usemtl").is_none());
    // Faces before the first `usemtl` have the material without a name.
    let nameless = until_first.any(|l| value_of(l, "f").is_some());
    let nameless = nameless.then(|| MtlMaterial::grey(""));
    let named = used
        .iter()
        .map(|name| match declared.iter().find(|m| m.name == *name) {
            Some(material) => material.clone(),
            None => {
                notes.push(format!(
                    "material `{name}` is in no library: grey 0.5 instead"
                ));
                MtlMaterial::grey(name)
            }
        })
        .collect::<Vec<_>>();
    Ok((nameless.into_iter().chain(named).collect(), notes))
}

/// Names after `usemtl`, each once, in order.
pub(super) fn used_materials(obj_text: &str) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for name in obj_text.lines().filter_map(|l| value_of(l, "usemtl")) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The rest of a line that starts with a keyword.
fn value_of<'a>(line: &'a str, keyword: &str) -> Option<&'a str> {
    let rest = line.trim_start().strip_prefix(keyword)?;
    let value = rest.trim();
    (rest.starts_with(char::is_whitespace) && !value.is_empty()).then_some(value)
}

fn parse_mtl(text: &str, path: &Path) -> Result<Vec<MtlMaterial>, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut materials: Vec<MtlMaterial> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or("");
        if let Some(name) = value_of(line, "newmtl") {
            materials.push(MtlMaterial {
                diffuse: [0.8; 3],
                ..MtlMaterial::grey(name)
            });
            continue;
        }
        let Some(material) = materials.last_mut() else {
            continue;
        };
        // Options such as `-bm 1` may stand before the file.
        let map = || {
            line.split_whitespace()
                .last()
                .map(|f| folder.join(f.replace('\\', "/")))
        };
        match keyword {
            "map_Kd" => material.diffuse_map = map(),
            "map_d" => material.opacity_map = map(),
            "Kd" | "Ks" | "Ke" | "Ns" | "d" | "Tr" => {
                let numbers: Option<Vec<f32>> = words.map(|w| w.parse().ok()).collect();
                let colour = match numbers.as_deref() {
                    Some([grey]) => [*grey; 3],
                    Some([r, g, b]) => [*r, *g, *b],
                    _ => {
                        return Err(SceneError::At {
                            file: path.to_owned(),
                            line: index + 1,
                            column: 1,
                            message: format!("`{keyword}` needs one or three numbers"),
                        });
                    }
                };
                set(material, keyword, colour);
            }
            _ => {}
        }
    }
    Ok(materials)
}

fn set(material: &mut MtlMaterial, keyword: &str, colour: [f32; 3]) {
    match keyword {
        "Kd" => material.diffuse = colour,
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
    }
}

/// GGX α of a Phong exponent.
pub(super) fn phong_alpha(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_are_read_and_damage_is_named() {
        let text = "# x\nnewmtl a b\nKd 0.1 0.2 0.3\nKs 0.04\nNs 48\nTr 0.25\nmap_Kd -s 1 1 1 t\\x.png\nillum 2\nnewmtl c\n";
        let materials = parse_mtl(text, Path::new("d/m.mtl")).unwrap();
        assert_eq!(materials.len(), 2);
        let m = &materials[0];
        assert_eq!(
            (m.name.as_str(), m.diffuse, m.opacity),
            ("a b", [0.1, 0.2, 0.3], 0.75)
        );
        assert_eq!(m.diffuse_map.as_deref(), Some(Path::new("d/t/x.png")));
        assert!((phong_alpha(m.exponent) - 0.2).abs() < 1e-6);
        let error = parse_mtl("newmtl a\nKd 0.1 0.2\n", Path::new("m.mtl")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "m.mtl:2:1: `Kd` needs one or three numbers"
        );
    }
}
