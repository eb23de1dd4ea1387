//! What a paint looks like: its colour, its light and its opacity, and a gradient in bands of even light.

use usvg::tiny_skia_path::{Path, PathBuilder, Point, Rect};
use usvg::{BaseGradient, Color, Paint, SpreadMethod, Stop, Transform};

const WHITE: u32 = 250; // least red, green and blue of white
const MOST_PERIODS: f32 = 64.0; // of a gradient that repeats
const FINEST: f32 = 1.0 / 16.0; // change of light or opacity within a band
const BESIDE: f32 = 1e-4; // of a gradient's length, on either side of a leap
const LEAP: f32 = 40.0; // change of a channel, of 255, that makes a line
const BEND: usize = 64; // parts of a ramp in which a threshold is looked for

fn stops(paint: &Paint) -> Option<&[Stop]> {
    gradient(paint).map(BaseGradient::stops)
}

fn gradient(paint: &Paint) -> Option<&BaseGradient> {
    match paint {
        Paint::LinearGradient(g) => Some(g),
        Paint::RadialGradient(g) => Some(g),
        Paint::Color(_) | Paint::Pattern(_) => None,
    }
}

pub fn shows(paint: &Paint) -> bool {
    stops(paint).is_none_or(|stops| stops.iter().any(|s| s.opacity().get() > 0.0))
}

/// 0xRRGGBB; of a gradient the mean of its stops; of a pattern black.
pub fn colour(paint: &Paint) -> u32 {
    let pack = |[r, g, b]: [usize; 3]| (r as u32) << 16 | (g as u32) << 8 | b as u32;
    let channels = |c: Color| [c.red, c.green, c.blue].map(usize::from);
    match (paint, stops(paint)) {
        (Paint::Color(c), _) => pack(channels(*c)),
        (_, Some(stops)) => pack([0, 1, 2].map(|k| stops.iter().map(|s| channels(s.color())[k]).sum::<usize>() / stops.len().max(1))),
        _ => 0,
    }
}

pub fn is_white(colour: u32) -> bool {
    [16, 8, 0].iter().all(|shift| colour >> shift & 0xff >= WHITE)
}

/// Of the whole paint. A pattern lets through what lies beneath.
pub fn least_opacity(paint: &Paint) -> f32 {
    match (paint, stops(paint)) {
        (Paint::Pattern(_), _) => 0.0,
        (_, stops) => stops.unwrap_or(&[]).iter().map(|s| s.opacity().get()).fold(1.0, f32::min),
    }
}

pub fn luminance(c: Color) -> f32 {
    light([c.red, c.green, c.blue, 255].map(|c| c as f32 / 255.0))
}

fn light([red, green, blue, _]: [f32; 4]) -> f32 {
    0.2125 * red + 0.7154 * green + 0.0721 * blue
}

/// A part of a gradient. Borders stand where luminance, opacity or their product pass one half.
pub struct Band {
    pub area: Path, // even-odd, in the gradient's own unit
    pub luminance: f32,
    pub opacity: f32,
}

/// Red, green, blue and opacity, from 0 to 1, at t along the gradient.
fn at(stops: &[Stop], t: f32) -> [f32; 4] {
    let of = |s: &Stop| [s.color().red, s.color().green, s.color().blue].map(|c| c as f32 / 255.0);
    let of = |s: &Stop| [of(s)[0], of(s)[1], of(s)[2], s.opacity().get()];
    let next = stops.iter().position(|s| s.offset().get() > t).unwrap_or(stops.len());
    if next == 0 || next == stops.len() {
        return of(&stops[next.saturating_sub(1)]);
    }
    let (a, b) = (&stops[next - 1], &stops[next]);
    let share = (t - a.offset().get()) / (b.offset().get() - a.offset().get());
    [0, 1, 2, 3].map(|k| of(a)[k] + share * (of(b)[k] - of(a)[k]))
}

/// Where t lies within one period.
fn within(spread: SpreadMethod, t: f32) -> f32 {
    match spread {
        SpreadMethod::Pad => t,
        SpreadMethod::Reflect if t.floor().rem_euclid(2.0) == 1.0 => 1.0 - t.rem_euclid(1.0),
        _ => t.rem_euclid(1.0),
    }
}

