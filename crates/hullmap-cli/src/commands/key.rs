//! `bake farm key`: the key of each pack, and what goes into it.

use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

use crate::args::KeyArgs;
use crate::rows::jobs_of_folders;
use crate::terminal::{self, Output};
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::jobs::key::KeyInputs;
use hullmap_pipeline::options::RecordSource;
use hullmap_pipeline::outcome::{Exit, Failure, end};

const AT_ONCE: usize = 1024;

/// Key of one pack. Field names are the JSON's.
#[derive(Serialize)]
struct Row<'a> {
    source: String,
    key: String,
    #[serde(flatten)]
    from: &'a KeyInputs,
}

pub fn run(args: &KeyArgs, out: &mut Output) -> Result<Exit, Failure> {
    let (project, limits) = (Path::new("."), args.meshes.limits.limits());
    let out_folder = args.out.as_deref().unwrap_or(Path::new(""));
    let (mut jobs, mut exit) = jobs_of_folders(&args.meshes, out_folder)?;
    if args.out.is_none() {
        jobs.iter_mut().for_each(lie_beside_the_mesh);
    }
    for jobs in jobs.chunks(AT_ONCE) {
        let found: Vec<_> = jobs.par_iter().map(|job| KeyInputs::new(job, &limits, project)).collect();
        for (job, found) in jobs.iter().zip(found) {
            let written = match found {
                Ok(from) => write(args, job, &from, out),
                Err(failure) => {
                    terminal::error(&failure);
                    exit = exit.max(failure.exit);
                    Ok(())
                }
            };
            if written.is_err() {
                return end(exit, written);
            }
        }
    }
    end(exit, out.flush().map_err(Failure::from))
}

fn write(args: &KeyArgs, job: &Job, from: &KeyInputs, out: &mut Output) -> Result<(), Failure> {
    let (source, key) = (job.source.display().to_string(), from.key());
    if args.json {
        out.json(&Row { source, key, from })?;
    } else {
        out.line(format_args!("{key}  {source}"))?;
    }
    Ok(())
}

/// A pack beside its mesh records the name.
fn lie_beside_the_mesh(job: &mut Job) {
    if job.options.record_source() == RecordSource::Relative {
        job.records = Some(job.source.file_name().unwrap_or_default().to_string_lossy().into_owned());
    }
}
