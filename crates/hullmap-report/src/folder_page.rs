//! The page of a folder: a card with a picture for each pack.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use crate::Analysis;
use crate::html::{count, escape, link, sentence, size};
use crate::page::Page;
use crate::surface::SurfaceReport;
use crate::verdict::{Verdict, headline};

const PAGE: Page = Page {
    kind: "folder",
    generator: "bake report",
    style: "",
    contents: include_str!("page/folder.html"),
    scripts: &[include_str!("page/folder.js")],
};

const PICTURE: &str = "data:image/png;base64,";

/// One pack on a folder's page. It can be written to a file and read again, so that several
/// machines can make the pages of one folder.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Card {
    /// The pack's path below the folder, without extension.
    name: String,
    verdict: Verdict,
    /// Faults, then warnings.
    remarks: Vec<String>,
    /// The verdict as a sentence.
    headline: String,
    /// Contents of the pack; `None` if it does not open.
    content: Option<Content>,
}

#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
struct Content {
    /// Path of its page, relative to the folder's.
    page: String,
    /// Its picture, as a `data:` URL.
    picture: String,
    hulls: usize,
    triangles: usize,
    vertices: usize,
    bytes: usize,
}

impl Card {
    /// The card of a pack that opens; `page` is the path of its own page, relative to the folder's.
    pub fn new(name: String, pack: &Analysis, page: String) -> Self {
        Self {
            name,
            verdict: Verdict::new(pack),
            remarks: pack.remarks.faults.iter().chain(&pack.remarks.warnings).cloned().collect(),
            headline: headline(pack),
            content: Some(Content {
                page,
                picture: pack.picture.clone(),
                hulls: pack.hull_count,
                triangles: 0,
                vertices: pack.vertex_count,
                bytes: pack.bytes,
            }),
        }
    }

    /// The card of a triangle mesh or height field; `page` is the path of its own page, relative to
    /// the folder's.
    pub fn of_surface(name: String, surface: &SurfaceReport, page: String) -> Self {
        Self {
            name,
            verdict: surface.verdict(),
            remarks: surface.remarks.faults.iter().chain(&surface.remarks.warnings).cloned().collect(),
            headline: surface.headline.clone(),
            content: Some(Content {
                page,
                picture: surface.picture.clone(),
                hulls: 0,
                triangles: surface.triangle_count,
                vertices: surface.vertex_count,
                bytes: surface.bytes,
            }),
        }
    }

    /// The pack's path below the folder, without extension.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the pack was rejected.
    pub fn is_faulty(&self) -> bool {
        self.verdict.words().0 == "bad"
    }

    /// Whether the card, if it was read from a file, has a picture that is a plain image.
    pub fn is_sound(&self) -> bool {
        self.content.as_ref().is_none_or(|content| {
            let data = content.picture.strip_prefix(PICTURE);
            data.is_some_and(|data| data.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+/=".contains(&byte)))
        })
    }

    /// The card of a pack that does not open, with the reason.
    pub fn unopened(name: String, reason: String) -> Self {
        Self { name, verdict: Verdict::NotOpened, headline: reason, remarks: Vec::new(), content: None }
    }
}

/// The page of a folder.
///
/// Its verdict combines the verdicts of the cards.
pub fn folder_page(folder: &str, cards: &[Card]) -> String {
    let sum = |pick: fn(&Content) -> usize| {
        count(cards.iter().filter_map(|card| card.content.as_ref()).map(pick).sum::<usize>() as u64)
    };
    let triangles = match sum(|content| content.triangles) {
        none if none == "0" => String::new(),
        some => format!(" · {some} triangles"),
    };
    let bytes = cards.iter().filter_map(|card| card.content.as_ref()).map(|content| content.bytes).sum();
    let headline = format!(
        "{} · {} hulls{triangles} · {} vertices · {}",
        match cards.len() {
            1 => "1 file".to_owned(),
            files => format!("{} files", count(files as u64)),
        },
        sum(|content| content.hulls),
        sum(|content| content.vertices),
        size(bytes)
    );
    let cards_html: String = cards.iter().map(item).collect();
    let footer = "Made by <code>bake report</code>. Each file has a page of its own, in the folder beside this one.";
    PAGE.fill(&[
        ("title", &escape(folder)),
        ("verdict", &verdict(cards)),
        ("headline", &headline),
        ("cards", &cards_html),
        ("footer", footer),
    ])
}

/// The verdicts of all cards in words: all that are not good, or one for all.
fn verdict(cards: &[Card]) -> String {
    let doubts = Verdict::DOUBTS.iter().filter_map(|doubt| {
        let n = cards.iter().filter(|card| card.verdict == *doubt).count();
        let (class, word) = doubt.words();
        (n > 0).then(|| format!("<span class=\"chip {class}\">{word}: {n}</span>"))
    });
    let doubts: String = doubts.collect();
    if !doubts.is_empty() {
        return doubts;
    }
    let word = if cards.iter().all(|card| card.verdict == Verdict::Exact) { "all exact" } else { "all verified" };
    format!("<span class=\"chip good\">{word}</span>")
}

fn item(card: &Card) -> String {
    let name = escape(&card.name);
    let is_odd = card.verdict.words().0 != "good" || !card.remarks.is_empty();
    let mut out = format!("<li data-name=\"{name}\" data-odd=\"{is_odd}\">\n");
    match &card.content {
        Some(content) => {
            let page = escape(&link(&content.page));
            let _ = write!(
                out,
                "<a class=\"picture\" href=\"{page}\" tabindex=\"-1\" aria-hidden=\"true\"><img src=\"{}\" width=\"160\" height=\"120\" alt=\"\"></a>\n\
                 <div class=\"text\"><h2><a href=\"{page}\">{name}</a></h2>{}\n<p class=\"said\">{}</p>\n<p>{} vertices · {}</p>\n",
                content.picture,
                card.verdict.html(),
                sentence(&card.headline),
                count(content.vertices as u64),
                size(content.bytes)
            );
        }
        None => {
            let _ = write!(
                out,
                "<div class=\"picture soft\">no picture</div>\n<div class=\"text\"><h2>{name}</h2>{}\n<p class=\"said\">{}</p>\n",
                card.verdict.html(),
                sentence(&card.headline)
            );
        }
    }
    if let Some(first) = card.remarks.first() {
        let more = card.remarks.len() - 1;
        let more = if more > 0 { format!(" (and {} more)", count(more as u64)) } else { String::new() };
        let _ = writeln!(out, "<p>{}{more}</p>", escape(first));
    }
    out + "</div>\n</li>\n"
}
