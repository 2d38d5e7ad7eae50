//! Concave solids, on which convex decompositions are compared.
//!
//! All are closed and wound counter-clockwise seen from outside. Some consist of several shells
//! that touch or overlap, as modelled furniture does.

use crate::mesh::Mesh;
use crate::solids::lathe;
use crate::turn::cos_sin;

/// The solids and their names, in a fixed order.
pub fn all() -> Vec<(&'static str, Mesh)> {
    vec![
        ("l", l()),
        ("horseshoe", horseshoe(24)),
        ("chair", chair()),
        ("open_box", open_box()),
        ("pipe", pipe(32)),
        ("mug", mug(32)),
        ("spiral_stair", spiral_stair(18)),
        ("bowl", bowl(32, 12)),
    ]
}

/// Rings of equal length, joined by quads. Closed: the last ring is joined to the first. Otherwise
/// both ends have a cap, and must be convex. Faces are wound outward whichever way the rings run.
fn sweep(rings: &[Vec<[f64; 3]>], is_closed: bool) -> Mesh {
    let mut mesh = Mesh::default();
    for p in rings.iter().flatten() {
        mesh.push_vertex(*p);
    }
    let sides = rings.first().map_or(0, Vec::len) as u32;
    let count = rings.len() as u32;
    let at = |ring: u32, side: u32| ring % count * sides + side % sides;
    for ring in 0..if is_closed { count } else { count - 1 } {
        for side in 0..sides {
            mesh.faces.push(vec![at(ring, side), at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side)]);
        }
    }
    if !is_closed {
        mesh.faces.push((0..sides).rev().map(|side| at(0, side)).collect());
        mesh.faces.push((0..sides).map(|side| at(count - 1, side)).collect());
    }
    if mesh.signed_volume() < 0.0 {
        mesh.faces.iter_mut().for_each(|face| face.reverse());
    }
    mesh
}

fn append(mesh: &mut Mesh, other: Mesh) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(other.vertices);
    mesh.faces.extend(other.faces.into_iter().map(|face| face.into_iter().map(|v| v + first).collect()));
}

fn block(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let ring = |z: f64| vec![[low[0], low[1], z], [high[0], low[1], z], [high[0], high[1], z], [low[0], high[1], z]];
    sweep(&[ring(low[2]), ring(high[2])], false)
}

/// Two arms that meet at a right angle.
pub fn l() -> Mesh {
    // Starts at the concave corner, so that a fan from it triangulates the caps.
    let outline = [[1.0, 1.0], [1.0, 3.0], [0.0, 3.0], [0.0, 0.0], [2.0, 0.0], [2.0, 1.0]];
    let mut mesh = crate::solids::extrusion(&outline, 0.0, 1.0);
    // The bottom is listed in reverse.
    if let Some(bottom) = mesh.faces.first_mut() {
        bottom.rotate_right(1);
    }
    mesh
}

/// A bar of rectangular section, bent to a half circle of `segments` steps between two straight
/// legs.
pub fn horseshoe(segments: usize) -> Mesh {
    let section = |c: f64, s: f64, y: f64| {
        [(0.75, -0.2), (1.0, -0.2), (1.0, 0.2), (0.75, 0.2)].map(|(r, z)| [r * c, r * s + y, z]).to_vec()
    };
    let mut rings = vec![section(1.0, 0.0, -0.8)];
    rings.extend((0..=segments).map(|i| {
        let (c, s) = cos_sin(i, 2 * segments);
        section(c, s, 0.0)
    }));
    rings.push(section(-1.0, 0.0, -0.8));
    sweep(&rings, false)
}

