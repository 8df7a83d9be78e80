//! The toy pipeline: numbers -> squares (`Each`) -> total (`All`) -> draws (`One`, rows) -> report (`Cases`, published);
//! a pinned figure; aside -> echo, which nothing else reads; fickle -> witness, which can be told not to be reproducible.

use encounter::engine::arrow::{All, CaseOf, Cases, Each, One, PiecesOf};
use encounter::engine::case::Axis;
use encounter::engine::error::{Error, Result};
use encounter::engine::node::{Node, node};
use encounter::engine::pipeline::Pipeline;
use encounter::engine::stage::{Here, Keep, Pieces, Published, Select, Stage};
use encounter::numerics::random;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The inner axis: `[base.NAME]`.
pub(crate) const BASE: Axis = Axis {
    table: "base",
    list: "bases",
};
/// The outer axis: `[scale.NAME]`, whose values have figures folders of their own.
pub(crate) const SCALE: Axis = Axis {
    table: "scale",
    list: "scales",
};
/// The toy pipeline.
pub(crate) const TOY: Pipeline = Pipeline {
    axes: &[SCALE, BASE],
    contents: CONTENTS,
    optional: &[],
    on_request: &[],
};
const CONTENTS: &[&dyn Node] = &[
    node::<Numbers<10>>(),
    node::<Squares>(),
    node::<Total>(),
    node::<Draws>(),
    node::<Pinned>(),
    node::<Report>(),
    node::<Aside>(),
    node::<Echo>(),
    node::<Fickle>(),
    node::<Witness>(),
];
/// Numbers alone, cut into pieces of another size.
pub(crate) const OTHER_BATCHES: Pipeline = Pipeline {
    axes: &[],
    contents: &[node::<Numbers<7>>()],
    optional: &[],
    on_request: &[],
};
/// Numbers alone.
pub(crate) const NUMBERS: Pipeline = Pipeline {
    axes: &[],
    contents: &[node::<Numbers<10>>()],
    optional: &[],
    on_request: &[],
};

/// Random whole numbers below `span`, left out of the store.
pub(crate) struct Numbers<const BATCH: u64>;

#[derive(Serialize, Deserialize)]
pub(crate) struct NumbersParams {
    numbers: NumbersTable,
}

#[derive(Serialize, Deserialize)]
struct NumbersTable {
    span: f64,
    /// In the key, in no byte of the output.
    label: String,
}

impl<const BATCH: u64> Stage for Numbers<BATCH> {
    const NAME: &'static str = "numbers";
    const PAPER: &'static str = "§1";
    const PIECES: Pieces = Pieces::Batches("numbers.count", BATCH);
    const KEEP: Keep = Keep::Evict;
    const SCHEMA: &'static str = "toy-numbers/1";
    type Params = NumbersParams;
    type Inputs = ();
    type Output = Vec<u64>;

    fn run(p: &NumbersParams, (): (), here: Here<'_>) -> Result<Vec<u64>> {
        let below = |mut stream| random::below(&mut stream, p.numbers.span as usize) as u64;
        Ok(here.streams().map(below).collect())
    }
}

/// (number + offset)^2.
pub(crate) struct Squares;

#[derive(Serialize, Deserialize)]
pub(crate) struct SquaresParams {
    base: Base,
    squares: SquaresTable,
}

#[derive(Serialize, Deserialize)]
struct Base {
    offset: u64,
}

#[derive(Serialize, Deserialize)]
struct SquaresTable {
    fail_at: u64,
    panic_at: u64,
}

impl Stage for Squares {
    const NAME: &'static str = "squares";
    const PAPER: &'static str = "§2";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "toy-squares/1";
    type Params = SquaresParams;
    type Inputs = (Each<Numbers<10>>,);
    type Output = Vec<u64>;

