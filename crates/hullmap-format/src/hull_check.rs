//! Checks of a hull: record, vertices, faces, quads, neighbours, edges, outer hull, index, blocks.

use rkyv::rend::{f32_le, f64_le, u32_le};

use crate::{
    adjacency::Adjacency,
    archive::{
        ArchivedBlock, ArchivedHullRecord, ArchivedSpan, LANES, LEAN_FACES, MAX_OUTER_VERTICES, MassRecord,
        NO_SOURCE_VERTEX,
    },
    check_error::HullError,
    index_kind::IndexKind,
    mass,
    sections::Sections,
    solid_kind::SolidKind,
    walk::{Cost, IndexShape, walk},
};

pub(crate) struct HullCheck<'a> {
    pub(crate) hull: usize,
    pub(crate) pack: &'a Sections<'a>,
    pub(crate) start: &'a ArchivedSpan,
    pub(crate) end: &'a ArchivedSpan,
    pub(crate) record: &'a ArchivedHullRecord,
}

impl HullCheck<'_> {
    /// Runs all checks. `scratch` is memory that hulls share.
    pub(crate) fn run(&self, scratch: &mut Vec<u64>) -> Result<(), HullError> {
        self.name()?;
        self.record()?;
        self.part()?;
        self.solid()?;
        self.mass()?;
        self.vertices()?;
        self.source_vertices()?;
        self.faces()?;
        if self.pack.is_lean() {
            self.no_neighbours()?;
        } else {
            self.quads()?;
            self.neighbours()?;
            self.adjacency().check(scratch)?;
            self.edges()?;
        }
        self.outer()?;
        self.index()?;
        self.blocks()
    }

    fn vertex_count(&self) -> u32 {
        self.end.vertex.to_native() - self.start.vertex.to_native()
    }

    fn block_count(&self) -> u32 {
        self.end.block.to_native() - self.start.block.to_native()
    }

    fn name(&self) -> Result<(), HullError> {
        let name = run(self.pack.names, self.start.name, self.end.name);
        std::str::from_utf8(name).map(drop).map_err(|error| HullError::Name { at: error.valid_up_to() })
    }

    fn record(&self) -> Result<(), HullError> {
        let r = self.record;
        for (field, length) in [
            ("inner radius", r.inner_radius),
            ("outer radius", r.outer_radius),
            ("diameter", r.diameter),
            ("volume", r.volume),
            ("surface area", r.surface_area),
            ("containment error", r.containment_error),
            ("outer error", r.outer_error),
            ("uncovered distance", r.uncovered),
            ("protrusion", r.protrusion),
        ] {
            let found = length.to_native();
            // `>=` is false for NaN.
            if !(found >= 0.0 && found.is_finite()) {
                return Err(HullError::Length { field, found });
            }
        }
        all_finite("centroid", &r.centroid, f64_le::to_native)?;
        all_finite("interior point", &r.interior_point, f64_le::to_native)?;
        all_finite("second moments", &r.second_moments, f64_le::to_native)?;
        all_finite("origin", &r.origin, f64_le::to_native)?;
        all_finite("point of greatest protrusion", &r.protrusion_at, f64_le::to_native)?;
        all_finite("lower bounds", &r.bounds_min, |c| f64::from(c.to_native()))?;
        all_finite("upper bounds", &r.bounds_max, |c| f64::from(c.to_native()))?;
        let (rank, found) = (r.rank.to_native(), self.vertex_count());
        let fits = match rank {
            0 => found == 1,
            1 => found == 2,
            2 | 3 => found > rank,
            _ => return Err(HullError::Rank { found: rank }),
        };
        if !fits {
            return Err(HullError::VertexCount { rank, found });
        }
        let (inner, outer) = (r.inner_radius.to_native(), r.outer_radius.to_native());
        if inner <= outer { Ok(()) } else { Err(HullError::Radii { inner, outer }) }
    }

    fn before(&self) -> Option<&ArchivedHullRecord> {
        self.hull.checked_sub(1).and_then(|before| self.pack.hulls.get(before))
    }

    /// Parts of an object are consecutive, counted from 0, and complete. All hulls share a frame.
    fn part(&self) -> Result<(), HullError> {
        let before = self.before();
        let [found, count] = [self.record.part, self.record.part_count].map(u32_le::to_native);
        let next = before.map_or(0, |before| {
            let next = before.part.to_native().saturating_add(1);
            if next < before.part_count.to_native() { next } else { 0 }
        });
        if found != next {
            return Err(HullError::Part { found, expected: next });
        }
        let expected = match before {
            Some(before) if next > 0 => before.part_count.to_native(),
            _ => count,
        };
        let left = self.pack.hulls.len() - self.hull;
        // The first part states how many follow.
        if count != expected || next == 0 && count as usize > left {
            return Err(HullError::PartCount {
                found: count,
                expected: if next > 0 { Some(expected) } else { None },
                left,
            });
        }
        match before {
            Some(before) if before.origin != self.record.origin => Err(HullError::Origin {
                found: self.record.origin.map(f64_le::to_native),
                expected: before.origin.map(f64_le::to_native),
            }),
            _ => Ok(()),
        }
    }

    /// A hull that was not measured states no distances. One solid measured all parts of an object.
    fn solid(&self) -> Result<(), HullError> {
        let r = self.record;
        let found = r.solid.to_native();
        if found > 0 && SolidKind::from_code(found).is_none() {
            return Err(HullError::Solid { found });
        }
        let measures = [r.uncovered, r.protrusion, r.protrusion_at[0], r.protrusion_at[1], r.protrusion_at[2]];
        if found == 0 && measures.iter().any(|measure| measure.to_native() != 0.0) {
            return Err(HullError::Unmeasured);
        }
        if found > 0 && r.part_count.to_native() == 0 {
            return Err(HullError::MeasuredAlone);
        }
        match self.before() {
            Some(before) if r.part.to_native() > 0 && (before.solid, before.uncovered) != (r.solid, r.uncovered) => {
                Err(HullError::PartsDiffer)
            }
            _ => Ok(()),
        }
    }

    /// An object's first hull may have the mass of its mesh: its centre is then within the bounds
    /// of the hulls, and a solid can have its inertia tensor.
    fn mass(&self) -> Result<(), HullError> {
        let found = run(self.pack.masses, self.start.mass, self.end.mass);
        let expected = usize::from(self.record.part.to_native() == 0);
        if found.len() > expected {
            return Err(HullError::MassCount { found: found.len(), expected });
        }
        let Some(found) = found.first() else { return Ok(()) };
        let count = self.record.part_count.to_native().max(1) as usize;
        let own = self.pack.hulls.iter().skip(self.hull).take(count);
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for record in own {
            // NaN is ignored here, and rejected in the record itself.
            low.iter_mut().zip(&record.bounds_min).for_each(|(low, own)| *low = low.min(own.to_native()));
            high.iter_mut().zip(&record.bounds_max).for_each(|(high, own)| *high = high.max(own.to_native()));
        }
        Ok(mass::check(&MassRecord::from(found), low, high, self.record.uncovered.to_native())?)
    }

    fn vertices(&self) -> Result<(), HullError> {
        let vertices = run(self.pack.vertices, self.start.vertex, self.end.vertex);
        let (low, high) = (self.record.bounds_min, self.record.bounds_max);
        // Four vertices at a time. NaN is out of all bounds.
        let fours = vertices.as_chunks::<4>();
        let four = |bound: [f32_le; 3]| [bound; 4].map(|v| v.map(f32_le::to_native));
        let (lows, highs) = (four(low), four(high));
        let mut inside = true;
        for four in fours.0 {
            for (v, (low, high)) in four.as_flattened().iter().zip(lows.as_flattened().iter().zip(highs.as_flattened()))
            {
                inside &= (*low <= v.to_native()) & (v.to_native() <= *high);
            }
        }
        let is_within = |v: &[f32_le; 3]| v.iter().zip(low.iter().zip(&high)).all(|(v, (l, h))| l <= v && v <= h);
        inside &= fours.1.iter().all(is_within);
        if inside { Ok(()) } else { Err(self.vertex_out_of_bounds(vertices)) }
    }

    #[cold]
    fn vertex_out_of_bounds(&self, vertices: &[[f32_le; 3]]) -> HullError {
        let index = first(vertices.as_flattened(), |i, c| !self.is_in_bounds(i % 3, c.to_native()));
        let found = vertices.as_flattened().get(index).map_or(f32::NAN, |c| c.to_native());
        let [low, high] = self.bounds(index % 3);
        HullError::VertexBounds { vertex: index / 3, axis: index % 3, found, low, high }
    }

    fn bounds(&self, axis: usize) -> [f32; 2] {
        [&self.record.bounds_min, &self.record.bounds_max].map(|b| b.get(axis).map_or(f32::NAN, |c| c.to_native()))
    }

    /// False for NaN.
    fn is_in_bounds(&self, axis: usize, c: f32) -> bool {
        let [low, high] = self.bounds(axis);
        low <= c && c <= high
    }

    fn source_vertices(&self) -> Result<(), HullError> {
        let all = run(self.pack.source_vertices, self.start.vertex, self.end.vertex);
        let later = all.get(1..).unwrap_or_default();
        let ascend = |a: u32, b: u32| (a < b) | ((a == NO_SOURCE_VERTEX) & (b == NO_SOURCE_VERTEX));
        if all.iter().zip(later).fold(true, |all, (a, b)| all & ascend(a.to_native(), b.to_native())) {
            return Ok(());
        }
        let pairs: Vec<[u32; 2]> = all.iter().zip(later).map(|(a, b)| [a.to_native(), b.to_native()]).collect();
        let index = first(&pairs, |_, [a, b]| !ascend(*a, *b));
        let [before, found] = pairs.get(index).copied().unwrap_or_default();
        Err(HullError::SourceVertexOrder { vertex: index + 1, found, before })
    }

    /// Every face has three vertices or more, every vertex index is in range, and V − E + F = 2. A
    /// large hull in a lean pack has no faces.
    fn faces(&self) -> Result<(), HullError> {
        let starts = run(self.pack.face_starts, self.start.face, self.end.face);
        let corners = run(self.pack.face_vertices, self.start.face_vertex, self.end.face_vertex);
        let rank = self.record.rank.to_native();
        let has_faces = rank >= 2 && !(self.pack.is_lean() && self.vertex_count() > LEAN_FACES);
        if !has_faces && starts.is_empty() && corners.is_empty() {
            return Ok(());
        }
        if rank >= 2 && !has_faces {
            return Err(HullError::LeanFaces { vertex_count: self.vertex_count(), faces: starts.len() });
        }
        if rank < 2 || starts.is_empty() {
            return Err(HullError::FaceCount { rank, faces: starts.len(), corners: corners.len() });
        }
        if run_lengths(starts, corners.len()).is_none_or(|(shortest, _)| shortest < 3) {
            let (face, start, end) = first_bad_run(starts, corners.len(), 3);
            return Err(HullError::FaceRun { face, start, end, corners: corners.len() });
        }
        let vertex_count = self.vertex_count();
        if !all_below(corners, vertex_count) {
            let index = first(corners, |_, vertex| vertex.to_native() >= vertex_count);
            let face = starts.partition_point(|start| start.to_native() as usize <= index).saturating_sub(1);
            return Err(HullError::FaceVertex { face, found: value_at(corners, index), vertex_count });
        }
        let euler = i64::from(vertex_count) - corners.len() as i64 / 2 + starts.len() as i64;
        if corners.len().is_multiple_of(2) && euler == 2 {
            Ok(())
        } else {
            Err(HullError::Euler { vertices: vertex_count, faces: starts.len(), corners: corners.len() })
        }
    }

    /// Every face with more than four corners has an entry, in order, with ascending own corners.
    fn quads(&self) -> Result<(), HullError> {
        let starts = run(self.pack.face_starts, self.start.face, self.end.face);
        let corners = run(self.pack.face_vertices, self.start.face_vertex, self.end.face_vertex);
        let ends = starts.iter().skip(1).map(|start| start.to_native()).chain([corners.len() as u32]);
        let counts = starts.iter().zip(ends).map(|(start, end)| end.saturating_sub(start.to_native()));
        let mut large = (0_u32..).zip(counts).filter(|(_, count)| *count > 4);
        let quads = run(self.pack.quads, self.start.quad, self.end.quad);
        for (index, quad) in quads.iter().enumerate() {
            let found = quad.face.to_native();
            let expected = large.next();
            let Some((_, corner_count)) = expected.filter(|(face, _)| *face == found) else {
                return Err(HullError::QuadFace { quad: index, found, expected: expected.map(|(face, _)| face) });
            };
            let corners = quad.corners.map(|corner| corner.to_native());
            let [a, b, c, d] = corners;
            if !(a < b && b < c && c < d && d < corner_count) {
                return Err(HullError::QuadCorners { quad: index, found: corners, corner_count });
            }
            let fall = quad.fall.to_native();
            // NaN is in no range.
            if !(0.0..=1.0).contains(&fall) {
                return Err(HullError::QuadFall { quad: index, found: fall });
            }
        }
        match large.next() {
            Some((face, _)) => Err(HullError::QuadMissing { face: face as usize }),
            None => Ok(()),
        }
    }

    /// In a lean pack no vertex has neighbours.
    fn no_neighbours(&self) -> Result<(), HullError> {
        match self.record.max_neighbours.to_native() {
            0 => Ok(()),
            found => Err(HullError::MaxNeighbours { found, expected: 0 }),
        }
    }

    /// Every vertex has a run of neighbours, all in range.
    fn neighbours(&self) -> Result<(), HullError> {
        let starts = run(self.pack.neighbour_starts, self.start.vertex, self.end.vertex);
        let all = run(self.pack.neighbours, self.start.neighbour, self.end.neighbour);
        let Some((_, expected)) = run_lengths(starts, all.len()) else {
            let (vertex, start, end) = first_bad_run(starts, all.len(), 0);
            return Err(HullError::NeighbourRun { vertex, start, end, count: all.len() });
        };
        let found = self.record.max_neighbours.to_native();
        if found != expected {
            return Err(HullError::MaxNeighbours { found, expected });
        }
        let vertex_count = self.vertex_count();
        if !all_below(all, vertex_count) {
            let entry = first(all, |_, vertex| vertex.to_native() >= vertex_count);
            return Err(HullError::Neighbour { entry, found: value_at(all, entry), vertex_count });
        }
        let left = run(self.pack.neighbour_faces, self.start.neighbour, self.end.neighbour);
        let face_count = self.end.face.to_native() - self.start.face.to_native();
        // Without faces the entries are 0.
        let limit = face_count.max(1);
        if !all_below(left, limit) {
            let entry = first(left, |_, face| face.to_native() >= limit);
            return Err(HullError::NeighbourFace { entry, found: value_at(left, entry), face_count });
        }
        Ok(())
    }

    fn adjacency(&self) -> Adjacency<'_> {
        Adjacency {
            face_starts: run(self.pack.face_starts, self.start.face, self.end.face),
            face_vertices: run(self.pack.face_vertices, self.start.face_vertex, self.end.face_vertex),
            neighbour_starts: run(self.pack.neighbour_starts, self.start.vertex, self.end.vertex),
            neighbours: run(self.pack.neighbours, self.start.neighbour, self.end.neighbour),
            neighbour_faces: run(self.pack.neighbour_faces, self.start.neighbour, self.end.neighbour),
        }
    }

    /// A solid has three coordinates per neighbour; other hulls have no edges.
    fn edges(&self) -> Result<(), HullError> {
        let neighbours = (self.end.neighbour.to_native() - self.start.neighbour.to_native()) as usize;
        let found = (self.end.edge.to_native() - self.start.edge.to_native()) as usize;
        let expected = if self.record.rank == 3 { 3 * neighbours } else { 0 };
        if found == expected { Ok(()) } else { Err(HullError::EdgeCount { found, expected }) }
    }

    /// The outer hull is absent, or has enough vertices for a solid, all finite.
    fn outer(&self) -> Result<(), HullError> {
        let outer = run(self.pack.outer_vertices, self.start.outer, self.end.outer);
        let found = outer.len();
        if !(found == 0 || (4..=MAX_OUTER_VERTICES).contains(&found)) {
            return Err(HullError::OuterVertexCount { found });
        }
        match outer.as_flattened().iter().map(|c| c.to_native()).enumerate().find(|(_, c)| !c.is_finite()) {
            Some((index, found)) => Err(HullError::OuterVertex { vertex: index / 3, axis: index % 3, found }),
            None => Ok(()),
        }
    }

    fn index(&self) -> Result<(), HullError> {
        let slots = run(self.pack.slots, self.start.slot, self.end.slot);
        let r = self.record;
        let kind = IndexKind::of_record(r)?;
        if self.block_count() == 0 {
            return Err(HullError::NoBlocks);
        }
        let roots = usize::try_from(kind.root_count()).unwrap_or(usize::MAX);
        let leaf_blocks = r.leaf_blocks.to_native();
        let shape = IndexShape { roots, branches: kind.branches(), leaf_blocks, block_count: self.block_count() };
        let walked = walk(shape, slots)?;
        let expected = if kind == IndexKind::None { shape.scan_cost() } else { walked };
        let found = Cost { nodes: r.max_nodes.to_native(), dots: r.max_dots.to_native() };
        if found != expected {
            return Err(HullError::WorstCost { found, expected });
        }
        // A leaf that repeats vertices could make a query on a small hull take time proportional to
        // the file's length.
        let vertex_count = self.vertex_count();
        let blocks = vertex_count.div_ceil(LANES as u32).max(leaf_blocks);
        let limit = blocks.saturating_mul(LANES as u32);
        if found.dots <= limit {
            Ok(())
        } else {
            Err(HullError::LeafCandidates { found: found.dots, vertex_count, limit })
        }
    }

    /// Every lane of every block has a vertex of the hull, whose position is inside the bounds.
    #[expect(clippy::indexing_slicing, reason = "three axes, three coordinates; the loop is one for vectors")]
    fn blocks(&self) -> Result<(), HullError> {
        let blocks = run(self.pack.blocks, self.start.block, self.end.block);
        let n = self.vertex_count();
        let (low, high) = (self.record.bounds_min, self.record.bounds_max);
        let mut named = true;
        let mut inside = true;
        for block in blocks {
            for (axis, lanes) in [&block.x, &block.y, &block.z].into_iter().enumerate() {
                let (low, high) = (low[axis].to_native(), high[axis].to_native());
                for lane in lanes {
                    // NaN is out of all bounds.
                    inside &= (low <= lane.to_native()) & (lane.to_native() <= high);
                }
            }
            for vertex in &block.vertex {
                named &= vertex.to_native() < n;
            }
        }
        if named && inside { Ok(()) } else { Err(self.bad_block(blocks)) }
    }

    #[cold]
    fn bad_block(&self, blocks: &[ArchivedBlock]) -> HullError {
        let vertex_count = self.vertex_count();
        for (index, block) in blocks.iter().enumerate() {
            for (lane, vertex) in block.vertex.iter().enumerate() {
                if vertex.to_native() >= vertex_count {
                    return HullError::BlockVertex { block: index, lane, found: vertex.to_native(), vertex_count };
                }
            }
            for (axis, lanes) in [&block.x, &block.y, &block.z].into_iter().enumerate() {
                let outside = lanes.iter().position(|c| !self.is_in_bounds(axis, c.to_native()));
                if let Some((lane, c)) = outside.and_then(|lane| Some((lane, lanes.get(lane)?))) {
                    let [low, high] = self.bounds(axis);
                    return HullError::BlockBounds { block: index, lane, axis, found: c.to_native(), low, high };
                }
            }
        }
        HullError::OutOfRange { section: "blocks" }
    }
}

