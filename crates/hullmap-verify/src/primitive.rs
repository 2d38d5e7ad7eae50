//! Verification of the primitive that may replace a part.

use hullmap::{Hull, Replacement};
use hullmap_bake::primitive::{Primitive, around::surface_points, contained};
use hullmap_geometry::PointSet;

use crate::fit::{Judge, Witness};
use crate::geometry::rebuilt;
use hullmap_geometry::number::rounded;

/// Distance by which rounding may move a point of the surface, relative to the diagonal.
const ROUNDING: f64 = 1e-9;

/// Why the primitive of a part cannot replace it; `None` if it can, or there is none. It must
/// contain what the part contains of the surface, and protrude by no more than it states.
pub fn problem(hull: &Hull, mesh: &PointSet, judge: &Judge) -> Option<String> {
    let Replacement { kind, center, rotation, sizes, protrusion } = hull.primitive()?;
    let primitive = Primitive { kind, center, rotation, sizes };
    let Some(part) = rebuilt(hull) else {
        return Some(format!("its {kind} stands for a part that cannot be built again"));
    };
    let size = mesh.diagonal();
    let uncovered = hull.uncovered().unwrap_or(0.0);
    let outside = contained(mesh, &part, uncovered, size).into_iter().find(|p| !primitive.holds(*p, ROUNDING * size));
    if let Some(p) = outside {
        let name = &mesh.name;
        return Some(format!(
            "{p} on the surface of {name} is in this part, but not in the {kind} that may replace it"
        ));
    }
    let Witness { distance, at } = judge.farther(&surface_points(&primitive), protrusion)?;
    let (found, claimed) = (rounded(distance), rounded(protrusion));
    Some(format!("{at} of its {kind} is {found} outside the solid, but the pack records at most {claimed}"))
}
