//! Bakes that meet a fault: a broken or full disk, a kill, a cut of the power. `bake-faults` does the same at length.
#![cfg(target_os = "linux")]

use std::{
    fs,
    os::unix::fs::symlink,
    process::{Command, Stdio},
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

use hullmap_tests::{
    command::{bake_in, binary},
    faults::{
        calls,
        inject::{Errno, Fault, Injector},
        kills,
        power::{self, Op},
        project::Project,
    },
};

const THREADS: usize = 2;

/// A tracer; without one, says so.
fn injector() -> Option<Injector> {
    Injector::build().map_err(|why| println!("skipped: {why}")).ok()
}

/// The fault goes round, so that each call meets one of eight. `bake-faults` tries all eight at each.
#[test]
fn a_fault_at_every_system_call() {
    let Some(injector) = injector() else { return };
    let tally = calls::at_every_call(binary(), &injector, THREADS, |number| Fault::ALL[number % Fault::ALL.len()]);
    println!("{tally}");
    assert!(tally.wrong.is_empty(), "{:#?}", tally.wrong);
    assert!(
        tally.bakes >= 200 && tally.told > 40 && tally.absorbed > 20 && tally.mixed > 30,
        "representative: {tally}"
    );
}

#[test]
fn kills_at_random_moments() {
    let tally = kills::kill(binary(), 150, 1, THREADS);
    println!("{tally}");
    assert!(tally.wrong.is_empty(), "{:#?}", tally.wrong);
    assert!(tally.none_some_all[1] > 20 && tally.beside > 10, "representative: {tally}");
}

#[test]
fn a_cut_of_the_power_after_every_operation() {
    let Some(injector) = injector() else { return };
    let project = Project::new(binary(), 0);
    let ops = power::record(&project, &injector);
    let tally = power::cut(&project, &ops, 1);
    println!("{tally}");
    assert!(tally.wrong.is_empty(), "{:#?}", tally.wrong);
    assert!(tally.distinct > 30 && tally.healed == tally.distinct, "representative: {tally}");

    // The same bake without its syncs must be found out.
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

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

#[track_caller]
fn bake(folder: &tempfile::TempDir, line: &str, code: i32) -> String {
    bake_in(folder.path(), line.split_whitespace()).expect(code).stderr
}

/// A link that leads to itself cannot be followed, whoever asks.
#[test]
fn links_in_circles_are_told_or_replaced() {
    let folder = folder(&[("in/a.obj", CUBE)]);
    let link = |to: &str, at: &str| symlink(to, folder.path().join(at)).unwrap();
    link("loop.obj", "loop.obj");
    let said = bake(&folder, "build loop.obj --out o", 2);
    assert!(said.contains("loop.obj: cannot read this input") && said.contains("os error 40"), "{said}");
    // In a folder it is a mesh that cannot be read.
    link("loop.obj", "in/loop.obj");
    let said = bake(&folder, "build in --out o", 2);
    assert!(said.contains("os error 40"), "{said}");
    fs::remove_file(folder.path().join("in/loop.obj")).unwrap();
    link("out", "out");
    let said = bake(&folder, "build in --out out", 2);
    assert!(said.contains("out: cannot make this folder"), "{said}");
    // The pack's own place is ours: what is renamed over it replaces the link, not what it leads to.
    fs::create_dir(folder.path().join("o")).ok();
    link("a.hullmap", "o/a.hullmap");
    bake(&folder, "build in --out o", 0);
    bake(&folder, "build in --out o --check", 0);
}

/// The packs stand, and that the table could not be printed is told.
#[test]
fn a_full_disk_behind_standard_output_is_told() {
    let Ok(full) = fs::File::options().write(true).open("/dev/full") else {
        println!("skipped: there is no /dev/full here");
        return;
    };
    let folder = folder(&[("in/a.obj", CUBE)]);
    let mut command = Command::new(binary());
    command.args(["build", "in", "--out", "o"]).current_dir(folder.path()).stdout(Stdio::from(full));
    let run = command.output().unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(said.contains("cannot write the results") && said.contains("os error 28"), "{said}");
    bake(&folder, "build in --out o --check", 0);
}

/// Not renamed over, as careful editors do, but cut to nothing and written again: whatever was read is baked or refused, and
/// never called fresh afterwards.
#[test]
fn a_source_that_is_rewritten_in_place_meanwhile() {
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

/// A killed bake's file stayed for ever where its mesh was gone by the next, or where it was to become a depfile.
#[test]
fn temporary_files_are_swept_wherever_they_are() {
    let folder = folder(&[
        ("in/a.obj", CUBE),
        ("o/once/.b.hullmapAbCdEf.tmp", "half"),
        ("deps/.a.d.hullmapAbCdEf.tmp", "half"),
        ("pages/.report.html.hullmapAbCdEf.tmp", "half"),
    ]);
    bake(&folder, "build in --out o --depfile deps/a.d", 0);
    bake(&folder, "report o --out pages/report.html", 0);
    for place in ["o/once", "deps", "pages"] {
        let names: Vec<_> =
            fs::read_dir(folder.path().join(place)).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert!(names.iter().all(|name| !name.to_string_lossy().ends_with(".tmp")), "{place}: {names:?}");
    }
}

/// Where the file of options cannot be asked for, its meshes were baked without it, and nobody was told.
#[test]
fn options_that_cannot_be_read_are_not_left_out() {
    let Some(injector) = injector() else { return };
    let folder = folder(&[("in/a.obj", CUBE), ("in/hullmap.toml", "[defaults]\nunit_scale = 2.0\n")]);
    let words = ["build", "in", "--out", "o"];
    let (_, calls) = injector.run(binary(), &words, folder.path(), 0, Fault::None);
    let asked: Vec<usize> =
        (1..).zip(&calls).filter(|(_, call)| call.path.ends_with("hullmap.toml")).map(|(at, _)| at).collect();
    assert!(asked.len() >= 2);
    for at in asked {
        fs::remove_dir_all(folder.path().join("o")).ok();
        let (run, _) = injector.run(binary(), &words, folder.path(), at, Fault::Error(Errno::Io));
        let said = String::from_utf8_lossy(&run.stderr);
        // Asking how long it is only saves time.
        let is_absorbed = run.status.code() == Some(0);
        assert!(is_absorbed || run.status.code() == Some(2) && said.contains("hullmap.toml"), "{run:?}");
        if is_absorbed {
            bake(&folder, "build in --out o --check", 0);
        }
    }
}

/// A source whose folder could not be asked for counted as gone, and its pack was removed.
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
            for errno in [Errno::Io, Errno::Denied, Errno::Interrupted] {
                injector.run(binary(), &words, folder.path(), at, Fault::Error(errno));
                assert!(folder.path().join("o/b.hullmap").exists(), "{errno:?} at {call:?}");
                tried += 1;
            }
        }
    }
    assert!(tried >= 6, "{calls:?}");
}

/// Half a `hullmap.toml` stood in the way of the next try.
#[test]
fn a_failed_init_leaves_nothing() {
    let Some(injector) = injector() else { return };
    let folder = folder(&[("in/a.obj", CUBE)]);
    let made = folder.path().join("hullmap.toml");
    let (_, calls) = injector.run(binary(), &["init"], folder.path(), 0, Fault::None);
    let whole = fs::read(&made).unwrap();
    for at in 1..=calls.len() {
        for fault in [Fault::Full(Errno::NoSpace), Fault::Error(Errno::Io), Fault::Kill, Fault::Torn] {
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
