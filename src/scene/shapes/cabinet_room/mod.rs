//! A kitchen: cabinets with thin handles and door gaps, shelves of bottles and plates, a worktop with
//! sink and tap, a tiled back wall, a window and a lamp.

mod cabinets;
mod furniture;
mod room;
mod tableware;
mod worktop;

use super::{Parameters, PartFunction};
use crate::scene::Mesh;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("floor", room::floor),
    ("walls", room::walls),
    ("ceiling", room::ceiling),
    ("wall-tiles", room::wall_tiles),
    ("carcasses", cabinets::carcasses),
    ("fronts", cabinets::fronts),
    ("handles", cabinets::handles),
    ("worktop", worktop::worktop),
    ("sink-and-tap", worktop::sink_and_tap),
    ("stove", worktop::stove),
    ("shelves", furniture::shelves),
    ("bottles", tableware::bottles),
    ("plates", tableware::plates),
    ("cups", tableware::cups),
    ("towel", worktop::towel),
    ("window", room::window),
    ("lamp", furniture::lamp),
    ("lamp-glow", furniture::lamp_glow),
    ("stools", furniture::stools),
    ("table", furniture::table),
];

/// The part of this name, for a house that has this kitchen in it; empty when there is none.
pub fn part(name: &str, parameters: &Parameters) -> Mesh {
    let found = PARTS.iter().find(|(known, _)| *known == name);
    found.map_or_else(Mesh::default, |(_, make)| make(parameters))
}

/// The room: x = ±2.3, z from -2.2 (the kitchen wall) to 3.2, 2.6 m high.
const ROOM_X: f64 = 2.3;
const BACK_Z: f64 = -2.2;
const FRONT_Z: f64 = 3.2;
const HEIGHT: f64 = 2.6;

/// Fronts of base and wall cabinets, and the worktop's upper side.
const BASE_Z: f64 = BACK_Z + 0.58;
const UPPER_Z: f64 = BACK_Z + 0.34;
const TOP: f64 = 0.9;
const PLINTH: f64 = 0.1;

/// Width of a cabinet; eight stand side by side from x = -2.3 to 2.26.
const UNIT: f64 = 0.57;
const GAP: f64 = 0.002;

fn unit_x(i: usize) -> f64 {
    -ROOM_X + UNIT * i as f64
}

/// Which wall cabinets are open shelves instead: the two in the middle.
fn is_open(i: usize) -> bool {
    (3..5).contains(&i)
}

/// Heights of the open boards between the wall cabinets.
const BOARDS: [f64; 3] = [1.44, 1.74, 2.04];
const SHELF_X: [f64; 2] = [-ROOM_X + UNIT * 3.0, -ROOM_X + UNIT * 5.0];
const TABLE_TOP: f64 = 0.74;
