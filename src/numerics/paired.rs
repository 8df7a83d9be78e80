//! Real series of 1,024 modes by transforms that are two passes of 32-point transforms, with the same bits on every CPU.
//!
//! | symbol | code | shape | meaning |
//! |---|---|---|---|
//! | c_k | `spectrum[k - 1]` | (modes) x 8 | complex amplitude of mode k = 1, 2, ..., N |
//! | M, N = 1024, R = M/N | `samples`, `N`, `shifts` | 1 | points of a series, of a transform, and their ratio |
//! | P_k, S_k | `bins` | (N) x 8 | what modes k and k - N put into bin k |
//! | r, q | r, q | 0, 2, .. R - 2; 0..N | a shift, a point of its transform |
//!
//! The series at a shift is real, so shifts r and r + 1 share one complex transform: with w = e^(2 pi i/M), u_r = w^(-N r),
//! P = c (1 + i w^k)/2 and S_k = conj(Q_(N - k)), Q = c (1 - i w^k)/2,
//! ```text
//! eta(r + R q) + i eta(r + 1 + R q) = sum_k (P_k + u_r S_k) w^(k r) e^(2 pi i k q/N)
//! ```
//! k = k_1 + 32 k_2 and q = q_1 + 32 q_2: first over k_2 at every k_1, then over k_1 at every q_1. Loops over the eight
//! fields are innermost and work in place, which is what the compiler turns into whole vectors at every level. A series
//! does not fit a cache near the CPU: both shifts of a transform are neighbours, and what else is touched is kept small.
//! Tested against direct sums and rustfft in `tests/physics/fourier.rs`.

use crate::numerics::fourier::{Lanes, WIDTH, turn, turns};
use crate::numerics::lanes::Kernel;
use num_complex::Complex;

/// Modes of a series.
pub(crate) const N: usize = 1024;
/// Points of one small transform: N = SIDE^2.
const SIDE: usize = 32;
/// Distance of the rows between the passes: not a multiple of 4 kB, so that a column spreads over the cache.
const ROW: usize = SIDE + 1;

/// Eight complex numbers on cache lines of their own.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Wide {
    re: [f64; WIDTH],
    im: [f64; WIDTH],
}

impl Wide {
    const ZERO: Self = Self {
        re: [0.0; WIDTH],
        im: [0.0; WIDTH],
    };
}

/// What a mode and its negative put into a bin.
#[derive(Clone, Copy)]
struct Bin {
    p: Wide,
    s: Wide,
}

/// The constants of series of a length.
struct Constants {
    /// (samples) e^(2 pi i j/M).
    turns: Vec<Complex<f64>>,
    /// (R/2, 32, 32) w^(k_1 (r + R q_1)) for even r, k_1 innermost: the phase of a shift and the twiddle between the passes in one.
    between: Vec<Complex<f64>>,
    /// (8, 4) e^(2 pi i n m/32).
    within: [[Complex<f64>; 4]; 8],
    /// sqrt(1/2).
    half: f64,
}

/// A plan for real series, with its buffers.
pub(crate) struct Paired {
    shifts: usize,
    constants: Constants,
    // (N), bin k_1 + 32 k_2 at 32 k_1 + k_2.
    bins: Vec<Bin>,
    /// c_N, which meets its own negative in bin 0.
    last: Wide,
    // (32, ROW), the result of the first pass by k_1 and q_1.
    rows: Vec<Wide>,
}

impl Paired {
    /// Plans series of `samples` points, a power of two and at least 2 N.
    pub(crate) fn new(samples: usize) -> Self {
        let shifts = samples / N;
        let turns = turns(samples);
        let at = |r: usize, q: usize, k: usize| turns[(k * (r + shifts * q)) & (samples - 1)];
        let between = (0..shifts / 2)
            .flat_map(|pair| (0..SIDE).flat_map(move |q| (0..SIDE).map(move |k| (pair, q, k))))
            .map(|(pair, q, k)| at(2 * pair, q, k))
            .collect();
        let constants = Constants {
            between,
            within: std::array::from_fn(|n| std::array::from_fn(|m| turn(n * m, SIDE))),
            half: turn(1, 8).re,
            turns,
        };
        Self {
            shifts,
            constants,
            bins: vec![
                Bin {
                    p: Wide::ZERO,
                    s: Wide::ZERO
                };
                N
            ],
            last: Wide::ZERO,
            rows: vec![Wide::ZERO; SIDE * ROW],
        }
    }

