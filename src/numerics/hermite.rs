//! The cubic Hermite interpolant of one step, and the extremum it takes where the slope changes sign inside.
//!
//! With u = (t - t_0)/h in [0, 1] the interpolant through (x_0, v_0) and (x_1, v_1) has the derivative
//! `a u^2 + b u + c`, a = 3 h (v_0 + v_1) - 6 d, b = 6 d - 4 h v_0 - 2 h v_1, c = h v_0, d = x_1 - x_0: its root is exact.
//! Tested in `tests/physics/hermite.rs` against a dense search.

/// The interpolant's value at its inner extremum where v_0 and v_1 have opposite signs, x_0 in the other lanes.
///
/// h in s, x in any unit, v in that unit per s. The extremum is taken inside the step, whatever rounding says.
#[inline(always)]
pub fn extremum<const L: usize>(h: f64, x: [[f64; L]; 2], v: [[f64; L]; 2]) -> [f64; L] {
    let mut value = [0.0; L];
    for i in 0..L {
        let (p, q) = (h * v[0][i], h * v[1][i]);
        let d = x[1][i] - x[0][i];
        let a = 3.0 * (p + q) - 6.0 * d;
        let b = 6.0 * d - 4.0 * p - 2.0 * q;
        let discriminant = b * b - 4.0 * a * p;
        let discriminant = if discriminant > 0.0 { discriminant } else { 0.0 };
        // Of the two roots the one where the slope leaves the sign of v_0, in the form that does not cancel.
        let u = 2.0 * p.abs() / (discriminant.sqrt() - b * 1.0_f64.copysign(p));
        let u = if u > 0.0 { u } else { 0.0 };
        let u = if u < 1.0 { u } else { 1.0 };
        let there = x[0][i] + u * (p + u * ((3.0 * d - 2.0 * p - q) + u * (p + q - 2.0 * d)));
        let turns = (v[0][i] > 0.0 && v[1][i] < 0.0) || (v[0][i] < 0.0 && v[1][i] > 0.0);
        value[i] = if turns { there } else { x[0][i] };
    }
    value
}
