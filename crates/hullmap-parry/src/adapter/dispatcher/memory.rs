//! Memory of a pair from step to step: hullmap's manifold and cache, in a parry workspace.

use hullmap::{Cache, Manifold};

use super::super::parry::query::details::{
    ContactManifoldsWorkspace, TypedWorkspaceData, VoxelsShapeContactManifoldsWorkspace, WorkspaceData,
};

/// The memory of a pair that has one manifold.
#[derive(Clone, Default)]
pub(super) struct Memory {
    pub(super) manifold: Manifold,
    pub(super) cache: Cache,
}

#[derive(Clone, Default)]
struct Workspace<T> {
    memory: T,
    /// An empty parry workspace. It is saved instead of this one, because parry cannot load custom
    /// workspaces. The first step after loading replaces it.
    saved_as: VoxelsShapeContactManifoldsWorkspace<2>,
}

impl<T: Clone + Send + Sync + 'static> WorkspaceData for Workspace<T> {
    fn as_typed_workspace_data(&self) -> TypedWorkspaceData<'_> {
        TypedWorkspaceData::VoxelsShapeContactManifoldsWorkspace(&self.saved_as)
    }

    fn clone_dyn(&self) -> Box<dyn WorkspaceData> {
        Box::new(self.clone())
    }
}

/// The memory of type `T` in `workspace`, which is replaced if it is missing or of another type.
pub(super) fn in_workspace<T: Clone + Default + Send + Sync + 'static>(
    workspace: &mut Option<ContactManifoldsWorkspace>,
) -> Option<&mut T> {
    if workspace.as_ref().is_none_or(|found| found.0.downcast_ref::<Workspace<T>>().is_none()) {
        *workspace = Some(Workspace::<T>::default().into());
    }
    Some(&mut workspace.as_mut()?.0.downcast_mut::<Workspace<T>>()?.memory)
}
