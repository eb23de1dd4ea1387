//! Completes a document by its internal DTD, which roxmltree passes over: the namespaces of
//! prefixes, and the default values of attributes (XML 1.0, section 3.3.2).

use crate::document::{self, spliced};
use std::borrow::Cow;
use usvg::roxmltree::Error;

const MOST_PREFIXES: usize = 50; // that a document does not declare itself

/// Index of the first of `stops` that stands outside quotes, comments and instructions.
fn outside(text: &str, stops: &[char]) -> Option<usize> {
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let after = |skip: usize, end: &str| rest[skip..].find(end).map(|n| skip + n + end.len());
        at += match c {
            '<' if rest.starts_with("<!--") => after(4, "-->")?,
            '<' if rest.starts_with("<?") => after(2, "?>")?,
            _ if stops.contains(&c) => return Some(at),
            '"' => after(1, "\"")?,
            '\'' => after(1, "'")?,
            _ => c.len_utf8(),
        };
    }
    None
}

/// The internal DTD, and where the root element's name ends.
fn prolog(text: &str) -> Option<(&str, usize)> {
    let mut subset = "";
    let mut at = outside(text, &['<'])?;
    if text[at..].starts_with("<!DOCTYPE") {
        at += outside(&text[at..], &['[', '>'])? + 1;
        if text[..at].ends_with('[') {
            let end = outside(&text[at..], &[']'])?;
            subset = &text[at..at + end];
            at += end + 1;
        }
        at += outside(&text[at..], &['<'])?;
    }
    let name = text[at..].find(|c: char| c.is_whitespace() || matches!(c, '>' | '/'))?;
    Some((subset, at + name))
}

/// The words of a declaration: names, quoted values with their quotes, lists in parentheses.
fn words(mut text: &str) -> Vec<&str> {
    let mut all = Vec::new();
    loop {
        text = text.trim_start();
        let Some(first) = text.chars().next() else { return all };
        let last = match first {
            '"' | '\'' => first,
            '(' => ')',
            _ => '\0',
        };
        let end = match last {
            '\0' => text.find(|c: char| c.is_whitespace() || matches!(c, '"' | '\'' | '(')),
            _ => text[1..].find(last).map(|n| n + 2),
        };
        let (word, rest) = text.split_at(end.unwrap_or(text.len()));
        all.push(word);
        text = rest;
    }
}

/// Element, attribute and quoted value of each default that the DTD declares.
fn defaults(mut subset: &str) -> Vec<(&str, &str, &str)> {
    let mut all = Vec::new();
    while let Some(start) = outside(subset, &['<']) {
        let Some(length) = outside(&subset[start + 1..], &['>']) else { break };
        let (declaration, rest) = subset[start + 1..].split_at(length);
        subset = rest;
        let Some(list) = declaration.strip_prefix("!ATTLIST") else { continue };
        let list = words(list);
        let mut next = list.iter().skip(1);
        while let (Some(name), Some(kind)) = (next.next(), next.next()) {
            if *kind == "NOTATION" {
                next.next();
            }
            let value = match next.next() {
                Some(&"#FIXED") => next.next(),
                other => other,
            };
            if let Some(value) = value.filter(|v| v.starts_with(['"', '\''])) {
                all.push((list[0], *name, *value));
            }
        }
    }
    all
}

/// The document with what its DTD adds. A prefix that is declared nowhere gets a namespace, too:
/// most programs read such files, and a drawing seldom depends on it.
pub fn completed<'a>(text: Cow<'a, str>, warnings: &mut Vec<String>) -> Cow<'a, str> {
    let Some((subset, root)) = prolog(&text) else { return text };
    let declared = defaults(subset);
    let mut added = String::new();
    let head = &text[root..root + outside(&text[root..], &['>']).unwrap_or(0)];
    if let Some((_, _, uri)) = declared.iter().find(|(e, a, _)| *a == "xmlns" && text[..root].ends_with(e)) {
        if !words(&head.replace('=', " ")).contains(&"xmlns") {
            added = format!(" xmlns={uri}");
        }
    }
    let with = |added: &str| format!("{}{added}{}", &text[..root], &text[root..]);
    let mut whole = if added.is_empty() { text.clone() } else { with(&added).into() };
    for _ in 0..MOST_PREFIXES {
        let Err(Error::UnknownNamespace(prefix, _)) = document::xml(&whole) else { break };
        let attribute = format!("xmlns:{prefix}");
        let uri = match declared.iter().find(|(_, a, _)| *a == attribute) {
            Some((_, _, uri)) => uri.to_string(),
            None => {
                warnings.push(format!("the prefix '{prefix}:' has no namespace: read as if it had one"));
                format!("\"{}\"", if prefix == "xlink" { document::XLINK } else { "urn:undeclared" })
            }
        };
        added += &format!(" {attribute}={uri}");
        whole = with(&added).into();
    }
    let plain = |name: &str| !name.starts_with("xmlns") && !name.contains(':');
    let mut inserts = Vec::new();
    if declared.iter().any(|(_, name, _)| plain(name)) {
        let Ok(xml) = document::xml(&whole) else { return whole };
        let first = xml.root_element().range().start; // an entity's text stands before
        for node in xml.descendants().filter(|n| n.is_element() && n.range().start >= first) {
            let tag = &whole[node.range().start + 1..];
            let tag = &tag[..tag.find(|c: char| c.is_whitespace() || matches!(c, '>' | '/')).unwrap_or(0)];
            for (_, name, value) in declared.iter().filter(|(e, name, _)| *e == tag && plain(name)) {
                if !node.has_attribute(*name) {
                    let at = node.range().start + 1 + tag.len();
                    inserts.push((at..at, format!(" {name}={value}")));
                }
            }
        }
    }
    if inserts.is_empty() {
        return whole;
    }
    spliced(&whole, inserts).into()
}
