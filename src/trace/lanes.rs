//! Many floats at a time on two instruction sets: the few operations that the kernels are written in.
//!
//! A value of [`Avx512`] or [`Avx2`] can only be made with a proof that the processor has the
//! instructions, which is why every operation on it is safe. Everything here and in the kernels is
//! `#[inline(always)]`: it becomes part of the entry points in [`super::entry`], which alone are
//! compiled for these instructions. Lanes do not mix, so that hits are the same to the last bit
//! on either set.

use std::arch::x86_64::*;
use std::ops::{Add, Div, IndexMut, Mul, Sub};

use crate::instructions::Instructions;

/// The most lanes of any instruction set.
pub const MOST_LANES: usize = 16;

/// A register of floats: the boxes of a node, the triangles of a block or the rays of a group. Masks
/// have a bit for each lane.
pub trait Floats:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    const LANES: usize;
    /// `[f32; LANES]`.
    type Row: Copy + IndexMut<usize, Output = f32>;
    /// `[u32; LANES]`.
    type Ids: Copy + IndexMut<usize, Output = u32>;
    /// Proof that the processor has the instructions.
    type Present: Copy + Send + Sync;

    /// The proof, if the processor has the instructions and `LIGHTBENCH_HIDE` does not hide them.
    fn detect() -> Option<Self::Present>;
    fn splat(present: Self::Present, value: f32) -> Self;
    fn load(present: Self::Present, row: &Self::Row) -> Self;
    fn store(self) -> Self::Row;
    /// The first lane.
    fn first(self) -> f32;

    /// `self·a + b`, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `self·a − b`, rounded once.
    fn mul_sub(self, a: Self, b: Self) -> Self;
    /// `b − self·a`, rounded once.
    fn neg_mul_add(self, a: Self, b: Self) -> Self;
    fn min(self, o: Self) -> Self;
    fn max(self, o: Self) -> Self;
    fn and(self, o: Self) -> Self;
    fn xor(self, o: Self) -> Self;
    /// The smaller by the order of the bits as integers.
    fn min_bits(self, o: Self) -> Self;
    /// The larger by the order of the bits as integers.
    fn max_bits(self, o: Self) -> Self;
    /// NaN where `o < 0`.
    fn nan_where_negative(self, o: Self) -> Self;

    fn lt(self, o: Self) -> u32;
    fn le(self, o: Self) -> u32;
    /// `self ≤ o` by the order of the bits as integers.
    fn le_bits(self, o: Self) -> u32;

    /// Writes the ids of a mask's lanes, highest lane first, to the front of `top`, and anything to
    /// the rest of its first `LANES` places: no branch and no loop.
    fn write_falling(present: Self::Present, ids: &Self::Ids, lanes: u32, top: &mut [u32]);
}

/// Sixteen floats in a register of AVX-512.
#[derive(Clone, Copy)]
pub struct Avx512(__m512);

/// Eight floats in a register of AVX2.
#[derive(Clone, Copy)]
pub struct Avx2(__m256);

/// Proof of AVX-512 (F and DQ) and of what [`HasAvx2`] proves.
#[derive(Clone, Copy, Debug)]
pub struct HasAvx512(());

/// Proof of AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT (x86-64-v3).
#[derive(Clone, Copy, Debug)]
pub struct HasAvx2(());

/// Operators of one instruction.
macro_rules! operators {
    ($floats:ident: $($operator:ident::$name:ident = $instruction:ident),*) => {
        $(impl $operator for $floats {
            type Output = Self;

            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                // SAFETY: values exist only where their instructions do.
                Self(unsafe { $instruction(self.0, o.0) })
            }
        })*
    };
}

/// Functions of one instruction.
macro_rules! functions {
    ($($name:ident($($other:ident),*) = $instruction:ident),*) => {
        $(#[inline(always)]
        fn $name(self, $($other: Self),*) -> Self {
            // SAFETY: values exist only where their instructions do.
            Self(unsafe { $instruction(self.0, $($other.0),*) })
        })*
    };
}

