//! Discrete Fourier transforms of eight fields side by side, with the same bits on every CPU.
//!
//! | symbol | code | unit or shape | meaning |
//! |---|---|---|---|
//! | c_k | `spectrum[k - 1]` | (modes) x 8 | complex amplitude of mode k = 1, 2, ... |
//! | M | `samples` | 1 | points of a series over one period |
//! | N | `length` | 1 | length of one transform, the smallest power of two >= modes |
//! | R = M/N | `shifts` | 1 | phase-shifted transforms of one series |
//!
//! rustfft's radix 4, never chosen by CPU, runs on [`Lanes`], our own number type. Its twiddles come from the
//! platform's cos and sin, so [`Lanes::from_f64`] moves each to the nearest entry of an exactly computed table.
//! Tested against direct sums and plain rustfft in `tests/physics/fourier.rs`.

use crate::numerics::elementary;
use crate::numerics::lanes::{Level, dispatch_at};
use crate::numerics::paired::{N, Paired, RealSeries};
use num_complex::Complex;
use num_traits::{FromPrimitive, Num, One, Signed, Zero};
use rustfft::algorithm::Radix4;
use rustfft::{Fft, FftDirection};
use std::ops::{Add, Div, Mul, Neg, Rem, Sub};
use std::sync::OnceLock;

/// Fields side by side in one [`Lanes`].
pub const WIDTH: usize = 8;

/// Longest transform whose twiddles the table holds.
pub const LONGEST: usize = 32_768;

/// Eight numbers that go through the same arithmetic: one for each of eight fields.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes(pub [f64; WIDTH]);

