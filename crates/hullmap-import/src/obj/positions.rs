//! Wavefront OBJ: the coordinates of the `v` lines, read by tobj as `f32` or parsed here as `f64`.
//!
//! tobj reports a vertex only where an element references it, and indexes each object's vertices by
//! first use. So each batch of `v` lines is followed by one `l` line that references all in order.
//!
//! tobj keeps about 200 bytes per vertex while it builds a model, so batches are small. It parses
//! `f32` in this build; its `f64` would round `f32` coordinates twice. [`VertexLine`] parses `f64`.

use std::io::Write as _;

use rayon::prelude::*;

use super::lines::{Lines, Part, Parts, is_vertex_line, with_words};
use super::vertex_line::VertexLine;
use crate::coordinate::{Coordinate, parse_coordinate};
use crate::fault::Fault;

/// Vertices that tobj reads at a time. They and their model fit the second-level cache.
const BATCH_VERTICES: usize = 1 << 12;

/// Longer words are parsed here before tobj gets a copy, so that junk is not copied several times.
const LONG_WORD_BYTES: usize = 1 << 10;

/// Read by tobj. The fault names no line, and need not be the first one: [`super::read`] finds
/// that. Complexity: O(bytes), in parallel.
pub fn singles(parts: &Parts) -> Result<Vec<[f32; 3]>, Fault> {
    fill(parts, |part, positions| {
        let mut batch = Batch::default();
        let mut batches = positions.chunks_mut(BATCH_VERTICES);
        for_each_vertex(part, |vertex| {
            batch.push(vertex)?;
            if batch.vertex_count == BATCH_VERTICES { batch.read(batches.next()) } else { Ok(()) }
        })?;
        if batch.vertex_count > 0 { batch.read(batches.next()) } else { Ok(()) }
    })
}

/// Positions of all `v` lines as `f64`. Fails as [`singles`]. Complexity: O(bytes), in parallel.
pub fn doubles(parts: &Parts) -> Result<Vec<[f64; 3]>, Fault> {
    fill(parts, |part, positions| {
        let mut positions = positions.iter_mut();
        for_each_vertex(part, |vertex| {
            if let Some(position) = positions.next() {
                *position = vertex.point()?;
            }
            Ok(())
        })
    })
}

/// Calls `read` for each part with the targets of its vertices: no list of positions exists twice.
fn fill<T: Coordinate>(
    parts: &Parts,
    read: impl Fn(&Part, &mut [[T; 3]]) -> Result<(), Fault> + Sync,
) -> Result<Vec<[T; 3]>, Fault> {
    let mut positions = vec![[T::ZERO; 3]; parts.vertex_count()];
    let mut targets = Vec::with_capacity(parts.parts.len());
    let mut rest = positions.as_mut_slice();
    for part in &parts.parts {
        let (own, tail) = rest.split_at_mut(part.vertex_count);
        targets.push((part, own));
        rest = tail;
    }
    targets.into_par_iter().try_for_each(|(part, targets)| read(part, targets))?;
    Ok(positions)
}

fn for_each_vertex(part: &Part, mut visit: impl FnMut(&VertexLine) -> Result<(), Fault>) -> Result<(), Fault> {
    let mut lines = Lines::new(part.text, part.first_line);
    while let Some((_, line)) = lines.next_logical() {
        if is_vertex_line(&line) {
            with_words!(&line, words => {
                words.next();
                visit(&VertexLine::new(words.take_while(|word| !word.starts_with('#')))?)
            })?;
        }
    }
    Ok(())
}

#[derive(Debug, Default)]
struct Batch {
    text: Vec<u8>,
    vertex_count: usize,
}

impl Batch {
    fn push(&mut self, vertex: &VertexLine) -> Result<(), Fault> {
        self.text.push(b'v');
        for word in vertex.words() {
            if word.len() > LONG_WORD_BYTES {
                parse_coordinate::<f32>(word)?;
            }
            self.text.push(b' ');
            self.text.extend_from_slice(word.as_bytes());
        }
        self.text.push(b'\n');
        self.vertex_count += 1;
        Ok(())
    }

    /// Has tobj read the batch, writes the positions to `targets`, and empties the batch.
    fn read(&mut self, targets: Option<&mut [[f32; 3]]>) -> Result<(), Fault> {
        self.text.push(b'l');
        for vertex in 1..=self.vertex_count {
            write!(self.text, " {vertex}").map_err(|_| Fault::Rejected(tobj::LoadError::ReadError))?;
        }
        let no_materials = |_: &std::path::Path| Ok(Default::default());
        let options = tobj::LoadOptions::default();
        let (models, _) =
            tobj::load_obj_buf(&mut self.text.as_slice(), &options, no_materials).map_err(Fault::Rejected)?;
        let positions = models.first().map(|model| model.mesh.positions.as_slice()).unwrap_or_default();
        let (points, _) = positions.as_chunks::<3>();
        // tobj accepts NaN and infinity, and rounds to infinity what is too large for f32.
        match targets {
            Some(targets) if targets.len() == points.len() && positions.iter().all(|x| x.is_finite()) => {
                targets.copy_from_slice(points);
            }
            _ => return Err(Fault::Rejected(tobj::LoadError::PositionParseError)),
        }
        self.text.clear();
        self.vertex_count = 0;
        Ok(())
    }
}
