//! First reader: every `v` line and every vertex reference of an OBJ file, with line numbers.
//!
//! tobj reads OBJ files well but reports only the vertices that faces and lines reference, forgets their numbers and
//! has no line numbers in its errors. This scanner reads just what shapes a hull, so that errors can say where they
//! are and so that every hull vertex can be traced to its `v` line. `cross_check` has tobj read the same words.
//!
//! 1. Split the bytes at LF, CRLF or a lone CR; drop a UTF-8 byte order mark; join lines that end in `\`.
//! 2. `v`: three coordinates parsed as `f32`, divided by a fourth (w) where there is one; colours are skipped.
//! 3. `f`, `l`, `p`: references resolved to zero-based vertex numbers; negative ones count back from their line.
//! 4. `o` opens an object. Everything else (`vt`, `vn`, `g`, materials, …) does not shape a hull and is not checked.
//! 5. Positive references may point ahead; they are checked against the vertex count at the end.
//!
//! A large file is read in parts side by side: vertices and lines of each part are counted first, so that all parts
//! know where they stand. The result does not depend on how it is cut.
//!
//! Deviations from the OBJ text format, all of them harmless:
//! - a word that starts with `#` ends a `v`, `f`, `l` or `p` line (many writers put remarks there);
//! - comments and lines that hold names (`o`, `g`, `usemtl`, `mtllib`) never continue: Windows paths end in `\`;
//! - bytes that are not UTF-8 are tolerated wherever they are not part of a number;
//! - an `f` of one or two vertices counts as an element, as it does for tobj.

use rayon::prelude::*;

use super::lines::{Lines, parts, with_words};
use super::reference::resolve_reference;
use crate::coordinate::parse_coordinate;
use crate::fault::{Fault, LineFault, excerpt};
use crate::limits::Limits;
use crate::mesh::{Object, Polygons};

/// Bytes of a part: some milliseconds of work.
const PART_BYTES: usize = 4 << 20;

/// Everything in an OBJ file that can shape a hull.
#[derive(Debug, Default)]
pub struct Scan {
    /// Position of each `v` line, in file order, all finite.
    pub positions: Vec<[f32; 3]>,
    /// `f` elements: zero-based numbers of `v` lines, all in range.
    pub faces: Polygons,
    /// References of `l` and `p` elements, likewise.
    pub loose: Vec<u32>,
    /// Objects in file order; the first is what stands before any `o` line, with an empty name.
    pub objects: Vec<Object>,
    /// Whether there are more objects than the limit; those beyond it are joined to the last.
    pub has_too_many_objects: bool,
    /// Number of `g` lines.
    pub group_count: usize,
    /// Number of `f` lines with fewer than three vertices.
    pub short_face_count: usize,
    /// First line with a free-form curve or surface, which is not read as an element.
    pub free_form_line: Option<usize>,
    /// Vertices above what this part has read.
    vertices_before: usize,
    /// Most objects.
    object_limit: usize,
    /// Greatest reference, in range or not.
    greatest: u32,
}

/// The text of a file without its byte order mark.
pub fn text_of(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Reads the geometry of an OBJ file.
///
/// # Errors
/// The first fault in the file, with its line; references that are too large come after all others.
///
/// # Complexity
/// O(bytes), shared by the threads of the pool; memory a small multiple of the file.
pub fn scan(bytes: &[u8], limits: &Limits) -> Result<Scan, LineFault> {
    scan_in_parts(bytes, limits, PART_BYTES)
}

fn scan_in_parts(bytes: &[u8], limits: &Limits, part_bytes: usize) -> Result<Scan, LineFault> {
    let text = text_of(bytes);
    if text.starts_with(b"\xFF\xFE") || text.starts_with(b"\xFE\xFF") {
        return Err(Fault::Utf16.of_file());
    }
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::Empty.of_file());
    }
    let parts = parts(text, part_bytes);
    let counts: Vec<(usize, usize)> = if parts.len() > 1 {
        parts.par_iter().map(|part| count_vertices_and_lines(part)).collect()
    } else {
        vec![(0, 0)]
    };
    let mut starts = Vec::with_capacity(parts.len());
    let (mut vertices, mut lines) = (0, 0);
    for (vertex_count, line_count) in counts {
        starts.push((vertices, lines));
        vertices += vertex_count;
        lines += line_count;
    }
    if vertices > (u32::MAX - 1) as usize {
        return Err(Fault::TooManyVertices.of_file());
    }
    let read = |(part, (vertices, lines)): (&&[u8], (usize, usize))| {
        let mut scan = Scan { vertices_before: vertices, object_limit: limits.objects, ..Scan::default() };
        scan.read_part(part, lines + 1).map(|()| scan)
    };
    let mut whole = Scan {
        objects: vec![Object { name: String::new(), first_vertex: 0, first_face: 0, first_loose: 0 }],
        object_limit: limits.objects,
        ..Scan::default()
    };
    // Every part is read even where an earlier one fails: the first fault in the file counts, whoever finds one first.
    let scans: Vec<Result<Scan, LineFault>> = parts.par_iter().zip(starts).map(read).collect();
    if scans.len() > 1 {
        // Growing by doubling would hold the list twice at the end.
        let total = |len: fn(&Scan) -> usize| scans.iter().flatten().map(len).sum::<usize>();
        whole.positions.reserve_exact(total(|scan| scan.positions.len()));
        whole.faces.corners.reserve_exact(total(|scan| scan.faces.corners.len()));
        whole.faces.ends.reserve_exact(total(|scan| scan.faces.ends.len()));
        whole.loose.reserve_exact(total(|scan| scan.loose.len()));
    }
    for scan in scans {
        whole.append(scan?)?;
    }
    if whole.positions.is_empty() {
        return Err(Fault::NoVertices.of_file());
    }
    if whole.greatest as usize >= whole.positions.len() {
        return Err(first_out_of_range(text, whole.positions.len()));
    }
    Ok(whole)
}

