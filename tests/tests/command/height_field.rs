//! `bake build --height-field`, and height fields in `inspect`, `verify`, `export` and `report`.

use std::fs;

use hullmap::HeightField;
use hullmap::glam::DVec3;
use hullmap_outside::command::{Run, bake_in};
use tempfile::TempDir;

fn bake(folder: &TempDir, line: &str) -> Run {
    bake_in(folder.path(), line.split_whitespace())
}

/// Assertions about what a run printed.
trait OutputAssertions {
    /// Asserts that standard output has this text.
    fn out(&self, part: &str);
    /// Asserts that standard error has this text.
    fn err(&self, part: &str);
}

impl OutputAssertions for Run {
    #[track_caller]
    fn out(&self, part: &str) {
        assert!(self.stdout.contains(part), "no `{part}` in {}", self.stdout);
    }

    #[track_caller]
    fn err(&self, part: &str) {
        assert!(self.stderr.contains(part), "no `{part}` in {}", self.stderr);
    }
}

/// A grid of 4 × 3 samples with a hole. The first row of the file has the greatest y.
const GRID: &str =
    "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n8 9 10 11\n4 5 6 -1\n0 1 2 3\n";

fn folder_with_grid() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    fs::write(folder.path().join("in/dem.asc"), GRID).unwrap();
    folder
}

#[test]
fn a_grid_is_baked_once_inspected_and_verified() {
    let folder = folder_with_grid();
    let line = "build in/dem.asc --height-field --height-offset 0.5 --out o";
    bake(&folder, &format!("{line} --check")).expect(1).out("missing  o/dem.hullfield");
    let first = bake(&folder, &format!("{line} --json")).expect(0).json().remove(0);
    assert_eq!(
        (&first["status"], &first["columns"], &first["rows"], &first["holes"]),
        (&"baked".into(), &4.into(), &3.into(), &2.into())
    );
    let again = bake(&folder, &format!("{line} --json --verify")).expect(0).json().remove(0);
    assert_eq!(again["status"], "fresh");
    bake(&folder, &format!("{line} --check --height-scale 2")).expect(1).out("stale");

    let field = HeightField::open(folder.path().join("o/dem.hullfield")).unwrap();
    // The middle of the lower left cell of the grid is the first vertex.
    assert_eq!(field.vertex(0, 0), Some(DVec3::new(105.0, 205.0, 0.5)));
    assert_eq!(field.vertex(0, 2), Some(DVec3::new(105.0, 225.0, 8.5)));
    assert!(field.is_hole(2, 0) && field.is_hole(2, 1) && !field.is_hole(1, 1));

    let described = bake(&folder, "inspect o/dem.hullfield --json --vertices").expect(0).json().remove(0);
    let facts = &described["height_field"];
    assert_eq!((&facts["holes"], &facts["triangles"], &facts["diagonal"]), (&2.into(), &8.into(), &"rising".into()));
    assert_eq!((&facts["vertices"][0], &facts["edges"]["border"]), (&0.5.into(), &8.into()));
    bake(&folder, "inspect o/dem.hullfield").expect(0).out("  holes              2 of 6 cells");
    let verified = bake(&folder, "verify o/dem.hullfield --json --directions 500").expect(0).json().remove(0);
    assert_eq!((&verified["pass"], &verified["rays"]), (&true.into(), &500.into()));
    bake(&folder, "report o/dem.hullfield --out o/page.html").expect(0);
    assert!(fs::read_to_string(folder.path().join("o/page.html")).unwrap().contains("data:image/png;base64,"));
}

#[test]
fn a_changed_source_a_damaged_file_and_a_wrong_field_are_rejected() {
    let folder = folder_with_grid();
    bake(&folder, "build in/dem.asc --height-field --out o").expect(0);
    let file = folder.path().join("o/dem.hullfield");
    let good = fs::read(&file).unwrap();
    // Another surface that claims the same source.
    let other = GRID.replace("8 9 10 11", "8 9 12 11");
    fs::write(folder.path().join("in/dem.asc"), &other).unwrap();
    bake(&folder, "verify o/dem.hullfield").expect(1).err("stale: ");
    bake(&folder, "build in/dem.asc --height-field --out o").expect(0);
    let mut forged = fs::read(&file).unwrap();
    forged[24..40].copy_from_slice(&good[24..40]);
    let header = hullmap::Header::read_kind(&forged, hullmap_format::header::FileKind::HeightField).unwrap();
    let checksum = header.checksum_of(&forged[64..]);
    forged[56..64].copy_from_slice(&checksum.to_le_bytes());
    fs::write(&file, &forged).unwrap();
    fs::write(folder.path().join("in/dem.asc"), GRID).unwrap();
    bake(&folder, "verify o/dem.hullfield").expect(1).err("differs from what");
    let mut damaged = good;
    damaged[200] ^= 1;
    fs::write(&file, &damaged).unwrap();
    bake(&folder, "verify o/dem.hullfield").expect(1).err("the file is damaged");
    bake(&folder, "inspect o/dem.hullfield").expect(1).err("the file is damaged");
    bake(&folder, "inspect o/none.hullfield").expect(2).err("cannot read");
    fs::remove_file(folder.path().join("in/dem.asc")).unwrap();
    fs::write(&file, &forged).unwrap();
    bake(&folder, "verify o/dem.hullfield").expect(0).err("no source found at the recorded path");
    bake(&folder, "verify o/dem.hullfield --require-source").expect(1).err("name the source with --source");
}

