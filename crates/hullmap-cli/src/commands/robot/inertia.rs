//! Inertia of a link from its meshes, at uniform density, for the mass that the link states.
//!
//! Second moments C = ∫ x xᵀ about the centroid follow linear maps: a mesh transformed by A has
//! |det A| A C Aᵀ. The inertia tensor is tr(C) E − C.

use glam::{DMat3, DVec3};
use hullmap::MassProperties;
use hullmap_robot::{Frame, MeshUse};

/// A mesh in a link: its mass properties at density 1, in its own frame, and how it is drawn.
#[derive(Clone, Debug)]
pub struct Body {
    /// At density 1.
    pub own: MassProperties,
    pub mesh: MeshUse,
    pub pose: Frame,
}

/// Centre of mass and inertia tensor about it, in the frame and the axes of the link, of bodies
/// whose masses add up to `mass`. `None` if they have no volume.
pub fn inertia(bodies: &[Body], mass: f64) -> Option<(DVec3, DMat3)> {
    let placed: Vec<(f64, DVec3, DMat3)> = bodies.iter().map(placed).collect();
    let volume: f64 = placed.iter().map(|(volume, ..)| volume).sum();
    // NaN takes the failing branch.
    if !(volume > 0.0 && volume.is_finite()) {
        return None;
    }
    let centre = placed.iter().map(|(volume, centre, _)| *centre * *volume).sum::<DVec3>() / volume;
    let moments = placed.iter().fold(DMat3::ZERO, |sum, (volume, own, moments)| {
        let arm = *own - centre;
        sum + *moments + outer(arm) * *volume
    });
    let moments = moments * (mass / volume);
    Some((centre, DMat3::IDENTITY * trace(moments) - moments))
}

/// Volume, centroid, and second moments about it, in the frame of the link.
fn placed(body: &Body) -> (f64, DVec3, DMat3) {
    let scaled = DMat3::from_diagonal(DVec3::from_array(body.mesh.scale));
    let drawn =
        DMat3::from_quat(body.pose.rotation) * scaled * DMat3::from_quat(body.mesh.reference.rotation.inverse());
    let factor = drawn.determinant().abs();
    let moments = DMat3::IDENTITY * (trace(body.own.inertia) / 2.0) - body.own.inertia;
    let centre = body.pose.apply(body.mesh.placed(body.own.center_of_mass));
    (body.own.mass * factor, centre, drawn * moments * drawn.transpose() * factor)
}

fn trace(matrix: DMat3) -> f64 {
    matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

#[cfg(test)]
mod tests {
    use hullmap_robot::Unresolved;

    use super::*;

    fn cube(scale: [f64; 3], pose: [f64; 6]) -> Body {
        let own = MassProperties {
            mass: 1.0,
            center_of_mass: DVec3::splat(0.5),
            inertia: DMat3::IDENTITY / 6.0,
            ..MassProperties::default()
        };
        let (written, file) = (String::new(), Err(Unresolved::Remote));
        let mesh = MeshUse { written, file, scale, reference: Frame::IDENTITY, submesh: None };
        Body { own, mesh, pose: Frame::of_xyz_rpy(pose) }
    }

    fn of_box(mass: f64, [x, y, z]: [f64; 3]) -> DMat3 {
        DMat3::from_diagonal(DVec3::new(y * y + z * z, x * x + z * z, x * x + y * y) * (mass / 12.0))
    }

    fn assert_near(found: (DVec3, DMat3), centre: [f64; 3], inertia: DMat3) {
        assert!(found.0.abs_diff_eq(DVec3::from_array(centre), 1e-12), "{found:?}");
        assert!(found.1.abs_diff_eq(inertia, 1e-12), "{found:?}, {inertia:?}");
    }

    #[test]
    fn boxes_have_the_inertia_of_the_textbook() {
        let turn = std::f64::consts::FRAC_PI_2;
        let drawn = cube([2.0, 3.0, 4.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_near(inertia(&[drawn], 5.0).unwrap(), [2.0, 1.5, 2.0], of_box(5.0, [2.0, 3.0, 4.0]));
        // Turned before it is scaled: its second axis is the third of the file.
        let mut sheared = cube([2.0, 3.0, 4.0], [0.0; 6]);
        sheared.mesh.reference = Frame::of_xyz_rpy([0.0, 0.0, 0.0, turn, 0.0, 0.0]);
        assert_near(inertia(&[sheared], 5.0).unwrap(), [1.0, 1.5, -2.0], of_box(5.0, [2.0, 3.0, 4.0]));
        let mirrored = cube([2.0, -3.0, 4.0], [0.0; 6]);
        assert_near(inertia(&[mirrored], 5.0).unwrap(), [1.0, -1.5, 2.0], of_box(5.0, [2.0, 3.0, 4.0]));
        // Roll first, then yaw: the axes are permuted.
        let turned = cube([2.0, 3.0, 4.0], [0.0, 0.0, 0.0, turn, 0.0, turn]);
        assert_near(inertia(&[turned], 1.0).unwrap(), [2.0, 1.0, 1.5], of_box(1.0, [4.0, 2.0, 3.0]));
    }

    #[test]
    fn halves_have_the_inertia_of_the_whole() {
        let halves = [cube([1.0, 3.0, 4.0], [0.0; 6]), cube([-1.0, 3.0, 4.0], [2.0, 0.0, 0.0, 0.0, 0.0, 0.0])];
        assert_near(inertia(&halves, 7.0).unwrap(), [1.0, 1.5, 2.0], of_box(7.0, [2.0, 3.0, 4.0]));
        assert!(inertia(&[], 1.0).is_none());
    }
}
