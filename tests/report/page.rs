//! Claims about the page.

use std::collections::BTreeMap;

use encounter::report::page::{Page, Shown, html};
use serde_json::json;

fn page() -> Page {
    let table = json!({"fields": 16, "name": "<S1>", "list": [0.5, true], "range": {"from": 0.0}});
    Page {
        ship: "a & b".to_owned(),
        figures: vec![Shown {
            name: "fig1".to_owned(),
            title: "Figure 1: waves".to_owned(),
            caption: "A < B".to_owned(),
            look_for: "nothing".to_owned(),
            svg: "<svg width=\"960\" height=\"420\"><title>t</title><desc>Dots say &quot;truth&quot;</desc></svg>"
                .to_owned(),
        }],
        table1: "| sea | P |\n|---|---|\n| S1 | 1 \\| 2 |\n".to_owned(),
        findings:
            "# Heading\n\nAs *printed* here, `P_true`, P_true.\n\n- one\n- two\n\n## Numbers\n\n### F1: epsilon_1\n"
                .to_owned(),
        parameters: BTreeMap::from([("record".to_owned(), table)]),
        ids: BTreeMap::from([("fig1.svg".to_owned(), "ab12".to_owned())]),
    }
}

#[test]
fn every_picture_has_a_name_a_size_and_its_description() {
    let text = html(&page());
    assert!(text.contains(
        "<img src=\"fig1.svg\" width=\"960\" height=\"420\" loading=\"lazy\" alt=\"Dots say &quot;truth&quot;\">"
    ));
    assert!(text.contains("<a href=\"#fig1\">Figure 1</a>") && text.contains("<section id=\"fig1\">"));
}

#[test]
fn words_are_escaped_and_tables_kept() {
    let text = html(&page());
    assert!(text.contains("<strong>a &amp; b</strong>") && text.contains("A &lt; B"));
    assert!(
        text.contains("<td class=\"whole\">S1</td><td class=\"whole\">1 | 2</td>"),
        "{text}"
    );
    assert!(
        text.contains("<p>As <em>printed</em> here, <code>P_true</code>, <i>P</i><sub>true</sub>.</p>"),
        "{text}"
    );
    assert!(!text.contains("# Heading") && text.contains("<h3>Numbers</h3>\n<h4>F1: <i>ε</i><sub>1</sub></h4>"));
    assert!(text.contains("<ul>\n<li>one</li>\n<li>two</li>\n</ul>"));
    assert!(
        text.contains(
            "[record]\nfields = 16\nlist = [0.5, true]\nname = &quot;&lt;S1&gt;&quot;\nrange = { from = 0.0 }\n"
        ),
        "{text}"
    );
    assert!(text.contains("<tr><td>fig1.svg</td><td><code>ab12</code></td></tr>"));
}

#[test]
fn the_page_needs_nothing_from_elsewhere() {
    let text = html(&page());
    for word in ["<script", "http://", "src=\"http", "@import", "url("] {
        assert!(!text.contains(word), "{word}");
    }
    // The one address is that of the paper, in a link.
    assert_eq!(text.matches("https://").count(), 1);
    let opened = |tag: &str| text.matches(&format!("<{tag}>")).count() + text.matches(&format!("<{tag} ")).count();
    for tag in [
        "section", "table", "figure", "ul", "p", "main", "html", "div", "li", "tr",
    ] {
        assert_eq!(opened(tag), text.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}
