//! lightbench: a laboratory for *cached light*.
//!
//! An experiment file names scenes, a technique, its contenders and their shared budget; lightbench
//! renders every combination, measures error and counted cost against references, and writes the
//! tables and figures of the papers it reproduces. Every job is a sequence: a contender is given one frame after
//! another, each as all viewers see it, and may keep what it learned; a still is one frame of one viewer.
//!
//! The modules import downwards only:
//! `cli → experiment, report → technique → placement, cache, environment, shade → world → scene,
//! trace, sample → image, files, memory, suggest`.

pub mod cache;
pub mod cli;
pub mod entry;
pub mod environment;
pub mod experiment;
mod files;
pub mod image;
mod instructions;
pub mod memory;
pub mod metric;
mod other_kind;
pub mod placement;
pub mod readers;
pub mod registry;
pub mod report;
pub mod sample;
pub mod scene;
pub mod shade;
mod standard_error;
mod suggest;
pub mod technique;
pub mod trace;
pub mod world;
