use std::path::Path;

use hullmap::Asset;

use crate::args::ReportArgs;
use hullmap_pipeline::outcome::{Exit, Failure};
use hullmap_pipeline::packs::PackPlace;
use hullmap_pipeline::source::{Folders, Recorded, Source, SourceSearch, find_source};

pub struct Sought {
    pub source: Option<Source>,
    /// Why it was not found, as the start of a sentence.
    pub absent: String,
}

/// Searches the source of a file. `folders` remembers the folders that were read for other files. A
/// source that does not match is a fault. Fails if `--source` leads to no file.
pub fn seek_source(
    place: &PackPlace,
    asset: &Asset,
    given: Option<&Path>,
    args: &ReportArgs,
    folders: &Folders,
    faults: &mut Vec<String>,
) -> Result<Sought, Failure> {
    let mut absent = "the source cannot be used, so".to_owned();
    let source = match find_source(place, Recorded::from_asset(asset), given, &args.limits.limits(), folders) {
        Ok(SourceSearch::Found(source)) => Some(*source),
        Ok(SourceSearch::Absent(why)) => {
            absent = why.map_or_else(|| "the source was not found, so".to_owned(), |why| format!("{why};"));
            None
        }
        Err(failure) if failure.exit == Exit::Rejected => {
            faults.push(failure.message);
            None
        }
        Err(failure) => return Err(failure),
    };
    Ok(Sought { source, absent })
}

/// The recorded path instead of an absolute one, which would name folders of this machine.
pub fn source_name(source: &Source, recorded: &str) -> String {
    if source.path.is_absolute() && !recorded.is_empty() {
        return recorded.to_owned();
    }
    source.path.display().to_string()
}
