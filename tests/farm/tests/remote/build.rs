//! `bake build --remote` against a farm in this process, whose workers run the command itself.

use std::{fs, path::Path};

use hullmap_outside::command::Run;
use hullmap_outside::files::contents;
use serde_json::Value;
use tempfile::TempDir;

use crate::farm_server::FarmServer;
use crate::{binary, run};

const CUBE: &str =
    "o cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 4 3\nf 5 6 8 7\n";

/// A triangle whose positions are in `data/a.bin`.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"data/a.bin","byteLength":36}]}"#;

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// A checkout: cubes, a glTF file with a buffer, and options.
pub fn checkout(root: &Path) {
    for index in 0..20 {
        let text = CUBE.replace("1 1 1", &format!("1 1 {}", index + 1));
        write(root, &format!("in/{}/{index}.obj", index % 3), text);
    }
    write(root, "in/a.gltf", GLTF);
    let positions: Vec<u8> =
        [0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    write(root, "in/data/a.bin", positions);
    write(root, "in/hullmap.toml", "[[rule]]\nfiles = \"1/*.obj\"\nindex = \"compact\"\n");
}

/// A farm, and a checkout `one` with the packs of a local build in `local`.
pub struct Setup {
    pub server: FarmServer,
    pub folder: TempDir,
}

impl Setup {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        checkout(&folder.path().join("one"));
        run(&folder.path().join("one"), "build in --out local").expect(0);
        Self { server: FarmServer::start(), folder }
    }

    /// Builds on the farm, in a checkout.
    pub fn build(&self, checkout: &str, more: &str) -> Run {
        let (url, worker) = (self.server.url(), binary().display());
        let line = format!("build in --out o --json --remote {url} --remote-worker {worker} {more}");
        run(&self.folder.path().join(checkout), &line)
    }

    /// Asserts that a checkout has exactly the packs of the local build, and no other files.
    pub fn assert_equal(&self, checkout: &str) {
        let packs = |place: &str| contents(&self.folder.path().join(place));
        assert_eq!(packs(&format!("{checkout}/o")), packs("one/local"));
    }
}

/// How many rows have this value in a field.
pub fn count(run: &Run, field: &str, value: &str) -> usize {
    run.json().iter().filter(|row| row[field] == value).count()
}

#[test]
fn workers_bake_the_same_packs_and_every_checkout_shares_them() {
    let setup = Setup::new();
    let cold = setup.build("one", "--remote-header authorization=secret --remote-property OSFamily=linux").expect(0);
    assert_eq!(count(&cold, "origin", "worker"), 21, "{}", cold.stdout);
    setup.assert_equal("one");
    assert_eq!(setup.server.state.lock().unwrap().headers["authorization"], "secret");

    // Nothing to do: no batch is looked up.
    let looked_up = setup.server.requests("GetActionResult");
    let again = setup.build("one", "--remote-property OSFamily=linux").expect(0);
    assert_eq!((count(&again, "status", "fresh"), setup.server.requests("GetActionResult")), (21, looked_up));

    // Another checkout, in another folder, finds everything in the cache.
    checkout(&setup.folder.path().join("deep/two"));
    let runs = setup.server.state.lock().unwrap().runs;
    let warm = setup.build("deep/two", "--remote-property OSFamily=linux --verify").expect(0);
    assert_eq!(count(&warm, "origin", "cache"), 21, "{}", warm.stdout);
    assert_eq!(setup.server.state.lock().unwrap().runs, runs);
    setup.assert_equal("deep/two");

    // An edit bakes its batch again, but takes only the pack that changed.
    write(&setup.folder.path().join("deep/two"), "in/0/0.obj", CUBE.replace("1 1 1", "5 5 5"));
    let edited = setup.build("deep/two", "--remote-property OSFamily=linux").expect(0);
    assert_eq!((count(&edited, "origin", "worker"), count(&edited, "status", "fresh")), (1, 20));
    // Other properties are another action.
    fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
    assert_eq!(count(&setup.build("one", "").expect(0), "origin", "worker"), 21);
}

#[test]
fn rows_match_a_local_bake() {
    let setup = Setup::new();
    let strip = |run: Run| -> Vec<Value> {
        let mut rows = run.json();
        for row in &mut rows {
            for field in ["millis", "origin"] {
                row.as_object_mut().unwrap().remove(field);
            }
        }
        rows
    };
    let local = strip(run(&setup.folder.path().join("one"), "build in --out o --json").expect(0));
    fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
    let remote = strip(setup.build("one", "").expect(0));
    for (local, remote) in local.iter().zip(&remote) {
        let mut expected = local.clone();
        expected["reason"] = remote["reason"].clone();
        assert_eq!(&expected, remote);
    }
}