    fn run(p: &SquaresParams, (numbers,): (Arc<Vec<u64>>,), here: Here<'_>) -> Result<Vec<u64>> {
        let items = here.first..here.first + here.items;
        if items.contains(&p.squares.fail_at) {
            return Err(Error::stage(format!("cannot square item {}", p.squares.fail_at)));
        }
        assert!(!items.contains(&p.squares.panic_at), "a toy told to panic");
        let square = |number: &u64| (number + p.base.offset) * (number + p.base.offset);
        Ok(numbers.iter().map(square).collect())
    }
}

/// The sum of all squares, modulo `modulo`.
pub(crate) struct Total;

#[derive(Serialize, Deserialize)]
pub(crate) struct TotalParams {
    total: TotalTable,
}

#[derive(Serialize, Deserialize)]
struct TotalTable {
    modulo: u64,
}

impl Stage for Total {
    const NAME: &'static str = "total";
    const PAPER: &'static str = "§3";
    const SCHEMA: &'static str = "toy-total/1";
    type Params = TotalParams;
    type Inputs = (All<Squares>,);
    type Output = u64;

    fn run(p: &TotalParams, (squares,): (PiecesOf<'_, Vec<u64>>,), _: Here<'_>) -> Result<u64> {
        let mut sum = 0;
        for piece in squares.iter() {
            sum += piece?.iter().sum::<u64>();
        }
        Ok(sum % p.total.modulo)
    }
}

/// A random number and a level, for the bases that have a row.
pub(crate) struct Draws;

#[derive(Serialize, Deserialize)]
pub(crate) struct DrawsParams {
    draws: DrawsTable,
}

#[derive(Serialize, Deserialize)]
struct DrawsTable {
    row: Vec<Row>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    base: String,
    level: u64,
}

impl Stage for Draws {
    const NAME: &'static str = "draws";
    const PAPER: &'static str = "§4";
    const PIECES: Pieces = Pieces::Counted("draws.count");
    const SELECTS: &'static [Select] = &[Select::Rows(BASE, "draws.row")];
    const SCHEMA: &'static str = "toy-draws/1";
    type Params = DrawsParams;
    type Inputs = (One<Total>,);
    type Output = Vec<u64>;

    fn run(p: &DrawsParams, (total,): (Arc<u64>,), here: Here<'_>) -> Result<Vec<u64>> {
        let [row] = p.draws.row.as_slice() else {
            return Err(Error::stage(format!("{} rows, not one", p.draws.row.len())));
        };
        let drawn = random::below(&mut here.stream(here.first), 1000) as u64;
        Ok(vec![row.level, *total, drawn])
    }
}

/// A published file about one base alone.
pub(crate) struct Pinned;

#[derive(Serialize, Deserialize)]
pub(crate) struct PinnedParams {
    case: BaseName,
    pinned: PinnedTable,
}

#[derive(Serialize, Deserialize)]
struct BaseName {
    base: String,
}

#[derive(Serialize, Deserialize)]
struct PinnedTable {
    item: u64,
}

impl Stage for Pinned {
    const NAME: &'static str = "pinned";
    const PAPER: &'static str = "Fig. 1";
    const SELECTS: &'static [Select] = &[Select::At(BASE, "pinned.base")];
    const ITEMS: &'static [(&'static str, &'static str, u64)] = &[("pinned.item", "numbers.count", 1)];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = PinnedParams;
    type Inputs = (One<Total>,);
    type Output = Published;

    fn run(p: &PinnedParams, (total,): (Arc<u64>,), _: Here<'_>) -> Result<Published> {
        let text = format!("{} {} {total}\n", p.case.base, p.pinned.item);
        Ok(Published::new(Self::NAME, [("csv", text)]))
    }
}

/// The published table of all bases.
pub(crate) struct Report;

#[derive(Serialize, Deserialize)]
pub(crate) struct ReportParams {
    scale: Scale,
}

#[derive(Serialize, Deserialize)]
struct Scale {
    factor: u64,
}

impl Stage for Report {
    const NAME: &'static str = "report";
    const PAPER: &'static str = "Table 1";
    const GATHERS: &'static [Axis] = &[BASE];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = ReportParams;
    type Inputs = (Cases<Total>, Cases<Draws>);
    type Output = Published;

