//! What a pattern or a gradient draws.

use crate::outlines::{Outlines, SvgClip, SvgPath};
use crate::paints;
use usvg::tiny_skia_path::{self, PathBuilder};
use usvg::{BlendMode, Fill, FillRule, Paint, Path, Transform};

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
