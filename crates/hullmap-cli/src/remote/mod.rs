//! `bake build --remote`: packs from the cache of a farm, or baked by its workers.
//!
//! 1. Packs that are fresh here are left alone.
//! 2. All meshes are divided into batches ([`batch`](crate::jobs::batch)); [`action`] describes
//!    each as an action whose digest depends on its meshes and options alone, not on where they
//!    lie.
//! 3. For each batch with a pack that is not fresh, the result is looked up in the action cache, or
//!    a worker makes it. [`answer`] checks every pack that arrives.
//! 4. Packs that the farm does not bake are baked here, and uploaded on request.

mod action;
mod answer;

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use hullmap_remote::{Client, Identity, RemoteError, Settings};
use rayon::prelude::*;

use crate::args::{RemoteArgs, RunArgs};
use crate::jobs::Job;
use crate::jobs::batch::{BatchSize, batches};
use crate::outcome::{Exit, Failure};
use crate::runner;
use crate::runner::one::Build;
use crate::runner::progress::Progress;
use crate::runner::rows::{Row, Status};
use crate::terminal;
use action::{Batch, Worker, read};
use answer::{Delivered, Results};

/// Runs jobs on a farm and returns their results in the same order. Fails if the farm cannot be
/// reached and `--remote-fallback` is not given, it cannot do what is requested, or a file that an
/// argument names cannot be read.
pub fn run(jobs: &[&Job], build: &Build, remote: &RemoteArgs, args: &RunArgs) -> Result<Vec<(Row, Exit)>, Failure> {
    let worker = Worker::new(remote, build)?;
    let settings = settings(remote)?;
    let address = settings.address.clone();
    if !settings.headers.is_empty() && !address.uses_tls() && !address.is_local() {
        terminal::warning(format_args!(
            "--remote-header: the connection to {address} is not encrypted, so others on the network can read the \
             values; use grpcs://"
        ));
    }
    let client = match Client::connect(settings) {
        Ok(client) => client,
        Err(error) if error.is_unreachable() && remote.fallback => {
            terminal::warning(format_args!("{address}: {error}; baking here"));
            return runner::run(jobs, build, args);
        }
        Err(error) => {
            let Failure { exit, message } = failure(&error);
            return Err(Failure { exit, message: format!("{address}: {message}") });
        }
    };
    let executes = !remote.cache_only;
    if executes && !client.executes() {
        return Err(Failure::usage(
            "--remote: the server does not run actions; use its cache alone with --remote-cache-only",
        ));
    }
    if remote.upload && !client.takes_results() {
        return Err(Failure::usage(
            "--remote-upload: the server does not take results from clients; leave the flag out",
        ));
    }
    let farm = Farm { client, remote, build, has_failed: AtomicBool::new(false) };

    let mut results: Results =
        if build.force { jobs.iter().map(|_| None).collect() } else { fresh(jobs, build, args)? };
    let batches = farm.batches(jobs, &results, &worker);
    let answers = farm.answers(jobs, &batches, args)?;
    let mut rest = Vec::new();
    for (batch, delivered) in answers {
        if delivered.len() < batch.wanted().count() {
            rest.push(batch);
        }
        delivered.into_iter().for_each(|(index, row, exit)| results[index] = Some((row, exit)));
    }
    let left: Vec<usize> = (0..jobs.len()).filter(|&index| results[index].is_none()).collect();
    let baked = runner::run(&left.iter().map(|&index| jobs[index]).collect::<Vec<_>>(), build, args)?;
    for (index, result) in left.into_iter().zip(baked) {
        results[index] = Some(result);
    }
    if remote.upload {
        farm.publish(&rest, &results)?;
    }
    Ok(results.into_iter().flatten().collect())
}

/// A batch, and the results that the farm delivered for it. Jobs without one are baked here.
type Answer<'a> = (&'a Batch<'a>, Delivered);

/// Interval between updates of the progress.
const TICK: Duration = Duration::from_millis(100);

/// A farm and its settings.
struct Farm<'a> {
    client: Client,
    remote: &'a RemoteArgs,
    build: &'a Build<'a>,
    /// A batch has failed, so no other is started.
    has_failed: AtomicBool,
}

