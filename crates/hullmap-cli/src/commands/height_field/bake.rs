use std::path::{Path, PathBuf};

use hullmap::height_field::Layout;
use hullmap_bake::height_field::{BakedHeightField, HeightGrid, bake_height_field};
use hullmap_format::header::source_hash;
use hullmap_import::height_field::{Heights, import_heights, import_holes, read_heights};
use hullmap_import::{Limits, ReadError, SourceFile};

use super::options::FieldOptions;
use crate::outcome::Failure;

pub struct FieldSource {
    name: String,
    heights: SourceFile,
    holes: Option<(PathBuf, SourceFile)>,
}

impl FieldSource {
    pub fn read(path: &Path, options: &FieldOptions, limits: &Limits) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let heights = read(path, limits)?;
        let holes = match &options.hole_image {
            Some(image) => {
                let path = path.with_file_name(image);
                let bytes = read(&path, limits)?;
                Some((path, bytes))
            }
            None => None,
        };
        Ok(Self { name, heights, holes })
    }

    /// XXH3-128 of the file's bytes. With an image of holes, XXH3-128 of both hashes, each as 16
    /// bytes in little-endian order.
    pub fn hash(&self) -> u128 {
        match &self.holes {
            None => self.heights.hash,
            Some((_, holes)) => {
                let hashes = [self.heights.hash, holes.hash].map(u128::to_le_bytes);
                source_hash(hashes.as_flattened())
            }
        }
    }

    /// The heights, and for each cell whether it is a hole; empty without an image of holes.
    pub fn import(&self, options: &FieldOptions) -> Result<(Heights, Vec<bool>), Failure> {
        let rejected = |error: hullmap_import::ImportError| Failure::rejected(error.to_string());
        let heights = import_heights(&self.name, &self.heights.bytes, &options.samples()).map_err(rejected)?;
        if heights.is_image && options.scale.is_none() {
            let message = format!(
                "{}: an image has no unit; name the height of white above black with --height-scale",
                self.name
            );
            return Err(Failure::usage(message));
        }
        let holes = match &self.holes {
            Some((path, image)) => {
                let name = path.display().to_string();
                import_holes(&name, &image.bytes, heights.columns, heights.rows).map_err(rejected)?
            }
            None => Vec::new(),
        };
        Ok((heights, holes))
    }

    pub fn warning(&self, heights: &Heights, options: &FieldOptions) -> Option<String> {
        let hole = options.hole.filter(|_| heights.hole_samples == 0)?;
        Some(format!("{}: no sample is {hole}, so --hole makes no holes; check the value", self.name))
    }

    pub fn bake(&self, heights: &Heights, holes: &[bool], options: &FieldOptions) -> Result<BakedHeightField, Failure> {
        let layout = layout(&self.name, heights, options)?;
        let grid = HeightGrid { layout, heights: &heights.heights, holes, materials: &[] };
        bake_height_field(&grid).map_err(|error| Failure::rejected(format!("{}: {error}", self.name)))
    }
}

pub fn layout(name: &str, heights: &Heights, options: &FieldOptions) -> Result<Layout, Failure> {
    let Heights { columns, rows, .. } = *heights;
    let spacing = options.spacing.or(heights.spacing).ok_or_else(|| {
        Failure::usage(format!("{name}: the file states no distance of its samples; name it with --spacing"))
    })?;
    let [dx, dy] = spacing;
    // The middle of the grid is at the origin.
    let middle = [(columns, dx), (rows, dy)].map(|(count, spacing)| -0.5 * spacing * count.saturating_sub(1) as f64);
    let origin = options.origin.or(heights.origin).unwrap_or(middle);
    Ok(Layout { columns, rows, origin, spacing, diagonal: options.diagonal })
}

fn read(path: &Path, limits: &Limits) -> Result<SourceFile, Failure> {
    let name = path.display().to_string();
    read_heights(&name, path, limits).map_err(|error| match error {
        ReadError::Io(error) => Failure::usage(format!("{name}: cannot read: {error}; check the path")),
        ReadError::Import(error) => Failure::rejected(error.to_string()),
    })
}