    /// Sets P and S from the modes.
    #[inline(always)]
    fn load(&mut self, spectrum: &[Complex<Lanes>]) {
        self.last = Wide::ZERO;
        for k in 1..=N {
            let turn = self.constants.turns[k];
            let zero = Lanes([0.0; WIDTH]);
            let c = spectrum.get(k - 1).copied().unwrap_or(Complex { re: zero, im: zero });
            let (re, im) = (c.re.0, c.im.0);
            if k == N {
                self.last = Wide { re, im };
                continue;
            }
            let (p, s) = (place(k), place(N - k));
            for i in 0..WIDTH {
                // i c w^k, which P adds and Q subtracts.
                let turned_re = -(re[i] * turn.im + im[i] * turn.re);
                let turned_im = re[i] * turn.re - im[i] * turn.im;
                self.bins[p].p.re[i] = 0.5 * (re[i] + turned_re);
                self.bins[p].p.im[i] = 0.5 * (im[i] + turned_im);
                self.bins[s].s.re[i] = 0.5 * (re[i] - turned_re);
                self.bins[s].s.im[i] = -0.5 * (im[i] - turned_im);
            }
        }
    }

    /// The first pass of shifts r and r + 1.
    #[inline(always)]
    fn first_pass(&mut self, r: usize, local: &mut [Wide; SIDE]) {
        let turns = &self.constants.turns;
        let at = |j: usize| turns[j & (turns.len() - 1)];
        let (u, next) = (at(N * r).conj(), at(N * (r + 1)).conj());
        // Bin 0 holds mode N and its negative: Re(c_N w^(N r)) + i Re(c_N w^(N (r + 1))).
        for i in 0..WIDTH {
            self.bins[0].p.re[i] = self.last.re[i] * u.re + self.last.im[i] * u.im;
            self.bins[0].p.im[i] = self.last.re[i] * next.re + self.last.im[i] * next.im;
        }
        let mut shift = [u; SIDE];
        for (k, shift) in shift.iter_mut().enumerate() {
            *shift = at(SIDE * k * r);
        }
        let rows = self.rows.as_chunks_mut::<ROW>().0;
        for (bins, row) in self.bins.as_chunks::<SIDE>().0.iter().zip(rows) {
            for n in 0..8 {
                enter_bins(bins, n, u, &shift, &self.constants.within[n], local);
            }
            finish(self.constants.half, local);
            for (m, eight) in local.as_chunks::<8>().0.iter().enumerate() {
                for (q, value) in eight.iter().enumerate() {
                    row[m + 4 * q] = *value;
                }
            }
        }
    }

    /// The second pass of shifts r and r + 1 at one q_1, to the series.
    #[inline(always)]
    fn second_pass(&self, r: usize, q: usize, local: &mut [Wide; SIDE], out: &mut [[f64; WIDTH]]) {
        let (Some(rows), Some(between)) = (
            self.rows.first_chunk(),
            self.constants.between.as_chunks::<SIDE>().0.get(r / 2 * SIDE + q),
        ) else {
            return;
        };
        for n in 0..8 {
            enter_column(rows, q, n, between, &self.constants.within[n], local);
        }
        finish(self.constants.half, local);
        for (m, eight) in local.as_chunks::<8>().0.iter().enumerate() {
            for (k, value) in eight.iter().enumerate() {
                let j = r + self.shifts * (q + SIDE * (m + 4 * k));
                out[j] = value.re;
                out[j + 1] = value.im;
            }
        }
    }
}

/// Where bin k lies.
fn place(k: usize) -> usize {
    SIDE * (k % SIDE) + k / SIDE
}

/// The real series of some modes, to be dispatched.
pub(crate) struct RealSeries<'a> {
    pub(crate) plan: &'a mut Paired,
    pub(crate) spectrum: &'a [Complex<Lanes>],
    pub(crate) out: &'a mut [[f64; WIDTH]],
}

impl Kernel for RealSeries<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { plan, spectrum, out } = self;
        plan.load(spectrum);
        let mut local = [Wide::ZERO; SIDE];
        for r in (0..plan.shifts).step_by(2) {
            plan.first_pass(r, &mut local);
            for q in 0..SIDE {
                plan.second_pass(r, q, &mut local, out);
            }
        }
    }
}

/// a b in one lane.
#[inline(always)]
fn times(re: f64, im: f64, b: Complex<f64>) -> (f64, f64) {
    (re * b.re - im * b.im, re * b.im + im * b.re)
}

/// The transform of four points in one lane: re, im, re, im, ...
#[inline(always)]
fn four(a: [f64; 8]) -> [f64; 8] {
    let (sum_re, sum_im, other_re, other_im) = (a[0] + a[4], a[1] + a[5], a[2] + a[6], a[3] + a[7]);
    let (gap_re, gap_im, turn_re, turn_im) = (a[0] - a[4], a[1] - a[5], a[2] - a[6], a[3] - a[7]);
    [
        sum_re + other_re,
        sum_im + other_im,
        gap_re - turn_im,
        gap_im + turn_re,
        sum_re - other_re,
        sum_im - other_im,
        gap_re + turn_im,
        gap_im - turn_re,
    ]
}

/// P + u S, turned by the shift, in one lane.
#[inline(always)]
fn entered(bin: &Bin, i: usize, u: Complex<f64>, shift: Complex<f64>) -> (f64, f64) {
    let (re, im) = times(bin.s.re[i], bin.s.im[i], u);
    times(bin.p.re[i] + re, bin.p.im[i] + im, shift)
}

