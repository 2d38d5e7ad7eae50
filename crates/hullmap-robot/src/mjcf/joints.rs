//! Joints of MJCF.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-joint>

use std::collections::HashMap;

use glam::DVec3;

use super::pose::Angles;
use super::tree::Tree;
use crate::chain::{Chain, Coupling, Joint, Motion};
use crate::description::{number, numbers, triple};
use crate::frame::Frame;

/// A joint of body `link`, in its element `frame`. `get` returns an attribute, also of its class.
pub fn joint<'t>(
    link: usize,
    name: &str,
    frame: Frame,
    angles: Angles,
    auto_limits: bool,
    get: impl Fn(&str) -> Option<&'t str>,
) -> Joint {
    let motion = match get("type").unwrap_or("hinge") {
        "slide" => Motion::Slide,
        "ball" => Motion::Ball,
        "free" => Motion::Free,
        _ => Motion::Hinge,
    };
    let angle = |value: f64| if motion == Motion::Slide { value } else { angles.radians(value) };
    let vector = |name: &str, default: DVec3| get(name).and_then(triple).map_or(default, DVec3::from_array);
    let range = get("range").and_then(numbers).and_then(|range| <[f64; 2]>::try_from(range).ok());
    let is_limited = match get("limited") {
        Some("true") => true,
        Some("false") => false,
        _ => auto_limits,
    };
    let limits = range.filter(|[low, high]| is_limited && low < high).map(|range| range.map(angle));
    let reference = get("ref").and_then(number);
    let reference = reference.filter(|_| matches!(motion, Motion::Hinge | Motion::Slide)).map_or(0.0, angle);
    let axis = frame.rotation * vector("axis", DVec3::Z);
    Joint {
        name: name.to_owned(),
        link,
        motion,
        axis: axis.try_normalize().unwrap_or(DVec3::Z),
        anchor: frame.apply(vector("pos", DVec3::ZERO)),
        limits,
        reference,
        neutral: reference,
        coupling: None,
    }
}

/// Inactive couplings, and couplings of joints with several axes, are left out.
pub fn couple(tree: &Tree, chain: &mut Chain) {
    let scalars = chain.joints.iter().enumerate().filter(|(_, joint)| !joint.name.is_empty());
    let scalars = scalars.filter(|(_, joint)| matches!(joint.motion, Motion::Hinge | Motion::Slide));
    let named: HashMap<String, usize> = scalars.map(|(index, joint)| (joint.name.clone(), index)).collect();
    for element in tree.section("equality").into_iter().filter(|element| element.name() == "joint") {
        if element.node.attribute("active") == Some("false") {
            continue;
        }
        let joint = |name: &str| element.node.attribute(name).map(|name| named.get(name).copied());
        let (Some(Some(follower)), leader) = (joint("joint1"), joint("joint2")) else { continue };
        if leader == Some(None) {
            continue;
        }
        let mut coefficients = [0.0, 1.0, 0.0, 0.0, 0.0];
        let stated = element.node.attribute("polycoef").and_then(numbers).unwrap_or_default();
        coefficients.iter_mut().zip(stated).for_each(|(own, stated)| *own = stated);
        chain.joints[follower].coupling = Some(Coupling { leader: leader.flatten(), coefficients });
    }
}
