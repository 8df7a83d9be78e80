//! A reader of SVG, small enough to be trusted, and what every document must satisfy.

/// The attributes and inner text of the document's elements: (name, attributes, text right behind the opening tag).
pub(crate) struct Element {
    pub(crate) name: String,
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) text: String,
}

impl Element {
    /// An attribute's value.
    pub(crate) fn attribute(&self, wanted: &str) -> Option<&str> {
        self.attributes
            .iter()
            .find(|(name, _)| name == wanted)
            .map(|(_, value)| value.as_str())
    }
}

/// Reads every element, checking that tags balance and that text holds no raw `<` or lonely `&`.
pub(crate) fn elements(svg: &str) -> Vec<Element> {
    let mut open: Vec<String> = Vec::new();
    let mut group: Vec<(String, String)> = Vec::new();
    let mut found = Vec::new();
    for piece in svg.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("every tag is closed");
        for entity in text.split('&').skip(1) {
            let name = entity.split(';').next().unwrap_or_default();
            assert!(
                ["lt", "gt", "amp", "quot", "apos"].contains(&name),
                "unknown entity in {text}"
            );
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "tags balance");
            if name == "g" {
                group.clear();
            }
            continue;
        }
        let body = tag.trim_end_matches('/');
        let (name, rest) = body.split_once(' ').unwrap_or((body, ""));
        let mut attributes = Vec::new();
        let mut parts = rest.split('"');
        while let (Some(key), Some(value)) = (parts.next(), parts.next()) {
            attributes.push((key.trim().trim_end_matches('=').to_owned(), value.to_owned()));
        }
        if name == "g" {
            group.clone_from(&attributes);
        } else if !["text", "tspan"].contains(&name) {
            attributes.extend(
                group
                    .iter()
                    .filter(|(key, _)| ["fill", "stroke"].contains(&key.as_str()))
                    .cloned(),
            );
        }
        found.push(Element {
            name: name.to_owned(),
            attributes,
            text: text.to_owned(),
        });
        if !tag.ends_with('/') {
            open.push(name.to_owned());
        }
    }
    assert!(open.is_empty(), "every tag is closed, but {open:?}");
    found
}

/// The document's words without its tags, one line for each `<text>`.
pub(crate) fn words(svg: &str) -> Vec<String> {
    let mut words = Vec::new();
    for piece in svg.split("<text").skip(1) {
        let inside = piece.split_once('>').expect("tags are closed").1;
        let inside = inside.split("</text>").next().unwrap_or_default();
        let mut word = String::new();
        let mut hidden = false;
        for c in inside.chars() {
            match c {
                '<' => hidden = true,
                '>' => hidden = false,
                c if !hidden => word.push(c),
                _ => {}
            }
        }
        words.push(plain(&word));
    }
    words
}

/// How many elements of a name the document has.
pub(crate) fn count(svg: &str, name: &str) -> usize {
    elements(svg).iter().filter(|element| element.name == name).count()
}

/// How many shapes are stroked in a colour.
pub(crate) fn stroked(svg: &str, colour: &str) -> usize {
    let all = elements(svg);
    all.iter()
        .filter(|element| element.name != "g" && element.attribute("stroke") == Some(colour))
        .count()
}

/// What every published figure must satisfy.
pub(crate) fn check(svg: &str) {
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
    assert!(
        !svg.contains("NaN") && !svg.contains("inf\"") && !svg.contains("inf,"),
        "every coordinate is finite"
    );
    let all = elements(svg);
    assert_eq!(all[0].name, "svg");
    assert_eq!(all[1].name, "title", "the title comes first");
    assert_eq!(all[2].name, "desc", "then the description");
    assert!(all[1].text.len() > 10 && all[2].text.len() > 40);
    assert!(
        all[0]
            .attribute("font-family")
            .expect("fonts are named")
            .starts_with("'DejaVu Sans'")
    );
    let view: Vec<f64> = all[0]
        .attribute("viewBox")
        .expect("there is a view box")
        .split(' ')
        .map(number)
        .collect();
    for element in &all {
        for key in ["x", "x1", "x2", "cx"] {
            assert_within(element.attribute(key), view[2], element);
        }
        for key in ["y", "y1", "y2", "cy"] {
            assert_within(element.attribute(key), view[3], element);
        }
        for point in element.attribute("points").unwrap_or_default().split_whitespace() {
            let (x, y) = point.split_once(',').expect("points are pairs");
            assert_within(Some(x), view[2], element);
            assert_within(Some(y), view[3], element);
        }
    }
    assert_words_fit(&all, view[2]);
}

/// Horizontal text ends within the sheet, by the estimated width.
fn assert_words_fit(all: &[Element], width: f64) {
    for element in all
        .iter()
        .filter(|element| element.name == "text" && element.attribute("transform").is_none())
    {
        let size = number(element.attribute("font-size").expect("text has a size")) / 10.0;
        let long = 10.0 * encounter::plot::svg::text_width(&plain(&element.text), size);
        let x = number(element.attribute("x").expect("text has a place"));
        let (left, right) = match element.attribute("text-anchor") {
            Some("middle") => (x - long / 2.0, x + long / 2.0),
            Some("end") => (x - long, x),
            _ => (x, x + long),
        };
        assert!(
            left >= 0.0 && right <= width,
            "\"{}\" leaves the sheet: {left} to {right} of {width}",
            element.text
        );
    }
}

/// Text with its entities resolved.
fn plain(text: &str) -> String {
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
    text.replace("&apos;", "'").replace("&amp;", "&")
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

fn assert_within(value: Option<&str>, bound: f64, element: &Element) {
    let Some(value) = value.map(number) else { return };
    assert!(
        (0.0..=bound).contains(&value),
        "{} at {value} leaves the sheet of {bound}",
        element.name
    );
}

#[test]
#[should_panic(expected = "tags balance")]
fn the_reader_refuses_what_is_not_balanced() {
    elements("<svg><g></svg>");
}

#[test]
#[should_panic(expected = "unknown entity")]
fn the_reader_refuses_a_lonely_ampersand() {
    elements("<svg><text>a & b</text></svg>");
}
