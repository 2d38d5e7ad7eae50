//! Models that a model attaches: the files that they need. MuJoCo reads an attached model by
//! itself, from its own folder by its own `compiler`. Its collisions are left alone.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::description::{Description, Reference};
use crate::error::RobotError;
use crate::places::plain;

const MAX_MODELS: usize = 1000;

/// Adds files of attached models, and of the models that they attach in turn. `read` returns a
/// model and the files of its attached models. A model that cannot be read is a warning.
pub fn add_references(
    description: &mut Description,
    mut waiting: Vec<Reference>,
    read: impl Fn(&Path) -> Result<(Description, Vec<Reference>), RobotError>,
) {
    let mut seen: BTreeSet<PathBuf> = BTreeSet::new();
    let mut found: BTreeSet<Reference> = std::mem::take(&mut description.references).into_iter().collect();
    while let Some(model) = waiting.pop() {
        let real = model.file.canonicalize().unwrap_or_else(|_| model.file.clone());
        if seen.len() >= MAX_MODELS || !seen.insert(real) {
            continue;
        }
        let (own, attached) = match read(&model.file) {
            Ok(own) => own,
            Err(error) => {
                let message = "so the files that this attached model needs are not copied; correct it";
                description.warnings.push(format!("{error}, {message}"));
                continue;
            }
        };
        let below = model.path.parent().unwrap_or(Path::new(""));
        // The edited model may or may not still name them: nothing is searched.
        let moved = |own: Reference| Reference { path: plain(&below.join(&own.path)), written: String::new(), ..own };
        found.extend(own.references.into_iter().map(moved));
        waiting.extend(attached.into_iter().map(moved));
    }
    description.references = found.into_iter().collect();
}