fn all_finite<T>(field: &'static str, values: &[T], read: impl Fn(T) -> f64) -> Result<(), HullError>
where
    T: Copy,
{
    match values.iter().map(|value| read(*value)).enumerate().find(|(_, value)| !value.is_finite()) {
        Some((axis, found)) => Err(HullError::NotFinite { field, axis, found }),
        None => Ok(()),
    }
}

/// Index of the first element that `is_bad`, after a pass over all elements has found a bad one. 0
/// if no element is bad any more: another process may have rewritten a mapped file in the meantime.
fn first<T>(all: &[T], is_bad: impl Fn(usize, &T) -> bool) -> usize {
    all.iter().enumerate().position(|(i, element)| is_bad(i, element)).unwrap_or(0)
}

fn value_at(all: &[u32_le], index: usize) -> u32 {
    all.get(index).map_or(0, |value| value.to_native())
}

/// Whether all values are below `limit`. Without an early exit, so that the loop is vectorised.
fn all_below(values: &[u32_le], limit: u32) -> bool {
    values.iter().fold(true, |below, value| below & (value.to_native() < limit))
}

/// Shortest and longest of the runs that start at `starts` and follow one another up to `end`.
/// `None` if they do not, or if there are no runs.
fn run_lengths(starts: &[u32_le], end: usize) -> Option<(u32, u32)> {
    let (first, later) = starts.split_first()?;
    let (first, last, end) = (first.to_native(), starts.last()?.to_native(), u32::try_from(end).ok()?);
    let (mut shortest, mut longest, mut farthest) = (u32::MAX, 0, 0);
    // Both are at most `end`. Out of order, their difference wraps around to more than `end`.
    let mut take = |start: u32, end: u32| {
        let length = end.wrapping_sub(start);
        shortest = shortest.min(length);
        longest = longest.max(length);
        farthest = farthest.max(start);
    };
    for (start, end) in starts.iter().zip(later) {
        take(start.to_native(), end.to_native());
    }
    take(last, end);
    (first == 0 && farthest <= end && longest <= end).then_some((shortest, longest))
}

/// The first run that is shorter than `min_length`, out of order or out of range: its index, start
/// and end. The slow twin of [`run_lengths`].
#[cold]
fn first_bad_run(starts: &[u32_le], end: usize, min_length: u32) -> (usize, u32, u32) {
    let len = u32::try_from(end).unwrap_or(u32::MAX);
    let ends = starts.iter().skip(1).map(|start| start.to_native()).chain([len]);
    let runs: Vec<(u32, u32)> = starts.iter().map(|start| start.to_native()).zip(ends).collect();
    let is_bad = |i: usize, &(start, end): &(u32, u32)| {
        (i == 0 && start != 0) || end > len || end.checked_sub(start).is_none_or(|length| length < min_length)
    };
    let run = first(&runs, is_bad);
    let (start, end) = runs.get(run).copied().unwrap_or_default();
    (run, start, end)
}

#[expect(
    clippy::indexing_slicing,
    reason = "`structure` has checked that runs ascend and end where their sections end"
)]
fn run<T>(section: &[T], start: u32_le, end: u32_le) -> &[T] {
    &section[start.to_native() as usize..end.to_native() as usize]
}
