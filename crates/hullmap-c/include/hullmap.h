// hullmap: convex collision on baked hulls. C99 and later, C++11 and later.
//
// Generated from crates/hullmap-c by cbindgen: do not edit. Licence: MIT OR Apache-2.0.
//
// A pack is a .hullmap file with one or more hulls, made by the command `bake`; a triangle mesh is a
// .hullmesh file, a static level; a height field is a .hullfield file, ground on a grid. A shape is a
// hull, a whole pack as a compound, a triangle mesh, a height field, or a primitive. Queries take one
// shape or an ordered pair (A, B). Statements about compounds below hold for triangle meshes and
// height fields, too, with triangles in place of hulls.
//
// Frames and units. Every shape has a frame of its own. A pose b_in_a maps B's frame into A's.
// Points, normals and directions of answers are in A's frame, or in the frame of the motions; a
// normal points from A to B, and is of unit length. Lengths are in the unit of the shapes, whatever
// it is. Numbers are double precision.
//
// Errors. Functions return a HullmapResult, HULLMAP_RESULT_OK on success; hullmap_last_error() has
// the message of the last failure on the calling thread. A call that fails writes nothing to its
// answers, except that a function which makes a handle writes NULL, and that a batch which fails
// while it is solved leaves its answers unspecified. No panic or exception crosses the border: a
// bug in the library is HULLMAP_RESULT_PANIC, after a line on stderr. If memory runs out, the
// process is aborted.
//
// Numerical trouble is not an error: an answer's status states it, and it is never "no contact".
// NaN and infinity in poses, points and lengths are errors.
//
// Memory. A handle is made by a function with HullmapX **out, and is freed once by the function
// that ends in _free. Freeing a handle twice, or using it after it was freed, is undefined, as for
// free(). Handles may be freed in any order: a shape keeps its file. Pointers into a pack (names,
// arrays) are valid as long as the pack or a shape made from it exists. Queries do not allocate,
// except batches, failures, and queries of compounds: with a cache or manifold the first one, and
// without a cache each of them.
//
// Threads. Packs, meshes, height fields and shapes never change: any number of threads may use them.
// A cache or a manifold is for one thread at a time; a call that finds it in use by another call
// returns HULLMAP_RESULT_BUSY. A handle must not be freed while another thread uses it. Batches run
// on a pool of threads, one for each core (or as many as the environment variable
// RAYON_NUM_THREADS says), which the first batch starts. Answers do not depend on their number.
// A query needs at most 128 KiB of stack with default settings. A child process after fork()
// without exec() must not call batches.
//
// Rules for callers, for every function: a pointer is NULL, where that is allowed, or points to
// what its type says, is aligned for it, and stays valid and unchanged during the call. Structs
// that start with struct_size state their own size. Arrays of answers do not overlap arguments.


#ifndef HULLMAP_H
#define HULLMAP_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// A point, a direction or a velocity.
typedef struct {
    double x;
    double y;
    double z;
} HullmapVec3;

// A rotation. Any length but zero: it is normalised by each query. The identity is (0, 0, 0, 1).
typedef struct {
    // Vector part.
    double x;
    double y;
    double z;
    // Scalar part.
    double w;
} HullmapQuat;

// Number of the binary interface. A program compares it with hullmap_abi_version() if it loads the
// library at run time.
#define HULLMAP_ABI_VERSION 1

// Open a file by mapping it instead of copying it. No process may write to the file or truncate it
// while the pack or a shape made from it exists; replacing it by renaming is allowed. If this rule
// is broken, answers are wrong, or the process is ended by SIGBUS.
#define HULLMAP_OPEN_MAP 1

// Use the caller's memory in place instead of copying it.
#define HULLMAP_OPEN_BORROW 2

// Check the header, the length and the structure, but not the checksum and the contents. For files
// that have passed the full check before. If the file is damaged, answers may be wrong, and
// queries may return HULLMAP_RESULT_PANIC; they never read out of bounds.
#define HULLMAP_OPEN_SKIP_CONTENTS 4

// Result of a function. Every value except HULLMAP_RESULT_OK is a failure, for which
// hullmap_last_error() has a message.
enum HullmapResult
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Success.
    HULLMAP_RESULT_OK = 0,
    // A pointer is NULL but must not be.
    HULLMAP_RESULT_NULL = 1,
    // An argument is out of range, not a finite number, misaligned or of an unknown version.
    HULLMAP_RESULT_INVALID_ARGUMENT = 2,
    // The pack has no hull of this index or name.
    HULLMAP_RESULT_NOT_FOUND = 3,
    // The file cannot be read.
    HULLMAP_RESULT_IO = 4,
    // The file or the memory is not a sound pack that this version reads.
    HULLMAP_RESULT_INVALID_PACK = 5,
    // The query does not exist for shapes of this kind.
    HULLMAP_RESULT_UNSUPPORTED = 6,
    // A cache or manifold is in use by another call, or was passed twice to a batch.
    HULLMAP_RESULT_BUSY = 7,
    // A bug in the library. The call was ended; caches and manifolds in it were emptied.
    HULLMAP_RESULT_PANIC = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapResult HullmapResult;
#else
typedef uint32_t HullmapResult;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The solid that mass properties describe.
enum HullmapMassSource
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The hulls. Parts of a mesh overlap, and hulls of concave meshes and simplified hulls are
    // larger than their mesh, so their mass is an upper bound, and may be twice the mesh's.
    HULLMAP_MASS_SOURCE_HULLS = 0,
    // The mesh that the hulls were baked from.
    HULLMAP_MASS_SOURCE_MESH = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapMassSource HullmapMassSource;
#else
typedef uint32_t HullmapMassSource;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Class of an edge of a triangle.
enum HullmapEdgeClass
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // No other triangle has the edge.
    HULLMAP_EDGE_CLASS_BORDER = 0,
    // The neighbour continues in the same plane, to within a sine of 1e-3.
    HULLMAP_EDGE_CLASS_FLAT = 1,
    // A ridge: the neighbour falls behind the plane of the triangle.
    HULLMAP_EDGE_CLASS_CONVEX = 2,
    // A valley: the neighbour rises before the plane of the triangle.
    HULLMAP_EDGE_CLASS_CONCAVE = 3,
    // More than two triangles have the edge.
    HULLMAP_EDGE_CLASS_NON_MANIFOLD = 4,
    // The neighbour's front is on the other side: both triangles have the edge in the same
    // direction.
    HULLMAP_EDGE_CLASS_REVERSED = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapEdgeClass HullmapEdgeClass;
#else
typedef uint32_t HullmapEdgeClass;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The diagonal that divides each cell.
enum HullmapDiagonal
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // From the vertex with the least x and y to that with the greatest.
    HULLMAP_DIAGONAL_RISING = 0,
    // From the greatest x and least y to the least x and greatest y.
    HULLMAP_DIAGONAL_FALLING = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapDiagonal HullmapDiagonal;
#else
typedef uint32_t HullmapDiagonal;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Whether two shapes share a point.
enum HullmapOverlap
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // They share no point: a separating plane proves it. Any other status counts as a hit.
    HULLMAP_OVERLAP_SEPARATED = 0,
    // Their interiors share points.
    HULLMAP_OVERLAP_OVERLAPPING = 1,
    // They touch, as HULLMAP_STATUS_TOUCHING defines it.
    HULLMAP_OVERLAP_TOUCHING = 2,
    // Not known: an iteration limit was reached, or rounding error stopped all progress.
    HULLMAP_OVERLAP_UNDECIDED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapOverlap HullmapOverlap;
