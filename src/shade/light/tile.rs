//! Many places on lights at once, and what they send to surfaces: loops that processors work through many at a time.

use glam::Vec3;
use macro_rules_attribute::apply;

use super::{Arriving, ChosenPlace, LIGHT_GROUPS, LightPlace, Lights, Unshadowed, near};
use crate::image::luminance;
use crate::instructions::compiled_for_avx512;
use crate::sample::Rng;
use crate::shade::bsdf::{LANES, Lanes, VectorLanes};
use crate::shade::surface::Interaction;

/// Places on lights that were selected at random, evenly spaced over all lights by power.
pub struct LightTile {
    count: usize,
    parts: Vec<TilePart>,
}

/// Up to [`LANES`] places of a tile.
pub struct TilePart {
    places: [LightPlace; LANES],
    /// Their [`Lights::group`].
    groups: [u32; LANES],
    /// Density over places with which each was selected; zero where there is none.
    density: Lanes,
    /// Points of emitting triangles.
    points: VectorLanes,
    normals: VectorLanes,
    /// Their triangles' centres, and squared longest edges; zero of other lights.
    centres: VectorLanes,
    edge2: Lanes,
    /// Radiance of emitting triangles; zero of other lights.
    emission: VectorLanes,
    /// Which places are at infinity, and what these send, whatever the surface; no irradiance of the others.
    is_distant: [bool; LANES],
    distant: Sent,
    /// Point and spot lights.
    point_lights: Vec<usize>,
}

/// What the places of a part send to a surface, as [`Unshadowed`]; no irradiance where a place cannot reach it.
pub struct Sent {
    directions: VectorLanes,
    irradiance: VectorLanes,
    /// Whether the surface is near some of their triangles.
    is_near_any: bool,
}

impl LightTile {
    /// Selects `count` places: for each of as many evenly spaced numbers, with one random offset, as [`Lights::choose`] does.
    pub fn new(lights: &Lights, count: usize, rng: &mut Rng) -> Self {
        match lights.is_dark() {
            true => Self {
                count: 0,
                parts: Vec::new(),
            },
            false => Self::selected(count, rng, |part, lane, choice, at| {
                part.select(lane, lights, choice, at);
            }),
        }
    }

    /// Selects `count` places of the environment alone: along its first axis evenly spaced.
    pub fn of_environment(lights: &Lights, count: usize, rng: &mut Rng) -> Self {
        Self::selected(count, rng, |part, lane, choice, [_, v]| {
            if let Some(chosen) = lights.choose_environment([choice as f32, v]) {
                part.keep(lane, lights, chosen);
            }
        })
    }

    fn selected(
        count: usize,
        rng: &mut Rng,
        select: impl Fn(&mut TilePart, usize, f64, [f32; 2]),
    ) -> Self {
        let mut parts: Vec<TilePart> = Vec::with_capacity(count.div_ceil(LANES));
        let offset = rng.next_f64();
        for number in 0..count {
            let lane = number % LANES;
            if lane == 0 {
                parts.push(TilePart::default());
            }
            let choice = (number as f64 + offset) / count as f64;
            let at = [rng.next_f32(), rng.next_f32()];
            let part = parts.last_mut().expect("one was pushed");
            select(part, lane, choice, at);
        }
        Self { count, parts }
    }

    /// How many places there are; none where nothing shines.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The places, [`LANES`] in each part, without density behind the last one.
    pub fn parts(&self) -> &[TilePart] {
        &self.parts
    }

    /// The [`Lights::group`] of place `number`.
    pub fn group(&self, number: usize) -> u32 {
        self.parts[number / LANES].groups[number % LANES]
    }

    /// What place `number` sends to a surface: [`Lights::arriving`], or `None` where that is nothing. `sent` is what its part was
    /// found to send.
    pub fn arriving(
        &self,
        number: usize,
        lights: &Lights,
        from: &Interaction,
        sent: &Sent,
    ) -> Option<Arriving> {
        self.parts[number / LANES].arriving(number % LANES, lights, from, sent)
    }
}

impl Default for TilePart {
    fn default() -> Self {
        Self {
            places: [LightPlace::Point(u32::MAX); LANES],
            groups: [0; LANES],
            density: [0.0; LANES],
            points: [[0.0; LANES]; 3],
            normals: [[0.0; LANES]; 3],
            centres: [[0.0; LANES]; 3],
            edge2: [0.0; LANES],
            emission: [[0.0; LANES]; 3],
            is_distant: [false; LANES],
            distant: Sent::default(),
            point_lights: Vec::new(),
        }
    }
}

impl Default for Sent {
    fn default() -> Self {
        Self {
            directions: [[0.0; LANES]; 3],
            irradiance: [[0.0; LANES]; 3],
            is_near_any: false,
        }
    }
}

