//! `bake build --remote` against a hostile farm: sizes, digests, paths, streams without end, huge
//! messages, and text for the terminal.

use std::fs;
use std::time::Duration;

use bazel_remote_apis::build::bazel::remote::execution::v2 as api;
use hullmap_outside::files::contents;
use hullmap_remote::{Blob, Client, Digest, Settings};

use crate::build::{Setup, count};
use crate::farm_server::{FarmServer, Fault};
use crate::run;

/// The pack whose entry the tests change.
const VICTIM: &str = "out/0/0.hullmap";

/// A farm whose cache has the results of a checkout without packs.
fn warm() -> Setup {
    let setup = Setup::new();
    setup.build("one", "").expect(0);
    fs::remove_dir_all(setup.folder.path().join("one/o")).unwrap();
    setup
}

/// Changes the entry of the victim in every result.
fn change(setup: &Setup, change: impl Fn(&mut api::OutputFile)) {
    let mut state = setup.server.state.lock().unwrap();
    let results = state.results.values_mut().flat_map(|result| &mut result.output_files);
    let changed = results.filter(|file| file.path == VICTIM).map(change).count();
    assert_eq!(changed, 1);
}

/// Every file in the folder that holds all checkouts, without the local build.
fn names(setup: &Setup) -> Vec<String> {
    contents(setup.folder.path()).into_keys().filter(|name| !name.starts_with("one/local")).collect()
}

#[test]
fn sizes_and_digests_of_outputs_are_checked_before_a_download() {
    let setup = warm();
    let honest = setup.server.state.lock().unwrap().results.clone();
    let hash = "0".repeat(64);
    for (digest, reason) in [
        (Some((&*hash, 1_i64 << 40)), "which is more than"),
        (Some((&*hash, i64::MAX)), "which is more than"),
        (Some((&*hash, -1)), "a digest is missing"),
        (Some(("../../../etc/passwd", 9)), "is not a SHA-256 digest"),
        (Some(("\u{1b}[2J", 9)), "is not a SHA-256 digest"),
        (None, "a digest is missing"),
    ] {
        setup.server.state.lock().unwrap().results = honest.clone();
        let digest = digest.map(|(hash, size_bytes)| api::Digest { hash: hash.to_owned(), size_bytes });
        change(&setup, |file| file.digest.clone_from(&digest));
        let downloads = setup.server.requests("Read");
        let run = setup.build("one", "").expect(1);
        assert!(run.stderr.contains(reason) && !run.stderr.contains('\u{1b}'), "{}", run.stderr);
        assert_eq!(setup.server.requests("Read"), downloads);
    }
}

/// The path of a pack comes from its mesh. Other outputs, folders and links are never looked at.
#[test]
fn outputs_cannot_leave_the_folder() {
    let setup = warm();
    let before = names(&setup);
    let absolute = setup.folder.path().join("evil").display().to_string();
    for path in ["../evil", "out/../../evil", "one/o/evil", &absolute, "out/0/../../../evil"] {
        change(&setup, |file| path.clone_into(&mut file.path));
        for result in setup.server.state.lock().unwrap().results.values_mut() {
            let link =
                api::OutputSymlink { path: VICTIM.to_owned(), target: "/etc/passwd".to_owned(), ..Default::default() };
            result.output_symlinks = vec![link];
            let tree = api::OutputDirectory { path: "out".to_owned(), ..Default::default() };
            result.output_directories = vec![tree];
        }
        let run = setup.build("one", "").expect(1);
        assert!(run.stderr.contains("has neither out/0/0.hullmap nor an error"), "{}", run.stderr);
        assert_eq!(names(&setup), before);
        // For the next path.
        for file in setup.server.state.lock().unwrap().results.values_mut().flat_map(|result| &mut result.output_files)
        {
            if file.path == path {
                VICTIM.clone_into(&mut file.path);
            }
        }
    }
}

