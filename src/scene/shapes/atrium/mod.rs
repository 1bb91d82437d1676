//! A tiled courtyard between two-storeyed arcades, with hanging chains, curtains and vases.

mod arcade;
mod court;
mod curtains;
mod lanterns;
mod vases;

use super::PartFunction;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("light-tiles", court::light_tiles),
    ("dark-tiles", court::dark_tiles),
    ("slab", court::slab),
    ("walls", court::walls),
    ("columns", arcade::columns),
    ("arches", arcade::arches),
    ("cornices", court::cornices),
    ("red-curtains", curtains::red_curtains),
    ("blue-curtains", curtains::blue_curtains),
    ("rails", curtains::rails),
    ("chains", lanterns::chains),
    ("lanterns", lanterns::lanterns),
    ("flames", lanterns::flames),
    ("vases", vases::vases),
];

/// Columns stand at x = ±3 every 2.6 m from z = 2 to z = -21.4; the aisles reach to x = ±5.4.
const ROW_X: f64 = 3.0;
const PITCH: f64 = 2.6;
const BAYS: usize = 9;
const FIRST_Z: f64 = 2.0;
const WALL_X: f64 = 5.4;
const FRONT_Z: f64 = 4.6;
const BACK_Z: f64 = -24.0;

/// Height of the springing line, of the gallery floor and of the wall's top.
const SPRING: f64 = 3.1;
const GALLERY: f64 = 4.9;
const TOP: f64 = 9.4;

fn column_z(i: usize) -> f64 {
    FIRST_Z - PITCH * i as f64
}
