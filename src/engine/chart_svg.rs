//! A chart as a picture: the stages as steps of a stair in paper order, so that no line can meet a box it is not for.
//!
//! What a stage makes runs down its own line, left of every later step; what a stage reads comes along its own row from
//! the left. A dot marks each line that is read there; lines without a dot only cross.

use std::fmt::Write as _;

use crate::engine::chart::{Chart, Tile};
use crate::engine::chart_text::COLOURS;
use crate::text::escape::xml as escape;

/// Height of a row, px.
const ROW: f64 = 34.0;
/// Height of a box, px.
const HEIGHT: f64 = 24.0;
/// How far each step stands right of the one before, px.
const STEP: f64 = 20.0;
/// How far right of its box's left border a line runs down, px.
const INSET: f64 = 7.0;
/// Left and upper border of the first box, px.
const LEFT: f64 = 22.0;
const TOP: f64 = 58.0;
/// Size of names and notes, px.
const NAME: f64 = 12.0;
const NOTE: f64 = 10.5;
/// The advance of a character, em: more than that of letters in DejaVu Sans.
const ADVANCE: f64 = 0.66;
/// Families with like metrics.
const FONTS: &str = "'DejaVu Sans', Verdana, 'Bitstream Vera Sans', Arial, sans-serif";

/// Where everything stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Stair {
    /// Per tile: left, upper border, width, height of its box, px.
    pub boxes: Vec<[f64; 4]>,
    /// Lines, px: x1, y1, x2, y2; those down belong to the tile they come from, those across to the one that reads.
    pub lines: Vec<([f64; 4], usize)>,
    /// Dots where a line is read: x, y, and the tile that reads.
    pub dots: Vec<([f64; 2], usize)>,
    /// Width and height of the whole, px.
    pub size: [f64; 2],
}

/// Lays a chart out.
pub fn stair(chart: &Chart) -> Stair {
    let widest = |of: &dyn Fn(&Tile) -> String, size: f64| {
        let lengths = chart.tiles.iter().map(|tile| of(tile).chars().count());
        lengths.max().unwrap_or(0) as f64 * ADVANCE * size
    };
    let width = widest(&|tile| tile.name.clone(), NAME) + 20.0;
    let notes = widest(&note, NOTE) + 30.0;
    let corner = |place: usize| (LEFT + STEP * place as f64, TOP + ROW * place as f64);
    let boxes: Vec<[f64; 4]> = (0..chart.tiles.len())
        .map(|place| [corner(place).0, corner(place).1, width, HEIGHT])
        .collect();
    let line_of = |place: usize| corner(place).0 + INSET;
    let row_of = |place: usize| corner(place).1 + HEIGHT / 2.0;
    let (mut lines, mut dots) = (Vec::new(), Vec::new());
    for place in 0..chart.tiles.len() {
        let readers = chart.flows.iter().filter(|flow| flow.from == place).map(|flow| flow.to);
        if let Some(last) = readers.max() {
            let x = line_of(place);
            lines.push(([x, corner(place).1 + HEIGHT, x, row_of(last)], place));
        }
        let inputs: Vec<usize> = chart
            .flows
            .iter()
            .filter(|flow| flow.to == place)
            .map(|flow| flow.from)
            .collect();
        if let Some(first) = inputs.iter().min() {
            let y = row_of(place);
            lines.push(([line_of(*first), y, corner(place).0, y], place));
        }
        dots.extend(inputs.iter().map(|from| ([line_of(*from), row_of(place)], place)));
    }
    let last = chart.tiles.len().saturating_sub(1);
    let size = [corner(last).0 + width + notes, corner(last).1 + HEIGHT + 20.0];
    Stair {
        boxes,
        lines,
        dots,
        size,
    }
}

/// What stands beside a box.
fn note(tile: &Tile) -> String {
    let parts = [tile.paper.clone(), tile.counts(), tile.news()];
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    parts.join(" · ")
}

fn colours(state: &str) -> (&'static str, &'static str) {
    let found = COLOURS.iter().find(|(name, ..)| *name == state);
    found.map_or(("#FFFFFF", "#000000"), |(_, fill, line)| (*fill, *line))
}