/// Number of `v` lines, and of all lines.
fn count_vertices_and_lines(part: &[u8]) -> (usize, usize) {
    let mut lines = Lines::new(part, 1);
    let mut vertices = 0;
    while let Some((_, line)) = lines.next_logical() {
        if !is_other(&line) {
            vertices += usize::from(with_words!(&line, words => words.next() == Some("v")));
        }
    }
    (vertices, lines.number())
}

/// The commonest lines that shape no hull, told without cutting them into words.
fn is_other(line: &[u8]) -> bool {
    matches!(line, [b'v', b't' | b'n' | b'p', b' ' | b'\t', ..] | [b'#', ..])
}

impl Scan {
    fn read_part(&mut self, part: &[u8], first_line: usize) -> Result<(), LineFault> {
        let mut lines = Lines::new(part, first_line);
        while let Some((line, text)) = lines.next_logical() {
            if !is_other(&text) {
                self.read_line(line, &text).map_err(|fault| fault.at(line))?;
            }
        }
        Ok(())
    }

    fn read_line(&mut self, line: usize, text: &[u8]) -> Result<(), Fault> {
        with_words!(text, words => match words.next() {
            Some("v") => self.read_vertex(words.take_while(|word| !word.starts_with('#'))),
            Some("f") => self.read_face(words.take_while(|word| !word.starts_with('#'))),
            Some(keyword @ ("l" | "p")) => {
                self.read_loose(keyword, words.take_while(|word| !word.starts_with('#')))
            }
            Some("o") => {
                self.begin_object(text);
                Ok(())
            }
            Some("g") => {
                self.group_count += 1;
                Ok(())
            }
            Some("curv" | "surf") => {
                self.free_form_line.get_or_insert(line);
                Ok(())
            }
            _ => Ok(()),
        })
    }

    fn begin_object(&mut self, text: &[u8]) {
        let text = String::from_utf8_lossy(text);
        let name = text.trim_start()["o".len()..].trim().to_owned();
        if self.objects.len() > self.object_limit {
            self.has_too_many_objects = true;
            return;
        }
        self.objects.push(Object {
            name,
            first_vertex: self.positions.len() as u32,
            first_face: self.faces.len() as u32,
            first_loose: self.loose.len() as u32,
        });
    }

