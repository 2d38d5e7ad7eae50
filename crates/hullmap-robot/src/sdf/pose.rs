//! The `pose` of an element of SDF, and of a link relative to its model.
//!
//! # Reference
//! <http://sdformat.org/tutorials?tut=pose_frame_semantics>

use std::cell::RefCell;
use std::collections::HashMap;

use glam::{DQuat, DVec3};
use roxmltree::Node;

use crate::description::numbers;
use crate::element::child;
use crate::frame::Frame;

/// Maximum number of frames that refer to each other.
const MAX_STEPS: usize = 100;

const FRAMES: [&str; 4] = ["link", "joint", "frame", "model"];

/// The numbers of an element's pose, in whatever frame they are relative to; `None` if invalid.
pub fn stated(node: Node) -> Option<Frame> {
    let Some(pose) = child(node, "pose") else { return Some(Frame::IDENTITY) };
    let Some(text) = pose.text().filter(|text| !text.trim().is_empty()) else { return Some(Frame::IDENTITY) };
    let numbers = numbers(text)?;
    match pose.attribute("rotation_format") {
        Some("quat_xyzw") => {
            let [x, y, z, qx, qy, qz, qw] = numbers.try_into().ok()?;
            let rotation = DQuat::from_xyzw(qx, qy, qz, qw);
            let rotation = Some(rotation).filter(|own| own.length_squared() > 0.0)?.normalize();
            Some(Frame { rotation, translation: DVec3::new(x, y, z) })
        }
        None | Some("euler_rpy") => {
            let mut numbers: [f64; 6] = numbers.try_into().ok()?;
            if pose.attribute("degrees") == Some("true") {
                numbers.iter_mut().skip(3).for_each(|angle| *angle = angle.to_radians());
            }
            Some(Frame::of_xyz_rpy(numbers))
        }
        Some(_) => None,
    }
}

fn relative_to<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    child(node, "pose")?.attribute("relative_to").filter(|frame| !frame.is_empty())
}

/// The pose of a shape in its link; `None` if it is invalid, or relative to another frame.
pub fn in_link(node: Node) -> Option<Frame> {
    stated(node).filter(|_| relative_to(node).is_none())
}

pub struct Frames<'a> {
    /// By the start of the model, and the name.
    named: HashMap<(usize, &'a str), Node<'a, 'a>>,
    /// Frames that are known, by the start of their element: in their model, and in the world.
    in_model: RefCell<HashMap<usize, Option<Frame>>>,
    in_world: RefCell<HashMap<usize, Option<Frame>>>,
}

impl<'a> Frames<'a> {
    pub fn new(root: Node<'a, 'a>) -> Self {
        let mut named = HashMap::new();
        for model in root.descendants().filter(|node| node.has_tag_name("model")) {
            for node in model.children().filter(|node| FRAMES.contains(&node.tag_name().name())) {
                if let Some(name) = node.attribute("name") {
                    named.entry((model.range().start, name)).or_insert(node);
                }
            }
        }
        Self { named, in_model: RefCell::default(), in_world: RefCell::default() }
    }

    /// The element with this name in a model; `a::b` is in the nested model `a`.
    pub fn find(&self, model: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
        let mut model = model;
        let mut words = name.split("::").peekable();
        while let Some(word) = words.next() {
            let found = *self.named.get(&(model.range().start, word))?;
            if words.peek().is_none() {
                return Some(found);
            }
            model = found;
        }
        None
    }

    /// The link that an element of a model is, or is attached to.
    pub fn link(&self, model: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
        let mut found = self.find(model, name)?;
        for _ in 0..MAX_STEPS {
            let own = found.parent_element()?;
            found = match found.tag_name().name() {
                "link" => return Some(found),
                "frame" => self.find(own, found.attribute("attached_to")?)?,
                "joint" => self.find(own, end(found, "child")?)?,
                _ => return None,
            };
        }
        None
    }

    /// The frame of an element in the frame of its model; `None` if it is invalid or circular.
    pub fn in_model(&self, node: Node<'a, 'a>) -> Option<Frame> {
        self.resolve(node, MAX_STEPS)
    }

    /// Each frame is computed once, so that frames in nested models do not take exponential time.
    fn resolve(&self, node: Node<'a, 'a>, steps: usize) -> Option<Frame> {
        let key = node.range().start;
        if let Some(known) = self.in_model.borrow().get(&key) {
            return *known;
        }
        // A circle leads here again.
        self.in_model.borrow_mut().insert(key, None);
        let found = self.computed(node, steps.checked_sub(1)?);
        self.in_model.borrow_mut().insert(key, found);
        found
    }

    fn computed(&self, node: Node<'a, 'a>, steps: usize) -> Option<Frame> {
        let own = stated(node)?;
        let by_default = match node.tag_name().name() {
            "joint" => end(node, "child"),
            "frame" => node.attribute("attached_to").filter(|name| !name.is_empty()),
            _ => None,
        };
        let model = node.parent_element()?;
        let base = match relative_to(node).or(by_default) {
            None | Some("__model__") => Frame::IDENTITY,
            Some(name) => self.named(model, name, steps)?,
        };
        Some(base * own)
    }

    /// The frame of a named element in the frame of a model that contains it.
    pub fn named_in_model(&self, model: Node<'a, 'a>, name: &str) -> Option<Frame> {
        self.named(model, name, MAX_STEPS)
    }

    fn named(&self, model: Node<'a, 'a>, name: &str, steps: usize) -> Option<Frame> {
        let mut found = self.find(model, name)?;
        let mut frame = self.resolve(found, steps)?;
        while found.parent_element() != Some(model) {
            found = found.parent_element()?;
            frame = self.resolve(found, steps)? * frame;
        }
        Some(frame)
    }

    /// The frame of an element of a model, or of a model, in the frame of the whole file.
    pub fn in_world(&self, node: Node<'a, 'a>) -> Option<Frame> {
        let (mut inner, mut around) = (Vec::new(), Some(Frame::IDENTITY));
        for own in node.ancestors().filter(|own| *own == node || own.has_tag_name("model")) {
            if let Some(known) = self.in_world.borrow().get(&own.range().start) {
                around = *known;
                break;
            }
            inner.push(own);
        }
        for own in inner.into_iter().rev() {
            around = around.zip(self.in_model(own)).map(|(around, own)| around * own);
            self.in_world.borrow_mut().insert(own.range().start, around);
        }
        around
    }
}

/// The name of a joint's parent or child: the text of an element, or of an element in it.
pub fn end<'a>(joint: Node<'a, 'a>, kind: &str) -> Option<&'a str> {
    child(joint, kind)?.text().map(str::trim)
}