impl Farm<'_> {
    /// The batches with a job that has no result yet.
    fn batches<'j>(&self, jobs: &[&'j Job], results: &Results, worker: &Worker) -> Vec<Batch<'j>> {
        let portable: Vec<usize> =
            (0..jobs.len()).filter(|&index| action::is_portable(jobs[index], self.build)).collect();
        let sizes: Vec<u64> = portable.par_iter().map(|&index| jobs[index].source_bytes()).collect();
        let meshes: Vec<(&str, u64)> = portable.iter().map(|&index| jobs[index].place.as_str()).zip(sizes).collect();
        let found = batches(&meshes, BatchSize::default());
        let indices = found.into_iter().map(|batch| batch.into_iter().map(|at| portable[at]).collect::<Vec<usize>>());
        let stale: Vec<Vec<usize>> =
            indices.filter(|batch| batch.iter().any(|&index| results[index].is_none())).collect();
        let batch = |indices: Vec<usize>| {
            let members = indices.into_iter().map(|index| (index, jobs[index], results[index].is_none())).collect();
            Batch::new(members, self.build, worker)
        };
        stale.into_par_iter().filter_map(batch).collect()
    }

    /// The answers to all batches, several of which are in flight at a time. Fails if the farm does
    /// not deliver a batch. Packs that have arrived are in place.
    fn answers<'a>(&self, jobs: &[&Job], batches: &'a [Batch<'a>], args: &RunArgs) -> Result<Vec<Answer<'a>>, Failure> {
        let progress = Progress::new(args.quiet, batches.len(), batches.len() as u64);
        let (next, answers) = (AtomicUsize::new(0), Mutex::new(Vec::with_capacity(batches.len())));
        let work = || {
            while let Some(batch) = batches.get(next.fetch_add(1, Ordering::Relaxed))
                && !self.has_failed.load(Ordering::Relaxed)
            {
                let first = batch.members.first().map_or(0, |member| member.index);
                progress.begin(
                    first,
                    format_args!("{} and {} more", jobs[first].source.display(), batch.members.len() - 1),
                    1,
                );
                let answer = self.answer(batch);
                progress.end(first, Status::Baked);
                answers.lock().unwrap_or_else(PoisonError::into_inner).push(answer);
            }
        };
        std::thread::scope(|scope| {
            let threads = 0..usize::from(self.remote.jobs).min(batches.len());
            let workers: Vec<_> = threads.map(|_| scope.spawn(work)).collect();
            while workers.iter().any(|worker| !worker.is_finished()) {
                std::thread::sleep(TICK);
                progress.tick();
            }
        });
        progress.finish();
        answers.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect()
    }

    fn answer<'a>(&self, batch: &'a Batch<'a>) -> Result<Answer<'a>, Failure> {
        match self.deliver(batch) {
            Ok(delivered) => Ok((batch, delivered)),
            Err(error) if self.remote.fallback => {
                terminal::warning(format_args!("{error}; baking {} meshes here", batch.wanted().count()));
                Ok((batch, Delivered::new()))
            }
            Err(error) => {
                self.has_failed.store(true, Ordering::Relaxed);
                let Failure { exit, message } = failure(&error);
                let action = batch.action.digest.hash();
                let message = if exit == Exit::Rejected { format!("action {action}: {message}") } else { message };
                Err(Failure { exit, message })
            }
        }
    }

    /// The results of a batch, from the cache or from a worker; empty if the cache lacks them and
    /// workers are not used.
    fn deliver(&self, batch: &Batch) -> Result<Delivered, RemoteError> {
        let (digest, executes) = (&batch.action.digest, !self.remote.cache_only);
        let mut again = self.build.force;
        if !again && let Some(outcome) = self.client.look_up(digest, &[action::RESULTS.to_owned()])? {
            match answer::accept(&self.client, batch, &outcome, self.build, self.remote.fallback) {
                // The cache has the result, but its files were removed from the store.
                Err(RemoteError::Missing(_)) => again = true,
                accepted => return accepted,
            }
        }
        if !executes {
            return Ok(Delivered::new());
        }
        let outcome = self.client.execute(&batch.action, again)?;
        answer::accept(&self.client, batch, &outcome, self.build, self.remote.fallback)
    }

    /// Uploads the results of batches baked here, unless [`answer::files`] leaves them out.
    fn publish(&self, batches: &[&Batch], results: &Results) -> Result<(), Failure> {
        for batch in batches {
            let Some(files) = answer::files(batch, results, self.build) else { continue };
            match self.client.publish(&batch.action, &files) {
                Ok(()) => {}
                Err(error) if self.remote.fallback => {
                    terminal::warning(format_args!("{error}; results are not uploaded"));
                    return Ok(());
                }
                Err(error) => return Err(failure(&error)),
            }
        }
        Ok(())
    }
}

