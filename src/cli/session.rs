//! Session: the options of every verb, and what they come to: parameters, graph, store, checkout, figures and lock.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::cli::{progress, target};
use crate::engine::checkout::{Checkout, check_name, derived_name};
use crate::engine::claim;
use crate::engine::error::{Error, Result};
use crate::engine::graph::Graph;
use crate::engine::leftover::Due;
use crate::engine::names::Folder;
use crate::engine::node::Node;
use crate::engine::params::ParamsFile;
use crate::engine::published::Set;
use crate::engine::store::Store;
use crate::engine::target::Target;
use crate::stages::PIPELINE;
use crate::stages::axes::SHIP;

/// Options of every verb.
#[derive(Debug, Args)]
pub(super) struct Common {
    /// The scale: the paper's own, a minute's, or seconds'
    #[arg(long, value_enum, default_value = "paper")]
    pub(super) profile: Profile,
    /// A parameter file laid over the profile; may be repeated
    #[arg(long, value_name = "FILE")]
    pub(super) overlay: Vec<PathBuf>,
    /// One parameter, such as sea.S2.bandwidth=0.035; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
    /// The folder of cached outputs [default: artifacts]
    #[arg(long, value_name = "DIR")]
    pub(super) store: Option<PathBuf>,
    /// The folder of figures [default: figures for the paper profile, artifacts/figures/PROFILE for another, for a
    /// what-if (--overlay, --set) artifacts/figures/NAME, or whatif-HASH of what differs]
    #[arg(long, value_name = "DIR")]
    pub(super) figures: Option<PathBuf>,
    /// The name of a what-if, whose figures lie in artifacts/figures/NAME with their parameters: at most 64 letters,
    /// digits, `_` and `-`
    #[arg(long, value_name = "NAME")]
    pub(super) name: Option<String>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Profile {
    Paper,
    Quick,
    Tiny,
}

/// The profiles, which have folders and locks of their names.
const PROFILES: [&str; 3] = ["paper", "quick", "tiny"];

impl Profile {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Quick => "quick",
            Self::Tiny => "tiny",
        }
    }
}

/// What a verb works on.
pub(super) struct Session {
    pub(super) graph: Graph,
    pub(super) ships: Vec<String>,
    pub(super) store: PathBuf,
    pub(super) checkout: Checkout,
    pub(super) figures: PathBuf,
    /// The profile whose own folder that is.
    home: Option<&'static str>,
    /// The text of `parameters.toml`; none beside the committed figures.
    parameters: Option<String>,
    /// Whether the folder may hold the figures of other parameters, which a run replaces.
    may_replace: bool,
}

impl Common {
    /// The folder that holds `stages/paper.toml`: this one or the nearest above it.
    pub(super) fn root() -> Result<PathBuf> {
        let mut folder = PathBuf::new();
        for _ in 0..16 {
            if folder.join("stages/paper.toml").is_file() {
                return Ok(folder);
            }
            folder.push("..");
        }
        Err(Error::Usage(
            "stages/paper.toml: expected in this folder or one above it, found in none; run encounter in its repository"
                .to_owned(),
        ))
    }

    pub(super) fn checkout() -> Result<Checkout> {
        Ok(Checkout::at(&Self::root()?))
    }

    /// The files of a profile, the paper's first.
    fn profile_files(&self) -> Result<Vec<PathBuf>> {
        let stages = Self::root()?.join("stages");
        let mut files = vec![stages.join("paper.toml")];
        if self.profile != Profile::Paper {
            files.push(stages.join(format!("{}.toml", self.profile.name())));
        }
        Ok(files)
    }

    pub(super) fn params(&self) -> Result<ParamsFile> {
        let mut files = self.profile_files()?;
        files.extend(self.overlay.iter().cloned());
        read(&files, &self.set)
    }

    pub(super) fn store_folder(&self) -> Result<PathBuf> {
        self.store.clone().map_or_else(|| Ok(Self::checkout()?.artifacts()), Ok)
    }

    /// The folder of a profile's own figures, or that of a what-if.
    pub(super) fn figures_folder(&self, params: &ParamsFile) -> Result<PathBuf> {
        if let Some(folder) = &self.figures {
            return refuse_store(folder).map(|()| folder.clone());
        }
        let checkout = Self::checkout()?;
        Ok(match (&self.name, self.is_custom(), self.profile) {
            (Some(name), ..) => checkout.figures(name),
            (None, true, _) => {
                let base = read(&self.profile_files()?, &[])?;
                checkout.figures(&derived_name(params, &base, self.profile.name()))
            }
            (None, false, Profile::Paper) => checkout.root().join("figures"),
            (None, false, other) => checkout.figures(other.name()),
        })
    }

    /// The lock of a run of everything, or of the one output named that only runs on request.
    pub(super) fn lock_file(&self, targets: &[String]) -> Result<PathBuf> {
        let profile = self.profile.name();
        let name = match on_request(targets) {
            Some(own) if self.profile == Profile::Paper => own.to_owned(),
            Some(own) => format!("{profile}.{own}"),
            None => profile.to_owned(),
        };
        Ok(Self::checkout()?.lock_file(&name))
    }

