//! Effects on an open pack when its file changes.
//!
//! - A copy ([`Pack::open`], [`Pack::from_bytes`]) does not change.
//! - A map ([`Pack::map`]) changes with the file. Its caller promises that no process writes to the
//!   file. If one does, answers change; if the file is truncated, the process gets SIGBUS or reads
//!   zeros. No query reads outside of the map: `hostile_writes_stay_within_the_map` overwrites the
//!   file's root and other numbers while queries run, with inaccessible pages on both sides.
//! - Replacing the file by renaming changes neither.
//!
//! Each case runs in a process of its own.

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    os::{
        fd::AsRawFd,
        unix::{fs::FileExt, process::ExitStatusExt},
    },
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    process::{Child, Command, ExitStatus, Stdio},
    sync::Arc,
    time::{Duration, Instant},
};

use glam::{DVec3, Vec3};
use hullmap::{Cache, OpenError, Pack, Pose, Settings, contact, distance};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_format::archive::ArchivedPack;
use hullmap_testkit::packs;
use hullmap_tests::hostile::{
    inquiry::{Extent, Inquiry},
    samples,
};
use shapes::{families::Family, rng::SplitMix64};

/// The environment variable with the file that the child opens, and the way to open it.
const CHILD: &str = "HULLMAP_TEST_PACK";

/// Name of the test that runs as the child.
const CHILD_TEST: &str = "live_mapping::child";

const SIGBUS: i32 = 7;

/// A pack of several pages, and a smaller one.
const LARGE: usize = 3_000;
const SMALL: usize = 10;

/// How a child ended, and whether its answers, before and after, were the same.
#[derive(Debug)]
struct Outcome {
    status: ExitStatus,
    same: Option<bool>,
}

fn bytes(points: usize, scale: f32) -> Vec<u8> {
    let positions: Vec<[f32; 3]> = Family::Rock.points(points, 1).into_iter().map(|p| p.map(|c| c * scale)).collect();
    packs::bytes(&[packs::point_set("rock", &positions)], IndexKind::Tree, &SourceRecord::default()).unwrap()
}

/// A hash of a hull's vertices and of some support points.
fn answers(pack: &Pack) -> u64 {
    let hull = pack.hull(0).unwrap();
    let vertices = hull.vertices().flat_map(|v| v.to_array()).map(|c| u64::from(c.to_bits()));
    let supports = [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::ONE].map(|dir| u64::from(hull.support(dir).index));
    vertices.chain(supports).fold(0, |sum: u64, n| sum.rotate_left(7) ^ n)
}

/// Maps the pack at `path`, to which these tests do write.
fn map(path: impl AsRef<Path>) -> Result<Pack, OpenError> {
    // SAFETY: the contract does not hold. The tests break it on purpose, in processes of their own,
    // to observe the consequences. No compiled code writes to the mapped bytes.
    unsafe { Pack::map(path) }
}

/// The child process: opens the pack, reports it, waits for a line, queries again. Without the
/// variable, as a plain test, it does nothing.
#[test]
fn child() {
    let Ok(way) = std::env::var(CHILD) else { return };
    let (how, path) = way.split_once(' ').unwrap();
    let pack = match how {
        "hostile" => return hostile_child(Path::new(path)),
        "map" => map(path),
        "open" => Pack::open(path),
        _ => Pack::from_bytes(&fs::read(path).unwrap()).map_err(|error| panic!("{error}")),
    };
    let pack = pack.unwrap();
    let before = answers(&pack);
    println!("\nopened");
    std::io::stdin().read_line(&mut String::new()).unwrap();
    println!("\nsame {}", answers(&pack) == before);
}

/// Starts a child process on the pack at `path`.
fn start(how: &str, path: &Path) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", CHILD_TEST, "--nocapture"])
        .env(CHILD, format!("{how} {}", path.display()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(if how == "hostile" { Stdio::inherit() } else { Stdio::null() })
        .spawn()
        .unwrap()
}

/// Waits until a child has opened its pack, and returns the lines that it prints after that.
fn opened(child: &mut Child) -> impl Iterator<Item = String> + use<> {
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line == "opened"), "the child did not open the pack");
    lines
}