/// Between registers, numbers and memory.
macro_rules! transfers {
    ($proof:ident, $lanes:literal: $splat:ident, $load:ident, $store:ident, $first:ident) => {
        #[inline(always)]
        fn splat(_: $proof, value: f32) -> Self {
            // SAFETY: the proof.
            Self(unsafe { $splat(value) })
        }

        #[inline(always)]
        fn load(_: $proof, row: &[f32; $lanes]) -> Self {
            // SAFETY: the proof; the reference covers the bytes read, without a demand on alignment.
            Self(unsafe { $load(row.as_ptr()) })
        }

        #[inline(always)]
        fn store(self) -> [f32; $lanes] {
            let mut row = [0.0; $lanes];
            // SAFETY: `row` is the bytes written, without a demand on alignment.
            unsafe { $store(row.as_mut_ptr(), self.0) };
            row
        }

        #[inline(always)]
        fn first(self) -> f32 {
            // SAFETY: values exist only where their instructions do.
            unsafe { $first(self.0) }
        }
    };
}

/// Functions of the bits as integers; `$to` and `$from` rename registers.
macro_rules! integer_functions {
    ($to:ident, $from:ident: $($name:ident = $instruction:ident),*) => {
        $(#[inline(always)]
        fn $name(self, o: Self) -> Self {
            // SAFETY: values exist only where their instructions do.
            Self(unsafe { $from($instruction($to(self.0), $to(o.0))) })
        })*
    };
}

operators!(Avx512: Add::add = _mm512_add_ps, Sub::sub = _mm512_sub_ps,
    Mul::mul = _mm512_mul_ps, Div::div = _mm512_div_ps);
operators!(Avx2: Add::add = _mm256_add_ps, Sub::sub = _mm256_sub_ps,
    Mul::mul = _mm256_mul_ps, Div::div = _mm256_div_ps);

impl Floats for Avx512 {
    const LANES: usize = 16;
    type Row = [f32; 16];
    type Ids = [u32; 16];
    type Present = HasAvx512;

    fn detect() -> Option<HasAvx512> {
        Instructions::Avx512.is_present().then_some(HasAvx512(()))
    }

    functions!(
        mul_add(a, b) = _mm512_fmadd_ps,
        mul_sub(a, b) = _mm512_fmsub_ps,
        neg_mul_add(a, b) = _mm512_fnmadd_ps,
        min(o) = _mm512_min_ps,
        max(o) = _mm512_max_ps,
        and(o) = _mm512_and_ps,
        xor(o) = _mm512_xor_ps
    );

    transfers!(HasAvx512, 16: _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_cvtss_f32);

    integer_functions!(
        _mm512_castps_si512,
        _mm512_castsi512_ps:
        min_bits = _mm512_min_epi32,
        max_bits = _mm512_max_epi32
    );

    #[inline(always)]
    fn nan_where_negative(self, o: Self) -> Self {
        // SAFETY: values exist only where their instructions do.
        Self(unsafe {
            let negative = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(o.0, _mm512_setzero_ps());
            _mm512_mask_blend_ps(negative, self.0, _mm512_set1_ps(f32::NAN))
        })
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u32 {
        // SAFETY: values exist only where their instructions do.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, o.0) })
    }

    #[inline(always)]
    fn le(self, o: Self) -> u32 {
        // SAFETY: values exist only where their instructions do.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, o.0) })
    }

    #[inline(always)]
    fn le_bits(self, o: Self) -> u32 {
        // SAFETY: values exist only where their instructions do.
        u32::from(unsafe { _mm512_cmple_epi32_mask(self.bits(), o.bits()) })
    }

    #[inline(always)]
    fn write_falling(_: HasAvx512, ids: &[u32; 16], lanes: u32, top: &mut [u32]) {
        let top = &mut top[..16];
        // SAFETY: the proof; `ids` and `top` are the bytes read and written.
        unsafe {
            let falling = _mm512_set_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let order = _mm512_maskz_compress_epi32((lanes as u16).reverse_bits(), falling);
            let ids = _mm512_permutexvar_epi32(order, _mm512_loadu_si512(ids.as_ptr().cast()));
            _mm512_storeu_si512(top.as_mut_ptr().cast(), ids);
        }
    }
}

impl Avx512 {
    #[inline(always)]
    fn bits(self) -> __m512i {
        // SAFETY: values exist only where their instructions do.
        unsafe { _mm512_castps_si512(self.0) }
    }
}

impl Floats for Avx2 {
    const LANES: usize = 8;
    type Row = [f32; 8];
    type Ids = [u32; 8];
    type Present = HasAvx2;

