use crate::outcome::Failure;
use crate::table::{Align, Table, or_dash};
use crate::terminal::{self, Output};
use hullmap_bake::number::grouped;
use hullmap_verify::triangle_mesh::MeshVerification;

pub fn write_text(meshes: &[MeshVerification], out: &mut Output) -> Result<(), Failure> {
    for mesh in meshes {
        if let Some(problems) = mesh.verdict() {
            terminal::error(format_args!("{}: {problems}", mesh.file));
        }
    }
    let mut table = Table::new(&[
        ("file", Align::Left),
        ("triangles", Align::Right),
        ("rays", Align::Right),
        ("hits", Align::Right),
        ("points", Align::Right),
        ("seed", Align::Right),
        ("mismatches", Align::Right),
        ("against", Align::Left),
        ("result", Align::Left),
    ]);
    let count = |value: Option<usize>| or_dash(value, |value| grouped(value as u64));
    for mesh in meshes {
        table.push(vec![
            mesh.file.clone(),
            count(mesh.triangles),
            count(mesh.rays),
            count(mesh.ray_hits),
            count(mesh.points),
            or_dash(mesh.seed, |seed| seed.to_string()),
            count(mesh.mismatches),
            mesh.against.unwrap_or("-").to_owned(),
            if mesh.pass { "exact" } else { "FAILED" }.to_owned(),
        ]);
    }
    table.write(out)?;
    out.line("")?;
    let failed = meshes.iter().filter(|mesh| !mesh.pass).count();
    let noun = if meshes.len() == 1 { "triangle mesh" } else { "triangle meshes" };
    Ok(out.line(format_args!("{noun}: {} exact, {failed} failed", meshes.len() - failed))?)
}