#else
typedef uint32_t HullmapOverlap;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How a distance or contact query ended, and thus how narrow its interval is.
//
// The interval contains the true value whatever the status is.
enum HullmapStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The interval is as narrow as rounding error allows.
    HULLMAP_STATUS_EXACT = 0,
    // The interval is within HullmapSettings.tolerance.
    HULLMAP_STATUS_WITHIN = 1,
    // The shapes touch: rounding error leaves open whether they overlap. A gap or a penetration is
    // at most 64 rounding errors: docs/contributors/intervals.md, section 6, states them. For
    // baked hulls near the origin, that is 1e-10 of the sum of their outer radii.
    HULLMAP_STATUS_TOUCHING = 2,
    // The shapes overlap: their distance is 0, or a ray or a motion starts so.
    HULLMAP_STATUS_OVERLAPPING = 3,
    // Certainly no contact, or no hit of a ray or a motion: a separating plane proves it.
    HULLMAP_STATUS_SEPARATED = 4,
    // The iteration limit was reached; the interval is wider than the tolerance, or the witness
    // points are less accurate than the interval.
    HULLMAP_STATUS_ITERATION_LIMIT = 5,
    // Rounding error stopped all progress; the interval is wider than the tolerance, or the
    // witness points are less accurate than the interval.
    HULLMAP_STATUS_STALLED = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapStatus HullmapStatus;
#else
typedef uint32_t HullmapStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Whether a length or a time has a derivative, or the reason why it has none.
enum HullmapDifferentiability
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // There is one pair of points and one normal within the interval of the answer.
    HULLMAP_DIFFERENTIABILITY_UNIQUE = 0,
    // The shapes touch, or it is not certain that they do not: distance and depth have a kink at
    // 0.
    HULLMAP_DIFFERENTIABILITY_TOUCHING = 1,
    // Faces or edges are parallel within the interval, so several pairs of points have the same
    // distance: a rotation moves each of them differently.
    HULLMAP_DIFFERENTIABILITY_PARALLEL = 2,
    // Several normals have the same depth within the interval, or a line meets a vertex or an
    // edge.
    HULLMAP_DIFFERENTIABILITY_NORMALS = 3,
    // A ray or a motion is parallel to the surface that it meets, within rounding error.
    HULLMAP_DIFFERENTIABILITY_GRAZING = 4,
    // There is nothing to differentiate: no hit, an overlap at the start of a motion, or the depth
    // of a separated pair.
    HULLMAP_DIFFERENTIABILITY_MISSING = 5,
    // The answer is less accurate than its settings require.
    HULLMAP_DIFFERENTIABILITY_INACCURATE = 6,
    // Only of normals and points: a point is on the border of its face or edge, or the normal is
    // on the border of the normals of its edge or vertex, within the interval. Other features are
    // nearest beyond.
    HULLMAP_DIFFERENTIABILITY_FEATURE = 7,
    // Only of normals and points: the shape is curved there, and no feature describes how.
    HULLMAP_DIFFERENTIABILITY_CURVED = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapDifferentiability HullmapDifferentiability;
#else
typedef uint32_t HullmapDifferentiability;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Whether a motion is certainly free.
enum HullmapVerdict
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The bodies are certainly farther apart than the margin at all times.
    HULLMAP_VERDICT_FREE = 0,
    // They are certainly within the margin at some time.
    HULLMAP_VERDICT_HIT = 1,
    // Neither is known: they graze the margin within rounding error, or the limit of queries was
    // reached.
    HULLMAP_VERDICT_OPEN = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapVerdict HullmapVerdict;
#else
typedef uint32_t HullmapVerdict;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Kind of feature that a manifold point lies on.
enum HullmapFeatureKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The interior of a face.
    HULLMAP_FEATURE_KIND_FACE = 0,
    // An edge: two vertices in ascending order.
    HULLMAP_FEATURE_KIND_EDGE = 1,
    // A vertex.
    HULLMAP_FEATURE_KIND_VERTEX = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapFeatureKind HullmapFeatureKind;
#else
typedef uint32_t HullmapFeatureKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How a HullmapMotion moves a shape over the times 0 to 1.
enum HullmapMotionKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // It stays at the start.
    HULLMAP_MOTION_KIND_STILL = 0,
    // From the start to the end: the origin of its frame along a straight line, its rotation by
    // spherical interpolation, the shorter way.
    HULLMAP_MOTION_KIND_BETWEEN = 1,
    // The point that is at `center` at time 0 moves by `linear`, and the shape turns about it by
    // the rotation vector `angular`, in radians. More than a full turn is allowed.
    HULLMAP_MOTION_KIND_SCREW = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapMotionKind HullmapMotionKind;
#else
typedef uint32_t HullmapMotionKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Unit of HullmapManifoldSettings.prediction.
enum HullmapPrediction
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // A fraction of the outer radius of the smaller shape.
    HULLMAP_PREDICTION_RELATIVE = 0,
    // A length in the shapes' unit.
    HULLMAP_PREDICTION_LENGTH = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapPrediction HullmapPrediction;
#else
typedef uint32_t HullmapPrediction;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Kind of a primitive: HullmapReplacement.kind.
enum HullmapPrimitiveKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // No primitive may replace the hull.
    HULLMAP_PRIMITIVE_KIND_NONE = 0,
    // A cuboid, with three half extents.
    HULLMAP_PRIMITIVE_KIND_BOX = 1,
    // A ball, with a radius.
    HULLMAP_PRIMITIVE_KIND_SPHERE = 2,
    // All points within a radius of a segment along z, with half of its length.
    HULLMAP_PRIMITIVE_KIND_CAPSULE = 3,
    // A cylinder along z, with a radius and half of its height.
    HULLMAP_PRIMITIVE_KIND_CYLINDER = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapPrimitiveKind HullmapPrimitiveKind;
#else
typedef uint32_t HullmapPrimitiveKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Kind of solid that convex parts were measured against: HullmapHullFacts.solid.
enum HullmapSolid
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The hull was not measured: it is not a part, or its mesh was not known.
    HULLMAP_SOLID_UNMEASURED = 0,
    // The mesh is watertight.
    HULLMAP_SOLID_WATERTIGHT = 1,
    // The mesh has holes, which were closed.
    HULLMAP_SOLID_CLOSED = 2,
    // The solid is the triangles of the mesh alone: it is open, or encloses nothing.
    HULLMAP_SOLID_WALLS = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapSolid HullmapSolid;
#else
typedef uint32_t HullmapSolid;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Memory of one ordered pair of shapes from query to query. It makes the next query cheaper, and
// changes answers by no more than rounding error. One call at a time may use it.
typedef struct HullmapCache HullmapCache;

// An open height field: static ground whose heights are known on a grid. It never changes; threads
// may share it.
typedef struct HullmapHeightField HullmapHeightField;

// The contact points of one ordered pair of shapes, kept from step to step. One call at a time may
// use it.
typedef struct HullmapManifold HullmapManifold;

// An open pack: a file with one or more hulls. It never changes; threads may share it.
typedef struct HullmapPack HullmapPack;

// A shape: a hull, a whole pack as a compound, a triangle mesh, a height field, or a primitive. It
// never changes; threads may share it. A shape that comes from a file keeps it open.
typedef struct HullmapShape HullmapShape;

// An open triangle mesh: a static mesh that keeps its triangles. It never changes; threads may
// share it.
typedef struct HullmapTriangleMesh HullmapTriangleMesh;

// Text in UTF-8. It is not terminated, and may hold any character.
typedef struct {
    // First byte; never NULL.
    const char *data;
    // Number of bytes.
    size_t length;
} HullmapText;

// An axis-aligned box that contains a shape, in the frame that its pose maps to and in the shape's
// unit.
typedef struct {
    // Minimum of each coordinate.
    HullmapVec3 min;
    // Maximum of each coordinate.
    HullmapVec3 max;
} HullmapBounds;