/// A gradient's red, green, blue and opacity, from 0 to 1, at a point in its own unit.
pub fn shade(paint: &Paint, p: Point) -> [f32; 4] {
    let t = match paint {
        Paint::LinearGradient(g) => {
            let (start, along) = (Point::from_xy(g.x1(), g.y1()), Point::from_xy(g.x2() - g.x1(), g.y2() - g.y1()));
            Some((p - start).dot(along) / along.dot(along))
        }
        Paint::RadialGradient(g) => {
            // p lies on the circle round focus + t to_centre with the radius fr + t dr.
            let focus = Point::from_xy(g.fx(), g.fy());
            let (to_p, to_centre) = (p - focus, Point::from_xy(g.cx(), g.cy()) - focus);
            let (fr, dr) = (g.fr().get(), g.r().get() - g.fr().get());
            let (a, b) = (to_centre.dot(to_centre) - dr * dr, to_p.dot(to_centre) + fr * dr);
            let root = (b * b - a * (to_p.dot(to_p) - fr * fr)).sqrt();
            let ts = [(b + root) / a, (b - root) / a].into_iter();
            ts.filter(|t| t.is_finite() && fr + t * dr >= 0.0).reduce(f32::max)
        }
        _ => None,
    };
    match (gradient(paint), t) {
        (Some(g), Some(t)) => at(g.stops(), within(g.spread_method(), t)),
        _ => [0.0; 4],
    }
}

/// Where the bands of one period meet, from 0 to 1.
fn borders(stops: &[Stop]) -> Vec<f32> {
    let mut all = vec![0.0, 1.0];
    all.extend(stops.iter().map(|s| s.offset().get()));
    for pair in stops.windows(2) {
        let (from, to) = (pair[0].offset().get(), pair[1].offset().get());
        let inside = |s: f32| at(stops, from + s.clamp(1e-4, 1.0 - 1e-4) * (to - from));
        let (a, b) = (inside(0.0), inside(1.0));
        let parts = ((light(a) - light(b)).abs().max((a[3] - b[3]).abs()) / FINEST).ceil();
        all.extend((1..parts as usize).map(|i| from + (to - from) * i as f32 / parts));
        for measure in [light, |v: [f32; 4]| v[3], |v: [f32; 4]| light(v) * v[3]] {
            let above = |s: f32| measure(inside(s)) > 0.5;
            for i in 0..BEND {
                let (mut low, mut high) = (i as f32 / BEND as f32, (i + 1) as f32 / BEND as f32);
                let side = above(low);
                if side == above(high) {
                    continue;
                }
                for _ in 0..20 {
                    let middle = (low + high) / 2.0;
                    *(if above(middle) == side { &mut low } else { &mut high }) = middle;
                }
                all.push(from + high * (to - from));
            }
        }
    }
    all.sort_by(f32::total_cmp);
    all.dedup();
    all
}

/// The bands that reach into `box_`, which is in the unit of the painted shape, and the transform from
/// their unit to that one. None: not a gradient, or one that is not to be taken apart.
pub fn bands(paint: &Paint, box_: Rect) -> Option<(Vec<Band>, Transform)> {
    cut(paint, box_, false)
}

/// Where the colour leaps from one band to the next: the areas before, whose borders are lines.
pub fn leaps(paint: &Paint, box_: Rect) -> Option<(Vec<Band>, Transform)> {
    cut(paint, box_, true)
}