/// Points n, n + 8, n + 16, n + 24 of the first pass, and their transform of four.
#[inline(always)]
fn enter_bins(
    bins: &[Bin; SIDE],
    n: usize,
    u: Complex<f64>,
    shift: &[Complex<f64>; SIDE],
    within: &[Complex<f64>; 4],
    local: &mut [Wide; SIDE],
) {
    let (a, b, c, d) = (&bins[n], &bins[n + 8], &bins[n + 16], &bins[n + 24]);
    let [w_a, w_b, w_c, w_d] = [shift[n], shift[n + 8], shift[n + 16], shift[n + 24]];
    let [_, t_1, t_2, t_3] = *within;
    for i in 0..WIDTH {
        let (a, b) = (entered(a, i, u, w_a), entered(b, i, u, w_b));
        let (c, d) = (entered(c, i, u, w_c), entered(d, i, u, w_d));
        let y = four([a.0, a.1, b.0, b.1, c.0, c.1, d.0, d.1]);
        (local[n].re[i], local[n].im[i]) = (y[0], y[1]);
        (local[n + 8].re[i], local[n + 8].im[i]) = times(y[2], y[3], t_1);
        (local[n + 16].re[i], local[n + 16].im[i]) = times(y[4], y[5], t_2);
        (local[n + 24].re[i], local[n + 24].im[i]) = times(y[6], y[7], t_3);
    }
}

/// Points n, n + 8, n + 16, n + 24 of a column between the passes, and their transform of four.
#[inline(always)]
fn enter_column(
    rows: &[Wide; SIDE * ROW],
    q: usize,
    n: usize,
    between: &[Complex<f64>; SIDE],
    within: &[Complex<f64>; 4],
    local: &mut [Wide; SIDE],
) {
    let (a, b) = (&rows[n * ROW + q], &rows[(n + 8) * ROW + q]);
    let (c, d) = (&rows[(n + 16) * ROW + q], &rows[(n + 24) * ROW + q]);
    let [w_a, w_b, w_c, w_d] = [between[n], between[n + 8], between[n + 16], between[n + 24]];
    let [_, t_1, t_2, t_3] = *within;
    for i in 0..WIDTH {
        let (a, b) = (times(a.re[i], a.im[i], w_a), times(b.re[i], b.im[i], w_b));
        let (c, d) = (times(c.re[i], c.im[i], w_c), times(d.re[i], d.im[i], w_d));
        let y = four([a.0, a.1, b.0, b.1, c.0, c.1, d.0, d.1]);
        (local[n].re[i], local[n].im[i]) = (y[0], y[1]);
        (local[n + 8].re[i], local[n + 8].im[i]) = times(y[2], y[3], t_1);
        (local[n + 16].re[i], local[n + 16].im[i]) = times(y[4], y[5], t_2);
        (local[n + 24].re[i], local[n + 24].im[i]) = times(y[6], y[7], t_3);
    }
}

/// The four transforms of eight that end one of 32: point m + 4 q is left at 8 m + q.
#[inline(always)]
fn finish(half: f64, local: &mut [Wide; SIDE]) {
    for x in local.as_chunks_mut::<8>().0 {
        for i in 0..WIDTH {
            let [a, b, c, d] = [&x[0], &x[2], &x[4], &x[6]];
            let even = four([a.re[i], a.im[i], b.re[i], b.im[i], c.re[i], c.im[i], d.re[i], d.im[i]]);
            let [a, b, c, d] = [&x[1], &x[3], &x[5], &x[7]];
            let odd = four([a.re[i], a.im[i], b.re[i], b.im[i], c.re[i], c.im[i], d.re[i], d.im[i]]);
            // Turns by an eighth, a quarter, three eighths: i times the first one again.
            let (re_1, im_1) = ((odd[2] - odd[3]) * half, (odd[2] + odd[3]) * half);
            let (re_3, im_3) = ((odd[6] - odd[7]) * half, (odd[6] + odd[7]) * half);
            (x[0].re[i], x[0].im[i]) = (even[0] + odd[0], even[1] + odd[1]);
            (x[1].re[i], x[1].im[i]) = (even[2] + re_1, even[3] + im_1);
            (x[2].re[i], x[2].im[i]) = (even[4] - odd[5], even[5] + odd[4]);
            (x[3].re[i], x[3].im[i]) = (even[6] - im_3, even[7] + re_3);
            (x[4].re[i], x[4].im[i]) = (even[0] - odd[0], even[1] - odd[1]);
            (x[5].re[i], x[5].im[i]) = (even[2] - re_1, even[3] - im_1);
            (x[6].re[i], x[6].im[i]) = (even[4] + odd[5], even[5] - odd[4]);
            (x[7].re[i], x[7].im[i]) = (even[6] + im_3, even[7] - re_3);
        }
    }
}
