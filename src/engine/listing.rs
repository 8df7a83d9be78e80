//! Listing: what lies in a folder of the store, each file as the place that its name says, or as somebody else's.

use std::io::ErrorKind;
use std::time::SystemTime;

use crate::engine::disk::{Entry, Kind};
use crate::engine::error::{Error, Result};
use crate::engine::names::{At, Folder, Place};
use crate::engine::store::Store;

/// Something that was found in a folder of the store.
#[derive(Clone, Debug)]
pub(crate) struct Listed {
    /// Which file of the store it is; none for what is not ours, or is no regular file.
    pub(crate) place: Option<Place>,
    /// Its path below the store, for messages.
    pub(crate) path: String,
    pub(crate) bytes: u64,
    pub(crate) modified: SystemTime,
}

/// All that lies in a folder, sorted by path; nothing if there is no such folder. Folders of strangers are not looked into.
///
/// # Errors
/// A folder that cannot be read: what lies in it is not known.
pub(crate) fn listed(store: &Store, folder: Folder) -> Result<Vec<Listed>> {
    let mut found = Vec::new();
    for entry in entries(store, &folder.at())? {
        let name = entry.name.to_str().unwrap_or_default().to_owned();
        match folder.division(&name).filter(|_| entry.kind == Kind::Folder) {
            Some(division) => {
                for inner in entries(store, &division)? {
                    found.push(listed_as(folder, &name, &inner));
                }
            }
            None => found.push(listed_as(folder, "", &entry)),
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

fn entries(store: &Store, at: &At) -> Result<Vec<Entry>> {
    match store.files().list(at) {
        Err(why) if why.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        listed => listed.map_err(Error::io("read the folder", store.root().join(at.text()))),
    }
}

fn listed_as(folder: Folder, division: &str, entry: &Entry) -> Listed {
    let name = entry.name.to_string_lossy();
    let place = entry
        .name
        .to_str()
        .and_then(|name| Place::parse(folder, division, name));
    let names = [folder.name(), division, &name];
    let path: Vec<&str> = names.into_iter().filter(|name| !name.is_empty()).collect();
    Listed {
        place: place.filter(|_| entry.kind == Kind::File),
        path: path.join("/"),
        bytes: entry.bytes,
        modified: entry.modified,
    }
}
