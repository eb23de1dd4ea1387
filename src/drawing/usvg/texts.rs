//! Text: the fonts that it is set in, and its letters as outlines or for single strokes.

use crate::outlines::{Outlines, SvgPath};
use crate::paints;
use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};
use std::sync::Arc;
use usvg::layout::PositionedGlyph;
use usvg::tiny_skia_path::PathBuilder;
use usvg::{fontdb, Font, FontFamily, FontResolver, Path, Text, Transform};

/// The system's fonts. Each generic family name maps to an installed font.
pub fn fonts() -> fontdb::Database {
    let mut fonts = fontdb::Database::new();
    fonts.load_system_fonts();
    let families: Vec<String> = fonts.faces().flat_map(|face| face.families.iter().map(|f| f.0.clone())).collect();
    let first_of = |wanted: [&str; 4]| {
        let found = wanted.iter().find(|w| families.iter().any(|f| f == *w));
        found.map(|w| w.to_string()).or(families.first().cloned())
    };
    let serif = first_of(["Times New Roman", "Liberation Serif", "DejaVu Serif", "Noto Serif"]);
    let sans = first_of(["Arial", "Liberation Sans", "DejaVu Sans", "Noto Sans"]);
    let mono = first_of(["Courier New", "Liberation Mono", "DejaVu Sans Mono", "Noto Sans Mono"]);
    fonts.set_serif_family(serif.clone().unwrap_or_default());
    fonts.set_sans_serif_family(sans.clone().unwrap_or_default());
    fonts.set_monospace_family(mono.clone().unwrap_or_default());
    // Names of one kind stand for its font, as browsers have it: Liberation's letters are as wide.
    for (family, others) in [(sans, ["Arial", "Helvetica"]), (serif, ["Times New Roman", "Times"]), (mono, ["Courier New", "Courier"])] {
        let own: Vec<_> = fonts.faces().filter(|face| face.families.iter().any(|f| Some(&f.0) == family.as_ref())).cloned().collect();
        let missing = others.iter().filter(|other| !families.iter().any(|f| f == *other));
        for (mut face, other) in own.into_iter().flat_map(|face| missing.clone().map(move |other| (face.clone(), other))) {
            face.families.push((other.to_string(), fontdb::Language::Unknown));
            fonts.push_face_info(face);
        }
    }
    fonts
}

/// usvg's choice of a font; says so if it is not the one that the document names first.
pub fn select_font(font: &Font, fonts: &mut Arc<fontdb::Database>) -> Option<fontdb::ID> {
    let id = FontResolver::default_font_selector()(font, fonts)?;
    let generic = matches!(font.families()[0], FontFamily::Serif | FontFamily::SansSerif | FontFamily::Monospace);
    let wanted = match &font.families()[0] {
        FontFamily::Named(name) => name.clone(),
        other => other.to_string(),
    };
    let names = &fonts.face(id)?.families;
    if !generic && names.iter().all(|(name, language)| *name != wanted || *language == fontdb::Language::Unknown) {
        log::warn!(target: "usvg", "the font '{wanted}' is not installed: replaced by '{}'", names[0].0);
    }
    Some(id)
}

/// Advance and height of the capitals, in the font's units.
fn measures(glyph: &PositionedGlyph, fonts: &fontdb::Database) -> Option<(f32, f32)> {
    fonts.with_face_data(glyph.font, |data, index| {
        let font = FontRef::from_index(data, index).ok()?;
        let metrics = font.metrics(Size::unscaled(), LocationRef::default());
        let glyphs = font.glyph_metrics(Size::unscaled(), LocationRef::default());
        let advance = glyphs.advance_width(skrifa::GlyphId::new(glyph.id.0 as u32))?;
        let of_h = font.charmap().map('H').and_then(|h| glyphs.bounds(h)).map(|box_| box_.y_max); // DejaVu tells no cap_height
        let height = of_h.or(metrics.cap_height).filter(|h| *h > 0.0);
        Some((advance, height.unwrap_or(0.7 * metrics.units_per_em as f32)))
    })?
}

fn is_mark(c: char) -> bool {
    ('\u{300}'..='\u{36f}').contains(&c)
}

impl Outlines {
    pub fn add_text<'a>(&mut self, text: &'a Text, ts: Transform, layer: Option<&'a str>, clip: u32) {
        let before = self.paths.len();
        if self.fonts.is_some() {
            self.add_letters(text, ts, layer, clip);
        } else {
            self.add_group(text.flattened(), ts, layer, clip);
        }
        let shown = text.chunks().iter().any(|chunk| {
            let draws = |span: &usvg::TextSpan| span.is_visible() && (span.fill().is_some() || span.stroke().is_some());
            chunk.text().chars().any(|c| !c.is_whitespace()) && chunk.spans().iter().any(draws)
        });
        self.lost_texts += (shown && self.paths.len() == before) as usize;
    }

    /// Puts the place of each letter, and decorations as lines.
    fn add_letters(&mut self, text: &Text, ts: Transform, layer: Option<&str>, clip: u32) {
        let Some(fonts) = self.fonts.clone() else { return };
        for span in text.layouted().iter().filter(|span| span.visible) {
            let fill = span.fill.as_ref().filter(|f| f.opacity().get() > 0.0 && paints::shows(f.paint())).map(|f| f.paint());
            let stroke = span.stroke.as_ref().filter(|s| s.opacity().get() > 0.0 && paints::shows(s.paint())).map(|s| s.paint());
            let Some(paint) = fill.or(stroke) else { continue };
            let layer = self.layer_index(layer);
            let drawn = SvgPath { layer, clip, stroked: 1, caps: 1, stroke: paints::colour(paint), path_length: f64::NAN, ..SvgPath::default() };
            let line = |points: [(f32, f32); 3]| {
                let mut path = PathBuilder::new();
                path.move_to(points[0].0, points[0].1);
                points[1..].iter().for_each(|p| path.line_to(p.0, p.1));
                path.finish()
            };
            for glyph in &span.positioned_glyphs {
                let Some((advance, capitals)) = measures(glyph, &fonts).filter(|m| m.0 > 0.0) else { continue };
                let letters: Vec<char> = glyph.text.chars().filter(|c| !c.is_control()).collect();
                let count = letters.iter().filter(|c| !is_mark(**c)).count().max(1) as f32;
                for (place, (at, letter)) in letters.iter().enumerate().filter(|(_, c)| !is_mark(**c) && !c.is_whitespace()).enumerate() {
                    let x = advance * place as f32 / count;
                    let mark = letters.get(at + 1).filter(|c| is_mark(**c)).map_or(0, |c| *c as u32);
                    if let Some(box_) = line([(x, 0.0), (x + advance / count, 0.0), (x, capitals)]) {
                        self.put(&box_, ts.pre_concat(glyph.outline_transform()), SvgPath { letter: [*letter as u32, mark], ..drawn.clone() });
                    }
                }
            }
            for decoration in [&span.underline, &span.overline, &span.line_through].into_iter().flatten() {
                let box_ = Path::data(decoration).bounds();
                let middle = (box_.top() + box_.bottom()) / 2.0;
                if let Some(path) = line([(box_.left(), middle), (box_.left() + box_.width() / 2.0, middle), (box_.right(), middle)]) {
                    self.put(&path, ts, drawn.clone());
                }
            }
        }
    }
}
