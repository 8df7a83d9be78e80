//! tmp
use encounter::numerics::lanes::Level;
use encounter::ship::continuous_roll::{Timing, continuous_record, continuous_states};
use encounter::ship::encounter::{Approach, Encounter, max_roll_along_record, max_roll_through_groups};
use encounter::ship::exceedance::Thresholds;
use encounter::ship::response::{Capsize, Roll, Truth};
use encounter::ship::roll_equation::{Damping, Ship};
use encounter::ship::simulation::Simulation;
use std::time::Instant;

#[test]
fn speed() {
    let ship = Ship { alpha_1: 0.01, alpha_2: 0.4, damping: Damping::Cubic, beta_1: 0.13, beta_2: -0.06,
        epsilon_1: vec![0.0, 0.002, 0.004], epsilon_2: 0.0043 };
    let truth = Truth { window: 2.0, roll: Roll::Absolute, capsize_angle: std::f64::consts::PI, capsize: Capsize::Restart,
        temporal_level: 0.25, thresholds: Thresholds { from: 0.0, to: 1.2, step: 0.025 } };
    let timing = Timing::new(3840.0, 32768, 500.0, 300.0);
    let eta: Vec<[f64; 8]> = (0..32768).map(|j| {
        let mut row = [0.0; 8];
        for (c, x) in row.iter_mut().enumerate() {
            for k in 0..40 {
                let n = 232 + k;
                let ph = (c * 97 + k * k * 31) as f64;
                *x += 0.67 * ((n * j % 32768) as f64 * std::f64::consts::TAU / 32768.0 + ph).cos();
            }
        }
        row
    }).collect();
    let groups: Vec<Vec<Encounter>> = (0..8).map(|c| (0..28).map(|i| Encounter { t_c: 3840.0 * (i as f64 + c as f64 / 8.0) / 28.0, l: 20.0 + (i % 5) as f64 * 10.0, a: 5.0 }).collect()).collect();
    let approach = Approach { h: timing.h, field_period: 3840.0, truth_window: 2.0, estimate_window: 3.0, groups_ahead: 2 };
    for level in std::env::var("LV").map_or(vec![Level::Base, Level::Avx2, Level::Avx512], |_| vec![Level::Avx512]) {
        let sim = Simulation { level, ..Simulation::new(&ship, &truth, timing.h) };
        let mut best = f64::MAX; let mut best_s = f64::MAX;
        for _ in 0..60 {
            let t = Instant::now();
            let r = continuous_record(&sim, &timing, &eta, &groups);
            best = best.min(t.elapsed().as_secs_f64());
            std::hint::black_box(r);
            let t = Instant::now();
            let r = continuous_states(&sim, &timing, &eta, 8, 8);
            best_s = best_s.min(t.elapsed().as_secs_f64());
            std::hint::black_box(r);
        }
        let steps = (timing.lead_in + timing.steps + timing.tail) as f64 * 24.0;
        println!("{level:?} continuous {:.3} ns/lane-step  states {:.3}", best * 1e9 / steps, best_s * 1e9 / ((timing.lead_in + timing.steps) as f64 * 24.0));
        let mut rec = Vec::new(); let mut grp = Vec::new(); let mut cic = Vec::new();
        for c in 0..8 { for i in 0..28 { rec.push(approach.through_record(c as u32, &groups[c], i)); grp.push(approach.through_groups(&groups[c], i)); cic.push(approach.alone(groups[c][i])); } }
        let mut b = [f64::MAX; 3];
        for _ in 0..10 {
            let t = Instant::now(); std::hint::black_box(max_roll_along_record(&sim, &eta, &rec)); b[0] = b[0].min(t.elapsed().as_secs_f64());
            let t = Instant::now(); std::hint::black_box(max_roll_through_groups(&sim, 15.0, &grp, &[])); b[1] = b[1].min(t.elapsed().as_secs_f64());
            let t = Instant::now(); std::hint::black_box(max_roll_through_groups(&sim, 15.0, &cic, &[])); b[2] = b[2].min(t.elapsed().as_secs_f64());
        }
        let n: i64 = rec.iter().map(|r| r.segment.last).sum();
        let nc: i64 = cic.iter().map(|r| r.segment.last).sum();
        println!("   nic record {:.3} groups {:.3} cic {:.3}  (mean steps {} {})", b[0]*1e9/(3*n) as f64, b[1]*1e9/(3*n) as f64, b[2]*1e9/(3*nc) as f64, n / 224, nc/224);
    }
}