// Facts that the bake recorded about a hull. Points are in the hull's frame, which is the source
// mesh's; lengths are in its unit.
//
// Set struct_size to sizeof(HullmapHullFacts) before the call. Later versions may add fields at
// the end.
typedef struct {
    // Set by the caller.
    size_t struct_size;
    // Name; valid as long as the pack, or a shape made from it, exists.
    HullmapText name;
    // Number of vertices, at least 1.
    size_t vertex_count;
    // Number of faces: both sides of a polygon, 0 for a segment or a point.
    size_t face_count;
    // Dimension: 3 for a solid, 2 for a polygon, 1 for a segment, 0 for a point.
    uint32_t rank;
    // Index of the hull among the convex parts of its source object.
    uint32_t part;
    // Volume; 0 below rank 3.
    double volume;
    // Surface area: both sides of a polygon, 0 below rank 2.
    double surface_area;
    // Centre of mass at uniform density.
    HullmapVec3 centroid;
    // Inertia tensor about the centroid at density 1, row by row; symmetric. For a density d or a
    // mass m, multiply it by d, or by m / volume.
    double inertia[9];
    // Box around the vertices.
    HullmapBounds bounds;
    // Maximum distance between two vertices.
    double diameter;
    // A point in the hull, far from its surface.
    HullmapVec3 interior_point;
    // Radius of a ball around interior_point that the hull contains; 0 for a flat hull.
    double inner_radius;
    // Radius of a ball around interior_point that contains the hull.
    double outer_radius;
    // Maximum distance of a source point from the hull, divided by the diameter; at most 1e-7.
    double containment_error;
    // Maximum distance by which the hull reaches beyond the convex hull of its source; 0 for an
    // exact hull.
    double outer_error;
    // Origin of the hull's frame in the source file's frame; zero unless the bake recentred.
    HullmapVec3 origin;
    // Number of convex parts of its source object; 0 for a hull that is not a part.
    uint32_t part_count;
    // A HullmapSolid: kind of solid that the part was measured against. With
    // HULLMAP_SOLID_UNMEASURED, the next three fields are 0 and claim nothing.
    uint32_t solid;
    // Upper bound on how far a point of the mesh's surface lies outside all of its parts.
    double uncovered;
    // Upper bound on how far a point of the part lies outside the mesh's solid.
    double protrusion;
    // The point of the part that protrudes most, as far as the bake found.
    HullmapVec3 protrusion_at;
    // Share of the mesh's solid that is in no part, from 0 to 1; -1 if it is not recorded.
    double voids;
    // Error of voids, from 0 to 1.
    double voids_error;
} HullmapHullFacts;

// A rigid motion: rotate, then translate. `b_in_a` maps points of B's frame into A's frame. From
// the poses of both in a world, hullmap_pose_relative() computes it. A component of the
// translation is at most 3.4e38.
typedef struct {
    // Where B's origin is in A's frame.
    HullmapVec3 translation;
    // Rotation of B in A's frame.
    HullmapQuat rotation;
} HullmapPose;

// A primitive that may replace a convex part, from hullmap_pack_hull_primitive.
//
// It contains all of the mesh's surface that is in the part, so the surface stays covered if some
// or all parts are replaced.
typedef struct {
    // A HullmapPrimitiveKind. With HULLMAP_PRIMITIVE_KIND_NONE, all other fields are 0.
    uint32_t kind;
    // From the primitive's own axes to the frame of the hull. The origin is its centre; the axis
    // of capsules and cylinders is z.
    HullmapPose pose;
    // Box: half of its extent along x, y and z. Sphere: radius. Capsule and cylinder: radius, and
    // half the length of its axis, without the round ends of a capsule. The others are 0.
    double sizes[3];
    // Upper bound on how far a point of the primitive lies outside the mesh's solid, a length.
    double protrusion;
} HullmapReplacement;

// Mass properties of a rigid body, from hullmap_pack_mass_properties.
typedef struct {
    // Mass: density times volume.
    double mass;
    // Centre of mass, in the frame of the pack.
    HullmapVec3 center_of_mass;
    // Inertia tensor about the centre of mass, row by row; symmetric.
    double inertia[9];
    // The solid that these are the properties of.
    HullmapMassSource source;
} HullmapMassProperties;

// The arrays of a hull: pointers into the pack, for reading only. They are valid as long as the
// pack, or a shape made from it, exists. All are aligned to 4 bytes.
//
// A run of face_vertices or neighbours ends where the next one starts, the last one at the end of
// the array.
typedef struct {
    // Positions: three numbers x, y, z for each vertex.
    const float *vertices;
    // For each vertex, its index in the source file; UINT32_MAX for a vertex that the bake
    // created.
    const uint32_t *source_vertices;
    // For each vertex, where its run of neighbours starts.
    const uint32_t *neighbour_starts;
    // Number of vertices.
    size_t vertex_count;
    // Indices of the vertices that share an edge with each vertex, ascending.
    const uint32_t *neighbours;
    // Length of neighbours.
    size_t neighbour_count;
    // For each face, where its run of face_vertices starts.
    const uint32_t *face_starts;
    // Number of faces.
    size_t face_count;
    // Indices of the vertices of the faces, counter-clockwise seen from outside.
    const uint32_t *face_vertices;
    // Length of face_vertices.
    size_t face_vertex_count;
} HullmapHullArrays;

// A triangle of a mesh or of a height field. Edge i goes from corner i to the next one.
typedef struct {
    // Its corners, counter-clockwise seen from the front, which is above for a field.
    HullmapVec3 corners[3];
    // Indices of the corners among the vertices of the mesh. In a height field: row times
    // columns plus column.
    uint32_t vertices[3];
    // The triangles beyond its edges; UINT32_MAX where there is none, or more than one.
    uint32_t neighbours[3];
    // Classes of its edges.
    HullmapEdgeClass edge_classes[3];
    // Its index in the mesh that was baked; of a field, its own index.
    uint32_t source_triangle;
    // Its material; 0 without one.
    uint32_t material;
} HullmapMeshTriangle;

// The grid of a height field. Vertex (column, row) is at origin + column times spacing along x,
// and origin + row times spacing along y; heights are along z. Cell (column, row) has the index
// i = row times (columns - 1) + column, and the triangles 2 i and 2 i + 1.
typedef struct {
    // Number of vertices along x, at least 2.
    size_t columns;
    // Number of vertices along y, at least 2.
    size_t rows;
    // x and y of the first vertex.
    double origin[2];
    // Distance of neighbouring vertices along x and along y.
    double spacing[2];
    // The diagonal that divides each cell.
    HullmapDiagonal diagonal;
    // Number of cells that are holes. A hole has no triangles, but their indices are reserved.
    size_t holes;
} HullmapFieldLayout;

// Height and normal of a height field at a point.
typedef struct {
    // z of the surface, on the plane of the triangle. Its rounding error is at most a few units
    // in the last place of the greatest height of the cell.
    double height;
    // Upward unit normal of the triangle.
    HullmapVec3 normal;
    // The triangle.
    size_t triangle;
} HullmapGround;

// Support point of a shape: a point of the shape with the maximum dot product with the query
// direction.
typedef struct {
    // The point, in the shape's local frame.
    HullmapVec3 point;
    // Identifies the point among the shape's features: on a hull, the vertex index. Shapes with
    // vertices return equal points for equal features, and other features for other points: a
    // manifold merges points on the same features. A shape without vertices returns 0.
    uint32_t feature;
} HullmapSupportPoint;

// Answer of hullmap_intersects().
typedef struct {
    // Whether the shapes share a point.
    HullmapOverlap status;
    // Number of steps of all phases together.
    uint32_t iterations;
    // Number of support calls. One call queries both shapes once.
    uint32_t support_calls;
    // The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    // mesh or a field. 0 for a shape without parts.
    uint32_t parts[2];
} HullmapIntersection;

// Accuracy and effort of a distance, contact or signed distance. Start from
// HULLMAP_SETTINGS_DEFAULT.
typedef struct {
    // sizeof(HullmapSettings)
    size_t struct_size;
    // Maximum width of the interval, relative to its upper bound. The default is 1e-5. NaN and
    // negative values count as 0: as narrow as rounding error allows.
    double tolerance;
    // Maximum number of steps of the last phase. The default is 1000.
    uint32_t max_iterations;
} HullmapSettings;

