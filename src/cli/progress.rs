//! Progress: events to a bar per stage with a time estimate on a terminal, to plain lines elsewhere.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::engine::event::{Event, Fate};
use crate::text::count::counted;
use crate::text::escape::terminal;

/// Listens to a run and speaks on standard error.
pub struct Progress {
    bars: Option<MultiProgress>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Stage -> pieces not yet done, its bar once a piece has run.
    stages: BTreeMap<String, (usize, usize, Option<ProgressBar>)>,
    /// Node -> pieces not yet done, pieces that ran, their seconds.
    nodes: BTreeMap<String, (usize, usize, f64)>,
}

/// Writes a line to standard error; a reader that has gone is no error.
pub(super) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", terminal(line));
}

fn stage_of(node: &str) -> &str {
    node.split('/').next().unwrap_or(node)
}

impl Progress {
    /// Bars if standard error is a terminal, lines otherwise.
    pub fn new() -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bars = terminal.then(|| MultiProgress::with_draw_target(ProgressDrawTarget::stderr_with_hz(8)));
        Self {
            bars,
            state: Mutex::default(),
        }
    }

    /// Takes note of an event.
    pub fn hear(&self, event: &Event) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Event::DidPlan { nodes } => {
                // A walk that begins anew meets every piece again.
                *state = State::default();
                for (node, pieces) in nodes {
                    state.nodes.insert(node.clone(), (*pieces, 0, 0.0));
                    let stage = state.stages.entry(stage_of(node).to_owned()).or_default();
                    stage.0 += pieces;
                    stage.1 += pieces;
                }
            }
            Event::WillRun { node, .. } => self.show_bar(&mut state, node),
            Event::DidRun { node, seconds, .. } => self.did(&mut state, node, Some(*seconds)),
            Event::DidReuse { node, .. } => self.did(&mut state, node, None),
            Event::DidHeal { node, piece, why } => self.say(&format!("{node}/{piece}: {why}; making it again")),
            Event::DidDistrust { node, why } => {
                self.say(&format!(
                    "{node}: the store held an output that breaks the rules of its stage ({why}); moved to quarantine/ with its \
                     record, making the plan again"
                ));
            }
            Event::DidFail { message, .. } => self.say(message),
            Event::DidWait { node, piece } => {
                self.say(&format!("{node}/{piece}: another run is making it; waiting"));
            }
            Event::DidSetAside { path, kept } => {
                self.say(&format!(
                    "{path}: edited by hand; moved to {}, ours restored",
                    kept.display()
                ));
            }
            Event::DidFindOld { path, fate } => self.say(&match fate {
                Fate::Removed => format!("{path}: removed, an earlier run made it with other parameters"),
                Fate::Kept => format!("{path}: of an earlier run, this one did not make it"),
                Fate::KeptEdited => {
                    format!("{path}: of an earlier run and edited by hand since, this run did not make it")
                }
            }),
            Event::DidPublish { .. } => {}
        }
    }

    /// Takes the bars away.
    pub fn finish(&self) {
        if let Some(bars) = &self.bars {
            // Nothing can be done about a terminal that has gone.
            let _ = bars.clear();
        }
    }

    fn say(&self, text: &str) {
        match &self.bars {
            Some(bars) => {
                let _ = bars.println(text);
            }
            None => tell(text),
        }
    }

    fn show_bar(&self, state: &mut MutexGuard<'_, State>, node: &str) {
        let Some(bars) = &self.bars else { return };
        let Some((left, all, bar)) = state.stages.get_mut(stage_of(node)) else {
            return;
        };
        if bar.is_some() {
            return;
        }
        let style = ProgressStyle::with_template("{prefix:<24} {wide_bar} {pos:>5}/{len} {elapsed:>4} eta {eta:>4}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let new = bars.add(
            ProgressBar::new(*all as u64)
                .with_style(style)
                .with_prefix(stage_of(node).to_owned()),
        );
        new.set_position((*all - *left) as u64);
        new.reset_eta();
        *bar = Some(new);
    }

    fn did(&self, state: &mut MutexGuard<'_, State>, node: &str, seconds: Option<f64>) {
        if let Some((left, _, bar)) = state.stages.get_mut(stage_of(node)) {
            *left = left.saturating_sub(1);
            if let Some(bar) = bar {
                bar.inc(1);
                if *left == 0 {
                    bar.finish_and_clear();
                }
            }
        }
        let Some((left, ran, total)) = state.nodes.get_mut(node) else {
            return;
        };
        *left = left.saturating_sub(1);
        *ran += usize::from(seconds.is_some());
        *total += seconds.unwrap_or(0.0);
        if *left == 0 && *ran > 0 && self.bars.is_none() {
            tell(&format!("{node}: ran {} in {total:.2} s", counted(*ran, "piece")));
        }
    }
}

impl Default for Progress {
    fn default() -> Self {
        Self::new()
    }
}
