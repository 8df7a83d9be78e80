//! The classical fourth-order Runge-Kutta step of theta'' = f(theta, theta', forcing), side by side in lanes.
//!
//! | paper | code | shape | meaning |
//! |---|---|---|---|
//! | theta, theta' | theta, theta_dot | `(L)` | state of L independent oscillators |
//! | eta | forcing | `(3)` of any kind | forcing at t, t + h/2, t + h |
//!
//! The paper says "4th-order Runge-Kutta" and no more; the step is fixed (Decision 3). Structure of arrays, so that each
//! line is one vector operation. Tested in `tests/physics/rk4.rs`: observed order 4, an exact solution, a scalar twin.

/// x + by rate, in every lane.
#[inline(always)]
fn moved<const L: usize>(x: [f64; L], by: f64, rate: [f64; L]) -> [f64; L] {
    let mut result = [0.0; L];
    for i in 0..L {
        result[i] = x[i] + by * rate[i];
    }
    result
}

/// x + by (k_1 + 2 (k_2 + k_3) + k_4), in every lane.
#[inline(always)]
fn advanced<const L: usize>(x: [f64; L], by: f64, k: [[f64; L]; 4]) -> [f64; L] {
    let mut result = [0.0; L];
    for i in 0..L {
        result[i] = x[i] + by * (k[0][i] + 2.0 * (k[1][i] + k[2][i]) + k[3][i]);
    }
    result
}

/// One step of length h: the state (theta, theta_dot) at t + h.
///
/// `acceleration(theta, theta_dot, forcing)` is the right-hand side; it must be inlined to be compiled per level.
#[inline(always)]
pub fn step<const L: usize, F: Copy>(
    acceleration: impl Fn([f64; L], [f64; L], F) -> [f64; L],
    h: f64,
    theta: [f64; L],
    theta_dot: [f64; L],
    forcing: [F; 3],
) -> ([f64; L], [f64; L]) {
    let [now, middle, next] = forcing;
    let half = 0.5 * h;
    let k_1 = acceleration(theta, theta_dot, now);
    let v_2 = moved(theta_dot, half, k_1);
    let k_2 = acceleration(moved(theta, half, theta_dot), v_2, middle);
    let v_3 = moved(theta_dot, half, k_2);
    let k_3 = acceleration(moved(theta, half, v_2), v_3, middle);
    let v_4 = moved(theta_dot, h, k_3);
    let k_4 = acceleration(moved(theta, h, v_3), v_4, next);
    (
        advanced(theta, h / 6.0, [theta_dot, v_2, v_3, v_4]),
        advanced(theta_dot, h / 6.0, [k_1, k_2, k_3, k_4]),
    )
}
