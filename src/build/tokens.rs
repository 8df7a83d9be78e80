//! The normal form of a source file: its tokens without what cannot change a result.
//!
//! Dropped: comments, doc attributes, items under `#[cfg(test)]`, and the trailing commas that rustfmt adds and removes
//! when it breaks a line. Tested on toy sources in `tests/invalidation.rs`.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Attribute, ImplItem, Item, TraitItem};

/// Parses a file and removes the items under `#[cfg(test)]`, at every depth of modules, impls and traits.
pub(crate) fn parse(text: &str) -> syn::Result<syn::File> {
    let mut file = syn::parse_file(text)?;
    drop_tests(&mut file.items);
    Ok(file)
}

/// The BLAKE3 of the normal form, in hex.
pub(crate) fn token_hash(file: &syn::File) -> String {
    let mut normal = Vec::new();
    let trees: Vec<TokenTree> = file.to_token_stream().into_iter().collect();
    write(&trees, &mut normal);
    blake3::hash(&normal).to_hex().to_string()
}

/// The BLAKE3 of the file as it is on disk, in hex.
pub(crate) fn byte_hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

fn drop_tests(items: &mut Vec<Item>) {
    items.retain(|item| !is_test(attributes(item)));
    for item in items {
        match item {
            Item::Mod(module) => {
                if let Some((_, content)) = &mut module.content {
                    drop_tests(content);
                }
            }
            Item::Impl(block) => block.items.retain(|item| match item {
                ImplItem::Const(it) => !is_test(&it.attrs),
                ImplItem::Fn(it) => !is_test(&it.attrs),
                ImplItem::Type(it) => !is_test(&it.attrs),
                _ => true,
            }),
            Item::Trait(block) => block.items.retain(|item| match item {
                TraitItem::Const(it) => !is_test(&it.attrs),
                TraitItem::Fn(it) => !is_test(&it.attrs),
                TraitItem::Type(it) => !is_test(&it.attrs),
                _ => true,
            }),
            _ => {}
        }
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(it) => &it.attrs,
        Item::Enum(it) => &it.attrs,
        Item::Fn(it) => &it.attrs,
        Item::Impl(it) => &it.attrs,
        Item::Macro(it) => &it.attrs,
        Item::Mod(it) => &it.attrs,
        Item::Static(it) => &it.attrs,
        Item::Struct(it) => &it.attrs,
        Item::Trait(it) => &it.attrs,
        Item::Type(it) => &it.attrs,
        Item::Use(it) => &it.attrs,
        _ => &[],
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg") && attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "test")
    })
}

/// Appends the normal form of a stream: per token a kind, and a length before every text.
fn write(trees: &[TokenTree], normal: &mut Vec<u8>) {
    let mut i = 0;
    while i < trees.len() {
        let doc = doc_length(&trees[i..]);
        if doc > 0 {
            i += doc;
            continue;
        }
        match &trees[i] {
            TokenTree::Group(group) => {
                let is_call = i > 0 && matches!(&trees[i - 1], TokenTree::Ident(name) if !is_keyword(name));
                normal.push(opening(group.delimiter()));
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                write(without_last_comma(&inner, group.delimiter(), is_call), normal);
                normal.push(b'e');
            }
            TokenTree::Ident(ident) => write_text(b'i', &ident.to_string(), normal),
            TokenTree::Literal(literal) => write_text(b'l', &literal.to_string(), normal),
            TokenTree::Punct(punct) => {
                normal.push(if punct.spacing() == Spacing::Joint { b'j' } else { b'p' });
                normal.push(punct.as_char() as u8);
            }
        }
        i += 1;
    }
}

fn write_text(kind: u8, text: &str, normal: &mut Vec<u8>) {
    normal.push(kind);
    normal.extend((text.len() as u64).to_le_bytes());
    normal.extend(text.as_bytes());
}

fn opening(delimiter: Delimiter) -> u8 {
    match delimiter {
        Delimiter::Parenthesis => b'(',
        Delimiter::Brace => b'{',
        Delimiter::Bracket => b'[',
        Delimiter::None => b'n',
    }
}

/// How many tokens the doc attribute at the head takes; 0 if there is none.
fn doc_length(trees: &[TokenTree]) -> usize {
    let is_punct = |i: usize, c: char| matches!(trees.get(i), Some(TokenTree::Punct(p)) if p.as_char() == c);
    if !is_punct(0, '#') {
        return 0;
    }
    let at = if is_punct(1, '!') { 2 } else { 1 };
    match trees.get(at) {
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Bracket && is_doc(group.stream()) => at + 1,
        _ => 0,
    }
}

fn is_doc(attribute: TokenStream) -> bool {
    matches!(attribute.into_iter().next(), Some(TokenTree::Ident(name)) if name == "doc")
}

/// The content of a group without its trailing comma, unless that comma makes the tuple `(a,)`.
fn without_last_comma(inner: &[TokenTree], delimiter: Delimiter, is_call: bool) -> &[TokenTree] {
    let is_comma = |tree: &TokenTree| matches!(tree, TokenTree::Punct(punct) if punct.as_char() == ',');
    match inner.split_last() {
        Some((last, rest)) if is_comma(last) => {
            let is_list = delimiter != Delimiter::Parenthesis || is_call || rest.iter().any(is_comma);
            if is_list { rest } else { inner }
        }
        _ => inner,
    }
}

/// Words after which a parenthesis is no call.
fn is_keyword(name: &proc_macro2::Ident) -> bool {
    [
        "as", "break", "dyn", "else", "for", "if", "impl", "in", "let", "match", "move", "mut", "ref", "return",
        "where", "while",
    ]
    .iter()
    .any(|word| name == word)
}
