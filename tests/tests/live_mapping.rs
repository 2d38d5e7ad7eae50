//! What happens to an opened pack when its file changes, each in a process of its own; and reloading under 64 readers.
#![cfg(target_os = "linux")]

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    os::unix::process::ExitStatusExt,
    path::Path,
    process::{Command, ExitStatus, Stdio},
    sync::{
        Arc, RwLock,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use glam::Vec3;
use hullmap::Pack;
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_tests::packs;
use shapes::families::Family;

/// Tells the child which file to open, and how.
const CHILD: &str = "HULLMAP_TEST_PACK";

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
    packs::bytes(&[packs::point_set("rock", &positions)], IndexKind::TREE, &SourceRecord::default()).unwrap()
}

/// All that a hull says, as a sum of bits.
fn answers(pack: &Pack) -> u64 {
    let hull = pack.hull(0).unwrap();
    let vertices = hull.vertices().flat_map(|v| v.to_array()).map(|c| u64::from(c.to_bits()));
    let supports = [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::ONE].map(|dir| u64::from(hull.support(dir).index));
    vertices.chain(supports).fold(0, |sum: u64, n| sum.rotate_left(7) ^ n)
}

/// The child's part: opens, says so, waits for a line, asks again. A test that does nothing else when run by the harness.
#[test]
fn child() {
    let Ok(way) = std::env::var(CHILD) else { return };
    let (how, path) = way.split_once(' ').unwrap();
    let pack = match how {
        "open" => Pack::open(path),
        "read" => Pack::read(path),
        "sealed" => Pack::read_sealed(path),
        _ => Pack::from_bytes(&fs::read(path).unwrap()).map_err(|error| panic!("{error}")),
    };
    let pack = pack.unwrap();
    let before = answers(&pack);
    println!("\nopened");
    std::io::stdin().read_line(&mut String::new()).unwrap();
    println!("\nsame {}", answers(&pack) == before);
}

/// Opens `path` in a child, lets `change` happen, and sees what the child says then.
fn after(how: &str, path: &Path, change: impl FnOnce()) -> Outcome {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "child", "--nocapture"])
        .env(CHILD, format!("{how} {}", path.display()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line == "opened"), "{how}: the child did not open the pack");
    change();
    child.stdin.take().unwrap().write_all(b"\n").unwrap();
    let same = lines.find_map(|line| line.strip_prefix("same ").map(|same| same == "true"));
    Outcome { status: child.wait().unwrap(), same }
}

const COPIES: [&str; 3] = ["read", "sealed", "bytes"];

#[test]
fn truncated_under_a_map_is_a_bus_error_and_no_matter_to_a_copy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rock.hullmap");
    let cut = || fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(100).unwrap();
    fs::write(&path, bytes(LARGE, 1.0)).unwrap();
    let mapped = after("open", &path, cut);
    // No handler of ours stands between.
    assert_eq!((mapped.status.signal(), mapped.same), (Some(SIGBUS), None));
    for how in COPIES {
        fs::write(&path, bytes(LARGE, 1.0)).unwrap();
        let copy = after(how, &path, cut);
        assert!(copy.status.success() && copy.same == Some(true), "{how}: {copy:?}");
    }
}

/// Within the last page there is no signal: what was cut off reads as zeros.
#[test]
fn truncated_within_a_page_is_silent_zeros() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rock.hullmap");
    let file = bytes(SMALL, 1.0);
    assert!(file.len() < 4096, "{} bytes are more than a page", file.len());
    fs::write(&path, &file).unwrap();
    let cut = || fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(100).unwrap();
    let mapped = after("open", &path, cut);
    // Even so nothing is read out of bounds: other answers, or a panic where there is no hull any more.
    assert!(mapped.status.signal().is_none() && mapped.same != Some(true), "{mapped:?}");
}

#[test]
fn overwritten_in_place_changes_answers_of_a_map_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rock.hullmap");
    let overwrite = || fs::write(&path, bytes(LARGE, 2.0)).unwrap();
    fs::write(&path, bytes(LARGE, 1.0)).unwrap();
    // As many bytes: no cut.
    let in_place = || {
        let mut file = fs::OpenOptions::new().write(true).open(&path).unwrap();
        file.write_all(&bytes(LARGE, 2.0)).unwrap();
    };
    let mapped = after("open", &path, in_place);
    assert_eq!((mapped.status.success(), mapped.same), (true, Some(false)), "{mapped:?}");
    for how in COPIES {
        fs::write(&path, bytes(LARGE, 1.0)).unwrap();
        let copy = after(how, &path, overwrite);
        assert!(copy.status.success() && copy.same == Some(true), "{how}: {copy:?}");
    }
}

