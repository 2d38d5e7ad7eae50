//! Second reader: tobj reads the same words, and both must come to the same points.
//!
//! tobj gets a plain text in which byte order mark, continuations, remarks, materials, texture coordinates and normals
//! are resolved or gone, since it trips over them and no hull depends on them; the words of `v` lines, and the vertex
//! numbers of `f`, `l` and `p` lines, are the file's own. Its numbers, its vertex numbering and its resolution of
//! negative references are thus an independent reading. The text is made from the file line by line as tobj asks for
//! it.
//!
//! tobj keeps many times the bytes of an element until the object ends. So the text opens a new object every
//! [`CORNERS_AT_A_TIME`] corners, and long elements go on in a further line: what is compared is the sequence of
//! vertices.
//!
//! A large file is read by several tobj's side by side. Each gets all vertices, without which it could not resolve a
//! reference, and its share of the elements. One of them also references every vertex at the end, counted backwards, so
//! that all positions are compared, and so that it fails when tobj has counted fewer of them.

use std::io::{self, BufRead, Read, Write as _};
use std::ops::Range;

use rayon::prelude::*;

use super::lines::{Lines, with_words};
use super::scan::{Scan, text_of};
use crate::fault::Fault;
use crate::limits::CORNERS_AT_A_TIME;

/// Stands for a vertex that no element of an object has referenced yet.
const UNSEEN: u32 = u32::MAX;

/// Corners for which another reader pays: reading all vertices again must cost less than it saves.
const CORNERS_A_READER: usize = 1 << 20;

/// Most readers of the faces: each holds all vertices.
const MAX_READERS: usize = 4;

/// Corners on a line of the plain text.
const CORNERS_A_LINE: usize = 1 << 10;

/// Bytes of plain text that are made at a time.
const BLOCK_BYTES: usize = 1 << 16;

/// What one tobj reads, and what it must come to.
#[derive(Clone, Debug)]
struct Share<'a> {
    /// Whether it reads `f` lines; else it reads `l` and `p`.
    is_of_faces: bool,
    /// The elements that it reads, counted among those of its kind.
    elements: Range<usize>,
    /// Their vertices.
    references: &'a [u32],
    /// Whether it also references every vertex.
    has_positions: bool,
}

/// Compares the scan of `bytes` with what tobj reads.
///
/// # Errors
/// [`Fault::Refused`] when tobj does not accept the text, [`Fault::Disagreement`] when it reads another number of
/// vertices, another position (compared bit by bit) or another reference.
pub fn cross_check(scan: &Scan, bytes: &[u8]) -> Result<(), Fault> {
    let reader_count = rayon::current_num_threads().min(MAX_READERS);
    let checks: Vec<Result<(), Fault>> =
        shares(scan, reader_count).par_iter().map(|share| check(scan, bytes, share)).collect();
    checks.into_iter().collect()
}

/// Cuts the elements into shares; at most `reader_count` of them are of faces.
#[expect(
    clippy::indexing_slicing,
    reason = "bounds ascend, none is above the number of faces, and faces end within the corners"
)]
fn shares(scan: &Scan, reader_count: usize) -> Vec<Share<'_>> {
    let faces = &scan.faces;
    let count = (faces.corners.len() / CORNERS_A_READER).clamp(1, reader_count);
    let bound = |number: usize| number * faces.len() / count;
    let mut shares: Vec<Share> = (0..count)
        .map(|number| {
            let elements = bound(number)..bound(number + 1);
            let references = &faces.corners[faces.start(elements.start)..faces.start(elements.end)];
            Share { is_of_faces: true, elements, references, has_positions: number == 0 }
        })
        .collect();
    if !scan.loose.is_empty() {
        shares.push(Share {
            is_of_faces: false,
            elements: 0..usize::MAX,
            references: &scan.loose,
            has_positions: false,
        });
    }
    shares
}

fn check(scan: &Scan, bytes: &[u8], share: &Share) -> Result<(), Fault> {
    let options =
        tobj::LoadOptions { single_index: false, triangulate: false, ignore_points: false, ignore_lines: false };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let mut text = PlainText::new(bytes, share.clone(), scan.positions.len());
    let (models, _) = tobj::load_obj_buf(&mut text, &options, no_materials).map_err(Fault::Refused)?;
    compare(scan, share, &models)
}