    /// Whether parameters differ from those of the profile, so that nothing committed may be touched.
    pub(super) fn is_custom(&self) -> bool {
        !self.overlay.is_empty() || !self.set.is_empty()
    }

    pub(super) fn open(&self, targets: &[String]) -> Result<Session> {
        self.open_targets(&targets.iter().map(|text| target(text)).collect::<Result<Vec<_>>>()?)
    }

    /// The same for whole nodes, whatever pieces the targets name.
    pub(super) fn open_nodes(&self, targets: &[String]) -> Result<Session> {
        let whole = |text: &String| target(text).map(|target| Target { piece: None, ..target });
        self.open_targets(&targets.iter().map(whole).collect::<Result<Vec<_>>>()?)
    }

    fn open_targets(&self, targets: &[Target]) -> Result<Session> {
        self.check_name()?;
        let params = self.params()?;
        let graph = Graph::new(&PIPELINE, &params, targets)?;
        let is_own = self.figures.is_none() && !self.is_custom();
        let is_paper = self.profile == Profile::Paper && !self.is_custom();
        Ok(Session {
            graph,
            ships: params.list(SHIP)?,
            store: self.store_folder()?,
            checkout: Self::checkout()?,
            figures: self.figures_folder(&params)?,
            home: is_own.then_some(self.profile.name()),
            parameters: (!is_paper).then(|| self.parameters_text(&params)),
            may_replace: self.name.is_none(),
        })
    }

    fn check_name(&self) -> Result<()> {
        let Some(name) = &self.name else { return Ok(()) };
        check_name(name, &PROFILES).map_err(|why| Error::Usage(format!("--name: {why}")))?;
        if self.is_custom() {
            return Ok(());
        }
        let profile = self.profile.name();
        Err(Error::Usage(format!(
            "--name {name}: expected --overlay or --set with it, found the parameters of the profile {profile}, which has a \
             folder of its own"
        )))
    }

    /// The parameters in force as a file that can be used as an overlay of the same profile.
    fn parameters_text(&self, params: &ParamsFile) -> String {
        let profile = self.profile.name();
        let name = self
            .name
            .as_ref()
            .map_or(String::new(), |name| format!(", name {name}"));
        format!(
            "# All parameters that the figures beside this file were made with: profile {profile}{name}.\n\
             # `encounter run --profile {profile} --overlay FILE` with this file makes them again.\n\n{}",
            params.text()
        )
    }
}

/// Refuses a figures folder that is a store or one of a store's own folders: only content belongs there.
fn refuse_store(folder: &Path) -> Result<()> {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let mut below: Option<&std::ffi::OsStr> = None;
    for above in whole.ancestors() {
        let is_own = below.is_none_or(|name| Folder::ALL.iter().any(|own| name == own.name()));
        if is_own && claim::is_marked(above) {
            return Err(Error::Usage(format!(
                "--figures {}: expected a folder of its own, found the store {}; name another folder",
                folder.display(),
                above.display()
            )));
        }
        below = above.file_name();
    }
    Ok(())
}

fn read(files: &[PathBuf], sets: &[String]) -> Result<ParamsFile> {
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    ParamsFile::read(&files, sets)
}

/// The one target, if it is published and only on request: it has a lock of its own.
pub(super) fn on_request(targets: &[String]) -> Option<&str> {
    let [own] = targets else { return None };
    let is_it = |node: &&dyn Node| node.name() == own && node.is_published();
    let is_published = PIPELINE.contents.iter().any(is_it);
    (is_published && PIPELINE.on_request.contains(&own.as_str())).then_some(own.as_str())
}

impl Session {
    /// The figures folder and whose set it holds.
    pub(super) fn set(&self) -> Set<'_> {
        Set {
            checkout: &self.checkout,
            folder: &self.figures,
            home: self.home,
            parameters: self.parameters.as_deref(),
            may_replace: self.may_replace,
        }
    }

    /// Lets the figures of these parameters take the place of others under the same name.
    pub(super) fn replace(&mut self) {
        self.may_replace = true;
    }

    /// What may lie in the figures folder.
    pub(super) fn due(&self) -> Due<'static> {
        Due::new(&PIPELINE, &self.ships)
    }

    pub(super) fn open_store(&self) -> Result<Store> {
        Store::open_on(Store::disk(&self.store)?, &wait_for_gc).map(told_of_locks)
    }

    /// The store, which need not be there, for reading.
    pub(super) fn look_at_store(&self) -> Result<Store> {
        claim::check(&self.store)?;
        let store = Store::look_on(Store::look_at(&self.store)?, &wait_for_gc);
        Ok(told_of_locks(store))
    }

    /// Says what the grids and steps resolve poorly.
    pub(super) fn warn(&self) {
        for warning in &self.graph.warnings {
            progress::tell(&format!("warning: {warning}"));
        }
    }
}

/// Says so where the file system has no locks.
fn told_of_locks(store: Store) -> Store {
    if store.is_without_locks() {
        let folder = store.root().display();
        progress::tell(&format!(
            "{folder} has no file locks: runs at once may do the same work twice, nothing else"
        ));
    }
    store
}

fn wait_for_gc() {
    progress::tell(
        "another `encounter` removes old outputs from this store; this one goes on when it has ended, Ctrl-C gives up",
    );
}
