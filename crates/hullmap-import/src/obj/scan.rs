//! Wavefront OBJ: elements, objects and counts, with the line of every fault.
//!
//! 1. Split the text into logical lines, see [`super::lines`].
//! 2. `v`: count the numbers, and look for weights. [`super::positions`] reads the coordinates; a
//!    [`VertexCheck`] can parse them here too.
//! 3. `f`, `l`, `p`: resolve the references to zero-based vertex indices. Negative ones count back
//!    from their line.
//! 4. `o` starts an object, and `usemtl` a run of faces with a material. Everything else (`vt`,
//!    `vn`, `g`, …) has no effect on a hull and is not checked.
//! 5. Positive references may point ahead, so they are compared with the vertex count at the end.
//!
//! A large file is scanned in parts, in parallel. The result does not depend on where it is cut.
//!
//! # Deviations
//! Other readers accept such files, too:
//! - a word that starts with `#` ends a `v`, `f`, `l` or `p` line, where many writers put comments;
//! - comments and lines that hold names (`o`, `g`, `usemtl`, `mtllib`) never continue, since
//!   Windows paths end in `\`;
//! - bytes that are not UTF-8 are accepted except in numbers;
//! - an `f` line of one or two vertices is an element, as it is for tobj;
//! - the weight w of `v x y z w` is ignored. It belongs to rational curves and surfaces, which are
//!   not read. Most readers of polygons ignore it, and exporters write anything there.

use rayon::prelude::*;

use super::lines::{Lines, Part, Parts, is_irrelevant, is_vertex_line, with_words};
use super::named_materials::NamedMaterials;
use super::reference::resolve_reference;
use super::vertex_line::VertexLine;
use crate::fault::{Fault, LineFault, excerpt};
use crate::limits::Limits;
use crate::mesh::{Polygons, SourceObject};

pub type VertexCheck = fn(&VertexLine) -> Result<(), Fault>;

/// Everything in an OBJ file that shapes a hull, except coordinates.
#[derive(Debug, Default)]
pub struct Scan {
    pub vertex_count: usize,
    /// `f` elements: zero-based vertex indices, all in range.
    pub faces: Polygons,
    pub materials: NamedMaterials,
    /// References of `l` and `p` elements: zero-based vertex indices, all in range.
    pub loose: Vec<u32>,
    /// Objects in file order. The first holds what precedes any `o` line, and has an empty name.
    pub objects: Vec<SourceObject>,
    /// Whether the file has more objects than the limit. The rest then belong to the last object.
    pub has_too_many_objects: bool,
    pub group_count: usize,
    /// Number of `f` lines with fewer than three vertices.
    pub short_face_count: usize,
    /// First line with a free-form curve or surface. These are not read.
    pub free_form_line: Option<usize>,
    /// Number of `v` lines with a weight other than 1, which is ignored.
    pub weight_count: usize,
    pub weight_line: Option<usize>,
    /// Number of `v` lines before this part of the file.
    vertices_before: usize,
    object_limit: usize,
    /// Largest reference, in range or not.
    largest_reference: u32,
}

/// Scans an OBJ file and calls `check` for each `v` line. The error is the first fault in the file,
/// with its line. References beyond the last vertex are found after all other faults. Complexity:
/// O(bytes), in parallel. Memory is at most 4 bytes a reference and 4 a face, twice.
pub fn scan(parts: &Parts, limits: &Limits, check: VertexCheck) -> Result<Scan, LineFault> {
    // The first fault in the file is reported, so every part is scanned.
    let scans: Vec<Result<Scan, LineFault>> =
        parts.parts.par_iter().map(|part| Scan::of_part(part, limits, check)).collect();
    let mut whole = Scan {
        objects: vec![SourceObject { name: String::new(), first_vertex: 0, first_face: 0, first_loose: 0 }],
        object_limit: limits.objects,
        ..Scan::default()
    };
    if scans.len() > 1 {
        // A list that grows by doubling would exist twice at the end.
        let total = |len: fn(&Scan) -> usize| scans.iter().flatten().map(len).sum::<usize>();
        whole.faces.corners.reserve_exact(total(|scan| scan.faces.corners.len()));
        whole.faces.ends.reserve_exact(total(|scan| scan.faces.ends.len()));
        whole.loose.reserve_exact(total(|scan| scan.loose.len()));
    }
    for scan in scans {
        whole.append(scan?)?;
    }
    if whole.vertex_count == 0 {
        return Err(Fault::NoVertices.of_file());
    }
    if whole.largest_reference as usize >= whole.vertex_count {
        return Err(first_out_of_range(parts.text, &whole));
    }
    Ok(whole)
}

