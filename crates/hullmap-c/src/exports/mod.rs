//! The exported functions.
//!
//! Each one copies its arguments, checks them, calls a safe module, and writes the answer. The
//! rules for callers are the same for all, and are written once: at the head of the header
//! (`cbindgen.toml`).
#![allow(clippy::missing_safety_doc, reason = "the rules are at the head of the header")]

// In the order of the header; the empty lines keep rustfmt from sorting them.

pub mod version;

pub mod pack;

pub mod triangle_mesh;

pub mod height_field;

pub mod shape;

pub mod pose;

pub mod cache;

pub mod query;

pub mod motion;

pub mod manifold;

pub mod batch;

mod sheet;

use hullmap::Pose;

use crate::failure::{Failure, Fallible};
use crate::types;

/// A pose from C, checked and normalised.
#[inline(always)]
fn pose(name: &str, pose: types::Pose) -> Fallible<Pose> {
    Pose::new(pose.translation, pose.rotation).map_err(|error| Failure::argument(name, error))
}

/// Settings from C, or the default ones.
fn settings(found: Option<types::Settings>) -> hullmap::Settings {
    found.map_or_else(hullmap::Settings::default, |found| hullmap::Settings {
        tolerance: found.tolerance,
        max_iterations: found.max_iterations,
    })
}

fn cast_settings(found: Option<types::CastSettings>) -> hullmap::CastSettings {
    found.map_or_else(hullmap::CastSettings::default, |found| hullmap::CastSettings {
        max_t: found.max_t,
        tolerance: found.tolerance,
        max_iterations: found.max_iterations,
    })
}

fn manifold_settings(found: Option<types::ManifoldSettings>) -> Fallible<hullmap::ManifoldSettings> {
    let Some(found) = found else { return Ok(hullmap::ManifoldSettings::default()) };
    let types::ManifoldSettings { tolerance, max_iterations, prediction_kind, prediction, .. } = found;
    let prediction = match prediction_kind {
        kind if kind == types::Prediction::Relative as u32 => hullmap::Prediction::Relative(prediction),
        kind if kind == types::Prediction::Length as u32 => hullmap::Prediction::Length(prediction),
        kind => return Err(Failure::argument("prediction_kind", format_args!("{kind} is not a HullmapPrediction"))),
    };
    Ok(hullmap::ManifoldSettings { contact: hullmap::Settings { tolerance, max_iterations }, prediction })
}
