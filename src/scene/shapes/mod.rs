//! Shapes generated in code, by name.
//!
//! A generator stands for one scene and is a list of named parts, one function each, so that a scene
//! file can give every part its own material without anything being generated twice. Lengths are
//! metres, y is up. The same parameters give the same bits on any number of threads.
//!
//! Every generator knows `detail` (default 1, 0.1 to 4: factor on the number of facets along a curve,
//! so that triangles grow with its square) and `seed` (default 1, for scattered things).

mod arcade_court;
mod atrium;
mod cabinet_room;
mod cornell_curved;
mod country_house;
mod figures;
mod kit;
mod long_street;
mod parameters;
mod robots;
mod stairs;
mod statues;
mod still_life;
mod table;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use super::Mesh;
pub use parameters::Parameters;

/// Makes one part.
type PartFunction = fn(&Parameters) -> Mesh;

/// A scene's worth of parts.
struct Generator {
    name: &'static str,
    parts: &'static [(&'static str, PartFunction)],
}

const GENERATORS: [Generator; 11] = [
    Generator {
        name: "arcade-court",
        parts: arcade_court::PARTS,
    },
    Generator {
        name: "atrium",
        parts: atrium::PARTS,
    },
    Generator {
        name: "cabinet-room",
        parts: cabinet_room::PARTS,
    },
    Generator {
        name: "cornell-curved",
        parts: cornell_curved::PARTS,
    },
    Generator {
        name: "country-house",
        parts: country_house::PARTS,
    },
    Generator {
        name: "long-street",
        parts: long_street::PARTS,
    },
    Generator {
        name: "robots",
        parts: robots::PARTS,
    },
    Generator {
        name: "stairs",
        parts: stairs::PARTS,
    },
    Generator {
        name: "statues",
        parts: statues::PARTS,
    },
    Generator {
        name: "still-life",
        parts: still_life::PARTS,
    },
    Generator {
        name: "table",
        parts: table::PARTS,
    },
];

/// Generates `generator` (or one `part` of it). Errors name what exists.
pub fn generate(
    generator: &str,
    part: Option<&str>,
    parameters: &BTreeMap<String, f64>,
) -> Result<Mesh, String> {
    let known = find(generator)?;
    let parameters = Parameters::new(parameters)?;
    let Some(part) = part else {
        return Ok(kit::merged(known.parts.iter().map(|(_, f)| f(&parameters))));
    };
    match known.parts.iter().find(|(name, _)| *name == part) {
        Some((_, function)) => Ok(function(&parameters)),
        None => Err(format!(
            "the shape generator `{generator}` has no part `{part}`; its parts are {}",
            names(known.parts.iter().map(|(name, _)| *name))
        )),
    }
}

/// Names of the generators.
pub fn generators() -> Vec<&'static str> {
    GENERATORS.iter().map(|g| g.name).collect()
}

/// Names of a generator's parts; an error that lists the generators when there is none of that name.
pub fn parts(generator: &str) -> Result<Vec<&'static str>, String> {
    Ok(find(generator)?
        .parts
        .iter()
        .map(|(name, _)| *name)
        .collect())
}

fn find(generator: &str) -> Result<&'static Generator, String> {
    let found = GENERATORS.iter().find(|g| g.name == generator);
    found.ok_or_else(|| {
        format!(
            "no shape generator is called `{generator}`{}; known are {}",
            crate::suggest::hint(
                generator,
                &GENERATORS.iter().map(|g| g.name).collect::<Vec<_>>()
            ),
            names(GENERATORS.iter().map(|g| g.name))
        )
    })
}

fn names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ")
}