impl Scan {
    fn of_part(part: &Part, limits: &Limits, check: VertexCheck) -> Result<Self, LineFault> {
        let mut scan = Self { vertices_before: part.first_vertex, object_limit: limits.objects, ..Self::default() };
        let mut lines = Lines::new(part.text, part.first_line);
        while let Some((line, text)) = lines.next_logical() {
            if !is_irrelevant(&text) {
                scan.read_line(line, &text, check).map_err(|fault| fault.at_line(line))?;
            }
        }
        Ok(scan)
    }

    fn read_line(&mut self, line: usize, text: &[u8], check: VertexCheck) -> Result<(), Fault> {
        with_words!(text, words => match words.next() {
            Some("v") => {
                self.vertex_count += 1;
                let vertex = VertexLine::new(words.take_while(|word| !word.starts_with('#')))?;
                check(&vertex)?;
                if vertex.has_ignored_weight()? {
                    self.weight_count += 1;
                    self.weight_line.get_or_insert(line);
                }
                Ok(())
            }
            Some("f") => self.read_face(words.take_while(|word| !word.starts_with('#'))),
            Some(keyword @ ("l" | "p")) => {
                self.read_loose(keyword, words.take_while(|word| !word.starts_with('#')))
            }
            Some("o") => {
                self.begin_object(text);
                Ok(())
            }
            Some("usemtl") => {
                self.materials.begin(self.faces.len(), &argument(text, "usemtl"));
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
        if self.objects.len() > self.object_limit {
            self.has_too_many_objects = true;
            return;
        }
        self.objects.push(SourceObject {
            name: argument(text, "o"),
            first_vertex: self.vertex_count as u32,
            first_face: self.faces.len() as u32,
            first_loose: self.loose.len() as u32,
        });
    }

    fn read_face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let declared = self.vertices_before + self.vertex_count;
        let start = self.faces.corners.len();
        for word in words {
            let vertex = resolve_reference(word, declared)?;
            self.largest_reference = self.largest_reference.max(vertex);
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
        let declared = self.vertices_before + self.vertex_count;
        let start = self.loose.len();
        for word in words {
            let vertex = resolve_reference(word, declared)?;
            self.largest_reference = self.largest_reference.max(vertex);
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

    fn append(&mut self, part: Scan) -> Result<(), LineFault> {
        let (vertices, faces, loose) = (self.vertex_count, self.faces.len(), self.loose.len());
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
            self.objects.push(SourceObject {
                name: object.name,
                first_vertex: object.first_vertex + vertices as u32,
                first_face: object.first_face + faces as u32,
                first_loose: object.first_loose + loose as u32,
            });
        }
        self.has_too_many_objects |= part.has_too_many_objects;
        self.vertex_count += part.vertex_count;
        if self.faces.corners.capacity() + self.loose.capacity() == 0 {
            // Nothing is reserved: this part is the first with elements, and usually the only one.
            (self.faces, self.loose) = (part.faces, part.loose);
        } else {
            self.faces.corners.extend(part.faces.corners);
            self.faces.ends.extend(part.faces.ends.iter().map(|end| end + corners as u32));
            self.loose.extend(part.loose);
        }
        self.materials.append(part.materials, faces);
        self.group_count += part.group_count;
        self.short_face_count += part.short_face_count;
        self.free_form_line = self.free_form_line.or(part.free_form_line);
        self.weight_count += part.weight_count;
        self.weight_line = self.weight_line.or(part.weight_line);
        self.largest_reference = self.largest_reference.max(part.largest_reference);
        Ok(())
    }
}

/// The rest of a line after its keyword, which may have blanks.
fn argument(line: &[u8], keyword: &str) -> String {
    let line = String::from_utf8_lossy(line);
    let line = line.trim_start();
    line.strip_prefix(keyword).unwrap_or(line).trim().to_owned()
}

fn first_out_of_range(text: &[u8], scan: &Scan) -> LineFault {
    let count = scan.vertex_count;
    let mut lines = Lines::new(text, 1);
    let mut declared = 0;
    while let Some((line, text)) = lines.next_logical() {
        if is_vertex_line(&text) {
            declared += 1;
            continue;
        }
        let found = with_words!(&text, words => match words.next() {
            Some("f" | "l" | "p") => words
                .take_while(|word| !word.starts_with('#'))
                .find(|word| resolve_reference(word, declared).is_ok_and(|vertex| vertex as usize >= count))
                .map(|word| excerpt(word.split('/').next().unwrap_or_default())),
            _ => None,
        });
        if let Some(text) = found {
            return Fault::IndexTooLarge { text, count }.at_line(line);
        }
    }
    Fault::IndexTooLarge { text: (u64::from(scan.largest_reference) + 1).to_string(), count }.of_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything that may depend on the cuts.
    fn text(fault: &str) -> String {
        let mut text = String::from("f 1 3 2\n");
        for i in 0..40 {
            text += &format!(
                "o part {i}\nusemtl m {}\nv {i} 0.1 2\nv 1 {i} -3e-5 2\nv 0 0 {i}\ng x\nf -1 -2 -3\nl -1 1\n",
                i % 7
            );
            text += "f 1 2 \\\n 3 1\n\np 2 # remark\n";
            if i == 25 {
                text += fault;
            }
        }
        text
    }

    fn scan_in_parts(text: &str, limits: &Limits, part_bytes: usize) -> Result<Scan, LineFault> {
        let parts = Parts::new(text.as_bytes(), part_bytes).unwrap();
        scan(&parts, limits, |vertex| vertex.point::<f32>().map(drop))
    }

    #[test]
    fn the_result_does_not_depend_on_the_parts() {
        for fault in ["", "f 1 0\n", "f 900 1\n", "v 1 2\n", "v 1 2 x\n", "l\n", "f -400\n", "surf 1\n"] {
            let text = text(fault);
            let outline = |scan: Result<Scan, LineFault>| match scan {
                Ok(s) => Ok(format!(
                    "{:?}",
                    (
                        s.vertex_count,
                        s.faces,
                        s.loose,
                        s.objects,
                        s.materials.finish(),
                        s.group_count,
                        s.free_form_line,
                        s.weight_line
                    )
                )),
                Err(error) => Err((error.line, error.fault.to_string())),
            };
            let whole = outline(scan_in_parts(&text, &Limits::DEFAULT, usize::MAX));
            for size in [1, 7, 64, 500] {
                assert_eq!(outline(scan_in_parts(&text, &Limits::DEFAULT, size)), whole, "{fault} in {size}");
            }
        }
    }

    #[test]
    fn objects_beyond_the_limit_join_the_last_one() {
        let limits = Limits { objects: 3, ..Limits::DEFAULT };
        for size in [1, 64, usize::MAX] {
            let scan = scan_in_parts(&text(""), &limits, size).unwrap();
            assert!(scan.has_too_many_objects && scan.objects.len() == 4, "{size}");
        }
    }
}
