//! A country house in its garden, and the kitchen behind its door: that of the cabinet room, with a
//! table, chairs and glass in it.

mod dining;
mod garden;
mod joinery;
mod plants;
mod roof;
mod shell;
mod utensils;

use super::cabinet_room::part as kitchen;
use super::{Parameters, PartFunction};

pub const PARTS: &[(&str, PartFunction)] = &[
    ("ground", garden::ground),
    ("path", garden::path),
    ("fence", garden::fence),
    ("grass", plants::grass),
    ("bushes", plants::bushes),
    ("flowers", plants::flowers),
    ("tree-trunks", plants::trunks),
    ("tree-crowns", plants::crowns),
    ("pots", plants::pots),
    ("bench", garden::bench),
    ("walls", shell::walls),
    ("inner-walls", shell::inner_walls),
    ("plinth", shell::plinth),
    ("ceiling", shell::ceiling),
    ("room-floor", shell::room_floor),
    ("roof", roof::roof),
    ("chimney", roof::chimney),
    ("window-frames", joinery::window_frames),
    ("window-panes", joinery::window_panes),
    ("shutters", joinery::shutters),
    ("door", joinery::door),
    ("door-handle", joinery::door_handle),
    ("curtains", joinery::curtains),
    ("floor", |p| kitchen("floor", p)),
    ("wall-tiles", |p| kitchen("wall-tiles", p)),
    ("carcasses", |p| kitchen("carcasses", p)),
    ("fronts", |p| kitchen("fronts", p)),
    ("handles", |p| kitchen("handles", p)),
    ("worktop", |p| kitchen("worktop", p)),
    ("sink-and-tap", |p| kitchen("sink-and-tap", p)),
    ("stove", |p| kitchen("stove", p)),
    ("shelves", |p| kitchen("shelves", p)),
    ("bottles", |p| kitchen("bottles", &coarser(p))),
    ("plates", |p| kitchen("plates", &coarser(p))),
    ("cups", |p| kitchen("cups", &coarser(p))),
    ("towel", |p| kitchen("towel", p)),
    ("side-window", |p| kitchen("window", p)),
    ("lamp", |p| kitchen("lamp", p)),
    ("lamp-glow", |p| kitchen("lamp-glow", p)),
    ("strip-lights", utensils::strip_lights),
    ("table", dining::table),
    ("chairs", dining::chairs),
    ("rug", dining::rug),
    ("mirror", dining::mirror),
    ("mirror-frame", dining::mirror_frame),
    ("kettle", utensils::kettle),
    ("glasses", utensils::glasses),
    ("bowls", utensils::bowls),
    ("lemons", utensils::lemons),
    ("copper", utensils::copper),
];

/// What there are dozens of has fewer facets here than in a scene of the kitchen alone.
fn coarser(parameters: &Parameters) -> Parameters {
    Parameters {
        detail: parameters.detail * 0.55,
        ..*parameters
    }
}

/// The kitchen: x = ±2.3, z from -2.2 to 3.2 (its front wall, with the door), 2.6 m high, its floor at
/// y = 0. A second room lies to its right.
const ROOM_X: f64 = 2.3;
const BACK_Z: f64 = -2.2;
const FRONT_Z: f64 = 3.2;
const HEIGHT: f64 = 2.6;

/// Outer faces of the house.
const HOUSE_X: [f64; 2] = [-2.55, 6.75];
const HOUSE_Z: [f64; 2] = [-2.4, 3.45];

/// The lawn lies a step below the floor.
const LAWN: f64 = -0.15;

/// x range of the door and of the windows in the front wall; the first window is the kitchen's.
const DOOR_X: [f64; 2] = [0.75, 1.75];
const DOOR_TOP: f64 = 2.15;
const WINDOWS_X: [[f64; 2]; 3] = [[-1.85, -0.15], [3.0, 4.0], [5.0, 6.0]];
const WINDOW_Y: [f64; 2] = [0.95, 2.15];

/// Where the gate stands in the fence, and the fence's line.
const GATE_X: [f64; 2] = [2.0, 3.6];
const FENCE_Z: f64 = 12.5;
