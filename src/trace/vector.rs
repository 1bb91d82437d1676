//! Eight floats at a time: the few operations the kernels are written in.
//!
//! Everything here and in the kernels carries the same `target_feature` list and is inlined into
//! the entry points of [`super::single`] and [`super::bundle`].

use std::arch::x86_64::*;

use super::wide::Block;

/// Three vectors of eight: a point or direction for each lane.
#[derive(Clone, Copy)]
pub struct Vec3x8 {
    pub x: __m256,
    pub y: __m256,
    pub z: __m256,
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn load(row: &[f32; 8]) -> __m256 {
    // SAFETY: the reference covers the 32 bytes read; the load has no alignment demand.
    unsafe { _mm256_loadu_ps(row.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn store(value: __m256) -> [f32; 8] {
    let mut row = [0.0; 8];
    // SAFETY: `row` is the 32 bytes written; the store has no alignment demand.
    unsafe { _mm256_storeu_ps(row.as_mut_ptr(), value) };
    row
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn load_bits(row: &[u32; 8]) -> __m256i {
    // SAFETY: the reference covers the 32 bytes read; the load has no alignment demand.
    unsafe { _mm256_loadu_si256(row.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn store_bits(row: &mut [u32], value: __m256i) {
    assert!(row.len() >= 8);
    // SAFETY: `row` covers the 32 bytes written; the store has no alignment demand.
    unsafe { _mm256_storeu_si256(row.as_mut_ptr().cast(), value) }
}

impl Vec3x8 {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn load(rows: &[[f32; 8]; 3]) -> Self {
        Self {
            x: load(&rows[0]),
            y: load(&rows[1]),
            z: load(&rows[2]),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn splat(v: [f32; 3]) -> Self {
        Self {
            x: _mm256_set1_ps(v[0]),
            y: _mm256_set1_ps(v[1]),
            z: _mm256_set1_ps(v[2]),
        }
    }

    /// The first lane.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn lowest(self) -> [f32; 3] {
        [
            _mm256_cvtss_f32(self.x),
            _mm256_cvtss_f32(self.y),
            _mm256_cvtss_f32(self.z),
        ]
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn sub(self, o: Self) -> Self {
        Self {
            x: _mm256_sub_ps(self.x, o.x),
            y: _mm256_sub_ps(self.y, o.y),
            z: _mm256_sub_ps(self.z, o.z),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn cross(self, o: Self) -> Self {
        Self {
            x: _mm256_fmsub_ps(self.y, o.z, _mm256_mul_ps(self.z, o.y)),
            y: _mm256_fmsub_ps(self.z, o.x, _mm256_mul_ps(self.x, o.z)),
            z: _mm256_fmsub_ps(self.x, o.y, _mm256_mul_ps(self.y, o.x)),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn dot(self, o: Self) -> __m256 {
        _mm256_fmadd_ps(
            self.z,
            o.z,
            _mm256_fmadd_ps(self.y, o.y, _mm256_mul_ps(self.x, o.x)),
        )
    }
}

/// Eight triangles as seen from an origin `o`, before a direction is known.
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
pub struct Seen<const TIGHT: bool> {
    /// `N`, or the first vertex relative to the origin.
    first: Vec3x8,
    /// `e2 × C`, or the second vertex.
    second: Vec3x8,
    /// `e1 × C`, or the third vertex.
    third: Vec3x8,
    /// `N·C`, or nothing.
    t: __m256,
}

/// The undivided results for one ray and eight triangles, made positive in the denominator.
pub struct Crossing {
    pub u: __m256,
    pub v: __m256,
    pub t: __m256,
    pub denominator: __m256,
}

impl<const TIGHT: bool> Seen<TIGHT> {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn new(block: &Block, origin: Vec3x8) -> Self {
        let c = Vec3x8::load(&block.rows[0]).sub(origin);
        let (e1, e2) = (Vec3x8::load(&block.rows[1]), Vec3x8::load(&block.rows[2]));
        if TIGHT {
            return Self {
                first: c,
                second: e1.sub(origin),
                third: e2.sub(origin),
                t: _mm256_setzero_ps(),
            };
        }
        let normal = e2.cross(e1);
        Self {
            first: normal,
            second: e2.cross(c),
            third: e1.cross(c),
            t: normal.dot(c),
        }
    }

    /// The crossings of one ray, whose direction is in all lanes.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn cross(&self, direction: Vec3x8) -> Crossing {
        if TIGHT {
            return self.cross_sheared(direction.lowest());
        }
        let denominator = self.first.dot(direction);
        let sign = _mm256_and_ps(denominator, _mm256_set1_ps(-0.0));
        Crossing {
            u: _mm256_xor_ps(self.second.dot(direction), sign),
            v: _mm256_xor_ps(self.third.dot(direction), sign),
            t: _mm256_xor_ps(self.t, sign),
            denominator: _mm256_xor_ps(denominator, sign),
        }
    }

    /// The watertight test.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn cross_sheared(&self, direction: [f32; 3]) -> Crossing {
        let [dx, dy, dz] = direction.map(f32::abs);
        let main = if dx >= dy && dx >= dz {
            0
        } else {
            1 + usize::from(dz > dy)
        };
        let (left, right) = ((main + 1) % 3, (main + 2) % 3);
        let along = 1.0 / direction[main];
        let shear = Shear {
            axes: [main, left, right],
            slopes: [left, right].map(|axis| direction[axis] * along),
            along,
        };
        let a = shear.apply(self.first);
        let b = shear.apply(self.second);
        let c = shear.apply(self.third);
        let (w, u, v) = (c.edge(b), a.edge(c), b.edge(a));
        let denominator = _mm256_add_ps(w, _mm256_add_ps(u, v));
        let sign = _mm256_and_ps(denominator, _mm256_set1_ps(-0.0));
        let (w, u, v) = (
            _mm256_xor_ps(w, sign),
            _mm256_xor_ps(u, sign),
            _mm256_xor_ps(v, sign),
        );
        let distances = Vec3x8 {
            x: a.z,
            y: b.z,
            z: c.z,
        };
        let t = distances.dot(Vec3x8 { x: w, y: u, z: v });
        // `hits` tests u, v and their sum; an outside w makes the distance a NaN.
        let outside = _mm256_cmp_ps::<_CMP_LT_OQ>(w, _mm256_setzero_ps());
        Crossing {
            u,
            v,
            t: _mm256_or_ps(t, outside),
            denominator: _mm256_xor_ps(denominator, sign),
        }
    }
}

/// What turns a ray into the third axis: the plane's axes keep their places, `z` becomes the distance.
struct Shear {
    /// The direction's main axis and the two others.
    axes: [usize; 3],
    slopes: [f32; 2],
    along: f32,
}

impl Shear {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn apply(&self, vertex: Vec3x8) -> Vec3x8 {
        let rows = [vertex.x, vertex.y, vertex.z];
        let [main, left, right] = self.axes;
        let (depth, left, right) = (rows[main], rows[left], rows[right]);
        Vec3x8 {
            x: _mm256_fnmadd_ps(_mm256_set1_ps(self.slopes[0]), depth, left),
            y: _mm256_fnmadd_ps(_mm256_set1_ps(self.slopes[1]), depth, right),
            z: _mm256_mul_ps(depth, _mm256_set1_ps(self.along)),
        }
    }
}

impl Vec3x8 {
    /// The edge function of two sheared vertices. Its products are rounded before their
    /// difference is taken: that, not fused, is what makes its sign exact.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn edge(self, o: Self) -> __m256 {
        _mm256_sub_ps(_mm256_mul_ps(self.x, o.y), _mm256_mul_ps(self.y, o.x))
    }
}

impl Crossing {
    /// A bit for each lane hit in `(t_min, t_max]`, without division. A parallel or degenerate
    /// triangle has `denominator = 0` and then cannot pass both limits.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn hits(&self, t_min: __m256, t_max: __m256) -> u32 {
        let inside = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GE_OQ>(_mm256_min_ps(self.u, self.v), _mm256_setzero_ps()),
            _mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_add_ps(self.u, self.v), self.denominator),
        );
        let within = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_LT_OQ>(_mm256_mul_ps(self.denominator, t_min), self.t),
            _mm256_cmp_ps::<_CMP_LE_OQ>(self.t, _mm256_mul_ps(self.denominator, t_max)),
        );
        _mm256_movemask_ps(_mm256_and_ps(inside, within)) as u32
    }
}
