//! Packs and answers have the bits that the golden file records: in this build, on 1, 2 and 16
//! threads, with every set of vector instructions. The small set is also checked under Miri, for
//! other processors (`.ci/bits`).

use hullmap_golden::golden::Golden;

fn golden() -> Golden {
    Golden::read(include_str!("../golden.txt")).unwrap()
}

#[track_caller]
fn assert_same(golden: &Golden, found: &Golden) {
    let differences = golden.differences(found);
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}

#[test]
fn the_small_set_is_the_same_bits() {
    let found = Golden::small();
    assert!(found.hashes.len() >= 11);
    assert_same(&golden(), &found);
}

#[test]
#[cfg(not(miri))]
fn the_large_set_is_the_same_bits_on_any_number_of_threads() {
    for threads in [1, 2, 16] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_same(&golden(), &pool.install(Golden::large));
    }
}

/// Each run is a process of its own, because the variable is read only once.
#[test]
#[cfg(not(miri))]
fn every_set_of_instructions_gives_the_same_bits() {
    for instructions in ["portable", "avx2", "none such"] {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_golden"))
            .env("HULLMAP_INSTRUCTIONS", instructions)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{instructions}: {text}");
    }
}

/// If the variable had no effect, the test above would be vacuous.
#[test]
#[cfg(not(miri))]
fn the_variable_chooses_the_instructions() {
    use hullmap::Instructions;
    const CHILD: &str = "HULLMAP_TEST_CHILD";
    let used = || {
        let files = hullmap_golden::packs::files(hullmap_golden::packs::Set::Small);
        hullmap_golden::packs::opened(&files)[0].hull(0).unwrap().instructions()
    };
    if let Ok(expected) = std::env::var(CHILD) {
        assert_eq!(format!("{:?}", used()), expected);
        return;
    }
    let best = {
        let files = hullmap_golden::packs::files(hullmap_golden::packs::Set::Small);
        let packs = hullmap_golden::packs::opened(&files);
        let hull = packs[0].hull(0).unwrap();
        hull.with_instructions(Instructions::Avx2).unwrap_or(hull).instructions()
    };
    for (value, expected) in [("portable", Instructions::Portable), ("avx2", best), ("PORTABLE", best), ("", best)] {
        let status = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "the_variable_chooses_the_instructions"])
            .env(CHILD, format!("{expected:?}"))
            .env("HULLMAP_INSTRUCTIONS", value)
            .stdout(std::process::Stdio::null())
            .status()
            .unwrap();
        assert!(status.success(), "{value:?}");
    }
}

#[test]
fn changed_bytes_of_the_same_version_are_reported() {
    let golden = golden();
    let mut found = golden.clone();
    for (name, hash) in &mut found.hashes {
        *hash ^= u64::from(name == "small pack small-rock") | u64::from(name == "small answers contact");
    }
    let lines = golden.differences(&found);
    assert_eq!(lines.len(), 2);
    assert!(lines[0].contains("renew the file") && lines[1].contains("raise FORMAT_VERSION"), "{lines:?}");
    found.format_version += 1;
    assert!(golden.differences(&found).iter().all(|line| line.contains("renew the file")));
}

#[test]
fn the_file_is_read_as_written() {
    assert_eq!(Golden::read(&golden().text()), Ok(golden()));
    assert!(Golden::read("a line of words").is_err());
}