// Answer of hullmap_distance(): the distance of a pair and the witness points that realise it.
//
// Lengths are in the shapes' unit, points and directions in A's frame. The interval from `lower`
// to `upper` always contains the distance.
typedef struct {
    // How the query ended, and thus how narrow the interval is.
    HullmapStatus status;
    // Length of the segment from `point_a` to `point_b`; 0 if the shapes overlap or touch.
    double distance;
    // Lower bound of the distance, at least 0, with allowance for rounding error.
    double lower;
    // Upper bound of the distance, with allowance for rounding error.
    double upper;
    // Unit vector from A to B: the normal of the planes that prove `lower`. It is the direction of
    // the shortest segment within the tolerance.
    //
    // If the shapes touch, it is the normal of a plane between them. If they overlap, it is any
    // unit vector.
    HullmapVec3 normal;
    // Witness point: the point of A closest to B. If the shapes overlap, a common point.
    HullmapVec3 point_a;
    // Witness point: the point of B closest to A. If the shapes overlap, a common point.
    HullmapVec3 point_b;
    // Number of steps of the search.
    uint32_t iterations;
    // Number of support calls. One call queries both shapes once.
    uint32_t support_calls;
    // The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    // mesh or a field. 0 for a shape without parts.
    uint32_t parts[2];
    // Features of a point of A and of a point of B in their support planes along the normal; the
    // greatest number if they are not known. For the derivatives.
    uint32_t features[2];
} HullmapDistance;

// Answer of hullmap_contact(): penetration depth, normal and witness points of a pair.
//
// Lengths are in the shapes' unit, points and directions in A's frame. If rounding error or a
// limit stopped the search, `status` says so; the interval from `depth_lower` to `depth_upper`
// always contains the depth.
typedef struct {
    // False only if a separating plane proves the shapes separated.
    bool hit;
    // Whether it is certain that no other normal has nearly the same depth. For the derivatives.
    bool is_only_normal;
    // How the query ended, and thus how narrow the interval is.
    HullmapStatus status;
    // Penetration depth: moving B by this length along `normal` makes the shapes touch. 0 if they
    // are separated or touch.
    double depth;
    // Lower bound of the penetration depth, at least 0, with allowance for rounding error.
    double depth_lower;
    // Upper bound of the penetration depth, with allowance for rounding error.
    double depth_upper;
    // Unit vector from A to B. If two convex shapes are separated, a separating axis. If parts are
    // separated, the normal and the points are NaN: one axis may not separate them all.
    HullmapVec3 normal;
    // Witness point: the point of A that is deepest in B. If the shapes are separated, some point
    // of A; hullmap_distance() computes the closest one.
    //
    // Both witness points are in their shapes and on their support planes along `normal`, and
    // `point_a` − `point_b` is `depth` times `normal`: all to within the width of the interval and
    // rounding error. With the statuses HULLMAP_STATUS_ITERATION_LIMIT and HULLMAP_STATUS_STALLED,
    // `point_a` − `point_b` may differ from that across the normal, and if the lower bound is 0,
    // along it as well.
    HullmapVec3 point_a;
    // Witness point: the point of B that is deepest in A. If the shapes are separated, some point
    // of B.
    HullmapVec3 point_b;
    // Number of steps of all phases together.
    uint32_t iterations;
    // Number of support calls. One call queries both shapes once.
    uint32_t support_calls;
    // The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    // mesh or a field. 0 for a shape without parts.
    uint32_t parts[2];
    // Features of a point of A and of a point of B in their support planes along the normal; the
    // greatest number if they are not known. For the derivatives.
    uint32_t features[2];
} HullmapContact;

// Limits and accuracy of a ray or a cast. Start from HULLMAP_CAST_SETTINGS_DEFAULT.
typedef struct {
    // sizeof(HullmapCastSettings)
    size_t struct_size;
    // Maximum t, in the unit of the ray or the motion. The default is infinite. NaN and negative
    // values count as 0.
    double max_t;
    // Maximum width of the interval as a length along the way, relative to the outer radius of the
    // shape, or to the sum of both radii. The default is 1e-6.
    double tolerance;
    // Maximum number of steps. The default is 1000.
    uint32_t max_iterations;
} HullmapCastSettings;

// Answer of hullmap_cast(): when and where a moving shape first meets another.
//
// Points and directions are in A's frame. Times are in the unit that the velocity implies: at time
// t, B has moved by t times its velocity.
typedef struct {
    // False only if it is certain that the shapes do not meet up to HullmapCastSettings.max_t.
    bool hit;
    // How the query ended.
    //
    // - HULLMAP_STATUS_SEPARATED: certainly no hit. All times are infinite.
    // - HULLMAP_STATUS_OVERLAPPING: the shapes overlap at the start. All times are 0, the normal is
    //   opposite to the motion, and hullmap_contact() computes the depth. Without motion, the
    //   normal is any unit vector.
    // - HULLMAP_STATUS_EXACT, HULLMAP_STATUS_WITHIN: a hit in the interval.
    // - HULLMAP_STATUS_TOUCHING: the shapes graze each other, and rounding error decides between
    //   hit and miss. If they meet, they do so in the interval.
    // - HULLMAP_STATUS_ITERATION_LIMIT, HULLMAP_STATUS_STALLED: a hit, in an interval that is wider
    //   than the tolerance.
    HullmapStatus status;
    // Time of impact; infinite if there is no hit.
    double t;
    // Lower bound of the time of impact, at least 0, with allowance for rounding error. Until then
    // the shapes certainly do not overlap.
    double t_lower;
    // Upper bound of the time of impact, with allowance for rounding error. It may exceed `max_t`
    // if the interval does.
    double t_upper;
    // Unit vector from A to B: normal of a plane that separates the shapes until `t_lower`. If
    // there is no hit, normal of a plane that takes part in the proof.
    HullmapVec3 normal;
    // Point of A at which the shapes meet. If they overlap at the start, a common point. Zero if
    // there is no hit.
    HullmapVec3 point_a;
    // Point of B at which the shapes meet, at time `t`.
    HullmapVec3 point_b;
    // Number of steps of the search.
    uint32_t iterations;
    // Number of support calls. One call queries both shapes once.
    uint32_t support_calls;
    // The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    // mesh or a field. 0 for a shape without parts.
    uint32_t parts[2];
} HullmapImpact;

// Answer of hullmap_ray(): where a ray first enters a shape.
//
// Points and directions are in the shape's frame. t is a factor of the ray's direction, which
// need not be of unit length.
typedef struct {
    // False only if it is certain that the ray misses the shape up to HullmapCastSettings.max_t.
    bool hit;
    // How the query ended.
    //
    // - HULLMAP_STATUS_SEPARATED: certainly no hit. t and its interval are infinite.
    // - HULLMAP_STATUS_OVERLAPPING: the origin is inside the shape. t is 0, the point is the
    //   origin, and the normal is opposite to the direction. If the direction is zero, the normal
    //   is any unit vector.
    // - HULLMAP_STATUS_EXACT, HULLMAP_STATUS_WITHIN: a hit in the interval.
    // - HULLMAP_STATUS_TOUCHING: the ray grazes the shape, and rounding error decides between hit
    //   and miss. If it hits, it does so in the interval. Rays at hulls, boxes and triangles never
    //   end so: they are decided exactly.
    // - HULLMAP_STATUS_ITERATION_LIMIT, HULLMAP_STATUS_STALLED: a hit, in an interval that is wider
    //   than the tolerance.
    HullmapStatus status;
    // The ray enters the shape at `origin + t direction`; infinite if there is no hit.
    double t;
    // Lower bound of t, at least 0, with allowance for rounding error.
    double t_lower;
    // Upper bound of t, with allowance for rounding error. It may exceed `max_t` if the interval
    // does.
    double t_upper;
    // The point at t. If the ray grazes the shape, the point need not be on the shape. The origin
    // if there is no hit.
    HullmapVec3 point;
    // Unit outward normal of a support plane of the shape, which the ray crosses at `t_lower`. On
    // a polytope, it is the normal of the face at the point. If there is no hit, normal of a plane
    // that takes part in the proof.
    HullmapVec3 normal;
    // Number of steps of the search.
    uint32_t iterations;
    // Number of support calls.
    uint32_t support_calls;
    // Index of the part that decided the answer: the hull of a pack, the triangle of a mesh or a
    // field. 0 for a shape without parts.
    uint32_t part;
} HullmapRayHit;

