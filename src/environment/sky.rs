//! A clear daylight sky as a map: Hosek & Wilkie 2012 with the solar disc.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use rayon::prelude::*;

use super::EnvironmentError;
use crate::image::Image;

/// A sky over a ground.
#[derive(Clone, Copy, Debug)]
pub struct SunSky {
    /// Towards the sun, y up; not below the horizon.
    pub sun_direction: DVec3,
    /// 1 (pure air) to 10 (haze).
    pub turbidity: f32,
    /// Of the ground, linear RGB in [0, 1].
    pub albedo: [f32; 3],
    /// Whether the solar disc shines.
    pub sun: bool,
    /// Of a surface that faces the sun, W/(m² nm); `None` follows from the turbidity.
    pub sun_irradiance: Option<[f32; 3]>,
    /// How wide its disc is, degrees; the same light comes from it. `None` is the sun as it is seen from the earth, and
    /// those narrower than 0.1 degrees are as wide as that.
    pub sun_aperture_deg: Option<f64>,
    /// Whether the sky shines.
    pub sky: bool,
}

const WIDTH: usize = 1024;
const HEIGHT: usize = 512;
/// Half the apparent diameter of the sun.
const SUN_RADIUS_RAD: f64 = 0.2666 * PI / 180.0;
/// ∫ ȳ dλ in nm: takes the model's values to radiance per nm.
const LUMINOUS_INTEGRAL: f32 = 106.856_98;
/// Representative wavelengths (µm) of red, green and blue, the solar irradiance above the
/// atmosphere there (W/(m² nm)) and the absorption of ozone (1/cm).
const CHANNELS: [(f64, f64, f64); 3] = [
    (0.61, 1.73, 0.125),
    (0.55, 1.86, 0.085),
    (0.465, 2.03, 0.008),
];

/// Renders a 1024×512 latitude–longitude map, in W/(m² sr nm). Below the horizon it is black.
///
/// *differs:* the sun's disc is uniform, and, where its irradiance is not given, attenuated by Preetham's air, aerosol and ozone at one
/// wavelength a channel; texels at its rim are partly covered and their sum is exact.
///
/// # Errors
/// A sun below the horizon, turbidity or albedo out of range.
pub fn sun_sky_image(sky: &SunSky) -> Result<Image, EnvironmentError> {
    let sun = sky.sun_direction.normalize_or_zero();
    let elevation = sun.y.clamp(-1.0, 1.0).asin();
    if sun == DVec3::ZERO || elevation < 0.0 {
        return Err(EnvironmentError::Sky {
            message: format!(
                "the sun stands below the horizon (direction {}); sun_direction.y must not be negative",
                sky.sun_direction
            ),
        });
    }
    let parameters = SkyParams {
        elevation: elevation.clamp(0.0, FRAC_PI_2) as f32,
        turbidity: sky.turbidity,
        albedo: sky.albedo,
    };
    let state = SkyState::new(&parameters).map_err(|error| EnvironmentError::Sky {
        message: error.to_string(),
    })?;
    let mut image = Image::new(WIDTH, HEIGHT);
    if sky.sky {
        image
            .pixels
            .par_chunks_mut(WIDTH)
            .enumerate()
            .for_each(|(y, row)| shade_row(&state, sun, y, row));
    }
    if sky.sun {
        let irradiance = match sky.sun_irradiance {
            Some(irradiance) => irradiance.map(f64::from),
            None => sun_irradiance(sun.y, f64::from(sky.turbidity)),
        };
        let aperture = sky.sun_aperture_deg;
        let radius = aperture.map_or(SUN_RADIUS_RAD, |a| (0.5 * a.max(0.1)).to_radians());
        add_sun(&mut image, [sun, DVec3::from(irradiance)], radius);
    }
    Ok(image)
}

fn direction(x: f64, y: f64) -> DVec3 {
    let (sin, cos) = (PI * y / HEIGHT as f64).sin_cos();
    let (sin_phi, cos_phi) = (TAU * x / WIDTH as f64).sin_cos();
    DVec3::new(sin_phi * sin, cos, -cos_phi * sin)
}

fn shade_row(state: &SkyState, sun: DVec3, y: usize, row: &mut [[f32; 3]]) {
    for (x, pixel) in row.iter_mut().enumerate() {
        let d = direction(x as f64 + 0.5, y as f64 + 0.5);
        if d.y <= 0.0 {
            continue;
        }
        let theta = d.y.acos() as f32;
        let gamma = d.dot(sun).clamp(-1.0, 1.0).acos() as f32;
        *pixel = [Channel::R, Channel::G, Channel::B]
            .map(|c| state.radiance(theta, gamma, c).max(0.0) / LUMINOUS_INTEGRAL);
    }
}

/// Solar irradiance (W/(m² nm)) that reaches a surface facing the sun.
fn sun_irradiance(cos_zenith: f64, turbidity: f64) -> [f64; 3] {
    let zenith_deg = cos_zenith.clamp(0.0, 1.0).acos().to_degrees();
    let air_mass = 1.0 / (cos_zenith + 0.15 * (93.885 - zenith_deg).powf(-1.253));
    let aerosol = 0.046_08 * turbidity - 0.045_86;
    CHANNELS.map(|(wavelength, irradiance, ozone)| {
        let depth =
            0.008_735 * wavelength.powf(-4.08) + aerosol * wavelength.powf(-1.3) + 0.35 * ozone;
        irradiance * (-depth * air_mass).exp()
    })
}

