//! Named pinhole cameras.

use glam::{DVec3, Vec3};

/// Which side of the film the field of view spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FovAxis {
    /// The width.
    X,
    /// The height.
    Y,
    /// The shorter side.
    Smaller,
    /// The longer side.
    Larger,
    /// The diagonal.
    Diagonal,
}

/// A pinhole camera. `right`, `up` and `forward` are orthonormal; mirrored cameras (left-handed
/// images) are expressed by `right` pointing the other way.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct View {
    /// What `--view` and configs call it.
    pub name: String,
    /// Scene units; [`crate::scene::Scene::build`] re-centres it with the geometry.
    pub origin: DVec3,
    /// World direction of increasing column.
    pub right: DVec3,
    /// World direction of decreasing row.
    pub up: DVec3,
    /// World direction of the optical axis, into the middle of the image where there is no `shift`.
    pub forward: DVec3,
    /// Full angle of view along `fov_axis`.
    pub fov_deg: f64,
    /// Which side of the image the angle belongs to.
    pub fov_axis: FovAxis,
    /// Where the middle of the film looks beside `forward`, for films that are cut out of larger ones: to the right and up,
    /// as tangents.
    pub shift: [f64; 2],
    /// Default resolution, and the aspect of the published image.
    pub width: usize,
    /// Rows; see `width`.
    pub height: usize,
}

impl View {
    /// A camera at `origin` that looks at `target`; image right is `forward × up`.
    pub fn look_at(
        name: &str,
        [origin, target, up]: [DVec3; 3],
        fov_x_deg: f64,
        size: [usize; 2],
    ) -> Self {
        let forward = (target - origin).normalize();
        let right = forward.cross(up).normalize();
        Self {
            name: name.to_owned(),
            origin,
            right,
            up: right.cross(forward),
            forward,
            fov_deg: fov_x_deg,
            fov_axis: FovAxis::X,
            shift: [0.0; 2],
            width: size[0],
            height: size[1],
        }
    }

    /// Tangents of half the horizontal and vertical field of view for a film of this size (pixels).
    pub fn half_tangents(&self, width: usize, height: usize) -> [f64; 2] {
        let tangent = (self.fov_deg.to_radians() * 0.5).tan();
        let (w, h) = (width as f64, height as f64);
        let spanned = match self.fov_axis {
            FovAxis::X => w,
            FovAxis::Y => h,
            FovAxis::Smaller => w.min(h),
            FovAxis::Larger => w.max(h),
            FovAxis::Diagonal => w.hypot(h),
        };
        [tangent * w / spanned, tangent * h / spanned]
    }

    /// The camera of a part of its film: `size` pixels from `offset`, which counts from the top left corner. `None` where
    /// that is empty or not all on the film.
    pub fn cropped(mut self, offset: [usize; 2], size: [usize; 2]) -> Option<Self> {
        let whole = [self.width, self.height];
        let on_film = |i: usize| size[i] > 0 && offset[i].checked_add(size[i]) <= Some(whole[i]);
        if !on_film(0) || !on_film(1) {
            return None;
        }
        if size == whole {
            return Some(self);
        }
        let half = self.half_tangents(whole[0], whole[1]);
        // The middle of the part, from −1 to 1 over the whole film.
        let middle = |i: usize| (2 * offset[i] + size[i]) as f64 / whole[i] as f64 - 1.0;
        self.shift[0] += half[0] * middle(0);
        self.shift[1] -= half[1] * middle(1);
        let tangent = half[0] * size[0] as f64 / whole[0] as f64;
        self.fov_deg = 2.0 * tangent.atan().to_degrees();
        self.fov_axis = FovAxis::X;
        [self.width, self.height] = size;
        Some(self)
    }

    /// Film position in pixels of a point (scene units, in the frame of `origin`), as [`View::direction`] counts;
    /// `None` behind the camera and outside the film.
    pub fn project(&self, point: DVec3, size: [usize; 2]) -> Option<[f64; 2]> {
        let [tx, ty] = self.half_tangents(size[0], size[1]);
        let away = point - self.origin;
        let depth = away.dot(self.forward);
        let [width, height] = size.map(|side| side as f64);
        let [right, up] = self.shift;
        let x = 0.5 * width * (1.0 + (away.dot(self.right) / depth - right) / tx);
        let y = 0.5 * height * (1.0 - (away.dot(self.up) / depth - up) / ty);
        // False for what is not a number as well.
        let inside = depth > 0.0 && (0.0..width).contains(&x) && (0.0..height).contains(&y);
        inside.then_some([x, y])
    }

    /// Unit direction through film position (`x`, `y`) in pixels, the top left corner at (0, 0), on
    /// a film of `size` = [width, height].
    pub fn direction(&self, x: f64, y: f64, size: [usize; 2]) -> Vec3 {
        self.direction_within(self.half_tangents(size[0], size[1]), [x, y], size)
    }

    /// The same on a film whose [`View::half_tangents`] are known.
    pub fn direction_within(&self, [tx, ty]: [f64; 2], [x, y]: [f64; 2], size: [usize; 2]) -> Vec3 {
        let sx = (2.0 * x / size[0] as f64 - 1.0) * tx + self.shift[0];
        let sy = (1.0 - 2.0 * y / size[1] as f64) * ty + self.shift[1];
        (self.right * sx + self.up * sy + self.forward)
            .normalize()
            .as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_film_looks_where_it_did() {
        let size = [64, 48];
        let whole = View::look_at("v", [DVec3::ZERO, DVec3::NEG_Z, DVec3::Y], 70.0, size);
        let part = whole.clone().cropped([16, 30], [40, 10]).expect("fits");
        assert_eq!([part.width, part.height], [40, 10]);
        for [x, y] in [[0.0, 0.0], [13.25, 7.5], [40.0, 10.0]] {
            let direction = part.direction(x, y, [40, 10]);
            let expected = whole.direction(x + 16.0, y + 30.0, size);
            assert!(
                direction.distance(expected) < 1e-6,
                "{direction} {expected}"
            );
            if x == 13.25 {
                let [px, py] = part
                    .project(direction.as_dvec3() * 3.0, [40, 10])
                    .expect("seen");
                assert!((px - x).abs() < 1e-4 && (py - y).abs() < 1e-4, "{px} {py}");
            }
        }
        assert!(whole.clone().cropped([30, 0], [35, 10]).is_none());
        assert!(whole.cropped([0, 0], [0, 10]).is_none());
    }
}