/// tobj numbers the vertices of a model by their first appearance in an element; so does this, from the scan.
#[expect(
    clippy::indexing_slicing,
    reason = "what is looked up is the scan's own reference, and all those are in range"
)]
fn compare(scan: &Scan, share: &Share, models: &[tobj::Model]) -> Result<(), Fault> {
    let count = scan.positions.len();
    let all = if share.has_positions { 0..count as u32 } else { 0..0 };
    let expected = share.references.len() + all.len();
    let found: usize = models.iter().map(|model| model.mesh.indices.len()).sum();
    if found != expected {
        return Err(Fault::Disagreement(format!("{expected} references in one, {found} in the other")));
    }
    let mut references = share.references.iter().copied().chain(all);
    let mut order = vec![UNSEEN; count];
    let mut seen: Vec<u32> = Vec::new();
    for tobj::Model { mesh, .. } in models {
        for (&index, vertex) in mesh.indices.iter().zip(&mut references) {
            let place = &mut order[vertex as usize];
            if *place == UNSEEN {
                let ours = scan.positions[vertex as usize];
                let theirs = mesh.positions.get(3 * seen.len()..3 * seen.len() + 3).unwrap_or_default();
                *place = seen.len() as u32;
                seen.push(vertex);
                if theirs.len() != 3 || ours.iter().zip(theirs).any(|(a, b)| a.to_bits() != b.to_bits()) {
                    return Err(Fault::Disagreement(format!(
                        "vertex {} is {ours:?} in one and {theirs:?} in the other",
                        vertex + 1
                    )));
                }
            }
            if *place != index {
                return Err(Fault::Disagreement(format!(
                    "a reference to vertex {} is to another one in tobj",
                    vertex + 1
                )));
            }
        }
        if mesh.positions.len() != 3 * seen.len() {
            let theirs = mesh.positions.len() / 3;
            return Err(Fault::Disagreement(format!("{} vertices in one, {theirs} in the other", seen.len())));
        }
        for vertex in seen.drain(..) {
            order[vertex as usize] = UNSEEN;
        }
    }
    Ok(())
}

/// The text that one tobj reads.
struct PlainText<'a> {
    lines: Lines<'a>,
    share: Share<'a>,
    /// Number of the next element of the share's kind.
    element: usize,
    /// Corners since an object was opened.
    corners: usize,
    /// Vertices that the closing references have still to name, the next one counted from the end.
    to_name: usize,
    /// Text made and not yet read from `at` on.
    block: Vec<u8>,
    at: usize,
}

impl<'a> PlainText<'a> {
    fn new(bytes: &'a [u8], share: Share<'a>, vertex_count: usize) -> Self {
        let to_name = if share.has_positions { vertex_count } else { 0 };
        let lines = Lines::new(text_of(bytes), 1);
        Self { lines, share, element: 0, corners: 0, to_name, block: Vec::with_capacity(2 * BLOCK_BYTES), at: 0 }
    }

    /// Makes the next block of text; it stays empty at the end.
    fn make_block(&mut self) -> io::Result<()> {
        self.block.clear();
        self.at = 0;
        while self.block.len() < BLOCK_BYTES {
            if let Some((_, line)) = self.lines.next_logical() {
                with_words!(&line, words => match words.next() {
                    Some("v") => self.vertex(words.take_while(|word| !word.starts_with('#'))),
                    Some("f") if self.share.is_of_faces => {
                        self.element("f", words.take_while(|word| !word.starts_with('#')));
                    }
                    // tobj ignores `p`; as an `l` it reads the same references.
                    Some("l" | "p") if !self.share.is_of_faces => {
                        self.element("l", words.take_while(|word| !word.starts_with('#')));
                    }
                    _ => {}
                });
            } else if self.to_name > 0 {
                let line = self.to_name.min(CORNERS_A_LINE);
                self.block.push(b'l');
                for back in (self.to_name - line + 1..=self.to_name).rev() {
                    write!(self.block, " -{back}")?;
                }
                self.to_name -= line;
                self.end_line(line);
            } else {
                break;
            }
        }
        Ok(())
    }