    fn detect() -> Option<HasAvx2> {
        Instructions::Avx2.is_present().then_some(HasAvx2(()))
    }

    functions!(
        mul_add(a, b) = _mm256_fmadd_ps,
        mul_sub(a, b) = _mm256_fmsub_ps,
        neg_mul_add(a, b) = _mm256_fnmadd_ps,
        min(o) = _mm256_min_ps,
        max(o) = _mm256_max_ps,
        and(o) = _mm256_and_ps,
        xor(o) = _mm256_xor_ps
    );

    transfers!(HasAvx2, 8: _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_cvtss_f32);

    integer_functions!(
        _mm256_castps_si256,
        _mm256_castsi256_ps:
        min_bits = _mm256_min_epi32,
        max_bits = _mm256_max_epi32
    );

    #[inline(always)]
    fn nan_where_negative(self, o: Self) -> Self {
        // SAFETY: values exist only where their instructions do.
        Self(unsafe {
            let negative = _mm256_cmp_ps::<_CMP_LT_OQ>(o.0, _mm256_setzero_ps());
            _mm256_or_ps(self.0, negative)
        })
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u32 {
        // SAFETY: values exist only where their instructions do.
        Self(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, o.0) }).signs()
    }

    #[inline(always)]
    fn le(self, o: Self) -> u32 {
        // SAFETY: values exist only where their instructions do.
        Self(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, o.0) }).signs()
    }

    #[inline(always)]
    fn le_bits(self, o: Self) -> u32 {
        // SAFETY: values exist only where their instructions do.
        let greater = unsafe { _mm256_cmpgt_epi32(self.bits(), o.bits()) };
        // SAFETY: as above.
        !Self(unsafe { _mm256_castsi256_ps(greater) }).signs() & 0xff
    }

    #[inline(always)]
    fn write_falling(_: HasAvx2, ids: &[u32; 8], lanes: u32, top: &mut [u32]) {
        let top = &mut top[..8];
        let order = &FALLING[lanes as usize & 0xff];
        // SAFETY: the proof; `order`, `ids` and `top` are the bytes read and written.
        unsafe {
            let order = _mm256_loadu_si256(order.as_ptr().cast());
            let ids = _mm256_loadu_si256(ids.as_ptr().cast());
            let ids = _mm256_permutevar8x32_epi32(ids, order);
            _mm256_storeu_si256(top.as_mut_ptr().cast(), ids);
        }
    }
}

impl Avx2 {
    #[inline(always)]
    fn bits(self) -> __m256i {
        // SAFETY: values exist only where their instructions do.
        unsafe { _mm256_castps_si256(self.0) }
    }

    /// The signs of the lanes as a mask.
    #[inline(always)]
    fn signs(self) -> u32 {
        // SAFETY: values exist only where their instructions do.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

/// `[m]`: the positions of the set bits of `m` from the highest to the lowest, then zeros.
static FALLING: [[u32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut left = mask as u32;
        let mut count = 0;
        while left != 0 {
            let highest = 31 - left.leading_zeros();
            table[mask][count] = highest;
            left ^= 1 << highest;
            count += 1;
        }
        mask += 1;
    }
    table
};
