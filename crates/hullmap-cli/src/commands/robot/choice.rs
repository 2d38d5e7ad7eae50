use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use hullmap_robot::{Description, Format, Geometry, Link, MeshUse, Shape, Submesh, Unresolved};

use super::files::starts_with;
use super::target::Target;
use crate::args::{DECIDED_BY_ROBOTS, FromVisual, RobotArgs, reason_of_robots};
use hullmap_pipeline::config::{Chosen, Configs};
use hullmap_pipeline::jobs::Job;
use hullmap_pipeline::jobs::pack_names::PackName;
use hullmap_pipeline::mesh_file::{names::token, obj};
use hullmap_pipeline::options::OptionLayer;
use hullmap_pipeline::options::table::position;
use hullmap_pipeline::options::value::Value;
use hullmap_pipeline::outcome::Failure;

/// Options that are lengths of the robot, in metres.
const LENGTHS: [&str; 2] = ["max_error", "wall"];

#[derive(Debug)]
pub enum Choice {
    Hulls(usize),
    /// A primitive that is drawn becomes a collision.
    Primitive,
    /// A collision is replaced by the collisions from visuals.
    Removed,
    Kept(String),
}

#[derive(Debug)]
pub struct ShapeChoice {
    pub link: usize,
    /// Index among its collisions, or visuals.
    pub shape: usize,
    pub from_visual: bool,
    pub choice: Choice,
}

#[derive(Debug)]
pub struct HullsOf {
    pub job: usize,
    pub stem: String,
    pub mesh: MeshUse,
}

#[derive(Default)]
struct Known {
    jobs: BTreeMap<(PathBuf, String), usize>,
    /// By job and submesh.
    hulls: BTreeMap<(usize, Option<Submesh>), usize>,
    stems: BTreeSet<String>,
}

#[derive(Debug, Default)]
pub struct Choices {
    /// In the order of the description.
    pub shapes: Vec<ShapeChoice>,
    pub jobs: Vec<Job>,
    pub hulls: Vec<HullsOf>,
    pub warnings: Vec<String>,
    /// Faults of the description, each with its line.
    pub errors: Vec<String>,
}

impl Choices {
    pub fn shape<'d>(&self, own: &ShapeChoice, description: &'d Description) -> &'d Shape {
        let link = &description.links[own.link];
        if own.from_visual { &link.visuals[own.shape] } else { &link.collisions[own.shape] }
    }
}

pub struct Chooser<'a> {
    pub args: &'a RobotArgs,
    pub description: &'a Description,
    pub target: &'a Target,
}