/// Opens `path` in a child process, runs `change`, and reports what the child answers after it.
fn after(how: &str, path: &Path, change: impl FnOnce()) -> Outcome {
    let mut child = start(how, path);
    let mut lines = opened(&mut child);
    change();
    child.stdin.take().unwrap().write_all(b"\n").unwrap();
    let same = lines.find_map(|line| line.strip_prefix("same ").map(|same| same == "true"));
    Outcome { status: child.wait().unwrap(), same }
}

/// The crate installs no handler of the signal that a truncated map sends.
#[test]
fn a_map_changes_with_its_file_and_copies_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rock.hullmap");
    let open = || fs::OpenOptions::new().write(true).open(&path).unwrap();
    let truncate = || open().set_len(100).unwrap();
    let overwrite = || open().write_all(&bytes(LARGE, 2.0)).unwrap();
    let of_copy = (None, Some(true));
    for (name, change, of_map) in
        [("truncated", &truncate as &dyn Fn(), (Some(SIGBUS), None)), ("overwritten", &overwrite, (None, Some(false)))]
    {
        for (how, expected) in [("map", of_map), ("open", of_copy), ("bytes", of_copy)] {
            fs::write(&path, bytes(LARGE, 1.0)).unwrap();
            let found = after(how, &path, change);
            assert_eq!((found.status.signal(), found.same), expected, "{name}, {how}: {found:?}");
            assert_eq!(found.status.success(), expected.0.is_none(), "{name}, {how}: {found:?}");
        }
    }
}

#[test]
fn maps_and_copies_report_the_same_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.hullmap");
    let good = bytes(SMALL, 1.0);
    let mut flipped = good.clone();
    flipped[200] ^= 1;
    let longer = [&good[..], &[0]].concat();
    for file in [vec![], vec![0; 10], vec![7; 100], flipped, longer, good[..good.len() - 1].to_vec()] {
        fs::write(&path, &file).unwrap();
        let [mapped, copied] = [map(&path), Pack::open(&path)].map(|opened| opened.unwrap_err().to_string());
        assert_eq!(mapped, copied);
        assert!(copied.contains("bad.hullmap: ") && copied.contains("; "), "no file or no remedy: {copied}");
    }
}

/// A pack can come through a pipe, which has no length.
#[test]
fn a_pipe_is_read_to_its_end() {
    let file = bytes(SMALL, 1.0);
    for (end, is_ok) in [(file.len(), true), (file.len() - 1, false)] {
        let (reader, mut writer) = std::io::pipe().unwrap();
        let part = file[..end].to_vec();
        let thread = std::thread::spawn(move || writer.write_all(&part).unwrap());
        let opened = Pack::open(format!("/dev/fd/{}", reader.as_raw_fd()));
        assert_eq!(opened.is_ok(), is_ok, "{:?}", opened.err());
        thread.join().unwrap();
    }
}

/// Address space on each side of the map that faults when it is read. The file's offsets are
/// 32-bit.
const GUARD: usize = 4 << 30;

const PAGE: usize = 4096;

/// Reserves `len` bytes of address space, every access to which faults.
fn reserve(len: usize) -> usize {
    let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE;
    // SAFETY: a new mapping at an address that the kernel chooses.
    let found = unsafe { libc::mmap(std::ptr::null_mut(), len, libc::PROT_NONE, flags, -1, 0) };
    assert_ne!(found, libc::MAP_FAILED, "{len} bytes of address space");
    found.addr()
}

/// Releases address space that [`reserve`] returned.
fn release(start: usize, len: usize) {
    // SAFETY: the range is inaccessible, so that nothing refers to it.
    let failed = unsafe { libc::munmap(std::ptr::without_provenance_mut(start), len) };
    assert_eq!(failed, 0);
}

