//! Leftovers: published files that no run of these parameters makes any more, such as those of a ship that is no longer
//! run, or of an output that a stage has given up. `status` and `verify` name them, `gc --stale` removes them.
//!
//! Only a file whose bytes a run of this checkout put at that very path counts as ours and may be removed; one that was
//! edited since is named and kept. What nobody here has published is not looked at.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use crate::engine::error::{Error, Result};
use crate::engine::figures::{self, may_publish};
use crate::engine::pipeline::Pipeline;
use crate::engine::published::{Ours, PARAMETERS, Set, State};
use crate::engine::run::Run;

/// What may lie in a figures folder.
pub struct Due<'a> {
    pipeline: &'a Pipeline,
    /// The folders within it; the first is the folder itself.
    folders: Vec<String>,
    /// `(folder, stage)` -> the names that the stage publishes there, where that is known.
    exact: BTreeMap<(String, &'static str), BTreeSet<String>>,
}

impl<'a> Due<'a> {
    /// Everything that the stages of a pipeline may publish, with these values of the axis that has folders of its own.
    pub fn new(pipeline: &'a Pipeline, values: &[String]) -> Self {
        let further = values.iter().skip(1).cloned();
        Self {
            pipeline,
            folders: std::iter::once(String::new()).chain(further).collect(),
            exact: BTreeMap::new(),
        }
    }

    /// The same, exact about nodes whose outputs are known; a node that failed publishes nothing.
    #[must_use]
    pub fn exactly(
        mut self,
        run: &Run<'_>,
        layout: &[(usize, String)],
        texts: &BTreeMap<String, String>,
        is_known: impl Fn(usize) -> bool,
    ) -> Self {
        for (node, prefix) in layout.iter().filter(|(node, _)| is_known(*node)) {
            let stage = run.graph.nodes[*node].node.name();
            let names = texts.keys().filter_map(|path| path.strip_prefix(prefix.as_str()));
            let names = names.filter(|name| !name.contains('/') && self.stage_of(name) == Some(stage));
            let names = names.map(str::to_owned).collect();
            let folder = prefix.trim_end_matches('/').to_owned();
            self.exact.insert((folder, stage), names);
        }
        self
    }

    /// The published stage that a name belongs to: that of the same name before one whose name begins it.
    fn stage_of(&self, name: &str) -> Option<&'static str> {
        let stages = self.pipeline.contents.iter().filter(|node| node.is_published());
        let own = stages.map(|node| node.name()).filter(|stage| may_publish(stage, name));
        own.max_by_key(|stage| stage.len())
    }

    /// Whether a run of these parameters may make a file of this path.
    pub(crate) fn is_due(&self, path: &str) -> bool {
        let Some((folder, name)) = figures::parts(path) else {
            return false;
        };
        let Some(stage) = self
            .stage_of(name)
            .filter(|_| self.folders.iter().any(|own| own == folder))
        else {
            return false;
        };
        let exact = self.exact.get(&(folder.to_owned(), stage));
        exact.is_none_or(|names| names.contains(name))
    }
}

/// The files of earlier runs in a folder that no run of these parameters makes: outdated ones, and ones edited since.
pub fn leftovers(ours: &Ours, due: &Due<'_>, set: &Set<'_>) -> Vec<(String, State)> {
    let paths = ours.there(set).into_iter();
    let old = paths.filter(|path| path != PARAMETERS && !due.is_due(path));
    let state = |path: &str| {
        if ours.made(set, path) {
            State::Outdated
        } else {
            State::Edited
        }
    };
    old.map(|path| (path.clone(), state(&path))).collect()
}

/// Removes the leftovers of a folder and the folders that become empty; gives those that were removed, and those that
/// somebody has edited, which stay.
///
/// # Errors
/// A link in place of a folder, or a file that cannot be removed.
pub fn remove_leftovers(due: &Due<'_>, set: &Set<'_>, is_dry: bool) -> Result<(Vec<String>, Vec<String>)> {
    set.check_links()?;
    let _turn = figures::turn(set.folder);
    let (mut removed, mut kept) = (Vec::new(), Vec::new());
    for (path, state) in leftovers(&Ours::of(set), due, set) {
        if state == State::Edited {
            kept.push(path);
            continue;
        }
        if !is_dry {
            let place = set.folder.join(&path);
            fs::remove_file(&place).map_err(Error::io("remove", &place))?;
            if let Some((folder, _)) = path.rsplit_once('/') {
                // It fails while anything is left in the folder.
                let _ = fs::remove_dir(set.folder.join(folder));
            }
        }
        removed.push(path);
    }
    Ok((removed, kept))
}