impl Lanes {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self.0;
        for i in 0..WIDTH {
            out[i] = f(out[i], other.0[i]);
        }
        Self(out)
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl Rem for Lanes {
    type Output = Self;
    fn rem(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b * (a / b).trunc())
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Zero for Lanes {
    #[inline(always)]
    fn zero() -> Self {
        Self([0.0; WIDTH])
    }
    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl One for Lanes {
    #[inline(always)]
    fn one() -> Self {
        Self([1.0; WIDTH])
    }
}

impl Num for Lanes {
    type FromStrRadixErr = std::num::ParseFloatError;
    fn from_str_radix(text: &str, _radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        text.parse().map(|x| Self([x; WIDTH]))
    }
}

impl Signed for Lanes {
    fn abs(&self) -> Self {
        self.map(f64::abs)
    }
    fn abs_sub(&self, other: &Self) -> Self {
        self.zip(*other, |a, b| if a > b { a - b } else { 0.0 })
    }
    fn signum(&self) -> Self {
        self.map(f64::signum)
    }
    fn is_positive(&self) -> bool {
        self.0.iter().all(|a| *a > 0.0)
    }
    fn is_negative(&self) -> bool {
        self.0.iter().all(|a| *a < 0.0)
    }
}

impl FromPrimitive for Lanes {
    fn from_i64(n: i64) -> Option<Self> {
        Some(Self([n as f64; WIDTH]))
    }
    fn from_u64(n: u64) -> Option<Self> {
        Some(Self([n as f64; WIDTH]))
    }
    /// A twiddle of rustfft, moved to the exact table.
    fn from_f64(x: f64) -> Option<Self> {
        Some(Self([snapped(x); WIDTH]))
    }
}

/// (cos, sin) of the angle 2 pi k/n, n a multiple of 8, by reduction to the first octant: exact at its symmetries.
pub fn turn(k: usize, n: usize) -> Complex<f64> {
    reflected(k, n, |m| in_first_octant(m, n))
}

/// [`turn`] for k = 0, 1, .. n - 1: one octant computed, the others reflected.
pub fn turns(n: usize) -> Vec<Complex<f64>> {
    let octant: Vec<_> = (0..=n / 8).map(|m| in_first_octant(m, n)).collect();
    (0..n).map(|k| reflected(k, n, |m| octant[m])).collect()
}

/// (cos, sin) of the angle 2 pi m/n, m = 0, 1, .. n/8.
fn in_first_octant(m: usize, n: usize) -> Complex<f64> {
    if m == n / 8 {
        return Complex::new(0.5_f64.sqrt(), 0.5_f64.sqrt());
    }
    let (sine, cosine) = elementary::sin_cos(std::f64::consts::TAU * m as f64 / n as f64);
    Complex::new(cosine, sine)
}

/// (cos, sin) of the angle 2 pi k/n, from those of the first octant.
fn reflected(k: usize, n: usize, octant: impl Fn(usize) -> Complex<f64>) -> Complex<f64> {
    let (k, eighth) = (k % n, n / 8);
    let within = k % eighth;
    // Odd octants run backwards, from the next multiple of an eighth turn.
    let odd = (k / eighth) % 2 == 1;
    let Complex { re: cosine, im: sine } = octant(if odd { eighth - within } else { within });
    match k / eighth {
        0 => Complex::new(cosine, sine),
        1 => Complex::new(sine, cosine),
        2 => Complex::new(-sine, cosine),
        3 => Complex::new(-cosine, sine),
        4 => Complex::new(-cosine, -sine),
        5 => Complex::new(-sine, -cosine),
        6 => Complex::new(sine, -cosine),
        _ => Complex::new(cosine, -sine),
    }
}

/// The nearest +-|cos(2 pi k/N)|, N = [`LONGEST`]; neighbours are 1.8e-8 apart or more, a twiddle's error is 1e-15.
fn snapped(x: f64) -> f64 {
    static TABLE: OnceLock<Vec<f64>> = OnceLock::new();
    // Ascending: cos from a quarter turn down to none.
    let table = TABLE.get_or_init(|| (0..=LONGEST / 4).rev().map(|k| turn(k, LONGEST).re).collect());
    let at = table.partition_point(|c| *c < x.abs());
    let below = table[at.saturating_sub(1)];
    let above = table[at.min(table.len() - 1)];
    let nearest = if x.abs() - below < above - x.abs() {
        below
    } else {
        above
    };
    assert!(
        (nearest - x.abs()).abs() < 1e-12,
        "a constant of the transform is no cosine of a power-of-two circle: {x}"
    );
    nearest.copysign(x)
}

/// One planned complex transform of power-of-two length, not normalised.
pub struct Transform {
    plan: Radix4<Lanes>,
}

impl Transform {
    /// Plans X_m = sum_j x_j e^(-2 pi i j m/n).
    pub fn forward(n: usize) -> Self {
        Self::planned(n, FftDirection::Forward)
    }

    /// Plans x_j = sum_m X_m e^(+2 pi i j m/n).
    pub fn inverse(n: usize) -> Self {
        Self::planned(n, FftDirection::Inverse)
    }

    fn planned(n: usize, direction: FftDirection) -> Self {
        assert!(
            n.is_power_of_two() && n <= LONGEST,
            "a transform's length is a power of two up to {LONGEST}, not {n}"
        );
        Self {
            plan: Radix4::new(n, direction),
        }
    }

    /// Transforms in place; `scratch` grows to what is needed and is best kept between calls.
    pub fn process(&self, buffer: &mut [Complex<Lanes>], scratch: &mut Vec<Complex<Lanes>>) {
        let needed = self.plan.get_inplace_scratch_len();
        if scratch.len() < needed {
            scratch.resize(needed, Complex::zero());
        }
        self.plan.process_with_scratch(buffer, scratch);
    }
}

/// From modes to a series, science (W5): z_j = sum_k c_k e^(2 pi i j k/M), pruned to R transforms of length N.
///
/// ```text
/// z_(r + R q) = sum_k (c_k e^(2 pi i k r/M)) e^(2 pi i k q/N),   r = 0..R-1,  q = 0..N-1
/// ```
/// Real series of N = 1024, the paper's, go two shifts to a transform: [`crate::numerics::paired`].
pub struct Synthesis {
    /// Instruction set; it cannot change a result.
    pub level: Level,
    paired: Option<Paired>,
    length: usize,
    shifts: usize,
    transform: Transform,
    turns: Vec<Complex<f64>>, // (samples) e^(2 pi i j/M)
    buffer: Vec<Complex<Lanes>>,
    scratch: Vec<Complex<Lanes>>,
}

impl Synthesis {
    /// Plans series of `samples` points, a power of two >= 8.
    ///
    /// # Panics
    /// If there are more modes than samples.
    pub fn new(modes: usize, samples: usize) -> Self {
        let length = modes.next_power_of_two();
        assert!(
            samples.is_power_of_two() && samples >= 8 && samples >= length,
            "a series of {modes} modes needs a power of two of at least that many samples, not {samples}"
        );
        Self {
            level: Level::current(),
            paired: (length == N && samples > N).then(|| Paired::new(samples)),
            length,
            shifts: samples / length,
            transform: Transform::inverse(length),
            turns: turns(samples),
            buffer: vec![Complex::zero(); length],
            scratch: Vec::new(),
        }
    }

    /// Points of a series.
    pub fn samples(&self) -> usize {
        self.turns.len()
    }

    /// Writes Re z_j; `spectrum[k - 1]` is c_k, `out` has [`Synthesis::samples`] entries.
    pub fn real_series(&mut self, spectrum: &[Complex<Lanes>], out: &mut [[f64; WIDTH]]) {
        assert!(spectrum.len() <= self.length, "no more modes than planned");
        assert_eq!(
            out.len(),
            self.samples(),
            "the series has the planned number of samples"
        );
        match &mut self.paired {
            Some(plan) => dispatch_at(self.level, RealSeries { plan, spectrum, out }),
            None => self.series(spectrum, out, |z| z.re.0),
        }
    }

    /// Writes |z_j|; `spectrum[k - 1]` is c_k, `out` has [`Synthesis::samples`] entries.
    pub fn modulus(&mut self, spectrum: &[Complex<Lanes>], out: &mut [[f64; WIDTH]]) {
        self.series(spectrum, out, |z| (z.re * z.re + z.im * z.im).map(f64::sqrt).0);
    }

    fn series(
        &mut self,
        spectrum: &[Complex<Lanes>],
        out: &mut [[f64; WIDTH]],
        part: impl Fn(Complex<Lanes>) -> [f64; WIDTH],
    ) {
        assert_eq!(
            out.len(),
            self.samples(),
            "the series has the planned number of samples"
        );
        for r in 0..self.shifts {
            self.load_turned(spectrum, r);
            self.transform.process(&mut self.buffer, &mut self.scratch);
            let every = out[r..].iter_mut().step_by(self.shifts);
            for (sample, z) in every.zip(&self.buffer) {
                *sample = part(*z);
            }
        }
    }

    /// Puts c_k e^(2 pi i k r/M) into bin k mod N.
    fn load_turned(&mut self, spectrum: &[Complex<Lanes>], r: usize) {
        assert!(spectrum.len() <= self.length, "no more modes than planned");
        self.buffer.fill(Complex::zero());
        for (i, c) in spectrum.iter().enumerate() {
            let k = i + 1;
            let turn = self.turns[(k * r) & (self.turns.len() - 1)];
            let turned = Complex {
                re: c.re.zip(c.im, |re, im| re * turn.re - im * turn.im),
                im: c.re.zip(c.im, |re, im| re * turn.im + im * turn.re),
            };
            self.buffer[k & (self.length - 1)] = turned;
        }
    }
}
