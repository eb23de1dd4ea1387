//! CSS transforms in the words of SVG's attribute, which are all that usvg reads: numbers without
//! units, and no function for one axis alone.

/// A number with a CSS unit of length or angle, in user units or degrees. None: another unit.
fn plain(word: &str) -> Option<f64> {
    let unit = word.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-'));
    let factor = match unit {
        "" | "px" | "deg" => 1.0,
        "mm" => 96.0 / 25.4,
        "cm" => 96.0 / 2.54,
        "in" => 96.0,
        "pt" => 96.0 / 72.0,
        "pc" => 16.0,
        "rad" => 180.0 / std::f64::consts::PI,
        "grad" => 0.9,
        "turn" => 360.0,
        _ => return None,
    };
    Some(factor * word[..word.len() - unit.len()].parse::<f64>().ok()?)
}

/// The value as SVG's attribute has it. None: it is so already, or says what no attribute can.
fn as_attribute(value: &str) -> Option<String> {
    let mut functions = Vec::new();
    for function in value.split_inclusive(')').map(str::trim).filter(|f| !f.is_empty()) {
        let (name, words) = function.strip_suffix(')')?.split_once('(')?;
        let words = words.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty());
        let n = words.map(plain).collect::<Option<Vec<_>>>()?;
        let (name, n) = match (name.trim(), n.as_slice()) {
            ("translateX", [x]) => ("translate", vec![*x, 0.0]),
            ("translateY", [y]) => ("translate", vec![0.0, *y]),
            ("translate3d", [x, y, _]) => ("translate", vec![*x, *y]),
            ("scaleX", [x]) => ("scale", vec![*x, 1.0]),
            ("scaleY", [y]) => ("scale", vec![1.0, *y]),
            ("rotateZ", [a]) => ("rotate", vec![*a]),
            (name @ ("translate" | "scale" | "rotate" | "skewX" | "skewY" | "matrix"), _) => (name, n),
            _ => return None,
        };
        let n = n.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        functions.push(format!("{name}({n})"));
    }
    let plain = functions.join(" ");
    (!plain.is_empty() && plain != value).then_some(plain)
}

/// A style sheet's or a style attribute's text with each transform so; what it is otherwise.
pub fn rewritten(style: &str) -> String {
    const NAME: &str = "transform";
    let mut text = String::new();
    let mut rest = style;
    while let Some(at) = rest.find(NAME) {
        let after = rest[at + NAME.len()..].trim_start();
        let own = !rest[..at].ends_with(|c: char| c == '-' || c.is_alphanumeric());
        let colon = rest.len() - after.len() + usize::from(after.starts_with(':'));
        let end = colon + rest[colon..].find([';', '}']).unwrap_or(rest.len() - colon);
        text.push_str(&rest[..colon]);
        let value = &rest[colon..end];
        match as_attribute(value.trim()).filter(|_| own && after.starts_with(':')) {
            Some(plain) => text.push_str(&plain),
            None => text.push_str(value),
        }
        rest = &rest[end..];
    }
    text + rest
}
