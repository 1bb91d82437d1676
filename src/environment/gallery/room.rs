//! Rooms seen from within: a box with walls, and luminous rectangles on or before them.

use glam::{DVec3, Vec3};

use super::paint::{disc, filled, towards};
use crate::image::Image;

/// A luminous rectangle: the centre, its two half sides and the radiance it sends to all sides.
struct Panel {
    centre: DVec3,
    sides: [DVec3; 2],
    radiance: Vec3,
    /// Bars divide it into this many panes along each side.
    panes: [u32; 2],
}

impl Panel {
    fn new(centre: [f64; 3], sides: [[f64; 3]; 2], radiance: [f32; 3]) -> Self {
        Self {
            centre: centre.into(),
            sides: sides.map(DVec3::from),
            radiance: radiance.into(),
            panes: [1, 1],
        }
    }

    fn panes(mut self, panes: [u32; 2]) -> Self {
        self.panes = panes;
        self
    }

    /// Distance to it along a direction from the origin, and its radiance there: a bar, or brighter
    /// towards the middle and the upper edge, as no lamp and no view is even.
    fn hit(&self, d: DVec3) -> Option<(f64, Vec3)> {
        let normal = self.sides[0].cross(self.sides[1]);
        let t = normal.dot(self.centre) / normal.dot(d);
        if !t.is_finite() || t <= 0.0 {
            return None;
        }
        let offset = d * t - self.centre;
        let along = self.sides.map(|s| offset.dot(s) / s.length_squared());
        if along.iter().any(|a| a.abs() > 1.0) {
            return None;
        }
        let bar = along.iter().zip(self.panes).any(|(a, n)| {
            let share = (0.5 * (a + 1.0) * f64::from(n)).fract();
            n > 1 && (share - 0.5).abs() > 0.46
        });
        let middle = 1.0 - 0.25 * (along[0] * along[0] + along[1] * along[1]);
        let share = if bar {
            0.01
        } else {
            middle * (1.0 + 0.2 * along[1])
        };
        Some((t, self.radiance * share as f32))
    }

    /// Irradiance at a point of a wall, as if it were small.
    fn irradiance(&self, point: DVec3, normal: DVec3) -> f32 {
        let way = self.centre - point;
        let area_normal = 4.0 * self.sides[0].cross(self.sides[1]);
        let distance2 = way.length_squared() + 0.5 * area_normal.length();
        let cosines = normal.dot(way).max(0.0) * area_normal.dot(way).abs();
        (cosines / (distance2 * distance2)) as f32
    }
}

/// A box about the viewer with luminous panels.
struct Room {
    low: DVec3,
    high: DVec3,
    /// Reflectance of floor, walls and ceiling.
    colours: [Vec3; 3],
    /// Light from everywhere, in addition to that of the panels.
    ambient: f32,
    panels: Vec<Panel>,
}

impl Room {
    fn radiance(&self, d: DVec3) -> Vec3 {
        let (point, normal) = self.wall(d);
        let wall_distance = point.length() * 1.0001;
        let nearest = self
            .panels
            .iter()
            .filter_map(|panel| panel.hit(d))
            .filter(|(t, _)| *t <= wall_distance)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, radiance)) = nearest {
            return radiance;
        }
        let colour = match normal.y {
            y if y > 0.5 => self.colours[0],
            y if y < -0.5 => self.colours[2],
            _ => self.colours[1],
        };
        let irradiance: Vec3 = self
            .panels
            .iter()
            .map(|p| p.radiance * p.irradiance(point, normal))
            .sum();
        colour * (irradiance / std::f32::consts::PI + Vec3::splat(self.ambient))
    }

    /// Where a direction meets the box, and the normal there.
    fn wall(&self, d: DVec3) -> (DVec3, DVec3) {
        let bounds = DVec3::select(d.cmpgt(DVec3::ZERO), self.high, self.low);
        let times = bounds / d;
        let axis = (0..3).fold(0, |best, i| {
            let better = times[i].is_finite() && times[i] < times[best];
            if better || !times[best].is_finite() {
                i
            } else {
                best
            }
        });
        let mut normal = DVec3::ZERO;
        normal[axis] = -d[axis].signum();
        (d * times[axis], normal)
    }

    fn image(&self) -> Image {
        filled(2, |d| self.radiance(d))
    }
}

/// Daylight through two windows, and a lamp.
pub fn living_room() -> Image {
    let daylight = [38.0, 44.0, 50.0];
    Room {
        low: DVec3::new(-3.2, -1.1, -2.6),
        high: DVec3::new(2.4, 1.5, 3.4),
        colours: [
            Vec3::new(0.32, 0.2, 0.12),
            Vec3::new(0.66, 0.6, 0.5),
            Vec3::splat(0.8),
        ],
        ambient: 0.25,
        panels: vec![
            Panel::new(
                [2.4, 0.25, -0.6],
                [[0.0, 0.0, 0.6], [0.0, 0.75, 0.0]],
                daylight,
            )
            .panes([2, 3]),
            Panel::new(
                [2.4, 0.25, 1.5],
                [[0.0, 0.0, 0.6], [0.0, 0.75, 0.0]],
                daylight,
            )
            .panes([2, 3]),
            Panel::new(
                [-2.4, 0.35, -1.9],
                [[0.14, 0.0, 0.0], [0.0, 0.16, 0.0]],
                [60.0, 40.0, 20.0],
            ),
        ],
    }
    .image()
}

