//! Tests of triangle meshes and height fields, against brute force over all triangles in f64. A
//! separate binary, since the binary of all queries takes minutes to compile.

mod body_manifold;
mod height_field;
mod height_field_seams;
mod manifold_points;
mod meshes;
mod one_sided;
mod surface;
mod tiles;
mod triangle_mesh;
