//! The page of a folder: a card with a picture for each pack.

use std::fmt::Write;

use super::html::{count, escape, fill, link};
use super::pack_page::{FAULTS, STYLE};

const PAGE: &str = include_str!("page/folder.html");
const SCRIPT: &str = include_str!("page/folder.js");

/// What the folder's page says of a pack.
#[derive(Debug)]
pub struct Card {
    /// The pack, below the folder.
    pub name: String,
    /// How it stands, as HTML.
    pub verdict: String,
    /// Whether there are faults.
    pub is_faulty: bool,
    /// Whether no hull is a simplified one.
    pub is_exact: bool,
    /// What is wrong or may surprise.
    pub remarks: Vec<String>,
    /// What the pack holds; `None` where it does not open.
    pub content: Option<Content>,
}

/// What a card says of a pack that opens.
#[derive(Debug)]
pub struct Content {
    /// Its page, relative to the folder's.
    pub page: String,
    /// Its picture, as a `data:` address.
    pub picture: String,
    /// Number of hulls.
    pub hulls: usize,
    /// Vertices over all hulls.
    pub vertices: usize,
    /// Bytes of the pack.
    pub bytes: usize,
}

/// The page of a folder.
pub fn folder_page(folder: &str, cards: &[Card]) -> String {
    let failed = cards.iter().filter(|card| card.is_faulty).count();
    let sum = |pick: fn(&Content) -> usize| {
        count(cards.iter().filter_map(|card| card.content.as_ref()).map(pick).sum::<usize>() as u64)
    };
    let packs = |number: usize| format!("{} {}", count(number as u64), if number == 1 { "pack" } else { "packs" });
    let subtitle = format!(
        "{} · {} hulls · {} vertices · {} bytes",
        packs(cards.len()),
        sum(|content| content.hulls),
        sum(|content| content.vertices),
        sum(|content| content.bytes)
    );
    let verdict = if failed == 0 {
        let word = if cards.iter().all(|card| card.is_exact) { "all exact" } else { "all verified" };
        format!("<span class=\"chip good\">{word}</span>")
    } else {
        format!("<span class=\"chip bad\">{} failed</span>", packs(failed))
    };
    let cards: String = cards.iter().map(card).collect();
    let script = [FAULTS, SCRIPT].concat();
    let footer = "Made by <code>bake report</code>. Each pack has a page of its own in the folder beside this one.";
    fill(
        PAGE,
        &[
            ("title", &escape(folder)),
            ("style", STYLE),
            ("verdict", &verdict),
            ("subtitle", &subtitle),
            ("cards", &cards),
            ("script", &script),
            ("footer", footer),
        ],
    )
}

fn card(card: &Card) -> String {
    let name = escape(&card.name);
    let is_odd = card.is_faulty || !card.remarks.is_empty();
    let mut out = format!("<li data-name=\"{name}\" data-odd=\"{is_odd}\">\n");
    match &card.content {
        Some(content) => {
            let page = escape(&link(&content.page));
            let hulls = if content.hulls == 1 { "hull" } else { "hulls" };
            let _ = write!(
                out,
                "<a class=\"picture\" href=\"{page}\" tabindex=\"-1\" aria-hidden=\"true\"><img src=\"{}\" width=\"160\" height=\"120\" alt=\"\"></a>\n\
                 <div class=\"text\"><h2><a href=\"{page}\">{name}</a></h2>{}\n<p>{} {hulls} · {} vertices · {} bytes</p>\n",
                content.picture,
                card.verdict,
                count(content.hulls as u64),
                count(content.vertices as u64),
                count(content.bytes as u64)
            );
        }
        None => {
            let _ = write!(
                out,
                "<div class=\"picture soft\">no picture</div>\n<div class=\"text\"><h2>{name}</h2>{}\n",
                card.verdict
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