/// The results of jobs whose packs are fresh, or that fail before a bake.
fn fresh(jobs: &[&Job], build: &Build, args: &RunArgs) -> Result<Results, Failure> {
    let check = Build { check: true, ..*build };
    let is_open = |row: &Row| matches!(row.status, Status::Stale | Status::Missing);
    Ok(runner::run(jobs, &check, args)?
        .into_iter()
        .map(|(row, exit)| (!is_open(&row)).then_some((row, exit)))
        .collect())
}

fn settings(remote: &RemoteArgs) -> Result<Settings, Failure> {
    let Some(address) = remote.address.clone() else {
        return Err(Failure::usage("--remote: an address is missing"));
    };
    let mut settings = Settings::new(address);
    settings.instance.clone_from(&remote.instance);
    for (index, header) in remote.headers.iter().enumerate() {
        // No message shows a value.
        let Some((name, value)) = header.split_once('=').filter(|(name, _)| !name.is_empty()) else {
            let which = index + 1;
            return Err(Failure::usage(format!("--remote-header: expected NAME=VALUE, but header {which} has no `=`")));
        };
        let value = match value.strip_prefix('@') {
            Some(path) => {
                let bytes = read("--remote-header", path.as_ref())?;
                let text = String::from_utf8(bytes)
                    .map_err(|_| Failure::usage(format!("--remote-header: {path}: it is not UTF-8 text")))?;
                text.trim().to_owned()
            }
            None => value.to_owned(),
        };
        settings.headers.push((name.to_owned(), value));
    }
    let pem = |flag: &str, path: &Path, kind: &str| {
        let bytes = read(flag, path)?;
        let text = String::from_utf8_lossy(&bytes);
        let is_there = text.lines().any(|line| line.starts_with("-----BEGIN ") && line.trim_end().ends_with(kind));
        if is_there && !text.contains("-----BEGIN ENCRYPTED") {
            return Ok(bytes);
        }
        let path = path.display();
        Err(Failure::usage(format!(
            "{flag} {path}: it has no unencrypted part in PEM format that begins with `{kind}`"
        )))
    };
    let certificate = "CERTIFICATE-----";
    settings.certificates =
        remote.certificates.as_deref().map(|path| pem("--remote-ca", path, certificate)).transpose()?;
    if let (Some(own), Some(key)) = (&remote.client_cert, &remote.client_key) {
        settings.identity = Some(Identity {
            certificate: pem("--remote-client-cert", own, certificate)?,
            key: pem("--remote-client-key", key, "PRIVATE KEY-----")?,
        });
    }
    settings.action_timeout = Duration::from_secs(remote.timeout);
    Ok(settings)
}

/// The failure of an error of the farm.
fn failure(error: &RemoteError) -> Failure {
    match error {
        RemoteError::Unreachable { .. } => {
            Failure::usage(format!("{error}; check the address, or bake here with --remote-fallback"))
        }
        RemoteError::Certificate(_) => Failure::usage(format!(
            "{error}; check the address, --remote-ca (the authorities to trust) and --remote-client-cert"
        )),
        RemoteError::Settings(_) | RemoteError::File(_) => Failure::usage(error.to_string()),
        RemoteError::Rejected { .. } | RemoteError::Missing(_) | RemoteError::Invalid(_) => {
            Failure::rejected(format!("{error}; bake on a worker again with --force, or here with --remote-fallback"))
        }
    }
}
