//! One build on many machines: keys, tasks with hostile files, caches.

use std::{collections::BTreeSet, fs, path::Path};

use hullmap_outside::command::{Run, bake_line as run, command};
use hullmap_outside::files::{contents, write};
use serde_json::Value;
use tempfile::TempDir;

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

/// A triangle whose positions are in `a.bin`.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"a.bin","byteLength":36}]}"#;

/// Positions of that triangle.
fn positions() -> Vec<u8> {
    [0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A folder `in` with `count` cubes of different sizes in three folders, and a glTF file.
fn meshes(count: usize) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_meshes(folder.path(), count);
    folder
}

fn write_meshes(folder: &Path, count: usize) {
    for index in 0..count {
        let text = CUBE.replace("1 1 1", &format!("1 1 {}", index + 1));
        write(folder, &format!("in/{}/{index}.obj", index % 3), text);
    }
    write(folder, "in/a.gltf", GLTF);
    write(folder, "in/a.bin", positions());
}

/// The key is computed as the page describes, and written as by sha256sum.
#[test]
fn keys_are_hashes_of_their_ingredients() {
    let folder = meshes(3);
    let row = &run(folder.path(), "key in/0/0.obj --json").expect(0).json()[0];
    let text = run(folder.path(), "key in/0/0.obj").expect(0).stdout;
    assert_eq!(text, format!("{}  in/0/0.obj\n", row["key"].as_str().unwrap()));
    let names = ["baker", "format_version", "name", "options", "records", "inputs"];
    let inputs = row["inputs"].as_array().unwrap();
    let input = ["path", "bytes", "sha256"].map(|name| format!("\"{name}\":{}", inputs[0][name])).join(",");
    let field = |name: &str| match name {
        "inputs" => format!("\"inputs\":[{{{input}}}]"),
        _ => format!("\"{name}\":{}", row[name]),
    };
    write(folder.path(), "hashed.json", format!("{{{}}}", names.map(field).join(",")));
    // An independent SHA-256, where the system has one.
    if let Ok(out) = std::process::Command::new("sha256sum").arg(folder.path().join("hashed.json")).output() {
        let sum = String::from_utf8(out.stdout).unwrap();
        assert_eq!(sum.split(' ').next(), row["key"].as_str());
    }
    write(folder.path(), "in/bad.gltf", "{");
    run(folder.path(), "key in").expect(1);
}

/// The tasks of a plan in this folder.
fn plan(folder: &Path, line: &str) -> Vec<Value> {
    let out = run(folder, &format!("plan {line}")).expect(0);
    fs::write(folder.join("plan.jsonl"), &out.stdout).unwrap();
    out.json()
}

/// `/dev/zero` was read to 4 GiB although the plan stated 200 bytes, a pipe blocked the task, and
/// with an empty list of inputs any mesh passed for the planned one.
#[test]
fn a_task_trusts_neither_files_nor_keys() {
    let folder = meshes(1);
    let path = |name: &str| folder.path().join(name);
    let text = run(folder.path(), "plan in/0/0.obj --out o").expect(0).stdout;
    let planned: Value = serde_json::from_str(&text).unwrap();
    let key = planned["meshes"][0]["key"].as_str().unwrap();
    let inputs =
        format!("\"inputs\":{}", text.split_once("\"inputs\":").unwrap().1.trim().strip_suffix("}]}").unwrap());
    let task = |changes: &[(&str, &str)], code: i32| {
        let changed = changes.iter().fold(text.clone(), |text, (from, to)| {
            assert!(text.contains(from), "{from}: {text}");
            text.replace(from, to)
        });
        fs::write(path("task.jsonl"), changed).unwrap();
        let run = run(folder.path(), "task task.jsonl").expect(code);
        assert_eq!(path("o/0.hullmap").exists(), code == 0);
        run.stderr
    };
    let source = "\"source\":\"in/0/0.obj\"";
    assert!(task(&[(source, "\"source\":\"/dev/zero\"")], 2).contains("it is a device, not a regular file"));
    if std::process::Command::new("mkfifo").arg(path("pipe")).status().is_ok_and(|status| status.success()) {
        assert!(task(&[(source, "\"source\":\"pipe\"")], 2).contains("it is a pipe, not a regular file"));
    }
    // Far too large to be read: its size is enough.
    fs::File::create(path("huge.obj")).unwrap().set_len(1 << 40).unwrap();
    let huge = [(source, "\"source\":\"huge.obj\""), ("\"path\":\"0.obj\"", "\"path\":\"huge.obj\"")];
    assert!(task(&huge, 1).contains("huge.obj: it has changed since it was planned"));
    // A file of another name than the listed one is read as far as the plan allows.
    assert!(task(&huge[..1], 1).contains("huge.obj: it has changed since it was planned"));

    let no_key = "its pack would not have the planned key";
    assert!(task(&[(key, &"0".repeat(64))], 1).contains(no_key));
    assert!(task(&[(&inputs, "\"inputs\":[]"), (key, &"0".repeat(64))], 1).contains(no_key));
    assert!(task(&[("index tree 8", "index tree 16")], 1).contains(no_key));
    task(&[(&inputs, "\"inputs\":[]")], 0);
}

/// 13 meshes in two checkouts, and in `one/local` their packs of a build without a cache.
fn checkouts() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    ["one", "two"].iter().for_each(|checkout| write_meshes(&folder.path().join(checkout), 12));
    run(folder.path().join("one"), "build in --out local").expect(0);
    folder
}

