//! The truth of eight fields: the Runge-Kutta step, the elevation, and both with everything that is counted.
//!
//! Beside them [`crate::table`] prints what C takes: the step, and nearly the whole (`truth.c` says what it leaves out).
//! The items of a second are lane-steps, samples, and lane-steps again: ns of one is 1000 / (Mitem/s).

use crate::roll_twin::{Trajectory, acceleration, printed, truth};
use crate::seas::{detection, fields, four_seas, record};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use encounter::numerics::fourier::WIDTH;
use encounter::numerics::lanes::{Kernel, Level, dispatch_at};
use encounter::numerics::rk4;
use encounter::numerics::rows::Rows;
use encounter::sea::detection::detect;
use encounter::sea::envelope::Envelopes;
use encounter::sea::wave_field::WaveFields;
use encounter::ship::continuous_roll::{Timing, continuous_record};
use encounter::ship::roll_equation::RollEquation;
use encounter::ship::sample::Selection;
use encounter::ship::simulation::Simulation;
use num_complex::Complex;
use rustfft::{FftDirection, FftPlannerScalar};

const LEVELS: [&str; 3] = ["base", "avx2", "avx512"];
const LANES: usize = 24;
const STEPS: usize = 16_384;

fn level(name: &str) -> Option<Level> {
    Level::choose(Some(name)).ok()
}

fn eight_fields() -> WaveFields {
    fields(&four_seas()[0], &record(), 0, WIDTH as u64)
}

fn elevation() -> Rows {
    let mut eta = Rows::new(record().samples());
    eight_fields().elevation(0, &mut record().synthesis(), &mut eta);
    eta
}

struct Roll<'a>(&'a [[f64; WIDTH]]);

impl Kernel for Roll<'_> {
    type Output = [f64; LANES];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let ship = printed();
        let epsilon_1 = std::array::from_fn(|lane| ship.epsilon_1[lane / WIDTH]);
        let equation = black_box(RollEquation::<LANES, true>::new(&ship, epsilon_1));
        let (mut theta, mut theta_dot) = ([0.0; LANES], [0.0; LANES]);
        let forcing = |row: &[f64; WIDTH]| equation.forcing(std::array::from_fn(|lane| row[lane % WIDTH]));
        let mut now = forcing(&self.0[0]);
        for [middle, next] in self.0[1..].as_chunks().0 {
            let (middle, next) = (forcing(middle), forcing(next));
            let rate = |x, v, eta| equation.acceleration(x, v, eta);
            (theta, theta_dot) = rk4::step(rate, 15.0 / 64.0, theta, theta_dot, [now, middle, next]);
            now = next;
        }
        theta
    }
}

/// The bare step in 24 lanes, on low waves.
#[divan::bench(args = LEVELS, sample_count = 50)]
fn rk4_of_24_lanes(bencher: Bencher, name: &str) {
    let Some(level) = level(name) else { return };
    let eta = vec![[0.5; WIDTH]; 2 * STEPS + 1];
    bencher
        .counter(ItemsCount::new(LANES * STEPS))
        .bench_local(|| dispatch_at(level, Roll(black_box(&eta))));
}

/// The bare step of one ship.
#[divan::bench(sample_count = 20)]
fn rk4_of_one_ship(bencher: Bencher) {
    let (ship, eta) = (printed(), vec![0.5; 2 * STEPS + 1]);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let rate = |x: [f64; 1], v: [f64; 1], eta: [f64; 1]| [acceleration(&ship, 0.02, x[0], v[0], eta[0])];
        let (mut theta, mut theta_dot) = ([0.0], [0.0]);
        for eta in black_box(&eta).windows(3).step_by(2) {
            let forcing = [[eta[0]], [eta[1]], [eta[2]]];
            (theta, theta_dot) = rk4::step(rate, 15.0 / 64.0, theta, theta_dot, forcing);
        }
        theta
    });
}

/// The elevation of eight fields, from their phases.
#[divan::bench(args = LEVELS, sample_count = 50)]
fn eta_of_eight_fields(bencher: Bencher, name: &str) {
    let Some(level) = level(name) else { return };
    let (fields, mut synthesis) = (eight_fields(), record().synthesis());
    synthesis.level = level;
    let mut eta = Rows::new(record().samples());
    bencher
        .counter(ItemsCount::new(WIDTH * record().samples()))
        .bench_local(|| black_box(&fields).elevation(0, &mut synthesis, &mut eta));
}

/// One field by rustfft as it comes, a transform as long as the series.
#[divan::bench(sample_count = 20)]
#[expect(clippy::disallowed_methods, reason = "a yardstick")]
fn eta_by_rustfft(bencher: Bencher) {
    let (fields, samples) = (eight_fields(), record().samples());
    let spectrum = fields.spectrum(0);
    let plan = FftPlannerScalar::<f64>::new().plan_fft(samples, FftDirection::Inverse);
    let mut scratch = vec![Complex::ZERO; plan.get_inplace_scratch_len()];
    let mut series = vec![Complex::ZERO; samples];
    bencher.counter(ItemsCount::new(samples)).bench_local(|| {
        series.fill(Complex::ZERO);
        for (k, c) in black_box(&spectrum).iter().enumerate() {
            series[k + 1] = Complex::new(c.re.0[0], c.im.0[0]);
        }
        plan.process_with_scratch(&mut series, &mut scratch);
    });
}

fn timing() -> Timing {
    let record = record();
    Timing::new(
        record.field_period(15.0),
        record.samples() as u32,
        record.lead_in,
        300.0,
    )
}

/// Elevation, roll, capsizes, maxima of eight fields for three epsilon_1.
#[divan::bench(args = LEVELS, sample_count = 20)]
fn truth_of_eight_fields(bencher: Bencher, name: &str) {
    let Some(level) = level(name) else { return };
    let (ship, truth, timing, fields) = (printed(), truth(), timing(), eight_fields());
    let groups = detect(&Envelopes::of(&fields, &record()), &detection());
    let encounters = Selection::new(groups.parameters(), &[]).groups;
    let simulation = Simulation {
        level,
        ..Simulation::new(&ship, &truth, timing.h)
    };
    let mut synthesis = record().synthesis();
    synthesis.level = level;
    let mut eta = Rows::new(record().samples());
    // Steps past the field, to the end of its last group, come on top: of a few percent.
    let steps = (timing.lead_in + timing.steps) as usize;
    bencher.counter(ItemsCount::new(LANES * steps)).bench_local(|| {
        black_box(&fields).elevation(0, &mut synthesis, &mut eta);
        continuous_record(&simulation, &timing, &eta, &encounters)
    });
}

/// One field and one epsilon_1, the trajectory kept, the elevation given.
#[divan::bench(sample_count = 5)]
fn truth_of_the_twin(bencher: Bencher) {
    let (ship, truth, timing, eta) = (printed(), truth(), timing(), elevation());
    let wave = |j: i64| eta[j.rem_euclid(eta.len() as i64) as usize][0];
    let (start, end) = (-timing.lead_in, timing.steps + timing.tail);
    bencher
        .counter(ItemsCount::new((end - start) as usize))
        .bench_local(|| {
            let whole = Trajectory::run((&ship, 0.02, &truth, timing.h), start, end, (0.0, 0.0), wave);
            whole.largest(start, end)
        });
}
