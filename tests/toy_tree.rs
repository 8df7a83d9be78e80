//! A toy package in memory: two stages and a figure over four layers, with a manifest and a lock.

use crate::code_table::CodeTable;
use crate::modules::Sources;

/// Sources, manifest and lock, to be edited by a test.
pub(crate) struct ToyTree {
    pub(crate) sources: Sources,
    pub(crate) manifest: String,
    pub(crate) lock: String,
}

const FILES: [(&str, &str); 18] = [
    (
        "src/lib.rs",
        r#"pub mod engine; pub mod numerics; pub mod plot; pub mod sea; pub mod ship;
        #[path = "../stages/mod.rs"] pub mod stages;"#,
    ),
    ("src/main.rs", "mod cli; fn main() { cli::speak(); }"),
    (
        "src/cli/mod.rs",
        "use encounter::stages::CONTENTS; pub fn speak() { drop(CONTENTS); }",
    ),
    (
        "src/engine/mod.rs",
        "pub mod arrow; pub mod codec; pub mod schedule; pub mod stage; pub mod streams;",
    ),
    ("src/engine/arrow.rs", "pub struct One<S>(S); pub struct All<S>(S);"),
    ("src/engine/codec.rs", "use bincode::config; pub fn encode() {}"),
    ("src/engine/schedule.rs", "use rayon::prelude; pub fn start() {}"),
    (
        "src/engine/stage.rs",
        "use crate::engine::schedule; pub trait Stage { const NAME: &'static str; }",
    ),
    ("src/engine/streams.rs", "pub fn stream() {}"),
    (
        "src/numerics/mod.rs",
        "pub mod elementary; pub mod sums; pub mod domain;",
    ),
    (
        "src/numerics/elementary.rs",
        "pub fn sin(x: f64) -> f64 { pxfm::f_sin(x) }",
    ),
    (
        "src/numerics/sums.rs",
        "/// Adds.\npub fn sum(x: &[f64]) -> f64 { x.len() as f64 }\n#[cfg(test)]\nmod tests {}",
    ),
    ("src/numerics/domain.rs", "pub fn positive() {}"),
    (
        "src/plot/mod.rs",
        "use crate::numerics::elementary; pub fn draw() { elementary::sin(1.0); }",
    ),
    (
        "src/sea/mod.rs",
        "pub mod spectrum { pub struct Sea; impl Sea { pub fn of() { crate::numerics::elementary::sin(0.0); } } }",
    ),
    (
        "src/ship/mod.rs",
        r#"//! Roll.
        pub struct Roll { #[serde(deserialize_with = "crate::numerics::domain::positive")] pub alpha: f64 }"#,
    ),
    (
        "stages/mod.rs",
        "pub mod fig; pub mod roll; pub mod waves; use self::{fig::Fig, roll::RollStage, waves::Waves};
        pub const CONTENTS: &[&dyn Node] = &[&Of::<Waves>::NODE, &Of::<RollStage>::NODE, &Of::<Fig>::NODE];",
    ),
    (
        "stages/waves.rs",
        r#"use crate::engine::stage::Stage; use crate::sea::spectrum::Sea; pub struct Waves;
        impl Stage for Waves { const NAME: &'static str = "waves"; type Inputs = (); type Output = Sea;
            fn run() -> Sea { use crate::numerics::sums::sum; sum(&[]); Sea } }"#,
    ),
];

const ROLL: (&str, &str) = (
    "stages/roll.rs",
    r#"use super::waves::Waves; use crate::engine::{arrow::All, stage::Stage}; use crate::ship::Roll;
    pub struct RollStage;
    impl Stage for RollStage { const NAME: &'static str = "roll"; type Inputs = (All<Waves>,); type Output = Roll;
        fn run(_: Vec<crate::sea::spectrum::Sea>) -> Roll { Roll { alpha: 1.0 } } }"#,
);

const FIG: (&str, &str) = (
    "stages/fig.rs",
    r#"use crate::engine::{arrow::One, stage::Stage}; use crate::stages::roll::RollStage; pub struct Fig;
    impl Stage for Fig { const NAME: &'static str = "fig"; type Inputs = (One<RollStage>,); type Output = String;
        fn run() -> String { assert!(crate::plot::draw() == ()); String::new() } }"#,
);

const MANIFEST: &str = r#"
[package]
name = "encounter"
[dependencies]
bincode = "2"
pxfm = { version = "0.1", features = ["b", "a"] }
rayon = "1"
[dev-dependencies]
insta = "1"
"#;

const LOCK: &str = r#"
[[package]]
name = "bincode"
version = "2.0.1"
checksum = "b1"
[[package]]
name = "encounter"
version = "0.1.0"
dependencies = ["bincode", "insta", "pxfm", "rayon"]
[[package]]
name = "insta"
version = "1.0.0"
checksum = "i1"
dependencies = ["num-traits 0.1.0"]
[[package]]
name = "num-traits"
version = "0.1.0"
checksum = "n1"
[[package]]
name = "num-traits"
version = "0.2.0"
checksum = "n2"
[[package]]
name = "pxfm"
version = "0.1.30"
checksum = "p1"
dependencies = ["num-traits 0.2.0"]
[[package]]
name = "rayon"
version = "1.12.0"
checksum = "r1"
"#;

impl ToyTree {
    /// The toy package, unedited.
    pub(crate) fn new() -> Self {
        let files = FILES.into_iter().chain([ROLL, FIG]);
        Self {
            sources: files.map(|(path, text)| (path.to_owned(), text.to_owned())).collect(),
            manifest: MANIFEST.to_owned(),
            lock: LOCK.to_owned(),
        }
    }

    /// Replaces a passage of a file, which must be there.
    pub(crate) fn edit(mut self, path: &str, old: &str, new: &str) -> Self {
        let text = match path {
            "Cargo.toml" => &mut self.manifest,
            "Cargo.lock" => &mut self.lock,
            _ => self.sources.get_mut(path).expect("the toy file exists"),
        };
        assert!(text.contains(old), "{path} lacks `{old}`");
        *text = text.replace(old, new);
        self
    }

    /// Adds a file, or replaces one.
    pub(crate) fn with(mut self, path: &str, text: &str) -> Self {
        self.sources.insert(path.to_owned(), text.to_owned());
        self
    }

    /// Its code table.
    pub(crate) fn table(&self) -> CodeTable {
        CodeTable::new(&self.sources, &self.manifest, &self.lock).expect("the toy tree parses")
    }

    /// The stages whose row differs from that of the unedited tree.
    pub(crate) fn reruns(&self) -> Vec<String> {
        let (old, new) = (Self::new().table(), self.table());
        assert!(old.stages.keys().eq(new.stages.keys()), "an edit must keep the stages");
        let changed = new.stages.into_iter().filter(|(name, row)| old.stages[name] != *row);
        changed.map(|(name, _)| name).collect()
    }
}
