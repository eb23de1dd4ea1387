//! SVG to visible outlines, through usvg. The layout of what crosses the border is told in impedraw_usvg.h.

use std::collections::HashMap;
use std::ffi::{c_char, CString};
use std::panic::{catch_unwind, AssertUnwindSafe};
use usvg::tiny_skia_path::PathSegment;
use usvg::{roxmltree, Group, ImageHrefResolver, LineCap, Node, Options, Path, Tree};

const MM_PER_PX: f64 = 25.4 / 96.0;

#[repr(C)]
pub struct SvgPath {
    verbs: usize,
    layer: u32,
    stroked: u8,
    filled: u8,
    caps: u8,
}

#[repr(C)]
pub struct Svg {
    error: *const c_char,
    width_mm: f64,
    height_mm: f64,
    paths: *const SvgPath,
    path_count: usize,
    verbs: *const u8,
    points: *const f64,
    layers: *const *const c_char,
    layer_count: usize,
    warnings: *const *const c_char,
    warning_count: usize,
    drawing: Drawing, // owns what the pointers above show
}

#[derive(Default)]
struct Drawing {
    size: (f64, f64),
    paths: Vec<SvgPath>,
    verbs: Vec<u8>,
    points: Vec<f64>,
    layers: Vec<String>,
    warnings: Vec<String>,
    hidden_parts: usize, // clip paths and masks that are passed over
    dashes: usize,
    strings: Vec<CString>,
    pointers: Vec<*const c_char>,
}

impl Drawing {
    fn read(data: &[u8]) -> Result<Drawing, String> {
        let text = std::str::from_utf8(data).map_err(|_| "not a UTF-8 text".to_string())?;
        let xml_options = roxmltree::ParsingOptions { allow_dtd: true, nodes_limit: 4_000_000, ..Default::default() };
        let xml = roxmltree::Document::parse_with_options(text, xml_options).map_err(|e| e.to_string())?;
        if xml.root_element().tag_name().name() != "svg" {
            return Err(format!("the root element is <{}>, not <svg>", xml.root_element().tag_name().name()));
        }
        let options = Options {
            // Nothing outside of the file is read, and pictures inside of it cannot be drawn with a pen.
            image_href_resolver: ImageHrefResolver {
                resolve_data: Box::new(|_, _, _| None),
                resolve_string: Box::new(|_, _| None),
            },
            ..Options::default()
        };
        let tree = Tree::from_xmltree(&xml, &options).map_err(|e| e.to_string())?;
        let mut drawing = Drawing::default();
        drawing.size = (tree.size().width() as f64 * MM_PER_PX, tree.size().height() as f64 * MM_PER_PX);
        drawing.warn_of_elements(&xml);
        let labels = labels_of(&xml);

        // usvg wraps everything in one nameless group where the viewBox scales the page.
        let mut top = tree.root();
        if let [Node::Group(only)] = top.children() {
            if only.id().is_empty() {
                top = only;
            }
        }
        let mut loose = None; // the layer of what stands in no group
        for (index, node) in top.children().iter().enumerate() {
            let layer = match node {
                Node::Group(g) if !g.id().is_empty() || g.children().len() > 1 => {
                    let name = labels.get(g.id()).map(|s| s.to_string());
                    drawing.layers.push(name.unwrap_or_else(|| (index + 1).to_string()));
                    drawing.layers.len() - 1
                }
                _ => *loose.get_or_insert_with(|| {
                    drawing.layers.push("page".to_string());
                    drawing.layers.len() - 1
                }),
            };
            drawing.add_node(node, layer as u32);
        }
        if drawing.hidden_parts > 0 {
            let what = format!("{} clip paths or masks are passed over: what they hide is drawn", drawing.hidden_parts);
            drawing.warnings.push(what);
        }
        if drawing.dashes > 0 {
            drawing.warnings.push(format!("{} dashed lines are drawn unbroken", drawing.dashes));
        }
        Ok(drawing)
    }

