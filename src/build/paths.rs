//! The paths that tokens name: `a::b::c`, use trees, and paths in the strings of attributes.
//!
//! Tokens, not expressions, are scanned, so that paths inside macro calls count too.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::UseTree;
use syn::visit::Visit;

/// A path as written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Named {
    /// Its segments, without generic arguments.
    pub(crate) segments: Vec<String>,
    /// It cannot start at a module of ours: `::a::b`, or the tail of `<T>::a::b`.
    pub(crate) outside: bool,
}

/// Every path of at least two segments that the tokens name, and every path in a string of an attribute.
pub(crate) fn named_paths(stream: TokenStream) -> Vec<Named> {
    let mut found = Vec::new();
    scan(stream, &mut found);
    found
}

/// Every identifier of the tokens, in order.
pub(crate) fn identifiers(stream: TokenStream) -> Vec<String> {
    let mut found = Vec::new();
    for tree in stream {
        match tree {
            TokenTree::Ident(ident) => found.push(ident.to_string()),
            TokenTree::Group(group) => found.extend(identifiers(group.stream())),
            _ => {}
        }
    }
    found
}

/// One leaf of a `use` item: the name it binds, and the path it stands for.
#[derive(Clone, Debug)]
pub(crate) struct Import {
    /// The bound name; `*` for a glob.
    pub(crate) name: String,
    /// The path, as written; of a glob, the module.
    pub(crate) path: Vec<String>,
}

/// The imports of an item, those inside function bodies too, but not those of inline modules.
pub(crate) fn imports(item: &syn::Item) -> Vec<Import> {
    let mut visitor = Imports(Vec::new());
    visitor.visit_item(item);
    visitor.0
}

struct Imports(Vec<Import>);

impl<'ast> Visit<'ast> for Imports {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        flatten(&item.tree, &mut Vec::new(), &mut self.0);
    }

    fn visit_item_mod(&mut self, _: &'ast syn::ItemMod) {}
}

fn flatten(tree: &UseTree, prefix: &mut Vec<String>, found: &mut Vec<Import>) {
    let mut leaf = |segment: &syn::Ident, name: &syn::Ident, prefix: &[String]| {
        let mut path = prefix.to_vec();
        if segment != "self" || path.is_empty() {
            path.push(segment.to_string());
        }
        let name = if name == "self" {
            path.last().cloned().unwrap_or_default()
        } else {
            name.to_string()
        };
        found.push(Import { name, path });
    };
    match tree {
        UseTree::Path(path) => {
            prefix.push(path.ident.to_string());
            flatten(&path.tree, prefix, found);
            prefix.pop();
        }
        UseTree::Name(name) => leaf(&name.ident, &name.ident, prefix),
        UseTree::Rename(rename) => leaf(&rename.ident, &rename.rename, prefix),
        UseTree::Glob(_) => found.push(Import {
            name: "*".into(),
            path: prefix.clone(),
        }),
        UseTree::Group(group) => group.items.iter().for_each(|tree| flatten(tree, prefix, found)),
    }
}

fn scan(stream: TokenStream, found: &mut Vec<Named>) {
    let trees: Vec<TokenTree> = stream.into_iter().collect();
    let mut i = 0;
    while i < trees.len() {
        match &trees[i] {
            TokenTree::Ident(_) => {
                let outside = i >= 2 && is_double_colon(&trees, i - 2);
                i = scan_path(&trees, i, Vec::new(), outside, found);
            }
            TokenTree::Group(group) => {
                if group.delimiter() == Delimiter::Bracket && i > 0 && is_punct(&trees, i - 1, '#') {
                    scan_strings(group.stream(), found);
                }
                scan(group.stream(), found);
                i += 1;
            }
            _ => i += 1,
        }
    }
}

/// Reads the path that starts at `i`, with the use tree at its end if there is one; returns where it stops.
fn scan_path(trees: &[TokenTree], mut i: usize, prefix: Vec<String>, outside: bool, found: &mut Vec<Named>) -> usize {
    let mut segments = prefix;
    while let Some(TokenTree::Ident(ident)) = trees.get(i) {
        segments.push(ident.to_string());
        i += 1;
        if !is_double_colon(trees, i) {
            break;
        }
        i += 2;
    }
    match trees.get(i) {
        Some(TokenTree::Group(group)) if i >= 2 && is_double_colon(trees, i - 2) => {
            scan_use_group(group.stream(), &segments, outside, found);
            return i + 1;
        }
        _ => {}
    }
    if segments.last().is_some_and(|last| last == "self") && segments.len() > 1 {
        segments.pop();
    }
    if segments.len() > 1 {
        found.push(Named { segments, outside });
    }
    i
}

fn scan_use_group(stream: TokenStream, prefix: &[String], outside: bool, found: &mut Vec<Named>) {
    let trees: Vec<TokenTree> = stream.into_iter().collect();
    let mut i = 0;
    while i < trees.len() {
        let starts = i == 0 || is_punct(&trees, i - 1, ',');
        i = match &trees[i] {
            TokenTree::Ident(_) if starts => scan_path(&trees, i, prefix.to_vec(), outside, found),
            _ => i + 1,
        };
    }
}

/// The paths in string literals, such as `deserialize_with = "crate::a::b"`; here one segment is enough.
fn scan_strings(attribute: TokenStream, found: &mut Vec<Named>) {
    for tree in attribute {
        match tree {
            TokenTree::Group(group) => scan_strings(group.stream(), found),
            TokenTree::Literal(literal) => {
                let text = syn::parse_str::<syn::LitStr>(&literal.to_string()).map(|text| text.value());
                if let Some(path) = text.ok().and_then(|text| syn::parse_str::<syn::Path>(&text).ok()) {
                    found.push(Named {
                        segments: path.segments.iter().map(|segment| segment.ident.to_string()).collect(),
                        outside: path.leading_colon.is_some(),
                    });
                }
            }
            _ => {}
        }
    }
}

fn is_punct(trees: &[TokenTree], i: usize, c: char) -> bool {
    matches!(trees.get(i), Some(TokenTree::Punct(punct)) if punct.as_char() == c)
}

fn is_double_colon(trees: &[TokenTree], i: usize) -> bool {
    is_punct(trees, i, ':') && is_punct(trees, i + 1, ':')
}