#[test]
fn a_faulty_mesh_fails_alone_and_its_failure_is_cached() {
    let setup = Setup::new();
    write(&setup.folder.path().join("one"), "in/2/bad.obj", "v 0 0 0\nv 1 0\n");
    let first = setup.build("one", "").expect(1);
    assert_eq!((count(&first, "origin", "worker"), count(&first, "status", "failed")), (21, 1));
    let error = first.json().iter().find_map(|row| row["error"].as_str().map(str::to_owned)).unwrap();
    assert!(error.starts_with("in/2/bad.obj:2: "), "{error}");
    setup.assert_equal("one");
    fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
    let runs = setup.server.state.lock().unwrap().runs;
    let second = setup.build("one", "").expect(1);
    assert_eq!((count(&second, "origin", "cache"), count(&second, "status", "failed")), (21, 1));
    assert_eq!(setup.server.state.lock().unwrap().runs, runs);
}

#[test]
fn without_workers_the_cache_is_filled_from_here() {
    let setup = Setup::new();
    setup.server.state.lock().unwrap().executes = false;
    assert!(setup.build("one", "").expect(2).stderr.contains("--remote-cache-only"));
    let first = setup.build("one", "--remote-cache-only").expect(0);
    assert_eq!((count(&first, "origin", "local"), setup.server.requests("UpdateActionResult")), (21, 0));
    fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
    let second = setup.build("one", "--remote-cache-only --remote-upload").expect(0);
    assert_eq!(count(&second, "origin", "local"), 21);
    checkout(&setup.folder.path().join("two"));
    let third = setup.build("two", "--remote-cache-only --verify").expect(0);
    assert_eq!(count(&third, "origin", "cache"), 21);
    setup.assert_equal("two");
}

/// Others would get the pack of the edited mesh for the old one.
#[test]
fn an_edit_during_a_build_is_not_shared() {
    let setup = Setup::new();
    let mesh = setup.folder.path().join("one/in/0/0.obj");
    let build = |exit| {
        let run = setup.build("one", "--remote-cache-only --remote-upload").expect(exit);
        fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
        run
    };
    let honest = fs::read_to_string(&mesh).unwrap();
    for edit in [CUBE.replace("1 1 1", "1 1 7"), "f 1 2 9\n".to_owned()] {
        let is_faulty = edit.starts_with('f');
        setup.server.state.lock().unwrap().edit = Some((mesh.clone(), edit));
        let run = build(i32::from(is_faulty));
        assert!(setup.server.state.lock().unwrap().edit.is_none(), "the mesh was edited");
        assert_eq!(count(&run, "origin", "local"), 21 - usize::from(is_faulty));
        assert_eq!(setup.server.requests("UpdateActionResult"), 0);
        fs::write(&mesh, &honest).unwrap();
    }
    build(0);
    assert_eq!(setup.server.requests("UpdateActionResult"), 1);
}

#[test]
fn interruptions_are_survived() {
    let setup = Setup::new();
    // The first request, then others, fail; the stream of an action breaks off.
    setup.server.state.lock().unwrap().failures = 2;
    setup.server.state.lock().unwrap().broken_streams = 1;
    setup.build("one", "").expect(0);
    assert!(setup.server.requests("WaitExecution") >= 1);
    setup.assert_equal("one");
}

#[test]
fn an_unreachable_server_is_an_error_or_a_warning() {
    let setup = Setup::new();
    let folder = setup.folder.path().join("one");
    // A port that is free, because its listener is gone.
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let line = format!("build in --out o --remote grpc://127.0.0.1:{port}");
    let error = run(&folder, &line).expect(2).stderr;
    assert!(error.contains("does not answer") && error.contains("--remote-fallback"), "{error}");
    assert!(contents(&folder.join("o")).is_empty());
    let warning = run(&folder, &format!("{line} --remote-fallback")).expect(0).stderr;
    assert!(warning.contains("warning: ") && warning.contains("baking here"), "{warning}");
    setup.assert_equal("one");
}

