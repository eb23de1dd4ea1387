//! Reads the visible outlines of an SVG document with usvg. impedraw_usvg.h documents the C ABI.
//!
//! limits.rs      bounds on time and memory
//! dtd.rs         what the internal DTD adds to the document
//! document.rs    text and XML, before usvg
//! outlines.rs    usvg's tree as paths
//! clips.rs       clip paths and masks
//! paints.rs      colours and gradients
//! servers.rs     what patterns and gradients draw
//! texts.rs       fonts and letters
//! transforms.rs  transforms of CSS
//! labels.rs      labels in HTML
//! references.rs  what the document refers to and does not hold
//! font.rs        SVG 1.1 fonts
//! font_face.rs   fonts that the document holds
//! complaints.rs  usvg's messages

mod clips;
mod complaints;
mod document;
mod dtd;
mod font;
mod font_face;
mod labels;
mod limits;
mod outlines;
mod paints;
mod references;
mod servers;
mod texts;
mod transforms;

use outlines::{Outlines, SvgClip, SvgGroup, SvgPath};
use std::ffi::{c_char, CString};

#[repr(C)]
pub struct Svg {
    error: *const c_char,
    width_mm: f64,
    height_mm: f64,
    paths: *const SvgPath,
    path_count: usize,
    clips: *const SvgClip,
    clip_count: usize,
    groups: *const SvgGroup,
    group_count: usize,
    verbs: *const u8,
    points: *const f64,
    dashes: *const f64,
    layers: *const *const c_char,
    layer_count: usize,
    named: u8,
    warnings: *const *const c_char,
    warning_count: usize,
    outlines: Outlines, // these three own the data that the pointers above refer to
    _strings: Vec<CString>,
    pointers: Vec<*const c_char>,
}

fn c_string(text: &str) -> CString {
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    CString::new(line).unwrap_or_default()
}

/// Errors are one line each; nothing is printed.
fn read(bytes: &[u8], reader: fn(&[u8]) -> Result<Outlines, String>) -> Result<Outlines, String> {
    static SILENCE: std::sync::Once = std::sync::Once::new();
    SILENCE.call_once(|| std::panic::set_hook(Box::new(|_| {}))); // permanently: an abandoned thread may panic later
    limits::within(bytes.to_vec(), reader)
}

/// # Safety
/// `data` must point to `size` readable bytes.
#[no_mangle]
pub unsafe extern "C" fn impedraw_svg_read(data: *const u8, size: usize) -> *const Svg {
    read_with(data, size, |data| Outlines::read(data, false))
}

/// # Safety
/// `data` must point to `size` readable bytes.
#[no_mangle]
pub unsafe extern "C" fn impedraw_svg_letters(data: *const u8, size: usize) -> *const Svg {
    read_with(data, size, |data| Outlines::read(data, true))
}

/// # Safety
/// `data` must point to `size` readable bytes.
#[no_mangle]
pub unsafe extern "C" fn impedraw_svg_font(data: *const u8, size: usize) -> *const Svg {
    read_with(data, size, font::read)
}

unsafe fn read_with(data: *const u8, size: usize, reader: fn(&[u8]) -> Result<Outlines, String>) -> *const Svg {
    let bytes: &[u8] = if size == 0 { &[] } else { std::slice::from_raw_parts(data, size) };
    let (outlines, error) = match read(bytes, reader) {
        Ok(outlines) => (outlines, None),
        Err(error) => (Outlines::default(), Some(c_string(&error))),
    };
    let layer_count = outlines.layers.len();
    let warning_count = outlines.warnings.len();
    let mut strings: Vec<CString> = outlines.layers.iter().chain(&outlines.warnings).map(|s| c_string(s)).collect();
    strings.extend(error);
    let pointers: Vec<*const c_char> = strings.iter().map(|s| s.as_ptr()).collect();
    let error = pointers.get(layer_count + warning_count).copied();
    let mut svg = Box::new(Svg {
        error: error.unwrap_or(std::ptr::null()),
        width_mm: outlines.size.0,
        height_mm: outlines.size.1,
        paths: outlines.paths.as_ptr(),
        path_count: outlines.paths.len(),
        clips: outlines.clips.as_ptr(),
        clip_count: outlines.clips.len(),
        groups: outlines.groups.as_ptr(),
        group_count: outlines.groups.len(),
        verbs: outlines.verbs.as_ptr(),
        points: outlines.points.as_ptr(),
        dashes: outlines.dashes.as_ptr(),
        layers: std::ptr::null(),
        layer_count,
        named: outlines.named as u8,
        warnings: std::ptr::null(),
        warning_count,
        outlines,
        _strings: strings,
        pointers,
    });
    svg.layers = svg.pointers.as_ptr();
    svg.warnings = svg.pointers[layer_count..].as_ptr();
    debug_assert_eq!(svg.path_count, svg.outlines.paths.len());
    Box::into_raw(svg)
}

/// # Safety
/// `svg` must come from `impedraw_svg_read`, and `rgba` point to four numbers.
#[no_mangle]
pub unsafe extern "C" fn impedraw_svg_shade(svg: *const Svg, path: usize, of_stroke: u8, x: f64, y: f64, rgba: *mut f32) {
    let shade = (*svg).outlines.shade(path, of_stroke != 0, x, y);
    std::ptr::copy_nonoverlapping(shade.as_ptr(), rgba, 4);
}

/// # Safety
/// `svg` must come from `impedraw_svg_read`, and must be freed only once.
#[no_mangle]
pub unsafe extern "C" fn impedraw_svg_free(svg: *const Svg) {
    if !svg.is_null() {
        drop(Box::from_raw(svg as *mut Svg));
    }
}
