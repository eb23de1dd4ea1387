//! Clip paths and masks: the areas that they are made of.

use crate::outlines::{Outlines, SvgClip, SvgPath};
use crate::{document, paints};
use usvg::tiny_skia_path::{PathBuilder, PathStroker};
use usvg::{ClipPath, FillRule, Group, Mask, MaskType, Node, Opacity, Paint, Path, Stroke, Transform};

/// The area that a stroke covers, in the path's own unit.
pub fn stroked_area(path: &Path, stroke: &Stroke, ts: Transform) -> Option<usvg::tiny_skia_path::Path> {
    let mut pen = stroke.to_tiny_skia();
    if pen.miter_limit >= document::FIRST_LENGTH as f32 {
        pen.miter_limit = 4.0;
    }
    let scale = PathStroker::compute_resolution_scale(&ts);
    match pen.dash.take() {
        Some(dash) => path.data().dash(&dash, scale)?.stroke(&pen, scale),
        None => path.data().stroke(&pen, scale),
    }
}

impl Outlines {
    pub fn clip_of_group(&mut self, group: &Group, ts: Transform, clip: u32) -> u32 {
        let clip = group.clip_path().map_or(clip, |c| self.add_clip(c, ts, clip));
        group.mask().map_or(clip, |m| self.add_mask(m, ts, clip))
    }

    /// The number of the clip, from 1, and whether it is new: one that many elements share is added
    /// once.
    fn number_of_clip(&mut self, which: usize, ts: Transform, parent: u32, mask: bool) -> (u32, bool) {
        let key = (which, [ts.sx, ts.kx, ts.ky, ts.sy, ts.tx, ts.ty].map(f32::to_bits), parent);
        if let Some(number) = self.clip_numbers.get(&key) {
            return (*number, false);
        }
        self.clips.push(SvgClip { parent, mask: mask as u8 });
        self.clip_numbers.insert(key, self.clips.len() as u32);
        (self.clips.len() as u32, true)
    }

    fn add_clip(&mut self, clip: &ClipPath, ts: Transform, parent: u32) -> u32 {
        let parent = clip.clip_path().map_or(parent, |inner| self.add_clip(inner, ts, parent));
        let (number, new) = self.number_of_clip(clip as *const ClipPath as usize, ts, parent, false);
        if new {
            self.add_shapes(clip.root(), ts.pre_concat(clip.transform()), number, 0, None);
        }
        number
    }

    fn add_mask(&mut self, mask: &Mask, ts: Transform, parent: u32) -> u32 {
        let parent = mask.mask().map_or(parent, |inner| self.add_mask(inner, ts, parent));
        let (bounds, new) = self.number_of_clip(mask as *const Mask as usize, ts, parent, false);
        if new {
            let rect = PathBuilder::from_rect(mask.rect().to_rect());
            self.put(&rect, ts, SvgPath { shapes: bounds, filled: 1, value: 1.0, alpha: 1.0, ..SvgPath::default() });
        }
        let (number, new) = self.number_of_clip(mask as *const Mask as usize + 1, ts, bounds, true);
        if new {
            self.add_shapes(mask.root(), ts, number, 0, Some((mask.kind(), 1.0)));
        }
        number
    }

    /// What a clip path or a mask is made of. mask: its kind, and the opacity of the groups around.
    fn add_shapes(&mut self, group: &Group, ts: Transform, shapes: u32, clip: u32, mask: Option<(MaskType, f32)>) {
        for node in group.children() {
            match node {
                Node::Group(group) => {
                    let ts = ts.pre_concat(group.transform());
                    let clip = self.clip_of_group(group, ts, clip);
                    self.add_shapes(group, ts, shapes, clip, mask.map(|(kind, opacity)| (kind, opacity * group.opacity().get())));
                }
                Node::Path(path) if path.is_visible() => self.add_shape(path, ts, shapes, clip, mask),
                Node::Text(text) => self.add_shapes(text.flattened(), ts, shapes, clip, mask),
                _ => {}
            }
        }
    }

    fn add_shape(&mut self, path: &Path, ts: Transform, shapes: u32, clip: u32, mask: Option<(MaskType, f32)>) {
        if let Some(fill) = path.fill() {
            let even_odd = (fill.rule() == FillRule::EvenOdd) as u8;
            let shape = SvgPath { shapes, clip, filled: 1, even_odd, ..SvgPath::default() };
            self.add_painted_shape(path.data(), fill.paint(), fill.opacity(), ts, shape, mask);
        }
        if let Some(stroke) = path.stroke().filter(|_| mask.is_some()) {
            if let Some(area) = stroked_area(path, stroke, ts) {
                let shape = SvgPath { shapes, clip, filled: 1, ..SvgPath::default() };
                self.add_painted_shape(&area, stroke.paint(), stroke.opacity(), ts, shape, mask);
            }
        }
    }

    /// A gradient in a mask becomes bands, each a clip of its own.
    fn add_painted_shape(&mut self, data: &usvg::tiny_skia_path::Path, paint: &Paint, opacity: Opacity, ts: Transform, shape: SvgPath, mask: Option<(MaskType, f32)>) {
        let Some((kind, around)) = mask else {
            self.put(data, ts, SvgPath { value: 1.0, alpha: 1.0, ..shape });
            return;
        };
        let lit = |luminance: f32, alpha: f32, shape: SvgPath| {
            let value = if kind == MaskType::Luminance { luminance } else { 1.0 };
            SvgPath { value, alpha: around * alpha * opacity.get(), ..shape }
        };
        if let Paint::Color(c) = paint {
            self.put(data, ts, lit(paints::luminance(*c), 1.0, shape));
            return;
        }
        let Some((bands, to_shape)) = paints::bands(paint, data.bounds()) else {
            self.unread_masks += 1;
            self.put(data, ts, lit(1.0, 1.0, shape));
            return;
        };
        for band in bands {
            self.clips.push(SvgClip { parent: shape.clip, mask: 0 });
            let number = self.clips.len() as u32;
            let area = SvgPath { shapes: number, filled: 1, even_odd: 1, value: 1.0, alpha: 1.0, ..SvgPath::default() };
            self.put(&band.area, ts.pre_concat(to_shape), area);
            self.put(data, ts, lit(band.luminance, band.opacity, SvgPath { clip: number, ..shape }));
        }
    }
}
