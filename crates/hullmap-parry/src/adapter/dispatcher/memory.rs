//! Memory of a pair from step to step: hullmap's manifold and cache, in a parry workspace.

use hullmap::{Cache, Manifold};

use super::super::parry::query::details::{
    ContactManifoldsWorkspace, TypedWorkspaceData, VoxelsShapeContactManifoldsWorkspace, WorkspaceData,
};

#[derive(Clone, Default)]
pub(super) struct Memory {
    pub(super) manifold: Manifold,
    pub(super) cache: Cache,
    /// An empty parry workspace. It is saved instead of this one, because parry cannot load custom
    /// workspaces. The first step after loading replaces it.
    saved_as: VoxelsShapeContactManifoldsWorkspace<2>,
}

impl WorkspaceData for Memory {
    fn as_typed_workspace_data(&self) -> TypedWorkspaceData<'_> {
        TypedWorkspaceData::VoxelsShapeContactManifoldsWorkspace(&self.saved_as)
    }

    fn clone_dyn(&self) -> Box<dyn WorkspaceData> {
        Box::new(self.clone())
    }
}

/// The memory of type `T` in `workspace`, which is replaced if it is missing or of another type.
pub(super) fn in_workspace<T: WorkspaceData + Default>(
    workspace: &mut Option<ContactManifoldsWorkspace>,
) -> Option<&mut T> {
    if workspace.as_ref().is_none_or(|found| found.0.downcast_ref::<T>().is_none()) {
        *workspace = Some(ContactManifoldsWorkspace(Box::new(T::default())));
    }
    workspace.as_mut()?.0.downcast_mut()
}
