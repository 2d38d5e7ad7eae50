//! Second reader: tobj reads the same words, and both must come to the same points.
//!
//! tobj gets a plain text in which byte order mark, continuations, remarks, materials and texture coordinates are
//! resolved or gone, since it trips over them and no hull depends on them; the words of `v`, `f`, `l` and `p` lines
//! are the file's own. Its numbers, its vertex numbering and its resolution of negative references are thus an
//! independent reading. The text's last element references every vertex, so that all positions are compared.

use super::fault::Fault;
use super::scan::Scan;

/// Stands for a vertex that no element has referenced yet.
const UNSEEN: u32 = u32::MAX;

/// Compares the scan with what tobj reads.
///
/// # Errors
/// [`Fault::Refused`] when tobj does not accept the text, [`Fault::Disagreement`] when it reads another number of
/// vertices, another position (compared bit by bit) or another reference.
pub fn cross_check(scan: &Scan) -> Result<(), Fault> {
    let options =
        tobj::LoadOptions { single_index: false, triangulate: false, ignore_points: false, ignore_lines: false };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(&mut scan.plain_text.as_bytes(), &options, no_materials).map_err(Fault::Refused)?;
    let [model] = models.as_slice() else {
        return Err(Fault::Disagreement(format!("tobj found {} models in a text of one", models.len())));
    };
    compare(scan, &model.mesh.positions, &model.mesh.indices)
}

/// tobj numbers the vertices of a model by their first appearance in an element; so does this, from the scan.
fn compare(scan: &Scan, positions: &[f32], indices: &[u32]) -> Result<(), Fault> {
    let count = scan.positions.len();
    if positions.len() != 3 * count {
        let theirs = positions.len() / 3;
        return Err(Fault::Disagreement(format!("{count} vertices in one, {theirs} in the other")));
    }
    let references = scan.references.iter().copied().chain(0..count as u32);
    if indices.len() != scan.references.len() + count {
        let (ours, theirs) = (scan.references.len(), indices.len().saturating_sub(count));
        return Err(Fault::Disagreement(format!("{ours} references in one, {theirs} in the other")));
    }
    let mut order = vec![UNSEEN; count];
    let mut seen = 0;
    for (reference, &index) in references.zip(indices) {
        let vertex = reference as usize;
        if order[vertex] == UNSEEN {
            order[vertex] = seen;
            let theirs = &positions[3 * seen as usize..][..3];
            let ours = scan.positions[vertex];
            seen += 1;
            if ours.iter().zip(theirs).any(|(a, b)| a.to_bits() != b.to_bits()) {
                return Err(Fault::Disagreement(format!(
                    "vertex {} is {ours:?} in one and {theirs:?} in the other",
                    vertex + 1
                )));
            }
        }
        if order[vertex] != index {
            return Err(Fault::Disagreement(format!("a reference to vertex {} is to another one in tobj", vertex + 1)));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::scan::scan;

    const TEXT: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 3 1 2\n";

    #[test]
    fn agreement_passes() {
        assert_eq!(cross_check(&scan(TEXT).unwrap()), Ok(()));
    }

    #[test]
    fn a_changed_position_is_found_even_unreferenced() {
        for vertex in 0..4 {
            let mut read = scan(TEXT).unwrap();
            read.positions[vertex][1] += 0.5;
            assert!(matches!(cross_check(&read), Err(Fault::Disagreement(_))), "vertex {vertex}");
        }
    }

    #[test]
    fn a_negative_zero_is_not_a_zero() {
        let mut read = scan(TEXT).unwrap();
        read.positions[0][0] = -0.0;
        assert!(matches!(cross_check(&read), Err(Fault::Disagreement(_))));
    }

    #[test]
    fn a_changed_reference_or_count_is_found() {
        let mut read = scan(TEXT).unwrap();
        read.references[1] = 3;
        assert!(matches!(cross_check(&read), Err(Fault::Disagreement(_))));
        let mut read = scan(TEXT).unwrap();
        read.positions.push([0.0; 3]);
        assert!(matches!(cross_check(&read), Err(Fault::Disagreement(_))));
        let mut read = scan(TEXT).unwrap();
        read.references.pop();
        assert!(matches!(cross_check(&read), Err(Fault::Disagreement(_))));
    }
}