/// Spreads the disc over the texels it covers, by 32² points a texel.
fn add_sun(image: &mut Image, [sun, irradiance]: [DVec3; 2], radius_rad: f64) {
    const POINTS: usize = 32;
    let limit = radius_rad + 2.0 * PI / HEIGHT as f64;
    let solid_angle = |y: usize| {
        let cos = |edge: usize| (PI * edge as f64 / HEIGHT as f64).cos();
        TAU / WIDTH as f64 * (cos(y) - cos(y + 1))
    };
    let mut covered: Vec<(usize, f64)> = Vec::new();
    let mut total = 0.0;
    for i in 0..WIDTH * HEIGHT {
        let (x, y) = ((i % WIDTH) as f64, (i / WIDTH) as f64);
        if direction(x + 0.5, y + 0.5).angle_between(sun) > limit {
            continue;
        }
        let point = |k: usize| (k as f64 + 0.5) / POINTS as f64;
        let inside = (0..POINTS * POINTS)
            .filter(|k| {
                let d = direction(x + point(k % POINTS), y + point(k / POINTS));
                d.y >= 0.0 && d.angle_between(sun) <= radius_rad
            })
            .count();
        let share = inside as f64 / (POINTS * POINTS) as f64;
        if share > 0.0 {
            covered.push((i, share));
            total += share * solid_angle(i / WIDTH);
        }
    }
    if total <= 0.0 {
        return;
    }
    for (i, share) in covered {
        for (value, irradiance) in image.pixels[i].iter_mut().zip(irradiance.to_array()) {
            *value += (irradiance * share / total) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::{Environment, EnvironmentOptions};
    use crate::image::luminance;

    fn sky(elevation_deg: f64, sun: bool, sky: bool) -> SunSky {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        SunSky {
            sun_direction: DVec3::new(cos * 0.6, sin, cos * 0.8),
            turbidity: 3.0,
            albedo: [0.2; 3],
            sun_irradiance: None,
            sun_aperture_deg: None,
            sun,
            sky,
        }
    }

    fn horizontal_irradiance(image: &Image) -> f64 {
        let e = Environment::from_image(image, &EnvironmentOptions::default()).expect("map");
        (0..WIDTH * HEIGHT / 2)
            .map(|i| {
                let (x, y) = (i % WIDTH, i / WIDTH);
                f64::from(luminance(e.texel(x, y)))
                    * e.texel_solid_angle(y)
                    * f64::from(e.texel_direction(x, y).y)
            })
            .sum()
    }

    #[test]
    fn the_sun_has_its_power_at_any_height() {
        for elevation in [5.0, 30.0, 60.0, 89.9, 90.0] {
            let s = sky(elevation, true, false);
            let image = sun_sky_image(&s).expect("sky");
            let e = Environment::from_image(&image, &EnvironmentOptions::default()).expect("map");
            let expected = sun_irradiance(s.sun_direction.y, 3.0);
            for (power, expected) in e.total_power().iter().zip(expected) {
                assert!(
                    (power / expected - 1.0).abs() < 1e-3,
                    "{elevation}: {power}"
                );
            }
        }
    }

    #[test]
    fn a_wide_sun_has_the_power_of_a_small_one() {
        let power_and_brightest = |sun_aperture_deg: Option<f64>| {
            let wide = SunSky {
                sun_aperture_deg,
                ..sky(40.0, true, false)
            };
            let image = sun_sky_image(&wide).expect("sky");
            let pixels = image.pixels.iter();
            let brightest = pixels.fold(0.0, |most, pixel| f64::from(pixel[1]).max(most));
            let map = Environment::from_image(&image, &EnvironmentOptions::default());
            (map.expect("map").total_power()[1], brightest)
        };
        let (power, _) = power_and_brightest(None);
        for aperture_deg in [0.0, 0.5, 4.0, 20.0] {
            let (wide, brightest) = power_and_brightest(Some(aperture_deg));
            assert!((wide / power - 1.0).abs() < 1e-3, "{aperture_deg}: {wide}");
            let disc = TAU * (1.0 - (0.5 * f64::to_radians(aperture_deg)).cos());
            if aperture_deg > 1.0 {
                let even = power / disc;
                assert!((brightest / even - 1.0).abs() < 0.01, "{brightest} {even}");
            }
        }
    }

    #[test]
    fn skylight_is_a_plausible_part_of_daylight() {
        let sun = horizontal_irradiance(&sun_sky_image(&sky(50.0, true, false)).expect("sky"));
        let air = horizontal_irradiance(&sun_sky_image(&sky(50.0, false, true)).expect("sky"));
        let share = air / (sun + air);
        assert!((0.08..0.35).contains(&share), "{share}");
    }

    #[test]
    fn broken_skies_are_refused() {
        assert!(sun_sky_image(&sky(-3.0, true, true)).is_err());
        let mut hazy = sky(30.0, true, true);
        hazy.turbidity = 40.0;
        assert!(sun_sky_image(&hazy).is_err());
        hazy.sun_direction = DVec3::ZERO;
        assert!(sun_sky_image(&hazy).is_err());
    }
}
