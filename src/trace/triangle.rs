//! One ray against the triangles of a block.

use super::lanes::Floats;
use super::wide::Block;

/// Three registers: a point or direction for each lane.
#[derive(Clone, Copy)]
pub struct Vectors<F> {
    pub x: F,
    pub y: F,
    pub z: F,
}

impl<F: Floats> Vectors<F> {
    #[inline(always)]
    pub fn load(present: F::Present, rows: &[F::Row; 3]) -> Self {
        Self {
            x: F::load(present, &rows[0]),
            y: F::load(present, &rows[1]),
            z: F::load(present, &rows[2]),
        }
    }

    #[inline(always)]
    pub fn splat(present: F::Present, v: [f32; 3]) -> Self {
        Self {
            x: F::splat(present, v[0]),
            y: F::splat(present, v[1]),
            z: F::splat(present, v[2]),
        }
    }

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self {
            x: self.x - o.x,
            y: self.y - o.y,
            z: self.z - o.z,
        }
    }

    #[inline(always)]
    fn cross(self, o: Self) -> Self {
        Self {
            x: self.y.mul_sub(o.z, self.z * o.y),
            y: self.z.mul_sub(o.x, self.x * o.z),
            z: self.x.mul_sub(o.y, self.y * o.x),
        }
    }

    #[inline(always)]
    fn dot(self, o: Self) -> F {
        self.z.mul_add(o.z, self.y.mul_add(o.y, self.x * o.x))
    }

    /// The edge function of two sheared vertices. Its products are rounded before their
    /// difference is taken: that, not fused, is what makes its sign exact.
    #[inline(always)]
    fn edge(self, o: Self) -> F {
        self.x * o.y - self.y * o.x
    }
}

/// The triangles of a block as seen from an origin `o`, before a direction is known.
///
/// The fast test (Möller & Trumbore 1997, in the division-free form of Embree): with `C = v0 − o`
/// and a direction `d`, `den = N·d`, `U = (e2 × C)·d`, `V = (e1 × C)·d`, `T = N·C`; after division
/// by `den` these are the weights of the second and third vertex and the distance. Two triangles round
/// their shared edge each in their own way, so that about one ray in a million slips through.
///
/// The watertight test (Woop, Benthin & Wald 2013): vertices relative to `o` are sheared along `d`
/// into a plane, the same for every triangle that has the vertex; there, an edge function is
/// the difference of two rounded products, which has the sign of the exact one or is zero, and zero
/// counts as inside. No ray passes between two triangles that share an edge or a vertex.
///
/// Single rays and bundles share these operations in this order, so that they agree to the last bit.
pub struct Seen<F: Floats, const TIGHT: bool> {
    present: F::Present,
    /// `N`, or the first vertex relative to the origin.
    first: Vectors<F>,
    /// `e2 × C`, or the second vertex.
    second: Vectors<F>,
    /// `e1 × C`, or the third vertex.
    third: Vectors<F>,
    /// `N·C`, or nothing.
    t: F,
}

/// The undivided results for one ray and a block of triangles, made positive in the denominator.
pub struct Crossing<F> {
    pub u: F,
    pub v: F,
    pub t: F,
    pub denominator: F,
}

impl<F: Floats, const TIGHT: bool> Seen<F, TIGHT> {
    #[inline(always)]
    pub fn new(present: F::Present, block: &Block<F>, origin: Vectors<F>) -> Self {
        let [c, e1, e2] = &block.rows;
        let c = Vectors::load(present, c).sub(origin);
        let (e1, e2) = (Vectors::load(present, e1), Vectors::load(present, e2));
        if TIGHT {
            return Self {
                present,
                first: c,
                second: e1.sub(origin),
                third: e2.sub(origin),
                t: F::splat(present, 0.0),
            };
        }
        let normal = e2.cross(e1);
        Self {
            present,
            first: normal,
            second: e2.cross(c),
            third: e1.cross(c),
            t: normal.dot(c),
        }
    }

    /// The crossings of one ray, whose direction is in all lanes.
    #[inline(always)]
    pub fn cross(&self, direction: Vectors<F>) -> Crossing<F> {
        if TIGHT {
            return self.cross_sheared([
                direction.x.first(),
                direction.y.first(),
                direction.z.first(),
            ]);
        }
        let denominator = self.first.dot(direction);
        let sign = denominator.and(F::splat(self.present, -0.0));
        Crossing {
            u: self.second.dot(direction).xor(sign),
            v: self.third.dot(direction).xor(sign),
            t: self.t.xor(sign),
            denominator: denominator.xor(sign),
        }
    }

    /// The watertight test.
    #[inline(always)]
    fn cross_sheared(&self, direction: [f32; 3]) -> Crossing<F> {
        let [dx, dy, dz] = direction.map(f32::abs);
        let main = if dx >= dy && dx >= dz {
            0
        } else {
            1 + usize::from(dz > dy)
        };
        let (left, right) = ((main + 1) % 3, (main + 2) % 3);
        let along = 1.0 / direction[main];
        let splat = |value| F::splat(self.present, value);
        let shear = Shear {
            axes: [main, left, right],
            slopes: [
                splat(direction[left] * along),
                splat(direction[right] * along),
            ],
            along: splat(along),
        };
        let a = shear.apply(self.first);
        let b = shear.apply(self.second);
        let c = shear.apply(self.third);
        let (w, u, v) = (c.edge(b), a.edge(c), b.edge(a));
        let denominator = w + (u + v);
        let sign = denominator.and(F::splat(self.present, -0.0));
        let (w, u, v) = (w.xor(sign), u.xor(sign), v.xor(sign));
        let distances = Vectors {
            x: a.z,
            y: b.z,
            z: c.z,
        };
        let t = distances.dot(Vectors { x: w, y: u, z: v });
        Crossing {
            u,
            v,
            // `hits` tests u, v and their sum; an outside w makes the distance a NaN.
            t: t.nan_where_negative(w),
            denominator: denominator.xor(sign),
        }
    }
}

/// What turns a ray into the third axis: the plane's axes keep their places, `z` becomes the distance.
struct Shear<F> {
    /// The direction's main axis and the two others.
    axes: [usize; 3],
    slopes: [F; 2],
    along: F,
}

impl<F: Floats> Shear<F> {
    #[inline(always)]
    fn apply(&self, vertex: Vectors<F>) -> Vectors<F> {
        let rows = [vertex.x, vertex.y, vertex.z];
        let [main, left, right] = self.axes;
        let depth = rows[main];
        Vectors {
            x: self.slopes[0].neg_mul_add(depth, rows[left]),
            y: self.slopes[1].neg_mul_add(depth, rows[right]),
            z: depth * self.along,
        }
    }
}

impl<F: Floats> Crossing<F> {
    /// A bit for each lane hit in `(t_min, t_max]`, without division. A parallel or degenerate
    /// triangle has `denominator = 0` and then cannot pass both limits.
    #[inline(always)]
    pub fn hits(&self, present: F::Present, t_min: F, t_max: F) -> u32 {
        let zero = F::splat(present, 0.0);
        let inside = zero.le(self.u.min(self.v)) & (self.u + self.v).le(self.denominator);
        let within = (self.denominator * t_min).lt(self.t) & self.t.le(self.denominator * t_max);
        inside & within
    }
}
