//! Wavefront OBJ: materials by the names on `usemtl` lines, numbered by their first appearance.

use std::collections::HashMap;

use crate::materials::Materials;

#[derive(Debug, Default)]
pub struct NamedMaterials {
    numbers: HashMap<String, u32>,
    /// First face of each run, and the number of its material; 0 without a name.
    runs: Vec<(usize, u32)>,
}

impl NamedMaterials {
    /// The faces from `face` on have the material with this name, or none if it is empty.
    pub fn begin(&mut self, face: usize, name: &str) {
        let next = self.numbers.len() as u32 + 1;
        let number = match self.numbers.get(name) {
            _ if name.is_empty() => 0,
            Some(number) => *number,
            None => *self.numbers.entry(name.to_owned()).or_insert(next),
        };
        self.runs.push((face, number));
    }

    /// Appends the materials of the next part of the file, before which there are `faces` faces.
    pub fn append(&mut self, part: Self, faces: usize) {
        if self.runs.is_empty() && faces == 0 {
            *self = part;
            return;
        }
        let names = by_number(part.numbers);
        for (face, number) in part.runs {
            let name = (number as usize).checked_sub(1).and_then(|at| names.get(at));
            self.begin(face + faces, name.map_or("", String::as_str));
        }
    }

    pub fn finish(self) -> Materials {
        let mut materials = Materials::with_names(by_number(self.numbers));
        for (face, number) in self.runs {
            materials.begin(face, number);
        }
        materials
    }
}

fn by_number(numbers: HashMap<String, u32>) -> Vec<String> {
    let mut names: Vec<(u32, String)> = numbers.into_iter().map(|(name, number)| (number, name)).collect();
    names.sort_unstable();
    names.into_iter().map(|(_, name)| name).collect()
}
