use crate::table::{Table, or_dash};
use crate::terminal::{self, Output};
use hullmap_geometry::number::grouped;
use hullmap_pipeline::outcome::Failure;
use hullmap_verify::triangle_mesh::SurfaceVerification;

pub fn write_text(surfaces: &[SurfaceVerification], out: &mut Output) -> Result<(), Failure> {
    for surface in surfaces {
        if let Some(problems) = surface.verdict() {
            terminal::error(format_args!("{}: {problems}", surface.file));
        }
    }
    let mut table = Table::headed("file: | triangles | rays | hits | points | seed | mismatches | against: | result:");
    let count = |value: Option<usize>| or_dash(value, |value| grouped(value as u64));
    for surface in surfaces {
        table.push(vec![
            surface.file.clone(),
            count(surface.triangles),
            count(surface.rays),
            count(surface.ray_hits),
            count(surface.points),
            or_dash(surface.seed, |seed| seed.to_string()),
            count(surface.mismatches),
            surface.against.unwrap_or("-").to_owned(),
            if surface.pass { "exact" } else { "FAILED" }.to_owned(),
        ]);
    }
    table.write(out)?;
    out.line("")?;
    let failed = surfaces.iter().filter(|surface| !surface.pass).count();
    Ok(out.line(format_args!("surfaces: {} exact, {failed} failed", surfaces.len() - failed))?)
}
