//! Step (6) of detection: of two groups that overlap one stays.
//!
//! Tested on lists made by hand in `tests/physics/detection.rs`.

use super::Detection;
use super::fit::Candidate;

/// Removes overlaps along the period of n samples; candidates in any order, the rest sorted by x.
pub fn without_overlaps(mut groups: Vec<Candidate>, n: f64, d: &Detection) -> Vec<Candidate> {
    groups.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.l.total_cmp(&q.l)));
    // A survivor is not compared with what lies before it: hence the second pass.
    for _ in 0..2 {
        groups = pass(&groups, n, d);
    }
    groups
}

/// One pass: each group against the survivor before it, then the last against the first, round the period.
fn pass(groups: &[Candidate], n: f64, d: &Detection) -> Vec<Candidate> {
    let mut kept: Vec<Candidate> = Vec::with_capacity(groups.len());
    for group in groups {
        match kept.last_mut() {
            Some(last) if overlap(last, group, 0.0, d) => {
                if second_stays(last, group, d) {
                    *last = *group;
                }
            }
            _ => kept.push(*group),
        }
    }
    if let [first, .., last] = kept[..]
        && overlap(&last, &first, n, d)
    {
        if second_stays(&last, &first, d) {
            kept.pop();
        } else {
            kept.remove(0);
        }
    }
    kept
}

/// Whether p and q, moved on by `shift` samples, are closer than the factor times the greater length.
fn overlap(p: &Candidate, q: &Candidate, shift: f64, d: &Detection) -> bool {
    let longer = if p.l > q.l { p.l } else { q.l };
    (p.x - (q.x + shift)).abs() < d.overlap_factor * longer
}

/// The more similar stays if the margin is exceeded, else the longer, else the second.
fn second_stays(p: &Candidate, q: &Candidate, d: &Detection) -> bool {
    if (p.similarity - q.similarity).abs() > d.overlap_similarity_margin {
        q.similarity > p.similarity
    } else {
        q.l >= p.l
    }
}
