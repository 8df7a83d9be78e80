//! The static page of one ship: every figure with its caption, Table 1, the findings, the parameters in force and the ids.
//!
//! One HTML file without scripts, fonts or anything else from elsewhere: it reads the figures beside it. It holds no times,
//! since it is hashed like the rest. Tested in `tests/report/page.rs`.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::Value;

use crate::text::escape::xml as escape;

/// A value as the parameter file writes it.
fn written(value: &Value) -> String {
    match value {
        Value::Array(list) => {
            let inside: Vec<String> = list.iter().map(written).collect();
            format!("[{}]", inside.join(", "))
        }
        Value::Object(table) => {
            let inside: Vec<String> = table
                .iter()
                .map(|(key, value)| format!("{key} = {}", written(value)))
                .collect();
            format!("{{ {} }}", inside.join(", "))
        }
        other => other.to_string(),
    }
}

/// A figure on the page.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// File name without extension.
    pub name: String,
    /// Heading.
    pub title: String,
    /// What it shows, in our own words.
    pub caption: String,
    /// What to look for.
    pub look_for: String,
    /// The text of the SVG file.
    pub svg: String,
}

/// What the page shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// Name of the ship.
    pub ship: String,
    /// The figures, in order.
    pub figures: Vec<Shown>,
    /// Table 1 as Markdown.
    pub table1: String,
    /// The findings as Markdown, without their heading.
    pub findings: String,
    /// The parameters in force, by table.
    pub parameters: BTreeMap<String, Value>,
    /// File name -> id of every published file that the page names.
    pub ids: BTreeMap<String, String>,
}

/// The page's look: one column, wide tables scroll, figures never wider than the screen, nothing cut in print.
const STYLE: &str = "
:root { color-scheme: light; --ink: #1c1c1c; --grey: #5f5f5f; --line: #d9d9d9; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 4rem; max-width: 72rem; color: var(--ink); background: #fff;
  font: 16px/1.55 'DejaVu Sans', Verdana, Arial, Helvetica, sans-serif; }
h1 { font-size: 1.55rem; line-height: 1.25; margin: 0 0 .3rem; }
h2 { font-size: 1.2rem; margin: 3rem 0 .6rem; padding-top: .6rem; border-top: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 2rem 0 .4rem; }
h4 { font-size: .92rem; margin: 1.6rem 0 .3rem; }
h4 + p { margin: 0; color: var(--grey); font-size: .88rem; }
p, li, figcaption { max-width: 46rem; }
a { color: #2058cc; }
nav ul { padding: 0; margin: 1rem 0 0; display: flex; flex-wrap: wrap; gap: .3rem 1.2rem; list-style: none; }
figure { margin: 0; }
figure img { display: block; max-width: 100%; height: auto; margin: 0 auto; }
figure a { display: block; overflow-x: auto; }
figcaption { margin-top: .6rem; }
.look { color: var(--grey); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; margin: .8rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .45rem; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); }
th { border-bottom: 2px solid var(--grey); }
code, pre { font: .82rem/1.5 'DejaVu Sans Mono', Menlo, Consolas, monospace; }
pre { overflow-x: auto; padding: .8rem; background: #f6f6f6; }
td code { word-break: break-all; }
.whole { white-space: nowrap; }
sub { line-height: 0; }
@media screen and (max-width: 46rem) {
  figure img { width: 46rem; max-width: none; }
}
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  nav { display: none; }
  h2, h3, h4, h4 + p { break-after: avoid; }
  figure, tr, #table1 table { break-inside: avoid; }
  figure img { max-height: 19cm; width: auto; }
  .scroll, figure a { overflow: visible; }
  table { font-size: 7.5pt; }
  pre { white-space: pre-wrap; }
}
";

/// Writes the page.
pub fn html(page: &Page) -> String {
    let mut text = String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    text.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n");
    let _ = writeln!(
        text,
        "<title>Ships encountering wave groups: {} ship</title>",
        escape(&page.ship)
    );
    let _ = writeln!(text, "<style>{STYLE}</style>\n</head>\n<body>\n<header>");
    text.push_str("<h1>Ships encountering wave groups</h1>\n");
    let _ = writeln!(
        text,
        "<p>A reproduction of X. Gong and Y. Pan, <cite>Effects of varying initial conditions of ship encountering wave groups \
         in computing extreme motion statistics</cite> (34th Symposium on Naval Hydrodynamics, 2022, \
         <a href=\"https://arxiv.org/abs/2208.12907\">arXiv 2208.12907</a>), from seeded random waves to this page. Ship: \
         <strong>{}</strong>.</p>",
        escape(&page.ship)
    );
    navigation(&mut text, page);
    text.push_str("</header>\n<main>\n");
    for shown in &page.figures {
        figure(&mut text, shown);
    }
    text.push_str(
        "<section id=\"table1\">\n<h2>Table 1: sequential and random sampling, ours beside the paper's</h2>\n",
    );
    markdown(&mut text, &page.table1);
    text.push_str(&links("table1", &["svg", "csv", "md", "tex"]));
    text.push_str("</section>\n<section id=\"findings\">\n<h2>Findings against the paper</h2>\n");
    markdown(&mut text, &page.findings);
    text.push_str(&links("findings", &["csv", "md"]));
    text.push_str("</section>\n");
    parameters(&mut text, page);
    ids(&mut text, page);
    text.push_str("</main>\n</body>\n</html>\n");
    text
}

