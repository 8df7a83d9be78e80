//! The only door to transcendental functions: the same bits on every CPU, libc and build profile.
//!
//! Scalar functions come from pxfm (pure Rust, correctly rounded wherever it was sampled). The lane versions are our own
//! polynomials (Cody-Waite reduction, Horner, no FMA) for inner loops; they differ from the scalar ones in the last bit.
//! Tested against pxfm and against identities in `tests/physics/elementary.rs`.

/// sin x, x in radians.
pub fn sin(x: f64) -> f64 {
    pxfm::f_sin(x)
}

/// cos x, x in radians.
pub fn cos(x: f64) -> f64 {
    pxfm::f_cos(x)
}

/// (sin x, cos x), x in radians.
pub fn sin_cos(x: f64) -> (f64, f64) {
    pxfm::f_sincos(x)
}

/// e^x.
pub fn exp(x: f64) -> f64 {
    pxfm::f_exp(x)
}

/// The natural logarithm.
pub fn ln(x: f64) -> f64 {
    pxfm::f_log(x)
}

/// The decimal logarithm.
pub fn log10(x: f64) -> f64 {
    pxfm::f_log10(x)
}

/// x to the power y.
pub fn pow(x: f64, y: f64) -> f64 {
    pxfm::f_pow(x, y)
}

/// The error function.
pub fn erf(x: f64) -> f64 {
    pxfm::f_erf(x)
}

/// The complementary error function.
pub fn erfc(x: f64) -> f64 {
    pxfm::f_erfc(x)
}

/// Adding and subtracting this rounds |x| < 2^51 to the nearest integer and leaves that integer in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Evaluates a polynomial by Horner's rule, highest coefficient first, in every lane.
#[inline(always)]
fn horner<const L: usize>(x: [f64; L], coefficients: &[f64]) -> [f64; L] {
    let mut sum = [coefficients[0]; L];
    for c in &coefficients[1..] {
        for i in 0..L {
            sum[i] = sum[i] * x[i] + c;
        }
    }
    sum
}

/// e^x in every lane; 0 below -708 and e^709 above 709. Error at most 1 unit in the last place.
#[inline(always)]
pub fn exp_lanes<const L: usize>(x: [f64; L]) -> [f64; L] {
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    let mut r = [0.0; L];
    let mut scale = [0.0; L];
    for i in 0..L {
        let clamped = if x[i] < -708.0 { -708.0 } else { x[i] };
        let clamped = if clamped > 709.0 { 709.0 } else { clamped };
        let rounded = clamped * std::f64::consts::LOG2_E + ROUND;
        let k = rounded - ROUND;
        r[i] = (clamped - k * LN2_HIGH) - k * LN2_LOW;
        scale[i] = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
    }
    // 1/13! .. 1/2!: the Taylor remainder is below 1e-17 for |r| <= ln 2 / 2.
    let p = horner(
        r,
        &[
            1.605_904_383_682_161_5e-10,
            2.087_675_698_786_81e-9,
            2.505_210_838_544_172e-8,
            2.755_731_922_398_589_1e-7,
            2.755_731_922_398_589_1e-6,
            2.480_158_730_158_73e-5,
            1.984_126_984_126_984e-4,
            1.388_888_888_888_889e-3,
            8.333_333_333_333_333e-3,
            4.166_666_666_666_666_6e-2,
            1.666_666_666_666_666_7e-1,
            0.5,
        ],
    );
    let mut result = [0.0; L];
    for i in 0..L {
        let value = ((p[i] * r[i]) * r[i] + r[i] + 1.0) * scale[i];
        result[i] = if x[i] < -708.0 { 0.0 } else { value };
    }
    result
}

/// (sin x, cos x) in every lane, |x| < 1e6 rad. Error at most 2.3e-16 absolute for |x| < 50.
#[inline(always)]
pub fn sin_cos_lanes<const L: usize>(x: [f64; L]) -> ([f64; L], [f64; L]) {
    // Pi/2 in three pieces; the first two have trailing zeros, so that products with small integers are exact.
    const HALF_PI_1: f64 = 1.570_796_326_734_125_6;
    const HALF_PI_2: f64 = 6.077_100_506_303_966e-11;
    const HALF_PI_3: f64 = 2.022_266_248_795_950_6e-21;
    let mut r = [0.0; L];
    let mut square = [0.0; L];
    let mut quadrant = [0_u64; L];
    for i in 0..L {
        let rounded = x[i] * std::f64::consts::FRAC_2_PI + ROUND;
        let k = rounded - ROUND;
        r[i] = ((x[i] - k * HALF_PI_1) - k * HALF_PI_2) - k * HALF_PI_3;
        square[i] = r[i] * r[i];
        quadrant[i] = rounded.to_bits();
    }
    let s = horner(
        square,
        &[
            1.589_690_995_211_55e-10,
            -2.505_076_025_340_686_3e-8,
            2.755_731_370_707_006_8e-6,
            -1.984_126_982_985_795e-4,
            8.333_333_333_322_49e-3,
            -1.666_666_666_666_663_2e-1,
        ],
    );
    let c = horner(
        square,
        &[
            -1.135_964_755_778_819_5e-11,
            2.087_572_321_298_175e-9,
            -2.755_731_435_139_066_3e-7,
            2.480_158_728_947_673e-5,
            -1.388_888_888_887_411e-3,
            4.166_666_666_666_66e-2,
        ],
    );
    let mut sin = [0.0; L];
    let mut cos = [0.0; L];
    for i in 0..L {
        let sine = r[i] + r[i] * square[i] * s[i];
        let cosine = 1.0 - (0.5 * square[i] - square[i] * square[i] * c[i]);
        let odd = quadrant[i] & 1 == 1;
        let (a, b) = if odd { (cosine, sine) } else { (sine, cosine) };
        sin[i] = f64::from_bits(a.to_bits() ^ ((quadrant[i] & 2) << 62));
        cos[i] = f64::from_bits(b.to_bits() ^ ((quadrant[i].wrapping_add(1) & 2) << 62));
    }
    (sin, cos)
}