/// A wall that is all window.
pub fn loft() -> Image {
    Room {
        low: DVec3::new(-6.0, -1.2, -3.0),
        high: DVec3::new(6.0, 2.8, 5.0),
        colours: [
            Vec3::new(0.4, 0.38, 0.36),
            Vec3::new(0.5, 0.22, 0.16),
            Vec3::splat(0.6),
        ],
        ambient: 0.3,
        panels: vec![
            Panel::new(
                [0.0, 0.9, -3.0],
                [[5.2, 0.0, 0.0], [0.0, 1.5, 0.0]],
                [9.0, 10.0, 12.0],
            )
            .panes([7, 3]),
        ],
    }
    .image()
}

/// A slit of daylight high in one wall.
pub fn cellar() -> Image {
    Room {
        low: DVec3::new(-2.5, -1.3, -4.0),
        high: DVec3::new(2.5, 1.9, 4.0),
        colours: [
            Vec3::new(0.25, 0.22, 0.18),
            Vec3::new(0.34, 0.3, 0.25),
            Vec3::new(0.3, 0.27, 0.23),
        ],
        ambient: 0.05,
        panels: vec![Panel::new(
            [-2.5, 1.35, 0.8],
            [[0.0, 0.0, 0.5], [0.0, 0.14, 0.0]],
            [150.0, 160.0, 170.0],
        )],
    }
    .image()
}

/// Rows of tubes below a ceiling.
pub fn gym() -> Image {
    let tubes = (0..6).map(|i| {
        let (column, row) = (i % 3, i / 3);
        Panel::new(
            [
                -3.0 + 3.0 * f64::from(column),
                2.3,
                -2.2 + 4.4 * f64::from(row),
            ],
            [[0.0, 0.0, 1.4], [0.035, 0.0, 0.0]],
            [170.0, 180.0, 175.0],
        )
    });
    Room {
        low: DVec3::new(-6.0, -1.1, -5.0),
        high: DVec3::new(6.0, 2.6, 5.0),
        colours: [
            Vec3::new(0.5, 0.35, 0.2),
            Vec3::new(0.3, 0.35, 0.42),
            Vec3::splat(0.5),
        ],
        ambient: 0.08,
        panels: tubes.collect(),
    }
    .image()
}

/// Two large soft boxes and a dim fill in a dark room.
pub fn studio() -> Image {
    let towards_viewer = |centre: DVec3, half: [f64; 2], radiance: [f32; 3]| {
        let (right, up) = centre.normalize().any_orthonormal_pair();
        Panel::new(
            centre.into(),
            [(right * half[0]).into(), (up * half[1]).into()],
            radiance,
        )
    };
    Room {
        low: DVec3::new(-5.0, -1.0, -5.0),
        high: DVec3::new(5.0, 3.2, 5.0),
        colours: [Vec3::splat(0.3), Vec3::splat(0.12), Vec3::splat(0.1)],
        ambient: 0.05,
        panels: vec![
            towards_viewer(DVec3::new(2.4, 1.5, 1.6), [0.8, 0.8], [14.0, 13.6, 13.0]),
            towards_viewer(DVec3::new(-2.8, 1.0, 0.8), [0.6, 1.1], [5.0, 5.3, 6.0]),
            towards_viewer(DVec3::new(0.4, 2.6, -2.6), [1.2, 0.4], [4.0, 3.8, 3.4]),
        ],
    }
    .image()
}

/// Many small bright sources in an even spiral about the upper sphere.
pub fn photo_studio() -> Image {
    let lamps: Vec<(DVec3, Vec3)> = (0..48)
        .map(|i| {
            let azimuth_deg = 137.508 * f64::from(i);
            let elevation_deg = (0.05 + 0.9 * f64::from(i) / 48.0).asin().to_degrees();
            let warm = if i % 3 == 0 {
                Vec3::new(1.1, 0.95, 0.75)
            } else {
                Vec3::new(0.8, 0.95, 1.2)
            };
            (towards(azimuth_deg, elevation_deg), warm * 160.0)
        })
        .collect();
    filled(2, |d| {
        let walls = Vec3::new(0.1, 0.14, 0.24) * (1.2 + 0.4 * d.y as f32);
        lamps.iter().fold(walls, |sum, (centre, radiance)| {
            sum + *radiance * disc(d, *centre, 0.022)
        })
    })
}

/// A fire near the floor.
pub fn fireside() -> Image {
    Room {
        low: DVec3::new(-2.6, -0.9, -2.2),
        high: DVec3::new(2.8, 1.7, 2.4),
        colours: [
            Vec3::new(0.3, 0.17, 0.1),
            Vec3::new(0.45, 0.33, 0.24),
            Vec3::new(0.5, 0.45, 0.4),
        ],
        ambient: 0.02,
        panels: vec![
            Panel::new(
                [0.7, -0.45, 2.4],
                [[0.24, 0.0, 0.0], [0.0, 0.16, 0.0]],
                [90.0, 36.0, 9.0],
            ),
            Panel::new(
                [-1.6, 0.9, -2.2],
                [[0.35, 0.0, 0.0], [0.0, 0.45, 0.0]],
                [0.7, 0.8, 1.1],
            )
            .panes([2, 2]),
        ],
    }
    .image()
}
