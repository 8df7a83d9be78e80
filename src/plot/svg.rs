//! The sheet: plotters draws shapes on it ten times enlarged, text is set upon it with subscripts, and it ends as SVG.
//!
//! plotters' SVG backend knows whole pixels only, guesses the width of text by its bytes, places it by `ex` (which
//! renderers measure differently), and knows no dashes, no subscripts and no title. Hence: coordinates are tenths of a
//! pixel, every layer of shapes becomes a `<g>` that carries dashes and joins, and text is written here, as text, with
//! its baseline computed. Tested in `tests/plots` for well-formed XML, equal bytes and coordinates within the sheet.

use std::fmt::Write;

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::style::RGBColor;

use super::{Error, style};
use crate::text::escape::xml as escape;

/// Units of the view box per pixel.
pub const SCALE: f64 = 10.0;

/// What plotters draws on.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// An SVG document in the making; lengths are pixels from the upper left corner.
#[derive(Clone, Debug)]
pub struct Sheet {
    width: f64,
    height: f64,
    body: String,
}

/// Which point of a text its position names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// How a text is set.
#[derive(Clone, Copy, Debug)]
pub struct Type {
    /// Size, px.
    pub size: f64,
    /// The point that stands at the given position.
    pub anchor: Anchor,
    /// Bold or regular.
    pub bold: bool,
    /// Colour.
    pub colour: RGBColor,
    /// Turned to read upwards.
    pub upwards: bool,
}

/// A label of an axis or legend: regular, black, from its left end.
pub const PLAIN: Type = Type {
    size: style::LABEL_SIZE,
    anchor: Anchor::Start,
    bold: false,
    colour: style::BLACK,
    upwards: false,
};

impl Sheet {
    /// An empty white sheet of the given size in px.
    pub fn new(width: f64, height: f64) -> Sheet {
        let (w, h) = (units(width), units(height));
        let body = format!("<rect x=\"0\" y=\"0\" width=\"{w}\" height=\"{h}\" fill=\"#FFFFFF\"/>\n");
        Sheet { width, height, body }
    }

    /// The width in px.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Lets plotters draw one layer of shapes; `attributes` dress the whole layer.
    pub fn shapes(&mut self, attributes: &str, draw: impl FnOnce(&Area<'_>) -> Result<(), Error>) -> Result<(), Error> {
        let mut drawn = String::new();
        {
            let size = (units(self.width) as u32, units(self.height) as u32);
            let area = SVGBackend::with_string(&mut drawn, size).into_drawing_area();
            draw(&area)?;
            area.present().map_err(|error| Error::Plotters(error.to_string()))?;
        }
        let inside = drawn.trim_end().trim_end_matches("</svg>");
        let inside = inside.find('\n').map_or("", |end| &inside[end + 1..]);
        if inside.is_empty() {
            return Ok(());
        }
        let (shared, inside) = share(&inside.replace(" opacity=\"1\"", "").replace(" \"/>", "\"/>"));
        let gap = if attributes.is_empty() { "" } else { " " };
        let _ = write!(self.body, "<g{gap}{attributes}{shared}>\n{inside}</g>\n");
        Ok(())
    }

    /// Sets a text with its baseline at (x, y); `_{..}` lowers, `^{..}` raises, `*..*` slants.
    pub fn text(&mut self, x: f64, y: f64, look: Type, text: &str) {
        if text.is_empty() {
            return;
        }
        let (x, y) = (units(x), units(y));
        let _ = write!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"",
            units(look.size)
        );
        match look.anchor {
            Anchor::Start => {}
            Anchor::Middle => self.body.push_str(" text-anchor=\"middle\""),
            Anchor::End => self.body.push_str(" text-anchor=\"end\""),
        }
        if look.bold {
            self.body.push_str(" font-weight=\"bold\"");
        }
        if look.upwards {
            let _ = write!(self.body, " transform=\"rotate(270,{x},{y})\"");
        }
        let RGBColor(r, g, b) = look.colour;
        let _ = write!(self.body, " fill=\"#{r:02X}{g:02X}{b:02X}\">");
        self.body.push_str(&spans(text, look.size));
        self.body.push_str("</text>\n");
    }

    /// The document, its title and its description for those who cannot see it.
    pub fn finish(self, title: &str, description: &str) -> String {
        let (w, h) = (units(self.width), units(self.height));
        let (title, description, fonts) = (escape(title), escape(description), style::FONTS);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {w} {h}\" \
             role=\"img\" xml:space=\"preserve\" font-family=\"{fonts}\">\n<title>{title}</title>\n<desc>{description}</desc>\n{}\n{}</svg>\n",
            self.width,
            self.height,
            provenance(&title),
            self.body
        )
    }
}

/// Where a picture comes from, in Dublin Core's words; the title is escaped already.
fn provenance(title: &str) -> String {
    format!(
        "<metadata><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\" \
         xmlns:dc=\"http://purl.org/dc/elements/1.1/\"><rdf:Description rdf:about=\"\"><dc:title>{title}</dc:title>\
         <dc:creator>encounter</dc:creator><dc:format>image/svg+xml</dc:format>\
         <dc:relation>https://arxiv.org/abs/2208.12907</dc:relation>\
         <dc:source>the CSV file beside this picture; its id stands in artifacts/*.lock, its recipe in `encounter show`</dc:source>\
         </rdf:Description></rdf:RDF></metadata>"
    )
}