fn set(lanes: &mut VectorLanes, lane: usize, value: Vec3) {
    for axis in 0..3 {
        lanes[axis][lane] = value[axis];
    }
}

fn get([x, y, z]: &VectorLanes, lane: usize) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

impl TilePart {
    fn select(&mut self, lane: usize, lights: &Lights, choice: f64, at: [f32; 2]) {
        if let Some(light) = lights.triangle_for(choice) {
            set(&mut self.points, lane, light.point(at));
            set(&mut self.normals, lane, light.normal);
            set(&mut self.centres, lane, light.centre);
            self.edge2[lane] = light.edge2;
            set(&mut self.emission, lane, light.emission);
            self.place(lane, lights, light.chosen(at));
        } else if let Some(chosen) = lights.choose_at(choice, at) {
            self.keep(lane, lights, chosen);
        }
    }

    /// Keeps a place that is on no triangle.
    fn keep(&mut self, lane: usize, lights: &Lights, chosen: ChosenPlace) {
        match lights.distant(&chosen.place) {
            Some(light) => {
                self.is_distant[lane] = true;
                self.distant.put(lane, &light);
            }
            None => self.point_lights.push(lane),
        }
        self.place(lane, lights, chosen);
    }

    fn place(&mut self, lane: usize, lights: &Lights, ChosenPlace { place, density }: ChosenPlace) {
        self.groups[lane] = lights.group(&place);
        (self.places[lane], self.density[lane]) = (place, density);
    }

    /// Luminance of the irradiance of a surface with this normal, times the factor of each place's [`Lights::group`].
    pub fn received(&self, sent: &Sent, normal: Vec3, factors: &[f32; LIGHT_GROUPS]) -> Lanes {
        let mut received = [0.0; LANES];
        receive(sent, normal, &self.groups, factors, &mut received);
        received
    }

    /// Divides numbers of the places by their densities, 0 where they are 0; `false` where some are not finite after that.
    pub fn over_density(&self, numbers: &Lanes, found: &mut [f64; LANES]) -> bool {
        over(numbers, &self.density, found)
    }

    /// The places.
    pub fn places(&self) -> &[LightPlace; LANES] {
        &self.places
    }

    /// Densities over places with which they were selected.
    pub fn density(&self) -> &Lanes {
        &self.density
    }

    /// What the places send to a surface.
    pub fn send(&self, lights: &Lights, from: &Interaction, sent: &mut Sent) {
        send(self, from.position, sent);
        if self.is_distant != [false; LANES] {
            send_distant(self, sent);
        }
        sent.is_near_any = is_near_any(self, from.position);
        if sent.is_near_any {
            for lane in (0..LANES).filter(|lane| self.is_near(*lane, from.position)) {
                let light = lights.unshadowed(&self.places[lane], from);
                sent.put(lane, &light.unwrap_or_default());
            }
        }
        for &lane in &self.point_lights {
            if let Some(light) = lights.unshadowed(&self.places[lane], from) {
                sent.put(lane, &light);
            }
        }
    }

    /// Whether a place is on a triangle that a position is near.
    fn is_near(&self, lane: usize, position: Vec3) -> bool {
        let [point, normal, centre] =
            [&self.points, &self.normals, &self.centres].map(|lanes| get(lanes, lane));
        let height = (position - point).dot(normal);
        near::is_near(position.distance_squared(centre), height, self.edge2[lane])
    }

    fn arriving(
        &self,
        lane: usize,
        lights: &Lights,
        from: &Interaction,
        sent: &Sent,
    ) -> Option<Arriving> {
        let is_triangle = matches!(self.places[lane], LightPlace::Triangle(..));
        if !is_triangle || sent.is_near_any && self.is_near(lane, from.position) {
            return lights.arriving(&self.places[lane], from);
        }
        let Unshadowed {
            direction,
            irradiance,
        } = sent.at(lane);
        if irradiance == Vec3::ZERO {
            return None;
        }
        let point = [&self.points, &self.normals].map(|lanes| get(lanes, lane));
        Some(Arriving {
            direction,
            irradiance,
            shadow_ray: lights.shadow_ray(from, direction, point)?,
        })
    }
}

impl Sent {
    fn put(&mut self, lane: usize, light: &Unshadowed) {
        set(&mut self.directions, lane, light.direction);
        set(&mut self.irradiance, lane, light.irradiance);
    }

    /// What one of the places sends.
    pub fn at(&self, lane: usize) -> Unshadowed {
        Unshadowed {
            direction: get(&self.directions, lane),
            irradiance: get(&self.irradiance, lane),
        }
    }

    /// A number of each place that sends light, zero of the others.
    pub fn each(&self, number: impl Fn(&Unshadowed) -> f32) -> Lanes {
        let mut numbers = [0.0; LANES];
        for (lane, found) in numbers.iter_mut().enumerate() {
            let light = self.at(lane);
            if light.irradiance != Vec3::ZERO {
                *found = number(&light);
            }
        }
        numbers
    }

