//! `encounter gc --stale`: removes the published files that no run of these parameters makes any more.

use serde_json::json;

use crate::cli::session::Common;
use crate::cli::{print_json, say};
use crate::engine::error::Result;
use crate::engine::leftover::remove_leftovers;
use crate::text::count::counted;

/// Removes them, or only says which they are.
///
/// # Errors
/// A parameter that cannot be used, a link in place of the figures folder, a file that cannot be removed.
pub(super) fn remove(common: &Common, is_dry: bool) -> Result<()> {
    let session = common.open(&[])?;
    let (removed, kept) = remove_leftovers(&session.due(), &session.set(), is_dry)?;
    let folder = session.figures.display();
    if common.json {
        print_json(&json!({
            "format": 1, "dry_run": is_dry, "folder": folder.to_string(), "removed": removed, "kept": kept,
        }));
        return Ok(());
    }
    let word = if is_dry { "would remove" } else { "removed" };
    for path in &removed {
        say(format_args!("{word}  {path}"));
    }
    for path in &kept {
        say(format_args!("kept  {path}, which was edited by hand"));
    }
    say(format_args!(
        "{word} {} in {folder}, kept {}",
        counted(removed.len(), "stale file"),
        kept.len()
    ));
    Ok(())
}