/// A chair of eight blocks that touch.
pub fn chair() -> Mesh {
    let mut mesh = block([0.0, 0.0, 0.45], [0.45, 0.45, 0.5]);
    for (x, y) in [(0.0, 0.0), (0.4, 0.0), (0.0, 0.4), (0.4, 0.4)] {
        append(&mut mesh, block([x, y, 0.0], [x + 0.05, y + 0.05, 0.45]));
    }
    append(&mut mesh, block([0.0, 0.4, 0.5], [0.05, 0.45, 1.0]));
    append(&mut mesh, block([0.4, 0.4, 0.5], [0.45, 0.45, 1.0]));
    append(&mut mesh, block([0.05, 0.41, 0.75], [0.4, 0.44, 0.95]));
    mesh
}

/// A box without a lid.
pub fn open_box() -> Mesh {
    let ring = |r: f64, z: f64| vec![[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]];
    sweep(&[ring(1.0, 0.0), ring(1.0, 1.2), ring(0.9, 1.2), ring(0.9, 0.1)], false)
}

/// A straight pipe of `segments` sides.
pub fn pipe(segments: usize) -> Mesh {
    let ring = |i: usize| {
        let (c, s) = cos_sin(i, segments);
        [(0.35, 0.0), (0.5, 0.0), (0.5, 1.5), (0.35, 1.5)].map(|(r, z)| [r * c, r * s, z]).to_vec()
    };
    sweep(&(0..segments).map(ring).collect::<Vec<_>>(), true)
}

/// A mug of `segments` sides, with a handle that is a shell of its own.
pub fn mug(segments: u32) -> Mesh {
    let mut mesh = lathe(&[[0.0, 0.0], [0.4, 0.0], [0.4, 1.0], [0.35, 1.0], [0.35, 0.06], [0.0, 0.06]], segments);
    let ring = |i: usize| {
        let (c, s) = cos_sin(i, 32);
        let (c, s) = (s, -c);
        (0..12)
            .map(|k| {
                let (u, v) = cos_sin(k, 12);
                let r = 0.28 + 0.05 * u;
                [0.38 + r * c, -0.05 * v, 0.5 + r * s]
            })
            .collect::<Vec<_>>()
    };
    append(&mut mesh, sweep(&(0..=16).map(ring).collect::<Vec<_>>(), false));
    mesh
}

/// Wedges around a column, each higher than the last.
pub fn spiral_stair(steps: usize) -> Mesh {
    let column = |z: f64| {
        (0..24)
            .map(|i| {
                let (c, s) = cos_sin(i, 24);
                [0.12 * c, 0.12 * s, z]
            })
            .collect::<Vec<_>>()
    };
    let mut mesh = sweep(&[column(0.0), column(0.1 * (steps + 2) as f64)], false);
    for step in 0..steps {
        let ring = |z: f64| {
            let [(c, s), (d, t)] = [step, step + 1].map(|i| cos_sin(i, 16));
            vec![[0.1 * c, 0.1 * s, z], [0.8 * c, 0.8 * s, z], [0.8 * d, 0.8 * t, z], [0.1 * d, 0.1 * t, z]]
        };
        let z = 0.1 * step as f64;
        append(&mut mesh, sweep(&[ring(z), ring(z + 0.06)], false));
    }
    mesh
}

/// Half a hollow sphere, of `segments` by twice `rings` quads.
pub fn bowl(segments: u32, rings: usize) -> Mesh {
    let arc = |radius: f64| {
        (0..=rings).map(move |i| {
            let (c, s) = cos_sin(i, 4 * rings);
            [radius * s, -radius * c]
        })
    };
    let inner: Vec<_> = arc(0.9).collect();
    let mut profile: Vec<[f64; 2]> = arc(1.0).collect();
    profile.extend(inner.into_iter().rev());
    if let [first, .., last] = profile.as_mut_slice() {
        (first[0], last[0]) = (0.0, 0.0);
    }
    lathe(&profile, segments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_closed_and_wound_outward() {
        for (name, mesh) in all() {
            assert_eq!(mesh.check_closed(), Ok(()), "{name}");
            assert!(mesh.signed_volume() > 0.0, "{name}: {}", mesh.signed_volume());
        }
    }
}