// Answer of hullmap_signed_distance().
//
// Lengths are in the shape's unit, points and directions in its frame.
typedef struct {
    // How the query ended. HULLMAP_STATUS_SEPARATED and HULLMAP_STATUS_OVERLAPPING do not occur:
    // the sign of the distance gives that information.
    HullmapStatus status;
    // Distance from the surface: positive outside, negative inside.
    double distance;
    // Lower bound of the distance, with allowance for rounding error. Positive only if the point
    // is certainly outside.
    double lower;
    // Upper bound of the distance, with allowance for rounding error. Negative only if the point
    // is certainly inside.
    double upper;
    // The point of the surface that is closest to the query point.
    HullmapVec3 point;
    // Unit outward normal of the surface at `point`: the gradient of the distance.
    HullmapVec3 normal;
    // Number of steps of all phases together.
    uint32_t iterations;
    // Number of support calls.
    uint32_t support_calls;
    // Index of the part that decided the answer: the hull of a pack, the triangle of a mesh or a
    // field. 0 for a shape without parts.
    uint32_t part;
} HullmapSignedDistance;

// A rigid motion of a shape over the times 0 to 1, in a frame that is common to both shapes.
//
// Members that its kind does not name are not read.
typedef struct {
    // A HullmapMotionKind.
    uint32_t kind;
    // Pose at time 0.
    HullmapPose start;
    // Pose at time 1: HULLMAP_MOTION_KIND_BETWEEN.
    HullmapPose end;
    // Displacement of the point at `center`: HULLMAP_MOTION_KIND_SCREW.
    HullmapVec3 linear;
    // Rotation vector: HULLMAP_MOTION_KIND_SCREW.
    HullmapVec3 angular;
    // The point about which the shape turns, at time 0: HULLMAP_MOTION_KIND_SCREW.
    HullmapVec3 center;
} HullmapMotion;

// Limits and accuracy of a motion. Start from HULLMAP_MOTION_SETTINGS_DEFAULT.
typedef struct {
    // sizeof(HullmapMotionSettings)
    size_t struct_size;
    // The shapes meet when their distance is at most this. The default is 0. NaN and negative
    // values count as 0.
    double target_distance;
    // At the lower bound of the time of impact, the distance exceeds the target by at most this
    // fraction of the sum of the outer radii. The default is 1e-6.
    double tolerance;
    // Maximum number of distance and contact queries for each turn of 360 degrees, up to 100
    // turns. Turns of both shapes are added and rounded up. The default is 200. All pairs of parts
    // share it, so compounds on triangles may need 1,000 or more.
    uint32_t max_iterations;
} HullmapMotionSettings;

// Answer of hullmap_cast_motion(): when and where two moving shapes first meet.
//
// Points and directions are in the common frame of the motions.
typedef struct {
    // False only if it is certain that the shapes do not meet until time 1.
    bool hit;
    // How the query ended.
    //
    // - HULLMAP_STATUS_SEPARATED: certainly no hit. All times are infinite.
    // - HULLMAP_STATUS_OVERLAPPING: the shapes meet at the start, in their poses as computed there.
    //   All times are 0.
    // - HULLMAP_STATUS_WITHIN: a hit in the interval. At `t_lower` the shapes are within the
    //   tolerance of the target distance.
    // - HULLMAP_STATUS_TOUCHING: the shapes come within rounding error of each other, and may graze
    //   without meeting. If they meet, they do so in the interval.
    // - HULLMAP_STATUS_ITERATION_LIMIT, HULLMAP_STATUS_STALLED: it is open whether they meet. If
    //   they do, it is in the interval.
    HullmapStatus status;
    // Time of impact, between 0 and 1; infinite if there is no hit.
    double t;
    // Lower bound of the time of impact, with allowance for rounding error. Until then the shapes
    // are certainly farther apart than the target distance.
    double t_lower;
    // Upper bound: at this time the shapes are certainly within the target distance. Infinite if
    // no such time was found.
    double t_upper;
    // Unit vector from A to B at `t_lower`: normal of a plane that separates the shapes then.
    HullmapVec3 normal;
    // Point of A closest to B at `t_lower`.
    HullmapVec3 point_a;
    // Point of B closest to A at `t_lower`.
    HullmapVec3 point_b;
    // Number of distance and contact queries.
    uint32_t iterations;
    // Number of support calls. One call queries both shapes once.
    uint32_t support_calls;
    // The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a
    // mesh or a field. 0 for a shape without parts.
    uint32_t parts[2];
} HullmapTimeOfImpact;

// Derivative of a length or a time by the pose of a shape: how much it changes when the shape
// moves by a small twist.
//
// A twist moves the shape by `v` and turns it by the rotation vector `w` about the origin of its
// own frame. Both are in the frame of the answer, so the turn is applied on the left of the
// shape's rotation. The change is `linear · v + angular · w`, to first order.
typedef struct {
    // By the translation: per unit of length.
    HullmapVec3 linear;
    // By the rotation about the origin of the shape's frame: per radian.
    HullmapVec3 angular;
} HullmapPoseDerivative;

// Derivatives of a length or a time by the poses of A and of B, in the frame of the answer.
//
// If the status is not HULLMAP_DIFFERENTIABILITY_UNIQUE, they belong to the normal and the points
// of the answer, which are some of several: a direction for an optimiser, and no derivative. They
// are 0 if there is nothing to differentiate.
typedef struct {
    // Whether these are derivatives.
    HullmapDifferentiability status;
    // By the pose of A.
    HullmapPoseDerivative by_a;
    // By the pose of B, or of the point or the ray.
    HullmapPoseDerivative by_b;
} HullmapDerivatives;

// Settings of hullmap_clear(). Start from HULLMAP_CLEAR_SETTINGS_DEFAULT.
typedef struct {
    // sizeof(HullmapClearSettings)
    size_t struct_size;
    // Shapes that come within this distance hit each other. The default is 0.
    double margin;
    // As in HullmapMotionSettings.
    double tolerance;
    // The clearance of a free motion is at least this share of the least distance found, or the
    // status is not HULLMAP_STATUS_WITHIN. The default is 0.5; 0 is the fastest.
    double share;
    // As in HullmapMotionSettings.
    uint32_t max_iterations;
} HullmapClearSettings;

// Answer of hullmap_clear(): whether a motion is free, and with which clearance.
typedef struct {
    // Whether the motion is free.
    HullmapVerdict verdict;
    // How the search ended.
    //
    // - HULLMAP_STATUS_WITHIN: a hit, or a free motion whose clearance is at least the
    //   HullmapClearSettings.share of the nearest distance.
    // - HULLMAP_STATUS_OVERLAPPING: a hit at the start.
    // - HULLMAP_STATUS_ITERATION_LIMIT: the limit of queries was reached. The motion is open, or
    //   free with a smaller clearance.
    // - HULLMAP_STATUS_TOUCHING, HULLMAP_STATUS_STALLED: the same, but rounding error stopped the
    //   search.
    HullmapStatus status;
    // Lower bound of the least distance during a free motion, with allowance for rounding error. 0
    // if it is not known to be free.
    double clearance;
    // Upper bound of the least distance: the bodies are this near at some time that was tried. It
    // is infinite if no parts were near enough to be tried.
    double nearest;
    // Until this time, the bodies are certainly farther apart than the margin. Infinite if they
    // are at all times.
    double t_lower;
    // At this time, the bodies are certainly within the margin. Infinite if no such time is known.
    double t_upper;
    // Number of distance and contact queries.
    uint32_t iterations;
    // Number of support calls. One call queries both shapes once.
    uint32_t support_calls;
    // The parts of A and of B that meet first if the motion hits, by index: hulls of a pack,
    // triangles of a mesh or a field. 0 otherwise, and for a shape without parts.
    uint32_t parts[2];
} HullmapClearance;

