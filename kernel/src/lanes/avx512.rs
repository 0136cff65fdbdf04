//! Crosswise work on vectors of eight lanes: transpositions and sums, with AVX-512.

use pulp::Simd;
use pulp::x86::V4;
use std::arch::x86_64::{__m512d, __m512i};

/// The columns of a matrix of eight rows, and the other way round.
#[inline(always)]
pub(super) fn transposed(simd: V4, rows: &[__m512d; 8]) -> [__m512d; 8] {
    let f = simd.avx512f;
    let mut columns = *rows;
    for parity in 0..2 {
        let mut pairs = [rows[0]; 4];
        for k in 0..4 {
            let (a, b) = (rows[2 * k], rows[2 * k + 1]);
            pairs[k] = if parity == 0 { f._mm512_unpacklo_pd(a, b) } else { f._mm512_unpackhi_pd(a, b) };
        }
        // The pairs stand in blocks of two lanes, which are transposed as a matrix of 4 × 4.
        let [a, b, c, d] = pairs;
        let (first, second) = (f._mm512_shuffle_f64x2::<0x44>(a, b), f._mm512_shuffle_f64x2::<0x44>(c, d));
        columns[parity] = f._mm512_shuffle_f64x2::<0x88>(first, second);
        columns[parity + 2] = f._mm512_shuffle_f64x2::<0xdd>(first, second);
        let (first, second) = (f._mm512_shuffle_f64x2::<0xee>(a, b), f._mm512_shuffle_f64x2::<0xee>(c, d));
        columns[parity + 4] = f._mm512_shuffle_f64x2::<0x88>(first, second);
        columns[parity + 6] = f._mm512_shuffle_f64x2::<0xdd>(first, second);
    }
    columns
}

/// Sums of all lanes of eight vectors: pairs of vectors are added crosswise three times, which takes
/// a third of the instructions that one sum after the other takes.
#[inline(always)]
pub(super) fn sums(simd: V4, vectors: &[__m512d; 8]) -> __m512d {
    let f = simd.avx512f;
    let mut v = *vectors;
    for k in 0..4 {
        let (a, b) = (v[2 * k], v[2 * k + 1]);
        v[k] = f._mm512_add_pd(f._mm512_unpacklo_pd(a, b), f._mm512_unpackhi_pd(a, b));
    }
    for k in [0, 1, 0] {
        let (a, b) = (v[2 * k], v[2 * k + 1]);
        let even = f._mm512_shuffle_f64x2::<0b10_00_10_00>(a, b);
        v[k] = f._mm512_add_pd(even, f._mm512_shuffle_f64x2::<0b11_01_11_01>(a, b));
    }
    v[0]
}

/// Eight rows of `C` numbers: entry c of row l in lane l of vector c.
#[inline(always)]
pub(super) fn read_rows<const C: usize>(simd: V4, rows: &[f64]) -> [__m512d; C] {
    let rows = &rows[..8 * C];
    let mut out = [simd.avx512f._mm512_setzero_pd(); C];
    if C <= 4 {
        let mut stored = out;
        for k in 0..C {
            stored[k] = load(simd, rows, 8 * k);
        }
        for c in 0..C {
            out[c] = stored[0];
            for k in 1..C {
                // Lane l is number l C + c.
                let index = const { indices::<C>(true) }[c][k];
                out[c] = simd.avx512f._mm512_permutex2var_pd(out[c], vector(index), stored[k]);
            }
        }
        return out;
    }
    let mut square = [out[0]; 8];
    for l in 0..8 {
        let first = l * C;
        square[l] = if first + 8 <= 8 * C {
            load(simd, rows, first)
        } else {
            pulp::cast(simd.partial_load_f64s(&rows[first..]))
        };
    }
    square = transposed(simd, &square);
    out[..C.min(8)].copy_from_slice(&square[..C.min(8)]);
    for c in 8..C {
        let mut column = [0.0; 8];
        for l in 0..8 {
            column[l] = rows[l * C + c];
        }
        out[c] = pulp::cast(column);
    }
    out
}

/// Writes what [`read_rows`] reads.
#[inline(always)]
pub(super) fn write_rows<const C: usize>(simd: V4, rows: &mut [f64], values: &[__m512d; C]) {
    let rows = &mut rows[..8 * C];
    if C <= 4 {
        for k in 0..C {
            let mut stored = values[0];
            for c in 1..C {
                let index = const { indices::<C>(false) }[c][k];
                stored = simd.avx512f._mm512_permutex2var_pd(stored, vector(index), values[c]);
            }
            store(simd, rows, 8 * k, stored);
        }
        return;
    }
    let mut square = [values[0]; 8];
    square[..C.min(8)].copy_from_slice(&values[..C.min(8)]);
    square = transposed(simd, &square);
    for l in 0..8 {
        let first = l * C;
        // What is written beyond a row is overwritten by the next ones.
        if first + 8 <= 8 * C {
            store(simd, rows, first, square[l]);
        } else {
            simd.partial_store_f64s(&mut rows[first..first + C], pulp::cast(square[l]));
        }
    }
    for c in 8..C {
        let column: [f64; 8] = pulp::cast(values[c]);
        for l in 0..8 {
            rows[l * C + c] = column[l];
        }
    }
}

#[inline(always)]
fn load(simd: V4, numbers: &[f64], first: usize) -> __m512d {
    let _ = simd;
    let (vectors, _) = V4::as_simd_f64s(&numbers[first..first + 8]);
    pulp::cast(vectors[0])
}

#[inline(always)]
fn store(simd: V4, numbers: &mut [f64], first: usize, value: __m512d) {
    let _ = simd;
    let (vectors, _) = V4::as_mut_simd_f64s(&mut numbers[first..first + 8]);
    vectors[0] = pulp::cast(value);
}

#[inline(always)]
fn vector(index: [u64; 8]) -> __m512i {
    pulp::cast(index)
}

/// Where the lanes of a merged vector come from when another one is merged into it, 8 + lane for the
/// other one. Reading, entry `[c][k]` merges the numbers 8k to 8k + 7 of the rows into column c;
/// writing, column c into the numbers 8k to 8k + 7.
const fn indices<const C: usize>(reading: bool) -> [[[u64; 8]; C]; C] {
    let mut out = [[[0; 8]; C]; C];
    let mut c = 0;
    while c < C {
        let mut k = 0;
        while k < C {
            let mut l = 0;
            while l < 8 {
                let number = if reading { l * C + c } else { 8 * k + l };
                let (from, other, lane) =
                    if reading { (number / 8, k, number % 8) } else { (number % C, c, number / C) };
                out[c][k][l] = if from == other {
                    8 + lane as u64
                } else if other == 1 {
                    // The first vector has not been permuted yet.
                    lane as u64
                } else {
                    l as u64
                };
                l += 1;
            }
            k += 1;
        }
        c += 1;
    }
    out
}