fn navigation(text: &mut String, page: &Page) {
    text.push_str("<nav aria-label=\"Contents\"><ul>\n");
    for shown in &page.figures {
        let short = shown.title.split([':', '(']).next().unwrap_or(&shown.title).trim();
        let _ = writeln!(text, "<li><a href=\"#{}\">{}</a></li>", shown.name, escape(short));
    }
    for (id, name) in [
        ("table1", "Table 1"),
        ("findings", "Findings"),
        ("parameters", "Parameters"),
        ("ids", "Ids"),
    ] {
        let _ = writeln!(text, "<li><a href=\"#{id}\">{name}</a></li>");
    }
    text.push_str("</ul></nav>\n");
}

fn figure(text: &mut String, shown: &Shown) {
    let name = &shown.name;
    let _ = writeln!(
        text,
        "<section id=\"{name}\">\n<h2>{}</h2>\n<figure>",
        escape(&shown.title)
    );
    let (width, height) = size(&shown.svg);
    let _ = writeln!(
        text,
        "<a href=\"{name}.svg\"><img src=\"{name}.svg\" width=\"{width}\" height=\"{height}\" loading=\"lazy\" alt=\"{}\"></a>",
        // The description is escaped as it stands in the SVG.
        between(&shown.svg, "<desc>", "</desc>").replace('"', "&quot;")
    );
    let _ = writeln!(
        text,
        "<figcaption><p>{}</p>\n<p class=\"look\"><strong>What to look for.</strong> {}</p></figcaption>\n</figure>",
        emphasis(&shown.caption),
        emphasis(&shown.look_for)
    );
    text.push_str(&links(name, &["svg", "csv"]));
    text.push_str("</section>\n");
}

/// What stands between two marks, the first time; nothing if they do not stand there.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let inside = text.split_once(from).and_then(|(_, rest)| rest.split_once(to));
    inside.map_or("", |(inside, _)| inside)
}

/// Width and height of a picture, px, as its first line says.
fn size(svg: &str) -> (&str, &str) {
    (between(svg, " width=\"", "\""), between(svg, " height=\"", "\""))
}

fn links(name: &str, extensions: &[&str]) -> String {
    let all: Vec<String> = extensions
        .iter()
        .map(|e| format!("<a href=\"{name}.{e}\">{name}.{e}</a>"))
        .collect();
    format!("<p>{}</p>\n", all.join(" · "))
}

/// Our own Markdown as HTML: tables, lists of one level, paragraphs and headings but the first level's, which the section has.
fn markdown(text: &mut String, source: &str) {
    let mut lines = source.lines().peekable();
    while let Some(line) = lines.next() {
        if let Some(words) = line.strip_prefix("### ") {
            let _ = writeln!(text, "<h4>{}</h4>", emphasis(words));
        } else if let Some(words) = line.strip_prefix("## ") {
            let _ = writeln!(text, "<h3>{}</h3>", emphasis(words));
        } else if line.starts_with("| ") || line.starts_with("|--") {
            let mut rows = vec![line];
            while let Some(row) = lines.next_if(|next| next.starts_with('|')) {
                rows.push(row);
            }
            table(text, &rows);
        } else if let Some(first) = line.strip_prefix("- ") {
            let _ = write!(text, "<ul>\n<li>{}</li>\n", emphasis(first));
            while let Some(item) = lines.next_if(|next| next.starts_with("- ")) {
                let _ = writeln!(text, "<li>{}</li>", emphasis(&item[2..]));
            }
            text.push_str("</ul>\n");
        } else if !line.is_empty() && !line.starts_with('#') {
            let _ = writeln!(text, "<p>{}</p>", emphasis(line));
        }
    }
}

