//! Converts usvg's tree to paths on the page, in millimetres.

use crate::{complaints, document, dtd, references};
use std::collections::HashMap;
use std::sync::Arc;
use usvg::tiny_skia_path::{PathSegment, Point};
use usvg::{fontdb, Color, FillRule, Font, FontFamily, FontResolver, Group, ImageHrefResolver, LineCap, Node, Options, Paint, Path, Text, Tree};

const MM_PER_PX: f64 = 25.4 / 96.0;
const MOST_POINTS: usize = 4_000_000; // nested uses multiply without bound

// Style sheets that no rule of the document overrides. A pen draws no effect, and usvg would drop
// what has a filter, clip path or mask that is missing or empty.
const NO_MARKERS: &str = "* { marker: none !important }";
const NO_EFFECTS: &str = "* { filter: none !important; clip-path: none !important; mask: none !important }";
const ALL_SHOWN: &str = "* { display: inline !important }";

#[repr(C)]
pub struct SvgPath {
    verbs: usize,
    layer: u32,
    stroked: u8,
    filled: u8,
    caps: u8,
    even_odd: u8,
    white: u8,
    dash_count: usize,
    dash_offset: f64,
    path_length: f64,
    transform: [f64; 4],
}

#[derive(Default)]
pub struct Outlines {
    pub size: (f64, f64),
    pub paths: Vec<SvgPath>,
    pub verbs: Vec<u8>,
    pub points: Vec<f64>,
    pub dashes: Vec<f64>,
    pub layers: Vec<String>,
    pub warnings: Vec<String>,
    marked: document::Marked,
    seen: HashMap<String, u32>,     // layers with a path, by their group's id
    effects: Effects,
    spared: usize,                  // shapes that an effect would hide, as it is missing or empty
    hidden: usize,                  // shapes that are painted and do not show
    patterned: usize,               // painted with a pattern
    faint: usize,                   // shapes and groups that are partly transparent
    widths: Option<(f64, f64)>,     // of the narrowest and the widest stroke [mm]
    lost_texts: usize,
    too_many: bool,
}

/// What a group holds beside outlines.
#[derive(Default)]
struct Effects {
    shapes: usize, // paths and texts
    hiders: usize, // clip paths and masks
    filters: usize,
}

impl Effects {
    fn of(group: &Group) -> Effects {
        let hiders = group.clip_path().is_some() as usize + group.mask().is_some() as usize;
        let mut sum = Effects { shapes: 0, hiders, filters: group.filters().len() };
        for node in group.children() {
            match node {
                Node::Group(group) => {
                    let Effects { shapes, hiders, filters } = Effects::of(group);
                    sum = Effects { shapes: sum.shapes + shapes, hiders: sum.hiders + hiders, filters: sum.filters + filters };
                }
                Node::Path(_) | Node::Text(_) => sum.shapes += 1,
                Node::Image(_) => {}
            }
        }
        sum
    }
}

/// The system's fonts. Each generic family name maps to an installed font.
fn fonts() -> fontdb::Database {
    let mut fonts = fontdb::Database::new();
    fonts.load_system_fonts();
    let families: Vec<String> = fonts.faces().flat_map(|face| face.families.iter().map(|f| f.0.clone())).collect();
    let first_of = |wanted: [&str; 4]| {
        let found = wanted.iter().find(|w| families.iter().any(|f| f == *w));
        found.map(|w| w.to_string()).or(families.first().cloned())
    };
    if let Some(serif) = first_of(["Times New Roman", "Liberation Serif", "DejaVu Serif", "Noto Serif"]) {
        fonts.set_serif_family(serif);
    }
    if let Some(sans) = first_of(["Arial", "Liberation Sans", "DejaVu Sans", "Noto Sans"]) {
        fonts.set_sans_serif_family(sans);
    }
    if let Some(mono) = first_of(["Courier New", "Liberation Mono", "DejaVu Sans Mono", "Noto Sans Mono"]) {
        fonts.set_monospace_family(mono);
    }
    fonts
}

