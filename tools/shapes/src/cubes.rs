//! Solids of unit cubes: blocks with grooves, hollows and teeth, as closed meshes.

use std::collections::BTreeMap;

use crate::mesh::Mesh;

/// The surface of unit cubes at these places: a quad for each side that no other cube has. No two
/// cubes may share an edge or a corner alone.
pub fn surface(cubes: &[[i32; 3]]) -> Mesh {
    let mut vertices: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let mut mesh = Mesh::default();
    for cube in cubes {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut beside = *cube;
            beside[axis] += 2 * side - 1;
            if cubes.contains(&beside) {
                continue;
            }
            let corner = |[u, v]: [i32; 2]| {
                let mut at = *cube;
                at[axis] += side;
                at[(axis + 1) % 3] += u;
                at[(axis + 2) % 3] += v;
                at
            };
            let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|uv| {
                let at = corner(uv);
                *vertices.entry(at).or_insert_with(|| mesh.push_vertex(at.map(f64::from)))
            });
            if side == 0 {
                quad.reverse();
            }
            mesh.faces.push(quad.to_vec());
        }
    }
    mesh
}

/// The places of a block of this size, from the origin.
pub fn block([length, width, height]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..length).flat_map(move |x| (0..width).flat_map(move |y| (0..height).map(move |z| [x, y, z])))
}

/// A block with a groove around it in each of three directions. Its inside is far from the surface.
pub fn grooved(size: [i32; 3], grooves: [i32; 3]) -> Mesh {
    let is_groove = |cube: &[i32; 3], axis: usize| cube[axis] == grooves[axis];
    let is_kept = |cube: &[i32; 3]| {
        (0..3).all(|axis| {
            let is_outer = cube[axis] == 0 || cube[axis] == size[axis] - 1;
            !(is_outer && (is_groove(cube, (axis + 1) % 3) || is_groove(cube, (axis + 2) % 3)))
        })
    };
    surface(&block(size).filter(is_kept).collect::<Vec<_>>())
}

/// A box with a cavity that opens nowhere.
pub fn hollow(size: [i32; 3]) -> Mesh {
    let is_wall = |cube: &[i32; 3]| (0..3).any(|axis| cube[axis] == 0 || cube[axis] == size[axis] - 1);
    surface(&block(size).filter(is_wall).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_closed_and_have_the_volume_of_their_cubes() {
        for (mesh, volume) in [(grooved([9, 9, 9], [4, 4, 4]), 639.0), (hollow([6, 5, 4]), 96.0)] {
            mesh.check_closed().unwrap();
            assert_eq!(mesh.signed_volume(), volume);
        }
    }
}
