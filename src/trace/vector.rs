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

/// Eight triangles as seen from an origin `o`, before a direction is known. With `C = v0 − o` and a
/// direction `d`: `den = N·d`, `U = (e2 × C)·d`, `V = (e1 × C)·d`, `T = N·C`; after division by
/// `den` these are the weights of the second and third vertex and the distance
/// (Möller & Trumbore 1997, in the division-free form of Embree).
///
/// Single rays and bundles share these operations in this order, so that they agree to the last bit.
pub struct Seen {
    pub normal: Vec3x8,
    pub u: Vec3x8,
    pub v: Vec3x8,
    pub t: __m256,
}

/// The undivided results for one ray and eight triangles, made positive in the denominator.
pub struct Crossing {
    pub u: __m256,
    pub v: __m256,
    pub t: __m256,
    pub denominator: __m256,
}

impl Seen {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn new(block: &Block, origin: Vec3x8) -> Self {
        let (e1, e2) = (Vec3x8::load(&block.e1), Vec3x8::load(&block.e2));
        let c = Vec3x8::load(&block.v0).sub(origin);
        let normal = e2.cross(e1);
        Self {
            normal,
            u: e2.cross(c),
            v: e1.cross(c),
            t: normal.dot(c),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn cross(&self, direction: Vec3x8) -> Crossing {
        let denominator = self.normal.dot(direction);
        let sign = _mm256_and_ps(denominator, _mm256_set1_ps(-0.0));
        Crossing {
            u: _mm256_xor_ps(self.u.dot(direction), sign),
            v: _mm256_xor_ps(self.v.dot(direction), sign),
            t: _mm256_xor_ps(self.t, sign),
            denominator: _mm256_xor_ps(denominator, sign),
        }
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
