//! Prepares the document for usvg: character encoding, numbers, layers.

use crate::{labels, transforms};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use usvg::roxmltree::{Document, Error, Node, ParsingOptions};

const MOST_NODES: u32 = 2_000_000;
const DEEPEST: usize = 1000; // nesting of elements; usvg's limit is 1,024
const LARGEST: f64 = 1e30; // magnitude of a number, within single precision
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";
pub const XLINK: &str = "http://www.w3.org/1999/xlink";

/// Decodes UTF-8, UTF-16 with a byte order mark, or Latin-1 if the XML declaration says so.
pub fn text_of(data: &[u8]) -> Result<Cow<'_, str>, String> {
    let utf16 = |from: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = data[2..].chunks_exact(2).map(|two| from([two[0], two[1]])).collect();
        String::from_utf16(&units).map(Cow::from).map_err(|_| "not a UTF-16 text".to_string())
    };
    if data.starts_with(&[0xff, 0xfe]) {
        return utf16(u16::from_le_bytes);
    }
    if data.starts_with(&[0xfe, 0xff]) {
        return utf16(u16::from_be_bytes);
    }
    std::str::from_utf8(data).map(Cow::from).or_else(|_| {
        let head = String::from_utf8_lossy(&data[..data.len().min(200)]).to_ascii_lowercase();
        let latin = head.starts_with("<?xml") && ["iso-8859-1", "latin1", "windows-1252", "us-ascii"].iter().any(|e| head.contains(e));
        let decoded = || Cow::from(data.iter().map(|&byte| byte as char).collect::<String>());
        latin.then(decoded).ok_or("not a UTF-8 text".to_string())
    })
}

pub fn xml(text: &str) -> Result<Document<'_>, Error> {
    Document::parse_with_options(text, ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..Default::default() })
}

pub fn parse(text: &str) -> Result<Document<'_>, String> {
    let xml = xml(text).map_err(|e| e.to_string())?;
    if xml.root_element().tag_name().name() != "svg" {
        return Err(format!("the root element is <{}>, not <svg>", xml.root_element().tag_name().name()));
    }
    Ok(xml)
}

fn line_of(xml: &Document, node: Node) -> u32 {
    xml.text_pos_at(node.range().start).row
}

/// Rejects invalid numbers. usvg would skip the element, and a line would be missing.
pub fn check(xml: &Document) -> Result<(), String> {
    let mut depth = 0;
    let mut last: Option<Node> = None;
    for node in xml.descendants() {
        // In document order, an element is one deeper than its parent.
        depth = match last {
            Some(before) if node.parent() == Some(before) => depth + 1,
            Some(before) => {
                let up = before.ancestors().take_while(|n| Some(*n) != node.parent()).count();
                depth + 1 - up
            }
            None => 0,
        };
        last = Some(node);
        if depth > DEEPEST {
            return Err(format!("line {}: nested more than {DEEPEST} elements deep", line_of(xml, node)));
        }
        if !node.is_element() {
            continue;
        }
        for attribute in node.attributes().filter(|a| a.namespace().is_none()) {
            if let Some(fault) = fault_of(attribute.name(), attribute.value()) {
                let tag = node.tag_name().name();
                return Err(format!("line {}: <{tag}> {}: {fault}", line_of(xml, node), attribute.name()));
            }
        }
    }
    Ok(())
}

/// Rejects a `use` that refers to itself, directly or through others: it would be drawn forever.
/// Searches for a cycle in the graph of child and `use` references.
pub fn check_uses(xml: &Document) -> Result<(), String> {
    let by_id: HashMap<&str, Node> = xml.descendants().filter_map(|n| Some((n.attribute("id")?, n))).collect();
    let shown = |node: Node| {
        let href = node.attribute("href").or(node.attribute((XLINK, "href")))?;
        (node.tag_name().name() == "use").then_some(())?;
        by_id.get(href.trim().strip_prefix('#')?).copied()
    };
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        New,
        Open,
        Done,
    }
    let mut states = vec![State::New; xml.descendants().count() + 1];
    let mut stack = vec![(xml.root(), false)];
    while let Some((node, left)) = stack.pop() {
        let state = &mut states[node.id().get_usize()];
        if left {
            *state = State::Done;
            continue;
        }
        match *state {
            State::Done => continue,
            State::Open => return Err(format!("line {}: a <use> leads back to the element that it stands in", line_of(xml, node))),
            State::New => *state = State::Open,
        }
        stack.push((node, true));
        stack.extend(node.children().chain(shown(node)).filter(|n| n.is_element()).map(|n| (n, false)));
    }
    Ok(())
}

