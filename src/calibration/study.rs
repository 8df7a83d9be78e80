//! One search and one check of the calibration study.
//!
//! The search sees the first `search_fields` of each sea, least squares the first `polish_fields`, the check all others:
//! what is printed of a candidate comes from fields by which it was not chosen. Tested in `tests/physics/calibration.rs`.

use crate::calibration::bench::{Bench, Sea, Tally};
use crate::calibration::candidate::{Candidate, TABLE};
use crate::calibration::choice::{Checked, Chosen, Found, InSea, Trial};
use crate::calibration::evolution::{Effort, minimise};
use crate::calibration::methods::{Layout, interpolated_cic, methods, whole_blocks};
use crate::calibration::misfit::{misfit, ranking, residuals};
use crate::calibration::polish::least_squares;
use crate::calibration::settings::{Search, Settings, Target};
use crate::calibration::spread::spread;
use crate::ship::encounter::Encounter;
use rand_chacha::ChaCha12Rng;
use std::ops::Range;

/// Cap of the responses in (C3), rad: beyond every threshold of Table 1.
const CAP: f64 = 1.25;

/// Everything that searches and checks share.
pub struct Study<'a> {
    /// Fields, groups, the printed ship.
    pub bench: Bench<'a>,
    /// `[calibration]`.
    pub settings: &'a Settings,
    /// How single encounters are laid out.
    pub layout: Layout<'a>,
}

/// Which fields of the study are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Those on which candidates are searched.
    Search,
    /// Those that no search has seen.
    Check,
}

/// Whether some fields of a sea hold groups.
fn has_groups(sea: &Sea, fields: &Range<usize>) -> bool {
    let all = sea.pieces.iter().flat_map(|piece| &piece.groups[0].fields);
    let mut some = all.skip(fields.start).take(fields.len());
    some.any(|groups| !groups.is_empty())
}