    fn read_vertex<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        if self.vertices_before + self.positions.len() >= (u32::MAX - 1) as usize {
            return Err(Fault::TooManyVertices);
        }
        let (numbers, found) = first_words(words);
        let mut position = [0.0; 3];
        for (coordinate, word) in position.iter_mut().zip(numbers.iter().take(found)) {
            *coordinate = parse_coordinate::<f32>(word)?;
        }
        match found {
            0..3 => return Err(Fault::TooFewCoordinates { found }),
            3 | 6 => {}
            4 => {
                let w = parse_coordinate::<f32>(numbers[3])?;
                if w == 0.0 {
                    return Err(Fault::ZeroWeight);
                }
                for (coordinate, word) in position.iter_mut().zip(&numbers) {
                    *coordinate /= w;
                    if !coordinate.is_finite() {
                        return Err(Fault::Overflow { text: excerpt(&format!("{word} / {w}")) });
                    }
                }
            }
            _ => return Err(Fault::CoordinateCount { found }),
        }
        self.positions.push(position);
        Ok(())
    }

    fn read_face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let declared = self.vertices_before + self.positions.len();
        let start = self.faces.corners.len();
        for word in words {
            let vertex = resolve_reference(word, declared)?;
            self.greatest = self.greatest.max(vertex);
            self.faces.corners.push(vertex);
        }
        match self.faces.corners.len() - start {
            0 => return Err(Fault::NoReferences { keyword: "f".to_owned() }),
            1 | 2 => self.short_face_count += 1,
            _ => {}
        }
        if self.faces.corners.len() > u32::MAX as usize {
            return Err(Fault::TooManyReferences);
        }
        self.faces.end();
        Ok(())
    }

    fn read_loose<'a>(&mut self, keyword: &str, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let declared = self.vertices_before + self.positions.len();
        let start = self.loose.len();
        for word in words {
            let vertex = resolve_reference(word, declared)?;
            self.greatest = self.greatest.max(vertex);
            self.loose.push(vertex);
        }
        if self.loose.len() == start {
            return Err(Fault::NoReferences { keyword: keyword.to_owned() });
        }
        if self.loose.len() > u32::MAX as usize {
            return Err(Fault::TooManyReferences);
        }
        Ok(())
    }

    /// Adds what the part behind this one has.
    fn append(&mut self, part: Scan) -> Result<(), LineFault> {
        let (vertices, faces, loose) = (self.positions.len(), self.faces.len(), self.loose.len());
        let corners = self.faces.corners.len();
        let is_too_long = |count: usize| count > u32::MAX as usize;
        if is_too_long(corners + part.faces.corners.len()) || is_too_long(loose + part.loose.len()) {
            return Err(Fault::TooManyReferences.of_file());
        }
        for object in part.objects {
            if self.objects.len() > self.object_limit {
                self.has_too_many_objects = true;
                break;
            }
            self.objects.push(Object {
                name: object.name,
                first_vertex: object.first_vertex + vertices as u32,
                first_face: object.first_face + faces as u32,
                first_loose: object.first_loose + loose as u32,
            });
        }
        self.has_too_many_objects |= part.has_too_many_objects;
        if vertices + faces + loose == 0 {
            // The first part, usually the only one, is taken as it is.
            (self.positions, self.faces, self.loose) = (part.positions, part.faces, part.loose);
        } else {
            self.positions.extend(part.positions);
            self.faces.corners.extend(part.faces.corners);
            self.faces.ends.extend(part.faces.ends.iter().map(|end| end + corners as u32));
            self.loose.extend(part.loose);
        }
        self.group_count += part.group_count;
        self.short_face_count += part.short_face_count;
        self.free_form_line = self.free_form_line.or(part.free_form_line);
        self.greatest = self.greatest.max(part.greatest);
        Ok(())
    }
}

/// The positions of all `v` lines again, with the digits of f64, of a text that has been scanned without fault.
///
/// # Errors
/// A weight whose f64 is zero, or a quotient that is not finite.
///
/// # Complexity
/// O(bytes), shared by the threads of the pool.
pub fn doubles(bytes: &[u8]) -> Result<Vec<[f64; 3]>, LineFault> {
    let parts = parts(text_of(bytes), PART_BYTES);
    let counts: Vec<usize> = parts.par_iter().map(|part| count_vertices_and_lines(part).0).collect();
    let mut all = vec![[0.0; 3]; counts.iter().sum()];
    // Each part writes where its vertices belong, so that no list is there twice.
    let mut places = Vec::with_capacity(parts.len());
    let mut rest = all.as_mut_slice();
    for count in counts {
        let (place, tail) = rest.split_at_mut(count);
        places.push(place);
        rest = tail;
    }
    let read = |(part, place): (&&[u8], &mut [[f64; 3]])| -> Result<(), Fault> {
        let mut places = place.iter_mut();
        let mut lines = Lines::new(part, 1);
        while let Some((_, line)) = lines.next_logical() {
            if is_other(&line) {
                continue;
            }
            with_words!(&line, words => if words.next() == Some("v")
                && let Some(place) = places.next()
            {
                *place = double(words.take_while(|word| !word.starts_with('#')))?;
            });
        }
        Ok(())
    };
    let results: Vec<Result<(), Fault>> = parts.par_iter().zip(places).map(read).collect();
    results.into_iter().collect::<Result<(), Fault>>().map_err(Fault::of_file)?;
    Ok(all)
}