// Derivatives of the normal and the witness points by one pose: a row for each coordinate, and in
// it a column for each number of the twist, as in HullmapPoseDerivative.
typedef struct {
    // Rows of the normal: per unit of length, and per radian.
    double normal[3][6];
    // Rows of the point of A: lengths per unit of length, and per radian.
    double point_a[3][6];
    // Rows of the point of B.
    double point_b[3][6];
} HullmapWitnessJacobian;

// Derivatives of the normal and the witness points of an answer, in its frame, by the poses of A
// and of B.
//
// All numbers are 0 unless the status is HULLMAP_DIFFERENTIABILITY_UNIQUE.
typedef struct {
    // Whether these are derivatives, or why there are none.
    HullmapDifferentiability status;
    // By the pose of A.
    HullmapWitnessJacobian by_a;
    // By the pose of B, or of the point.
    HullmapWitnessJacobian by_b;
} HullmapWitnessDerivatives;

// Settings of a contact manifold. Start from HULLMAP_MANIFOLD_SETTINGS_DEFAULT.
typedef struct {
    // sizeof(HullmapManifoldSettings)
    size_t struct_size;
    // As in HullmapSettings.
    double tolerance;
    // As in HullmapSettings.
    uint32_t max_iterations;
    // A HullmapPrediction: the unit of prediction. The default is HULLMAP_PREDICTION_RELATIVE.
    uint32_t prediction_kind;
    // How far two surfaces may be separated and still have points, of negative depth. The default
    // is 0.02. NaN and negative values count as 0.
    double prediction;
} HullmapManifoldSettings;

// The feature of a shape that a manifold point lies on.
typedef struct {
    // Kind of the feature.
    HullmapFeatureKind kind;
    // One vertex, twice, or the two vertices of an edge. On a hull, their indices. 0 for a face.
    uint32_t vertices[2];
} HullmapFeature;

// A point of a manifold. Points and normal are in A's frame unless stated otherwise. Both points
// are on the surfaces, and separated by at most the prediction.
//
// The caller may write impulse and user_data: the next update keeps them if it keeps the point.
// Changes to other fields are ignored.
typedef struct {
    // Unit vector from A to B; the same for all points of a pair of hulls.
    HullmapVec3 normal;
    // The point on A.
    HullmapVec3 point_a;
    // The point on B.
    HullmapVec3 point_b;
    // The point on B, in B's frame.
    HullmapVec3 local_b;
    // Penetration depth at this point; negative if the surfaces are separated there.
    double depth;
    // Owned by the caller; 0 in a new point. For the accumulated impulse along the normal and two
    // tangents.
    double impulse[3];
    // Owned by the caller; 0 in a new point.
    uint64_t user_data;
    // Number of earlier updates in which the point was present.
    uint32_t age;
    // The parts of A and of B that touch, as in HullmapContact.
    uint32_t parts[2];
    // The feature of A.
    HullmapFeature feature_a;
    // The feature of B.
    HullmapFeature feature_b;
    // How the query ended that found the normal; the same for all points of a pair of hulls.
    HullmapStatus status;
} HullmapManifoldPoint;

// The points of a manifold after an update, and what the update cost.
typedef struct {
    // The points: memory of the manifold, valid until its next update, until it is cleared, or
    // until it is freed. Never NULL.
    HullmapManifoldPoint *points;
    // Number of points: at most 4 for each pair of hulls.
    size_t count;
    // Number of pairs of hulls with points.
    uint32_t touching;
    // Number of pairs of hulls that touch but have no points, because the manifold has no room for
    // more pairs.
    uint32_t dropped;
    // Number of pairs of hulls queried.
    uint32_t pairs;
    // Number of steps.
    uint32_t iterations;
    // Number of support calls.
    uint32_t support_calls;
} HullmapManifoldPoints;

// Two shapes and the pose of B in A's frame.
typedef struct {
    // The first shape.
    const HullmapShape *a;
    // The second shape.
    const HullmapShape *b;
    // The pose of B in A's frame.
    HullmapPose b_in_a;
} HullmapPair;



#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version of the library, for instance "0.1.0".
const char *hullmap_version(void);

// The number of the binary interface of the library: HULLMAP_ABI_VERSION of its own header.
uint32_t hullmap_abi_version(void);

// The version of the file format that the library reads.
uint32_t hullmap_format_version(void);

// Message of the last call that failed on this thread: what went wrong, where, and what to do. In
// UTF-8, at most 1023 bytes; "" if no call has failed. A call that succeeds does not change it.
// Valid until the next failure on this thread.
const char *hullmap_last_error(void);

// The name of a HullmapResult in lower case, for instance "not_found"; "unknown" for any other
// number.
const char *hullmap_result_name(uint32_t result);

// Opens a pack file. By default the file is copied into memory and checked completely, so that no
// file can harm a later query.
//
// path: in UTF-8 on Windows, in the system's bytes elsewhere. flags: 0, or HULLMAP_OPEN_MAP,
// HULLMAP_OPEN_SKIP_CONTENTS or both.
HullmapResult hullmap_pack_open(const char *path,
                                uint32_t flags,
                                HullmapPack **pack);

// Opens a pack that is in memory: all bytes of a file.
//
// flags: 0, or HULLMAP_OPEN_BORROW, HULLMAP_OPEN_SKIP_CONTENTS or both. By default the bytes are
// copied, and may be freed after the call; any alignment will do. With HULLMAP_OPEN_BORROW they
// are used in place: they start on a multiple of 64 bytes, and nobody writes to them or frees them
// while the pack or a shape made from it exists.
HullmapResult hullmap_pack_from_memory(const uint8_t *bytes,
                                       size_t length,
                                       uint32_t flags,
                                       HullmapPack **pack);

// Frees a pack; NULL is allowed. Shapes made from it stay valid, and keep its memory.
void hullmap_pack_free(HullmapPack *pack);

// Number of hulls of a pack, at least 1; 0 for NULL.
size_t hullmap_pack_hull_count(const HullmapPack *pack);

// Index of the first hull with this name. O(number of hulls).
HullmapResult hullmap_pack_find(const HullmapPack *pack,
                                const char *name,
                                size_t *index);

// Facts that the bake recorded about the hull of index `hull`, counted from 0. The caller sets
// facts->struct_size first.
HullmapResult hullmap_pack_hull_facts(const HullmapPack *pack,
                                      size_t hull,
                                      HullmapHullFacts *facts);

// The primitive that may replace the hull of index `hull` (option `primitives`). Its kind is
// HULLMAP_PRIMITIVE_KIND_NONE if there is none, or the bake did not look for primitives.
HullmapResult hullmap_pack_hull_primitive(const HullmapPack *pack,
                                          size_t hull,
                                          HullmapReplacement *primitive);

// Mass properties of `count` hulls from the one of index `first`, as one rigid body of uniform
// density: mass per volume. All hulls of a pack: 0 and hullmap_pack_hull_count.
//
// An object whose parts are all among the hulls has the mass of its mesh, if the pack records it.
// Others have the sum of their hulls, which counts overlaps twice; mass->source states which.
HullmapResult hullmap_pack_mass_properties(const HullmapPack *pack,
                                           size_t first,
                                           size_t count,
                                           double density,
                                           HullmapMassProperties *mass);

// The vertices, faces and neighbours of the hull of index `hull`, in place.
HullmapResult hullmap_pack_hull_arrays(const HullmapPack *pack,
                                       size_t hull,
                                       HullmapHullArrays *arrays);

// Opens the file of a triangle mesh, which `bake build --keep-triangles` writes. The file is
// copied into memory and checked completely, so that no file can harm a later query.
//
// path: in UTF-8 on Windows, in the system's bytes elsewhere.
HullmapResult hullmap_triangle_mesh_open(const char *path,
                                         HullmapTriangleMesh **mesh);