    fn vertex<'w>(&mut self, words: impl Iterator<Item = &'w str>) {
        let mut numbers = [""; 4];
        let mut found = 0;
        for word in words {
            if let Some(slot) = numbers.get_mut(found) {
                *slot = word;
            }
            found += 1;
        }
        self.block.push(b'v');
        // A fourth number is a weight; the fourth of six is a colour.
        for word in numbers.iter().take(if found == 4 { 4 } else { 3 }) {
            self.block.push(b' ');
            self.block.extend_from_slice(word.as_bytes());
        }
        self.block.push(b'\n');
    }

    fn element<'w>(&mut self, keyword: &str, words: impl Iterator<Item = &'w str>) {
        let is_mine = self.share.elements.contains(&self.element);
        self.element += 1;
        if !is_mine {
            return;
        }
        let mut on_line = 0;
        for word in words {
            if on_line == CORNERS_A_LINE {
                self.end_line(on_line);
                on_line = 0;
            }
            if on_line == 0 {
                self.block.extend_from_slice(keyword.as_bytes());
            }
            self.block.push(b' ');
            self.block.extend_from_slice(word.split('/').next().unwrap_or_default().as_bytes());
            on_line += 1;
        }
        self.end_line(on_line);
    }

    fn end_line(&mut self, corners: usize) {
        self.block.push(b'\n');
        self.corners += corners;
        if self.corners >= CORNERS_AT_A_TIME {
            self.block.extend_from_slice(b"o\n");
            self.corners = 0;
        }
    }
}

impl Read for PlainText<'_> {
    fn read(&mut self, target: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(target)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for PlainText<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.block.len() {
            self.make_block()?;
        }
        Ok(self.block.get(self.at..).unwrap_or_default())
    }

    fn consume(&mut self, count: usize) {
        self.at += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::obj::scan::scan;

    const TEXT: &[u8] = b"v 0 0 0\nv 1 0 0\nl 1 -1\nv 0 1 0\nv 5 5 5\nf 3 1/7/7 2\nf -1 1 2 # x\n";

    fn read(text: &[u8]) -> Scan {
        scan(text, &Limits::DEFAULT).unwrap()
    }

    #[test]
    fn agreement_passes() {
        assert_eq!(cross_check(&read(TEXT), TEXT), Ok(()));
    }

    #[test]
    fn a_changed_position_is_found_even_unreferenced() {
        for vertex in 0..4 {
            let mut read = read(TEXT);
            read.positions[vertex][1] += 0.5;
            assert!(matches!(cross_check(&read, TEXT), Err(Fault::Disagreement(_))), "vertex {vertex}");
        }
    }

    #[test]
    fn a_negative_zero_is_not_a_zero() {
        let mut read = read(TEXT);
        read.positions[0][0] = -0.0;
        assert!(matches!(cross_check(&read, TEXT), Err(Fault::Disagreement(_))));
    }

    #[test]
    fn a_changed_reference_or_count_is_found() {
        let changes: [fn(&mut Scan); 5] = [
            |scan| scan.faces.corners[1] = 3,
            |scan| scan.loose[1] = 0,
            |scan| scan.positions.push([0.0; 3]),
            |scan| scan.loose.truncate(1),
            |scan| {
                scan.faces.corners.pop();
                *scan.faces.ends.last_mut().unwrap() -= 1;
            },
        ];
        for (number, change) in changes.iter().enumerate() {
            let mut read = read(TEXT);
            change(&mut read);
            let result = cross_check(&read, TEXT);
            assert!(matches!(result, Err(Fault::Disagreement(_) | Fault::Refused(_))), "{number}: {result:?}");
        }
    }

    /// Long elements, more corners than are handed over at a time, and several readers.
    #[test]
    fn shares_cover_every_element_once() {
        let count = 70_000;
        let mut text: String = (0..count).map(|i| format!("v {i} 0 0\n")).collect();
        text += "f";
        (1..=count).for_each(|i| text += &format!(" {i}"));
        text += "\n";
        (1..count - 1).for_each(|i| text += &format!("f {i} {} -{i}\np {i}\n", i + 1));
        let scan = read(text.as_bytes());
        for reader_count in [1, 2, 3] {
            let faces = &scan.faces;
            let bound = |number: usize| number * faces.len() / reader_count;
            let mut covered = 0;
            for number in 0..reader_count {
                let elements = bound(number)..bound(number + 1);
                let references = &faces.corners[faces.start(elements.start)..faces.start(elements.end)];
                covered += references.len();
                let share = Share { is_of_faces: true, elements, references, has_positions: number == 0 };
                assert_eq!(check(&scan, text.as_bytes(), &share), Ok(()), "{number} of {reader_count}");
            }
            assert_eq!(covered, faces.corners.len());
        }
        assert_eq!(cross_check(&scan, text.as_bytes()), Ok(()));
        let mut wrong = read(text.as_bytes());
        let last = wrong.faces.corners.len() - 1;
        wrong.faces.corners[last] -= 1;
        assert!(matches!(cross_check(&wrong, text.as_bytes()), Err(Fault::Disagreement(_))));
    }
}