#[test]
fn exports_bake_to_the_same_surface() {
    let folder = folder_with_grid();
    bake(&folder, "build in/dem.asc --height-field --out o --diagonal falling").expect(0);
    bake(&folder, "export o/dem.hullfield --out o/dem.f32").expect(0);
    let again =
        "build o/dem.f32 --height-field --rows 3 --columns 4 --spacing 10 --origin 105,205 --diagonal falling --out p";
    bake(&folder, again).expect(0);
    let [a, b] = ["o", "p"].map(|out| HeightField::open(folder.path().join(out).join("dem.hullfield")).unwrap());
    assert_eq!((a.layout(), a.hole_count(), a.bounds()), (b.layout(), b.hole_count(), b.bounds()));
    for triangle in 0..a.triangle_count() {
        assert_eq!(a.triangle(triangle), b.triangle(triangle));
    }
    bake(&folder, "export o/dem.hullfield --out o/dem.obj").expect(0);
    bake(&folder, "export o/dem.hullfield --out o/dem.obj").expect(2);
    let text = fs::read_to_string(folder.path().join("o/dem.obj")).unwrap();
    let count = |key: &str| text.lines().filter(|line| line.starts_with(key)).count();
    assert_eq!((count("v "), count("f ")), (12, 8));
    assert!(text.starts_with("v 105 205 0\n") && text.contains("\nf 1 2 5\n"));
}

/// The sample that is a hole, and the value as tools write it. Other values are a warning.
#[test]
fn holes_are_found_as_they_are_stored_or_a_warning_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (sample, hole, warns) in [
        (-9999.9, "-9999.9", false),
        (f32::MAX, "3.4028235e38", false),
        (-3.4e38, "-3.4e38", false),
        (f32::MIN, "-3.402823e+38", false),
        (0.1, "0.1", false),
        (1e30, "1e30", false),
        (-9999.9, "-9999", true),
        (0.25, "0", true),
    ] {
        let samples = (0..20).map(|at| if at == 6 { sample } else { 10.0 + at as f32 });
        let bytes: Vec<u8> = samples.flat_map(f32::to_le_bytes).collect();
        fs::write(folder.path().join("a.f32"), bytes).unwrap();
        let line = format!("build a.f32 --height-field --rows 4 --columns 5 --spacing 1 --hole={hole} --out o --json");
        for status in ["baked", "fresh"] {
            let found = bake(&folder, &line).expect(0);
            let row = found.json().remove(0);
            assert_eq!((&row["status"], &row["holes"]), (&status.into(), &if warns { 0 } else { 4 }.into()), "{hole}");
            let text = "no sample is";
            assert_eq!(found.stderr.contains(text), warns, "{hole}: {}", found.stderr);
            assert_eq!(row["warnings"].to_string().contains(text), warns, "{hole}: {row}");
        }
        bake(&folder, "verify o/a.hullfield --require-source --directions 50").expect(0);
    }
    // In an image, and beside the no-data value of a grid.
    let folder = folder_with_grid();
    bake(&folder, "build in/dem.asc --height-field --hole 77 --out o")
        .expect(0)
        .err("in/dem.asc: no sample is 77, so --hole");
    bake(&folder, "build in/dem.asc --height-field --hole 77 --quiet --out o").expect(0);
}

#[test]
fn errors_name_file_cause_and_remedy() {
    let folder = folder_with_grid();
    fs::write(folder.path().join("in/raw.f32"), [0_u8; 24]).unwrap();
    fs::write(folder.path().join("in/dem.f32"), [0_u8; 24]).unwrap();
    for (line, code, expected) in [
        ("in/raw.f32 --height-field", 1, "in/raw.f32: expected a greyscale PNG, an ESRI ASCII grid"),
        ("in/raw.f32 --height-field --rows 2 --columns 3", 2, "name it with --spacing"),
        ("in/raw.f32 --height-field --rows 2 --columns 4 --spacing 1", 1, "take 32; check --rows and --columns"),
        ("in/raw.f32 --height-field --rows 2 --columns 3 --spacing 1 --origin 1e300,0", 1, "choose another spacing"),
        ("in/dem.asc --height-field --hole-image gone.png", 2, "gone.png: cannot read"),
        ("in/dem.asc --height-field --hole-image dem.asc", 1, "export the image as PNG"),
        ("in/dem.asc --height-field --hole-image ../x.png", 2, "without a folder"),
        ("in/dem.asc --spacing 1", 2, "--height-field"),
        ("in/dem.asc --height-field --spacing 0", 2, "expected lengths above 0"),
        ("in/dem.asc --height-field --decompose", 2, "options of packs have no effect on height fields"),
        ("in/dem.asc in/dem.f32 --height-field", 2, "would both become o/dem.hullfield"),
        ("in --height-field", 2, "in: is a folder"),
        ("in/none.asc --height-field", 2, "in/none.asc: cannot read"),
    ] {
        bake(&folder, &format!("build {line} --out o")).expect(code).err(expected);
    }
    bake(&folder, "build in/dem.asc --height-field --out o").expect(0);
    bake(&folder, "inspect o/dem.hullfield in/dem.asc").expect(2).err("in a run of their own");
    bake(&folder, "export o/dem.hullfield --out o/dem.stl").expect(2).err("becomes .obj or .f32");
}