// Opens a triangle mesh that is in memory: all bytes of a file. They are copied, and may be freed
// after the call; any alignment will do.
HullmapResult hullmap_triangle_mesh_from_memory(const uint8_t *bytes,
                                                size_t length,
                                                HullmapTriangleMesh **mesh);

// Frees a triangle mesh; NULL is allowed. Shapes made from it stay valid, and keep its memory.
void hullmap_triangle_mesh_free(HullmapTriangleMesh *mesh);

// Number of triangles of a mesh, at least 1; 0 for NULL.
size_t hullmap_triangle_mesh_triangle_count(const HullmapTriangleMesh *mesh);

// Number of vertices of a mesh; 0 for NULL.
size_t hullmap_triangle_mesh_vertex_count(const HullmapTriangleMesh *mesh);

// The triangle of index `index`, counted from 0, as answers of queries count them. O(1).
HullmapResult hullmap_triangle_mesh_triangle(const HullmapTriangleMesh *mesh,
                                             size_t index,
                                             HullmapMeshTriangle *triangle);

// Opens the file of a height field, which `bake build --terrain` writes. The file is copied
// into memory and checked completely, so that no file can harm a later query.
//
// path: in UTF-8 on Windows, in the system's bytes elsewhere.
HullmapResult hullmap_height_field_open(const char *path,
                                        HullmapHeightField **field);

// Opens a height field that is in memory: all bytes of a file. They are copied, and may be freed
// after the call; any alignment will do.
HullmapResult hullmap_height_field_from_memory(const uint8_t *bytes,
                                               size_t length,
                                               HullmapHeightField **field);

// Frees a height field; NULL is allowed. Shapes made from it stay valid, and keep its memory.
void hullmap_height_field_free(HullmapHeightField *field);

// Number of triangles of a height field, including the triangles of holes: two for each cell; 0
// for NULL.
size_t hullmap_height_field_triangle_count(const HullmapHeightField *field);

// The grid of a height field.
HullmapResult hullmap_height_field_layout(const HullmapHeightField *field,
                                          HullmapFieldLayout *layout);

// The triangle of index `index`, counted from 0, as answers of queries count them. A triangle in a
// hole is HULLMAP_RESULT_NOT_FOUND. O(1).
HullmapResult hullmap_height_field_triangle(const HullmapHeightField *field,
                                            size_t index,
                                            HullmapMeshTriangle *triangle);

// The ground at (x, y), in the frame of the field. On a shared edge or vertex, the triangle is the
// one with the lowest index. HULLMAP_RESULT_NOT_FOUND in a hole, and beyond the field. O(1).
HullmapResult hullmap_height_field_height_at(const HullmapHeightField *field,
                                             double x,
                                             double y,
                                             HullmapGround *ground);

// The hull of index `hull`, counted from 0, in its own frame.
HullmapResult hullmap_shape_hull(const HullmapPack *pack,
                                 size_t hull,
                                 HullmapShape **shape);

// The hull of index `hull`, scaled along the axes of its frame; a negative scale mirrors it. The
// magnitude of a scale is from 1e-38 to 3.4e38.
HullmapResult hullmap_shape_scaled_hull(const HullmapPack *pack,
                                        size_t hull,
                                        HullmapVec3 scale,
                                        HullmapShape **shape);

// All hulls of a pack together: a concave mesh that was baked as convex parts.
HullmapResult hullmap_shape_compound(const HullmapPack *pack,
                                     HullmapShape **shape);

// All triangles of a mesh together: a static level, which collides on both sides. Answers
// have the index of the triangle in place of the index of a hull. It has no support points and no
// signed distance.
HullmapResult hullmap_shape_triangle_mesh(const HullmapTriangleMesh *mesh,
                                          HullmapShape **shape);

// All triangles of a height field together: a terrain, which collides on both sides. Answers have
// the index of the triangle in place of the index of a hull. It has no support points and no
// signed distance.
HullmapResult hullmap_shape_height_field(const HullmapHeightField *field,
                                         HullmapShape **shape);

// A sphere about the origin. Lengths of this and the following shapes are from 0 to 3.4e38.
HullmapResult hullmap_shape_sphere(double radius,
                                   HullmapShape **shape);

// A box about the origin, with its edges along the axes: half their lengths.
HullmapResult hullmap_shape_cuboid(HullmapVec3 half_edges,
                                   HullmapShape **shape);

// A capsule about the origin, along z: half the length of the segment, without the caps.
HullmapResult hullmap_shape_capsule(double half_length,
                                    double radius,
                                    HullmapShape **shape);

// A cylinder about the origin, along z.
HullmapResult hullmap_shape_cylinder(double half_height,
                                     double radius,
                                     HullmapShape **shape);

// A cone along z: its base at -half_height, its apex at half_height.
HullmapResult hullmap_shape_cone(double half_height,
                                 double radius,
                                 HullmapShape **shape);

// The segment between two points, whose coordinates are from -3.4e38 to 3.4e38.
HullmapResult hullmap_shape_segment(HullmapVec3 start,
                                    HullmapVec3 end,
                                    HullmapShape **shape);

// The triangle between three points, from both sides: for single triangles; a level is a
// triangle mesh.
HullmapResult hullmap_shape_triangle(HullmapVec3 a,
                                     HullmapVec3 b,
                                     HullmapVec3 c,
                                     HullmapShape **shape);

// Everything below a plane: the points p with normal . p <= offset, after the normal is
// normalised. For floors and walls. Two half-spaces have no query.
HullmapResult hullmap_shape_half_space(HullmapVec3 normal,
                                       double offset,
                                       HullmapShape **shape);

// Frees a shape; NULL is allowed.
void hullmap_shape_free(HullmapShape *shape);

// The pose of B in A, from the poses of both in a world. Bodies near each other keep their digits
// however far they are from the origin.
HullmapResult hullmap_pose_relative(const HullmapPose *a_in_world,
                                    const HullmapPose *b_in_world,
                                    HullmapPose *b_in_a);

// Makes an empty cache: about 1.3 KB, and 90 KB more at the first query of a compound.
HullmapResult hullmap_cache_new(HullmapCache **cache);

// Empties a cache, for instance because its pair now consists of other shapes. Not required: a
// stale cache costs time, and never makes an answer wrong.
HullmapResult hullmap_cache_clear(HullmapCache *cache);

// Frees a cache; NULL is allowed.
void hullmap_cache_free(HullmapCache *cache);

// Support points of a shape in `count` directions: points of the shape with the maximum dot
// product.
//
// Directions are in the shape's frame and need not be of unit length. For a zero or non-finite
// direction the answer is any point of the shape. Not for compounds and half-spaces.
HullmapResult hullmap_support(const HullmapShape *shape,
                              const HullmapVec3 *directions,
                              size_t count,
                              HullmapSupportPoint *out);

// The box around a shape at a pose, in the frame that the pose maps to. It certainly contains the
// shape. Not for half-spaces.
HullmapResult hullmap_bounds(const HullmapShape *shape,
                             const HullmapPose *pose,
                             HullmapBounds *out);

// Whether two shapes share a point. cache may be NULL.
HullmapResult hullmap_intersects(const HullmapShape *a,
                                 const HullmapShape *b,
                                 const HullmapPose *b_in_a,
                                 HullmapCache *cache,
                                 HullmapIntersection *out);

// Distance of two shapes, and their closest points. settings and cache may be NULL.
HullmapResult hullmap_distance(const HullmapShape *a,
                               const HullmapShape *b,
                               const HullmapPose *b_in_a,
                               const HullmapSettings *settings,
                               HullmapCache *cache,
                               HullmapDistance *out);

// Contact of two shapes: penetration depth, normal and deepest points. settings and cache may be
// NULL.
HullmapResult hullmap_contact(const HullmapShape *a,
                              const HullmapShape *b,
                              const HullmapPose *b_in_a,
                              const HullmapSettings *settings,
                              HullmapCache *cache,
                              HullmapContact *out);