impl Study<'_> {
    fn targets(&self) -> Vec<&Target> {
        self.bench.seas.iter().map(|sea| &sea.target).collect()
    }

    /// Fields of the sea that has fewest.
    fn fields(&self) -> usize {
        let of = |sea: &Sea| sea.pieces.iter().map(|piece| piece.waves.phase.len()).sum::<usize>();
        self.bench.seas.iter().map(of).min().unwrap_or(0)
    }

    /// Checks that the waves of a search, or of a check, hold groups in every sea: without any there is nothing to agree with.
    ///
    /// # Errors
    /// The first sea without groups.
    pub fn expect_groups(&self, of: Part) -> Result<(), String> {
        let polished = whole_blocks(self.settings.polish_fields);
        let fields = match of {
            Part::Search => 0..whole_blocks(self.settings.search_fields),
            Part::Check => polished..self.fields(),
        };
        if self.bench.seas.is_empty() {
            return Err("table1.paper: expected a row for a sea of this run, found none".to_owned());
        }
        let without = self.bench.seas.iter().find(|sea| !has_groups(sea, &fields));
        without.map_or(Ok(()), |sea| {
            let (from, to, name) = (fields.start, fields.end, &sea.target.sea);
            Err(format!(
                "calibration.fields: expected wave groups in the fields {from} to below {to} of sea {name}, found none; raise it or \
                 lower detection.smallest_amplitude"
            ))
        })
    }

    /// The search with these coefficients free.
    pub fn search(&self, search: Search, stream: &mut ChaCha12Rng) -> Found {
        let per_change = |count: u32| count as usize * search.free.len();
        let effort = Effort {
            population: per_change(self.settings.population),
            generations: per_change(self.settings.generations),
            hopeless: self.settings.hopeless,
        };
        let bounds = self.settings.log_bounds(&search.free, self.bench.printed);
        let (mut evaluations, mut accepted) = (0, Vec::new());
        let members = minimise(&bounds, effort, stream, |points| {
            evaluations += points.len() as u64;
            let trials = self.trials(&candidates(&search, points));
            // A candidate all of whose fields were discarded has met nothing that it could agree with.
            let agrees = |it: &&(Trial, bool)| it.1 && it.0.misfit < self.settings.accepted;
            accepted.extend(trials.iter().filter(agrees).map(|(trial, _)| trial.clone()));
            trials.iter().map(|(trial, _)| trial.cost).collect()
        });
        let (best, _) = self.trials(&candidates(&search, &[members[0].x.clone()])).remove(0);
        Found {
            search,
            best,
            accepted,
            evaluations,
        }
    }

    /// How candidates do on the fields of the search, and whether every sea has groups in their statistics.
    fn trials(&self, candidates: &[Candidate]) -> Vec<(Trial, bool)> {
        let fields = 0..whole_blocks(self.settings.search_fields);
        let tallies = self.bench.tallies(&fields, candidates);
        let of = |(candidate, tallies): (&Candidate, &Vec<Tally>)| {
            let cic = interpolated_cic(&self.bench, &fields, candidate, &self.layout, TABLE);
            let misfit = misfit(tallies, &self.targets(), self.settings.relative_error);
            let ranking = ranking(tallies, &cic);
            let size = self.settings.size_weight * candidate.size();
            let trial = Trial {
                candidate: *candidate,
                misfit,
                ranking,
                cost: misfit + self.settings.ranking_weight * ranking + size,
            };
            (trial, tallies.iter().all(|tally| tally.groups(TABLE) > 0.0))
        };
        candidates.iter().zip(&tallies).map(of).collect()
    }

    /// Polishes and rounds a candidate if it is to be, and says how it does on all other fields.
    pub fn check(&self, chosen: &Chosen, stream: &mut ChaCha12Rng) -> Checked {
        let polished = whole_blocks(self.settings.polish_fields);
        let candidate = if chosen.polish {
            let found = self.polished(&chosen.candidate, &(0..polished));
            found.rounded(self.bench.printed, self.settings.digits as usize)
        } else {
            chosen.candidate
        };
        let others = polished..self.fields();
        let (mut tallies, mut seas) = (Vec::new(), Vec::new());
        for sea in &self.bench.seas {
            let (tally, spread) = self.rolled(sea, &others, &candidate);
            let some = polished..others.end.min(polished + whole_blocks(self.settings.method_fields));
            seas.push(InSea {
                target: sea.target.clone(),
                p_true: measured(&tally),
                standard_error: tally.standard_error(TABLE),
                methods: methods(&self.bench, (sea, &some), &candidate, &self.layout, stream),
                capsizes_per_field: tally.capsizes as f64 / if tally.fields > 0 { tally.fields as f64 } else { 1.0 },
                spread,
            });
            tallies.push(tally);
        }
        Checked {
            name: chosen.name.clone(),
            candidate,
            values: candidate.signed_values(self.bench.printed),
            misfit: misfit(&tallies, &self.targets(), self.settings.relative_error),
            fields: others.len() as u64,
            seas,
        }
    }

    /// Tally and spread of one candidate in one sea.
    fn rolled(&self, sea: &Sea, fields: &Range<usize>, candidate: &Candidate) -> (Tally, Option<f64>) {
        let mut tally = Tally::none(self.bench.printed.epsilon_1.len());
        let mut points = Vec::new();
        let t_p = sea.t_p();
        let (theta_t, h_s) = (sea.target.theta_t, sea.h_s());
        self.bench.roll(sea, fields, &[*candidate], |_, groups, responses| {
            tally.add(theta_t, groups, responses);
            for (groups, response) in groups.iter().zip(&responses[TABLE]) {
                let of = |(group, r): (&Encounter, &f64)| [group.l / t_p, group.a / h_s, *r];
                points.extend(groups.iter().zip(&response.r).map(of));
            }
        });
        (tally, spread(&points, theta_t, CAP))
    }

    /// Least squares on (C1) in the changed coefficients, which stay within their bounds.
    fn polished(&self, candidate: &Candidate, fields: &Range<usize>) -> Candidate {
        let free: Vec<u32> = (0..6).filter(|i| candidate.x[*i as usize] != 0.0).collect();
        let search = Search {
            free,
            reading: candidate.reading,
        };
        let start: Vec<f64> = search.free.iter().map(|i| candidate.x[*i as usize]).collect();
        let bounds = self.settings.log_bounds(&search.free, self.bench.printed);
        let x = least_squares(&start, &bounds, self.settings.polish_rounds, |points| {
            let tallies = self.bench.tallies(fields, &candidates(&search, points));
            let of = |tallies: &Vec<Tally>| residuals(tallies, &self.targets(), self.settings.relative_error);
            tallies.iter().map(of).collect()
        });
        candidates(&search, &[x]).remove(0)
    }
}

/// P_true per epsilon_1; nothing if no group is in the statistics.
fn measured(tally: &Tally) -> Vec<f64> {
    let epsilons = if tally.groups(TABLE) > 0.0 {
        tally.counts.len()
    } else {
        0
    };
    (0..epsilons).map(|e| tally.probability(e)).collect()
}

/// The candidates of a search at some points.
fn candidates(search: &Search, points: &[Vec<f64>]) -> Vec<Candidate> {
    let of = |point: &Vec<f64>| {
        let mut x = [0.0; 6];
        for (i, value) in search.free.iter().zip(point) {
            x[*i as usize] = *value;
        }
        Candidate {
            x,
            reading: search.reading,
        }
    };
    points.iter().map(of).collect()
}