/// usvg's choice of a font; says so if it is not the one that the document names first.
fn select_font(font: &Font, fonts: &mut Arc<fontdb::Database>) -> Option<fontdb::ID> {
    let id = FontResolver::default_font_selector()(font, fonts)?;
    let generic = matches!(font.families()[0], FontFamily::Serif | FontFamily::SansSerif | FontFamily::Monospace);
    let wanted = match &font.families()[0] {
        FontFamily::Named(name) => name.clone(),
        other => other.to_string(),
    };
    let names = &fonts.face(id)?.families;
    if !generic && names.iter().all(|(name, _)| *name != wanted) {
        log::warn!(target: "usvg", "the font '{wanted}' is not installed: replaced by '{}'", names[0].0);
    }
    Some(id)
}

fn shows(paint: &Paint) -> bool {
    match paint {
        Paint::Color(_) => true,
        Paint::LinearGradient(g) => g.stops().iter().any(|s| s.opacity().get() > 0.0),
        Paint::RadialGradient(g) => g.stops().iter().any(|s| s.opacity().get() > 0.0),
        Paint::Pattern(_) => true,
    }
}

fn is_white(paint: &Paint) -> bool {
    matches!(paint, Paint::Color(Color { red: 255, green: 255, blue: 255 }))
}

impl Outlines {
    pub fn read(data: &[u8]) -> Result<Outlines, String> {
        complaints::listen();
        let mut outlines = Outlines::default();
        let given = dtd::completed(document::text_of(data)?, &mut outlines.warnings);
        let mut xml = document::parse(&given)?;
        let changed = document::without_q(&given, &xml);
        let text = changed.as_deref().unwrap_or(&given);
        if changed.is_some() {
            xml = document::parse(text)?;
        }
        document::check(&xml)?;
        document::check_uses(&xml)?;
        let (named, marked) = document::marked(text, &xml);
        if let Some(named) = &named {
            xml = document::parse(named)?;
        }
        outlines.marked = marked;
        for (tags, consequence) in [
            (&["image"][..], "pictures are left out: a pen draws lines only"),
            (&["foreignObject"], "foreign objects are left out"),
            (&["animate", "animateTransform", "animateMotion", "animateColor", "set"], "animations are left out: drawn as it is without them"),
        ] {
            match tags.iter().map(|tag| document::count(&xml, tag)).sum() {
                0 => {}
                count => outlines.warnings.push(format!("{count} × <{}>: {consequence}", tags[0])),
            }
        }
        outlines.warnings.extend(references::missing(&xml));
        if references::has_outer_style(&xml) {
            outlines.warnings.push("a style sheet outside of the file is not read".to_string());
        }
        let mut options = Options {
            // Nothing outside the file is read, and a pen cannot draw embedded pictures.
            image_href_resolver: ImageHrefResolver { resolve_data: Box::new(|_, _, _| None), resolve_string: Box::new(|_, _| None) },
            ..Options::default()
        };
        let mut style = String::new();
        match document::count(&xml, "marker") {
            0 => {}
            count => {
                style.push_str(NO_MARKERS);
                outlines.warnings.push(format!("{count} × <marker>: arrow heads and other markers are left out"));
            }
        }
        if document::count(&xml, "text") > 0 {
            let fonts = fonts();
            options.font_family = fonts.family_name(&fontdb::Family::Serif).to_string(); // of text that names none
            options.fontdb = Arc::new(fonts);
            options.font_resolver.select_font = Box::new(select_font);
        }
        let mut tree_with = |sheets: &[&str]| {
            options.style_sheet = Some(style.clone() + &sheets.concat());
            Tree::from_xmltree(&xml, &options).map_err(|e| match e {
                usvg::Error::ParsingFailed(usvg::roxmltree::Error::NodesLimitReached) => {
                    "more than 1,000,000 elements, all uses counted, or too many within one another".to_string()
                }
                other => other.to_string(),
            })
        };
        let tree = tree_with(&[NO_EFFECTS])?;
        outlines.size = (tree.size().width() as f64 * MM_PER_PX, tree.size().height() as f64 * MM_PER_PX);
        outlines.add_group(tree.root(), None);
        if outlines.too_many {
            return Err(format!("more than {MOST_POINTS} points, all uses counted"));
        }
        let complaints = complaints::heard();
        let drawn = Effects::of(tree.root());
        drop(tree);
        // What a part of the document hides shows in the document without that part.
        let has = |words: &[&str]| words.iter().any(|word| given.contains(word));
        if has(&["display"]) {
            let shown = tree_with(&[NO_EFFECTS, ALL_SHOWN]).map_or(0, |tree| Effects::of(tree.root()).shapes);
            outlines.hidden += shown.saturating_sub(drawn.shapes);
        }
        let whole = if has(&["filter", "clip-path", "mask"]) { tree_with(&[]).ok() } else { None };
        outlines.effects = whole.map_or(Effects { ..drawn }, |tree| Effects::of(tree.root()));
        outlines.spared = drawn.shapes.saturating_sub(outlines.effects.shapes);
        outlines.warn();
        outlines.warnings.extend(complaints);
        Ok(outlines)
    }

