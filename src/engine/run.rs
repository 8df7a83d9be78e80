//! Run: the state of one walk through a graph. One code path decides what is cached; `status` and `run` both ask it.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use crate::engine::arrow::Kind;
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::flight::KeyLock;
use crate::engine::graph::{Graph, Link};
use crate::engine::id::{Id, Key, schema_number};
use crate::engine::key::{InputKey, Preimage};
use crate::engine::memo::Memo;
use crate::engine::names::Place;
use crate::engine::node::Value;
use crate::engine::object;
use crate::engine::parts::{self, PartNames};
use crate::engine::read::Reader;
use crate::engine::record::Record;
use crate::engine::runs::checkout_number;
use crate::engine::stage::{Here, Keep};
use crate::engine::stop::Stop;
use crate::engine::store::{Found, Store};
use crate::engine::twice;

/// Bytes of artifacts held in memory between stages.
const MEMO_BYTES: usize = 256 << 20;

const MISSING: &str = "its object is missing";

/// Whoever wants to know what happens.
pub type Listener<'a> = dyn Fn(&Event) + Sync + 'a;

/// The state of one walk through a graph.
pub struct Run<'g> {
    pub(crate) graph: &'g Graph,
    pub(crate) store: &'g Store,
    listener: &'g Listener<'g>,
    /// Per piece: its id and the length of its output, once known.
    known: Vec<Vec<OnceLock<(Id, u64)>>>,
    contents: Vec<OnceLock<Id>>,
    /// Per node: the parts that its records name, once one of its pieces was made.
    parts: Vec<OnceLock<PartNames>>,
    memo: Memo,
    stop: Option<&'g Stop>,
    /// The checkout that it was started in: its last runs stay out of the reach of `gc`.
    pub(crate) checkout: u64,
}

/// What is known of a piece before anything runs.
pub(crate) enum Decision {
    /// A record with its bytes at hand, or left out on purpose.
    Cached,
    /// No such record.
    WillRun(Key),
    /// An input will run; whether this piece must is not known yet.
    MayRun,
}

impl<'g> Run<'g> {
    /// A walk that knows no id yet.
    pub fn new(graph: &'g Graph, store: &'g Store, listener: &'g Listener<'g>) -> Self {
        let known = graph
            .nodes
            .iter()
            .map(|node| node.pieces.iter().map(|_| OnceLock::new()).collect())
            .collect();
        let contents = graph.nodes.iter().map(|_| OnceLock::new()).collect();
        let parts = graph.nodes.iter().map(|_| OnceLock::new()).collect();
        Self {
            graph,
            store,
            listener,
            known,
            contents,
            parts,
            memo: Memo::new(MEMO_BYTES),
            stop: None,
            checkout: 0,
        }
    }

    /// The same walk, ended early when somebody asks for it.
    #[must_use]
    pub fn until(mut self, stop: &'g Stop) -> Self {
        self.stop = Some(stop);
        self
    }

    /// The same walk, remembered as one of a checkout.
    #[must_use]
    pub fn in_checkout(mut self, checkout: &Path) -> Self {
        self.checkout = checkout_number(checkout);
        self
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(Stop::is_asked)
    }

    pub(crate) fn tell(&self, event: &Event) {
        (self.listener)(event);
    }

    /// The id of a piece, once it is known.
    pub fn id(&self, node: usize, piece: usize) -> Option<Id> {
        self.known[node][piece].get().map(|(id, _)| *id)
    }

    /// The length of a piece's output in bytes, once it is known.
    pub(crate) fn bytes_of(&self, node: usize, piece: usize) -> Option<u64> {
        self.known[node][piece].get().map(|(_, bytes)| *bytes)
    }

    /// The length of a node's output in bytes, over all pieces, once all are known.
    pub fn bytes_of_node(&self, node: usize) -> Option<u64> {
        let lengths: Option<Vec<u64>> = (0..self.known[node].len())
            .map(|piece| self.bytes_of(node, piece))
            .collect();
        // What a forged record says of its length need not add up.
        Some(lengths?.into_iter().fold(0, u64::saturating_add))
    }

