//! usvg reports what it skips only through the `log` crate. These lines are collected for the
//! thread that reads the document.

use std::cell::RefCell;

const MOST: usize = 20; // distinct messages
const LONGEST: usize = 160; // characters

thread_local! {
    static HEARD: RefCell<Vec<(String, usize)>> = const { RefCell::new(Vec::new()) };
}

struct Listener;

impl log::Log for Listener {
    fn enabled(&self, metadata: &log::Metadata) -> bool {
        metadata.level() <= log::Level::Warn && metadata.target().starts_with("usvg")
    }

    fn log(&self, record: &log::Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let mut text = record.args().to_string();
        let link = |name| text.starts_with(&format!("Failed to parse {name}")) && (name == "href" || text.contains("url("));
        if text.starts_with("Image") || ["href", "clip-path", "mask"].iter().any(|name| link(*name)) {
            return; // reported in another way
        }
        if let Some((end, _)) = text.char_indices().nth(LONGEST) {
            text.truncate(end);
            text.push('…');
        }
        let text = text.trim_end_matches('.').to_string();
        HEARD.with_borrow_mut(|heard| {
            let different = heard.len();
            match heard.iter_mut().find(|(said, _)| *said == text) {
                Some((_, times)) => *times += 1,
                None if different <= MOST => heard.push((text, 1)),
                None => heard[MOST].1 += 1,
            }
        });
    }

    fn flush(&self) {}
}

pub fn listen() {
    static LISTENER: Listener = Listener;
    let _ = log::set_logger(&LISTENER); // fails after the first time: it is already set
    log::set_max_level(log::LevelFilter::Warn);
    HEARD.with_borrow_mut(|heard| heard.clear());
}

pub fn heard() -> Vec<String> {
    let told = HEARD.with_borrow_mut(std::mem::take);
    let line = |(index, (text, times)): (usize, (String, usize))| match (index, times) {
        (MOST, _) => format!("{times} more of the kind"),
        (_, 1) => text,
        _ => format!("{times} × {text}"),
    };
    told.into_iter().enumerate().map(line).collect()
}
