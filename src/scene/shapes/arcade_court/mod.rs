//! A court between two storeys of arcades on all four sides, with vaults, curtains, a fountain and
//! lamps: three small ones in the lower arcade, one of them on a rail, and a large one over the court.

mod columns;
mod court;
mod furniture;
mod lamps;
mod vaults;
mod walls;

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::kit::{merged, placed};
use super::{Mesh, PartFunction};

pub const PARTS: &[(&str, PartFunction)] = &[
    ("light-tiles", court::light_tiles),
    ("dark-tiles", court::dark_tiles),
    ("bed", court::bed),
    ("walls", walls::walls),
    ("doors", walls::doors),
    ("gallery", walls::gallery),
    ("roof", walls::roof),
    ("vaults", vaults::vaults),
    ("arches", vaults::arches),
    ("columns", columns::columns),
    ("pilasters", columns::pilasters),
    ("balustrade", columns::balustrade),
    ("red-curtains", furniture::red_curtains),
    ("green-curtains", furniture::green_curtains),
    ("rods", furniture::rods),
    ("fountain", court::fountain),
    ("water", court::water),
    ("figures", furniture::figures),
    ("pedestals", furniture::pedestals),
    ("planters", furniture::planters),
    ("leaves", furniture::leaves),
    ("benches", furniture::benches),
    ("lamp-rail", lamps::rail),
    ("lamp-holders", lamps::holders),
    ("lamp-1-holder", lamps::moving_holder),
    ("lamp-1", |p| lamps::small(p, 0)),
    ("lamp-2", |p| lamps::small(p, 1)),
    ("lamp-3", |p| lamps::small(p, 2)),
    ("great-lamp", lamps::great),
];

/// Width of a bay; the court is three bays wide (x) and six long (z).
const PITCH: f64 = 8.0 / 3.0;
const COURT: [f64; 2] = [4.0, 8.0];

/// Depth of the aisles behind the arcades.
const AISLE: f64 = 2.8;

/// Height of the springing lines, of the gallery's floor and of the ceiling over the gallery.
const SPRING: f64 = 2.7;
const SLAB: f64 = 4.2;
const GALLERY: f64 = 4.5;
const UPPER_SPRING: f64 = 6.55;
const TOP: f64 = 8.0;

/// What `make` builds for a side of so many bays, on all four sides. In its frame x runs along the
/// arcade from its middle, z points into the court, and the columns stand at z = 0.
fn around(make: impl Fn(usize) -> Mesh) -> Mesh {
    let long = make(6);
    let short = make(3);
    let side = |mesh: &Mesh, quarter: f64, distance: f64| {
        let turn = DMat4::from_rotation_y(PI * 0.5 * quarter);
        placed(
            mesh,
            turn * DMat4::from_translation(DVec3::new(0.0, 0.0, -distance)),
        )
    };
    merged([
        side(&short, 0.0, COURT[1]),
        side(&long, 1.0, COURT[0]),
        side(&short, 2.0, COURT[1]),
        side(&long, 3.0, COURT[0]),
    ])
}

/// Middles of the bays of a side.
fn bays(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| PITCH * (i as f64 + 0.5 - count as f64 * 0.5))
}

/// Where the columns of a side stand, without those in the corners.
fn inner_columns(count: usize) -> impl Iterator<Item = f64> {
    (1..count).map(move |i| PITCH * (i as f64 - count as f64 * 0.5))
}

/// The corners of the court.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
