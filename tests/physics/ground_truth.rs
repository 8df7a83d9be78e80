//! Sea and ship together: the tables of the printed ship without parametric excitation, measured by two prototypes.

use std::sync::OnceLock;

use crate::physics::exceedance::of_fields;
use crate::physics::roll_twin::{printed as with_all_epsilon_1, truth};
use crate::physics::seas::{detection, fields, gaussian, record};
use encounter::numerics::fourier::WIDTH;
use encounter::sea::detection::detect;
use encounter::sea::envelope::Envelopes;
use encounter::sea::wave_field::{Record, WaveFields};
use encounter::sea::wave_group::Groups;
use encounter::ship::continuous_roll::{Timing, continuous_record};
use encounter::ship::encounter::{Approach, Encounter, max_roll_along_record, max_roll_through_groups};
use encounter::ship::roll_equation::Ship;
use encounter::ship::sample::Selection;
use encounter::ship::simulation::Simulation;

const FIELDS: u64 = 240;
const T_P: f64 = 15.0;

/// A sea's fields and groups.
struct Scene {
    waves: WaveFields,
    groups: Groups,
}

/// S1 and S2, made once for all tests.
fn scenes() -> &'static [Scene; 2] {
    static SCENES: OnceLock<[Scene; 2]> = OnceLock::new();
    SCENES.get_or_init(|| {
        [0.02, 0.03].map(|bandwidth| {
            let waves = fields(&gaussian(bandwidth), &record(), 1000, FIELDS);
            let groups = detect(&Envelopes::of(&waves, &record()), &detection());
            Scene { waves, groups }
        })
    })
}

fn printed() -> Ship {
    Ship {
        epsilon_1: vec![0.0],
        ..with_all_epsilon_1()
    }
}

fn elevation(scene: &Scene, record: &Record, block: usize) -> Vec<[f64; WIDTH]> {
    let mut eta = vec![[0.0; WIDTH]; record.samples()];
    scene.waves.elevation(block * WIDTH, &mut record.synthesis(), &mut eta);
    eta
}

fn encounters(scene: &Scene) -> Vec<Vec<Encounter>> {
    Selection::new(scene.groups.parameters(), &[]).groups
}

/// Responses of the continuous record, by field.
fn true_responses(scene: &Scene, record: &Record) -> Vec<Vec<f64>> {
    let reach = 2.0 * 80.0 * T_P / 8.0;
    let timing = Timing::new(record.field_period(T_P), record.samples() as u32, record.lead_in, reach);
    let (ship, truth) = (printed(), truth());
    let simulation = Simulation::new(&ship, &truth, timing.h);
    let mut r = Vec::new();
    for (block, groups) in encounters(scene).chunks(WIDTH).enumerate() {
        let eta = elevation(scene, record, block);
        let rolled = continuous_record(&simulation, &timing, &eta, groups);
        r.extend(rolled.responses[0].iter().map(|field| field.r.clone()));
    }
    r
}

fn probability(r: &[Vec<f64>], theta_t: f64) -> (f64, f64) {
    let counted = of_fields(&[theta_t], r.iter().map(Vec::as_slice));
    let known = counted.probability(0).zip(counted.standard_error(0));
    known.expect("there are groups")
}

/// |ours - theirs| < 4 combined standard errors.
fn agrees(what: &str, (p, se): (f64, f64), theirs: f64, their_se: f64) {
    let allowed = 4.0 * (se * se + their_se * their_se).sqrt();
    assert!(
        (p - theirs).abs() < allowed,
        "{what}: {p} +- {se}, expected {theirs} +- {their_se}"
    );
}