/// Maps the pack at `path` so that [`GUARD`] bytes before and after the map are inaccessible.
fn map_between_guards(path: &Path) -> Pack {
    let len = (fs::metadata(path).unwrap().len() as usize).next_multiple_of(PAGE);
    let region = reserve(GUARD + len + GUARD);
    // The kernel takes the highest gap that fits, or goes below all other maps. Fill all gaps, so
    // that the one made here is the only one.
    let mut size = 1 << 30;
    while size >= PAGE {
        let found = reserve(size);
        if found < region {
            release(found, size);
            size /= 2;
        }
    }
    release(region + GUARD, len);
    let pack = map(path).unwrap();
    assert_eq!(extent(path), (region + GUARD, region + GUARD + len), "the map is not between the guards");
    pack
}

/// First address of the map of the file at `path` in this process, and the one after its last.
fn extent(path: &Path) -> (usize, usize) {
    let maps = fs::read_to_string("/proc/self/maps").unwrap();
    let line = maps.lines().find(|line| line.ends_with(path.to_str().unwrap())).expect("the file is mapped");
    let (range, _) = line.split_once(' ').unwrap();
    let (start, end) = range.split_once('-').unwrap();
    (usize::from_str_radix(start, 16).unwrap(), usize::from_str_radix(end, 16).unwrap())
}

/// Duration of the hostile writes to each pack. `HULLMAP_TEST_HOSTILE_SECONDS` sets another time.
const HOSTILE_SECONDS: u64 = 1;

/// Maximum time until a child ends after the last write.
const PATIENCE: Duration = Duration::from_secs(60);

fn hostile_time() -> Duration {
    let seconds = std::env::var("HULLMAP_TEST_HOSTILE_SECONDS").ok().and_then(|seconds| seconds.parse().ok());
    Duration::from_secs(seconds.unwrap_or(HOSTILE_SECONDS))
}

/// Runs all queries on a mapped pack until the time is over, while its file changes.
fn hostile_child(path: &Path) {
    let pack = Arc::new(map_between_guards(path));
    let inquiry = Inquiry::new(&Pack::open(path).unwrap(), Extent::BRIEF).unjudged();
    let texts = |pack: &Pack| format!("{} {} {:?}", pack.source_path(), pack.options(), pack.hull_count());
    let before = texts(&pack);
    // Also hulls from before the writes: their slices were cut from valid numbers.
    let old = pack.shared_hull(0).unwrap();
    let pose = Pose::from_translation(DVec3::new(0.5, 0.25, 0.125)).unwrap();
    let apart = Pose::from_translation(DVec3::new(90.0, 50.0, 20.0)).unwrap();
    // The contact of small hulls reads copies of their faces; the distance always reads the map.
    let answer = || {
        let found = contact(&old, &old, pose, &Settings::default(), &mut Cache::default());
        (found, distance(&old, &old, apart, &Settings::default(), &mut Cache::default()))
    };
    let first = answer();
    std::panic::set_hook(Box::new(|_| ()));
    println!("\nopened");
    let (mut rounds, mut panics, mut changed) = (0_u64, 0_u64, 0_u64);
    let start = Instant::now();
    while start.elapsed() < hostile_time() {
        panics += u64::from(catch_unwind(AssertUnwindSafe(|| inquiry.run(&pack))).is_err());
        match catch_unwind(AssertUnwindSafe(answer)) {
            Ok(found) => changed += u64::from(found != first),
            Err(_) => panics += 1,
        }
        assert_eq!(texts(&pack), before, "texts are copied");
        rounds += 1;
    }
    println!("\nrounds {rounds} panics {panics} changed {changed}");
}