#[test]
fn poisoned_results_are_rejected() {
    let setup = Setup::new();
    setup.build("one", "").expect(0);
    let folder = setup.folder.path().join("one");
    let honest = setup.server.state.lock().unwrap().results.clone();
    // Another mesh's pack, with a correct checksum.
    let other = fs::read(folder.join("o/0/3.hullmap")).unwrap();
    // The right mesh with other options, and a damaged pack.
    run(&folder, "build in/0/0.obj --out odd --index none --no-config --quiet").expect(0);
    let odd = fs::read(folder.join("odd/0.hullmap")).unwrap();
    let mut damaged = fs::read(folder.join("o/0/0.hullmap")).unwrap();
    *damaged.last_mut().unwrap() ^= 1;
    for (poison, reason) in [
        (other, "the source has changed"),
        (odd, "the options have changed"),
        (damaged, "checksum"),
        (b"no pack".to_vec(), "the header of a pack"),
    ] {
        {
            let mut state = setup.server.state.lock().unwrap();
            let digest = state.put(poison);
            state.results = honest.clone();
            for file in state.results.values_mut().flat_map(|result| &mut result.output_files) {
                if file.path == "out/0/0.hullmap" {
                    file.digest = Some(digest.clone());
                }
            }
        }
        fs::remove_dir_all(folder.join("o")).unwrap();
        let run = setup.build("one", "").expect(1);
        assert_eq!((count(&run, "status", "failed"), count(&run, "origin", "cache")), (1, 20), "{}", run.stdout);
        assert!(run.stderr.contains("was rejected") && run.stderr.contains(reason), "{}", run.stderr);
        assert_eq!(contents(&folder.join("o")).len(), 20, "nothing was written for it");
        let action = setup.server.state.lock().unwrap().results.keys().next().unwrap().clone();
        assert!(run.stderr.contains(&format!("remove the result of action {action} ")), "{}", run.stderr);
        // It can be baked here instead.
        let run = setup.build("one", "--remote-fallback").expect(0);
        assert!(run.stderr.contains("was rejected") && run.stderr.contains("baking it here"), "{}", run.stderr);
        assert_eq!((count(&run, "origin", "local"), count(&run, "status", "fresh")), (1, 20));
        setup.assert_equal("one");
    }
    // An upload heals the cache.
    let run = setup.build("one", "--remote-cache-only --remote-fallback --remote-upload").expect(0);
    assert_eq!(count(&run, "status", "fresh"), 21);
    fs::remove_dir_all(folder.join("o")).unwrap();
    let run = setup.build("one", "--remote-cache-only --remote-fallback --remote-upload").expect(0);
    assert_eq!((count(&run, "origin", "cache"), count(&run, "origin", "local")), (20, 1));
    fs::remove_dir_all(folder.join("o")).unwrap();
    assert_eq!(count(&setup.build("one", "--remote-cache-only").expect(0), "origin", "cache"), 21);
    // So does a worker.
    let healed = setup.build("one", "--force").expect(0);
    assert_eq!(count(&healed, "origin", "worker"), 21);
    fs::remove_dir_all(folder.join("o")).unwrap();
    assert_eq!(count(&setup.build("one", "").expect(0), "origin", "cache"), 21);
    setup.assert_equal("one");
}

/// Stores remove blobs that were not used for long, and action caches keep entries that name them.
#[test]
fn files_that_were_removed_from_the_store_are_baked_again() {
    let setup = Setup::new();
    setup.build("one", "").expect(0);
    {
        let mut state = setup.server.state.lock().unwrap();
        let gone: Vec<String> = state
            .results
            .values()
            .flat_map(|result| &result.output_files)
            .map(|f| f.digest.clone().unwrap().hash)
            .collect();
        gone.iter().for_each(|hash| drop(state.blobs.remove(hash)));
    }
    fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
    let run = setup.build("one", "").expect(0);
    assert_eq!(count(&run, "origin", "worker"), 21);
    setup.assert_equal("one");
}

/// A pack with the right header and a correct checksum, but the hull of another mesh.
#[test]
fn a_pack_with_the_right_header_and_wrong_hulls_is_rejected_with_verify() {
    let setup = Setup::new();
    setup.build("one", "").expect(0);
    let folder = setup.folder.path().join("one");
    let forged = {
        use hullmap_format::header::{HEADER_LEN, Header};
        let [right, wrong] = ["o/0/0.hullmap", "o/0/3.hullmap"].map(|name| fs::read(folder.join(name)).unwrap());
        let right = Header::read(&right).unwrap();
        let payload = String::from_utf8_lossy(&wrong[HEADER_LEN..]).len();
        assert!(payload > 0);
        // The recorded path has the same length: `3.obj` becomes `0.obj`.
        let mut payload = wrong[HEADER_LEN..].to_vec();
        let at = payload.windows(5).position(|window| window == b"3.obj").unwrap();
        payload[at] = b'0';
        let header = Header::for_payload(right.source_hash, right.options_hash, &payload);
        [header.to_bytes().to_vec(), payload].concat()
    };
    {
        let mut state = setup.server.state.lock().unwrap();
        let digest = state.put(forged);
        for file in state.results.values_mut().flat_map(|result| &mut result.output_files) {
            if file.path == "out/0/0.hullmap" {
                file.digest = Some(digest.clone());
            }
        }
    }
    fs::remove_dir_all(folder.join("o")).unwrap();
    // Without --verify it is accepted, as docs/farm-security.md states.
    setup.build("one", "").expect(0);
    fs::remove_dir_all(folder.join("o")).unwrap();
    let run = setup.build("one", "--verify").expect(1);
    assert!(run.stderr.contains("the farm's pack: verification failed"), "{}", run.stderr);
    assert_eq!(contents(&folder.join("o")).len(), 20);
}

#[test]
fn a_lying_store_is_noticed() {
    let setup = Setup::new();
    setup.build("one", "").expect(0);
    {
        let mut state = setup.server.state.lock().unwrap();
        let hashes: Vec<String> = state
            .results
            .values()
            .flat_map(|result| &result.output_files)
            .map(|f| f.digest.clone().unwrap().hash)
            .collect();
        for hash in hashes {
            state.blobs.insert(hash, b"something else".to_vec());
        }
    }
    fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
    let run = setup.build("one", "").expect(1);
    assert!(run.stderr.contains("do not have the digest"), "{}", run.stderr);
    // The same with a bake here instead.
    setup.build("one", "--remote-fallback").expect(0);
    setup.assert_equal("one");
}
