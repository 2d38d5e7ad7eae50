use std::path::Path;

use hullmap::Asset;
use hullmap_import::{UpAxis, is_in_metres, is_y_up};
use hullmap_report::input::{Frame, Up};

use crate::args::ReportArgs;
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::{Exit, Failure};
use hullmap_pipeline::packs::PackPlace;
use hullmap_pipeline::source::{Folders, Recorded, Source, SourceSearch, find_source};

pub struct FoundSource {
    pub source: Option<Source>,
    /// Why it was not found, as the start of a sentence.
    pub absent: String,
}

/// Searches the source of a file. `folders` remembers the folders that were read for other files. A
/// source that does not match is a fault. Fails if `--source` leads to no file.
pub fn source_of(
    place: &PackPlace,
    asset: &Asset,
    given: Option<&Path>,
    args: &ReportArgs,
    folders: &Folders,
    faults: &mut Vec<String>,
) -> Result<FoundSource, Failure> {
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
    Ok(FoundSource { source, absent })
}

/// The recorded path instead of an absolute one, which would name folders of this machine.
pub fn source_name(source: &Source, recorded: &str) -> String {
    if source.path.is_absolute() && !recorded.is_empty() {
        return recorded.to_owned();
    }
    source.path.display().to_string()
}

/// Up axis and unit of a baked file: `given`, or as the format of its source, the path `source`,
/// says, turned and scaled by its recorded options.
pub fn frame_of(source: &Path, options: &str, given: Option<Up>) -> Frame {
    let options = BuildOptions::from_recorded(options).unwrap_or_default().import();
    let stated = if is_y_up(source) { Up::Y } else { Up::Z };
    let up = match options.up_axis {
        UpAxis::Keep => stated,
        UpAxis::YToZ => Up::Z,
        UpAxis::ZToY => Up::Y,
    };
    let is_metric = is_in_metres(source) && options.unit_scale == 1.0;
    Frame { up: given.unwrap_or(up), unit: if is_metric { "m" } else { "units" } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_as_the_format_says_and_turned_by_the_options() {
        let usual = "split none, vertices referenced, index tree 8";
        for (source, more, up, unit) in [
            ("a.glb", "", Up::Y, "m"),
            ("a.GLTF", ", unit_scale 100", Up::Y, "units"),
            ("a.glb", ", up_axis y-to-z", Up::Z, "m"),
            ("a.obj", "", Up::Y, "units"),
            ("a.stl", "", Up::Z, "units"),
            ("a.stl", ", up_axis z-to-y", Up::Y, "units"),
            ("a.ply", "", Up::Z, "units"),
            ("a.dae", "", Up::Z, "m"),
            ("", "", Up::Z, "units"),
        ] {
            let source = Path::new(source);
            assert_eq!(frame_of(source, &format!("{usual}{more}"), None), Frame { up, unit }, "{source:?}{more}");
            assert_eq!(frame_of(source, usual, Some(Up::Z)).up, Up::Z);
        }
    }
}
