use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::pack_names::PackName;
use crate::content::beside;
use crate::options::{BuildOptions, RecordSource};
use crate::pack_file::{folder_of, recorded_path, records_source};
use crate::packs::PackPlace;
use crate::project::Project;

#[derive(Clone, Debug)]
pub struct Job {
    pub source: PathBuf,
    /// Its path relative to the input folder, with `/`; the file name of a mesh that is itself an
    /// input. It is the same on all machines.
    pub place: String,
    pub output: PathBuf,
    pub name: PackName,
    pub options: BuildOptions,
    /// The `hullmap.toml` they come from, if any.
    pub config: Option<PathBuf>,
    /// The path of the source that the pack must record; `None` if the options decide.
    pub records: Option<String>,
    /// The files that the pack must be baked from; empty if any bytes will do.
    pub inputs: Vec<Input>,
    /// The key that the pack must have; empty if any will do.
    pub key: String,
}

impl Job {
    /// The source's path, as the pack records it: relative if the source lies in the pack's
    /// [`Project`]. `start` is the folder where `bake` was started.
    pub fn recorded_path(&self, start: &Path) -> io::Result<String> {
        let name = || self.source.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match (&self.records, self.options.record_source()) {
            (Some(path), _) => Ok(path.clone()),
            (None, RecordSource::Relative) => {
                let project = self.project(start);
                let root = project.as_ref().map_or(start, Project::root);
                recorded_path(&self.source, folder_of(&self.output), root)
            }
            (None, RecordSource::Name) => Ok(name()),
            (None, RecordSource::None) => Ok(String::new()),
        }
    }

    /// The project of the pack. `start` is the folder where `bake` was started.
    pub fn project(&self, start: &Path) -> Option<Project> {
        let below = Path::new(&self.place).parent().unwrap_or(Path::new("")).to_owned();
        Project::of_pack(&PackPlace { path: self.output.clone(), below }, start)
    }

    /// Whether a pack with this record of its source is fresh, where `expected` would be recorded
    /// now. A build that was started elsewhere may have recorded the source in another way.
    pub fn accepts_record(&self, recorded: &str, expected: &str) -> bool {
        let is_relative = self.records.is_none() && self.options.record_source() == RecordSource::Relative;
        recorded == expected || is_relative && records_source(recorded, &self.source, folder_of(&self.output))
    }

    /// Bytes of the mesh and of its buffers that were planned; `None` if any will do.
    pub fn planned_bytes(&self) -> Option<u64> {
        let sum = self.inputs.iter().fold(0_u64, |sum, input| sum.saturating_add(input.bytes));
        (!self.inputs.is_empty()).then_some(sum)
    }

    /// Bytes of the mesh and its buffers, whose files are not read, or 0 if it cannot be read.
    pub fn source_bytes(&self) -> u64 {
        if let Some(planned) = self.planned_bytes() {
            return planned;
        }
        let length = |path: &Path| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
        // A GLB file contains its buffer; finding others would require reading all of it.
        let is_glb = self.source.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
        let beside = if is_glb { Vec::new() } else { beside(&self.source, &self.options).unwrap_or_default() };
        length(&self.source) + beside.iter().map(|path| length(path)).sum::<u64>()
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Input {
    /// Its path relative to the folder of the mesh: the name of the mesh, or the path of a buffer.
    pub path: String,
    pub bytes: u64,
    pub sha256: String,
}
