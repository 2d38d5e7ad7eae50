use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use hullmap::{Hull, MassProperties, Pack};
use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_owned_pack};
use hullmap_import::UpAxis;
use hullmap_robot::Submesh;

use super::choice::HullsOf;
use super::meshes::Meshes;
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::mesh_file::{body::Body, obj, place::OutputFile};
use hullmap_pipeline::open::open_pack;
use hullmap_pipeline::outcome::Failure;
use hullmap_verify::geometry::positions;

pub struct Hulls {
    pub file: PathBuf,
    pub pack: Arc<Pack>,
    pub files: Vec<OutputFile>,
    pub vertices: usize,
    pub is_parts: bool,
    /// Bound on the protrusion of the parts, in units of the mesh.
    pub protrusion: Option<f64>,
    /// Bound on how far the surface lies outside of the parts, in units of the mesh.
    pub uncovered: Option<f64>,
    pub fault: Option<Fault>,
    /// Mass properties of the mesh, at density 1; `None` if it is not watertight.
    pub mass: Option<MassProperties>,
}

pub struct Fault {
    pub reason: String,
    pub remedy: &'static str,
}

pub fn read_hulls(jobs: &[Job], own: &HullsOf, meshes: &mut Meshes) -> Result<Hulls, Failure> {
    let job = &jobs[own.job];
    let whole = open_pack(&job.output)?;
    let names: Vec<String> = whole.hulls().map(|hull| object(&hull)).collect();
    let is_meant = |hull: &Hull| own.mesh.submesh.as_ref().is_none_or(|submesh| object(hull) == submesh.name);
    let meant: Vec<Hull> = whole.hulls().filter(is_meant).collect();
    let worst = |bounds: Vec<Option<f64>>| {
        bounds.into_iter().collect::<Option<Vec<f64>>>().map(|all| all.into_iter().fold(0.0, f64::max))
    };
    let protrusion = worst(meant.iter().map(Hull::protrusion).collect());
    let uncovered = worst(meant.iter().map(Hull::uncovered).collect());
    let is_parts = meant.iter().any(|hull| hull.part_count() > 1);
    let mut mass = meant.first().and_then(|hull| hull.mesh_mass_properties(1.0));
    let mut fault = meant.iter().any(|hull| hull.rank() < 3).then(|| Fault {
        reason: "its hull is flat, and programs reject flat meshes".to_owned(),
        remedy: "give the mesh a thickness, or use a box",
    });
    if let Some(submesh) = own.mesh.submesh.as_ref().filter(|_| meant.is_empty()) {
        fault = Some(no_submesh(submesh, &names));
    }
    let pack = match own.mesh.submesh.as_ref().filter(|_| fault.is_none()) {
        None => {
            drop(meant);
            Arc::new(whole)
        }
        Some(submesh) => {
            let centre = meshes.get(&own.mesh).filter(|_| submesh.is_centered).map_or(DVec3::ZERO, |mesh| mesh.moved);
            if let Some(mass) = &mut mass {
                mass.center_of_mass -= centre;
            }
            let moved = moved(&meant, centre).map_err(|error| Failure::rejected(format!("{}: {error}", own.stem)))?;
            Arc::new(moved)
        }
    };
    let (mut files, mut vertices) = (Vec::new(), 0);
    for (index, hull) in pack.hulls().enumerate() {
        let end = if is_parts { format!("part_{index:02}") } else { "hull".to_owned() };
        let name = format!("{}_{end}", own.stem);
        vertices += hull.vertex_count();
        let path = job.output.with_file_name(format!("{name}.obj"));
        let body = Body { name, ..Body::new(&hull, UpAxis::Keep) };
        files.push(OutputFile { path, bytes: obj::write(&[body], false) });
    }
    Ok(Hulls { file: job.output.clone(), pack, files, vertices, is_parts, protrusion, uncovered, fault, mass })
}

fn object(hull: &Hull) -> String {
    let name = hull.name();
    let whole = if hull.part_count() > 1 { name.rsplit_once("_part_").map(|(name, _)| name) } else { None };
    whole.unwrap_or(name).to_owned()
}

fn no_submesh(submesh: &Submesh, names: &[String]) -> Fault {
    let mut names = names.to_vec();
    names.dedup();
    let (count, shown) = (names.len(), names.iter().take(8).cloned().collect::<Vec<_>>().join(", "));
    let more = if count > 8 { ", …" } else { "" };
    Fault {
        reason: format!("the file has no submesh `{}` (it has {shown}{more})", submesh.name),
        remedy: "correct the name",
    }
}

/// A pack of hulls, moved so that `centre` becomes the origin. It has no index, because the hulls
/// are few and rarely queried.
fn moved(hulls: &[Hull], centre: DVec3) -> Result<Pack, String> {
    let bake = |hull: &Hull| {
        let place = |position: [f32; 3]| (DVec3::from_array(position.map(f64::from)) - centre).as_vec3().to_array();
        let positions: Vec<[f32; 3]> = positions(hull).into_iter().map(place).collect();
        let points = PointSet { name: hull.name().to_owned(), ..PointSet::of_positions(positions) };
        bake_hull(&points, IndexKind::None).map_err(|error| error.to_string())
    };
    let baked: Vec<_> = hulls.iter().map(bake).collect::<Result<_, _>>()?;
    let bytes = write_owned_pack(baked, &SourceRecord::default()).map_err(|error| error.to_string())?;
    Pack::from_bytes(&bytes).map_err(|error| error.to_string())
}
