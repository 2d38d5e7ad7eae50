//! Tests of triangle meshes and height fields, against brute force over all triangles in f64. A
//! separate binary, since the binary of all queries takes minutes to compile.

mod body_manifold;
mod height_field;
mod manifold_points;
mod meshes;
mod one_sided;
mod seams;
mod surface;