/// Takes the colours and widths that all elements have in common out of them, for the group around them.
fn share(elements: &str) -> (String, String) {
    let mut shared = String::new();
    let mut rest = elements.to_owned();
    for key in ["fill", "stroke", "stroke-width"] {
        let start = format!(" {key}=\"");
        let Some(at) = rest.find(&start) else { continue };
        let end = rest[at + start.len()..]
            .find('"')
            .map_or(rest.len(), |end| at + start.len() + end + 1);
        let attribute = rest[at..end].to_owned();
        if rest.lines().all(|element| element.contains(&attribute)) {
            rest = rest.replace(&attribute, "");
            shared.push_str(&attribute);
        }
    }
    (shared, rest)
}

/// The attribute that dashes a layer's lines; empty for solid ones.
pub fn dashes(lengths: &[f64]) -> String {
    let joins = "stroke-linejoin=\"round\"";
    if lengths.is_empty() {
        return joins.to_owned();
    }
    let lengths: Vec<String> = lengths.iter().map(|length| units(*length).to_string()).collect();
    format!("{joins} stroke-dasharray=\"{}\"", lengths.join(","))
}

/// Pixels in units of the view box, to the nearest.
pub fn units(px: f64) -> i32 {
    (px * SCALE).round() as i32
}

/// A width for plotters: pixels in units of the view box, at least one.
pub fn stroke(px: f64) -> u32 {
    units(px).unsigned_abs().max(1)
}

/// The estimated width of a marked-up text in DejaVu Sans, px; other families run narrower.
pub fn text_width(text: &str, size: f64) -> f64 {
    let mut width = 0.0;
    for run in runs(text) {
        let scale = if run.shift == 0 { 1.0 } else { SMALL };
        for c in run.text.chars() {
            width += scale * advance(c);
        }
    }
    width * size
}

/// The longest beginning of a text that fits into `width` px; a text that is cut loses its marks and gains an ellipsis.
pub fn shorten(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let plain: String = runs(text).iter().map(|run| run.text).collect();
    let mut kept = String::new();
    for c in plain.chars() {
        let longer = format!("{kept}{c}");
        if text_width(&longer, size) + size > width {
            break;
        }
        kept = longer;
    }
    format!("{}…", kept.trim_end())
}

/// Size of sub- and superscripts relative to their text.
const SMALL: f64 = 0.72;

/// A stretch of text set in one way; `shift` is -1 below, 0 on and 1 above the baseline.
struct Run<'a> {
    text: &'a str,
    shift: i32,
    slanted: bool,
}

/// Splits marked-up text into its runs.
fn runs(text: &str) -> Vec<Run<'_>> {
    let mut runs = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['_', '^', '*']) {
        let (before, marked) = rest.split_at(at);
        let (closed, shift) = match marked.as_bytes() {
            [b'_', b'{', ..] => (marked[2..].split_once('}'), -1),
            [b'^', b'{', ..] => (marked[2..].split_once('}'), 1),
            [b'*', ..] => (marked[1..].split_once('*'), 0),
            _ => (None, 0),
        };
        let Some((inside, after)) = closed else {
            let end = at + marked.chars().next().map_or(0, char::len_utf8);
            runs.push(Run {
                text: &rest[..end],
                shift: 0,
                slanted: false,
            });
            rest = &rest[end..];
            continue;
        };
        runs.push(Run {
            text: before,
            shift: 0,
            slanted: false,
        });
        runs.push(Run {
            text: inside,
            shift,
            slanted: shift == 0,
        });
        rest = after;
    }
    runs.push(Run {
        text: rest,
        shift: 0,
        slanted: false,
    });
    runs.retain(|run| !run.text.is_empty());
    runs
}

/// The runs of a marked-up text as `<tspan>`s; a plain one stays bare.
fn spans(text: &str, size: f64) -> String {
    let mut set = String::new();
    let mut height = 0;
    for run in runs(text) {
        let wanted = if run.shift < 0 {
            -units(0.2 * size)
        } else {
            run.shift * units(0.36 * size)
        };
        let mut attributes = String::new();
        if wanted != height {
            let _ = write!(attributes, " dy=\"{}\"", height - wanted);
            height = wanted;
        }
        if run.shift != 0 {
            let _ = write!(attributes, " font-size=\"{}\"", units(SMALL * size));
        }
        if run.slanted {
            attributes.push_str(" font-style=\"italic\"");
        }
        let inside = escape(run.text);
        if attributes.is_empty() {
            set.push_str(&inside);
        } else {
            let _ = write!(set, "<tspan{attributes}>{inside}</tspan>");
        }
    }
    set
}

/// The advance of a character in DejaVu Sans, em; classes within a few per cent, never much too small.
fn advance(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | 'I' | '\'' | '.' | ',' | ':' | ';' | ' ' | '|' => 0.32,
        'f' | 't' | 'r' | '(' | ')' | '-' | '/' | '[' | ']' | '·' | '⁰'..='₉' | '¹' | '²' | '³' => 0.41,
        'm' | 'w' | 'W' | 'M' | '@' | '…' => 0.98,
        '=' | '+' | '−' | '±' | '<' | '>' | '~' | '≤' | '≥' | '×' => 0.84,
        '\u{300}'..='\u{36f}' => 0.0,
        'A'..='Z' => 0.72,
        _ => 0.635,
    }
}
