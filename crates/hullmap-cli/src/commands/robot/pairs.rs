use std::collections::{BTreeMap, BTreeSet};

use hullmap_planning::{Convex, hulls as hulls_of, shape_of_primitive};
use hullmap_report::robot::{Excluded, Touching};
use hullmap_robot::{
    Change, CollisionFilter, Description, DisabledPair, Format, Frame, Geometry, Shape, Skipped, srdf,
};
use rayon::prelude::*;

use hullmap_pipeline::mesh_file::seal::{SEAL, sealed};

use super::bodies::Piece;
use super::choice::{Choice, Choices};
use super::hulls::Hulls;
use super::meshes::Meshes;
use super::sampling::{Seen, sample};
use super::touching::Bodies;

/// Maximum number of links whose pairs are tested and listed.
const MAX_LINKS: usize = 1500;

/// Maximum number of collisions and visuals of a robot whose pairs are listed.
const MAX_SHAPES: usize = 10_000;

/// Maximum length of a list of what is not tested.
const MAX_SKIPPED: usize = 100_000;

/// Maximum number of pairs or links in a warning.
const NAMED: usize = 5;

#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    pub count: u32,
    pub seed: u64,
}

pub struct Pairs {
    /// Its collisions, with meshes as their hulls.
    pub before: Bodies,
    /// Its new collisions.
    pub after: Bodies,
    pub touching: Vec<Touching>,
    /// Pairs to exclude.
    pub excluded: Vec<Excluded>,
    neutral: Vec<Frame>,
    sampling: Sampling,
    format: Format,
    /// Links with meshes that cannot be read. That they never touch is unknown.
    unread: BTreeSet<usize>,
    /// Whether the robot has too many links for a test of all pairs. Then none was tested.
    is_cut: bool,
}

impl Pairs {
    pub fn new(
        description: &Description,
        choices: &Choices,
        hulls: &[Hulls],
        meshes: &mut Meshes,
        sampling: Sampling,
    ) -> Self {
        let chain = &description.chain;
        let mut displacements = chain.neutral();
        chain.follow(&mut displacements);
        let neutral = chain.poses(&displacements);
        let before = description.links.iter().map(|link| {
            let shapes = link.collisions.iter();
            shapes.flat_map(|shape| as_engines_do(shape, meshes)).collect()
        });
        let before = Bodies::new(before.collect());
        let after = Bodies::new(after(description, choices, hulls, meshes));
        let unread = unread(description, choices, hulls, meshes);
        let filter = CollisionFilter::new(description);
        let has_geometry = |link| before.count(link) + after.count(link) > 0 || unread.contains(&link);
        let is_cut = description.links.len() > MAX_LINKS;
        let all = if is_cut { Vec::new() } else { filter.pairs(has_geometry) };
        let tested: Vec<Touching> = all
            .par_iter()
            .map(|&links| {
                let touches = [&before, &after].map(|bodies| bodies.touch(links, &neutral));
                Touching { links, touches, is_untested: filter.links(links).is_some() }
            })
            .collect();
        let seen = sample(chain, &after, &all, sampling.count, sampling.seed);
        let reason = |(pair, seen): (&Touching, &Seen)| {
            let reason = reason(description.format, pair, *seen)?;
            let is_known = pair.links.iter().all(|link| !unread.contains(link));
            (is_known || reason != "Never").then_some(Excluded { links: pair.links, reason })
        };
        let excluded = tested.iter().zip(&seen).filter_map(reason).collect();
        let touching = tested.into_iter().filter(|pair| pair.touches != [false, false]).collect();
        Self { before, after, touching, excluded, neutral, sampling, format: description.format, unread, is_cut }
    }

    pub fn neutral(&self) -> &[Frame] {
        &self.neutral
    }

