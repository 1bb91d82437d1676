//! A street of 200 m between houses with shops, balconies, signs and wires.

mod facades;
mod fittings;
mod houses;
mod parked;
mod shops;
mod signs;
mod street;

use super::PartFunction;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("road", street::road),
    ("pavement", street::pavement),
    ("marks", street::marks),
    ("poles", street::poles),
    ("wires", street::wires),
    ("street-lamps", street::street_lamps),
    ("pale-walls", |p| facades::walls(p, 0)),
    ("ochre-walls", |p| facades::walls(p, 1)),
    ("brick-walls", |p| facades::walls(p, 2)),
    ("ends", facades::ends),
    ("window-frames", facades::window_frames),
    ("dark-panes", facades::dark_panes),
    ("lit-panes", facades::lit_panes),
    ("balconies", fittings::balconies),
    ("railings", fittings::railings),
    ("cornices", fittings::cornices),
    ("boxes", fittings::boxes),
    ("rooftops", fittings::rooftops),
    ("shop-rooms", shops::rooms),
    ("shop-lights", shops::lights),
    ("wares", shops::wares),
    ("awnings", shops::awnings),
    ("sign-frames", signs::frames),
    ("sign-marks", signs::marks),
    ("red-signs", |p| signs::boards(p, 0)),
    ("blue-signs", |p| signs::boards(p, 1)),
    ("green-signs", |p| signs::boards(p, 2)),
    ("amber-signs", |p| signs::boards(p, 3)),
    ("pink-signs", |p| signs::boards(p, 4)),
    ("lantern-strings", signs::lantern_strings),
    ("lanterns", signs::lanterns),
    ("scooter-shells", parked::scooter_shells),
    ("scooter-metal", parked::scooter_metal),
    ("tyres", parked::tyres),
    ("vans", parked::vans),
    ("van-glass", parked::van_glass),
    ("crates", parked::crates),
    ("fruit", parked::fruit),
    ("stall-poles", parked::stall_poles),
    ("stall-lamps", parked::stall_lamps),
    ("plants", parked::plants),
];

/// Facades stand at x = ±6, kerbs at ±3.6; the street runs from z = 8 to z = -200.
const FACE_X: f64 = 6.0;
const KERB_X: f64 = 3.6;
const NEAR_Z: f64 = 8.0;
const FAR_Z: f64 = -200.0;

/// Height of the pavement over the road at y = 0.
const PAVEMENT: f64 = 0.13;

/// Height of a shop; the floors above are [`FLOOR`] high.
const SHOP: f64 = 3.3;
const FLOOR: f64 = 2.9;