// When B, which starts at b_in_a and moves by `velocity` per unit of time, first meets A. Neither
// shape turns. The velocity is in A's frame. settings and cache may be NULL.
HullmapResult hullmap_cast(const HullmapShape *a,
                           const HullmapShape *b,
                           const HullmapPose *b_in_a,
                           HullmapVec3 velocity,
                           const HullmapCastSettings *settings,
                           HullmapCache *cache,
                           HullmapImpact *out);

// Where the ray of all points origin + t direction, t >= 0, first enters a shape. Origin and
// direction are in the shape's frame; t is a factor of the direction, which need not be of unit
// length. settings may be NULL.
HullmapResult hullmap_ray(const HullmapShape *shape,
                          HullmapVec3 origin,
                          HullmapVec3 direction,
                          const HullmapCastSettings *settings,
                          HullmapRayHit *out);

// Signed distance of a point from the surface of a shape, in the shape's frame: positive outside,
// negative inside. The cache is for this shape and points near each other. settings and cache may
// be NULL.
//
// For a compound, it is the minimum over its hulls: outside, the distance from the union; inside,
// the depth in the hull in which the point is deepest. The union contains the ball of this radius
// around the point, but its surface may be farther away where hulls overlap or touch.
HullmapResult hullmap_signed_distance(const HullmapShape *shape,
                                      HullmapVec3 point,
                                      const HullmapSettings *settings,
                                      HullmapCache *cache,
                                      HullmapSignedDistance *out);

// When A and B, which move and turn, first come within a distance of each other. Motions are in a
// common frame, as is the answer.
//
// derivatives may be NULL. If not, it receives the derivatives of the time, by twists that
// displace the whole motion of a shape, and turn it about the place of its origin at the impact.
// settings and cache may be NULL.
HullmapResult hullmap_cast_motion(const HullmapShape *a,
                                  const HullmapMotion *motion_a,
                                  const HullmapShape *b,
                                  const HullmapMotion *motion_b,
                                  const HullmapMotionSettings *settings,
                                  HullmapCache *cache,
                                  HullmapTimeOfImpact *out,
                                  HullmapDerivatives *derivatives);

// Whether A and B, which move and turn, stay farther apart than a margin, and which clearance is
// proven. Motions are in a common frame. settings and cache may be NULL.
HullmapResult hullmap_clear(const HullmapShape *a,
                            const HullmapMotion *motion_a,
                            const HullmapShape *b,
                            const HullmapMotion *motion_b,
                            const HullmapClearSettings *settings,
                            HullmapCache *cache,
                            HullmapClearance *out);

// Distance of two convex shapes, and its derivatives by the poses of both, in A's frame. settings
// and cache may be NULL.
//
// witness may be NULL. If not, it gets the derivatives of the normal and the points.
HullmapResult hullmap_distance_derivatives(const HullmapShape *a,
                                           const HullmapShape *b,
                                           const HullmapPose *b_in_a,
                                           const HullmapSettings *settings,
                                           HullmapCache *cache,
                                           HullmapDistance *out,
                                           HullmapDerivatives *derivatives,
                                           HullmapWitnessDerivatives *witness);

// Contact of two convex shapes, and the derivatives of its depth by the poses of both, in A's
// frame. settings and cache may be NULL.
//
// witness may be NULL. If not, it gets the derivatives of the normal and the points.
HullmapResult hullmap_contact_derivatives(const HullmapShape *a,
                                          const HullmapShape *b,
                                          const HullmapPose *b_in_a,
                                          const HullmapSettings *settings,
                                          HullmapCache *cache,
                                          HullmapContact *out,
                                          HullmapDerivatives *derivatives,
                                          HullmapWitnessDerivatives *witness);

// Where a ray first enters a convex shape, and the derivatives of t, in the shape's frame.
// settings may be NULL.
//
// by_a is with respect to the pose of the shape, and by_b to the pose of the ray: of a frame with
// its origin at the ray's, which turns with the direction.
HullmapResult hullmap_ray_derivatives(const HullmapShape *shape,
                                      HullmapVec3 origin,
                                      HullmapVec3 direction,
                                      const HullmapCastSettings *settings,
                                      HullmapRayHit *out,
                                      HullmapDerivatives *derivatives);

// Makes a manifold without points, for one ordered pair of shapes. `max_pairs` is the maximum
// number of pairs of parts, of triangles of a level or of cells of a terrain that may touch at the
// same time. For two convex shapes, pass 1; for a body on a level, 32 or more. If more touch, the
// earlier pairs stay, and HullmapManifoldPoints.dropped counts the others: a body may then sink
// in. At most 65,536. About 1 KB for each of them, and 5 KB more once compounds are updated.
HullmapResult hullmap_manifold_new(uint32_t max_pairs,
                                   HullmapManifold **manifold);

// Finds up to four contact points of A and of B placed at b_in_a; for compounds, of each pair of
// hulls that touch.
//
// Shapes touch if they overlap, or if they are separated by at most the prediction. A point that
// was there before keeps its impulse and user data, and its age grows. settings may be NULL.
HullmapResult hullmap_manifold_update(HullmapManifold *manifold,
                                      const HullmapShape *a,
                                      const HullmapShape *b,
                                      const HullmapPose *b_in_a,
                                      const HullmapManifoldSettings *settings,
                                      HullmapManifoldPoints *out);

// Removes all points, for instance because a body was moved by hand.
HullmapResult hullmap_manifold_clear(HullmapManifold *manifold);

// Frees a manifold; NULL is allowed.
void hullmap_manifold_free(HullmapManifold *manifold);

// hullmap_intersects() of `count` pairs, on all cores.
//
// Pair i uses `caches[i]` and writes `out[i]`. caches may be NULL; otherwise no cache may occur
// twice. Answers have the same bits as in single queries with the same caches. All pairs are
// checked first: if one is wrong, the message has its index, and nothing is written.
HullmapResult hullmap_batch_intersects(const HullmapPair *pairs,
                                       size_t count,
                                       HullmapCache *const *caches,
                                       HullmapIntersection *out);

// hullmap_distance() of `count` pairs, on all cores. As hullmap_batch_intersects(); settings may
// be NULL.
HullmapResult hullmap_batch_distance(const HullmapPair *pairs,
                                     size_t count,
                                     const HullmapSettings *settings,
                                     HullmapCache *const *caches,
                                     HullmapDistance *out);

// hullmap_contact() of `count` pairs, on all cores. As hullmap_batch_intersects(); settings may be
// NULL.
HullmapResult hullmap_batch_contact(const HullmapPair *pairs,
                                    size_t count,
                                    const HullmapSettings *settings,
                                    HullmapCache *const *caches,
                                    HullmapContact *out);

// hullmap_manifold_update() of `count` pairs, on all cores. As hullmap_batch_intersects(): pair i
// updates `manifolds[i]`, and no manifold may occur twice. settings may be NULL.
HullmapResult hullmap_batch_manifolds(const HullmapPair *pairs,
                                      size_t count,
                                      const HullmapManifoldSettings *settings,
                                      HullmapManifold *const *manifolds,
                                      HullmapManifoldPoints *out);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HULLMAP_H */

// Values to start from.

// The pose that maps a frame to itself.
#define HULLMAP_POSE_IDENTITY {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}}

#define HULLMAP_SETTINGS_DEFAULT {sizeof(HullmapSettings), 1e-5, 1000}

#define HULLMAP_CAST_SETTINGS_DEFAULT {sizeof(HullmapCastSettings), HUGE_VAL, 1e-6, 1000}

#define HULLMAP_MANIFOLD_SETTINGS_DEFAULT \
    {sizeof(HullmapManifoldSettings), 1e-5, 1000, HULLMAP_PREDICTION_RELATIVE, 0.02}

#define HULLMAP_MOTION_SETTINGS_DEFAULT {sizeof(HullmapMotionSettings), 0.0, 1e-6, 200}

#define HULLMAP_CLEAR_SETTINGS_DEFAULT {sizeof(HullmapClearSettings), 0.0, 1e-6, 0.5, 200}
