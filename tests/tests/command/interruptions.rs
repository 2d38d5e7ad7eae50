//! Bakes that are interrupted, killed, watched, run side by side, or whose sources and readers
//! change under them.

use std::{
    fs,
    io::{BufRead, BufReader, Read},
    path::Path,
    process::{Child, Command, Stdio},
    sync::mpsc::{Receiver, channel},
    time::{Duration, Instant},
};

use hullmap_testkit::command::{bake_in, command};
use hullmap_testkit::files::write;
use shapes::families::Family;
use tempfile::TempDir;

/// A step that takes longer counts as hung. Loaded machines are slow.
const PATIENCE: Duration = Duration::from_secs(120);

/// A cloud of this many points on a sphere as OBJ text.
fn sphere(count: usize, seed: u64) -> String {
    Family::Sphere.points(count, seed).iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect()
}

/// A folder `in` with this many meshes.
fn meshes(count: usize, points: usize) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for index in 0..count {
        write(&folder, &format!("in/{index}.obj"), sphere(points, index as u64));
    }
    folder
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Names of files in a folder that are not complete packs.
fn left_over(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| !name.ends_with(".hullmap")).collect()
}

fn assert_packs_open(folder: &Path) -> usize {
    let mut count = 0;
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "hullmap") {
            hullmap::Pack::open(&path).unwrap_or_else(|error| panic!("{error}"));
            count += 1;
        }
    }
    count
}

/// Waits for a pack to appear, so that the bake is in the midst of its work.
fn wait_for_a_pack(folder: &Path) {
    let start = Instant::now();
    while assert_packs_open(folder) == 0 {
        assert!(start.elapsed() < PATIENCE, "no pack yet");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn ctrl_c_leaves_whole_packs_alone_and_exits_with_130() {
    let folder = meshes(40, 3000);
    let out = folder.path().join("o");
    let mut hit = 0;
    for wait in [0, 3, 10, 30, 70] {
        let _ = fs::remove_dir_all(&out);
        let mut child = command(folder.path(), ["build", "in", "--out", "o"]);
        let mut child = child.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for_a_pack(&out);
        std::thread::sleep(Duration::from_millis(wait));
        signal(&child, "INT");
        let code = child.wait().unwrap().code();
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert!(code == Some(130) || code == Some(0), "{code:?}: {stderr}");
        if code == Some(130) {
            hit += 1;
            assert!(stderr.contains("interrupted"), "{stderr}");
        }
        assert_eq!(left_over(&out), [""; 0]);
        assert_packs_open(&out);
    }
    assert!(hit >= 3, "only {hit} of 5 were interrupted in time");
    bake_in(folder.path(), ["build", "in", "--out", "o"]).expect(0);
    bake_in(folder.path(), ["build", "in", "--out", "o", "--check"]).expect(0);
}

/// Builds share a folder, and half of them are killed: the others end well, every pack is whole,
/// and the next build leaves nothing else.
#[test]
fn killed_builds_beside_others_leave_whole_packs() {
    let folder = meshes(12, 1000);
    let out = folder.path().join("o");
    for wait in [0, 10, 30, 70] {
        let _ = fs::remove_dir_all(&out);
        let start = || command(folder.path(), ["build", "in", "--out", "o", "--quiet"]).spawn().unwrap();
        let mut builds: Vec<Child> = (0..6).map(|_| start()).collect();
        wait_for_a_pack(&out);
        std::thread::sleep(Duration::from_millis(wait));
        builds.iter_mut().step_by(2).for_each(|build| build.kill().unwrap());
        for (index, build) in builds.iter_mut().enumerate() {
            assert!(build.wait().unwrap().success() || index % 2 == 0, "{wait} ms, build {index}");
        }
        assert_eq!(assert_packs_open(&out), 12);
        bake_in(folder.path(), ["build", "in", "--out", "o", "--force"]).expect(0);
        assert_eq!(left_over(&out), [""; 0]);
    }
}

/// Waits are repeated, longer each time, until the process has come far enough to catch Ctrl-C.
#[test]
fn ctrl_c_leaves_the_output_of_a_decomposition_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/torus_knot.obj");
    fs::copy(mesh, folder.path().join("in.obj")).unwrap();
    fs::create_dir(folder.path().join("o")).unwrap();
    fs::write(folder.path().join("o/parts.obj"), "kept").unwrap();
    let mut stderr = String::new();
    for wait in [100, 500, 2500, 12_500] {
        // Without a time limit, it takes far longer than the wait.
        let mut child =
            command(folder.path(), ["decompose", "in.obj", "o/parts.obj", "--force", "--max-error", "0.1%"]);
        let mut child = child.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(wait));
        signal(&child, "INT");
        let code = child.wait().unwrap().code();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert_eq!(left_over(&folder.path().join("o")), ["parts.obj"]);
        assert_eq!(fs::read_to_string(folder.path().join("o/parts.obj")).unwrap(), "kept");
        // Before the handler is in place, the signal ends the process as usual.
        assert!(code == Some(130) || code.is_none(), "{code:?}: {stderr}");
        if code == Some(130) {
            break;
        }
    }
    assert!(stderr.contains("interrupted"), "{stderr}");
}