fn is_length(name: &str) -> bool {
    matches!(name, "x" | "y" | "width" | "height" | "cx" | "cy" | "r" | "rx" | "ry" | "x1" | "y1" | "x2" | "y2")
}

fn fault_of(name: &str, value: &str) -> Option<String> {
    let many = matches!(name, "d" | "points" | "transform" | "viewBox");
    if !many && !is_length(name) {
        return None;
    }
    let word = |w: &str| value.as_bytes().windows(3).any(|three| three.eq_ignore_ascii_case(w.as_bytes()));
    if word("nan") || word("inf") {
        return Some("holds what is not a finite number".to_string());
    }
    if value.contains(['e', 'E']) {
        let number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | 'e' | 'E');
        let too_large = value.split(|c| !number(c)).find(|n| n.parse().is_ok_and(|v: f64| v.abs() > LARGEST));
        return too_large.map(|n| format!("holds {n}, beyond ± {LARGEST:e}"));
    }
    None
}

/// The texts of the document's style elements.
pub fn style_sheets<'a, 'i>(xml: &'a Document<'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    xml.descendants().filter(|n| n.is_text() && n.parent().is_some_and(|p| p.tag_name().name() == "style"))
}

/// Puts into usvg's words what it does not know: lengths in quarter-millimetres (40Q, a CSS unit),
/// transforms of CSS, labels in HTML, and declarations without a value, behind which it would read none. None: the
/// document has none.
pub fn in_known_words(text: &str, xml: &Document) -> Option<String> {
    let mut inserts: Vec<_> = labels::of(xml).filter_map(|label| Some((label.range(), labels::as_text(label)?))).collect();
    let in_label = |n: &Node| n.ancestors().any(|a| a.tag_name().name() == "foreignObject");
    let has_labels = !inserts.is_empty();
    for attribute in xml.descendants().filter(|n| !has_labels || !in_label(n)).flat_map(|n| n.attributes()).filter(|a| a.namespace().is_none()) {
        if attribute.name() == "style" {
            let has_value = |part: &&str| part.split_once(':').is_none_or(|(_, value)| !value.trim().is_empty());
            let kept = attribute.value().split(';').filter(has_value).collect::<Vec<_>>().join(";");
            let kept = transforms::rewritten(&kept);
            let within = attribute.range_value();
            if kept != attribute.value() && text.get(within.clone()) == Some(attribute.value()) {
                inserts.push((within, kept));
            }
            continue;
        }
        let length = is_length(attribute.name()) || matches!(attribute.name(), "stroke-width" | "stroke-dashoffset" | "font-size");
        let value = attribute.value().trim();
        let Some(number) = value.strip_suffix(['Q', 'q']).filter(|_| length) else { continue };
        let within = attribute.range_value();
        if let (Ok(quarters), true) = (number.parse::<f64>(), text.get(within.clone()) == Some(attribute.value())) {
            inserts.push((within, format!("{:e}mm", quarters / 4.0)));
        }
    }
    for sheet in style_sheets(xml) {
        let css = sheet.text().unwrap_or_default();
        let plain = transforms::rewritten(css);
        let within = sheet.range();
        // An entity's or a CDATA section's text stands elsewhere, or is longer in the document.
        if let (true, Some(at)) = (plain != css, text.get(within.clone()).and_then(|all| all.find(css))) {
            inserts.push((within.start + at..within.start + at + css.len(), plain));
        }
    }
    if inserts.is_empty() {
        return None;
    }
    inserts.sort_by_key(|(at, _)| at.start);
    Some(spliced(text, inserts))
}