#[test]
fn numbers_of_outputs_are_bounded() {
    let setup = warm();
    for result in setup.server.state.lock().unwrap().results.values_mut() {
        let digest = result.output_files[0].digest.clone();
        let more = |index| api::OutputFile { path: format!("{index}"), digest: digest.clone(), ..Default::default() };
        result.output_files.extend((0..70_000).map(more));
    }
    let run = setup.build("one", "").expect(1);
    assert!(run.stderr.contains("more than 65536 outputs"), "{}", run.stderr);
}

#[test]
fn invalid_rows_are_rejected() {
    let setup = warm();
    let honest = setup.server.state.lock().unwrap().results.clone();
    let nested = format!(r#"{{"source":{}"#, "[".repeat(100_000));
    let large = "x".repeat((16 << 20) + 1);
    for (rows, reason) in [
        ("no JSON", "out/results.jsonl: expected"),
        ("{}", "out/results.jsonl: missing field"),
        (&*nested, "out/results.jsonl: invalid type"),
        (&*large, "which is more than 16777216"),
    ] {
        let mut state = setup.server.state.lock().unwrap();
        let digest = state.put(rows.as_bytes().to_vec());
        state.results = honest.clone();
        for file in state.results.values_mut().flat_map(|result| &mut result.output_files) {
            if file.path == "out/results.jsonl" {
                *file = api::OutputFile { digest: Some(digest.clone()), path: file.path.clone(), ..Default::default() };
            }
        }
        drop(state);
        let run = setup.build("one", "").expect(1);
        assert!(
            run.stderr.contains(reason) && run.stderr.len() < 1000,
            "{}",
            &run.stderr[..1000.min(run.stderr.len())]
        );
    }
}

/// A worker's words end on the terminal: in one line, escaped, and not too long.
#[test]
fn text_from_workers_is_bounded_and_escaped() {
    let setup = warm();
    let words = format!("in/0/0.obj: \u{1b}[2J\n{}", "in/0/0.obj".repeat(100_000));
    {
        let mut state = setup.server.state.lock().unwrap();
        let row = serde_json::json!({"source": "in/0/0.obj", "output": VICTIM, "status": "failed", "millis": 0,
            "notes": [], "warnings": [], "error": words});
        let digest = state.put(row.to_string().into_bytes());
        for result in state.results.values_mut() {
            result.output_files.retain(|file| file.path != VICTIM);
            for file in result.output_files.iter_mut().filter(|file| file.path == "out/results.jsonl") {
                *file = api::OutputFile { digest: Some(digest.clone()), path: file.path.clone(), ..Default::default() };
            }
        }
    }
    let run = setup.build("one", "").expect(1);
    let line = run.stderr.lines().find(|line| line.contains("in/0/0.obj")).unwrap();
    assert!(line.contains("\\u{1b}[2J\\u{a}") && line.len() < 12_000, "{} {}", line.len(), &line[..200]);
    assert_eq!(count(&run, "origin", "cache"), 20);

    // The same for a command that failed on the worker.
    for result in setup.server.state.lock().unwrap().results.values_mut() {
        (result.exit_code, result.stderr_raw) = (127, format!("{words} the end").into_bytes());
    }
    let run = setup.build("one", "").expect(1);
    let line = run.stderr.lines().find(|line| line.contains("exit code 127")).unwrap();
    assert!(line.contains("the end") && line.len() < 5000, "{} {}", line.len(), &line[..200]);
}

/// tonic panics when it reads this header.
#[test]
fn an_invalid_base64_header_does_not_end_the_program() {
    let setup = Setup::new();
    setup.server.state.lock().unwrap().fault = Some(Fault::BrokenDetails);
    let run = setup.build("one", "").expect(0);
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    setup.assert_equal("one");
}

#[test]
fn huge_answers_are_rejected() {
    let setup = Setup::new();
    setup.server.state.lock().unwrap().fault = Some(Fault::HugeAnswer);
    let run = setup.build("one", "").expect(1);
    assert!(run.stderr.contains("length too large"), "{}", run.stderr);
}

#[test]
fn an_action_without_end_is_given_up() {
    let setup = Setup::new();
    setup.server.state.lock().unwrap().fault = Some(Fault::EndlessAction);
    let run = setup.build("one", "--remote-timeout 2").expect(2);
    assert!(run.stderr.contains("did not end in time"), "{}", run.stderr);
    let local = setup.build("one", "--remote-timeout 2 --remote-fallback").expect(0);
    assert_eq!(count(&local, "origin", "local"), 21);
    setup.assert_equal("one");
}

#[test]
fn a_download_without_end_is_given_up() {
    let server = FarmServer::start();
    let mut settings = Settings::new(server.url().parse().unwrap());
    settings.attempts = 2;
    settings.request_timeout = Duration::from_millis(300);
    settings.action_timeout = Duration::from_millis(600);
    let client = Client::connect(settings).unwrap();
    // Large enough for a stream.
    let digest = Digest::new(&"0".repeat(64), 10 << 20).unwrap();
    let fetch = || client.fetch(std::slice::from_ref(&digest), 1 << 30).unwrap_err().to_string();
    for (data, reason) in [(Vec::new(), "no answer in time"), (vec![7; 100_000], "more bytes than its digest says")] {
        server.state.lock().unwrap().fault = Some(Fault::EndlessBlob(data));
        assert!(fetch().contains(reason), "{}", fetch());
    }
    assert!(server.requests("Read") >= 3);
}

/// A file that changes between hash and upload is not sent.
#[test]
fn files_that_changed_after_hashing_are_not_uploaded() {
    let server = FarmServer::start();
    let client = Client::connect(Settings::new(server.url().parse().unwrap())).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh");
    fs::write(&path, b"before").unwrap();
    let mut blob = Blob::from_bytes(b"before".to_vec());
    blob.data = hullmap_remote::Data::File(path.clone());
    for changed in [&b"after!"[..], b"longer than before"] {
        fs::write(&path, changed).unwrap();
        let error = client.upload(&[&blob]).unwrap_err().to_string();
        assert!(error.contains("it changed during the upload"), "{error}");
    }
    assert!(server.state.lock().unwrap().blobs.is_empty());
}

/// Secrets are in no message.
#[test]
fn values_of_headers_are_never_printed() {
    let setup = Setup::new();
    let folder = setup.folder.path().join("one");
    fs::write(folder.join("token"), "s3cret\n").unwrap();
    let url = setup.server.url();
    // As people write headers elsewhere, a value with a line break, and a file that is missing.
    for (header, status) in
        [("authorization:s3cret", 2), ("=s3cret", 2), ("a\u{e9}=s3cret", 2), ("x=@missing", 2), ("x=@token", 0)]
    {
        let line = format!("build in --out o --verbose --remote {url} --remote-cache-only --remote-header {header}");
        let run = run(&folder, &line).expect(status);
        let all = run.stdout + &run.stderr;
        assert!(!all.contains("s3cret"), "{header}: {all}");
    }
    assert_eq!(setup.server.state.lock().unwrap().headers["x"], "s3cret");
}

#[test]
fn unencrypted_headers_to_another_machine_get_a_warning() {
    let setup = Setup::new();
    let folder = setup.folder.path().join("one");
    // No such machine, by RFC 6761.
    let line = "build in --out o --remote grpc://farm.invalid:1 --remote-fallback --remote-header a=s3cret";
    let run = run(&folder, line).expect(0);
    assert!(run.stderr.contains("grpc://farm.invalid:1 is not encrypted"), "{}", run.stderr);
    let local = setup.build("one", "--remote-header a=s3cret").expect(0);
    assert!(!local.stderr.contains("not encrypted"), "{}", local.stderr);
}
