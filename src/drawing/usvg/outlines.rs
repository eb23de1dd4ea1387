//! Converts usvg's tree to paths on the page, in millimetres.

use crate::clips::stroked_area;
use crate::{complaints, document, dtd, font_face, labels, paints, references, servers, texts};
use std::collections::HashMap;
use std::sync::Arc;
use usvg::tiny_skia_path::{PathBuilder, PathSegment, Point, Rect};
use usvg::filter::{Input, Kind, Primitive};
use usvg::{fontdb, BlendMode, FillRule, Group, ImageHrefResolver, ImageKind, LineCap, Node, Options};
use usvg::{Opacity, Paint, PaintOrder, Path, Transform, Tree};

const MM_PER_PX: f64 = 25.4 / 96.0;
const MOST_POINTS: usize = 4_000_000; // nested uses multiply without bound
const OPAQUE: f32 = 0.84; // what is not more opaque lets black show through as a visible grey
const SOFT: f64 = 1.0 / 300.0; // of the page's longer side: what is blurred by more has no line

// Style sheets that no rule of the document overrides.
const NO_FILTERS: &str = "* { filter: none !important }";
const NO_CLIPS: &str = "* { clip-path: none !important; mask: none !important }";
const ALL_SHOWN: &str = "* { display: inline !important }";
// Browsers put markers on lines alone.
const NO_MARKERS: &str = "rect, circle, ellipse { marker-start: none !important; marker-mid: none !important; marker-end: none !important }";

/// What a fill hides: ImpedrawSvgHides.
#[repr(u8)]
#[derive(Clone, Copy, Default)]
pub enum Hides {
    #[default]
    Nothing,
    Beneath,
    WhiteStroke,
    Veil,
}

#[repr(C)]
#[derive(Clone, Default)]
pub struct SvgPath {
    pub verbs: usize,
    pub layer: u32,
    pub stroked: u8,
    pub filled: u8,
    pub caps: u8,
    pub even_odd: u8,
    pub hides: Hides,
    pub fill: u32,
    pub stroke: u32,
    pub width: f64,
    pub hides_from: usize,
    pub covers: u8,
    pub covers_from: usize,
    pub group: u32,
    pub soft: f64,
    pub opacity: f32,
    pub stroke_opacity: f32,
    pub shaded: [u8; 2],
    pub clip: u32,
    pub shapes: u32,
    pub value: f32,
    pub alpha: f32,
    pub dash_count: usize,
    pub dash_offset: f64,
    pub path_length: f64,
    pub transform: [f64; 4],
    pub letter: [u32; 2],
}

#[repr(C)]
pub struct SvgClip {
    pub parent: u32,
    pub mask: u8,
}

#[repr(C)]
pub struct SvgGroup {
    pub parent: u32,
    pub opacity: f32,
    pub blend: u8,
}

#[derive(Default)]
pub struct Outlines {
    pub size: (f64, f64),
    pub paths: Vec<SvgPath>,
    pub clips: Vec<SvgClip>,
    pub verbs: Vec<u8>,
    pub points: Vec<f64>,
    pub dashes: Vec<f64>,
    pub layers: Vec<String>,
    pub warnings: Vec<String>,
    pub named: bool,
    marked: document::Marked,
    seen: HashMap<String, u32>,     // layers with a path, by their group's id
    pub clip_numbers: HashMap<(usize, [u32; 6], u32), u32>,
    pub groups: Vec<SvgGroup>,
    open: Vec<(f32, usize)>,        // groups that stand open: opacity, and the first path within
    group: u32,                     // the innermost of them, in `groups` from 1
    blur: f32,                      // of what is put [px]
    shades: HashMap<(usize, bool), (Paint, Transform)>, // gradients of paths and their strokes, from mm to their unit
    filters: usize,
    soft: usize,                    // shapes that are too blurred to have a line
    spared: usize,                  // shapes that a filter would hide, as it is missing or empty
    hidden: usize,                  // shapes that are painted and do not show
    patterned: usize,               // painted with a pattern that is left out
    pub tiles: usize,               // of patterns
    pub unread_masks: usize,        // shapes of masks that are painted with what is not evaluated
    faint: usize,                   // shapes and groups that are partly transparent
    pub lost_texts: usize,
    pub fonts: Option<Arc<fontdb::Database>>, // text is put as letters
    too_many: bool,
}

