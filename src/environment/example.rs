//! Strips (a worked example): the map in strips of equal width, each of which is one light.

use glam::Vec3;

use super::{
    Environment, EnvironmentSampler, Light, LightKind, LightSampler, LightSet, SamplerEntry,
};
use crate::entry::{About, Bias, check_keys};

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "strips",
        module: crate::entry::head_comment!("example.rs"),
        aliases: &[],
        summary: "strips of equal width from pole to pole, each at the mean of its power",
        source: "docs/adding.md",
        bias: Bias::Consistent,
        version: 1,
        failures: &["the sky and the ground of a strip share one light, near the horizon"],
        parameters: &[],
    },
    build: |table| {
        check_keys(table, &[])?;
        Ok(EnvironmentSampler::Lights(Box::new(Strips)))
    },
};

struct Strips;

impl LightSampler for Strips {
    fn lights(&self, map: &Environment, count: usize, _seed: u64) -> LightSet {
        let strips = count.min(map.width());
        let lights = (0..strips).filter_map(|strip| {
            let columns = strip * map.width() / strips..(strip + 1) * map.width() / strips;
            let mut power = [0.0; 3];
            let mut towards = Vec3::ZERO;
            for (x, y) in columns.flat_map(|x| (0..map.height()).map(move |y| (x, y))) {
                let texel = map.texel(x, y);
                let solid_angle = map.texel_solid_angle(y); // Exact: all of them sum to 4π.
                for (sum, radiance) in power.iter_mut().zip(texel) {
                    *sum += f64::from(radiance) * solid_angle;
                }
                let weight = texel.iter().sum::<f32>() * solid_angle as f32;
                towards += weight * map.texel_direction(x, y);
            }
            // No light may be black, and a direction has length 1.
            let direction = towards.try_normalize()?;
            Some(Light {
                direction,
                power,
                kind: LightKind::Global,
                extent_rad: std::f32::consts::FRAC_PI_2,
            })
        });
        LightSet {
            lights: lights.collect(),
            ..LightSet::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::EnvironmentOptions;
    use crate::environment::sampler_tests::rich;

    #[test]
    fn all_power_of_the_map_is_in_the_lights() {
        let map = Environment::from_image(&rich(24, 12), &EnvironmentOptions::default());
        let map = map.expect("a map");
        let EnvironmentSampler::Lights(sampler) =
            (ENTRY.build)(&toml::Table::new()).expect("no keys")
        else {
            panic!("it has lights");
        };
        for count in [1, 5, 24, 99] {
            let set = sampler.lights(&map, count, 1);
            assert_eq!(set.lights.len(), count.min(24));
            for (of_lights, of_map) in set.total_power().iter().zip(map.total_power()) {
                assert!((of_lights / of_map - 1.0).abs() < 1e-9, "{count}");
            }
        }
    }
}
