//! What a document refers to, but does not hold: told, since usvg passes over it in silence.

use crate::document::XLINK;
use std::collections::{BTreeMap, HashMap};
use usvg::roxmltree::{Document, Node};

const MOST: usize = 8; // lines

/// The targets of `url(…)` in a value or a style sheet, each with the property before it. Not those
/// with a colour beside them, which then counts.
fn urls(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.match_indices("url(").filter_map(move |(at, word)| {
        let after = &text[at + word.len()..];
        let target = after[..after.find(')')?].trim_matches(|c: char| c.is_whitespace() || c == '"' || c == '\'');
        let beside = after[after.find(')')? + 1..].split([';', '}', '!']).next().unwrap_or("").trim();
        if !matches!(beside, "" | "none") {
            return None;
        }
        let before = text[..at].rfind([';', '{']).map_or(0, |end| end + 1);
        let property = text[before..at].split(':').next().unwrap_or("").trim();
        Some((property, target))
    })
}

fn consequence(of: &str) -> Option<&'static str> {
    match of {
        "fill" | "stroke" => Some("not painted"),
        "clip-path" | "mask" | "filter" | "<linearGradient>" | "<radialGradient>" | "<pattern>" => Some("passed over"),
        "<use>" | "<textPath>" | "<tref>" => Some("left out"),
        _ => None,
    }
}

/// A gradient without stops or a pattern without contents paints nothing.
fn is_empty(server: Node) -> bool {
    let hollow = matches!(server.tag_name().name(), "linearGradient" | "radialGradient" | "pattern");
    let inherits = server.attributes().any(|a| a.name() == "href");
    hollow && !inherits && !server.children().any(|n| n.is_element())
}

/// One line for each thing that is missing and for each way in which it is referred to.
pub fn missing(xml: &Document) -> Vec<String> {
    let by_id: HashMap<&str, Node> = xml.descendants().filter_map(|n| Some((n.attribute("id")?, n))).collect();
    let mut counts = BTreeMap::<(String, String, &str), usize>::new();
    let mut check = |of: &str, target: &str| {
        let held = target.strip_prefix('#').and_then(|id| by_id.get(id));
        let fault = match held {
            None => "which the file does not hold",
            Some(server) if is_empty(*server) => "which is empty",
            Some(_) => return,
        };
        if consequence(of).is_some() {
            *counts.entry((of.to_string(), target.chars().take(60).collect(), fault)).or_default() += 1;
        }
    };
    for node in xml.descendants().filter(|n| n.is_element()) {
        let tag = node.tag_name().name();
        let href = node.attributes().find(|a| a.name() == "href" && a.namespace().is_none());
        if let Some(href) = href.map(|a| a.value()).or(node.attribute((XLINK, "href"))) {
            check(&format!("<{tag}>"), href.trim());
        }
        for attribute in node.attributes().filter(|a| a.namespace().is_none() && a.value().contains("url(")) {
            for (property, target) in urls(attribute.value()) {
                check(if attribute.name() == "style" { property } else { attribute.name() }, target);
            }
        }
        if tag == "style" {
            for (property, target) in node.children().filter_map(|n| n.text()).flat_map(urls) {
                check(property, target);
            }
        }
    }
    let more = counts.len().saturating_sub(MOST);
    let line = |((of, target, fault), times): ((String, String, &str), usize)| {
        format!("{times} × {of} refers to '{target}', {fault}: {}", consequence(&of).unwrap_or(""))
    };
    let mut lines: Vec<String> = counts.into_iter().take(MOST).map(line).collect();
    lines.extend((more > 0).then(|| format!("{more} more references to what the file does not hold")));
    lines
}

/// True if the document names a style sheet of another file: it is not read.
pub fn has_outer_style(xml: &Document) -> bool {
    let imports = |n: Node| n.tag_name().name() == "style" && n.children().filter_map(|c| c.text()).any(|t| t.contains("@import"));
    xml.descendants().any(|n| n.pi().is_some_and(|pi| pi.target == "xml-stylesheet") || imports(n))
}
