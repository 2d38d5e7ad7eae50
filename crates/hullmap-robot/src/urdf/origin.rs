//! The `origin` of an element of URDF: `xyz` in metres, `rpy` in radians.

use roxmltree::Node;

use crate::description::triple;
use crate::element::child;
use crate::frame::Frame;

/// The pose that the `origin` of an element states; `None` if it is invalid.
pub fn pose(node: Node) -> Option<Frame> {
    let origin = child(node, "origin");
    let stated = |name: &str| match origin.and_then(|origin| origin.attribute(name)) {
        Some(text) => triple(text),
        None => Some([0.0; 3]),
    };
    let ([x, y, z], [roll, pitch, yaw]) = (stated("xyz")?, stated("rpy")?);
    Some(Frame::of_xyz_rpy([x, y, z, roll, pitch, yaw]))
}
