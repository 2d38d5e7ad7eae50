//! Joints of URDF.
//!
//! # Reference
//! <https://wiki.ros.org/urdf/XML/joint>

use std::collections::HashMap;

use glam::DVec3;
use roxmltree::Node;

use super::origin::pose;
use crate::chain::{Chain, Coupling, Joint, Motion, neutral};
use crate::description::{self, Link, triple};
use crate::document::Document;
use crate::element::{child, children};
use crate::frame::Frame;

/// The chain of a robot, with a note for each joint that cannot be read.
pub fn chain(robot: Node, links: &[Link], document: &Document) -> Chain {
    let index: HashMap<&str, usize> = links.iter().enumerate().map(|(at, link)| (link.name.as_str(), at)).collect();
    let mut chain = Chain::new(links.len());
    let mut mimics = Vec::new();
    for node in children(robot, "joint") {
        let name = node.attribute("name").unwrap_or_default();
        let line = document.line(node.range().start);
        let mut warn =
            |message: &str| chain.warnings.push(format!("line {line}: joint `{name}`: {message}; correct it"));
        let end = |kind| child(node, kind).and_then(|end| end.attribute("link")).and_then(|link| index.get(link));
        let (Some(&parent), Some(&link)) = (end("parent"), end("child")) else {
            warn("its parent or child is not a link, so it moves nothing here");
            continue;
        };
        let rest = pose(node).unwrap_or_else(|| {
            warn("its origin is not three numbers each, so it is taken as 0");
            Frame::IDENTITY
        });
        let kind = node.attribute("type").unwrap_or_default();
        if matches!(kind, "floating" | "planar") {
            chain.notes.push(format!("line {line}: joint `{name}`: it is not moved here, since it has no single axis"));
        }
        if let Err(reason) = chain.attach(link, parent, rest) {
            chain.warnings.push(format!("line {line}: joint `{name}`: {reason}, and moves nothing here; correct it"));
            continue;
        }
        let Some(joint) = joint(node, name, kind, link) else { continue };
        if let Some(mimic) = child(node, "mimic") {
            mimics.push((chain.joints.len(), mimic));
        }
        chain.joints.push(joint);
    }
    let names: HashMap<String, usize> =
        chain.joints.iter().enumerate().map(|(at, joint)| (joint.name.clone(), at)).collect();
    for (follower, mimic) in mimics {
        let number = |name: &str, default: f64| mimic.attribute(name).and_then(description::number).unwrap_or(default);
        match mimic.attribute("joint").and_then(|leader| names.get(leader)) {
            Some(&leader) => {
                let coefficients = [number("offset", 0.0), number("multiplier", 1.0), 0.0, 0.0, 0.0];
                chain.joints[follower].coupling = Some(Coupling { leader: Some(leader), coefficients });
            }
            None => {
                let line = document.line(mimic.range().start);
                chain
                    .warnings
                    .push(format!("line {line}: this mimic names no joint that moves, so it is left out; correct it"));
            }
        }
    }
    chain
}

fn joint(node: Node, name: &str, kind: &str, link: usize) -> Option<Joint> {
    let motion = match kind {
        "revolute" | "continuous" => Motion::Hinge,
        "prismatic" => Motion::Slide,
        "floating" | "planar" => return Some(Joint::unmoved(name, link)),
        _ => return None,
    };
    let axis = child(node, "axis").and_then(|axis| triple(axis.attribute("xyz")?)).map_or(DVec3::X, DVec3::from_array);
    let limits = child(node, "limit").filter(|_| kind != "continuous").map(|limit| {
        ["lower", "upper"].map(|name| limit.attribute(name).and_then(|text| text.trim().parse().ok()).unwrap_or(0.0))
    });
    let limits = limits.filter(|[low, high]: &[f64; 2]| low <= high && low.is_finite() && high.is_finite());
    Some(Joint {
        name: name.to_owned(),
        link,
        motion,
        axis: axis.try_normalize().unwrap_or(DVec3::X),
        anchor: DVec3::ZERO,
        limits,
        reference: 0.0,
        neutral: neutral(limits),
        coupling: None,
    })
}