/// Builds into an empty folder `o` of a checkout, beside the cache. Asserts that the packs equal
/// the packs of the build without a cache.
#[track_caller]
fn build_with_cache(folder: &Path, checkout: &str, more: &str) -> Run {
    let checkout = folder.join(checkout);
    let _ = fs::remove_dir_all(checkout.join("o"));
    let run = run(&checkout, &format!("build in --out o --cache ../cache --json {more}")).expect(0);
    assert_eq!(contents(&checkout.join("o")), contents(&folder.join("one/local")), "{more}");
    run
}

/// How many packs came from the cache, and how many were baked.
fn origins(run: &Run) -> [usize; 2] {
    ["cache", "local"].map(|origin| run.json().iter().filter(|row| row["origin"] == origin).count())
}

#[test]
fn checkouts_share_a_cache() {
    let folder = checkouts();
    let path = |name: &str| folder.path().join(name);
    let keys = run(path("one"), "key in --out o --json").expect(0).json();
    let keys: BTreeSet<&str> = keys.iter().map(|row| row["key"].as_str().unwrap()).collect();
    let entries: Vec<String> = keys.iter().map(|key| format!("{}/{key}.hullmap", &key[..2])).collect();
    // A killed build left this file, which is removed.
    write(path("cache"), &entries[0].replace('/', "/.").replace(".hullmap", ".hullmapAbCdEf.tmp"), "half");
    assert_eq!(origins(&build_with_cache(folder.path(), "one", "")), [0, 13]);
    assert_eq!(contents(&path("cache")).into_keys().collect::<Vec<_>>(), entries);

    let second = build_with_cache(folder.path(), "two", "--verify");
    assert_eq!(origins(&second), [13, 0]);
    let rows = second.json();
    assert!(rows.iter().all(|row| row["status"] == "baked" && row["hulls"] == 1 && row["reason"].is_string()));
    let text = run(path("two"), "build in --out p --cache ../cache").expect(0).stdout;
    assert!(text.contains("13 baked (13 from the cache), 0 fresh, 0 failed; 13 hulls"), "{text}");
    assert_eq!(origins(&run(path("two"), "build in --out p --cache ../cache --json").expect(0)), [0, 0]);
    assert_eq!(origins(&build_with_cache(folder.path(), "two", "--force")), [0, 13]);

    // In shards and tasks.
    let mut taken = 0;
    for shard in 0..3 {
        let line = format!("build in --out s --cache ../cache --json --shard {shard}/3");
        taken += origins(&run(path("two"), &line).expect(0))[0];
    }
    assert_eq!(taken, 13);
    plan(&path("two"), "in --out t");
    let task = run(path("two"), "task plan.jsonl --cache ../cache --json").expect(0);
    assert_eq!(origins(&task), [13, 0]);
    assert_eq!(contents(&path("two/t")), contents(&path("one/local")));

    // One mesh is edited, others have other options or keep their triangles.
    write(path("two"), "in/0/0.obj", CUBE.replace("1 1 1", "5 5 5"));
    assert_eq!(origins(&run(path("two"), "build in --out p --cache ../cache --json --force").expect(0)), [0, 13]);
    assert_eq!(origins(&run(path("two"), "build in --out q --cache ../cache --json").expect(0)), [13, 0]);
    for expected in [[0, 13], [13, 0]] {
        let line = format!("build in --out k{} --cache ../cache --json --keep-triangles", expected[0]);
        assert_eq!(origins(&run(path("two"), &line).expect(0)), expected);
    }
    assert_eq!(contents(&path("two/k0")).len(), 13);
    // A mesh that is rejected is no entry.
    write(path("two"), "in/0/0.obj", "v 0\n");
    for _ in 0..2 {
        run(path("two"), "build in --out q --cache ../cache --json").expect(1);
    }
    assert!(run(path("two"), "build in --out q --cache ../cache --check").expect(2).stderr.contains("--check"));
}

