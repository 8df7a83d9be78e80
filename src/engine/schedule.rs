//! Schedule: the workers that empty the queue of pieces, each key made once among all threads and processes.
//!
//! A piece that another run is making is set aside for any other that is ready; only when none is left does a worker wait,
//! look up again and reuse. Which worker runs what never shows in a result. Tested in `tests/reliability/concurrency.rs`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::flight::Hold;
use crate::engine::plan::decide_all;
use crate::engine::queue::{Queue, Turn};
use crate::engine::run::{Decision, Run};
use crate::engine::runs;
use crate::engine::threads::{helper, pool};

/// How often the housekeeper looks around.
const ROUND: Duration = Duration::from_millis(50);

/// Runs everything that a run's graph wants and that is not cached.
///
/// # Errors
/// A store that cannot be written, a stage that is not reproducible, or the list of the nodes that failed.
pub fn execute(run: &Run<'_>, workers: usize) -> Result<()> {
    let nodes = run.graph.nodes.iter().enumerate();
    let nodes = nodes.map(|(node, it)| (it.name(), run.graph.wanted_pieces(node).count()));
    run.tell(&Event::DidPlan { nodes: nodes.collect() });
    if decide_all(run) {
        return reuse_all(run);
    }
    let queue = Queue::new(run.graph);
    std::thread::scope(|scope| {
        // The housekeeper first: the workers may take all threads that are left.
        helper(scope, || keep_house(run, &queue))?;
        let started = pool(workers).map(|pool| {
            pool.broadcast(|_| {
                while let Some((node, piece)) = queue.take(run) {
                    // A piece that is never finished would keep the other workers waiting.
                    let outcome = catch_unwind(AssertUnwindSafe(|| step(run, node, piece)));
                    let outcome = outcome.unwrap_or_else(|_| Err(panicked(run, node, piece)));
                    queue.finish(run.graph, node, piece, outcome);
                }
            })
        });
        queue.close();
        started
    })?;
    let flushed = run.store.flush();
    let verdict = queue.verdict(run.graph).and(flushed);
    match verdict {
        // What is done stays out of the reach of `gc`, whatever came of the rest.
        Ok(()) | Err(Error::Failures(_) | Error::Interrupted) => runs::remember(run).and(verdict),
        Err(_) => verdict,
    }
}

/// A run with nothing to do starts no thread.
fn reuse_all(run: &Run<'_>) -> Result<()> {
    for node in 0..run.graph.nodes.len() {
        for piece in run.graph.wanted_pieces(node) {
            reuse(run, node, piece);
        }
    }
    runs::remember(run)
}

/// While the workers work: publishes what has waited long enough, and ends the run when somebody asks for it.
fn keep_house(run: &Run<'_>, queue: &Queue) {
    while queue.is_open_after(ROUND) {
        let asked = run.is_stopped();
        let flushed = if asked {
            run.store.flush()
        } else {
            run.store.flush_due()
        };
        if let Err(error) = flushed {
            queue.fail(error);
        } else if asked {
            queue.fail(Error::Interrupted);
        }
    }
}

fn step(run: &Run<'_>, node: usize, piece: usize) -> Result<Turn> {
    let key = match run.decide(node, piece) {
        Decision::Cached => return Ok(reuse(run, node, piece)),
        Decision::WillRun(key) => key,
        Decision::MayRun => return Err(Error::stage("a piece was ready before its inputs")),
    };
    let lock = match run.store.hold(&key)? {
        Hold::Ours(lock) => lock,
        Hold::InThisProcess => return Ok(Turn::MadeHere),
        Hold::Elsewhere => return Ok(Turn::MadeElsewhere),
    };
    // Its last holder may have finished it since.
    if matches!(run.decide(node, piece), Decision::Cached) {
        return Ok(reuse(run, node, piece));
    }
    let made = catch_unwind(AssertUnwindSafe(|| run.make(node, piece, key, Some(lock))));
    let made = made.unwrap_or_else(|_| Err(panicked(run, node, piece)));
    if let Err(error) = &made {
        let node = run.graph.nodes[node].name();
        run.tell(&Event::DidFail {
            node,
            piece,
            message: error.to_string(),
        });
    }
    made.map(|()| Turn::Done)
}

fn panicked(run: &Run<'_>, node: usize, piece: usize) -> Error {
    Error::stage("it panicked").at(&run.graph.nodes[node].piece_name(piece))
}

fn reuse(run: &Run<'_>, node: usize, piece: usize) -> Turn {
    run.tell(&Event::DidReuse {
        node: run.graph.nodes[node].name(),
        piece,
    });
    Turn::Done
}
