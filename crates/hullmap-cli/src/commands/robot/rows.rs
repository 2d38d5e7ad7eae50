use hullmap_report::robot::Excluded;
use hullmap_robot::Description;
use serde::Serialize;

use crate::rows::Notes;
use crate::table::{Align, Table, or_dash};
use crate::terminal::{self, Output};
use hullmap_pipeline::outcome::Failure;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    Written,
    Fresh,
    /// With `--check`: it would change.
    Stale,
    /// With `--check`: there is no output yet.
    Missing,
    Failed,
}

/// One description. Field names are the JSON's.
#[derive(Debug, Serialize)]
pub struct Row {
    pub file: String,
    pub output: Option<String>,
    pub format: Option<&'static str>,
    pub status: Status,
    /// Why it is stale.
    pub reason: Option<String>,
    pub links: Option<usize>,
    /// Number of meshes that were baked; the others were fresh.
    pub baked: usize,
    pub collisions: Vec<Collision>,
    /// Pairs of links whose contacts are excluded, with `--exclude-pairs`.
    pub excluded_pairs: Option<Vec<ExcludedPair>>,
    /// The number of these pairs, and what their reasons mean.
    #[serde(skip)]
    pub exclusions: Option<String>,
    /// Pairs and geometry that are not tested, even without `--exclude-pairs`; `None` if the
    /// collisions are not known.
    pub skipped: Option<Vec<SkippedRow>>,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
    pub errors: Vec<String>,
    /// Time for its files, without the bakes, in milliseconds.
    pub millis: f64,
}

#[derive(Debug, Serialize)]
pub struct Collision {
    pub link: String,
    pub name: String,
    pub line: u32,
    /// `hull`, `parts`, `primitive` (a primitive that was only drawn), `removed` (replaced by the
    /// collisions from visuals) or `kept`.
    pub action: &'static str,
    pub reason: Option<String>,
    pub from_visual: bool,
    pub source: Option<String>,
    pub pack: Option<String>,
    /// The new meshes, as the description names them.
    pub meshes: Vec<String>,
    pub vertices: Option<usize>,
    /// Bound on the protrusion of the parts, in millimetres.
    pub protrusion_mm: Option<f64>,
    /// Bound on how far the surface lies outside of the parts, in millimetres.
    pub uncovered_mm: Option<f64>,
}

#[derive(Debug, Serialize)]
pub struct ExcludedPair {
    pub links: [String; 2],
    /// `Adjacent`, `Default`, `Always` or `Never`.
    pub reason: &'static str,
}

#[derive(Debug, Serialize)]
pub struct SkippedRow {
    pub links: Vec<String>,
    /// Empty for all geoms of the links.
    pub geoms: Vec<String>,
    pub reason: String,
}

impl ExcludedPair {
    pub fn new(pair: &Excluded, description: &Description) -> Self {
        Self { links: pair.links.map(|link| description.links[link].name.clone()), reason: pair.reason }
    }
}

impl Row {
    pub fn new(file: String) -> Self {
        Self {
            file,
            output: None,
            format: None,
            status: Status::Failed,
            reason: None,
            links: None,
            baked: 0,
            collisions: Vec::new(),
            excluded_pairs: None,
            exclusions: None,
            skipped: None,
            notes: Vec::new(),
            warnings: Vec::new(),
            errors: Vec::new(),
            millis: 0.0,
        }
    }

    /// Prints its messages. `notes` knows the notes of all rows.
    pub fn print_messages(&self, notes: &mut Notes) {
        notes.print(&self.file, &self.notes);
        self.warnings.iter().for_each(terminal::warning);
        self.errors.iter().for_each(terminal::error);
    }

    /// Kept collisions are listed only if `lists_all`.
    pub fn write(&self, lists_all: bool, out: &mut Output) -> Result<(), Failure> {
        let mut table = Table::new(&[
            ("link", Align::Left),
            ("mesh", Align::Left),
            ("becomes", Align::Left),
            ("vertices", Align::Right),
            ("protrusion", Align::Right),
        ]);
        let listed: Vec<&Collision> = self.collisions.iter().filter(|own| lists_all || own.action != "kept").collect();
        for own in &listed {
            let becomes = match (own.action, &own.reason) {
                ("parts", _) => format!("{} parts", own.meshes.len()),
                ("kept", Some(reason)) => format!("kept: {reason}"),
                (action, _) => action.to_owned(),
            };
            let mesh = own.source.clone().unwrap_or_else(|| "-".to_owned());
            let protrusion = or_dash(own.protrusion_mm, |mm| format!("{mm:.2} mm"));
            table.push(vec![
                own.link.clone(),
                mesh,
                becomes,
                or_dash(own.vertices, |count| count.to_string()),
                protrusion,
            ]);
        }
        let shows = self.status != Status::Fresh || lists_all;
        if !listed.is_empty() && shows {
            table.write(out)?;
        }
        let count = |action: &str| self.collisions.iter().filter(|own| own.action == action).count();
        let state = match self.status {
            Status::Written => "written",
            Status::Fresh => "fresh",
            Status::Stale => "stale",
            Status::Missing => "missing",
            Status::Failed => "failed",
        };
        let Some(output) = &self.output else {
            out.line(format_args!("{}: {state}; nothing written", self.file))?;
            return Ok(());
        };
        out.line(format_args!(
            "{} -> {output}: {state}; collisions: {} hulls, {} in parts, {} from primitives, {} kept; {} meshes baked",
            self.file,
            count("hull"),
            count("parts"),
            count("primitive"),
            count("kept"),
            self.baked
        ))?;
        for line in self.reason.iter().chain(&self.exclusions) {
            out.line(format_args!("  {line}"))?;
        }
        Ok(())
    }
}