    pub fn in_words(&self) -> String {
        if self.is_cut {
            return format!("Not tested: the description has more than {MAX_LINKS} links.");
        }
        let Sampling { count, seed } = self.sampling;
        let sampled = format!("in {count} random configurations (seed {seed})");
        match self.format {
            Format::Mjcf => {
                format!("Default: the two touch in the neutral pose. Always: they touch {sampled}, without exception.")
            }
            _ => format!(
                "Adjacent: a joint connects the two, or they are rigidly connected. Default: they touch in the neutral pose. \
                 Always: they touch {sampled}, without exception. Never: they touch in none of these, which is no proof."
            ),
        }
    }

    pub fn change(&self) -> Change {
        Change::Exclude { pairs: self.excluded.iter().map(|pair| pair.links).collect(), comment: self.in_words() }
    }

    /// Warning about links that were not tested.
    pub fn unread(&self, description: &Description) -> Option<String> {
        let names: Vec<String> =
            self.unread.iter().map(|link| format!("`{}`", description.links[*link].name)).collect();
        let (some, more) = named(&names);
        (!names.is_empty()).then(|| {
            format!(
                "{}: links with meshes that cannot be read were not tested: {some}{more}; restore their meshes, or add \
                 their pairs by hand",
                description.path().display()
            )
        })
    }

    /// Warning about pairs of a URDF file that may touch only because a hull fills a concavity.
    /// Other programs would test the triangles, and find a contact when the pose changes.
    pub fn filled(
        &self,
        description: &Description,
        choices: &Choices,
        hulls: &[Hulls],
        meshes: &mut Meshes,
    ) -> Option<String> {
        if self.format != Format::Urdf {
            return None;
        }
        let mut is_filled = vec![false; description.links.len()];
        for own in &choices.shapes {
            if let (Choice::Hulls(index), Geometry::Mesh(mesh)) =
                (&own.choice, &choices.shape(own, description).geometry)
            {
                let is_one = !hulls[*index].is_parts;
                is_filled[own.link] |= is_one && meshes.get(mesh).is_some_and(|mesh| mesh.is_concave());
            }
        }
        let pairs = self.excluded.iter().filter(|pair| pair.reason == "Default");
        let pairs: Vec<String> = pairs
            .filter(|pair| pair.links.iter().any(|link| is_filled[*link]))
            .map(|pair| pair.links.map(|link| description.links[link].name.as_str()).join("-"))
            .collect();
        let (some, more) = named(&pairs);
        (!pairs.is_empty()).then(|| {
            format!(
                "{}: pairs are excluded because hulls touch, which fill concavities of their meshes: {some}{more}; their \
                 meshes may meet in other poses: use --decompose",
                description.path().display()
            )
        })
    }

    /// The SRDF file, sealed.
    pub fn srdf(&self, description: &Description) -> Vec<u8> {
        let name = |link: usize| description.links[link].name.as_str();
        let pair = |pair: &Excluded| DisabledPair { links: pair.links.map(name), reason: pair.reason };
        let pairs: Vec<DisabledPair> = self.excluded.iter().map(pair).collect();
        let comment = format!("Pairs only, {SEAL}. {}", self.in_words());
        sealed(srdf(&description.name, &comment, &pairs).into_bytes())
    }
}

/// The list of what is not tested after these changes, and a note if it is cut.
pub fn skipped(description: &Description, changes: &[Change]) -> (Vec<Skipped>, Option<String>) {
    let mut filter = CollisionFilter::new(description);
    filter.change(changes, description);
    let shapes: usize = description.links.iter().map(|link| link.collisions.len() + link.visuals.len()).sum();
    let is_listed = description.links.len() <= MAX_LINKS && shapes <= MAX_SHAPES;
    let allowed = BTreeMap::new();
    let all: Box<dyn Iterator<Item = Skipped>> =
        if is_listed { Box::new(filter.skipped(&allowed)) } else { Box::new(filter.untested()) };
    let mut skipped: Vec<Skipped> = all.take(MAX_SKIPPED + 1).collect();
    let cut = if !is_listed {
        Some(format!("no pairs: the description has more than {MAX_LINKS} links, or {MAX_SHAPES} shapes"))
    } else {
        (skipped.len() > MAX_SKIPPED).then(|| format!("only the first {MAX_SKIPPED} entries"))
    };
    skipped.truncate(MAX_SKIPPED);
    (skipped, cut.map(|cut| format!("`skipped` has {cut}")))
}

