//! A paused look-up: the state of a support query that waits for memory. `index` continues it.

/// How far the look-up of a support query has come, for shapes that can interrupt it wherever it
/// waits for memory.
///
/// It has 16 bytes, so functions return it in registers.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// Bits of the direction that are still to be read, the next one on top.
    pub(crate) path: [u32; 2],
    /// Index of a word, the slot that refers to a node, or the first block and, in `path`, the
    /// number of blocks.
    pub(crate) at: u32,
    pub(crate) nodes: u16,
    pub(crate) kind: LookupKind,
}

/// Data that a look-up waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LookupKind {
    /// A slot that a branch into squares has led to.
    Square,
    /// A slot of a cube map.
    Uniform,
    /// Planes, a fan or a list of blocks.
    Node,
    Leaf,
    /// Nothing: the whole look-up is still to be done, and is not interrupted.
    Whole,
}

impl Lookup {
    /// A look-up that is not interrupted.
    pub(crate) const WHOLE: Self = Self { path: [0; 2], at: 0, nodes: 0, kind: LookupKind::Whole };

    /// Whether the answer can be computed without waiting for another word or node.
    #[inline(always)]
    pub(crate) fn is_ready(&self) -> bool {
        matches!(self.kind, LookupKind::Leaf | LookupKind::Whole)
    }
}
