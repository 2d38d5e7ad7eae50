//! Programs in C and C++ against the installed library, if there is a compiler: the headers in each
//! language version, the layout of structs, hostile calls, and the examples.

use std::{
    env, fs,
    mem::offset_of,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use hullmap_c::exports::batch::ShapePair;
use hullmap_c::types;
use hullmap_testkit::packs;

/// Warnings that a user may have switched on.
const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-pedantic", "-Werror"];

fn crate_path(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A compiler: from the environment variable, or the usual one. `None` if it does not run.
#[expect(clippy::disallowed_methods, reason = "the machine says which compiler it has")]
fn compiler(variable: &str, usual: &str) -> Option<String> {
    let name = env::var(variable).ok().filter(|name| !name.is_empty()).unwrap_or_else(|| usual.to_owned());
    let runs = Command::new(&name).arg("--version").output().is_ok_and(|output| output.status.success());
    if !runs {
        println!("skipped: {usual} does not run; set {variable}");
    }
    runs.then_some(name)
}

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    println!("{out}");
    assert!(output.status.success(), "{command:?}: {}\n{out}{err}", output.status);
    output
}

/// The folder into which Cargo has built this test and the libraries.
fn libraries() -> PathBuf {
    env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// The headers and libraries, installed into a folder of their own.
fn install(into: &Path) {
    let mut install = Command::new(crate_path("install"));
    run(install.arg(into).arg("--from").arg(libraries()));
}

/// Blocks of a document between fences that name a language.
fn examples(document: &str, language: &str) -> Vec<String> {
    let text = fs::read_to_string(crate_path(document)).expect(document);
    let fence = format!("```{language}\n");
    text.split(&fence).skip(1).filter_map(|rest| Some(rest.split_once("\n```")?.0.to_owned() + "\n")).collect()
}

/// A pack of one hull with a flat top: a prism of 64 sides. The top is at z = 1.
fn write_pack(path: &Path) {
    let corner = |i: usize| {
        let angle = std::f32::consts::TAU * (i / 2) as f32 / 64.0;
        [2.0 * angle.cos(), 2.0 * angle.sin(), if i.is_multiple_of(2) { 1.0 } else { -1.0 }]
    };
    let set = packs::point_set("table", &(0..128).map(corner).collect::<Vec<_>>());
    let bytes = packs::bytes(&[set], hullmap_bake::IndexKind::Tree, &hullmap_bake::SourceRecord::default());
    fs::write(path, bytes.unwrap()).unwrap();
}

/// Each header compiles without a warning, alone and twice.
#[test]
fn headers_compile_in_each_language_version() {
    let folder = tempfile::tempdir().unwrap();
    let include = crate_path("include");
    let check = |compiler: &str, header: &str, file: &str, standards: &[&str]| {
        let source = folder.path().join(file);
        let more = if header.ends_with(".h") { "\nHullmapPose pose = HULLMAP_POSE_IDENTITY;" } else { "" };
        fs::write(&source, format!("#include <{header}>\n#include <{header}>{more}\n")).unwrap();
        for standard in standards {
            let mut command = Command::new(compiler);
            run(command.args(WARNINGS).args([standard, "-fsyntax-only", "-I"]).arg(&include).arg(&source));
        }
    };
    if let Some(cc) = compiler("CC", "cc") {
        check(&cc, "hullmap.h", "c.c", &["-std=c99", "-std=c11", "-std=c17"]);
    }
    if let Some(cxx) = compiler("CXX", "c++") {
        check(&cxx, "hullmap.h", "cpp.cpp", &["-std=c++11", "-std=c++17"]);
        check(&cxx, "hullmap.hpp", "raii.cpp", &["-std=c++17", "-std=c++20"]);
    }
}

#[test]
fn structs_have_one_layout() {
    let Some(cc) = compiler("CC", "cc") else { return };
    let mut source = String::from("#include <hullmap.h>\n");
    let mut count = 0;
    let mut expect = |what: String, value: usize| {
        source += &format!("_Static_assert({what} == {value}, \"{what}\");\n");
        count += 1;
    };
    macro_rules! layout {
        ($($type:ident { $($field:ident)* })*) => {$(
            layout!(types::$type, $type { $($field)* });
        )*};
        ($path:ty, $type:ident { $($field:ident)* }) => {
            let name = concat!("Hullmap", stringify!($type));
            expect(format!("sizeof({name})"), size_of::<$path>());
            $(expect(format!("offsetof({name}, {})", stringify!($field)), offset_of!($path, $field));)*
        };
    }
    layout! {
        Pose { translation rotation }
        Bounds { min max }
        Text { data length }
        HullFacts {
            struct_size name vertex_count face_count rank part volume surface_area centroid inertia bounds diameter
            interior_point inner_radius outer_radius containment_error outer_error origin
            part_count solid uncovered protrusion protrusion_at voids voids_error
        }
        MassProperties { mass center_of_mass inertia source }
        Replacement { kind pose sizes protrusion }
        HullArrays {
            vertices source_vertices neighbour_starts vertex_count neighbours neighbour_count face_starts face_count
            face_vertices face_vertex_count
        }
        MeshTriangle { corners vertices neighbours edge_classes source_triangle material }
        FieldLayout { columns rows origin spacing diagonal holes }
        Settings { struct_size tolerance max_iterations }
        CastSettings { struct_size max_t tolerance max_iterations }
        ManifoldSettings { struct_size tolerance max_iterations prediction_kind prediction }
        SupportPoint { point feature }
        Intersection { status iterations support_calls parts }
        Distance { status distance lower upper normal point_a point_b iterations support_calls parts features }
        Contact {
            hit is_only_normal status depth depth_lower depth_upper normal point_a point_b iterations support_calls
            parts features
        }
        RayHit { hit status t t_lower t_upper point normal iterations support_calls part }
        Impact { hit status t t_lower t_upper normal point_a point_b iterations support_calls parts }
        SignedDistance { status distance lower upper point normal iterations support_calls part }
        Feature { kind vertices }
        ManifoldPoint {
            normal point_a point_b local_b depth impulse user_data age parts feature_a feature_b status
        }
        ManifoldPoints { points count touching dropped pairs iterations support_calls }
        Ground { height normal triangle }
        Motion { kind start end linear angular center }
        MotionSettings { struct_size target_distance tolerance max_iterations }
        ClearSettings { struct_size margin tolerance share max_iterations }
        TimeOfImpact { hit status t t_lower t_upper normal point_a point_b iterations support_calls parts }
        Clearance { verdict status clearance nearest t_lower t_upper iterations support_calls parts }
        Derivatives { status by_a by_b }
        WitnessDerivatives { status by_a by_b }
    }
    layout!(types::DVec3, Vec3 { x y z });
    layout!(types::DQuat, Quat { x y z w });
    layout!(hullmap::PoseDerivative, PoseDerivative { linear angular });
    layout!(hullmap::WitnessJacobian, WitnessJacobian { normal point_a point_b });
    layout!(ShapePair, Pair { a b b_in_a });
    for (name, value) in [
        ("RESULT_PANIC", types::Result::Panic as usize),
        ("STATUS_STALLED", types::Status::Stalled as usize),
        ("OVERLAP_UNDECIDED", types::Overlap::Undecided as usize),
        ("FEATURE_KIND_VERTEX", types::FeatureKind::Vertex as usize),
        ("PREDICTION_LENGTH", types::Prediction::Length as usize),
        ("DIAGONAL_FALLING", types::Diagonal::Falling as usize),
        ("MOTION_KIND_SCREW", types::MotionKind::Screw as usize),
        ("VERDICT_OPEN", types::Verdict::Open as usize),
        ("DIFFERENTIABILITY_INACCURATE", types::Differentiability::Inaccurate as usize),
        ("EDGE_CLASS_REVERSED", types::EdgeClass::Reversed as usize),
        ("MASS_SOURCE_MESH", types::MassSource::Mesh as usize),
    ] {
        expect(format!("HULLMAP_{name}"), value);
    }
    assert!(count > 100, "{count}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layout.c");
    fs::write(&path, source).unwrap();
    run(Command::new(&cc).args(["-std=c11", "-fsyntax-only", "-I"]).arg(crate_path("include")).arg(path));
}

/// Names of the sections of a file in ELF of 64 bits, little-endian.
fn sections(file: &[u8]) -> Vec<&str> {
    let number = |at: usize, len: usize| file[at..at + len].iter().rev().fold(0, |n, byte| n << 8 | *byte as usize);
    let header = |index: usize| number(0x28, 8) + index * number(0x3a, 2);
    let names = number(header(number(0x3e, 2)) + 0x18, 8);
    let name = |index: usize| {
        let rest = &file[names + number(header(index), 4)..];
        std::str::from_utf8(rest.split(|byte| *byte == 0).next().unwrap()).unwrap()
    };
    (0..number(0x3c, 2)).map(name).collect()
}

/// An installed library of 3 MB had 16 MB of symbols for debuggers. Without
/// `CARGO_PROFILE_DEV_DEBUG`, there are no line numbers, and the test only looks at what is left
/// out.
#[test]
#[cfg_attr(
    not(all(target_os = "linux", target_pointer_width = "64", target_endian = "little")),
    ignore = "the test reads ELF of 64 bits"
)]
fn libraries_were_installed_with_their_symbols() {
    let folder = tempfile::tempdir().unwrap();
    let prefix = folder.path();
    install(prefix);
    let read = |file: &str| fs::read(prefix.join("lib").join(file)).expect(file);
    let shared = format!("libhullmap.so.{}", env!("CARGO_PKG_VERSION"));
    let (library, symbols) = (read(&shared), read(&format!("{shared}.debug")));
    let (of_library, of_symbols) = (sections(&library), sections(&symbols));
    assert!(of_library.contains(&".text") && of_library.contains(&".gnu_debuglink"), "{of_library:?}");
    assert!(!of_library.iter().any(|name| name.starts_with(".debug") || *name == ".symtab"), "{of_library:?}");
    assert!(of_symbols.contains(&".symtab"), "{of_symbols:?}");
    let has_lines = sections(&fs::read(libraries().join("libhullmap_c.so")).unwrap()).contains(&".debug_line");
    assert_eq!(of_symbols.contains(&".debug_line"), has_lines, "{of_symbols:?}");
    assert!(has_lines || option_env!("CARGO_PROFILE_DEV_DEBUG").is_none(), "the nightly step asks for line numbers");
    let len = |path: PathBuf| fs::metadata(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).len();
    let built = |file: &str| len(libraries().join(file));
    let installed = |file: &str| len(prefix.join("lib").join(file));
    assert!(installed(&shared) < built("libhullmap_c.so"), "{}", installed(&shared));
    assert!(!has_lines || installed(&shared) < built("libhullmap_c.so") / 2, "{}", installed(&shared));
    let [stripped, whole] = ["libhullmap.a", "debug/libhullmap.a"].map(installed);
    assert!(!has_lines || 2 * stripped < built("libhullmap_c.a"), "{stripped}");
    assert!(stripped < whole, "{stripped} {whole}");

    // Without symbols, also in place of an installation that has them.
    run(Command::new(crate_path("install")).arg(prefix).arg("--no-symbols").arg("--from").arg(libraries()));
    assert!(!sections(&read(&shared)).contains(&".gnu_debuglink"));
    assert!(!prefix.join(format!("lib/{shared}.debug")).exists() && !prefix.join("lib/debug/libhullmap.a").exists());
}

