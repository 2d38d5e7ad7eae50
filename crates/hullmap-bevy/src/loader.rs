//! Reads packs for the asset server.

use std::io;
use std::sync::Arc;

use bevy_asset::io::Reader;
use bevy_asset::{AssetLoader, LoadContext};
use bevy_reflect::TypePath;
use hullmap::{InvalidPack, Pack};

use crate::PackAsset;

/// Loads `.hullmap` files as [`PackAsset`]s.
///
/// The file is checked in full, on a thread of the asset server. A file that passes cannot make a
/// query panic, loop or read out of bounds, whoever wrote it.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct PackLoader;

/// Why a file is not loaded. The asset server's message puts the asset's path in front.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be read.
    #[error("cannot read the file: {0}")]
    Read(#[from] io::Error),
    /// The file is not a pack that this version reads.
    #[error(transparent)]
    Invalid(#[from] InvalidPack),
}

impl AssetLoader for PackLoader {
    type Asset = PackAsset;
    type Settings = ();
    type Error = LoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        _context: &mut LoadContext<'_>,
    ) -> Result<PackAsset, LoadError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(PackAsset::new(Arc::new(Pack::from_bytes(&bytes)?)))
    }

    fn extensions(&self) -> &[&str] {
        &["hullmap"]
    }
}
