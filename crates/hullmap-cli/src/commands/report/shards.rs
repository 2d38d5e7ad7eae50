//! Reports of several machines: each writes the pages of its shard, and the cards of the overview
//! as JSON beside them. A last run merges the cards.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use hullmap_report::Card;
use serde::{Deserialize, Serialize};

use hullmap_pipeline::jobs::shard::{Shard, shard_of};
use hullmap_pipeline::outcome::Failure;

/// Maximum size of a shard's cards in bytes: about a hundred thousand packs.
const MAX_BYTES: u64 = 1 << 30;

#[derive(Deserialize, Serialize)]
pub struct ShardCards {
    index: u32,
    count: u32,
    cards: Vec<Card>,
}

impl ShardCards {
    pub fn new(shard: Shard, cards: Vec<Card>) -> Self {
        Self { index: shard.index(), count: shard.count(), cards }
    }
}

pub fn file(pages: &Path, shard: Shard) -> PathBuf {
    pages.join(format!("shard-{}-of-{}.json", shard.index(), shard.count()))
}

/// The cards of all `names`, in that order, from the files in the folder of the pages.
pub fn merged(pages: &Path, names: &[String]) -> Result<Vec<Card>, Failure> {
    let shards = read_all(pages)?;
    let Some(count) = shards.first().map(|shard| shard.count) else {
        let message =
            format!("{}: this folder has no report of a shard; run `bake report` with --shard first", pages.display());
        return Err(Failure::usage(message));
    };
    if shards.iter().any(|shard| shard.count != count) {
        let message = "it has reports for different numbers of shards; remove the reports for the wrong number";
        return Err(Failure::usage(format!("{}: {message}", pages.display())));
    }
    let mut cards: BTreeMap<String, Card> = BTreeMap::new();
    for card in shards.into_iter().flat_map(|shard| shard.cards) {
        cards.insert(card.name().to_owned(), card);
    }
    let missing = |name: &&String| !cards.contains_key(*name);
    let missing: BTreeSet<u32> = names.iter().filter(missing).map(|name| shard_of(name, count)).collect();
    if !missing.is_empty() {
        let list: Vec<String> = missing.iter().map(|index| format!("{index}/{count}")).collect();
        let message = format!(
            "packs of these shards have no report: {}; run `bake report` with --shard for them",
            list.join(", ")
        );
        return Err(Failure::usage(format!("{}: {message}", pages.display())));
    }
    Ok(names.iter().filter_map(|name| cards.remove(name)).collect())
}

fn read_all(pages: &Path) -> Result<Vec<ShardCards>, Failure> {
    let mut shards = Vec::new();
    let entries = std::fs::read_dir(pages).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| is_shard(path)).collect();
    paths.sort();
    for path in paths {
        let fault = |fault: String| {
            Failure::rejected(format!("{}: {fault}; run `bake report` with --shard again", path.display()))
        };
        let mut bytes = Vec::new();
        File::open(&path)
            .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
            .map_err(|error| Failure::usage(format!("{}: cannot read: {error}; check the file", path.display())))?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(fault(format!("it has more than {MAX_BYTES} bytes")));
        }
        let shard: ShardCards = serde_json::from_slice(&bytes).map_err(|error| fault(error.to_string()))?;
        if !shard.cards.iter().all(Card::is_sound) {
            return Err(fault("an image in it is invalid".to_owned()));
        }
        shards.push(shard);
    }
    Ok(shards)
}

fn is_shard(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let middle = name.strip_prefix("shard-").and_then(|rest| rest.strip_suffix(".json"));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let numbers = middle.and_then(|middle| middle.split_once("-of-"));
    numbers.is_some_and(|(index, count)| is_number(index) && is_number(count)) && path.is_file()
}
