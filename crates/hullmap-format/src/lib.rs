//! What is on disk in a `.hullmap` pack.