fn cut(paint: &Paint, box_: Rect, at_leaps: bool) -> Option<(Vec<Band>, Transform)> {
    let gradient = gradient(paint)?;
    let back = gradient.transform().invert()?;
    let mut corners = [(box_.left(), box_.top()), (box_.right(), box_.top()), (box_.left(), box_.bottom()), (box_.right(), box_.bottom())]
        .map(|(x, y)| Point::from_xy(x, y));
    back.map_points(&mut corners);
    let centre = Point::from_xy((corners[0].x + corners[3].x) / 2.0, (corners[0].y + corners[3].y) / 2.0);
    let reach = 1.01 * corners.iter().map(|p| p.distance(centre)).fold(0.0, f32::max) + f32::MIN_POSITIVE;
    let around = Rect::from_ltrb(centre.x - reach, centre.y - reach, centre.x + reach, centre.y + reach)?;
    // The range of t, and the area before t.
    let (from, to, before): (f32, f32, Box<dyn Fn(f32) -> Option<Path>>) = match paint {
        Paint::LinearGradient(g) => {
            let start = Point::from_xy(g.x1(), g.y1());
            let along = Point::from_xy(g.x2(), g.y2()) - start;
            let length = along.length();
            let middle = (centre - start).dot(along) / (length * length);
            let (from, to) = (middle - reach / length, middle + reach / length);
            let side = Point::from_xy(-along.y * reach / length, along.x * reach / length);
            let base = centre - Point::from_xy(along.x * middle, along.y * middle);
            let before = move |t: f32| {
                let mut area = PathBuilder::new();
                for (s, sign) in [(from, 1.0), (t, 1.0), (t, -1.0), (from, -1.0)] {
                    let p = Point::from_xy(base.x + along.x * s + side.x * sign, base.y + along.y * s + side.y * sign);
                    if area.is_empty() { area.move_to(p.x, p.y) } else { area.line_to(p.x, p.y) }
                }
                area.close();
                area.finish()
            };
            (from, to, Box::new(before))
        }
        Paint::RadialGradient(g) => {
            let (centre_g, focus) = (Point::from_xy(g.cx(), g.cy()), Point::from_xy(g.fx(), g.fy()));
            let (r, fr) = (g.r().get(), g.fr().get());
            if r <= fr || focus.distance(centre_g) + fr >= r {
                return None; // a cone
            }
            let to = ((centre.distance(focus) + reach - fr) / (r - fr - focus.distance(centre_g))).max(1.0);
            let before = move |t: f32| {
                let c = Point::from_xy(focus.x + t * (centre_g.x - focus.x), focus.y + t * (centre_g.y - focus.y));
                PathBuilder::from_circle(c.x, c.y, fr + t * (r - fr))
            };
            (0.0, to, Box::new(before))
        }
        _ => return None,
    };
    if !(to - from).is_finite() || gradient.stops().is_empty() {
        return None;
    }
    let period = borders(gradient.stops());
    let (first, last) = match gradient.spread_method() {
        SpreadMethod::Pad => (0.0, 1.0),
        _ if to - from > MOST_PERIODS => return None,
        _ => (from.floor(), to.ceil()),
    };
    let mirrors = |k: f32| gradient.spread_method() == SpreadMethod::Reflect && k.rem_euclid(2.0) == 1.0;
    let mut ends = vec![from];
    for k in (0..(last - first) as i32).map(|k| first + k as f32) {
        let own: Vec<f32> = if mirrors(k) { period.iter().rev().map(|t| 1.0 - t).collect() } else { period.clone() };
        ends.extend(own.iter().map(|t| k + t).filter(|t| *t > from && *t < to));
    }
    ends.push(to);
    let seen_at = |t: f32| at(gradient.stops(), within(gradient.spread_method(), t));
    let mut all = Vec::new();
    let band = |area: Path, t: f32| Band { area, luminance: light(seen_at(t)), opacity: seen_at(t)[3] };
    if at_leaps {
        ends.dedup_by(|a, b| *a - *b < 2.0 * BESIDE);
        for t in &ends[1..ends.len() - 1] {
            let on_white = |c: [f32; 4]| [0, 1, 2].map(|k| 255.0 * (1.0 - c[3] * (1.0 - c[k])));
            let sides = [on_white(seen_at(t - BESIDE)), on_white(seen_at(t + BESIDE))];
            if (0..3).any(|k| (sides[0][k] - sides[1][k]).abs() > LEAP) {
                all.extend(before(*t).map(|area| band(area, *t)));
            }
        }
        return Some((all, gradient.transform()));
    }
    for pair in ends.windows(2).filter(|pair| pair[1] > pair[0]) {
        let mut area = PathBuilder::new();
        let outer = if pair[1] == to { Some(PathBuilder::from_rect(around)) } else { before(pair[1]) };
        let inner = if pair[0] == from { None } else { before(pair[0]) };
        for part in [outer, inner].into_iter().flatten() {
            area.push_path(&part);
        }
        all.extend(area.finish().map(|area| band(area, (pair[0] + pair[1]) / 2.0)));
    }
    Some((all, gradient.transform()))
}