    /// The content of a node: the id of its only piece, or of the list of its pieces' ids.
    pub fn content(&self, node: usize) -> Option<Id> {
        if let Some(id) = self.contents[node].get() {
            return Some(*id);
        }
        let ids: Option<Vec<Id>> = (0..self.known[node].len()).map(|piece| self.id(node, piece)).collect();
        let ids = ids?;
        let content = if let [only] = ids.as_slice() {
            *only
        } else {
            Id::of_manifest(&ids)
        };
        Some(*self.contents[node].get_or_init(|| content))
    }

    /// The key of a piece, if the ids of all its inputs are known.
    pub fn key(&self, node: usize, piece: usize) -> Option<Key> {
        let inputs: Option<Vec<InputKey>> = self.graph.nodes[node]
            .links
            .iter()
            .map(|link| self.input_key(link, piece))
            .collect();
        Some(self.preimage(node, piece, inputs?).key())
    }

    fn preimage(&self, node: usize, piece: usize, inputs: Vec<InputKey>) -> Preimage<'_> {
        let it = &self.graph.nodes[node];
        let (first, items) = it.pieces[piece];
        Preimage {
            stage: it.node.name(),
            first,
            items,
            seed: self.graph.seed,
            code: it.code,
            params: &it.decoded.bytes,
            inputs,
        }
    }

    fn input_key(&self, link: &Link, piece: usize) -> Option<InputKey> {
        match link.kind {
            Kind::Each => self.id(link.upstream[0], piece).map(InputKey::Content),
            Kind::One | Kind::All => self.content(link.upstream[0]).map(InputKey::Content),
            Kind::Cases => {
                let case = |up: &usize| Some((self.graph.nodes[*up].case.to_string(), self.content(*up)?));
                link.upstream
                    .iter()
                    .map(case)
                    .collect::<Option<Vec<_>>>()
                    .map(InputKey::Cases)
            }
        }
    }

    /// Decides a piece from its key and the store; a cached one is known from now on.
    pub(crate) fn decide(&self, node: usize, piece: usize) -> Decision {
        if self.id(node, piece).is_some() {
            return Decision::Cached;
        }
        let Some(key) = self.key(node, piece) else {
            return Decision::MayRun;
        };
        match self
            .store
            .record(&key)
            .and_then(|record| Some((Id::parse(&record.id)?, record.bytes, record.evicted)))
        {
            Some((id, bytes, evicted)) if evicted || self.store.has(&id) => {
                let _ = self.known[node][piece].set((id, bytes));
                Decision::Cached
            }
            _ => Decision::WillRun(key),
        }
    }

    /// Takes an id from a record without looking for its object, which will be made again when somebody reads it.
    pub(crate) fn take_as_known(&self, node: usize, piece: usize, id: Id, bytes: u64) {
        let _ = self.known[node][piece].set((id, bytes));
    }

    /// Runs a piece, stores its output and takes note of its id; the lock keeps others from making it meanwhile.
    pub(crate) fn make(&self, node: usize, piece: usize, key: Key, lock: Option<KeyLock>) -> Result<()> {
        let it = &self.graph.nodes[node];
        let name = it.name();
        self.tell(&Event::WillRun {
            node: name.clone(),
            piece,
        });
        let start = Instant::now();
        let bytes = self.compute(node, piece)?;
        let seconds = start.elapsed().as_secs_f64();
        let schema = schema_number(it.node.schema());
        let id = Id::of(crate::engine::codec::CODEC, schema, &bytes);
        let mut record = Record::of(self, (node, piece), key, (id, bytes.len() as u64), seconds);
        record.parts = Some(self.parts(node)?);
        let earlier = self.store.record(&key);
        if let Some(earlier) = earlier.as_ref().filter(|earlier| earlier.id != record.id) {
            return Err(twice::error(self, node, piece, &earlier.id, &bytes));
        }
        let healed = earlier.is_some() && !record.evicted && !self.store.has(&id);
        self.store.publish(schema, &bytes, &record, lock)?;
        if healed {
            let why = MISSING.to_owned();
            let node = name.clone();
            self.tell(&Event::DidHeal { node, piece, why });
        }
        let length = bytes.len() as u64;
        self.memo.put_bytes(id, Arc::from(bytes));
        let _ = self.known[node][piece].set((id, length));
        self.tell(&Event::DidRun {
            node: name,
            piece,
            seconds,
            bytes: length,
        });
        Ok(())
    }

    /// The encoded output of a piece whose inputs are known, made now.
    pub(crate) fn compute(&self, node: usize, piece: usize) -> Result<Vec<u8>> {
        let it = &self.graph.nodes[node];
        let (first, items) = it.pieces[piece];
        let here = Here {
            first,
            items,
            streams: &it.streams,
        };
        let reader = Reader::new(self, node, piece);
        it.node
            .run(it.decoded.value.as_ref(), &reader, here)
            .map_err(|error| error.at(&it.piece_name(piece)))
    }

    /// The parts of a node whose inputs are all known, put into the store the first time.
    fn parts(&self, node: usize) -> Result<PartNames> {
        if let Some(names) = self.parts[node].get() {
            return Ok(names.clone());
        }
        let names = parts::keep(self, node)?;
        Ok(self.parts[node].get_or_init(|| names).clone())
    }

    /// The decoded output of a piece whose id is known: from memory, from the store, or made again and checked.
    pub(crate) fn value(&self, node: usize, piece: usize) -> Result<Value> {
        let id = self.id(node, piece).expect("a piece is read after its id is known");
        if let Some(value) = self.memo.value(&id) {
            return Ok(value);
        }
        let bytes = match self.memo.bytes(&id) {
            Some(bytes) => bytes,
            None => Arc::from(self.bytes(node, piece)?),
        };
        let value = self.graph.nodes[node].decode(piece, &bytes);
        let value = value.map_err(|error| self.distrust(node, piece, error))?;
        self.memo.put_value(id, value.clone(), bytes.len());
        Ok(value)
    }

    /// The encoded output of a piece whose id is known.
    ///
    /// # Errors
    /// An output that is gone and cannot be made again with the same bits.
    pub fn bytes(&self, node: usize, piece: usize) -> Result<Vec<u8>> {
        let it = &self.graph.nodes[node];
        let id = self.id(node, piece).expect("a piece is read after its id is known");
        let schema = schema_number(it.node.schema());
        let damage = match self.store.read(&id, Some(schema)) {
            Found::Bytes(bytes) => return Ok(bytes),
            Found::Missing => None,
            // It is sound as the output of another stage, which keeps it.
            Found::Damaged(why) if matches!(self.store.peek(&id, None), Found::Bytes(_)) => {
                return Err(self.distrust_record(node, piece, why));
            }
            Found::Damaged(why) => Some(format!("its object is damaged ({why})")),
        };
        for link in &it.links {
            self.know_inputs(link, piece)?;
        }
        let bytes = self.compute(node, piece)?;
        let (made, file) = object::seal(schema, &bytes);
        if made != id {
            return Err(twice::error(self, node, piece, &id.to_string(), &bytes));
        }
        if it.node.keep() != Keep::Evict {
            self.restore(node, piece, &file, damage)?;
        }
        Ok(bytes)
    }

    /// The files that a published piece holds, by name.
    ///
    /// # Errors
    /// Those of [`Self::bytes`]; an output that holds no files of this stage.
    pub fn published(&self, node: usize) -> Result<BTreeMap<String, String>> {
        let bytes = self.bytes(node, 0)?;
        let files = self.graph.nodes[node].node.published(&bytes);
        files.map_err(|error| self.distrust(node, 0, error))
    }

    /// Sets aside an object, and the record that names it, which are whole and yet no output of their stage: somebody forged
    /// them, since no stage stores what it could not read. What this walk knows may rest on them, so it has to begin anew.
    fn distrust(&self, node: usize, piece: usize, error: Error) -> Error {
        let Error::Damaged { why, .. } = error else {
            return error;
        };
        let object = self.id(node, piece).map(Place::Object);
        match object.map(|object| self.set_aside(&object)) {
            Some(Err(error)) => error,
            _ => self.distrust_record(node, piece, why),
        }
    }

    /// The same for the record alone.
    fn distrust_record(&self, node: usize, piece: usize, why: String) -> Error {
        let record = self.key(node, piece).map(Place::Record);
        if let Some(Err(error)) = record.map(|record| self.set_aside(&record)) {
            return error;
        }
        let node = self.graph.nodes[node].piece_name(piece);
        self.tell(&Event::DidDistrust {
            node: node.clone(),
            why: why.clone(),
        });
        Error::Distrusted { node, why }
    }

    fn set_aside(&self, place: &Place) -> Result<()> {
        match self.store.set_aside(place) {
            Err(why) if why.kind() != ErrorKind::NotFound => Err(Error::io(
                "set aside what no stage has made,",
                self.store.path(place),
            )(why)),
            _ => Ok(()),
        }
    }

    /// Puts an object back; one that `gc` took away was not lost.
    fn restore(&self, node: usize, piece: usize, file: &[u8], damage: Option<String>) -> Result<()> {
        let (Some(id), Some(key)) = (self.id(node, piece), self.key(node, piece)) else {
            return Ok(());
        };
        let evicted = self.store.record(&key).is_some_and(|record| record.evicted);
        self.store.restore(&id, file)?;
        if damage.is_some() || !evicted {
            self.tell(&Event::DidHeal {
                node: self.graph.nodes[node].name(),
                piece,
                why: damage.unwrap_or_else(|| MISSING.to_owned()),
            });
        }
        Ok(())
    }

    /// Makes sure that the ids an arrow needs are known, deciding upstream pieces that nobody has asked for yet.
    fn know_inputs(&self, link: &Link, piece: usize) -> Result<()> {
        for up in &link.upstream {
            let pieces = if link.kind == Kind::Each {
                piece..piece + 1
            } else {
                0..self.graph.nodes[*up].pieces.len()
            };
            for piece in pieces {
                self.know(*up, piece)?;
            }
        }
        Ok(())
    }

    fn know(&self, node: usize, piece: usize) -> Result<()> {
        if self.id(node, piece).is_some() {
            return Ok(());
        }
        for link in &self.graph.nodes[node].links {
            self.know_inputs(link, piece)?;
        }
        match self.decide(node, piece) {
            Decision::WillRun(key) => self.make(node, piece, key, None),
            Decision::Cached | Decision::MayRun => Ok(()),
        }
    }

    /// The recipe of a whole node: its key with the contents of its inputs, whatever the piece.
    pub(crate) fn recipe(&self, node: usize, content: &dyn Fn(usize) -> Option<Id>) -> Option<Key> {
        self.recipe_under(self.graph.seed, node, content)
    }

    /// The recipe that a node has under another root seed.
    pub(crate) fn recipe_under(&self, seed: u64, node: usize, content: &dyn Fn(usize) -> Option<Id>) -> Option<Key> {
        let it = &self.graph.nodes[node];
        let inputs: Option<Vec<InputKey>> = it
            .links
            .iter()
            .map(|link| {
                let case = |up: &usize| Some((self.graph.nodes[*up].case.to_string(), content(*up)?));
                link.upstream
                    .iter()
                    .map(case)
                    .collect::<Option<Vec<_>>>()
                    .map(InputKey::Cases)
            })
            .collect();
        let mut preimage = self.preimage(node, 0, inputs?);
        preimage.seed = seed;
        preimage.first = it.pieces.len() as u64;
        preimage.items = it.pieces.iter().map(|(_, items)| items).sum();
        Some(preimage.recipe())
    }
}