/// Draws a chart; the title stands above it.
pub fn svg(chart: &Chart, title: &str) -> String {
    let stair = stair(chart);
    let [width, height] = stair.size;
    let title = escape(title);
    let mut body = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         role=\"img\" font-family=\"{FONTS}\" fill=\"#141414\">\n<title>{title}</title>\n\
         <desc>The stages in paper order; lines lead from each stage to those that read it.</desc>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#FFFFFF\"/>\n\
         <text x=\"{LEFT}\" y=\"24\" font-size=\"13\" font-weight=\"bold\">{title}</text>\n"
    );
    legend(&mut body);
    draw_lines(&mut body, chart, &stair);
    for (tile, at) in chart.tiles.iter().zip(&stair.boxes) {
        draw_tile(&mut body, tile, *at);
    }
    body + "</svg>\n"
}

fn legend(body: &mut String) {
    let mut x = LEFT;
    for (state, fill, line) in COLOURS {
        let name = state.replace('_', " ");
        let _ = writeln!(
            body,
            "<rect x=\"{x}\" y=\"34\" width=\"14\" height=\"10\" rx=\"2\" fill=\"{fill}\" stroke=\"{line}\"/>\
             <text x=\"{}\" y=\"43\" font-size=\"{NOTE}\">{name}</text>",
            x + 20.0
        );
        x += 36.0 + name.len() as f64 * ADVANCE * NOTE;
    }
    let _ = writeln!(
        body,
        "<rect x=\"{x}\" y=\"34\" width=\"18\" height=\"10\" rx=\"5\" fill=\"#FFFFFF\" stroke=\"#6F7B87\"/>\
         <text x=\"{}\" y=\"43\" font-size=\"{NOTE}\">figure or table</text>",
        x + 24.0
    );
}

/// Lines that will change lie above those that stay.
fn draw_lines(body: &mut String, chart: &Chart, stair: &Stair) {
    for (state, _, colour) in COLOURS {
        let is_in = |place: usize| chart.tiles[place].state() == state;
        for ([x1, y1, x2, y2], _) in stair.lines.iter().filter(|(_, place)| is_in(*place)) {
            let _ = writeln!(
                body,
                "<path d=\"M{x1} {y1}L{x2} {y2}\" stroke=\"{colour}\" stroke-width=\"1.2\" fill=\"none\"/>"
            );
        }
        for ([x, y], _) in stair.dots.iter().filter(|(_, place)| is_in(*place)) {
            let _ = writeln!(body, "<circle cx=\"{x}\" cy=\"{y}\" r=\"3\" fill=\"{colour}\"/>");
        }
    }
    for (place, [x, y, ..]) in stair.boxes.iter().enumerate() {
        if chart.flows.iter().any(|flow| flow.to == place) {
            let (_, colour) = colours(chart.tiles[place].state());
            let (y, from) = (y + HEIGHT / 2.0, x - 6.0);
            let (above, below) = (y - 3.5, y + 3.5);
            let _ = writeln!(
                body,
                "<path d=\"M{x} {y}L{from} {above}L{from} {below}Z\" fill=\"{colour}\"/>"
            );
        }
    }
}

fn draw_tile(body: &mut String, tile: &Tile, [x, y, width, height]: [f64; 4]) {
    let (fill, line) = colours(tile.state());
    let radius = if tile.published { height / 2.0 } else { 4.0 };
    let dash = if tile.state() == "may_run" {
        " stroke-dasharray=\"4 2\""
    } else {
        ""
    };
    let baseline = y + height / 2.0 + 0.36 * NAME;
    let _ = writeln!(
        body,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"{radius}\" fill=\"{fill}\" \
         stroke=\"{line}\" stroke-width=\"1.2\"{dash}/>\n\
         <text x=\"{}\" y=\"{baseline}\" font-size=\"{NAME}\" text-anchor=\"middle\">{}</text>\n\
         <text x=\"{}\" y=\"{baseline}\" font-size=\"{NOTE}\" fill=\"#5F5F5F\">{}</text>",
        x + width / 2.0,
        escape(&tile.name),
        x + width + 10.0,
        escape(&note(tile))
    );
}
