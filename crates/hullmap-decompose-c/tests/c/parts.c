/* A U of three boxes becomes parts; wrong calls are errors with a message. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "hullmap_decompose.h"

static int checks = 0, failures = 0;

static void check(int is_true, const char *what) {
    ++checks;
    if (!is_true) {
        ++failures;
        printf("failed: %s: %s\n", what, hullmap_decompose_last_error());
    }
}

static const double OUTLINE[8][2] = {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
/* Triangles of the lower lid, seen from above. */
static const uint32_t LID[6][3] = {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}};

static double points[16][3];
static uint32_t triangles[28][3];

static void make_u(void) {
    size_t i, count = 0;
    for (i = 0; i < 16; ++i) {
        points[i][0] = 1000 + OUTLINE[i % 8][0];
        points[i][1] = OUTLINE[i % 8][1];
        points[i][2] = i < 8 ? 0 : 1;
    }
    for (i = 0; i < 6; ++i) {
        uint32_t a = LID[i][0], b = LID[i][1], c = LID[i][2];
        uint32_t lower[3], upper[3];
        lower[0] = a, lower[1] = c, lower[2] = b;
        upper[0] = a + 8, upper[1] = b + 8, upper[2] = c + 8;
        memcpy(triangles[count++], lower, sizeof lower);
        memcpy(triangles[count++], upper, sizeof upper);
    }
    for (i = 0; i < 8; ++i) {
        uint32_t a = (uint32_t)i, b = (uint32_t)((i + 1) % 8);
        uint32_t first[3], second[3];
        first[0] = a, first[1] = b, first[2] = b + 8;
        second[0] = a, second[1] = b + 8, second[2] = a + 8;
        memcpy(triangles[count++], first, sizeof first);
        memcpy(triangles[count++], second, sizeof second);
    }
}

