//! Labels in HTML, as Mermaid and draw.io write them: what is one plain text becomes SVG's.

use usvg::roxmltree::{Document, Node};

const BLOCKS: [&str; 4] = ["p", "div", "br", "li"]; // that begin a line

/// The elements that hold words and no drawing beside them in a switch stands for.
pub fn of<'a, 'i>(xml: &'a Document<'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let alone = |n: &Node| n.parent().is_none_or(|p| p.tag_name().name() != "switch" || p.children().all(|c| c == *n || !c.is_element()));
    let has_words = |n: &Node| n.descendants().any(|t| t.is_text() && t.text().is_some_and(|t| !t.trim().is_empty()));
    xml.descendants().filter(move |n| n.tag_name().name() == "foreignObject" && alone(n) && has_words(n))
}

/// What the last element within declares.
fn declared<'a>(label: Node<'a, '_>, name: &str) -> Option<&'a str> {
    let styles = label.descendants().filter_map(|n| n.attribute("style"));
    let pairs = styles.flat_map(|style| style.split(';')).filter_map(|part| part.split_once(':'));
    pairs.filter(|(key, _)| key.trim() == name).map(|(_, value)| value.trim()).last()
}

/// The label as SVG's text, in the middle of its box. None: it is not as high as its lines, as where
/// it is wrapped.
pub fn as_text(label: Node) -> Option<String> {
    let length = |name| label.attribute(name).unwrap_or("0").trim_end_matches("px").parse::<f64>().ok();
    let (x, y, width, height) = (length("x")?, length("y")?, length("width")?, length("height")?);
    let mut lines = vec![String::new()];
    for node in label.descendants() {
        if BLOCKS.contains(&node.tag_name().name()) && lines.last().is_some_and(|line| !line.is_empty()) {
            lines.push(String::new());
        }
        let words = node.text().filter(|_| node.is_text()).unwrap_or("");
        lines.last_mut()?.extend(words.split_whitespace().flat_map(|word| [word, " "]));
    }
    lines.retain(|line| !line.is_empty());
    let size = declared(label, "font-size").and_then(|size| size.trim_end_matches("px").parse().ok()).unwrap_or(16.0);
    let spacing = declared(label, "line-height").and_then(|l| l.parse().ok()).unwrap_or(1.15);
    if (height / (size * spacing) - lines.len() as f64).abs() > 0.5 {
        return None;
    }
    let fits = declared(label, "display") == Some("table-cell"); // as wide as its words
    let (anchor, x) = match declared(label, "text-align").filter(|_| !fits) {
        Some("center") => ("middle", x + width / 2.0),
        Some("right") => ("end", x + width),
        _ => ("start", x),
    };
    // Browsers set lines on whole pixels; ascent and descent are those of sans-serif.
    let (ascent, descent) = ((0.905 * size as f64).round(), (0.212 * size as f64).round());
    let first = height / 2.0 - size * spacing * lines.len() as f64 / 2.0 + ((size * spacing - ascent - descent) / 2.0).floor() + ascent;
    let style = [("font-family", "font-family"), ("font-weight", "font-weight"), ("color", "fill"), ("font-size", "font-size")];
    let style: String = style.iter().filter_map(|(css, svg)| Some(format!("{svg}:{};", declared(label, css)?.replace(['"', '<', '&'], "")))).collect();
    let text = |(at, line): (usize, &String)| {
        let y = y + first + size * spacing * at as f64;
        let line = line.trim().replace('&', "&amp;").replace('<', "&lt;");
        format!("<text x='{x}' y='{y}' style=\"text-anchor:{anchor};stroke:none;{style}\">{line}</text>")
    };
    Some(lines.iter().enumerate().map(text).collect())
}