/// The examples and the hostile calls, against the installed shared library, and `settle` against
/// the static one.
#[test]
#[cfg_attr(not(unix), ignore = "the script `install` is for Unix")]
fn programs_run_against_the_installed_library() {
    let (Some(cc), Some(cxx)) = (compiler("CC", "cc"), compiler("CXX", "c++")) else { return };
    let folder = tempfile::tempdir().unwrap();
    let (prefix, pack) = (folder.path().join("prefix"), folder.path().join("table.hullmap"));
    install(&prefix);
    // Every copy of the libraries needs them.
    let licences = prefix.join("share/licenses/hullmap");
    for (file, words) in [
        ("LICENSE-MIT", "Permission is hereby granted"),
        ("LICENSE-APACHE", "Apache License"),
        ("LICENSES-OF-DEPENDENCIES.txt", "==== rkyv "),
    ] {
        assert!(fs::read_to_string(licences.join(file)).expect(file).contains(words), "{file}");
    }
    write_pack(&pack);
    let library_path = if cfg!(target_os = "macos") { "DYLD_LIBRARY_PATH" } else { "LD_LIBRARY_PATH" };
    let built = |compiler: &str, standard: &str, source: &str, link: &[&str]| {
        let program = folder.path().join(format!("program-{}", source.replace(['/', '.'], "-")));
        let mut command = Command::new(compiler);
        command.args(WARNINGS).arg(standard).arg("-g").arg(crate_path(source)).arg("-I").arg(prefix.join("include"));
        run(command.arg("-L").arg(prefix.join("lib")).args(link).arg("-o").arg(&program));
        program
    };
    for (compiler, standard, source, link, words) in [
        (&cc, "-std=c99", "examples/quick.c", &["-lhullmap"][..], "table: 128 vertices, 66 faces"),
        (&cc, "-std=gnu99", "tests/c/hostile.c", &["-lhullmap", "-pthread"], " checks, 0 failures\n"),
        (&cxx, "-std=c++17", "examples/settle.cpp", &["-lhullmap"], "4 points, 0.2500 above"),
        (&cxx, "-std=c++17", "tests/c/moved.cpp", &["-lhullmap"], " checks, 0 failures\n"),
    ] {
        let program = built(compiler, standard, source, link);
        let output = run(Command::new(program).arg(&pack).env(library_path, prefix.join("lib")));
        let out = String::from_utf8_lossy(&output.stdout);
        assert!(out.contains(words), "{source}: {out}");
    }

    // The examples in the README open a cube of edge length 2.
    let corner = |i: u8| [1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 });
    let set = packs::point_set("cube", &(0..8).map(corner).collect::<Vec<_>>());
    let cube = packs::bytes(&[set], hullmap_bake::IndexKind::Tree, &hullmap_bake::SourceRecord::default());
    fs::create_dir(folder.path().join("baked")).unwrap();
    fs::write(folder.path().join("baked/cube.hullmap"), cube.unwrap()).unwrap();
    let mut count = 0;
    for (language, compiler, standard) in [("c", &cc, "-std=c99"), ("cpp", &cxx, "-std=c++17")] {
        for text in examples("README.md", language) {
            let source = folder.path().join(format!("example-{count}.{language}"));
            fs::write(&source, text).unwrap();
            let program = built(compiler, standard, source.to_str().unwrap(), &["-lhullmap"]);
            let mut command = Command::new(program);
            run(command.current_dir(folder.path()).env(library_path, prefix.join("lib")));
            count += 1;
        }
    }
    assert_eq!(count, 2, "examples in the README");

    // Without the folder of the library: all of it is in the program.
    let pc = fs::read_to_string(prefix.join("lib/pkgconfig/hullmap.pc")).unwrap();
    let system = pc.lines().find_map(|line| line.strip_prefix("Libs.private:")).unwrap();
    let library = prefix.join("lib/libhullmap.a");
    let mut link = vec![library.to_str().unwrap()];
    link.extend(system.split_whitespace());
    let program = built(&cxx, "-std=c++17", "examples/settle.cpp", &link);
    run(Command::new(program).arg(&pack).env_remove(library_path));
    assert!(!pc.contains(prefix.to_str().unwrap()), "{pc}");
}
