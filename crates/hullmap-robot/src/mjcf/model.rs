//! Facts about a model that an edit needs, besides its links.

use std::collections::BTreeMap;

/// Document and start of an `include`, and the document that it stands for.
pub type Includes = BTreeMap<(usize, usize), usize>;

#[derive(Debug)]
pub struct Model {
    pub includes: Includes,
    /// By document and start of the geom.
    pub geoms: BTreeMap<(usize, usize), Geom>,
    /// Whether new assets must be in the model's own file: in an included file, MuJoCo would look
    /// for their files elsewhere.
    pub assets_in_model: bool,
}

#[derive(Clone, Debug)]
pub struct Geom {
    /// Whether a copy must be drawn, or keep the mass.
    pub keeps_copy: bool,
    /// Whether another element names it.
    pub is_named: bool,
    /// Document and start of its mesh asset.
    pub asset: Option<(usize, usize)>,
}
