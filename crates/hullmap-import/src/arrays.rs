//! Import of meshes that are in memory instead of in a file: arrays of positions and of faces.

use hullmap_geometry::MAX_POINTS;

use crate::fault::{Fault, ImportError, counted};
use crate::import::{Imported, imported};
use crate::limits::Limits;
use crate::mesh::{Polygons, Positions, SourceMesh};
use crate::options::ImportOptions;

/// A mesh in memory.
#[derive(Clone, Debug, Default)]
pub struct MeshArrays {
    /// Name of its hull. If it is empty, the name of the whole import is used.
    pub name: String,
    /// Positions of the vertices.
    pub positions: Vec<[f64; 3]>,
    /// Faces, as indices into `positions`. If there are none, the mesh is a point cloud.
    pub faces: Polygons,
}

/// Imports meshes from memory, as [`import`](crate::import) does from a file with one object for
/// each mesh.
///
/// `name` stands for the file in messages, and is the name of meshes without one. With
/// [`Split::Object`](crate::Split::Object), each mesh becomes a point set of its own. Positions are
/// rounded to `f32` once, after they have been rotated, scaled and recentred.
///
/// # Errors
/// A position is not finite, a face references no vertex, or there are no or too many points.
///
/// # Complexity
/// O(vertices + corners), plus a sort of the points.
pub fn import_arrays(
    name: &str,
    meshes: Vec<MeshArrays>,
    options: &ImportOptions,
    limits: &Limits,
) -> Result<Imported, ImportError> {
    let mesh = join(meshes, limits).map_err(|fault| ImportError { file: name.to_owned(), line: None, fault })?;
    imported(name, name, mesh, options, limits)
}

fn join(meshes: Vec<MeshArrays>, limits: &Limits) -> Result<SourceMesh, Fault> {
    let mut joined = SourceMesh::new(Positions::Double(Vec::new()), Polygons::default());
    joined.objects.clear();
    for mesh in meshes {
        check(&mesh)?;
        joined.begin_object(mesh.name, limits.objects);
        let Positions::Double(positions) = &mut joined.positions else { continue };
        let first = positions.len();
        if first + mesh.positions.len() > MAX_POINTS {
            return Err(Fault::format(format!(
                "there are more than {MAX_POINTS} vertices; pass fewer meshes, or meshes with fewer vertices"
            )));
        }
        if joined.faces.corners.len() + mesh.faces.corners.len() >= u32::MAX as usize {
            return Err(Fault::TooManyReferences);
        }
        // Below `MAX_POINTS`, as checked above.
        let first = first as u32;
        let end = first + mesh.positions.len() as u32;
        if mesh.faces.corners.is_empty() {
            joined.loose.extend(first..end);
        }
        if first == 0 {
            *positions = mesh.positions;
            joined.faces = mesh.faces;
            continue;
        }
        positions.extend_from_slice(&mesh.positions);
        let corners = joined.faces.corners.len() as u32;
        joined.faces.corners.extend(mesh.faces.corners.iter().map(|corner| first + corner));
        joined.faces.ends.extend(mesh.faces.ends.iter().map(|end| corners + end));
    }
    if joined.positions.len() == 0 {
        return Err(Fault::format("there are no vertices, but a hull requires at least one: check the arrays"));
    }
    Ok(joined)
}

fn check(mesh: &MeshArrays) -> Result<(), Fault> {
    let vertex_count = mesh.positions.len();
    let not_finite = |position: &[f64; 3]| !position.iter().all(|x| x.is_finite());
    if let Some((vertex, [x, y, z])) = mesh.positions.iter().enumerate().find(|(_, position)| not_finite(position)) {
        return Err(Fault::format(format!(
            "vertex {vertex} is ({x}, {y}, {z}), but a hull requires finite points: correct or remove it"
        )));
    }
    let ends = &mesh.faces.ends;
    let ascending = ends.iter().zip(ends.iter().skip(1)).all(|(end, next)| end <= next);
    if !ascending || ends.last().map_or(0, |&end| end as usize) != mesh.faces.corners.len() {
        return Err(Fault::format(
            "the ends of the faces do not ascend to the number of corners: check how the faces were collected",
        ));
    }
    let corners = mesh.faces.corners.iter().enumerate();
    if let Some((at, corner)) = corners.into_iter().find(|(_, corner)| **corner as usize >= vertex_count) {
        let face = ends.partition_point(|&end| end as usize <= at);
        return Err(Fault::format(format!(
            "face {face} references vertex {corner}, but there are {}, counted from 0: check the faces",
            counted(vertex_count, "vertex", "vertices")
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Split;

    fn triangle(name: &str, x: f64) -> MeshArrays {
        let mut faces = Polygons::default();
        faces.push(&[2, 1, 0]);
        let positions = vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
        MeshArrays { name: name.to_owned(), positions, faces }
    }

    fn run(meshes: Vec<MeshArrays>, split: Split) -> Result<Imported, String> {
        let options = ImportOptions { split, ..ImportOptions::DEFAULT };
        import_arrays("m", meshes, &options, &Limits::DEFAULT).map_err(|error| error.to_string())
    }

    #[test]
    fn each_mesh_becomes_an_object() {
        let cloud = MeshArrays { positions: vec![[7.0; 3], [8.0; 3]], ..MeshArrays::default() };
        let meshes = vec![triangle("a", 0.0), cloud, triangle("a", 5.0)];
        let imported = run(meshes.clone(), Split::Object).unwrap();
        let names: Vec<&str> = imported.point_sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names, ["a", "m", "a_2"]);
        assert_eq!(imported.point_sets[1].positions, [[7.0; 3], [8.0; 3]]);
        assert_eq!(imported.faces[2].corners, [2, 1, 0]);
        assert_eq!(imported.point_sets[2].source_vertices, [5, 6, 7]);
        assert_eq!(run(meshes, Split::None).unwrap().point_sets.len(), 1);
    }

    #[test]
    fn faulty_arrays_are_rejected() {
        let error = |mesh: MeshArrays| run(vec![mesh], Split::None).unwrap_err();
        assert!(error(MeshArrays::default()).starts_with("m: there are no vertices"));
        let mut mesh = triangle("a", 0.0);
        mesh.positions[1][2] = f64::NAN;
        assert!(error(mesh).starts_with("m: vertex 1 is (1, 0, NaN)"));
        let mut mesh = triangle("a", 0.0);
        mesh.faces.corners[1] = 3;
        assert_eq!(
            error(mesh),
            "m: face 0 references vertex 3, but there are 3 vertices, counted from 0: check the faces"
        );
        for ends in [vec![], vec![2], vec![4], vec![2, 1, 3]] {
            let mut mesh = triangle("a", 0.0);
            mesh.faces.ends = ends;
            assert!(error(mesh).contains("the ends of the faces"));
        }
        let mut mesh = triangle("a", 0.0);
        mesh.positions[0][0] = 1e300;
        assert!(error(mesh).contains("too large for 32-bit floats"));
    }
}