#[test]
fn an_entry_is_judged_like_any_pack() {
    use hullmap_format::header::{HEADER_LEN, Header};
    let folder = checkouts();
    let path = |name: &str| folder.path().join(name);
    let other = fs::read(path("one/local/0/3.hullmap")).unwrap();
    run(path("one"), "build in/0/0.obj --out odd --index none --quiet").expect(0);
    let odd = fs::read(path("one/odd/0.hullmap")).unwrap();
    run(path("one"), "build in/0/0.obj --out elsewhere --quiet").expect(0);
    let moved = fs::read(path("one/elsewhere/0.hullmap")).unwrap();
    build_with_cache(folder.path(), "one", "");
    let row = &run(path("one"), "key in/0/0.obj --out o/0 --json").expect(0).json()[0];
    let key = row["key"].as_str().unwrap();
    let entry = path("cache").join(&key[..2]).join(format!("{key}.hullmap"));
    let honest = fs::read(&entry).unwrap();
    let mut damaged = honest.clone();
    *damaged.last_mut().unwrap() ^= 1;
    for (poison, reason) in [
        (other.as_slice(), "the source has changed"),
        (&odd, "the options have changed"),
        (&moved, "the pack records its source as"),
        (&damaged, "checksum"),
        (&honest[..honest.len() - 1], "bytes"),
        (&honest[..HEADER_LEN], "bytes"),
        (b"no pack", "the header of a pack"),
        (b"", "the header of a pack"),
    ] {
        fs::write(&entry, poison).unwrap();
        let run = build_with_cache(folder.path(), "one", "");
        assert_eq!(origins(&run), [12, 1], "{reason}");
        let rejected = run.stderr.lines().filter(|line| line.contains("was rejected, and baked again")).count();
        assert!(rejected == 1 && run.stderr.contains(reason), "{reason}: {}", run.stderr);
        assert_eq!(fs::read(&entry).unwrap(), honest, "{reason}: the bake replaces the entry");
    }

    // The right header and a correct checksum, but the hull of another mesh. The recorded path has
    // the same length: `3.obj` becomes `0.obj`.
    let mut payload = other[HEADER_LEN..].to_vec();
    let at = payload.windows(5).position(|window| window == b"3.obj").unwrap();
    payload[at] = b'0';
    let right = Header::read(&honest).unwrap();
    let header = Header::for_payload(right.source_hash, right.options_hash, &payload);
    fs::write(&entry, [header.to_bytes().to_vec(), payload].concat()).unwrap();
    let run = build_with_cache(folder.path(), "one", "--verify");
    assert!(origins(&run) == [12, 1] && run.stderr.contains("verification failed"), "{}", run.stderr);
    assert_eq!(fs::read(&entry).unwrap(), honest);
}

