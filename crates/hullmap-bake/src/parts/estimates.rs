//! Estimates of how the parts of an object fit together, and its summary in the rows of a build.

use hullmap_geometry::PointSet;

use crate::advice::usability::{Doubt, ObjectMeasures};
use crate::deadline::Deadline;
use crate::fit::{Looseness, Solid, VoidsShare, looseness_of_parts, overlap, voids};
use crate::hull::{self, Hull};
use crate::symmetry::{Mirror, mirror_of_parts};

/// A pack may be hostile, and the time grows with the square of the number.
const MAX_PARTS: usize = 4096;

/// Estimates of how the parts of one object fit together. Field names are the JSON's; `None` if
/// something was not measured. Lengths are in source units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PartsEstimates {
    /// Sum of the parts' volumes minus the volume of their union, relative to the latter.
    pub overlap: Option<f64>,
    /// Error of `overlap`: twice its standard deviation.
    pub overlap_error: Option<f64>,
    /// Mean distance of the parts' visible surface from the mesh's solid.
    pub mean_protrusion: Option<f64>,
    /// Maximum distance of a part from the mesh's convex hull.
    pub outside_hull: Option<f64>,
    /// Share of the solid's volume that is in no part.
    pub voids: Option<f64>,
    /// Error of `voids`: twice its standard deviation.
    pub voids_error: Option<f64>,
    /// The plane about which the parts are symmetric, in their frame; `None` if there is none.
    pub symmetry: Option<MirrorPlane>,
}

/// A plane of symmetry: the points p with `normal · p = offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MirrorPlane {
    /// Unit normal.
    pub normal: [f64; 3],
    /// Offset along the normal, a length.
    pub offset: f64,
}

impl MirrorPlane {
    /// The plane about which parts, each given by its vertices, are symmetric; `None` if there is
    /// none, or if there are too many parts.
    pub fn find(parts: &[&[[f32; 3]]]) -> Option<Self> {
        let Mirror { plane, .. } = mirror_of_parts(Some(parts).filter(|parts| parts.len() <= MAX_PARTS)?)?;
        Some(Self { normal: plane.normal.to_array(), offset: plane.offset })
    }

    /// Its equation, such as `x = 0`.
    pub fn in_words(&self) -> String {
        Mirror::new(self.normal, self.offset).to_string()
    }
}

fn symmetry(parts: &[&Hull]) -> Option<MirrorPlane> {
    MirrorPlane::find(&parts.iter().map(|part| part.vertices.as_slice()).collect::<Vec<_>>())
}

impl PartsEstimates {
    /// The estimates of `parts` that stand for `mesh`, and the mean protrusion of each part.
    /// Protrusion counts from `solid`; `volume` is the volume of the mesh's own solid, if it is
    /// known. After the deadline, voids are estimated coarsely.
    pub fn new(
        mesh: &PointSet,
        solid: &Solid,
        parts: &[&Hull],
        volume: Option<f64>,
        deadline: Option<Deadline>,
    ) -> (Self, Vec<Option<f64>>) {
        let Some(whole) = hull::build(mesh).ok().filter(|_| parts.len() <= MAX_PARTS) else {
            return (Self::default(), vec![None; parts.len()]);
        };
        let (loose, means) = looseness_of_parts(solid, &whole, parts);
        let mut found = Self {
            overlap: Some(loose.overlap),
            overlap_error: Some(loose.overlap_error),
            mean_protrusion: Some(loose.mean_protrusion),
            outside_hull: Some(loose.outside_hull),
            symmetry: symmetry(parts),
            ..Self::default()
        };
        if let Some(volume) = volume {
            let VoidsShare { share, error } = voids(solid, parts, deadline).relative_to(volume);
            (found.voids, found.voids_error) = (Some(share), Some(error));
        }
        (found, means)
    }

    /// The estimates of `parts` whose mesh is not known.
    pub fn without_mesh(parts: &[&Hull]) -> Self {
        let (overlap, overlap_error) = (parts.len() <= MAX_PARTS).then(|| overlap(parts)).unzip();
        Self { overlap, overlap_error, symmetry: symmetry(parts), ..Self::default() }
    }

    /// The voids, if they were estimated.
    pub fn voids_share(&self) -> Option<VoidsShare> {
        Some(VoidsShare { share: self.voids?, error: self.voids_error? })
    }

    /// The estimates for a sentence about the parts, if the parts were compared.
    pub fn looseness(&self) -> Option<Looseness> {
        Some(Looseness {
            overlap: self.overlap?,
            overlap_error: self.overlap_error?,
            mean_protrusion: self.mean_protrusion?,
            outside_hull: self.outside_hull?,
        })
    }
}

/// An object whose mesh was decomposed, or whose parts came with it. Field names are the JSON's.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DecomposedObject {
    /// Name of the object.
    pub name: String,
    /// Number of its parts.
    pub parts: usize,
    /// How its solid is known; `None` if the parts were not measured.
    pub solid: Option<String>,
    /// Bound on how far its surface lies outside all parts.
    pub uncovered: Option<f64>,
    /// Bound on how far a part protrudes from its solid.
    pub protrusion: Option<f64>,
    /// Thickness of the thinnest part.
    pub thickness: Option<f64>,
    /// Why an engine cannot use the parts well, in one word each; empty if it can.
    pub flaws: Vec<String>,
    /// How the parts fit together.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub estimates: PartsEstimates,
}

impl DecomposedObject {
    /// The summary of an object.
    pub fn new(object: &ObjectMeasures, doubts: &[Doubt], estimates: PartsEstimates) -> Self {
        Self {
            name: object.name.to_owned(),
            parts: object.parts.len(),
            solid: object.solid.map(|solid| solid.as_str().to_owned()),
            uncovered: object.solid.map(|_| object.uncovered),
            protrusion: object.parts.iter().filter_map(|part| part.protrusion).reduce(f64::max),
            thickness: object.parts.iter().map(|part| part.thickness).reduce(f64::min),
            flaws: doubts.iter().map(|doubt| doubt.flaw.as_str().to_owned()).collect(),
            estimates,
        }
    }
}