/// The text with each range, in order, replaced.
pub fn spliced(text: &str, changes: Vec<(Range<usize>, String)>) -> String {
    let mut changed = String::with_capacity(text.len() + 40 * changes.len());
    let mut from = 0;
    for (within, value) in changes {
        changed.push_str(&text[from..within.start]);
        changed.push_str(&value);
        from = within.end;
    }
    changed.push_str(&text[from..]);
    changed
}

/// Groups at the top of the document. Illustrator puts its own inside a switch and a group that it
/// calls extraneous.
fn layer_groups<'a, 'i>(within: Node<'a, 'i>, found: &mut Vec<(usize, Node<'a, 'i>)>) {
    for (index, node) in within.children().filter(|n| n.is_element()).enumerate() {
        let tag = node.tag_name().name();
        if tag == "switch" || (tag == "g" && node.attributes().any(|a| a.name() == "extraneous")) {
            layer_groups(node, found);
        } else if tag == "g" {
            found.push((index + 1, node));
        }
    }
}

/// What usvg does not hand on.
#[derive(Default)]
pub struct Marked {
    pub layers: HashMap<String, String>, // names, by id: Inkscape's label, the author's id, or a number
    pub named: bool, // a layer has a name of the author's
    pub lengths: Vec<f64>,               // each pathLength of the document
}

/// A miter limit from here on counts the lengths: usvg gives every copy of a path its miter limit,
/// which a pen has no use for, but not its id.
pub const FIRST_LENGTH: usize = 1_000_000;

/// Gives every layer an id, and every path with a pathLength its mark. The text is None if nothing
/// had to be added.
pub fn marked(text: &str, xml: &Document) -> (Option<String>, Marked) {
    let mut groups = Vec::new();
    layer_groups(xml.root_element(), &mut groups);
    let mut marked = Marked::default();
    let mut inserts = Vec::new();
    let taken: HashSet<&str> = xml.descendants().filter_map(|n| n.attribute("id")).collect();
    let first = xml.root_element().range().start; // an entity's text stands before
    let after_name = |node: Node| {
        let start = node.range().start + 1;
        let at = start + text[start..].find(|c: char| c.is_whitespace() || matches!(c, '>' | '/')).unwrap_or(0);
        at..at
    };
    for (place, group) in groups {
        let label = group.attribute((INKSCAPE, "label"));
        marked.named |= label.is_some() || group.has_attribute("id");
        match group.attribute("id").filter(|id| !id.is_empty()) {
            Some(id) => {
                marked.layers.insert(id.to_string(), label.unwrap_or(id).to_string());
            }
            // not beside an empty id
            None if group.range().start > first && !group.has_attribute("id") => {
                let mut id = format!("layer-{place}-at-{}", group.range().start + 1);
                while taken.contains(id.as_str()) {
                    id.push('_');
                }
                inserts.push((after_name(group), format!(" id=\"{id}\"")));
                marked.layers.insert(id, label.map_or(place.to_string(), str::to_string));
            }
            None => {}
        }
    }
    for node in xml.descendants().filter(|n| n.is_element() && n.range().start > first) {
        let length = node.attribute("pathLength").and_then(|l| l.trim().parse::<f64>().ok());
        let Some(length) = length.filter(|l| l.is_finite() && *l >= 0.0) else { continue };
        let limit = format!("stroke-miterlimit:{}", FIRST_LENGTH + marked.lengths.len());
        match node.attribute_node("style") {
            Some(style) => inserts.push((style.range_value().end..style.range_value().end, format!(";{limit}"))),
            None => inserts.push((after_name(node), format!(" style=\"{limit}\""))),
        }
        marked.lengths.push(length);
    }
    inserts.sort_by_key(|(at, _)| at.start);
    ((!inserts.is_empty()).then(|| spliced(text, inserts)), marked)
}

/// How the reference of a picture begins that is itself an SVG.
pub const DRAWING: &str = "data:image/svg+xml";

/// Elements with this tag. A picture that is an SVG counts for none.
pub fn count(xml: &Document, tag: &str) -> usize {
    let is_drawing = |n: Node| n.attributes().any(|a| a.name() == "href" && a.value().trim_start().starts_with(DRAWING));
    xml.descendants().filter(|n| n.is_element() && n.tag_name().name() == tag && !is_drawing(*n)).count()
}
