//! Random streams from names: root seed and stage give the key, the item (field, realisation) gives the stream.
//!
//! A draw never depends on threads, batches, cases or counts. Part of every code fingerprint.

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// The streams of one stage.
#[derive(Clone)]
pub struct Streams {
    key: [u8; 32],
}

impl Streams {
    /// The streams that belong to a root seed and a stage's name.
    pub fn new(seed: u64, stage: &str) -> Self {
        let mut hasher = blake3::Hasher::new_derive_key("encounter 1 streams");
        hasher.update(&seed.to_le_bytes());
        hasher.update(stage.as_bytes());
        Self {
            key: *hasher.finalize().as_bytes(),
        }
    }

    /// The stream of one item, counted over the whole node.
    pub fn of(&self, item: u64) -> ChaCha12Rng {
        let mut stream = ChaCha12Rng::from_seed(self.key);
        stream.set_stream(item);
        stream
    }
}
