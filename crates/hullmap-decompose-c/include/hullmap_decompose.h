// hullmap: convex decomposition of meshes in memory. C99 and later, C++11 and later.
//
// Generated from crates/hullmap-decompose-c by cbindgen: do not edit. Licence: MIT OR Apache-2.0.
//
// A mesh becomes convex parts that contain its whole surface and protrude from its solid by a limited
// length. Both bounds are proven, and the facts of a decomposition state them. A convex mesh gives one
// part. Positions are in the frame and unit of the mesh. They are rounded once, to float relative to
// the centre of the mesh. Without a limit of time, the same mesh gives the same parts on every
// machine.
//
// Errors. Functions return a HullmapDecomposeResult, and hullmap_decompose_last_error() has the
// message. No panic or exception crosses the border. If memory runs out, the process is aborted.
//
// Threads. A decomposition never changes. A progress may be used by several threads. The work is done
// by a pool of threads, one for each core, or as many as RAYON_NUM_THREADS says.
//
// Rules for callers: a pointer is NULL, where that is allowed, or points to what its type says, is
// aligned for it, and stays valid and unchanged during the call. Handles are freed once. Structs that
// start with struct_size state their own size.


#ifndef HULLMAP_DECOMPOSE_H
#define HULLMAP_DECOMPOSE_H

#include <stddef.h>
#include <stdint.h>

// Result of a function. Every value except HULLMAP_DECOMPOSE_RESULT_OK is a failure, for which
// hullmap_decompose_last_error() has a message.
enum HullmapDecomposeResult
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Success.
    HULLMAP_DECOMPOSE_RESULT_OK = 0,
    // A pointer is NULL but must not be.
    HULLMAP_DECOMPOSE_RESULT_NULL = 1,
    // An argument is out of range, not a finite number, misaligned or of an unknown version.
    HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT = 2,
    // The mesh has no hull.
    HULLMAP_DECOMPOSE_RESULT_REJECTED = 3,
    // The computation was cancelled.
    HULLMAP_DECOMPOSE_RESULT_CANCELLED = 4,
    // A bug in the library. The call was ended.
    HULLMAP_DECOMPOSE_RESULT_PANIC = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum HullmapDecomposeResult HullmapDecomposeResult;
#else
typedef uint32_t HullmapDecomposeResult;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A decomposition of a mesh into convex parts.
typedef struct HullmapDecomposition HullmapDecomposition;

// Progress of a decomposition, which another thread may read, and by which it may cancel.
typedef struct HullmapDecomposeProgress HullmapDecomposeProgress;

// Options of a decomposition. A field that is 0 has its default.
typedef struct {
    // sizeof(HullmapDecomposeOptions).
    size_t struct_size;
    // Maximum protrusion of a part from the mesh's solid, a length. Default: max_error_share.
    double max_error;
    // The same as a share of the diagonal of the box around the mesh. Default: 0.02.
    double max_error_share;
    // Maximum number of parts. The search then looks for the smallest error. Default: no maximum.
    uint32_t max_parts;
    // Maximum number of vertices of a part, at least 4. Default: 64; 255 for a mesh that one part
    // represents within the maximum error.
    uint32_t max_vertices;
    // The solid of an open mesh. 1: its inside, after its holes are closed. 2: its walls, so that
    // openings stay open. Default: open surfaces are walls if half of their area has faces on both
    // sides, a hole has more than an eighth of it, or all holes together more than all of it;
    // otherwise their holes are closed. Closed surfaces are solid.
    uint32_t solid;
    // Thickness of the parts of walls, as a share of the diagonal; at most half of the maximum
    // error. Default: 0.005.
    double wall_share;
    // Time for the decomposition and its bounds, in seconds. Parts may then protrude further, and
    // depend on the machine. Default: no limit.
    double seconds;
} HullmapDecomposeOptions;