impl Chooser<'_> {
    pub fn choose(&self, configs: &mut Configs) -> Result<Choices, Failure> {
        let mut choices = Choices::default();
        let mut known = Known { stems: self.names_of_sources(), ..Known::default() };
        for (index, link) in self.description.links.iter().enumerate() {
            let from_visual = self.takes_visuals(link);
            for (shape, own) in link.collisions.iter().enumerate().filter(|_| from_visual) {
                // A geom that is named by another element, a pair for instance, keeps its contacts.
                let choice = own.stays_single.clone().map_or(Choice::Removed, Choice::Kept);
                choices.shapes.push(ShapeChoice { link: index, shape, from_visual: false, choice });
            }
            let shapes = if from_visual { &link.visuals } else { &link.collisions };
            for (shape_index, shape) in shapes.iter().enumerate() {
                let choice = match &shape.geometry {
                    _ if self.args.exclude.iter().any(|glob| matches(glob, &link.name)) => {
                        Choice::Kept("--exclude".to_owned())
                    }
                    Geometry::Primitive(_) if from_visual => Choice::Primitive,
                    Geometry::Primitive(primitive) => Choice::Kept(primitive.name.clone()),
                    Geometry::Other(reason) => Choice::Kept(reason.clone()),
                    Geometry::Mesh(mesh) => self.of_mesh(link, shape, mesh, configs, &mut known, &mut choices)?,
                };
                choices.shapes.push(ShapeChoice { link: index, shape: shape_index, from_visual, choice });
            }
        }
        Ok(choices)
    }

    fn takes_visuals(&self, link: &Link) -> bool {
        let is_skipped = self.args.exclude.iter().any(|glob| matches(glob, &link.name));
        let has_mesh = link.visuals.iter().any(|shape| matches!(shape.geometry, Geometry::Mesh(_)));
        link.takes_visuals
            && match self.args.from_visual {
                // A geom of MJCF collides unless it states that it does not.
                FromVisual::Missing => link.collisions.is_empty() && self.description.format != Format::Mjcf,
                FromVisual::Always => link.collisions.is_empty() || has_mesh && !is_skipped && !has_hulls(link),
                FromVisual::Never => false,
            }
    }

    fn of_mesh(
        &self,
        link: &Link,
        shape: &Shape,
        mesh: &MeshUse,
        configs: &mut Configs,
        known: &mut Known,
        choices: &mut Choices,
    ) -> Result<Choice, Failure> {
        let place = || format!("{}:{}", self.description.documents[shape.document].path().display(), shape.line);
        let file = mesh.file.as_deref().unwrap_or(Path::new(&mesh.written));
        let Chosen { layer, skips, config } = configs.of_link(self.description.path(), &link.name, file)?;
        let config = config.map(|config| config.path.clone());
        if skips {
            return Ok(Choice::Kept(format!("skip = true in {}", config.unwrap_or_default().display())));
        }
        let file = match &mesh.file {
            Ok(file) => file,
            // Meshes in the description are files by now.
            Err(Unresolved::Remote | Unresolved::Inline(_)) => {
                let reason = format!("`{}` is not on this machine", mesh.written);
                choices.warnings.push(format!("{}: {reason}, so link `{}` keeps it; save it here", place(), link.name));
                return Ok(Choice::Kept(reason));
            }
            Err(Unresolved::Failed(message)) => {
                choices.errors.push(format!("{}: link `{}`: {message}", place(), link.name));
                return Ok(Choice::Kept("not found".to_owned()));
            }
        };
        if is_own(file) {
            return Ok(Choice::Kept("it is a hull of bake already".to_owned()));
        }
        let mut layer = self.args.options.0.laid_over(&layer);
        for key in DECIDED_BY_ROBOTS {
            let Some(at) = position(key).filter(|at| layer.value_at(*at).is_some()) else { continue };
            let file = config.as_deref().unwrap_or(Path::new("--config")).display();
            let reason = reason_of_robots(key);
            let warning = format!("{file}: {key} has no effect on robots, {reason}; use a rule for other meshes");
            if !choices.warnings.contains(&warning) {
                choices.warnings.push(warning);
            }
            layer.set_at(at, None);
        }
        if let (Some(reason), Some(true)) = (&shape.stays_single, layer.decompose()) {
            let name = if shape.name.is_empty() { &link.name } else { &shape.name };
            choices.warnings.push(format!("{}: `{name}` becomes one hull, because {reason}", place()));
            set(&mut layer, "decompose", Value::Switch(false));
        }
        scale_lengths(&mut layer, mesh.stretch());
        if mesh.submesh.is_some() {
            set(&mut layer, "split", Value::Word("object"));
        }
        let options = layer.resolve();
        let canonical = file.canonicalize().unwrap_or_else(|_| file.clone());
        let job = *known.jobs.entry((canonical, options.to_string())).or_insert_with(|| {
            let output = self.target.meshes.join(format!("{}.hullmap", name(&stem(file), &mut known.stems)));
            choices.jobs.push(Job {
                source: file.clone(),
                place: file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                name: PackName { output: output.clone(), ..PackName::default() },
                output,
                options,
                config,
                records: None,
                inputs: Vec::new(),
                key: String::new(),
            });
            choices.jobs.len() - 1
        });
        let hulls = *known.hulls.entry((job, mesh.submesh.clone())).or_insert_with(|| {
            let output = &choices.jobs[job].output;
            let stem = match &mesh.submesh {
                None => stem(output),
                Some(submesh) => name(&format!("{}_{}", stem(output), submesh.name), &mut known.stems),
            };
            choices.hulls.push(HullsOf { job, stem, mesh: mesh.clone() });
            choices.hulls.len() - 1
        });
        Ok(Choice::Hulls(hulls))
    }

    /// Stems that hulls must not have: programs that remove folders from names, as MuJoCo does in
    /// URDF, would confuse hulls and meshes.
    fn names_of_sources(&self) -> BTreeSet<String> {
        let meshes = self.description.links.iter().flat_map(Link::meshes);
        meshes.map(|mesh| stem(Path::new(&mesh.written)).to_lowercase()).filter(|stem| is_ending(stem)).collect()
    }
}

fn has_hulls(link: &Link) -> bool {
    link.collisions.iter().any(|shape| match &shape.geometry {
        Geometry::Mesh(mesh) => mesh.file.as_ref().is_ok_and(|file| is_own(file)),
        _ => false,
    })
}

pub fn matches(glob: &hullmap_pipeline::glob::Glob, link: &str) -> bool {
    glob.matches(Some(Path::new(link)), Path::new(link))
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn is_ending(stem: &str) -> bool {
    stem.ends_with("_hull") || stem.contains("_part_")
}

/// The stem of a pack or of hulls: the stem of the mesh, with a number if it is taken.
fn name(stem: &str, taken: &mut BTreeSet<String>) -> String {
    let stem = token(stem);
    let numbered = (2_u32..).map(|number| format!("{stem}_{number}"));
    let is_free = |name: &String| {
        let lower = name.to_lowercase();
        !taken.contains(&lower)
            && !taken.contains(&format!("{lower}_hull"))
            && !taken.contains(&format!("{lower}_part_00"))
    };
    let name = std::iter::once(stem.clone()).chain(numbered).find(is_free).unwrap_or(stem);
    taken.insert(name.to_lowercase());
    name
}

/// Whether bake wrote a mesh: hulls are not baked again, so that a second run changes nothing.
fn is_own(file: &Path) -> bool {
    starts_with(file, obj::START)
}

fn set(layer: &mut OptionLayer, key: &str, value: Value) {
    if let Some(at) = position(key) {
        layer.set_at(at, Some(value));
    }
}

fn scale_lengths(layer: &mut OptionLayer, stretch: f64) {
    for key in LENGTHS {
        if let Some(Value::Number(length)) = layer.get(key) {
            set(layer, key, Value::Number(length / stretch));
        }
    }
}
