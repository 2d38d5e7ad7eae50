//! `bake farm plan`: the work of a build as tasks, as JSON or for Ninja.
//!
//! Fresh packs are planned as well: the program that runs a task leaves them alone.

mod ninja;

use std::path::Path;

use rayon::prelude::*;

use crate::args::{Emit, PlanArgs};
use crate::rows::jobs_of_folders;
use crate::terminal::{self, Output};
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::jobs::batch::{BatchSize, batches, work};
use hullmap_pipeline::jobs::key::KeyInputs;
use hullmap_pipeline::jobs::task::{Task, TaskMesh};
use hullmap_pipeline::outcome::{Exit, Failure, end};

/// A mesh that cannot be read, or whose path cannot be written, is reported and left out.
pub fn run(args: &PlanArgs, out: &mut Output) -> Result<Exit, Failure> {
    let (jobs, mut exit) = jobs_of_folders(&args.meshes, &args.out)?;
    let sizes: Vec<u64> = jobs.par_iter().map(|job| work(job.source_bytes(), &job.options)).collect();
    let meshes: Vec<(&str, u64)> = jobs.iter().map(|job| job.place.as_str()).zip(sizes).collect();
    let size = BatchSize { meshes: args.batch, bytes: args.batch_bytes.unwrap_or(BatchSize::default().bytes) };
    let mut index = 0;
    if args.emit == Emit::Ninja {
        end(exit, out.verbatim(ninja::HEAD.as_bytes()).map_err(Failure::from))?;
    }
    for batch in batches(&meshes, size) {
        let batch: Vec<&Job> = batch.into_iter().map(|index| &jobs[index]).collect();
        let (task, worst) = task(args, index, &batch);
        exit = exit.max(worst);
        let Some(task) = task else { continue };
        index += 1;
        let written = match args.emit {
            Emit::Json => out.json(&task),
            Emit::Ninja => {
                let text = ninja::build(&task).map_err(Failure::usage)?;
                out.verbatim(text.as_bytes())
            }
        };
        if let Err(error) = written {
            return end(exit, Err(error.into()));
        }
    }
    end(exit, out.flush().map_err(Failure::from))
}

/// The task of a batch, without meshes that cannot be planned, and the exit code for those; `None`
/// if no mesh is left.
fn task(args: &PlanArgs, index: usize, batch: &[&Job]) -> (Option<Task>, Exit) {
    let limits = args.meshes.limits.limits();
    let found = batch.par_iter().map(|job| match &job.name.clash {
        Some(clash) => Err(Failure::usage(clash.clone())),
        None => KeyInputs::new(job, &limits, Path::new(".")),
    });
    let found: Vec<_> = found.collect();
    let (mut meshes, mut exit) = (Vec::with_capacity(batch.len()), Exit::Done);
    for (job, from) in batch.iter().zip(found) {
        match from.and_then(|from| TaskMesh::new(job, &args.out, from).map_err(Failure::usage)) {
            Ok(mesh) => meshes.push(mesh),
            Err(failure) => {
                terminal::error(&failure);
                exit = exit.max(failure.exit);
            }
        }
    }
    ((!meshes.is_empty()).then(|| Task::new(index, &args.out, meshes)), exit)
}
