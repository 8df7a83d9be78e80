//! Event: what happened, as data. The command line turns events into words, tests read them as they are.

use std::path::PathBuf;

/// One thing that happened during a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A run begins: the nodes in order, each with its number of pieces.
    DidPlan {
        /// (`STAGE/CASE`, pieces).
        nodes: Vec<(String, usize)>,
    },
    /// A piece begins to run.
    WillRun {
        /// The node.
        node: String,
        /// The piece's number.
        piece: usize,
    },
    /// A piece was made and stored.
    DidRun {
        /// The node.
        node: String,
        /// The piece's number.
        piece: usize,
        /// What it took, seconds.
        seconds: f64,
        /// The length of the output.
        bytes: u64,
    },
    /// A piece was found in the store.
    DidReuse {
        /// The node.
        node: String,
        /// The piece's number.
        piece: usize,
    },
    /// A piece is being made by another run, and nothing else is left to do: the run waits for it.
    DidWait {
        /// The node.
        node: String,
        /// The piece's number.
        piece: usize,
    },
    /// A damaged or missing object was made again, equal to its recorded id.
    DidHeal {
        /// The node.
        node: String,
        /// The piece's number.
        piece: usize,
        /// What was wrong.
        why: String,
    },
    /// A record of the store named what no stage has made: it was set aside, and the walk begins anew.
    DidDistrust {
        /// The node and piece.
        node: String,
        /// How what it named differs from an output of its stage.
        why: String,
    },
    /// A piece failed.
    DidFail {
        /// The node.
        node: String,
        /// The piece's number.
        piece: usize,
        /// What went wrong.
        message: String,
    },
    /// A published file that somebody had edited was moved aside, to be restored.
    DidSetAside {
        /// The path within the figures folder.
        path: String,
        /// Where the edited file is now.
        kept: PathBuf,
    },
    /// A published file of an earlier run was found that this run did not make.
    DidFindOld {
        /// The path within the figures folder.
        path: String,
        /// What became of it.
        fate: Fate,
    },
    /// A published file was looked at.
    DidPublish {
        /// The path within the figures folder.
        path: String,
        /// The BLAKE3 of the text.
        id: String,
        /// Whether the file had to be written.
        written: bool,
    },
}

/// What became of a published file of an earlier run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It was of other parameters, and was removed.
    Removed,
    /// It is as an earlier run wrote it, and is kept.
    Kept,
    /// It was edited since, and is kept.
    KeptEdited,
}
