//! Bakes with faults: a broken or full disk, a power cut. The program `bake-faults` runs
//! many more.

use std::{
    fs,
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

use hullmap_testkit::command::{bake_in, bake_line, binary};
use hullmap_testkit::files::folder;
use hullmap_tests::faults::{
    calls,
    inject::{EACCES, EINTR, EIO, ENOSPC, Fault, Injector},
    power::{self, Op},
    project::Project,
};

const THREADS: usize = 2;

/// The tracer. If it is unavailable, prints the reason.
fn injector() -> Option<Injector> {
    Injector::build().map_err(|why| println!("skipped: {why}")).ok()
}

/// Each call gets one of eight faults, in turn. `bake-faults` tries all eight at each call.
#[test]
#[ignore = "takes long; .ci/nightly runs it"]
fn a_fault_at_every_system_call() {
    let Some(injector) = injector() else { return };
    let tally = calls::at_every_call(binary(), &injector, THREADS, |call| Fault::ALL[call % Fault::ALL.len()]);
    println!("{tally}");
    assert!(tally.wrong.is_empty(), "{:#?}", tally.wrong);
    let [reported, absorbed, mixed] = ["reported", "absorbed", "mixed"].map(|outcome| tally.of(outcome));
    assert!(tally.bakes >= 200 && reported > 40 && absorbed > 20 && mixed > 30, "representative: {tally}");
}

#[test]
fn a_power_cut_after_every_operation() {
    let Some(injector) = injector() else { return };
    let project = Project::new(binary());
    let ops = power::record(&project, &injector);
    let tally = power::cut(&project, &ops, 1);
    println!("{tally}");
    assert!(tally.wrong.is_empty(), "{:#?}", tally.wrong);
    assert!(tally.distinct > 30 && tally.healed == tally.distinct, "representative: {tally}");

    // The same bake without its syncs must fail.
    let without =
        |is_left_out: &dyn Fn(&Op) -> bool| -> Vec<Op> { ops.iter().filter(|op| !is_left_out(op)).cloned().collect() };
    let of_files = without(&|op| matches!(op, Op::Sync(path) if path.ends_with(".tmp")));
    let found = power::cut(&project, &of_files, usize::MAX).wrong;
    assert!(of_files.len() < ops.len() && found.iter().any(|wrong| wrong.contains("neither")), "{found:#?}");
    let of_folders = without(&|op| matches!(op, Op::Sync(path) if !path.ends_with(".tmp")));
    let found = power::cut(&project, &of_folders, usize::MAX).wrong;
    assert!(of_folders.len() < ops.len() && found.iter().any(|wrong| wrong.contains("claimed")), "{found:#?}");
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n";

#[track_caller]
fn bake(folder: &tempfile::TempDir, line: &str, code: i32) -> String {
    bake_line(folder, line).expect(code).stderr
}

/// The source is truncated and rewritten in place, not replaced by renaming as careful editors do.
/// The bytes that were read are baked or rejected, and are never reported as fresh afterwards.
#[test]
fn a_source_that_is_rewritten_in_place_during_a_bake() {
    let texts = [CUBE.replace('1', "1.5"), CUBE.replace('1', "2.25")];
    let folder = folder(&[("in/a.obj", &texts[0])]);
    let path = folder.path().join("in/a.obj");
    let is_done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for text in texts.iter().cycle() {
                fs::write(&path, text).unwrap();
                if is_done.load(Relaxed) {
                    return;
                }
            }
        });
        for _ in 0..30 {
            let run = bake_in(folder.path(), ["build", "in", "--out", "o", "--force"]);
            assert!(run.code == 0 || run.code == 1 && run.stderr.contains("in/a.obj"), "{run:?}");
            let pack = folder.path().join("o/a.hullmap");
            if pack.exists() {
                hullmap::Pack::open(pack).unwrap();
            }
        }
        is_done.store(true, Relaxed);
    });
    bake(&folder, "build in --out o", 0);
    bake(&folder, "verify o --require-source", 0);
}

/// If the status of the option file could not be read, its meshes were silently baked without it.
#[test]
fn unreadable_options_are_an_error() {
    let Some(injector) = injector() else { return };
    let folder = folder(&[("in/a.obj", CUBE), ("in/hullmap.toml", "[defaults]\nunit_scale = 2.0\n")]);
    let words = ["build", "in", "--out", "o"];
    let (_, calls) = injector.run(binary(), &words, folder.path(), 0, Fault::None);
    let reads: Vec<usize> =
        (1..).zip(&calls).filter(|(_, call)| call.path.ends_with("hullmap.toml")).map(|(at, _)| at).collect();
    assert!(reads.len() >= 2);
    for at in reads {
        fs::remove_dir_all(folder.path().join("o")).ok();
        let (run, _) = injector.run(binary(), &words, folder.path(), at, Fault::Error(EIO));
        let message = String::from_utf8_lossy(&run.stderr);
        // A failure to read its length is harmless: the length only saves time.
        let is_absorbed = run.status.code() == Some(0);
        assert!(is_absorbed || run.status.code() == Some(2) && message.contains("hullmap.toml"), "{run:?}");
        if is_absorbed {
            bake(&folder, "build in --out o --check", 0);
        }
    }
}

/// A source whose folder's status could not be read counted as missing; its pack was removed.
#[test]
fn no_pack_is_pruned_on_a_broken_disk() {
    let Some(injector) = injector() else { return };
    let folder = folder(&[("in/a.obj", CUBE), ("elsewhere/b.obj", CUBE)]);
    bake(&folder, "build elsewhere --out o", 0);
    let words = ["build", "in", "--out", "o", "--prune"];
    let (_, calls) = injector.run(binary(), &words, folder.path(), 0, Fault::None);
    let mut tried = 0;
    for (at, call) in (1..).zip(&calls) {
        if call.path.contains("b.obj") || call.path.contains("b.hullmap") {
            for errno in [EIO, EACCES, EINTR] {
                injector.run(binary(), &words, folder.path(), at, Fault::Error(errno));
                assert!(folder.path().join("o/b.hullmap").exists(), "{errno:?} at {call:?}");
                tried += 1;
            }
        }
    }
    assert!(tried >= 6, "{calls:?}");
}

/// An incomplete `hullmap.toml` made the next attempt fail.
#[test]
fn a_failed_init_leaves_nothing() {
    let Some(injector) = injector() else { return };
    let folder = folder(&[("in/a.obj", CUBE)]);
    let made = folder.path().join("hullmap.toml");
    let (_, calls) = injector.run(binary(), &["init"], folder.path(), 0, Fault::None);
    let whole = fs::read(&made).unwrap();
    for at in 1..=calls.len() {
        for fault in [Fault::Full(ENOSPC), Fault::Error(EIO), Fault::Kill, Fault::Torn] {
            fs::remove_file(&made).ok();
            let (run, _) = injector.run(binary(), &["init"], folder.path(), at, fault);
            match fs::read(&made) {
                Ok(bytes) => assert_eq!(bytes, whole, "{fault} at call {at}: {run:?}"),
                Err(_) => assert_ne!(run.status.code(), Some(0), "{fault} at call {at}"),
            }
        }
    }
    fs::write(&made, "mine").unwrap();
    bake(&folder, "init", 2);
    assert_eq!(fs::read(&made).unwrap(), b"mine");
}