/// A line with `*..*` set in italics, `` `..` `` as code, and our symbols as they are printed.
fn emphasis(line: &str) -> String {
    let mut set = String::new();
    for (i, part) in escape(line).split('`').enumerate() {
        if i % 2 == 1 {
            let _ = write!(set, "<code>{part}</code>");
        } else {
            set.push_str(&symbols(&italics(part)));
        }
    }
    set
}

/// Escaped text with `*..*` set in italics; a lonely star stays.
fn italics(escaped: &str) -> String {
    let mut parts = escaped.split('*');
    let mut set = parts.next().unwrap_or_default().to_owned();
    while let Some(inside) = parts.next() {
        match parts.next() {
            Some(after) => {
                let _ = write!(set, "<em>{inside}</em>{after}");
            }
            None => {
                let _ = write!(set, "*{inside}");
            }
        }
    }
    set
}

/// The paper's symbols in words of ours, with their subscripts.
const SYMBOLS: [(&str, &str, &str); 7] = [
    ("P_true", "P", "true"),
    ("P_est", "P", "est"),
    ("P_CIC", "P", "CIC"),
    ("P_PIC", "P", "PIC"),
    ("θ_t", "θ", "t"),
    ("epsilon_1", "ε", "1"),
    ("alpha_2", "α", "2"),
];

/// Text in which every symbol is set as the figures set it.
fn symbols(text: &str) -> String {
    SYMBOLS.iter().fold(text.to_owned(), |text, (word, letter, index)| {
        text.replace(word, &format!("<i>{letter}</i><sub>{index}</sub>"))
    })
}

/// A Markdown table: its first row is the head, the second one the rule. An escaped bar is a character of no script meanwhile.
fn table(text: &mut String, rows: &[&str]) {
    let cells = |row: &str, tag: &str| {
        let inside = row
            .trim()
            .trim_start_matches('|')
            .trim_end_matches('|')
            .replace("\\|", "\u{e000}");
        let cell = |cell: &str| {
            let cell = cell.trim();
            // Numbers with their errors and short names stay on one line.
            let whole = if cell.contains('±') || cell.chars().count() < 18 {
                " class=\"whole\""
            } else {
                ""
            };
            let scope = if tag == "th" { " scope=\"col\"" } else { "" };
            format!(
                "<{tag}{whole}{scope}>{}</{tag}>",
                emphasis(cell).replace('\u{e000}', "|")
            )
        };
        inside.split('|').map(cell).collect::<String>()
    };
    let _ = writeln!(text, "{SCROLL}<table>");
    for (i, row) in rows.iter().enumerate() {
        match i {
            0 => {
                let _ = write!(text, "<thead><tr>{}</tr></thead>\n<tbody>\n", cells(row, "th"));
            }
            1 => {}
            _ => {
                let _ = writeln!(text, "<tr>{}</tr>", cells(row, "td"));
            }
        }
    }
    text.push_str("</tbody></table></div>\n");
}

/// What scrolls sideways is reached by the keyboard too.
const SCROLL: &str = "<div class=\"scroll\" role=\"region\" aria-label=\"Table\" tabindex=\"0\">";

fn parameters(text: &mut String, page: &Page) {
    text.push_str("<section id=\"parameters\">\n<h2>Parameters in force</h2>\n<p>SI units and radians. Units and sources stand in \
                   stages/paper.toml.</p>\n<pre>");
    for (name, table) in &page.parameters {
        let _ = writeln!(text, "[{name}]");
        match table {
            Value::Object(keys) => {
                // What a table leaves out is not in force.
                for (key, value) in keys.iter().filter(|(_, value)| !value.is_null()) {
                    let _ = writeln!(text, "{key} = {}", escape(&written(value)));
                }
            }
            other => {
                let _ = writeln!(text, "{}", escape(&written(other)));
            }
        }
        text.push('\n');
    }
    text.push_str("</pre>\n</section>\n");
}

fn ids(text: &mut String, page: &Page) {
    text.push_str("<section id=\"ids\">\n<h2>Ids, and how to verify them</h2>\n<p>The id of a file is the BLAKE3 hash of its bytes: \
                   <code>b3sum FILE</code> prints it. <code>encounter verify --lock</code> compares all of them, and every value \
                   behind them, with the committed lock; <code>encounter verify --rebuild</code> makes all of it again and names \
                   the first number that differs.</p>\n");
    let _ = writeln!(
        text,
        "{SCROLL}<table>\n<thead><tr><th scope=\"col\">file</th><th scope=\"col\">id</th></tr></thead>\n<tbody>"
    );
    for (file, id) in &page.ids {
        let _ = writeln!(text, "<tr><td>{}</td><td><code>{id}</code></td></tr>", escape(file));
    }
    text.push_str("</tbody></table></div>\n</section>\n");
}