/// MuJoCo does not test neighbours, and skips distant pairs by their boxes. Excluding pairs that
/// never touched would save nothing, and lose contacts that the random configurations missed.
fn reason(format: Format, pair: &Touching, seen: Seen) -> Option<&'static str> {
    let is_always = seen == Seen { together: true, apart: false };
    match format {
        Format::Mjcf if pair.is_untested => None,
        Format::Urdf | Format::Sdf if pair.is_untested => Some("Adjacent"),
        _ if pair.touches[1] => Some("Default"),
        _ if is_always => Some("Always"),
        Format::Urdf | Format::Sdf if seen == (Seen { together: false, apart: true }) => Some("Never"),
        _ => None,
    }
}

fn named(names: &[String]) -> (String, &'static str) {
    let some = names.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    (some, if names.len() > NAMED { ", …" } else { "" })
}

fn unread(description: &Description, choices: &Choices, hulls: &[Hulls], meshes: &mut Meshes) -> BTreeSet<usize> {
    let mut unread = BTreeSet::new();
    for own in &choices.shapes {
        let is_baked = match own.choice {
            Choice::Removed | Choice::Primitive => true,
            Choice::Hulls(at) => hulls[at].fault.is_none(),
            Choice::Kept(_) => false,
        };
        if let (false, Geometry::Mesh(mesh)) = (is_baked, &choices.shape(own, description).geometry)
            && meshes.get(mesh).is_none_or(|mesh| mesh.hull().is_err())
        {
            unread.insert(own.link);
        }
    }
    unread
}

fn after(description: &Description, choices: &Choices, hulls: &[Hulls], meshes: &mut Meshes) -> Vec<Vec<Piece>> {
    let mut after: Vec<Vec<Piece>> = description.links.iter().map(|_| Vec::new()).collect();
    for own in &choices.shapes {
        let shape = choices.shape(own, description);
        let pieces = match (&own.choice, &shape.geometry) {
            (Choice::Removed, _) => Vec::new(),
            (Choice::Hulls(own), Geometry::Mesh(mesh)) if hulls[*own].fault.is_none() => {
                pieces(shape, hulls_of(&hulls[*own].pack, mesh).unwrap_or_default())
            }
            _ => as_engines_do(shape, meshes),
        };
        // A geom that was only drawn collides with everything now.
        let contact_bits = |piece: &Piece| if own.from_visual { [1, 1] } else { piece.contact_bits };
        after[own.link].extend(pieces.into_iter().map(|piece| Piece { contact_bits: contact_bits(&piece), ..piece }));
    }
    after
}

/// The pieces of a shape of a description: engines replace a mesh by its convex hull.
fn as_engines_do(shape: &Shape, meshes: &mut Meshes) -> Vec<Piece> {
    let shapes = match &shape.geometry {
        Geometry::Mesh(mesh) => {
            meshes.get(mesh).and_then(|own| hulls_of(own.hull().ok()?, mesh).ok()).unwrap_or_default()
        }
        Geometry::Primitive(primitive) => {
            primitive.shape.and_then(|own| shape_of_primitive(own).ok()).into_iter().collect()
        }
        Geometry::Other(_) => Vec::new(),
    };
    pieces(shape, shapes)
}

fn pieces(shape: &Shape, shapes: Vec<Convex>) -> Vec<Piece> {
    let Some(in_link) = shape.pose else { return Vec::new() };
    shapes.into_iter().map(|own| Piece { shape: own, in_link, contact_bits: shape.contact_bits }).collect()
}
