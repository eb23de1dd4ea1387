//! An SVG 1.1 font as an SVG document, whose top-level groups are its glyphs.

use crate::document;
use crate::outlines::Outlines;
use std::fmt::Write;
use usvg::roxmltree::Node;

fn number(node: Node, name: &str) -> Option<f64> {
    node.attribute(name)?.trim().parse().ok().filter(|v: &f64| v.is_finite())
}

/// `warnings` are the document, then the capitals' height (0: not given), then for each glyph its character and its advance, in the
/// font's units. Glyphs of several characters are ligatures, which single strokes do without.
pub fn read(data: &[u8]) -> Result<Outlines, String> {
    let text = document::text_of(data)?;
    let xml = document::parse(&text)?;
    let named = |name: &'static str| xml.descendants().filter(move |n| n.is_element() && n.tag_name().name() == name);
    let font = named("font").next().ok_or("holds no <font>")?;
    let face = font.children().find(|n| n.tag_name().name() == "font-face");
    let units = face.and_then(|f| number(f, "units-per-em")).unwrap_or(1000.0);
    if !(units > 0.0 && units <= 1e6) {
        return Err(format!("units-per-em is {units}; valid are numbers above 0, up to 1e6"));
    }
    let capitals = face.and_then(|f| number(f, "cap-height")).filter(|h| *h > 0.0).unwrap_or(0.0);
    let advance = number(font, "horiz-adv-x").unwrap_or(units / 2.0);
    let mut drawn = format!("<svg xmlns='http://www.w3.org/2000/svg' width='{units}' height='{units}' fill='none' stroke='black'>");
    let mut glyphs = Vec::new();
    for glyph in font.children().filter(|n| n.tag_name().name() == "glyph") {
        let mut characters = glyph.attribute("unicode").unwrap_or("").chars();
        let (Some(character), None) = (characters.next(), characters.next()) else { continue };
        // A glyph's lines may also be paths within it.
        for path in glyph.descendants().filter_map(|n| n.attribute("d")) {
            let path = path.replace(['&', '<', '\''], " ");
            let _ = write!(drawn, "<g id='glyph-{}'><path d='{path}'/></g>", character as u32);
        }
        glyphs.push(format!("{} {}", character as u32, number(glyph, "horiz-adv-x").unwrap_or(advance)));
    }
    if glyphs.is_empty() {
        return Err("its <font> holds no <glyph> of one character".to_string());
    }
    drawn.push_str("</svg>");
    let mut warnings = vec![drawn, capitals.to_string()];
    warnings.extend(glyphs);
    let mut font = Outlines::default();
    font.warnings = warnings;
    Ok(font)
}
