//! `lights`: what a sampler makes of an environment map.

use std::path::PathBuf;

use serde_json::json;
use toml::Table;

use super::args::LightsArgs;
use super::exit::{self, Failure};
use super::out::say;
use super::run::set_threads;
use crate::environment::{
    ENVIRONMENT_SAMPLERS, Environment, EnvironmentSampler, LightKind, SamplerEntry,
};
use crate::experiment::Override;
use crate::image::{Image, overview, write_png_coded};
use crate::report::draw_lights;
use crate::scene::find_environment;
use crate::standard_error::tell;
use crate::suggest::advice;

/// Prints the lights, as JSON or a line each, and draws them with `--out`.
pub fn run(args: &LightsArgs) -> Result<u8, Failure> {
    set_threads(args.threads)?;
    if args.budget == 0 {
        return Err(Failure::usage("--budget 0: expected 1 light at least"));
    }
    let extension = |out: &PathBuf| out.extension().and_then(|e| e.to_str()).map(str::to_owned);
    if let Some(out) = args
        .out
        .as_ref()
        .filter(|out| extension(out).as_deref() != Some("png"))
    {
        let message = format!("--out {}: expected a .png file", out.display());
        return Err(Failure::usage(message));
    }
    let sampler = sampler(args)?;
    let description = find_environment(&args.map)?;
    let map = Environment::from_description(&description)?;
    for note in map.notes() {
        tell!("note: {note}");
    }
    let start = std::time::Instant::now();
    let EnvironmentSampler::Lights(sampler) = sampler else {
        return Err(Failure::usage(format!(
            "{} chooses lights or directions anew at every shading point and has no set of lights; those that have one: {}",
            args.method,
            known(Needed::Lights).join(", ")
        )));
    };
    let set = sampler.lights(&map, args.budget, args.seed);
    let seconds = start.elapsed().as_secs_f64();
    if let Some(out) = &args.out {
        let mut shown = overview(&pixels(&map), 1024);
        let marks = set.lights.iter();
        draw_lights(
            &mut shown,
            marks.map(|l| (map.coordinates(l.direction).map(|c| c as f32), l.kind)),
        );
        write_png_coded(out, &shown)?;
    }
    if args.json {
        let record = json!({ "lights": set.lights, "total_power": set.total_power() });
        say!("{record:#}");
    } else {
        for light in &set.lights {
            let kind = match light.kind {
                LightKind::Direct => "direct",
                LightKind::Indirect => "indirect",
                LightKind::Global => "global",
            };
            let ([x, y, z], [r, g, b]) = (light.direction.to_array(), light.power);
            say!(
                "{kind:<8} {x:>8.5} {y:>8.5} {z:>8.5}  {r:<12.6e} {g:<12.6e} {b:<12.6e} {:.5}",
                light.extent_rad
            );
        }
    }
    for note in &set.notes {
        tell!("note: {note}");
    }
    tell!("{} lights in {:.1} ms", set.lights.len(), seconds * 1e3);
    Ok(exit::OK)
}

fn sampler(args: &LightsArgs) -> Result<EnvironmentSampler, Failure> {
    let entry = crate::environment::environment_sampler(&args.method).ok_or_else(|| {
        Failure::usage(format!(
            "no sampler is called `{}`; {}",
            args.method,
            advice(&args.method, &known(Needed::Anything))
        ))
    })?;
    let mut parameters = Table::new();
    for text in &args.settings {
        let Override { key, values } = Override::parse(text)?;
        let [value] = values.as_slice() else {
            return Err(Failure::usage(format!(
                "--set {text}: one value is expected here"
            )));
        };
        if parameters.contains_key(&key) {
            let message = format!("--set {text}: `{key}` is set twice; leave one of the two out");
            return Err(Failure::usage(message));
        }
        parameters.insert(key, value.clone());
    }
    Ok((entry.build)(&parameters)?)
}

/// Which samplers are listed.
#[derive(PartialEq)]
enum Needed {
    Anything,
    Lights,
}

/// Ids of the samplers.
fn known(needed: Needed) -> Vec<&'static str> {
    let has_lights = |entry: &SamplerEntry| {
        let built = (entry.build)(&Table::new());
        matches!(built, Ok(EnvironmentSampler::Lights(_)))
    };
    ENVIRONMENT_SAMPLERS
        .iter()
        .filter(|entry| needed == Needed::Anything || has_lights(entry))
        .map(|entry| entry.about.id)
        .collect()
}

fn pixels(map: &Environment) -> Image {
    let (width, height) = (map.width(), map.height());
    Image {
        width,
        height,
        pixels: (0..width * height)
            .map(|i| map.texel(i % width, i / width))
            .collect(),
    }
}
