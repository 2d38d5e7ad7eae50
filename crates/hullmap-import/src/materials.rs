//! Materials of the faces of a file: their names, and runs of consecutive faces with the same one.

/// Materials of the faces, each as a number. The number 0 stands for no material.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Materials {
    names: Vec<String>,
    /// First face of each run, and its number. Faces ascend, and consecutive numbers differ.
    runs: Vec<(u32, u32)>,
    unknown_count: usize,
}

impl Materials {
    /// Names of the materials from number 1 on. A name may be empty.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether no face has a material.
    pub fn is_empty(&self) -> bool {
        self.runs.iter().all(|(_, number)| *number == 0)
    }

    /// Number of references to materials that the file does not have. Their faces have none.
    pub fn unknown_count(&self) -> usize {
        self.unknown_count
    }

    /// Material of each triangle, in the order of
    /// [`Polygons::triangles`](crate::Polygons::triangles); empty without materials. `ends` are the
    /// ends of all faces of the file. `None` if a number exceeds 65,535.
    pub fn of_triangles(&self, ends: &[u32]) -> Option<Vec<u16>> {
        if self.is_empty() {
            return Some(Vec::new());
        }
        let corners = ends.last().map_or(0, |end| *end as usize);
        let mut materials = Vec::with_capacity(corners.saturating_sub(2 * ends.len()));
        let mut runs = self.runs.iter().peekable();
        let (mut number, mut start) = (0, 0);
        for (face, &end) in (0_u32..).zip(ends) {
            while let Some((_, next)) = runs.next_if(|(first, _)| *first <= face) {
                number = u16::try_from(*next).ok()?;
            }
            // A polygon of n corners has n - 2 triangles.
            let count = (end as usize - start).saturating_sub(2);
            materials.extend(std::iter::repeat_n(number, count));
            start = end as usize;
        }
        Some(materials)
    }

    /// Materials of faces that a file numbers itself, with these names.
    pub(crate) fn with_names(names: Vec<String>) -> Self {
        Self { names, ..Self::default() }
    }

    /// The faces from `face` on have the material with this number, or none with 0.
    pub(crate) fn begin(&mut self, face: usize, number: u32) {
        if self.runs.last().is_some_and(|(first, _)| *first as usize == face) {
            self.runs.pop();
        }
        let last = self.runs.last().map_or(0, |(_, number)| *number);
        if last != number {
            self.runs.push((face as u32, number));
        }
    }

    /// The faces from `face` on have the material with this index in the file, if it has one.
    pub(crate) fn begin_index(&mut self, face: usize, index: Option<u32>) {
        let is_known = |index: &u32| (*index as usize) < self.names.len();
        let number = index.filter(is_known).map_or(0, |index| index + 1);
        self.unknown_count += usize::from(index.is_some() && number == 0);
        self.begin(face, number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_without_faces_leave_no_trace() {
        let mut materials = Materials::with_names(vec!["a".to_owned(), "b".to_owned()]);
        for (face, index) in [(0, Some(0)), (0, Some(1)), (2, Some(1)), (3, None), (3, Some(1)), (4, Some(7))] {
            materials.begin_index(face, index);
        }
        assert_eq!(materials.runs, [(0, 2), (4, 0)]);
        assert_eq!(materials.unknown_count(), 1);
        let ends = [3, 4, 8, 11, 14];
        assert_eq!(materials.of_triangles(&ends), Some(vec![2, 2, 2, 2, 0]));
        assert_eq!(Materials::default().of_triangles(&ends), Some(vec![]));
        materials.begin(4, 65_536);
        assert_eq!(materials.of_triangles(&ends), None);
    }
}