/// A cache that cannot be used costs a warning and no pack: not a folder, a link in the place of an
/// entry's folder, entries that are folders, pipes, or too large.
#[test]
fn a_build_never_needs_its_cache() {
    let folder = checkouts();
    let path = |name: &str| folder.path().join(name);
    let warnings = |run: &Run| run.stderr.lines().filter(|line| line.starts_with("warning: --cache: ")).count();
    fs::write(path("cache"), "a file").unwrap();
    let run = build_with_cache(folder.path(), "one", "");
    assert_eq!((origins(&run), warnings(&run)), ([0, 13], 1), "{}", run.stderr);
    assert!(run.stderr.contains("(the first of "), "{}", run.stderr);
    let quiet = build_with_cache(folder.path(), "one", "--quiet");
    assert_eq!(quiet.stderr, "");

    fs::remove_file(path("cache")).unwrap();
    build_with_cache(folder.path(), "one", "");
    let entries: Vec<_> = contents(&path("cache")).into_keys().map(|name| path("cache").join(name)).collect();
    let [first, second, ..] = &entries[..] else { panic!("{entries:?}") };
    fs::remove_file(first).unwrap();
    fs::create_dir(first).unwrap();
    fs::File::create(second).unwrap().set_len(1 << 40).unwrap();
    let run = build_with_cache(folder.path(), "one", "");
    assert_eq!((origins(&run), warnings(&run)), ([11, 2], 1), "{}", run.stderr);
    assert!(second.metadata().unwrap().len() < 1 << 20, "replaced");
    fs::remove_dir(first).unwrap();

    #[cfg(unix)]
    {
        use std::os::unix::fs::{PermissionsExt, symlink};
        symlink("/dev/zero", first).unwrap();
        let run = build_with_cache(folder.path(), "one", "");
        assert_eq!((origins(&run), warnings(&run)), ([12, 1], 1), "{}", run.stderr);
        assert!(run.stderr.contains("it is a device, not a regular file") && !first.is_symlink(), "{}", run.stderr);
        // A link in the place of a folder is not followed: whoever made it would choose what is
        // read, and where files are written.
        let own = first.parent().unwrap();
        fs::rename(own, path("away")).unwrap();
        symlink(path("away"), own).unwrap();
        let before = contents(&path("away"));
        let run = build_with_cache(folder.path(), "one", "");
        assert!(origins(&run)[1] >= 1 && run.stderr.contains("is a link; replace it"), "{}", run.stderr);
        assert_eq!(contents(&path("away")), before);
        fs::remove_file(own).unwrap();
        // A folder in which nothing may be written serves readers. Root may write everywhere.
        build_with_cache(folder.path(), "one", "");
        let folders: Vec<_> = fs::read_dir(path("cache")).unwrap().map(|entry| entry.unwrap().path()).collect();
        let all = |mode: u32| {
            let set = |folder| fs::set_permissions(folder, fs::Permissions::from_mode(mode)).unwrap();
            folders.iter().chain([&path("cache")]).for_each(set);
        };
        all(0o555);
        assert_eq!(origins(&build_with_cache(folder.path(), "one", "")), [13, 0]);
        all(0o755);
    }
}

#[test]
fn many_builds_fill_a_cache_at_the_same_time() {
    let folder = checkouts();
    let path = |name: &str| folder.path().join(name);
    let builds: Vec<_> = (0..6)
        .map(|index| {
            let line = format!("build in --out o{index} --cache ../cache --quiet");
            command(&path("one"), line.split(' ')).spawn().unwrap()
        })
        .collect();
    for mut build in builds {
        assert!(build.wait().unwrap().success());
    }
    let whole = contents(&path("one/local"));
    assert!((0..6).all(|index| contents(&path(&format!("one/o{index}"))) == whole));
    let entries = contents(&path("cache"));
    assert!(entries.len() == 13 && entries.keys().all(|name| name.ends_with(".hullmap")), "{:?}", entries.keys());
    assert_eq!(origins(&build_with_cache(folder.path(), "one", "")), [13, 0]);
}