#[test]
fn the_truth_of_the_printed_ship_is_that_of_the_prototype() {
    let table: [&[(f64, f64, f64)]; 2] = [
        &[
            (0.3, 0.7865, 0.0035),
            (0.4, 0.4209, 0.0035),
            (0.5, 0.0933, 0.0020),
            (0.6, 0.0067, 0.0006),
        ],
        &[
            (0.3, 0.939, 0.0018),
            (0.4, 0.783, 0.0031),
            (0.5, 0.511, 0.0033),
            (0.6, 0.2148, 0.0026),
            (0.7, 0.0489, 0.0015),
            (0.8, 0.0058, 0.0006),
        ],
    ];
    for (scene, rows) in scenes().iter().zip(table) {
        let r = true_responses(scene, &record());
        for (theta_t, p, se) in rows {
            agrees(&format!("P(r > {theta_t})"), probability(&r, *theta_t), *p, *se);
        }
    }
}

#[test]
fn the_methods_of_the_printed_ship_are_those_of_the_prototype() {
    // Per sea: threshold, its standard error in the prototype, then NIC record, NIC groups, CIC.
    let table = [
        [
            (0.5, 0.0028, 0.1055, 0.270, 0.136),
            (0.6, 0.0009, 0.0053, 0.047, 0.0043),
        ],
        [
            (0.7, 0.0021, 0.0501, 0.121, 0.0094),
            (0.8, 0.0008, 0.0062, 0.036, 0.0002),
        ],
    ];
    let record = record();
    let approach = Approach {
        h: record.h(T_P),
        field_period: record.field_period(T_P),
        truth_window: 2.0,
        estimate_window: 3.0,
        groups_ahead: 2,
    };
    let (ship, truth) = (printed(), truth());
    let simulation = Simulation::new(&ship, &truth, approach.h);
    for (scene, rows) in scenes().iter().zip(table) {
        let (mut nic, mut nic_groups, mut cic) = (Vec::new(), Vec::new(), Vec::new());
        for (block, fields) in encounters(scene).chunks(WIDTH).enumerate() {
            let eta = elevation(scene, &record, block);
            for (column, groups) in fields.iter().enumerate() {
                let all = 0..groups.len();
                let along: Vec<_> = all
                    .clone()
                    .map(|i| approach.through_record(column as u32, groups, i))
                    .collect();
                let through: Vec<_> = all.map(|i| approach.through_groups(groups, i)).collect();
                let alone: Vec<_> = groups.iter().map(|group| approach.alone(*group)).collect();
                nic.extend(max_roll_along_record(&simulation, &eta, &along));
                nic_groups.extend(max_roll_through_groups(&simulation, T_P, &through, &[]));
                cic.extend(max_roll_through_groups(&simulation, T_P, &alone, &[]));
            }
        }
        for (theta_t, se, of_nic, of_groups, of_cic) in rows {
            // The prototype gives the truth's standard error alone; a larger probability has a larger one.
            let scaled = |p: f64| se * (p / of_nic).sqrt().max(1.0);
            agrees(&format!("NIC record {theta_t}"), probability(&nic, theta_t), of_nic, se);
            agrees(
                &format!("NIC groups {theta_t}"),
                probability(&nic_groups, theta_t),
                of_groups,
                scaled(of_groups),
            );
            agrees(
                &format!("CIC {theta_t}"),
                probability(&cic, theta_t),
                of_cic,
                scaled(of_cic),
            );
        }
    }
}

#[test]
fn half_the_step_changes_no_probability_by_its_standard_error() {
    let fine = Record {
        samples_per_period: 256,
        ..record()
    };
    for (scene, levels) in scenes().iter().zip([[0.3, 0.4, 0.5, 0.6], [0.5, 0.6, 0.7, 0.8]]) {
        let (coarse, fine) = (true_responses(scene, &record()), true_responses(scene, &fine));
        for theta_t in levels {
            let ((p, se), (q, _)) = (probability(&coarse, theta_t), probability(&fine, theta_t));
            assert!(
                (p - q).abs() < se,
                "P(r > {theta_t}): {p} at h, {q} at h/2, standard error {se}"
            );
        }
    }
}