/* The height of a point above the planes of a part. */
static double height(const HullmapDecomposePart *part, const double *p) {
    double greatest = -HUGE_VAL;
    uint32_t t;
    for (t = 0; t < part->triangle_count; ++t) {
        const double *a = part->vertices + 3 * part->triangles[3 * t];
        const double *b = part->vertices + 3 * part->triangles[3 * t + 1];
        const double *c = part->vertices + 3 * part->triangles[3 * t + 2];
        double u[3], v[3], n[3], along = 0, length;
        int k;
        for (k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = c[k] - a[k];
        for (k = 0; k < 3; ++k) n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (k = 0; k < 3; ++k) along += n[k] * (p[k] - a[k]);
        if (length > 0 && along / length > greatest) greatest = along / length;
    }
    return greatest;
}

static HullmapDecomposeResult run(const HullmapDecomposeOptions *options, HullmapDecomposition **out) {
    return hullmap_decompose(points[0], 16, triangles[0], 28, options, NULL, out);
}

static void good_calls(void) {
    HullmapDecomposition *found = NULL;
    HullmapDecomposeFacts facts;
    HullmapDecomposeOptions options = HULLMAP_DECOMPOSE_OPTIONS_DEFAULT;
    HullmapDecomposeProgress *progress = hullmap_decompose_progress_new();
    HullmapDecomposePart part;
    double volume = 0;
    size_t i, k;
    facts.struct_size = sizeof facts;
    check(run(NULL, &found) == HULLMAP_DECOMPOSE_RESULT_OK, "default options");
    check(hullmap_decomposition_facts(found, &facts) == HULLMAP_DECOMPOSE_RESULT_OK, "facts");
    check(facts.part_count >= 2 && facts.part_count <= 8, "number of parts");
    check(facts.uncovered <= 1e-6 && facts.protrusion <= 0.02 * sqrt(19), "bounds");
    check(facts.overlap >= 0 && facts.overlap < 0.06, "overlap");
    check(facts.mean_protrusion >= 0 && facts.mean_protrusion <= facts.protrusion, "mean protrusion");
    check(facts.voids >= 0 && facts.voids == 0, "voids");
    check(fabs(facts.volume - 7) < 1e-6, "the volume of the mesh");
    check(fabs(facts.center[0] - 1001.5) < 1e-6 && fabs(facts.center[1] - 9.5 / 7) < 1e-6, "its centre");
    /* The base and the two arms, by the parallel axis theorem. */
    check(fabs(facts.inertia[8] - (2.5 + 3 * 36.0 / 49 + 2 * (5.0 / 6 + 2 * (1 + 81.0 / 196)))) < 1e-5, "its inertia");
    check(fabs(facts.inertia[1]) < 1e-6 && facts.inertia[1] == facts.inertia[3], "its products of inertia");
    for (i = 0; i < 16; ++i) {
        double least = HUGE_VAL;
        for (k = 0; k < facts.part_count; ++k) {
            check(hullmap_decomposition_part(found, k, &part) == HULLMAP_DECOMPOSE_RESULT_OK, "part");
            if (height(&part, points[i]) < least) least = height(&part, points[i]);
        }
        check(least < 1e-6, "every point is in a part");
    }
    for (k = 0; k < facts.part_count; ++k) {
        check(hullmap_decomposition_part(found, k, &part) == HULLMAP_DECOMPOSE_RESULT_OK, "part");
        check(part.vertex_count >= 4 && part.vertex_count <= 64 && part.protrusion <= facts.protrusion, "size");
        check(height(&part, part.center) < 0, "the centre is inside");
        volume += part.volume;
    }
    check(volume > 7 * (1 - 1e-6) && volume < 9, "the U has the volume 7, its hull 9");
    hullmap_decomposition_free(found);

    options.solid = 2;
    check(run(&options, &found) == HULLMAP_DECOMPOSE_RESULT_OK, "walls");
    check(hullmap_decomposition_facts(found, &facts) == HULLMAP_DECOMPOSE_RESULT_OK, "facts of walls");
    check(facts.part_count > 4 && facts.protrusion <= 0.02 * sqrt(19), "walls are hollow");
    hullmap_decomposition_free(found);
    options.solid = 0;

    options.max_parts = 1;
    check(hullmap_decompose(points[0], 16, triangles[0], 28, &options, progress, &found) == HULLMAP_DECOMPOSE_RESULT_OK,
          "one part");
    check(hullmap_decompose_progress_share(progress) == 1, "the progress is complete");
    check(hullmap_decomposition_facts(found, &facts) == HULLMAP_DECOMPOSE_RESULT_OK && facts.part_count == 1, "one");
    check(hullmap_decomposition_part(found, 0, &part) == HULLMAP_DECOMPOSE_RESULT_OK, "part");
    check(fabs(part.volume - 9) < 1e-4, "the hull");
    hullmap_decomposition_free(found);
    hullmap_decompose_progress_free(progress);
}

static void bad_calls(void) {
    HullmapDecomposition *found = NULL;
    HullmapDecomposeFacts facts;
    HullmapDecomposeOptions options = HULLMAP_DECOMPOSE_OPTIONS_DEFAULT;
    HullmapDecomposeProgress *progress = hullmap_decompose_progress_new();
    HullmapDecomposePart part;
    const double kept = points[3][1];
    facts.struct_size = 1;
    check(run(NULL, NULL) == HULLMAP_DECOMPOSE_RESULT_NULL, "out is NULL");
    check(hullmap_decompose(NULL, 16, triangles[0], 28, NULL, NULL, &found) == HULLMAP_DECOMPOSE_RESULT_NULL, "points");
    check(strcmp(hullmap_decompose_last_error(), "points is NULL") == 0, "message");
    check(hullmap_decompose(points[0], 4, triangles[0], 28, NULL, NULL, &found) ==
              HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT && found == NULL,
          "an index is out of range");
    check(strstr(hullmap_decompose_last_error(), "out of range, of 4 points") != NULL, "message");
    points[3][1] = NAN;
    check(run(NULL, &found) == HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT, "not a number");
    check(strstr(hullmap_decompose_last_error(), "points[3]") != NULL, "message");
    points[3][1] = kept;
    check(hullmap_decompose(points[0], 16, NULL, SIZE_MAX, NULL, NULL, &found) != HULLMAP_DECOMPOSE_RESULT_OK, "sizes");
    check(hullmap_decompose(points[0], SIZE_MAX, NULL, 0, NULL, NULL, &found) != HULLMAP_DECOMPOSE_RESULT_OK, "sizes");
    options.max_vertices = 3;
    check(run(&options, &found) == HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT, "too few vertices");
    options.max_vertices = 0;
    options.max_error = -1;
    check(run(&options, &found) == HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT, "a length below 0");
    options.max_error = 0;
    options.solid = 3;
    check(run(&options, &found) == HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT, "no such kind of solid");
    options.solid = 0;
    options.struct_size = 8;
    check(run(&options, &found) == HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT, "another version");
    hullmap_decompose_progress_cancel(progress);
    check(hullmap_decompose(points[0], 16, triangles[0], 28, NULL, progress, &found) ==
              HULLMAP_DECOMPOSE_RESULT_CANCELLED && found == NULL,
          "cancelled");
    check(hullmap_decomposition_facts(NULL, &facts) == HULLMAP_DECOMPOSE_RESULT_NULL, "no decomposition");
    check(hullmap_decomposition_part(NULL, 0, &part) == HULLMAP_DECOMPOSE_RESULT_NULL, "no decomposition");
    check(run(NULL, &found) == HULLMAP_DECOMPOSE_RESULT_OK, "a good call again");
    check(hullmap_decomposition_facts(found, &facts) == HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT, "size of facts");
    check(hullmap_decomposition_part(found, 99, &part) == HULLMAP_DECOMPOSE_RESULT_INVALID_ARGUMENT, "no such part");
    hullmap_decomposition_free(found);
    hullmap_decomposition_free(NULL);
    hullmap_decompose_progress_free(progress);
    hullmap_decompose_progress_free(NULL);
    check(hullmap_decompose_progress_share(NULL) == 0, "no progress");
}

int main(void) {
    make_u();
    good_calls();
    bad_calls();
    printf("%d checks, %d failures\n", checks, failures);
    return failures != 0;
}
