//! Support queries are exact for all shapes, indices, scales and numbers of threads.

mod clouds;
mod families;
mod proof;
mod threads;
