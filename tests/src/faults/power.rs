//! Possible contents of a disk after a power cut.
//!
//! 1. A bake is traced, and its calls become [`Op`]s on a simulated disk.
//! 2. The power is cut after each operation. Synced data is kept. Any part of the rest may be kept:
//!    any subset of a folder's entries, in any order; of each file no bytes, half of them, all of
//!    them, or zeros of the same length.
//! 3. Each possible disk must contain only old and new packs, and a bake on a real disk with the
//!    same contents must replace all old packs.
//!
//! POSIX allows all of this. Current file systems lose less: they keep the order of entries.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
};

use super::{
    inject::{Call, Fault, Injector},
    project::{Files, Project, WORDS},
};

/// Maximum number of unsynced entries of which every subset is tried. Above it, the subsets are:
/// each run of the first ones, each entry alone, and all but one.
const MAX_ALL_SUBSETS: usize = 6;

/// An operation of a bake on the disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Op {
    /// A folder is made.
    Folder(String),
    /// An empty file is made.
    Create(String),
    /// A number of bytes is appended to a file.
    Write(String, usize),
    /// A file's bytes, or a folder's entries, are synced.
    Sync(String),
    /// A file is renamed, and replaces the file at its new path.
    Rename(String, String),
    /// A file is removed.
    Remove(String),
}

/// Results of the cuts.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Operations of the bake.
    pub ops: usize,
    /// Possible disks after a cut, over all cuts.
    pub disks: usize,
    /// Number of different disks among these.
    pub distinct: usize,
    /// Distinct disks on which a later bake replaced all outputs.
    pub healed: usize,
    /// Failed checks.
    pub wrong: Vec<String>,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ops, disks, distinct, healed, wrong } = self;
        let wrong = wrong.len();
        write!(
            f,
            "power cut after each of {ops} operations: {disks} disks, {distinct} distinct; {healed} healed; {wrong} wrong"
        )
    }
}

/// Operations of an undisturbed bake of the project on the disk, on one thread. Panics on failure.
pub fn record(project: &Project, injector: &Injector) -> Vec<Op> {
    project.put(&project.old);
    let words: Vec<&str> = WORDS.into_iter().chain(["--jobs", "1"]).collect();
    let (run, calls) = injector.run(project.binary(), &words, project.folder(), 0, Fault::None);
    assert!(run.status.success(), "{run:?}");
    ops(&calls, project)
}

fn ops(calls: &[Call], project: &Project) -> Vec<Op> {
    let root = format!("{}/", project.folder().canonicalize().expect("it is there").display());
    let relative = |path: &str| path.strip_prefix(&root).map(|path| path.replace("/./", "/")).unwrap_or_default();
    let mut known: BTreeSet<String> = project.old.keys().cloned().collect();
    let mut ops = Vec::new();
    for call in calls.iter().filter(|call| call.result >= 0) {
        let path = relative(&call.path);
        let is_known = known.contains(&path);
        match call.name.as_str() {
            "open" if call.bytes > 0 && !is_known => {
                known.insert(path.clone());
                ops.push(Op::Create(path));
            }
            "write" => ops.push(Op::Write(path, call.result as usize)),
            "fsync" => ops.push(Op::Sync(path)),
            "mkdir" => ops.push(Op::Folder(path)),
            "unlink" => ops.push(Op::Remove(path)),
            "rename" => {
                known.insert(relative(&call.second));
                ops.push(Op::Rename(path, relative(&call.second)));
            }
            "open" | "read" | "stat" | "lstat" | "readlink" | "access" | "list" | "lock" | "map" => {}
            other => panic!("the simulated disk does not support {other}"),
        }
    }
    ops
}

/// Cuts the power after each operation of `ops`, of which the last is the end of a bake that
/// claimed success; bakes on every `stride`th of the disks that differ.
pub fn cut(project: &Project, ops: &[Op], stride: usize) -> Tally {
    let mut tally = Tally { ops: ops.len(), ..Tally::default() };
    let mut seen: BTreeSet<Files> = BTreeSet::new();
    for end in 0..=ops.len() {
        for disk in disks(project, &ops[..end]) {
            tally.disks += 1;
            let context = || format!("cut after operation {end} of {}", ops.len());
            match project.judge_files(&disk) {
                Err(error) => tally.wrong.push(format!("{}: {error}", context())),
                // The orphan may reappear, which is allowed.
                Ok(left) if end == ops.len() && left.old > usize::from(disk.contains_key("o/gone.hullmap")) => {
                    tally.wrong.push(format!("{}: success was claimed, but {} outputs are old", context(), left.old));
                }
                Ok(_) => {}
            }
            if seen.insert(disk.clone()) && seen.len().is_multiple_of(stride) && tally.wrong.is_empty() {
                project.put(&disk);
                match project.bake_again() {
                    Ok(()) => tally.healed += 1,
                    Err(error) => tally.wrong.push(format!("{}: {error}", context())),
                }
            }
        }
    }
    tally.distinct = seen.len();
    tally
}

/// An operation on entries, and whether it was synced.
struct Entry {
    op: Op,
    is_synced: bool,
}