    fn warn_of_elements(&mut self, xml: &roxmltree::Document) {
        for (tag, consequence) in [
            ("text", "text is left out: convert it to paths first"),
            ("image", "pictures are left out: a pen draws lines only"),
            ("foreignObject", "foreign objects are left out"),
        ] {
            let count = xml.descendants().filter(|n| n.is_element() && n.tag_name().name() == tag).count();
            if count > 0 {
                self.warnings.push(format!("{count} × <{tag}>: {consequence}"));
            }
        }
    }

    fn add_group(&mut self, group: &Group, layer: u32) {
        if group.opacity().get() == 0.0 {
            return;
        }
        self.hidden_parts += group.clip_path().is_some() as usize + group.mask().is_some() as usize;
        for node in group.children() {
            self.add_node(node, layer);
        }
    }

    fn add_node(&mut self, node: &Node, layer: u32) {
        match node {
            Node::Group(group) => self.add_group(group, layer),
            Node::Path(path) => self.add_path(path, layer),
            _ => {}
        }
    }

    fn add_path(&mut self, path: &Path, layer: u32) {
        let stroke = path.stroke().filter(|s| s.opacity().get() > 0.0);
        let filled = path.fill().is_some_and(|f| f.opacity().get() > 0.0);
        if !path.is_visible() || (stroke.is_none() && !filled) {
            return;
        }
        self.dashes += stroke.is_some_and(|s| s.dasharray().is_some()) as usize;
        let first = self.verbs.len();
        let ts = path.abs_transform();
        let mut put = |verb: u8, points: &[usvg::tiny_skia_path::Point]| {
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
        self.paths.push(SvgPath {
            verbs: self.verbs.len() - first,
            layer,
            stroked: stroke.is_some() as u8,
            filled: filled as u8,
            caps: stroke.is_some_and(|s| s.linecap() != LineCap::Butt) as u8,
        });
    }
}

/// A group's id → the name that its author sees: Inkscape's label where there is one.
fn labels_of<'a>(xml: &'a roxmltree::Document) -> HashMap<&'a str, &'a str> {
    let inkscape = "http://www.inkscape.org/namespaces/inkscape";
    let named = |n: roxmltree::Node<'a, '_>| Some((n.attribute("id")?, n.attribute((inkscape, "label")).or(n.attribute("id"))?));
    xml.descendants().filter_map(named).collect()
}

fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ").replace('\n', " ")).unwrap_or_default()
}

/// # Safety
/// `data` shows `size` readable bytes.
#[no_mangle]
pub unsafe extern "C" fn impedraw_svg_read(data: *const u8, size: usize) -> *const Svg {
    let bytes: &[u8] = if size == 0 { &[] } else { std::slice::from_raw_parts(data, size) };
    std::panic::set_hook(Box::new(|_| {})); // told by the error below, in one line
    let result = catch_unwind(AssertUnwindSafe(|| Drawing::read(bytes)));
    let _ = std::panic::take_hook();
    let read = result.unwrap_or_else(|_| Err("usvg gave up on it".to_string()));
    let (mut drawing, error) = match read {
        Ok(drawing) => (drawing, None),
        Err(error) => (Drawing::default(), Some(c_string(&error))),
    };
    let layer_count = drawing.layers.len();
    let warning_count = drawing.warnings.len();
    drawing.strings = drawing.layers.iter().chain(&drawing.warnings).map(|s| c_string(s)).collect();
    drawing.strings.extend(error);
    drawing.pointers = drawing.strings.iter().map(|s| s.as_ptr()).collect();
    let error = drawing.pointers.get(layer_count + warning_count).copied();
    Box::into_raw(Box::new(Svg {
        error: error.unwrap_or(std::ptr::null()),
        width_mm: drawing.size.0,
        height_mm: drawing.size.1,
        paths: drawing.paths.as_ptr(),
        path_count: drawing.paths.len(),
        verbs: drawing.verbs.as_ptr(),
        points: drawing.points.as_ptr(),
        layers: drawing.pointers.as_ptr(),
        layer_count,
        warnings: drawing.pointers[layer_count..].as_ptr(),
        warning_count,
        drawing,
    }))
}

/// # Safety
/// `svg` comes from `impedraw_svg_read` and is given back once.
#[no_mangle]
pub unsafe extern "C" fn impedraw_svg_free(svg: *const Svg) {
    if !svg.is_null() {
        drop(Box::from_raw(svg as *mut Svg));
    }
}