/// Overwrites numbers of the file at `path` until the child ends: in turns all of the root, single
/// numbers anywhere, and the original bytes. Returns the number of writes.
fn write_while_running(child: &mut Child, path: &Path, seed: u64) -> u64 {
    let original = fs::read(path).unwrap();
    let file = fs::OpenOptions::new().write(true).open(path).unwrap();
    let root = original.len() - size_of::<ArchivedPack>();
    let mut rng = SplitMix64::new(seed);
    let hostile = |rng: &mut SplitMix64| match rng.below(8) {
        0 => 0,
        1 => 1,
        2 => u32::MAX,
        3 => i32::MAX as u32,
        4 => i32::MIN as u32,
        5 => f32::NAN.to_bits(),
        6 => rng.next_u64() as u32 & 0xffff,
        _ => rng.next_u64() as u32,
    };
    let start = Instant::now();
    let mut writes = 0;
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > hostile_time() + PATIENCE {
            child.kill().unwrap();
            panic!("the child did not end: a query hangs");
        }
        for _ in 0..64 {
            let at =
                if rng.below(2) == 0 { root + rng.below(original.len() - root) } else { rng.below(original.len()) };
            file.write_all_at(&hostile(&mut rng).to_le_bytes(), (at & !3) as u64).unwrap();
            writes += 1;
        }
        if rng.below(4) == 0 {
            let garbage: Vec<u8> = (root..original.len()).map(|_| rng.next_u64() as u8).collect();
            file.write_all_at(&garbage, root as u64).unwrap();
            writes += 1;
        }
        if rng.below(4) == 0 {
            file.write_all_at(&original, 0).unwrap();
            writes += 1;
        }
    }
    writes
}

/// Overwriting a mapped file breaks the contract of `Pack::map`. Answers may then be wrong, and a
/// query may panic. No query reads outside of the map, hangs, or ends the process.
#[test]
fn hostile_writes_stay_within_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let names = [
        "hulls of all ranks, tree",
        "five hulls, no index",
        "sphere, binary tree",
        "sphere, cube map 3",
        "rotated prism, tree",
        "needle, tree",
    ];
    let mut packs: Vec<(&str, Vec<u8>)> = names.map(|name| (name, samples::named(name))).to_vec();
    packs.push(("large rock, tree", bytes(LARGE, 1.0)));
    let (mut writes, mut rounds, mut panics) = (0, 0, 0);
    for (index, (name, file)) in packs.iter().enumerate() {
        let path = folder.path().join(format!("{index}.hullmap"));
        fs::write(&path, file).unwrap();
        let mut child = start("hostile", &path);
        let mut lines = opened(&mut child);
        writes += write_while_running(&mut child, &path, index as u64);
        let status = child.wait().unwrap();
        assert!(status.success(), "{name}: the child ended with {status}");
        let counts = lines.find(|line| line.starts_with("rounds ")).unwrap();
        let counts: Vec<u64> = counts.split(' ').filter_map(|word| word.parse().ok()).collect();
        assert!(counts[0] > 3 && counts[2] > 0, "{name}: {counts:?}: the writes did not meet the queries");
        rounds += counts[0];
        panics += counts[1];
    }
    println!("{writes} writes under {rounds} rounds of queries, of which {panics} panicked");
}

/// A map ends with the pack, also if the file was replaced by renaming meanwhile.
#[test]
fn a_replaced_pack_keeps_its_answers_and_frees_its_map() {
    let folder = tempfile::tempdir().unwrap();
    let [path, fresh] = ["rock.hullmap", "fresh"].map(|name| folder.path().join(name));
    let name = folder.path().to_str().unwrap();
    let maps = || fs::read_to_string("/proc/self/maps").unwrap().lines().filter(|line| line.contains(name)).count();
    fs::write(&path, bytes(SMALL, 1.0)).unwrap();
    let packs = [map(&path), Pack::open(&path)].map(Result::unwrap);
    let before = packs.each_ref().map(answers);
    fs::write(&fresh, bytes(SMALL, 2.0)).unwrap();
    fs::rename(&fresh, &path).unwrap();
    assert_eq!(packs.each_ref().map(answers), before);
    assert_ne!(answers(&map(&path).unwrap()), before[0]);
    assert_eq!(maps(), 1);
    drop(packs);
    assert_eq!(maps(), 0);
}
