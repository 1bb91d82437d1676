//! A stair hall: balusters, rail and skirting, a seated figure near the camera and one on the landing.

mod flight;
mod furniture;
mod hall;

use super::PartFunction;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("floor", hall::floor),
    ("walls", hall::walls),
    ("ceiling", hall::ceiling),
    ("treads", flight::treads),
    ("risers", flight::risers),
    ("carpet", flight::carpet),
    ("balusters", flight::balusters),
    ("rails", flight::rails),
    ("skirting", hall::skirting),
    ("windows", hall::windows),
    ("near-figure", furniture::near_figure),
    ("far-figure", furniture::far_figure),
    ("pedestals", furniture::pedestals),
    ("lamp", furniture::lamp),
    ("lamp-glow", furniture::lamp_glow),
    ("pictures", furniture::pictures),
    ("picture-frames", furniture::picture_frames),
];

/// The flight rises towards -z between x = -1.15 and x = 1.15.
const STEPS: usize = 15;
const RISE: f64 = 0.17;
const GOING: f64 = 0.29;
const FIRST_Z: f64 = -0.9;
const HALF_WIDTH: f64 = 1.15;

/// The hall: x = ±2.6, z from -8.6 to 4.2, 6.2 m high.
const HALL_X: f64 = 2.6;
const BACK_Z: f64 = -8.6;
const FRONT_Z: f64 = 4.2;
const HEIGHT: f64 = 6.2;
const LANDING_Y: f64 = RISE * STEPS as f64;
const LANDING_Z: f64 = FIRST_Z - GOING * (STEPS - 1) as f64;