    fn warn(&mut self) {
        if self.lost_texts > 0 {
            self.warnings.push(format!("{} texts are left out: no font of this system shows them", self.lost_texts));
        }
        if self.hidden > 0 {
            self.warnings.push(format!("{} shapes are left out: hidden, or wholly transparent", self.hidden));
        }
        if self.patterned > 0 {
            self.warnings.push(format!("{} shapes are painted with a pattern: what it holds is left out", self.patterned));
        }
        if self.effects.hiders > 0 {
            self.warnings.push(format!("{} clip paths or masks are passed over: what they hide is drawn", self.effects.hiders));
        }
        if self.effects.filters > 0 {
            self.warnings.push(format!("{} filters (blur, shadow and the like) are passed over", self.effects.filters));
        }
        if self.spared > 0 {
            self.warnings.push(format!("{} shapes are drawn that a missing or empty filter, clip path or mask would hide", self.spared));
        }
        if self.faint > 0 {
            self.warnings.push(format!("{} shapes or groups are partly transparent: drawn as if they were not", self.faint));
        }
        if let Some((narrow, wide)) = self.widths.filter(|(narrow, wide)| *wide > 1.25 * narrow) {
            self.warnings.push(format!("stroke widths of {narrow:.2} to {wide:.2} mm are passed over: a pen has one width"));
        }
    }

