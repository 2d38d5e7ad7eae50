//! `bake export --for usd`: hulls as a layer over a stage of Universal Scene Description (USD).
//!
//! The objects of the packs are meshes below one prim of the stage, named after their prims. The
//! hulls of each object become a group beside its mesh. Only the Python package reads stages.

use std::collections::HashMap;
use std::path::Path;

use hullmap::Pack;
use hullmap_format::header::FileKind;

use super::{DENSITY, ExportedFile, leave_out, put, selected, write_unchanged};
use crate::args::export::{ExportArgs, Format};
use crate::args::usd::StageUp;
use crate::terminal::{self, Output};
use hullmap_pipeline::mesh_file::names;
use hullmap_pipeline::mesh_file::usda::{UsdGroup, UsdLayer, UsdMass, identifier, write};
use hullmap_pipeline::open::{noun, open_pack};
use hullmap_pipeline::outcome::{Exit, Failure, end};
use hullmap_pipeline::packs::{PackPlace, find_packs, is_baked, kind_by_name};

const EXTENSION: &str = "usda";

/// All packs become one layer.
pub fn run(args: &ExportArgs, out: &mut Output) -> Result<Exit, Failure> {
    terminal::with_notes_of_changes(|| layer(args, out)).map(|_| Exit::Done)
}

/// Returns whether something was written.
fn layer(args: &ExportArgs, out: &mut Output) -> Result<bool, Failure> {
    let parent = check_flags(args)?;
    let mut places = find_packs(&args.packs)?;
    places.retain(|place| {
        let kind =
            kind_by_name(&place.path).filter(|kind| *kind != FileKind::Pack && !args.packs.contains(&place.path));
        if let Some(kind) = kind {
            terminal::note(format_args!("{}: left out, because it is a {}", place.path.display(), noun(kind)));
        }
        kind.is_none()
    });
    if args.name.is_some() && places.len() > 1 {
        return Err(Failure::usage(
            "--name: several packs are exported, and each needs a name; export this one alone".to_owned(),
        ));
    }
    let packs = places.iter().map(|place| open_pack(&place.path)).collect::<Result<Vec<Pack>, Failure>>()?;
    let mut layer = empty_layer(args);
    let mut counts = [0; 3];
    let mut taken = HashMap::new();
    for (place, pack) in places.iter().zip(&packs) {
        add_pack(args, parent, place, pack, &mut layer, &mut counts, &mut taken)?;
    }
    let (text, of_hulls) = write(&layer).map_err(|error| Failure::usage(format!("--for usd: {error}")))?;
    for mesh in of_hulls {
        terminal::note(format_args!(
            "{mesh}: the mass comes from its hulls, because the pack does not record the mass of the mesh (it is \
             open, triangles are reversed, or only some of its parts are exported)"
        ));
    }
    let file = ExportedFile { name: String::new(), bytes: text.into_bytes(), counts: Some(counts) };
    let Some(target) = &args.out else {
        return end(Exit::Done, out.verbatim(&file.bytes).map_err(Failure::from)).map(|_| true);
    };
    let [written, unchanged] = put(args, vec![target.clone()], vec![file], None, out)?;
    end(Exit::Done, write_unchanged(unchanged, out).map_err(Failure::from)).map(|_| written > 0)
}

/// Checks what clap cannot express, and returns the prim below which the meshes are.
fn check_flags(args: &ExportArgs) -> Result<&str, Failure> {
    let usage = |message: String| Err(Failure::usage(message));
    if let Some(format) = args.format {
        return usage(format!("--format {}: USD is a format of its own; leave out --format", format.extension()));
    }
    if args.parts {
        return usage("--parts: a USD layer is one file; leave it out, or select hulls by --hull".to_owned());
    }
    if let Some(target) = &args.out {
        let shown = target.display();
        if target.is_dir() || target.file_name().is_none() || is_baked(target) {
            return usage(format!("--out {shown}: a USD layer is one file; name a file such as chair_physics.usda"));
        }
        if !has_extension(target) {
            return usage(format!("--out {shown}: the layer is text; name a file with the extension .{EXTENSION}"));
        }
    }
    match &args.usd.prim {
        Some(prim) => Ok(prim),
        None => usage("--for usd: the prim is unknown; add --prim, such as --prim /World/chair".to_owned()),
    }
}

fn has_extension(target: &Path) -> bool {
    let is = |ending: &str| target.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending));
    is(EXTENSION) || is("usd")
}

fn empty_layer<'a>(args: &ExportArgs) -> UsdLayer<'a> {
    UsdLayer {
        asset: args.usd.asset.clone(),
        // The stage's default prim contains the mesh.
        default_prim: args
            .usd
            .prim
            .as_deref()
            .and_then(|prim| prim.split('/').nth(1))
            .filter(|name| !name.is_empty())
            .map(str::to_owned),
        meters_per_unit: args.usd.meters_per_unit.unwrap_or(1.0),
        kilograms_per_unit: 1.0,
        up_axis: if args.usd.stage_up == Some(StageUp::Y) { 'Y' } else { 'Z' },
        groups: Vec::new(),
        off: Vec::new(),
    }
}

/// Adds the objects of a pack. `taken` has the file of each prim that has hulls already.
fn add_pack<'a>(
    args: &ExportArgs,
    parent: &str,
    place: &PackPlace,
    pack: &'a Pack,
    layer: &mut UsdLayer<'a>,
    counts: &mut [usize; 3],
    taken: &mut HashMap<String, String>,
) -> Result<(), Failure> {
    let path = place.path.as_path();
    let (indices, mut bodies) = selected(args, path, pack)?;
    let order: Vec<usize> =
        indices.into_iter().zip(&bodies).filter(|(_, body)| body.rank == 3).map(|at| at.0).collect();
    leave_out(args, path, Format::Obj, &mut bodies)?;
    if bodies.is_empty() {
        return Ok(());
    }
    let unit = layer.meters_per_unit;
    let density = args.density.unwrap_or(DENSITY * unit * unit * unit);
    let mut last: Option<(String, u32)> = None;
    for (index, body) in order.into_iter().zip(&bodies) {
        let object = args.name.as_deref().unwrap_or_else(|| names::object(&body.name, body.part));
        let mesh = format!("{}/{}", parent.trim_end_matches('/'), identifier(object));
        counts[0] += 1;
        counts[1] += body.positions.len();
        counts[2] += body.triangles().count();
        // Parts of an object follow each other.
        let follows =
            last.as_ref().is_some_and(|(prim, part)| *prim == mesh && (args.name.is_some() || body.part > *part));
        last = Some((mesh.clone(), body.part));
        if let Some(group) = layer.groups.last_mut().filter(|_| follows) {
            group.hulls.push(index);
            continue;
        }
        let own = format!("{} of {}", body.name, path.display());
        if let Some(other) = taken.insert(mesh.clone(), own.clone()) {
            return Err(Failure::rejected(format!(
                "{other} and {own} both stand for the prim {mesh}; export one of them with --hull, or rename its mesh"
            )));
        }
        layer.off.push(mesh.clone());
        layer.groups.push(UsdGroup {
            parent: parent.to_owned(),
            name: format!("{}_hulls", identifier(object)),
            mesh,
            transform: None,
            resets_transforms: false,
            pack,
            hulls: vec![index],
            rotation: args.up_axis,
            mass: UsdMass::Density { density, scale: [1.0; 3] },
        });
    }
    Ok(())
}