/// Paths and texts, and filters, in a group.
fn contents(group: &Group) -> (usize, usize) {
    group.children().iter().fold((0, group.filters().len()), |(shapes, filters), node| match node {
        Node::Group(group) => {
            let (more, more_filters) = contents(group);
            (shapes + more, filters + more_filters)
        }
        Node::Path(_) | Node::Text(_) => (shapes + 1, filters),
        Node::Image(_) => (shapes, filters),
    })
}

/// How much a filter blurs what it gets, by the way that blurs it least: a shadow beside the source leaves
/// it sharp.
fn blur_of(primitives: &[Primitive]) -> f32 {
    let mut blurs: Vec<f32> = Vec::new();
    for (i, primitive) in primitives.iter().enumerate() {
        let kind = primitive.kind();
        let from = |input: Input, blur: f32| kind.has_input(&input).then_some(blur);
        let sources = [from(Input::SourceGraphic, 0.0), from(Input::SourceAlpha, 0.0)].into_iter();
        let before = (0..i).map(|k| from(Input::Reference(primitives[k].result().to_string()), blurs[k]));
        let least = sources.chain(before).flatten().reduce(f32::min).unwrap_or(f32::INFINITY);
        let more = if let Kind::GaussianBlur(blur) = kind { blur.std_dev_x().get().max(blur.std_dev_y().get()) } else { 0.0 };
        blurs.push(least + more);
    }
    blurs.last().copied().unwrap_or(0.0)
}

fn drawing_of(kind: &str, data: Arc<Vec<u8>>, options: &Options) -> Option<ImageKind> {
    (kind == "image/svg+xml").then(|| ImageHrefResolver::default_data_resolver()(kind, data, options))?
}