    /// layer: the id of the enclosing top-level group.
    fn add_group<'a>(&mut self, group: &'a Group, layer: Option<&'a str>) {
        if group.opacity().get() == 0.0 {
            self.hidden += Effects::of(group).shapes;
            return;
        }
        self.faint += (group.opacity().get() < 1.0) as usize;
        let layer = layer.or(self.marked.layers.contains_key(group.id()).then_some(group.id()));
        for node in group.children() {
            match node {
                Node::Group(group) => self.add_group(group, layer),
                Node::Path(path) => self.add_path(path, layer),
                Node::Text(text) => self.add_text(text, layer),
                Node::Image(_) => {}
            }
        }
    }

    fn add_text<'a>(&mut self, text: &'a Text, layer: Option<&'a str>) {
        let before = self.paths.len();
        self.add_group(text.flattened(), layer);
        let shown = text.chunks().iter().any(|chunk| {
            let draws = |span: &usvg::TextSpan| span.is_visible() && (span.fill().is_some() || span.stroke().is_some());
            chunk.text().chars().any(|c| !c.is_whitespace()) && chunk.spans().iter().any(draws)
        });
        self.lost_texts += (shown && self.paths.len() == before) as usize;
    }

    fn layer_index(&mut self, id: Option<&str>) -> u32 {
        let id = id.unwrap_or(""); // in no group
        if let Some(index) = self.seen.get(id) {
            return *index;
        }
        let index = self.layers.len() as u32;
        self.layers.push(self.marked.layers.get(id).map_or("page", String::as_str).to_string());
        self.seen.insert(id.to_string(), index);
        index
    }

    fn add_path(&mut self, path: &Path, layer: Option<&str>) {
        let stroke = path.stroke().filter(|s| s.opacity().get() > 0.0 && shows(s.paint()));
        let filled = path.fill().is_some_and(|f| f.opacity().get() > 0.0 && shows(f.paint()));
        if !path.is_visible() || (stroke.is_none() && !filled) {
            self.hidden += (path.fill().is_some() || path.stroke().is_some()) as usize;
            return;
        }
        let has_pattern = |paint: &Paint| matches!(paint, Paint::Pattern(_));
        self.patterned += (path.fill().is_some_and(|f| has_pattern(f.paint())) || stroke.is_some_and(|s| has_pattern(s.paint()))) as usize;
        self.too_many |= self.points.len() / 2 + path.data().points().len() > MOST_POINTS;
        if self.too_many {
            return;
        }
        let layer = self.layer_index(layer);
        let ts = path.abs_transform();
        if let Some(stroke) = stroke {
            let scale = (ts.sx as f64 * ts.sy as f64 - ts.kx as f64 * ts.ky as f64).abs().sqrt();
            let width = MM_PER_PX * scale * stroke.width().get() as f64;
            let (narrow, wide) = self.widths.unwrap_or((width, width));
            self.widths = Some((narrow.min(width), wide.max(width)));
        }
        let opacities = [stroke.map(|s| s.opacity()), path.fill().map(|f| f.opacity())];
        self.faint += opacities.iter().flatten().any(|o| (0.01..1.0).contains(&o.get())) as usize;
        let dashes = stroke.and_then(|s| s.dasharray()).unwrap_or(&[]);
        self.dashes.extend(dashes.iter().map(|&length| length as f64));
        let first = self.verbs.len();
        let mut put = |verb: u8, points: &[Point]| {
            self.verbs.push(verb);
            for p in points {
                let (x, y) = (p.x as f64, p.y as f64);
                self.points.push(MM_PER_PX * (ts.sx as f64 * x + ts.kx as f64 * y + ts.tx as f64));
                self.points.push(MM_PER_PX * (ts.ky as f64 * x + ts.sy as f64 * y + ts.ty as f64));
            }
        };
        for segment in path.data().segments() {
            match segment {
                PathSegment::MoveTo(p) => put(0, &[p]),
                PathSegment::LineTo(p) => put(1, &[p]),
                PathSegment::QuadTo(a, p) => put(2, &[a, p]),
                PathSegment::CubicTo(a, b, p) => put(3, &[a, b, p]),
                PathSegment::Close => put(4, &[]),
            }
        }
        let limit = stroke.map_or(0, |s| s.miterlimit().get() as usize);
        let length = limit.checked_sub(document::FIRST_LENGTH).and_then(|index| self.marked.lengths.get(index));
        self.paths.push(SvgPath {
            verbs: self.verbs.len() - first,
            layer,
            stroked: stroke.is_some() as u8,
            filled: filled as u8,
            caps: stroke.is_some_and(|s| s.linecap() != LineCap::Butt) as u8,
            even_odd: path.fill().is_some_and(|f| f.rule() == FillRule::EvenOdd) as u8,
            white: path.fill().is_some_and(|f| is_white(f.paint())) as u8,
            dash_count: dashes.len(),
            dash_offset: stroke.map_or(0.0, |s| s.dashoffset() as f64),
            path_length: length.copied().unwrap_or(f64::NAN),
            transform: [ts.sx, ts.kx, ts.ky, ts.sy].map(|x| MM_PER_PX * x as f64),
        });
    }
}
