//! Verification of the mass that a pack records for a mesh, and of the share of its solid that is
//! in no part: both are computed again from the source.

use glam::{DMat3, DVec3};
use hullmap::Hull;
use hullmap_bake::fit::VoidsShare;
use hullmap_bake::mass::Mass;
use hullmap_geometry::PointSet;

use hullmap_geometry::number::rounded;

/// Difference that rounding may explain, relative to the volume and to the mesh's diagonal.
const ROUNDING: f64 = 1e-9;

/// Why the recorded mass of an object is not the mass of its mesh; `None` if it is, or if none is
/// recorded. `first` is the object's first hull, `computed` the mass of the mesh's solid.
pub fn problem(first: &Hull, mesh: &PointSet, computed: Option<&Mass>) -> Option<String> {
    let recorded = first.mesh_mass_properties(1.0)?;
    let name = &mesh.name;
    let Some(computed) = computed else {
        return Some(format!("it records the mass of {name}, which bounds no solid that can be measured"));
    };
    let size = mesh.diagonal();
    let (found, claimed) = (computed.volume, recorded.mass);
    let room = ROUNDING * found;
    // Written so that NaN is a problem, here and below.
    if !((found - claimed).abs() <= room) {
        let (found, claimed) = (rounded(found), rounded(claimed));
        return Some(format!("the volume of {name} is {found}, but the pack records {claimed}"));
    }
    let found = DVec3::from_array(computed.centroid);
    if !(found.distance(recorded.center_of_mass) <= ROUNDING * size) {
        let [found, claimed] = [found, recorded.center_of_mass].map(|p| p.to_array().map(rounded).join(" "));
        return Some(format!("the centre of mass of {name} is at {found}, but the pack records {claimed}"));
    }
    let difference = inertia(computed) - recorded.inertia;
    if !difference.to_cols_array().iter().all(|entry| entry.abs() <= room * size * size) {
        return Some(format!("the recorded inertia is not the inertia of {name}"));
    }
    None
}

/// Difference from the recorded share that rounding may explain. Numbers of records are f32.
const SHARE_ROUNDING: f64 = 1e-6;

/// Why the recorded voids of an object are not the voids of its parts; `None` if they are, or if
/// none are recorded. `first` is the object's first hull; `computed` are the voids of the parts.
pub fn voids_problem(first: &Hull, name: &str, computed: Option<VoidsShare>) -> Option<String> {
    let recorded = first.voids()?;
    let Some(computed) = computed else {
        return Some(format!("it records voids of {name}, which has no volume, or no parts that can be compared"));
    };
    // The estimate of a bake that had too little time is coarser, and its error is larger.
    let may_be_equal = (computed.share - recorded.share).abs() <= computed.error + recorded.error + SHARE_ROUNDING;
    if may_be_equal && recorded.error >= computed.error - SHARE_ROUNDING {
        return None;
    }
    let [found, found_error, claimed, claimed_error] =
        [computed.share, computed.error, recorded.share, recorded.error].map(rounded);
    Some(format!(
        "the share of {name} in no part is {found} ± {found_error}, but the pack records {claimed} ± {claimed_error}"
    ))
}

/// Inertia tensor about the centre of mass, at density 1.
fn inertia(mass: &Mass) -> DMat3 {
    let [xx, yy, zz, yz, zx, xy] = mass.second_moments;
    let moments = DMat3::from_cols(DVec3::new(xx, xy, zx), DVec3::new(xy, yy, yz), DVec3::new(zx, yz, zz));
    (DMat3::from_diagonal(DVec3::splat(xx + yy + zz)) - moments) * mass.volume
}