impl Outlines {
    /// single: text is put as letters, whose lines the caller draws.
    pub fn read(data: &[u8], single: bool) -> Result<Outlines, String> {
        complaints::listen();
        let mut outlines = Outlines::default();
        let given = dtd::completed(document::text_of(data)?, &mut outlines.warnings);
        let mut xml = document::parse(&given)?;
        let changed = document::in_known_words(&given, &xml);
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
        outlines.named = marked.named;
        outlines.marked = marked;
        for (tags, consequence) in [
            (&["image"][..], "pictures are left out: only paths and shapes are read"),
            (&["animate", "animateTransform", "animateMotion", "animateColor", "set"], "animations are left out: drawn as it is without them"),
        ] {
            match tags.iter().map(|tag| document::count(&xml, tag)).sum() {
                0 => {}
                count => outlines.warnings.push(format!("{count} × <{}>: {consequence}", tags[0])),
            }
        }
        let labels = labels::of(&xml).count();
        if labels > 0 {
            outlines.warnings.push(format!("{labels} × <foreignObject>: text in HTML that is not one plain label is left out"));
        }
        outlines.warnings.extend(references::missing(&xml));
        if references::has_outer_style(&xml) {
            outlines.warnings.push("a style sheet outside of the file is not read".to_string());
        }
        let mut options = Options {
            // Nothing outside the file is read. Of the pictures in it, a pen draws those that are SVG.
            image_href_resolver: ImageHrefResolver { resolve_data: Box::new(drawing_of), resolve_string: Box::new(|_, _| None) },
            ..Options::default()
        };
        if document::count(&xml, "text") > 0 || given.contains(document::DRAWING) {
            let mut fonts = texts::fonts();
            outlines.warnings.extend(font_face::load(&xml, &mut fonts));
            options.font_size = 16.0; // as browsers have it
            options.font_family = fonts.family_name(&fontdb::Family::Serif).to_string(); // of text that names none
            options.fontdb = Arc::new(fonts);
            options.font_resolver.select_font = Box::new(texts::select_font);
        }
        let mut tree_with = |sheets: &[&str]| {
            options.style_sheet = Some(sheets.concat());
            Tree::from_xmltree(&xml, &options).map_err(|e| match e {
                usvg::Error::ParsingFailed(usvg::roxmltree::Error::NodesLimitReached) => {
                    "more than 1,000,000 elements, all uses counted, or too many within one another".to_string()
                }
                other => other.to_string(),
            })
        };
        let mut tree = tree_with(&[NO_FILTERS, NO_MARKERS])?;
        let complaints = complaints::heard();
        let has = |words: &[&str]| words.iter().any(|word| given.contains(word));
        if has(&["filter"]) {
            let filtered = tree_with(&[NO_MARKERS])?;
            let (shapes, filters) = contents(filtered.root());
            // usvg drops what has a filter that is missing or empty.
            outlines.spared = contents(tree.root()).0.saturating_sub(shapes);
            if outlines.spared == 0 {
                tree = filtered;
            } else {
                outlines.filters = filters;
            }
        }
        outlines.size = (tree.size().width() as f64 * MM_PER_PX, tree.size().height() as f64 * MM_PER_PX);
        outlines.fonts = single.then(|| tree.fontdb().clone());
        outlines.add_group(tree.root(), Transform::identity(), None, 0);
        if outlines.too_many {
            return Err(format!("more than {MOST_POINTS} points, all uses counted"));
        }
        let (drawn, _) = contents(tree.root());
        drop(tree);
        // What a part of the document hides shows in the document without that part.
        if has(&["display", "clip-path", "mask"]) {
            let shown = tree_with(&[NO_FILTERS, NO_MARKERS, NO_CLIPS, ALL_SHOWN]).map_or(0, |tree| contents(tree.root()).0);
            outlines.hidden += shown.saturating_sub(drawn);
        }
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
            self.warnings.push(format!("{} shapes are painted with a pattern that is too fine, or on a stroke: it counts as an even tone, or as a line", self.patterned));
        }
        if self.unread_masks > 0 {
            self.warnings.push(format!("{} shapes of masks hold a pattern or a cone: taken as one even light", self.unread_masks));
        }
        if self.filters > 0 {
            self.warnings.push(format!("{} filters (shadow, light and the like) are passed over", self.filters));
        }
        if self.soft > 0 {
            self.warnings.push(format!("{} blurred shapes have no edge: drawn only where something cuts them", self.soft));
        }
        if self.spared > 0 {
            self.warnings.push(format!("{} shapes are drawn that a missing or empty filter would hide", self.spared));
        }
        if self.faint > 0 {
            self.warnings.push(format!("{} shapes or groups are partly transparent: their lines are drawn as if they were not", self.faint));
        }
    }

    /// around: the transform of the parent; layer: the id of the enclosing top-level group; clip: what
    /// clips the group, 0 if nothing does.
    pub fn add_group<'a>(&mut self, group: &'a Group, around: Transform, layer: Option<&'a str>, clip: u32) {
        if group.opacity().get() == 0.0 {
            self.hidden += contents(group).0;
            return;
        }
        self.faint += (group.opacity().get() < 1.0) as usize;
        let ts = around.pre_concat(group.transform());
        let clip = self.clip_of_group(group, ts, clip);
        let around = self.open(group.opacity().get(), group.blend_mode(), group.isolate());
        let blur = self.blur;
        let softens = self.blurs();
        self.blur += group.filters().iter().map(|f| f.primitives()).map(blur_of).sum::<f32>() * ts.get_scale().0.max(ts.get_scale().1);
        self.filters += if self.blurs() > softens { 0 } else { group.filters().len() };
        let layer = layer.or(self.marked.layers.contains_key(group.id()).then_some(group.id()));
        for node in group.children() {
            match node {
                Node::Group(group) => self.add_group(group, ts, layer, clip),
                Node::Path(path) => self.add_path(path, ts, layer, clip),
                Node::Text(text) => self.add_text(text, ts, layer, clip),
                Node::Image(image) => {
                    if let (true, ImageKind::SVG(drawing)) = (image.is_visible(), image.kind()) {
                        let page = Rect::from_xywh(0.0, 0.0, drawing.size().width(), drawing.size().height());
                        let clip = page.map_or(clip, |page| self.clip_to(&PathBuilder::from_rect(page), FillRule::NonZero, ts, clip));
                        self.add_group(drawing.root(), ts, layer, clip);
                    }
                }
            }
        }
        self.close(around);
        self.blur = blur;
    }

    /// The deviation of the blur around [mm]; 0 where it leaves edges.
    fn blurs(&self) -> f64 {
        let blur = self.blur as f64 * MM_PER_PX;
        if blur > SOFT * self.size.0.max(self.size.1) { blur } else { 0.0 }
    }

    /// Opens a group. Returns the one around.
    pub fn open(&mut self, opacity: f32, blend: BlendMode, isolated: bool) -> u32 {
        let around = self.group;
        self.open.push((if blend == BlendMode::Normal { opacity } else { 0.0 }, self.paths.len()));
        if opacity < 1.0 || blend != BlendMode::Normal || isolated {
            self.groups.push(SvgGroup { parent: around, opacity, blend: blend as u8 });
            self.group = self.groups.len() as u32;
        }
        around
    }

    pub fn close(&mut self, around: u32) {
        self.open.pop();
        self.group = around;
    }

    /// The first path that one of this opacity hides: groups around it may be too faint to hide what
    /// lies before them. None: it hides nothing.
    fn hides_from(&self, opacity: f32) -> Option<usize> {
        let mut opacity = opacity;
        if opacity <= OPAQUE {
            return None;
        }
        for (of_group, first) in self.open.iter().rev() {
            opacity *= of_group;
            if opacity <= OPAQUE {
                return Some(*first);
            }
        }
        Some(0)
    }

    /// The colour of what the path paints at a place [mm]: red, green, blue and opacity, from 0 to 1.
    pub fn shade(&self, path: usize, of_stroke: bool, x: f64, y: f64) -> [f32; 4] {
        let Some((paint, to_paint)) = self.shades.get(&(path, of_stroke)) else { return [0.0; 4] };
        let mut p = Point::from_xy(x as f32, y as f32);
        to_paint.map_point(&mut p);
        paints::shade(paint, p)
    }

    /// Keeps the gradient of the path that is put next. True if it is one.
    fn keep_shade(&mut self, path: usize, of_stroke: bool, paint: &Paint, ts: Transform) -> bool {
        let own = match paint {
            Paint::LinearGradient(g) => g.transform(),
            Paint::RadialGradient(g) => g.transform(),
            _ => return false,
        };
        let to_mm = ts.post_scale(MM_PER_PX as f32, MM_PER_PX as f32).pre_concat(own);
        let Some(back) = to_mm.invert() else { return false };
        self.shades.insert((path, of_stroke), (paint.clone(), back));
        true
    }

    pub fn layer_index(&mut self, id: Option<&str>) -> u32 {
        let id = id.unwrap_or(""); // in no group
        if let Some(index) = self.seen.get(id) {
            return *index;
        }
        let index = self.layers.len() as u32;
        self.layers.push(self.marked.layers.get(id).map_or("page", String::as_str).to_string());
        self.seen.insert(id.to_string(), index);
        index
    }

    fn add_path(&mut self, path: &Path, ts: Transform, given_layer: Option<&str>, clip: u32) {
        let stroke = path.stroke().filter(|s| s.opacity().get() > 0.0 && paints::shows(s.paint()));
        let fill = path.fill().filter(|f| f.opacity().get() > 0.0 && paints::shows(f.paint()));
        if !path.is_visible() || (stroke.is_none() && fill.is_none()) {
            self.hidden += (path.fill().is_some() || path.stroke().is_some()) as usize;
            return;
        }
        let has_pattern = |paint: &Paint| matches!(paint, Paint::Pattern(_));
        let tiled = fill.is_some_and(|f| has_pattern(f.paint()) && self.add_tiles(path, f, ts, given_layer, clip));
        let fill = fill.filter(|_| !tiled);
        self.patterned += (fill.is_some_and(|f| has_pattern(f.paint())) || stroke.is_some_and(|s| has_pattern(s.paint()))) as usize;
        if fill.is_none() && stroke.is_none() {
            return;
        }
        let layer = self.layer_index(given_layer);
        let scale = (ts.sx as f64 * ts.sy as f64 - ts.kx as f64 * ts.ky as f64).abs().sqrt();
        let width = stroke.map_or(0.0, |s| MM_PER_PX * scale * s.width().get() as f64);
        let opacities = [stroke.map(|s| s.opacity()), path.fill().map(|f| f.opacity())];
        self.faint += opacities.iter().flatten().any(|o| (0.01..1.0).contains(&o.get())) as usize;
        let hiding = |paint: &Paint, opacity: Opacity| self.hides_from(opacity.get() * paints::least_opacity(paint));
        let dashes = stroke.and_then(|s| s.dasharray()).unwrap_or(&[]);
        let limit = stroke.map_or(0, |s| s.miterlimit().get() as usize);
        let length = limit.checked_sub(document::FIRST_LENGTH).and_then(|index| self.marked.lengths.get(index)).copied();
        let hides_from = fill.and_then(|f| hiding(f.paint(), f.opacity()));
        let covers_from = stroke.and_then(|s| hiding(s.paint(), s.opacity()));
        let veils = |paint: &Paint, opacity: Opacity| hiding(paint, opacity) != Some(0) && paints::is_white(paints::colour(paint));
        let fill_veil = fill.filter(|f| veils(f.paint(), f.opacity()));
        let stroke_veil = stroke.filter(|s| veils(s.paint(), s.opacity()));
        let afar = fill.and_then(|f| if let Paint::Pattern(p) = f.paint() { Some(servers::from_afar(p)) } else { None });
        let drawn = SvgPath {
            layer,
            covers: covers_from.is_some() as u8,
            covers_from: covers_from.unwrap_or(0),
            opacity: fill.map_or(0.0, |f| f.opacity().get()) * afar.map_or(1.0, |(_, share)| share),
            stroke_opacity: stroke.map_or(0.0, |s| s.opacity().get()),
            stroked: stroke.is_some() as u8,
            filled: fill.is_some() as u8,
            caps: stroke.is_some_and(|s| s.linecap() != LineCap::Butt) as u8,
            even_odd: path.fill().is_some_and(|f| f.rule() == FillRule::EvenOdd) as u8,
            fill: fill.map_or(0, |f| afar.map_or(paints::colour(f.paint()), |(colour, _)| colour)),
            stroke: stroke.map_or(0, |s| paints::colour(s.paint())),
            width,
            hides: if hides_from.is_some() { Hides::Beneath } else { Hides::Nothing },
            hides_from: hides_from.unwrap_or(0),
            clip,
            dash_count: dashes.len(),
            dash_offset: stroke.map_or(0.0, |s| s.dashoffset() as f64),
            path_length: length.unwrap_or(f64::NAN),
            ..SvgPath::default()
        };
        // A white stroke hides what lies under its whole width: it is an area.
        let white = stroke.filter(|s| paints::is_white(paints::colour(s.paint())));
        let cover = white.and_then(|s| {
            let hides_from = hiding(s.paint(), s.opacity())?;
            let area = SvgPath { layer, clip, filled: 1, fill: 0xffffff, opacity: s.opacity().get(), hides: Hides::WhiteStroke, hides_from, ..SvgPath::default() };
            Some((stroked_area(path, s, ts)?, area))
        });
        self.dashes.extend(dashes.iter().map(|&length| length as f64));
        let is_covered = cover.is_some();
        let mut both = vec![(path.data().clone(), drawn)];
        both.extend(cover);
        if path.paint_order() == PaintOrder::StrokeAndFill {
            both.reverse();
        }
        for (data, mut path) in both {
            let index = self.paths.len();
            let of_cover = matches!(path.hides, Hides::WhiteStroke);
            let fill = if of_cover { stroke.map(|s| s.paint()) } else { fill.map(|f| f.paint()) };
            path.shaded = [(false, fill), (true, stroke.map(|s| s.paint()))].map(|(of_stroke, paint)| paint.is_some_and(|p| self.keep_shade(index, of_stroke, p, ts)) as u8);
            self.put(&data, ts, path);
        }
        if let Some(fill) = fill.filter(|_| stroke.is_none()) {
            self.add_leaps(path, fill, ts, layer, clip);
        }
        let veil = SvgPath { layer, clip, filled: 1, fill: 0xffffff, hides: Hides::Veil, ..SvgPath::default() };
        if let Some(fill) = fill_veil {
            self.put(path.data(), ts, SvgPath { even_odd: (fill.rule() == FillRule::EvenOdd) as u8, ..veil.clone() });
        }
        if let Some((stroke, area)) = stroke_veil.and_then(|s| Some((s, stroked_area(path, s, ts)?))) {
            let opacity = if is_covered { 0.0 } else { stroke.opacity().get() };
            let shaded = [self.keep_shade(self.paths.len(), false, stroke.paint(), ts) as u8, 0];
            self.put(&area, ts, SvgPath { opacity, shaded, ..veil });
        }
    }

    /// Adds a path with its verbs and points, which it counts.
    pub fn put(&mut self, data: &usvg::tiny_skia_path::Path, ts: Transform, path: SvgPath) {
        self.too_many |= self.points.len() / 2 + data.points().len() > MOST_POINTS;
        if self.too_many {
            return;
        }
        let first = self.verbs.len();
        let mut put = |verb: u8, points: &[Point]| {
            self.verbs.push(verb);
            for p in points {
                let (x, y) = (p.x as f64, p.y as f64);
                self.points.push(MM_PER_PX * (ts.sx as f64 * x + ts.kx as f64 * y + ts.tx as f64));
                self.points.push(MM_PER_PX * (ts.ky as f64 * x + ts.sy as f64 * y + ts.ty as f64));
            }
        };
        for segment in data.segments() {
            match segment {
                PathSegment::MoveTo(p) => put(0, &[p]),
                PathSegment::LineTo(p) => put(1, &[p]),
                PathSegment::QuadTo(a, p) => put(2, &[a, p]),
                PathSegment::CubicTo(a, b, p) => put(3, &[a, b, p]),
                PathSegment::Close => put(4, &[]),
            }
        }
        let verbs = self.verbs.len() - first;
        let soft = self.blurs() > 0.0;
        self.soft += (soft && path.shapes == 0 && !matches!(path.hides, Hides::Veil)) as usize;
        let hides = if soft { Hides::Nothing } else { path.hides };
        let covers = path.covers * !soft as u8;
        self.paths.push(SvgPath { verbs, group: self.group, soft: self.blurs(), hides, covers, transform: [ts.sx, ts.kx, ts.ky, ts.sy].map(|x| MM_PER_PX * x as f64), ..path });
    }
}