// Facts about a decomposition.
typedef struct {
    // sizeof(HullmapDecomposeFacts), written by the caller.
    size_t struct_size;
    // Number of parts.
    size_t part_count;
    // Bound on how far a point of the mesh's surface lies outside all parts; NaN if it is unknown.
    double uncovered;
    // Bound on how far a point of a part lies outside the mesh's solid; NaN if it is unknown.
    double protrusion;
    // Overlap: the sum of the parts' volumes minus the volume of their union, as a share of the
    // latter. An estimate; NaN if it is unknown.
    double overlap;
    // Mean distance of the parts' visible surface from the mesh's solid. An estimate; NaN if it is
    // unknown.
    double mean_protrusion;
    // Share of the solid's volume that is in no part. An estimate; NaN if the mesh is not
    // watertight.
    double voids;
    // Volume of the solid that the mesh bounds; NaN if the mesh is not watertight. The parts weigh
    // more, because they protrude and overlap.
    double volume;
    // Centre of mass of that solid; NaN if the mesh is not watertight.
    double center[3];
    // Inertia tensor of that solid about its centre of mass at density 1, row by row; NaN if the
    // mesh is not watertight.
    double inertia[9];
    // The solid that the parts were measured against: 1 if the mesh is watertight, 2 if its holes
    // were closed, 3 for its walls; 0 without triangles.
    uint32_t solid;
} HullmapDecomposeFacts;

// A convex part. The arrays belong to the decomposition.
typedef struct {
    // Three coordinates for each vertex, in the frame of the mesh.
    const double *vertices;
    // Number of vertices.
    uint32_t vertex_count;
    // Number of triangles.
    uint32_t triangle_count;
    // Three indices of vertices for each triangle, counter-clockwise seen from outside.
    const uint32_t *triangles;
    // Volume.
    double volume;
    // Centre of mass.
    double center[3];
    // Bound on how far a point of the part lies outside the mesh's solid; NaN if it is unknown.
    double protrusion;
} HullmapDecomposePart;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Message of the last call that failed on this thread: what went wrong and what to do, in UTF-8;
// "" if no call has failed. Valid until the next failure on this thread.
const char *hullmap_decompose_last_error(void);

// Makes a progress, to be freed by hullmap_decompose_progress_free().
HullmapDecomposeProgress *hullmap_decompose_progress_new(void);

// The share that is done, from 0 to 1. It never decreases. 0 for NULL.
double hullmap_decompose_progress_share(const HullmapDecomposeProgress *progress);

// Asks the decomposition to end soon with HULLMAP_DECOMPOSE_RESULT_CANCELLED. Does nothing for
// NULL.
void hullmap_decompose_progress_cancel(const HullmapDecomposeProgress *progress);

// Frees a progress that no call uses. Does nothing for NULL.
void hullmap_decompose_progress_free(HullmapDecomposeProgress *progress);

// Decomposes a mesh into convex parts.
//
// points has three coordinates for each of point_count points, and triangles three indices of
// points for each of triangle_count triangles. options may be NULL, for the defaults, and so may
// progress. On success, *out is a decomposition, to be freed by hullmap_decomposition_free(); on
// failure, it is NULL.
HullmapDecomposeResult hullmap_decompose(const double *points,
                                         size_t point_count,
                                         const uint32_t *triangles,
                                         size_t triangle_count,
                                         const HullmapDecomposeOptions *options,
                                         const HullmapDecomposeProgress *progress,
                                         HullmapDecomposition **out);

// Writes facts about a decomposition to *out. The caller sets out->struct_size first.
HullmapDecomposeResult hullmap_decomposition_facts(const HullmapDecomposition *decomposition,
                                                   HullmapDecomposeFacts *out);

// Writes the part with this index to *out. Its arrays are valid until the decomposition is freed.
HullmapDecomposeResult hullmap_decomposition_part(const HullmapDecomposition *decomposition,
                                                  size_t index,
                                                  HullmapDecomposePart *out);

// Frees a decomposition. Does nothing for NULL.
void hullmap_decomposition_free(HullmapDecomposition *decomposition);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HULLMAP_DECOMPOSE_H */

// Options with all defaults.
#define HULLMAP_DECOMPOSE_OPTIONS_DEFAULT \
    {sizeof(HullmapDecomposeOptions), 0.0, 0.0, 0, 0, 0, 0.0, 0.0}