    /// Luminance of what a surface scatters to its viewer of each place, without shadows.
    pub fn scattered(&self, at: &Interaction) -> Lanes {
        let Some(mut scattered) = at.luminances(&self.directions, &self.irradiance) else {
            return self
                .each(|light| luminance((at.evaluate(light.direction) * light.irradiance).into()));
        };
        let [red, green, blue] = &self.irradiance;
        for lane in 0..LANES {
            // The directions of places that send nothing need not be numbers.
            if red[lane] == 0.0 && green[lane] == 0.0 && blue[lane] == 0.0 {
                scattered[lane] = 0.0;
            }
        }
        scattered
    }
}

/// `FacingPoint::of` of all triangles, and what they send.
#[apply(compiled_for_avx512)]
fn send(part: &TilePart, position: Vec3, sent: &mut Sent) {
    let [px, py, pz] = &part.points;
    let [nx, ny, nz] = &part.normals;
    let [red, green, blue] = &part.emission;
    let [dx, dy, dz] = &mut sent.directions;
    let [to_red, to_green, to_blue] = &mut sent.irradiance;
    for lane in 0..LANES {
        let x = px[lane] - position.x;
        let y = py[lane] - position.y;
        let z = pz[lane] - position.z;
        let distance2 = x * x + y * y + z * z;
        let inverse = 1.0 / distance2.sqrt();
        let (x, y, z) = (x * inverse, y * inverse, z * inverse);
        let cos = -(x * nx[lane] + y * ny[lane] + z * nz[lane]);
        let pdf_sr = part.density[lane] * distance2 / cos;
        let reaches = (cos > 0.0)
            & (pdf_sr > 0.0)
            & (pdf_sr < f32::INFINITY)
            & (inverse > 0.0)
            & (inverse < f32::INFINITY);
        let factor = part.density[lane] / pdf_sr;
        (dx[lane], dy[lane], dz[lane]) = (x, y, z);
        to_red[lane] = if reaches { red[lane] * factor } else { 0.0 };
        to_green[lane] = if reaches { green[lane] * factor } else { 0.0 };
        to_blue[lane] = if reaches { blue[lane] * factor } else { 0.0 };
    }
}

/// Whether a position is near one of the triangles.
#[apply(compiled_for_avx512)]
fn is_near_any(part: &TilePart, position: Vec3) -> bool {
    let [cx, cy, cz] = &part.centres;
    let [px, py, pz] = &part.points;
    let [nx, ny, nz] = &part.normals;
    let mut any = false;
    for lane in 0..LANES {
        let (x, y, z) = (
            position.x - cx[lane],
            position.y - cy[lane],
            position.z - cz[lane],
        );
        let distance2 = x * x + y * y + z * z;
        let height = (position.x - px[lane]) * nx[lane]
            + (position.y - py[lane]) * ny[lane]
            + (position.z - pz[lane]) * nz[lane];
        any |= near::is_near(distance2, height, part.edge2[lane]);
    }
    any
}

/// What places at infinity send.
#[apply(compiled_for_avx512)]
fn send_distant(part: &TilePart, sent: &mut Sent) {
    let from = part
        .distant
        .directions
        .iter()
        .chain(&part.distant.irradiance);
    let to = sent.directions.iter_mut().chain(&mut sent.irradiance);
    for (from, to) in from.zip(to) {
        for lane in 0..LANES {
            to[lane] = if part.is_distant[lane] {
                from[lane]
            } else {
                to[lane]
            };
        }
    }
}

/// [`TilePart::over_density`].
#[apply(compiled_for_avx512)]
fn over(numbers: &Lanes, density: &Lanes, found: &mut [f64; LANES]) -> bool {
    let mut finite = true;
    for lane in 0..LANES {
        let weight = numbers[lane] / density[lane];
        let weight = if numbers[lane] == 0.0 { 0.0 } else { weight };
        finite &= weight.is_finite();
        found[lane] = f64::from(weight);
    }
    finite
}

/// [`TilePart::received`].
#[apply(compiled_for_avx512)]
fn receive(
    sent: &Sent,
    normal: Vec3,
    groups: &[u32; LANES],
    factors: &[f32; LIGHT_GROUPS],
    received: &mut Lanes,
) {
    let [x, y, z] = &sent.directions;
    let [red, green, blue] = &sent.irradiance;
    for lane in 0..LANES {
        let cosine = x[lane] * normal.x + y[lane] * normal.y + z[lane] * normal.z;
        let light = luminance([red[lane], green[lane], blue[lane]]);
        // Not `max`: a direction that is not a number receives nothing.
        let light = if cosine > 0.0 { light * cosine } else { 0.0 };
        received[lane] = light * factors[groups[lane] as usize % LIGHT_GROUPS];
    }
}

#[cfg(test)]
mod tests;
