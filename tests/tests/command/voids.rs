//! `--fill`: parts that leave no voids, from the command to the pack.

use std::fs;

use hullmap::Pack;
use hullmap_outside::command::bake_line as bake;
use shapes::{cubes, obj::text};

#[test]
fn filled_parts_are_recorded_and_verified() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = cubes::grooved([9, 9, 7], [4, 4, 3]);
    fs::write(folder.path().join("g.obj"), text(&mesh)).unwrap();
    let built = |out: &str, options: &str| {
        let line = format!("build g.obj --out {out} --decompose --max-error 1.5% {options} --json");
        let row = bake(&folder, &line).expect(0).json()[0].clone();
        (row["objects"][0].clone(), row["notes"].to_string())
    };
    let (usual, _) = built("usual", "");
    let (voids, error) = (usual["voids"].as_f64().unwrap(), usual["voids_error"].as_f64().unwrap());
    assert!(voids > 0.02 && error < 0.01 && usual["filled"].is_null(), "{usual}");
    let (filled, notes) = built("filled", "--fill");
    assert!(filled["filled"] == true && filled["voids"].as_f64().unwrap() <= error, "{filled}");
    assert!(notes.contains("the parts leave no voids: every point of the solid is in a part, proven"), "{notes}");
    let protrusion = filled["protrusion"].as_f64().unwrap();
    let diagonal = 211.0_f64.sqrt();
    assert!(protrusion <= 0.015015 * diagonal && filled["uncovered"].as_f64().unwrap() < 1e-6 * diagonal, "{filled}");
    let pack = Pack::open(folder.path().join("filled/g.hullmap")).unwrap();
    assert!(pack.options().ends_with(", fill true"), "{}", pack.options());
    assert!(pack.hulls().all(|hull| hull.voids().is_some_and(|voids| voids.share <= error)));
    let verified = bake(&folder, "verify filled --source g.obj --json --directions 100").expect(0).json();
    assert!(verified.iter().all(|row| row["parts"]["filled"] == true), "{verified:?}");
    let page = bake(&folder, "report filled/g.hullmap --out page.html").expect(0);
    let text = fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(text.contains("<dd>none, proven</dd>"), "{page:?}");
    // One part too few.
    let most = usual["parts"].as_u64().unwrap();
    let line = format!("build g.obj --out few --decompose --max-error 1.5% --max-parts {most} --fill --json");
    let few = bake(&folder, &line).expect(0).json()[0].clone();
    assert!(few["objects"][0]["parts"].as_u64().unwrap() <= most, "{few}");
    let is_filled = few["objects"][0]["filled"].as_bool().unwrap();
    assert!(is_filled || few["warnings"].to_string().contains("the parts leave voids"), "{few}");
}

#[test]
fn what_is_not_closed_is_not_filled() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = cubes::grooved([5, 5, 5], [2, 2, 2]);
    mesh.faces.pop();
    fs::write(folder.path().join("g.obj"), text(&mesh)).unwrap();
    let row =
        bake(&folder, "build g.obj --out baked --decompose --max-error 4% --fill --json").expect(0).json()[0].clone();
    assert!(row["objects"][0]["filled"].is_null(), "{row}");
    assert!(row["warnings"].to_string().contains("nothing was filled, because the mesh is not closed"), "{row}");
}
