//! One field of 256 T_p, from its phases to its groups: how many in a second on one core?

use crate::detection_twin;
use crate::seas::{detection, fields, four_seas, record};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use encounter::sea::detection::detect;
use encounter::sea::envelope::Envelopes;
use encounter::sea::wave_field::WaveFields;

/// Fields of one run of the stage.
const FIELDS: u64 = 32;

fn sea(index: usize, count: u64) -> WaveFields {
    fields(&four_seas()[index], &record(), 0, count)
}

/// Envelope and groups, in the lanes of eight fields; items are fields.
#[divan::bench(args = [0, 1, 2, 3], sample_count = 20)]
fn of_sea(bencher: Bencher, index: usize) {
    let fields = sea(index, FIELDS);
    bencher
        .counter(ItemsCount::new(FIELDS))
        .bench_local(|| detect(&Envelopes::of(black_box(&fields), &record()), &detection()));
}

/// The direct sums on the full grid, one fit after another.
#[divan::bench(sample_count = 3)]
fn of_the_direct_twin(bencher: Bencher) {
    let envelopes = Envelopes::of(&sea(1, 1), &record());
    bencher
        .counter(ItemsCount::new(1_u64))
        .bench_local(|| detection_twin::groups(black_box(&envelopes.rho[0]), envelopes.spacing, &detection()));
}
