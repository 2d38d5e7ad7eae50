//! Support queries are exact for all shapes, indices and scales.

mod clouds;
mod families;
mod proof;