    fn run(
        p: &ReportParams,
        (totals, draws): (Vec<CaseOf<'_, u64>>, Vec<CaseOf<'_, Vec<u64>>>),
        _: Here<'_>,
    ) -> Result<Published> {
        let mut lines = Vec::new();
        for total in &totals {
            lines.push(format!("{} {}\n", total.case, *total.get()? * p.scale.factor));
        }
        for draw in &draws {
            for piece in draw.pieces.iter() {
                lines.push(format!("{} {:?}\n", draw.case, piece?));
            }
        }
        let text = lines.concat();
        Ok(Published::new(Self::NAME, [("csv", text.clone()), ("md", text)]))
    }
}

/// A number that nothing but [`Echo`] reads.
pub(crate) struct Aside;

#[derive(Serialize, Deserialize)]
pub(crate) struct AsideParams {
    aside: AsideTable,
}

#[derive(Serialize, Deserialize)]
struct AsideTable {
    value: u64,
    fail: bool,
}

impl Stage for Aside {
    const NAME: &'static str = "aside";
    const PAPER: &'static str = "§5";
    const SCHEMA: &'static str = "toy-aside/1";
    type Params = AsideParams;
    type Inputs = ();
    type Output = u64;

    fn run(p: &AsideParams, (): (), _: Here<'_>) -> Result<u64> {
        if p.aside.fail {
            return Err(Error::stage("told to fail"));
        }
        Ok(p.aside.value)
    }
}

/// What [`Aside`] said.
pub(crate) struct Echo;

#[derive(Serialize, Deserialize)]
pub(crate) struct NoParams {}

impl Stage for Echo {
    const NAME: &'static str = "echo";
    const PAPER: &'static str = "§5";
    const SCHEMA: &'static str = "toy-echo/1";
    type Params = NoParams;
    type Inputs = (One<Aside>,);
    type Output = u64;

    fn run(_: &NoParams, (aside,): (Arc<u64>,), _: Here<'_>) -> Result<u64> {
        Ok(*aside)
    }
}

static TIMES: AtomicU64 = AtomicU64::new(0);

/// Left out of the store; gives another number each time unless steady.
pub(crate) struct Fickle;

#[derive(Serialize, Deserialize)]
pub(crate) struct FickleParams {
    fickle: FickleTable,
}

#[derive(Serialize, Deserialize)]
struct FickleTable {
    steady: bool,
}

impl Stage for Fickle {
    const NAME: &'static str = "fickle";
    const PAPER: &'static str = "§6";
    const KEEP: Keep = Keep::Evict;
    const SCHEMA: &'static str = "toy-fickle/1";
    type Params = FickleParams;
    type Inputs = ();
    type Output = u64;

    fn run(p: &FickleParams, (): (), _: Here<'_>) -> Result<u64> {
        let times = TIMES.fetch_add(1, Ordering::Relaxed);
        Ok(if p.fickle.steady { 1 } else { times })
    }
}

/// Reads [`Fickle`].
pub(crate) struct Witness;

#[derive(Serialize, Deserialize)]
pub(crate) struct WitnessParams {
    witness: WitnessTable,
}

#[derive(Serialize, Deserialize)]
struct WitnessTable {
    shift: u64,
}

impl Stage for Witness {
    const NAME: &'static str = "witness";
    const PAPER: &'static str = "§6";
    const SCHEMA: &'static str = "toy-witness/1";
    type Params = WitnessParams;
    type Inputs = (One<Fickle>,);
    type Output = u64;

    fn run(p: &WitnessParams, (fickle,): (Arc<u64>,), _: Here<'_>) -> Result<u64> {
        Ok(*fickle + p.witness.shift)
    }
}
