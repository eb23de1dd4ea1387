//! What a pattern or a gradient draws.

use crate::outlines::{Hides, Outlines, SvgClip, SvgPath};
use crate::paints::{self, Band};
use usvg::tiny_skia_path::{self, PathBuilder};
use usvg::{Fill, FillRule, Paint, Path, Transform};

const MOST_TILES: usize = 10_000; // of patterns, in all
const VEIL: f32 = 0.16; // a gradient of white with less opacity leaves black black

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
        self.groups.push((fill.opacity().get(), self.paths.len()));
        for row in *rows.start() as i32..=*rows.end() as i32 {
            for column in *columns.start() as i32..=*columns.end() as i32 {
                let (x, y) = (rect.x() + column as f32 * rect.width(), rect.y() + row as f32 * rect.height());
                let ts = ts.pre_concat(to_shape).pre_translate(x, y);
                let number = self.clip_to(&tile, FillRule::NonZero, ts, shape);
                self.add_group(pattern.root(), ts, layer, number);
            }
        }
        self.groups.pop();
        true
    }

    /// A gradient hides its shape's edge where it is as good as white or clear.
    pub fn add_clear_bands(&mut self, path: &Path, fill: &Fill, ts: Transform, layer: u32, clip: u32, hides_from: usize) {
        let Some((bands, to_shape)) = paints::bands(fill.paint(), path.data().bounds()) else { return };
        let opacity = fill.opacity().get() * self.opacity_of_groups();
        let mut clear = PathBuilder::new(); // where two of them meet, an edge would lie inside neither
        for band in bands.iter().filter(|band| !paints::is_seen(band, opacity)) {
            clear.push_path(&band.area);
        }
        let Some(clear) = clear.finish() else { return };
        let shape = self.clip_to(path.data(), fill.rule(), ts, clip);
        let area = SvgPath { layer, clip: shape, filled: 1, even_odd: 1, fill: 0xffffff, hides: Hides::Edge, hides_from, ..SvgPath::default() };
        self.put(&clear, ts.pre_concat(to_shape), area);
    }

    /// A clip of the gradient's bands that `shows` picks; the one around, if it picks them all.
    pub fn clip_to_bands(&mut self, paint: &Paint, box_: tiny_skia_path::Rect, ts: Transform, clip: u32, shows: impl Fn(&Band) -> bool) -> u32 {
        let Some((bands, to_shape)) = paints::bands(paint, box_).filter(|(bands, _)| !bands.iter().all(&shows)) else { return clip };
        self.clips.push(SvgClip { parent: clip, mask: 0 });
        let number = self.clips.len() as u32;
        for band in bands.iter().filter(|band| shows(band)) {
            let shape = SvgPath { shapes: number, filled: 1, even_odd: 1, value: 1.0, alpha: 1.0, ..SvgPath::default() };
            self.put(&band.area, ts.pre_concat(to_shape), shape);
        }
        number
    }

    /// What is white and lets something show has an edge on what has a colour beneath.
    pub fn add_veil(&mut self, data: &tiny_skia_path::Path, paint: &Paint, ts: Transform, area: SvgPath) {
        let shows = |band: &Band| band.opacity * area.alpha > VEIL;
        let bands = paints::bands(paint, data.bounds()).map_or(Vec::new(), |(bands, _)| bands);
        let least = bands.iter().filter(|band| shows(band)).map(|band| band.opacity).reduce(f32::min);
        let clip = self.clip_to_bands(paint, data.bounds(), ts, area.clip, shows);
        self.put(data, ts, SvgPath { clip, filled: 1, fill: 0xffffff, hides: Hides::Veil, alpha: area.alpha * least.unwrap_or(1.0), ..area });
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
