//! What a pattern or a gradient draws.

use crate::outlines::{Outlines, SvgClip, SvgPath};
use crate::paints;
use usvg::tiny_skia_path::{self, PathBuilder, PathSegment, Point};
use usvg::{BlendMode, Fill, FillRule, Group, Node, Paint, Path, Pattern, Transform};

const MOST_TILES: usize = 10_000; // of patterns, in all

impl Outlines {
    /// Puts the tiles of a pattern into the path's area. False: the area has too many.
    pub fn add_tiles(&mut self, path: &Path, fill: &Fill, ts: Transform, layer: Option<&str>, clip: u32) -> bool {
        let Paint::Pattern(pattern) = fill.paint() else { return false };
        let (rect, to_shape) = (pattern.rect(), pattern.transform());
        let Some(area) = to_shape.invert().and_then(|back| path.data().bounds().transform(back)) else { return false };
        let first = |low: f32, from: f32, size: f32| ((low - from) / size).floor();
        let (columns, rows) = (
            first(area.left(), rect.x(), rect.width())..=first(area.right(), rect.x(), rect.width()),
            first(area.top(), rect.y(), rect.height())..=first(area.bottom(), rect.y(), rect.height()),
        );
        let count = (columns.end() - columns.start() + 1.0) * (rows.end() - rows.start() + 1.0);
        if count.is_nan() || count > (MOST_TILES - self.tiles) as f32 {
            return false;
        }
        self.tiles += count as usize;
        let shape = self.clip_to(path.data(), fill.rule(), ts, clip);
        let Some(tile) = usvg::tiny_skia_path::Rect::from_xywh(0.0, 0.0, rect.width(), rect.height()).map(PathBuilder::from_rect) else { return false };
        let around = self.open(fill.opacity().get(), BlendMode::Normal, false);
        for row in *rows.start() as i32..=*rows.end() as i32 {
            for column in *columns.start() as i32..=*columns.end() as i32 {
                let (x, y) = (rect.x() + column as f32 * rect.width(), rect.y() + row as f32 * rect.height());
                let ts = ts.pre_concat(to_shape).pre_translate(x, y);
                let number = self.clip_to(&tile, FillRule::NonZero, ts, shape);
                self.add_group(pattern.root(), ts, layer, number);
            }
        }
        self.close(around);
        true
    }

    /// A clip of an area.
    pub fn clip_to(&mut self, area: &tiny_skia_path::Path, rule: FillRule, ts: Transform, parent: u32) -> u32 {
        self.clips.push(SvgClip { parent, mask: 0 });
        let number = self.clips.len() as u32;
        let even_odd = (rule == FillRule::EvenOdd) as u8;
        self.put(area, ts, SvgPath { shapes: number, filled: 1, even_odd, value: 1.0, alpha: 1.0, ..SvgPath::default() });
        number
    }

    /// Puts lines where a gradient's colour leaps.
    pub fn add_leaps(&mut self, path: &Path, fill: &Fill, ts: Transform, layer: u32, clip: u32) {
        let Some((leaps, to_shape)) = paints::leaps(fill.paint(), path.data().bounds()) else { return };
        if leaps.is_empty() {
            return;
        }
        let clip = self.clip_to(path.data(), fill.rule(), ts, clip);
        for leap in leaps {
            let line = SvgPath { layer, clip, stroked: 1, stroke: paints::colour(fill.paint()), path_length: f64::NAN, ..SvgPath::default() };
            self.put(&leap.area, ts.pre_concat(to_shape), line);
        }
    }
}

/// A pattern from afar, as a tone: the mean of its colours, and the share of a tile that they paint. What overlaps
/// counts twice.
pub fn from_afar(pattern: &Pattern) -> (u32, f32) {
    let mut painted = [0.0f32; 4]; // red, green and blue times area, and the area
    weigh(pattern.root(), 1.0, &mut painted);
    let whole = pattern.rect().width() * pattern.rect().height();
    let [red, green, blue] = [0, 1, 2].map(|k| (painted[k] / painted[3].max(f32::MIN_POSITIVE)) as u32);
    (red << 16 | green << 8 | blue, (painted[3] / whole).clamp(0.0, 1.0))
}

/// scale: of areas, the opacity around included.
fn weigh(group: &Group, scale: f32, painted: &mut [f32; 4]) {
    let ts = group.transform();
    let scale = scale * group.opacity().get() * (ts.sx * ts.sy - ts.kx * ts.ky).abs();
    let add = |painted: &mut [f32; 4], paint: &Paint, area: f32| {
        let colour = paints::colour(paint);
        for (k, shift) in [16, 8, 0].into_iter().enumerate() {
            painted[k] += area * (colour >> shift & 0xff) as f32;
        }
        painted[3] += area;
    };
    for node in group.children() {
        match node {
            Node::Path(path) if path.is_visible() => {
                let (area, length) = area_and_length(path.data());
                path.fill().into_iter().for_each(|f| add(painted, f.paint(), scale * f.opacity().get() * area));
                path.stroke().into_iter().for_each(|s| add(painted, s.paint(), scale * s.opacity().get() * s.width().get() * length));
            }
            Node::Group(inner) => weigh(inner, scale, painted),
            _ => {}
        }
    }
}

fn area_and_length(path: &tiny_skia_path::Path) -> (f32, f32) {
    let between = |a: Point, b: Point, share: f32| Point::from_xy(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y));
    let (mut twice, mut length) = (0.0, 0.0);
    let (mut start, mut at) = (Point::zero(), Point::zero());
    for segment in path.segments() {
        let points = match segment {
            PathSegment::MoveTo(p) => {
                twice += at.cross(start);
                (start, at) = (p, p);
                continue;
            }
            PathSegment::LineTo(p) => [at, p, p, p],
            PathSegment::QuadTo(a, p) => [at, between(at, a, 2.0 / 3.0), between(p, a, 2.0 / 3.0), p],
            PathSegment::CubicTo(a, b, p) => [at, a, b, p],
            PathSegment::Close => [at, start, start, start],
        };
        for i in 1..=8 {
            let (t, s) = (i as f32 / 8.0, 1.0 - i as f32 / 8.0);
            let shares = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            let next = points.iter().zip(shares).fold(Point::zero(), |sum, (p, share)| sum + between(Point::zero(), *p, share));
            (twice, length) = (twice + at.cross(next), length + at.distance(next));
            at = next;
        }
    }
    twice += at.cross(start);
    (twice.abs() / 2.0, length)
}