#[test]
fn renamed_over_is_safe_for_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rock.hullmap");
    for how in ["open"].into_iter().chain(COPIES) {
        fs::write(&path, bytes(LARGE, 1.0)).unwrap();
        let rename = || {
            let fresh = folder.path().join("fresh");
            fs::write(&fresh, bytes(SMALL, 2.0)).unwrap();
            fs::rename(&fresh, &path).unwrap();
        };
        let outcome = after(how, &path, rename);
        assert!(outcome.status.success() && outcome.same == Some(true), "{how}: {outcome:?}");
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn a_sealed_copy_is_refused_as_a_map_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.hullmap");
    let mut flipped = bytes(SMALL, 1.0);
    flipped[200] ^= 1;
    for file in [vec![], vec![0; 10], flipped] {
        fs::write(&path, &file).unwrap();
        let [mapped, sealed] =
            [Pack::open(&path), Pack::read_sealed(&path)].map(|opened| opened.unwrap_err().to_string());
        assert_eq!(mapped, sealed);
    }
}

const READERS: usize = 64;
const SWAPS: usize = 10_000;

/// Maps of files in this folder.
fn maps(folder: &Path) -> usize {
    let name = folder.to_str().unwrap().to_owned();
    fs::read_to_string("/proc/self/maps").unwrap().lines().filter(|line| line.contains(&name)).count()
}

#[test]
fn reloading_under_readers_tears_nothing_and_frees_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rock.hullmap");
    // Whatever a pack is scaled by shows in each of its answers.
    let versions: Vec<(f32, Vec<u8>)> = [1.0, 2.0, 4.0, 8.0].map(|scale| (scale, bytes(SMALL, scale))).to_vec();
    let install = |file: &[u8]| {
        let fresh = folder.path().join("fresh");
        fs::write(&fresh, file).unwrap();
        fs::rename(&fresh, &path).unwrap();
    };
    install(&versions[0].1);
    let reference = Pack::from_bytes(&versions[0].1).unwrap();
    let dirs = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::new(0.3, -0.5, 0.8)];
    let unit = dirs.map(|dir| reference.hull(0).unwrap().support(dir).point);
    let current = RwLock::new(Arc::new(Pack::open(&path).unwrap()));
    let (done, asked, most) = (AtomicBool::new(false), AtomicUsize::new(0), AtomicUsize::new(0));
    let seen = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..READERS {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    let pack = current.read().unwrap().clone();
                    let hull = pack.hull(0).unwrap();
                    let scale = hull.support(dirs[0]).point.x / unit[0].x;
                    let place = versions.iter().position(|(version, _)| *version == scale);
                    seen.fetch_or(1 << place.expect("one of the versions"), Ordering::Relaxed);
                    for (dir, unit) in dirs.iter().zip(unit) {
                        assert_eq!(hull.support(*dir).point, unit * scale, "torn");
                    }
                    asked.fetch_add(1, Ordering::Relaxed);
                    std::thread::yield_now();
                }
            });
        }
        for swap in 0..SWAPS {
            install(&versions[swap % versions.len()].1);
            let fresh = Arc::new(Pack::open(&path).unwrap());
            *current.write().unwrap() = fresh;
            if swap % 500 == 0 {
                most.fetch_max(maps(folder.path()), Ordering::Relaxed);
            }
        }
        // Readers may have been starved; all of them ask at least once more.
        let target = asked.load(Ordering::Relaxed) + READERS;
        while asked.load(Ordering::Relaxed) < target {
            std::thread::yield_now();
        }
        done.store(true, Ordering::Relaxed);
    });
    let most = most.into_inner();
    println!("{SWAPS} swaps, {READERS} readers asked {} times, at most {most} maps at once", asked.into_inner());
    assert!(most <= READERS + 2, "{most} maps at once: old ones are kept");
    assert_eq!(maps(folder.path()), 1, "only the current one is mapped");
    assert!(seen.into_inner().count_ones() > 1, "readers saw one version only");
    drop(current);
    assert_eq!(maps(folder.path()), 0);
}