/// The bytes of a file: the number written, and the number synced.
#[derive(Clone, Copy, Default)]
struct Length {
    written: usize,
    synced: usize,
}

/// The part that the disk keeps of bytes that were written and not synced.
#[derive(Clone, Copy)]
enum Kept {
    Nothing,
    Half,
    All,
    Zeros,
}

/// The possible disks after these operations.
fn disks(project: &Project, ops: &[Op]) -> Vec<Files> {
    let mut entries: Vec<Entry> = Vec::new();
    // By the path at which a file was created: a file keeps its bytes when it is renamed.
    let mut lengths: BTreeMap<String, Length> = BTreeMap::new();
    for op in ops {
        match op {
            Op::Write(path, count) => lengths.entry(path.clone()).or_default().written += count,
            Op::Sync(path) => match lengths.get_mut(path) {
                Some(length) => length.synced = length.written,
                None => {
                    entries.iter_mut().filter(|entry| touches(&entry.op, path)).for_each(|entry| entry.is_synced = true)
                }
            },
            op => entries.push(Entry { op: op.clone(), is_synced: false }),
        }
        if let Op::Create(path) = op {
            lengths.insert(path.clone(), Length::default());
        }
    }
    let loose: Vec<usize> = (0..entries.len()).filter(|&index| !entries[index].is_synced).collect();
    let mut disks = Vec::new();
    for subset in subsets(loose.len()) {
        let is_kept = |index: usize| loose.iter().position(|&at| at == index).is_none_or(|at| subset[at]);
        let kept: Vec<&Op> =
            (0..entries.len()).filter(|&index| is_kept(index)).map(|index| &entries[index].op).collect();
        for bytes in [Kept::Nothing, Kept::Half, Kept::All, Kept::Zeros] {
            disks.push(disk(project, ops, &kept, &lengths, bytes));
        }
    }
    disks
}

/// Whether syncing `folder` makes an entry last.
fn touches(op: &Op, folder: &str) -> bool {
    let parent = |path: &str| path.rsplit_once('/').map_or(String::new(), |(parent, _)| parent.to_owned());
    match op {
        Op::Folder(path) | Op::Create(path) | Op::Remove(path) => parent(path) == folder,
        Op::Rename(from, to) => parent(from) == folder && parent(to) == folder,
        Op::Write(..) | Op::Sync(_) => false,
    }
}

/// Subsets of `count` elements: all of them, or those described at [`MAX_ALL_SUBSETS`].
fn subsets(count: usize) -> Vec<Vec<bool>> {
    if count <= MAX_ALL_SUBSETS {
        return (0..1_usize << count).map(|bits| (0..count).map(|at| bits >> at & 1 == 1).collect()).collect();
    }
    let first = (0..=count).map(|end| (0..count).map(|at| at < end).collect());
    let alone = (0..count).map(|one| (0..count).map(|at| at == one).collect());
    let without = (0..count).map(|one| (0..count).map(|at| at != one).collect());
    first.chain(alone).chain(without).collect()
}

/// The disk with these entries, and with these bytes of the files that were written.
fn disk(project: &Project, ops: &[Op], entries: &[&Op], lengths: &BTreeMap<String, Length>, kept: Kept) -> Files {
    // The final path of a file determines its bytes.
    let whole = |made: &str| {
        let end = ops.iter().find(|op| matches!(op, Op::Rename(from, _) if from == made));
        let path = match end {
            Some(Op::Rename(_, to)) => to.as_str(),
            _ => made,
        };
        project.new.get(path).cloned().unwrap_or_default()
    };
    let content = |made: &str| {
        let Length { written, synced } = lengths.get(made).copied().unwrap_or_default();
        let mut bytes = whole(made);
        // Before the rename, the file has only its temporary name, and its bytes do not matter.
        bytes.resize(bytes.len().max(written), b'?');
        bytes.truncate(match kept {
            Kept::Nothing => synced,
            Kept::Half => synced + (written - synced) / 2,
            Kept::All | Kept::Zeros => written,
        });
        if matches!(kept, Kept::Zeros) {
            bytes[synced..].fill(0);
        }
        bytes
    };
    let made_folders: BTreeSet<&String> =
        ops.iter().filter_map(|op| if let Op::Folder(path) = op { Some(path) } else { None }).collect();
    let mut files = project.old.clone();
    let mut folders: BTreeSet<&String> = BTreeSet::new();
    for op in entries {
        match op {
            Op::Folder(path) => drop(folders.insert(path)),
            Op::Create(path) => drop(files.insert(path.clone(), content(path))),
            Op::Remove(path) => drop(files.remove(path)),
            // The new entry may exist even if the old one was never synced.
            Op::Rename(from, to) => {
                files.remove(from);
                files.insert(to.clone(), content(from));
            }
            Op::Write(..) | Op::Sync(_) => {}
        }
    }
    // A lost folder takes its files with it.
    files.retain(|path, _| {
        !made_folders.iter().any(|folder| !folders.contains(folder) && path.starts_with(&format!("{folder}/")))
    });
    files
}