/// Lines of a stream, as they arrive.
fn lines(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

/// Reads until a line holds `part`; the lines before it are in the message if it never comes.
#[track_caller]
fn wait_for(lines: &Receiver<String>, part: &str) -> String {
    let mut seen = Vec::new();
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        match lines.recv_timeout(Duration::from_millis(200)) {
            Ok(line) if line.contains(part) => return line,
            Ok(line) => seen.push(line),
            Err(_) => {}
        }
    }
    panic!("no `{part}` in {seen:#?}");
}

#[test]
fn a_watch_bakes_what_changes_survives_errors_and_ends_on_ctrl_c() {
    let folder = meshes(3, 40);
    // The output is inside the input: the watch's own output must not trigger it.
    let mut child = command(folder.path(), ["build", "in", "--out", "in/o", "--watch"]);
    let mut child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (out, messages) = (lines(child.stdout.take().unwrap()), lines(child.stderr.take().unwrap()));
    wait_for(&out, "3 baked, 0 fresh");
    wait_for(&messages, "watching for changes");

    write(&folder, "in/1.obj", sphere(41, 9));
    assert!(wait_for(&messages, "changed: ").contains("in/1.obj"));
    wait_for(&out, "1 baked, 0 fresh");
    wait_for(&messages, "watching");

    write(&folder, "in/1.obj", "v 1 2\n");
    wait_for(&messages, "error: in/1.obj:1: ");
    wait_for(&messages, "watching");
    write(&folder, "in/1.obj", sphere(42, 9));
    wait_for(&out, "1 baked, 0 fresh");
    wait_for(&messages, "watching");

    write(&folder, "in/new/4.obj", sphere(43, 9));
    wait_for(&out, "1 baked");
    wait_for(&messages, "watching");
    let start = Instant::now();
    while !folder.path().join("in/o/new/4.hullmap").exists() {
        assert!(start.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(10));
    }

    write(&folder, "in/hullmap.toml", "[defaults]\nindex = \"octree\"\n");
    wait_for(&messages, "in/hullmap.toml:2: index = \"octree\"");
    wait_for(&messages, "watching");
    write(&folder, "in/hullmap.toml", "[defaults]\nindex = \"none\"\n");
    wait_for(&out, "4 baked, 0 fresh");
    wait_for(&messages, "watching");

    // A pack that was deleted was not baked again.
    fs::remove_file(folder.path().join("in/o/1.hullmap")).unwrap();
    wait_for(&out, "1 baked, 0 fresh");
    wait_for(&messages, "watching");
    fs::remove_dir_all(folder.path().join("in/o")).unwrap();
    wait_for(&out, "4 baked, 0 fresh");
    wait_for(&messages, "watching");

    fs::remove_file(folder.path().join("in/0.obj")).unwrap();
    wait_for(&messages, "0.hullmap: its source ");
    wait_for(&messages, "watching");
    // From here on nothing changes, so nothing is baked.
    let more = messages.recv_timeout(Duration::from_millis(1500));
    assert!(more.is_err(), "{more:?}");
    signal(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(messages.recv_timeout(PATIENCE).as_deref(), Ok("stopped watching"), "nothing was interrupted");
}

/// Memory that the process takes even for the smallest bake: code, threads, their stacks and the
/// allocator's arenas.
#[cfg(target_os = "linux")]
const BASE: u64 = 24 << 20;

/// Peak memory of a build of the folder `in`, as `/proc` reports it while the process runs.
#[cfg(target_os = "linux")]
fn peak(folder: &TempDir, words: &[&str]) -> u64 {
    let line = ["build", "in", "--out", "o", "--force", "--quiet", "--jobs", "6"];
    let mut child = command(folder.path(), line.iter().chain(words)).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
        peak = peak.max(kib.unwrap_or(0) << 10);
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(child.wait().unwrap().success());
    peak
}

/// Texts, and the densest sources: clouds of 12 bytes per point, with all points on the hull, and
/// the indices that take the most memory.
#[cfg(target_os = "linux")]
#[test]
fn memory_stays_within_the_bound() {
    const POINTS: usize = 15_000;
    const RESOLUTION: u64 = 64;
    let texts = meshes(6, POINTS);
    let dense = tempfile::tempdir().unwrap();
    for index in 0..6 {
        let header = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {POINTS}\nproperty float x\nproperty float y\n\
             property float z\nend_header\n"
        );
        let points = Family::Sphere.points(POINTS, index);
        let bytes = points.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        write(&dense, &format!("in/{index}.ply"), header.into_bytes().into_iter().chain(bytes).collect::<Vec<u8>>());
    }
    for (folder, file, bytes, index, cells) in [
        (&texts, "in/0.obj", 128, "tree", 0),
        (&dense, "in/0.ply", 320, "tree", 0),
        (&dense, "in/0.ply", 320, "cubemap", 6 * RESOLUTION * RESOLUTION),
    ] {
        let source = fs::metadata(folder.path().join(file)).unwrap().len();
        let one = bytes * source + 640 * cells + (256 << 10);
        let bounded = peak(folder, &["--set", &format!("index={index}"), "--memory", &one.to_string()]);
        println!("{index}: sources of {source} bytes; peak {bounded} within a bound of {one}");
        assert!(bounded <= one + BASE, "{index}: {bounded} of {one} and {BASE}");
        if folder.path() == texts.path() {
            let free = peak(folder, &[]);
            assert!(free > bounded, "six at once take more than one at a time: {free}, {bounded}");
        }
    }
}
