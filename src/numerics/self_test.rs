//! A millisecond of fixed arithmetic, done before anything is computed: this build on this CPU gives the bits of the locks.
//!
//! Neither the compiler nor the CPU is part of a key, because they have been measured to make no difference
//! (`make verify-cpus`). A compiler, a crate built otherwise, or a CPU that does make one is caught here, by name, before
//! it computes an hour of other numbers. Each part is folded into one word; a change of algorithm changes its constant.

use num_complex::Complex;

use crate::numerics::cholesky::{Factor, solve};
use crate::numerics::elementary::{cos, erf, erfc, exp, exp_lanes, ln, log10, pow, sin, sin_cos, sin_cos_lanes};
use crate::numerics::fourier::{Lanes, Synthesis, WIDTH};
use crate::numerics::lanes::{Kernel, Level, dispatch_at};
use crate::numerics::normal;
use crate::numerics::rk4;
use crate::numerics::square::Square;
use crate::numerics::sums::sum;

/// A part of the mathematics: its name, what it computes at a level, and the word its bits fold into.
type Part = (&'static str, fn(Level) -> u64, u64);

/// The parts, least dependent first: the first that differs is the one to look at.
const PARTS: [Part; 7] = [
    ("the elementary functions (pxfm)", elementary, 0x72a5_ecb0_e5c3_4bd7),
    ("the lane functions", lane_functions, 0x4daa_5025_1643_d6a6),
    ("sums and normal quantiles", quantiles, 0x25a8_a9a4_e767_1d24),
    ("the Fourier transform (rustfft)", fourier, 0x4c29_0621_460e_7e70),
    ("the transform of 1,024 modes", synthesis, 0x59cd_e63b_64fc_59c3),
    ("the Runge-Kutta step", runge_kutta, 0x92ea_85c3_62c4_f528),
    ("the Cholesky factor", cholesky, 0x6d96_6564_730d_ad82),
];

/// Computes every part at one level.
///
/// # Errors
/// The first part whose bits are others than those of the committed locks.
pub fn check(level: Level) -> Result<(), String> {
    PARTS
        .into_iter()
        .try_for_each(|(name, compute, expected)| compare(name, expected, compute(level), level))
}

/// Compares the word of a part with the expected one.
///
/// # Errors
/// They differ: the sentence for the reader.
pub fn compare(name: &str, expected: u64, found: u64, level: Level) -> Result<(), String> {
    if found == expected {
        return Ok(());
    }
    let level = level.name();
    Err(format!(
        "self-test: {name}: expected the bits {expected:016x}, found {found:016x}; this build on this CPU ({level}) \
         computes other numbers than the committed locks hold"
    ))
}

/// Points in (0, 1), spread but exact: k φ mod 1 in steps of 2⁻³².
fn points<const N: usize>() -> [f64; N] {
    let mut points = [0.0; N];
    for (k, point) in points.iter_mut().enumerate() {
        let word = (k as u32 + 1).wrapping_mul(2_654_435_769);
        *point = (f64::from(word) + 0.5) / 4_294_967_296.0;
    }
    points
}

/// FNV-1a over the bits of the numbers.
fn fold(numbers: impl IntoIterator<Item = f64>) -> u64 {
    let bytes = numbers.into_iter().flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |word, byte| {
        (word ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

fn elementary(_: Level) -> u64 {
    fold(points::<64>().into_iter().flat_map(|x| {
        let (s, c) = sin_cos(31.0 * x);
        let wide = 40.0 * x - 20.0;
        [
            sin(wide),
            cos(wide),
            s,
            c,
            exp(wide),
            ln(x),
            log10(x),
            pow(x, wide),
            erf(4.0 * x),
            erfc(4.0 * x),
        ]
    }))
}

struct LaneFunctions;

impl Kernel for LaneFunctions {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let x = points::<64>();
        let (s, c) = sin_cos_lanes(x.map(|x| 80.0 * x - 40.0));
        let e = exp_lanes(x.map(|x| 60.0 * x - 50.0));
        fold([s, c, e].into_iter().flatten())
    }
}

fn lane_functions(level: Level) -> u64 {
    dispatch_at(level, LaneFunctions)
}

fn quantiles(_: Level) -> u64 {
    let x = points::<100>();
    let quantiles = x.map(normal::quantile);
    fold(quantiles.into_iter().chain([sum(&x), sum(&quantiles)]))
}

fn fourier(level: Level) -> u64 {
    series(32, 128, level)
}

fn synthesis(level: Level) -> u64 {
    series(1024, 2048, level)
}

/// A real series of so many modes.
fn series(modes: usize, samples: usize, level: Level) -> u64 {
    let x = points::<64>();
    let lanes = |k: usize| Lanes(std::array::from_fn(|i| x[(k + 7 * i) % 64] - 0.5));
    let spectrum: Vec<Complex<Lanes>> = (0..modes)
        .map(|k| Complex {
            re: lanes(k),
            im: lanes(k + 32),
        })
        .collect();
    let mut series = vec![[0.0; WIDTH]; samples];
    let mut synthesis = Synthesis::new(modes, samples);
    synthesis.level = level;
    synthesis.real_series(&spectrum, &mut series);
    fold(series.into_iter().flatten())
}

struct RungeKutta;

impl Kernel for RungeKutta {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let forcing = points::<24>();
        let (mut theta, mut theta_dot) = ([0.0; 24], forcing);
        for _ in 0..32 {
            let acceleration = |theta: [f64; 24], theta_dot: [f64; 24], forcing: [f64; 24]| {
                let mut rate = [0.0; 24];
                for i in 0..24 {
                    let cubed = theta[i] * theta[i] * theta[i];
                    rate[i] = forcing[i] - 0.3 * theta_dot[i] - (1.0 + 0.2 * forcing[i]) * theta[i] - 0.1 * cubed;
                }
                rate
            };
            (theta, theta_dot) = rk4::step(acceleration, 0.125, theta, theta_dot, [forcing; 3]);
        }
        fold(theta.into_iter().chain(theta_dot))
    }
}

fn runge_kutta(level: Level) -> u64 {
    dispatch_at(level, RungeKutta)
}

fn cholesky(level: Level) -> u64 {
    let x = points::<24>();
    let mut matrix = Square::from_fn(24, |i, j| {
        let apart = x[i] - x[j];
        1.0 / (1.0 + 9.0 * apart * apart) + if i == j { 0.1 } else { 0.0 }
    });
    if !dispatch_at(level, Factor { a: &mut matrix }) {
        return 0;
    }
    let mut solved = x;
    solve(&matrix, &mut solved);
    fold(solved.into_iter().chain((0..24).map(|i| matrix.at(23, i))))
}
