//! Fonts that the document holds: rules `@font-face` with data of TrueType, OpenType, WOFF or WOFF2.

use crate::document;
use std::sync::Arc;
use usvg::fontdb::{Database, FaceInfo, Language, Source, Style, Weight, ID};
use usvg::roxmltree::Document;

/// Name and value of each declaration. A data URL has semicolons of its own.
fn declarations(block: &str) -> Vec<(&str, &str)> {
    let (mut quote, mut within) = (None, 0);
    let ends = |c: char| {
        match (quote, c) {
            (Some(mark), _) if c == mark => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '(') => within += 1,
            (None, ')') => within -= 1,
            _ => {}
        }
        c == ';' && quote.is_none() && within == 0
    };
    block.split(ends).filter_map(|part| part.split_once(':')).map(|(name, value)| (name.trim(), value.trim())).collect()
}

fn unquoted(text: &str) -> &str {
    text.trim().trim_matches(['"', '\''])
}

/// The font's file. None: the URL leads out of the document, where nothing is read.
fn file_of(url: &str) -> Option<Result<Vec<u8>, String>> {
    let url = data_url::DataUrl::process(url).ok()?;
    let Ok((data, _)) = url.decode_to_vec() else { return Some(Err("is no base64".to_string())) };
    let packed = |e| format!("cannot be unpacked ({e:?})");
    Some(match data.get(..4) {
        Some(b"wOFF") => wuff::decompress_woff1(&data).map_err(packed),
        Some(b"wOF2") => wuff::decompress_woff2(&data).map_err(packed),
        _ => Ok(data),
    })
}

/// Puts the font of one rule into `fonts` under the rule's name, in place of those that have it.
fn put(rule: &[(&str, &str)], fonts: &mut Database) -> Result<(), String> {
    let of = |wanted: &str| rule.iter().find(|(name, _)| *name == wanted).map(|(_, value)| *value);
    let (Some(family), Some(sources)) = (of("font-family").map(unquoted), of("src")) else { return Ok(()) };
    let urls = sources.split("url(").skip(1).filter_map(|url| url.split_once(')')).map(|(url, _)| unquoted(url));
    let Some(file) = urls.filter_map(file_of).reduce(|first, second| first.or(second)) else { return Ok(()) };
    let named = |what: &str| format!("the font '{family}', which the file holds, {what}");
    let ids = fonts.load_font_source(Source::Binary(Arc::new(file.map_err(|what| named(&what))?)));
    let mut face = ids.first().and_then(|id| fonts.face(*id)).cloned().ok_or(named("cannot be read"))?;
    ids.iter().for_each(|id| fonts.remove_face(*id));
    face.families = vec![(family.to_string(), Language::English_UnitedStates)];
    match of("font-weight") {
        Some("normal") => face.weight = Weight::NORMAL,
        Some("bold") => face.weight = Weight::BOLD,
        Some(number) => face.weight = number.parse().map_or(face.weight, Weight),
        None => {}
    }
    match of("font-style") {
        Some(slant) if slant.starts_with("italic") => face.style = Style::Italic,
        Some(slant) if slant.starts_with("oblique") => face.style = Style::Oblique,
        Some(_) => face.style = Style::Normal,
        None => {}
    }
    let is_installed = |f: &FaceInfo| !matches!(f.source, Source::Binary(_)) && f.families.iter().any(|(name, _)| *name == family);
    let installed: Vec<ID> = fonts.faces().filter(|f| is_installed(f)).map(|f| f.id).collect();
    installed.into_iter().for_each(|id| fonts.remove_face(id));
    fonts.push_face_info(face);
    Ok(())
}

/// The document's fonts in place of installed ones of their names. Returns what could not be read.
pub fn load(xml: &Document, fonts: &mut Database) -> Vec<String> {
    let mut faults = Vec::new();
    for sheet in document::style_sheets(xml).filter_map(|n| n.text()) {
        for rule in sheet.split("@font-face").skip(1).filter_map(|after| after.split_once('{')?.1.split_once('}')) {
            faults.extend(put(&declarations(rule.0), fonts).err());
        }
    }
    faults
}