fn double<'a>(words: impl Iterator<Item = &'a str>) -> Result<[f64; 3], Fault> {
    let (numbers, found) = first_words(words);
    let weight = if found == 4 { parse_coordinate::<f64>(numbers[3])? } else { 1.0 };
    let mut position = [0.0; 3];
    for (coordinate, word) in position.iter_mut().zip(&numbers) {
        *coordinate = parse_coordinate::<f64>(word)? / weight;
        if !coordinate.is_finite() {
            return Err(Fault::Overflow { text: excerpt(&format!("{word} / {weight}")) });
        }
    }
    Ok(position)
}

/// The first four words, and how many there are.
fn first_words<'a>(words: impl Iterator<Item = &'a str>) -> ([&'a str; 4], usize) {
    let mut first = [""; 4];
    let mut found = 0;
    for word in words {
        if let Some(slot) = first.get_mut(found) {
            *slot = word;
        }
        found += 1;
    }
    (first, found)
}

/// Reads the elements again for the first reference that is too large.
fn first_out_of_range(text: &[u8], count: usize) -> LineFault {
    let mut lines = Lines::new(text, 1);
    let mut declared = 0;
    while let Some((line, text)) = lines.next_logical() {
        let found = with_words!(&text, words => match words.next() {
            Some("v") => {
                declared += 1;
                None
            }
            Some("f" | "l" | "p") => words
                .take_while(|word| !word.starts_with('#'))
                .filter_map(|word| resolve_reference(word, declared).ok())
                .find(|&vertex| vertex as usize >= count),
            _ => None,
        });
        if let Some(vertex) = found {
            return Fault::IndexTooLarge { number: u64::from(vertex) + 1, count }.at(line);
        }
    }
    Fault::Disagreement("a reference is out of range, but not when read again".to_owned()).of_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with all that may depend on where it is cut: negative references, references ahead, objects, faults.
    fn text(fault: &str) -> String {
        let mut text = String::from("f 1 3 2\n");
        for i in 0..40 {
            text += &format!("o part {i}\nv {i} 0.1 2\nv 1 {i} -3e-5 2\nv 0 0 {i}\ng x\nf -1 -2 -3\nl -1 1\n");
            text += "f 1 2 \\\n 3 1\n\np 2 # remark\n";
            if i == 25 {
                text += fault;
            }
        }
        text
    }

    #[test]
    fn parts_are_read_as_the_whole_is() {
        let limits = Limits::DEFAULT;
        for fault in ["", "f 1 0\n", "f 900 1\n", "v 1 2\n", "l\n", "f -400\n", "surf 1\n"] {
            let text = text(fault);
            let outline = |scan: Result<Scan, LineFault>| match scan {
                Ok(s) => {
                    Ok(format!("{:?}", (s.positions, s.faces, s.loose, s.objects, s.group_count, s.free_form_line)))
                }
                Err(error) => Err((error.line, error.fault.to_string())),
            };
            let whole = outline(scan_in_parts(text.as_bytes(), &limits, usize::MAX));
            for size in [1, 7, 64, 500] {
                assert_eq!(outline(scan_in_parts(text.as_bytes(), &limits, size)), whole, "{fault} in {size}");
            }
        }
    }

    #[test]
    fn doubles_round_to_the_floats() {
        let text = text("v 3 6 9 0.3\n");
        let scan = scan(text.as_bytes(), &Limits::DEFAULT).unwrap();
        let doubles = doubles(text.as_bytes()).unwrap();
        assert_eq!(doubles.len(), scan.positions.len());
        let mut weighted_count = 0;
        for (double, single) in doubles.iter().zip(&scan.positions) {
            let rounded = double.map(|x| x as f32);
            // Quotients of floats are rounded twice.
            let is_weighted = rounded != *single;
            weighted_count += usize::from(is_weighted);
            assert!(rounded.iter().zip(single).all(|(a, b)| (a - b).abs() <= 2e-7 * b.abs()), "{double:?} {single:?}");
        }
        assert!(weighted_count <= 41, "{weighted_count}");
        assert!(doubles.iter().any(|v| v[1] == 0.1));
    }

    #[test]
    fn objects_beyond_the_limit_are_joined() {
        let limits = Limits { objects: 3, ..Limits::DEFAULT };
        for size in [1, 64, usize::MAX] {
            let scan = scan_in_parts(text("").as_bytes(), &limits, size).unwrap();
            assert!(scan.has_too_many_objects && scan.objects.len() == 4, "{size}");
        }
    }
}
