//! Joints of SDF.
//!
//! # Reference
//! <http://sdformat.org/spec?elem=joint>

use std::collections::HashMap;

use glam::DVec3;
use roxmltree::Node;

use super::pose::{Frames, end};
use crate::chain::{Chain, Coupling, Joint, Motion, neutral};
use crate::description::{self, Link, triple};
use crate::document::Document;
use crate::element::{child, children};
use crate::frame::Frame;

/// Limits from here on mean that there are none.
const UNLIMITED: f64 = 1e16;

/// Versions below this one state axes in the frame of the model.
const AXES_IN_JOINT: f64 = 1.5;

/// The chain of all models, with a note for each joint that cannot be read.
pub fn chain<'a>(root: Node<'a, 'a>, links: &[Link], document: &Document) -> Chain {
    let version = root.attribute("version").and_then(|version| version.trim().parse().ok());
    let mut reader = Reader {
        frames: Frames::new(root),
        index: links.iter().enumerate().map(|(index, link)| (link.at, index)).collect(),
        chain: Chain::new(links.len()),
        axes_are_in_model: version.unwrap_or(AXES_IN_JOINT) < AXES_IN_JOINT,
        document,
        named: HashMap::new(),
        mimics: Vec::new(),
    };
    let in_world = reader.place_links(root);
    for model in root.descendants().filter(|node| node.has_tag_name("model")) {
        children(model, "joint").for_each(|joint| reader.add(model, joint, &in_world));
    }
    reader.couple();
    reader.chain
}

struct Reader<'a, 'd> {
    frames: Frames<'a>,
    /// Links by the start of their element.
    index: HashMap<usize, usize>,
    chain: Chain,
    axes_are_in_model: bool,
    document: &'d Document,
    /// Joints of the chain by the start of their element, and the name of their axis.
    named: HashMap<(usize, &'static str), usize>,
    /// Joints that follow others, their model, and the element that states it.
    mimics: Vec<(usize, Node<'a, 'a>, Node<'a, 'a>)>,
}

impl<'a> Reader<'a, '_> {
    fn about(&self, node: Node, message: &str) -> String {
        let line = self.document.line(node.range().start);
        let name = node.attribute("name").unwrap_or_default();
        format!("line {line}: {} `{name}`: {message}", node.tag_name().name())
    }

    fn warn(&mut self, node: Node, message: &str) {
        self.chain.warnings.push(self.about(node, message));
    }

    /// The frame of each link in the file's. It is their rest, too, until a joint attaches them.
    fn place_links(&mut self, root: Node<'a, 'a>) -> Vec<Frame> {
        for link in root.descendants().filter(|node| node.has_tag_name("link")) {
            let Some(&index) = self.index.get(&link.range().start) else { continue };
            match self.frames.in_world(link) {
                Some(frame) => self.chain.links[index].rest = frame,
                None => self.warn(link, "its pose cannot be determined, so it is taken as 0; correct it"),
            }
        }
        self.chain.links.iter().map(|link| link.rest).collect()
    }

    fn add(&mut self, model: Node<'a, 'a>, node: Node<'a, 'a>, in_world: &[Frame]) {
        let link = |kind: &str| {
            let found = self.frames.link(model, end(node, kind)?)?;
            self.index.get(&found.range().start).copied()
        };
        let (parent, Some(link)) = (link("parent"), link("child")) else {
            return self.warn(node, "its child is not a link of this file, so it moves nothing here");
        };
        if let Some(parent) = parent {
            if let Err(reason) = self.chain.attach(link, parent, in_world[parent].inverse() * in_world[link]) {
                return self.warn(node, &format!("{reason}, and moves nothing here"));
            }
        } else if end(node, "parent") != Some("world") {
            return self.warn(node, "its parent is not a link of this file, so it moves nothing here");
        }
        let axes: &[(&'static str, Motion)] = match node.attribute("type").unwrap_or_default() {
            "revolute" | "continuous" => &[("axis", Motion::Hinge)],
            "prismatic" => &[("axis", Motion::Slide)],
            "universal" | "revolute2" => &[("axis", Motion::Hinge), ("axis2", Motion::Hinge)],
            "ball" => &[("", Motion::Ball)],
            "fixed" => &[],
            _ => {
                let note = self.about(node, "joints of its type are not moved here");
                self.chain.notes.push(note);
                return self.add_unmoved(node, link);
            }
        };
        let in_model = self.frames.in_world(model).zip(self.frames.in_model(node));
        let Some((model_in_world, joint_in_model)) = in_model else {
            self.warn(node, "its pose cannot be determined, so it is not moved; correct it");
            return self.add_unmoved(node, link);
        };
        let model_in_link = in_world[link].inverse() * model_in_world;
        for (name, motion) in axes {
            self.push([model, node], link, [model_in_link, model_in_link * joint_in_model], (name, *motion));
        }
    }

    fn add_unmoved(&mut self, node: Node, link: usize) {
        self.chain.joints.push(Joint::unmoved(node.attribute("name").unwrap_or_default(), link));
    }

    /// Frames: of the model, and of the joint in the link.
    fn push(
        &mut self,
        [model, node]: [Node<'a, 'a>; 2],
        link: usize,
        [model_in_link, joint_in_link]: [Frame; 2],
        (axis_name, motion): (&'static str, Motion),
    ) {
        let axis = child(node, axis_name);
        let xyz = axis.and_then(|axis| child(axis, "xyz"));
        let stated = xyz.and_then(|xyz| triple(xyz.text()?)).map_or(DVec3::Z, DVec3::from_array);
        let is_in_model = self.axes_are_in_model
            || axis.and_then(|axis| child(axis, "use_parent_model_frame")?.text()).is_some_and(is_true);
        let expressed_in = xyz.and_then(|xyz| xyz.attribute("expressed_in")).filter(|frame| !frame.is_empty());
        let rotation = match expressed_in {
            Some("__model__") => model_in_link.rotation,
            Some(name) => match self.frames.named_in_model(model, name) {
                Some(frame) => model_in_link.rotation * frame.rotation,
                None => {
                    self.warn(
                        node,
                        "the frame of its axis cannot be determined, so the frame of the joint is used; correct it",
                    );
                    joint_in_link.rotation
                }
            },
            None if is_in_model => model_in_link.rotation,
            None => joint_in_link.rotation,
        };
        let limit = |name: &str, default: f64| {
            let text = axis.and_then(|axis| child(child(axis, "limit")?, name)?.text());
            text.and_then(|text| text.trim().parse().ok()).unwrap_or(default)
        };
        let limits = Some([limit("lower", -UNLIMITED), limit("upper", UNLIMITED)]);
        let is_limited = |[low, high]: &[f64; 2]| low <= high && *low > -UNLIMITED && *high < UNLIMITED;
        let limits = limits.filter(is_limited).filter(|_| node.attribute("type") != Some("continuous"));
        let index = self.chain.joints.len();
        self.named.insert((node.range().start, axis_name), index);
        if let Some(mimic) = axis.and_then(|axis| child(axis, "mimic")) {
            self.mimics.push((index, model, mimic));
        }
        let own = node.attribute("name").unwrap_or_default();
        self.chain.joints.push(Joint {
            name: if axis_name == "axis2" { format!("{own} axis2") } else { own.to_owned() },
            link,
            motion,
            axis: (rotation * stated).try_normalize().unwrap_or(DVec3::Z),
            anchor: joint_in_link.translation,
            limits,
            reference: 0.0,
            neutral: neutral(limits),
            coupling: None,
        });
    }

    fn couple(&mut self) {
        for (follower, model, mimic) in std::mem::take(&mut self.mimics) {
            let leader = mimic.attribute("joint").and_then(|name| self.frames.find(model, name));
            let axis = if mimic.attribute("axis") == Some("axis2") { "axis2" } else { "axis" };
            let number = |name: &str, default: f64| {
                let text = child(mimic, name).and_then(|element| element.text());
                text.and_then(description::number).unwrap_or(default)
            };
            match leader.and_then(|leader| self.named.get(&(leader.range().start, axis))) {
                Some(&leader) => {
                    let factor = number("multiplier", 1.0);
                    let offset = number("offset", 0.0) - factor * number("reference", 0.0);
                    let coefficients = [offset, factor, 0.0, 0.0, 0.0];
                    self.chain.joints[follower].coupling = Some(Coupling { leader: Some(leader), coefficients });
                }
                None => self.warn(mimic, "it names no joint that moves, so it is left out; correct it"),
            }
        }
    }
}

fn is_true(text: &str) -> bool {
    matches!(text.trim(), "1" | "true")
}
