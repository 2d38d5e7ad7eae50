/* Calls that break rules which the library can check: hostile PACK
 *
 * Prints each expectation that fails, and exits with 1 if there was one. */
#include <hullmap.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static unsigned failures = 0, checks = 0;

#define EXPECT(condition)                                                           \
    do {                                                                            \
        ++checks;                                                                   \
        if (!(condition)) {                                                         \
            printf("line %d: %s (%s)\n", __LINE__, #condition, hullmap_last_error()); \
            ++failures;                                                             \
        }                                                                           \
    } while (0)

/* The call fails with this result, and the message holds these words. */
#define FAILS(result, words, call)                                  \
    do {                                                            \
        EXPECT((call) == (result));                                 \
        EXPECT(strstr(hullmap_last_error(), words) != NULL);        \
    } while (0)

#define OK(call) EXPECT((call) == HULLMAP_RESULT_OK)

static unsigned char *file;
static size_t length;

static void read_file(const char *path) {
    FILE *in = fopen(path, "rb");
    if (in == NULL) {
        perror(path);
        exit(2);
    }
    fseek(in, 0, SEEK_END);
    length = (size_t)ftell(in);
    rewind(in);
    file = malloc(length);
    if (file == NULL || fread(file, 1, length, in) != length) {
        perror(path);
        exit(2);
    }
    fclose(in);
}

static void opening(const char *path) {
    HullmapPack *pack = (HullmapPack *)&failures;
    FAILS(HULLMAP_RESULT_NULL, "path", hullmap_pack_open(NULL, 0, &pack));
    EXPECT(pack == NULL);
    FAILS(HULLMAP_RESULT_NULL, "pack", hullmap_pack_open(path, 0, NULL));
    FAILS(HULLMAP_RESULT_IO, "no/such/file", hullmap_pack_open("no/such/file", 0, &pack));
    FAILS(HULLMAP_RESULT_IO, "no/such/file", hullmap_pack_open("no/such/file", HULLMAP_OPEN_MAP, &pack));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "0x80", hullmap_pack_open(path, 0x80, &pack));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "flag", hullmap_pack_open(path, HULLMAP_OPEN_BORROW, &pack));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "flag", hullmap_pack_from_memory(file, length, HULLMAP_OPEN_MAP, &pack));
    EXPECT(pack == NULL);
    for (uint32_t flags = 0; flags <= HULLMAP_OPEN_SKIP_CONTENTS; flags += HULLMAP_OPEN_SKIP_CONTENTS) {
        for (uint32_t map = 0; map <= HULLMAP_OPEN_MAP; ++map) {
            OK(hullmap_pack_open(path, flags | map, &pack));
            EXPECT(hullmap_pack_hull_count(pack) >= 1);
            hullmap_pack_free(pack);
        }
        OK(hullmap_pack_from_memory(file, length, flags, &pack));
        hullmap_pack_free(pack);
    }
    hullmap_pack_free(NULL);

    /* A long path: the message keeps its end. */
    char *name = malloc(3001);
    memset(name, 'x', 3000);
    name[3000] = 0;
    FAILS(HULLMAP_RESULT_IO, "cannot read the file", hullmap_pack_open(name, 0, &pack));
    EXPECT(strlen(hullmap_last_error()) == 1023);
    free(name);
    /* A missing file: the message has a remedy. */
    FAILS(HULLMAP_RESULT_IO, "; check the path", hullmap_pack_open("missing.hullmap", 0, &pack));
    FAILS(HULLMAP_RESULT_IO, "; check the path", hullmap_pack_open("missing.hullmap", HULLMAP_OPEN_MAP, &pack));
}

static void meshes(const char *path) {
    HullmapTriangleMesh *mesh;
    FAILS(HULLMAP_RESULT_NULL, "path", hullmap_triangle_mesh_open(NULL, &mesh));
    FAILS(HULLMAP_RESULT_NULL, "mesh", hullmap_triangle_mesh_open(path, NULL));
    FAILS(HULLMAP_RESULT_IO, "no/such/file", hullmap_triangle_mesh_open("no/such/file", &mesh));
    FAILS(HULLMAP_RESULT_INVALID_PACK, "not a hullmap triangle mesh", hullmap_triangle_mesh_open(path, &mesh));
    FAILS(HULLMAP_RESULT_INVALID_PACK, "", hullmap_triangle_mesh_from_memory(file, length, &mesh));
    EXPECT(mesh == NULL);
    FAILS(HULLMAP_RESULT_NULL, "bytes", hullmap_triangle_mesh_from_memory(NULL, 5, &mesh));
    EXPECT(hullmap_triangle_mesh_triangle_count(NULL) == 0 && hullmap_triangle_mesh_vertex_count(NULL) == 0);
    HullmapMeshTriangle triangle;
    FAILS(HULLMAP_RESULT_NULL, "mesh", hullmap_triangle_mesh_triangle(NULL, 0, &triangle));
    HullmapShape *shape;
    FAILS(HULLMAP_RESULT_NULL, "mesh", hullmap_shape_triangle_mesh(NULL, &shape));
    EXPECT(shape == NULL);
    hullmap_triangle_mesh_free(NULL);
}

static void fields(const char *path) {
    HullmapHeightField *field;
    FAILS(HULLMAP_RESULT_NULL, "path", hullmap_height_field_open(NULL, &field));
    FAILS(HULLMAP_RESULT_NULL, "field", hullmap_height_field_open(path, NULL));
    FAILS(HULLMAP_RESULT_IO, "no/such/file", hullmap_height_field_open("no/such/file", &field));
    FAILS(HULLMAP_RESULT_INVALID_PACK, "not a hullmap height field", hullmap_height_field_open(path, &field));
    FAILS(HULLMAP_RESULT_INVALID_PACK, "", hullmap_height_field_from_memory(file, length, &field));
    EXPECT(field == NULL);
    FAILS(HULLMAP_RESULT_NULL, "bytes", hullmap_height_field_from_memory(NULL, 5, &field));
    EXPECT(hullmap_height_field_triangle_count(NULL) == 0);
    HullmapMeshTriangle triangle;
    FAILS(HULLMAP_RESULT_NULL, "field", hullmap_height_field_triangle(NULL, 0, &triangle));
    HullmapFieldLayout layout;
    FAILS(HULLMAP_RESULT_NULL, "field", hullmap_height_field_layout(NULL, &layout));
    HullmapGround ground;
    FAILS(HULLMAP_RESULT_NULL, "field", hullmap_height_field_height_at(NULL, 0.0, 0.0, &ground));
    HullmapShape *shape;
    FAILS(HULLMAP_RESULT_NULL, "field", hullmap_shape_height_field(NULL, &shape));
    EXPECT(shape == NULL);
    hullmap_height_field_free(NULL);
}

static void memory(void) {
    HullmapPack *pack;
    FAILS(HULLMAP_RESULT_NULL, "bytes", hullmap_pack_from_memory(NULL, 5, 0, &pack));
    FAILS(HULLMAP_RESULT_INVALID_PACK, "0 bytes", hullmap_pack_from_memory(NULL, 0, 0, &pack));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "bytes", hullmap_pack_from_memory(file, SIZE_MAX, 0, &pack));
    /* Every length but the right one, with a copy that ends where the bytes do. */
    for (size_t cut = 0; cut < length; cut += cut < 100 ? 1 : 97) {
        unsigned char *part = malloc(cut + 1);
        memcpy(part, file, cut);
        FAILS(HULLMAP_RESULT_INVALID_PACK, "", hullmap_pack_from_memory(part, cut, 0, &pack));
        FAILS(HULLMAP_RESULT_INVALID_PACK, "",
              hullmap_pack_from_memory(part, cut, HULLMAP_OPEN_SKIP_CONTENTS, &pack));
        EXPECT(pack == NULL);
        free(part);
    }
    /* Flipped bits: a full check finds each of them. */
    unsigned char *copy = malloc(length + 128);
    unsigned char *aligned = copy + (64 - (size_t)copy % 64) % 64;
    for (size_t at = 0; at < length; at += 61) {
        memcpy(aligned, file, length);
        aligned[at] ^= (unsigned char)(1u << at % 8);
        FAILS(HULLMAP_RESULT_INVALID_PACK, "", hullmap_pack_from_memory(aligned, length, 0, &pack));
        FAILS(HULLMAP_RESULT_INVALID_PACK, "", hullmap_pack_from_memory(aligned, length, HULLMAP_OPEN_BORROW, &pack));
    }
    /* Borrowed memory must be aligned; a copy need not be. */
    for (size_t shift = 0; shift < 64; ++shift) {
        memmove(aligned + shift, file, length);
        OK(hullmap_pack_from_memory(aligned + shift, length, 0, &pack));
        hullmap_pack_free(pack);
        HullmapResult result = hullmap_pack_from_memory(aligned + shift, length, HULLMAP_OPEN_BORROW, &pack);
        EXPECT(result == (shift == 0 ? HULLMAP_RESULT_OK : HULLMAP_RESULT_INVALID_ARGUMENT));
        EXPECT(shift == 0 || strstr(hullmap_last_error(), "aligned") != NULL);
        hullmap_pack_free(pack);
    }
    /* The arrays of a borrowed pack are in the caller's memory. */
    memcpy(aligned, file, length);
    OK(hullmap_pack_from_memory(aligned, length, HULLMAP_OPEN_BORROW | HULLMAP_OPEN_SKIP_CONTENTS, &pack));
    HullmapHullArrays arrays;
    OK(hullmap_pack_hull_arrays(pack, 0, &arrays));
    const unsigned char *first = (const unsigned char *)arrays.vertices;
    EXPECT(first > aligned && first < aligned + length);
    hullmap_pack_free(pack);
    free(copy);
}

/* Damaged contents that nobody has checked: wrong answers or HULLMAP_RESULT_PANIC, nothing worse. */
static void unchecked(void) {
    unsigned opened = 0, panics = 0;
    unsigned char *copy = malloc(length);
    for (size_t at = 64; at < length; at += length < 10000 ? 5 : 401) {
        memcpy(copy, file, length);
        copy[at] ^= (unsigned char)(1u << at % 8);
        HullmapPack *pack;
        if (hullmap_pack_from_memory(copy, length, HULLMAP_OPEN_SKIP_CONTENTS, &pack) != HULLMAP_RESULT_OK) {
            continue;
        }
        ++opened;
        HullmapShape *shape;
        HullmapManifold *manifold;
        OK(hullmap_shape_hull(pack, 0, &shape));
        hullmap_pack_free(pack);
        OK(hullmap_manifold_new(1, &manifold));
        HullmapPose pose = HULLMAP_POSE_IDENTITY;
        for (int i = 0; i < 4; ++i) {
            pose.translation.z = 0.4 * i;
            pose.rotation.y = 0.1 * i;
            HullmapVec3 direction = {0.1 * i, -1.0, 0.3};
            HullmapSupportPoint support;
            HullmapContact contact;
            HullmapDistance gap;
            HullmapManifoldPoints points;
            HullmapResult results[4];
            results[0] = hullmap_support(shape, &direction, 1, &support);
            results[1] = hullmap_contact(shape, shape, &pose, NULL, NULL, &contact);
            results[2] = hullmap_distance(shape, shape, &pose, NULL, NULL, &gap);
            results[3] = hullmap_manifold_update(manifold, shape, shape, &pose, NULL, &points);
            for (int j = 0; j < 4; ++j) {
                EXPECT(results[j] == HULLMAP_RESULT_OK || results[j] == HULLMAP_RESULT_PANIC);
                panics += results[j] == HULLMAP_RESULT_PANIC;
            }
        }
        hullmap_manifold_free(manifold);
        hullmap_shape_free(shape);
    }
    printf("%u damaged packs opened unchecked, %u queries ended by a panic\n", opened, panics);
    EXPECT(opened > 20);
    free(copy);
}

static void packs(const HullmapPack *pack) {
    size_t index;
    HullmapHullFacts facts;
    HullmapHullArrays arrays;
    EXPECT(hullmap_pack_hull_count(NULL) == 0);
    facts.struct_size = sizeof facts;
    OK(hullmap_pack_hull_facts(pack, 0, &facts));
    char names[64];
    snprintf(names, sizeof names, "the pack has 1 (%.*s)", (int)facts.name.length, facts.name.data);
    FAILS(HULLMAP_RESULT_NOT_FOUND, names, hullmap_pack_find(pack, "no such hull", &index));
    FAILS(HULLMAP_RESULT_NOT_FOUND, names, hullmap_pack_find(pack, "\xff\xfe", &index));
    FAILS(HULLMAP_RESULT_NULL, "name", hullmap_pack_find(pack, NULL, &index));
    FAILS(HULLMAP_RESULT_NULL, "index", hullmap_pack_find(pack, "x", NULL));
    facts.struct_size = sizeof facts;
    FAILS(HULLMAP_RESULT_NOT_FOUND, "out of range", hullmap_pack_hull_facts(pack, 99, &facts));
    HullmapReplacement primitive;
    FAILS(HULLMAP_RESULT_NOT_FOUND, "out of range", hullmap_pack_hull_primitive(pack, 99, &primitive));
    FAILS(HULLMAP_RESULT_NULL, "primitive", hullmap_pack_hull_primitive(pack, 0, NULL));
    FAILS(HULLMAP_RESULT_NULL, "pack", hullmap_pack_hull_primitive(NULL, 0, &primitive));
    FAILS(HULLMAP_RESULT_NOT_FOUND, "out of range", hullmap_pack_hull_facts(pack, SIZE_MAX, &facts));
    FAILS(HULLMAP_RESULT_NULL, "facts", hullmap_pack_hull_facts(pack, 0, NULL));
    FAILS(HULLMAP_RESULT_NULL, "mass", hullmap_pack_mass_properties(pack, 0, 1, 1.0, NULL));
    FAILS(HULLMAP_RESULT_NULL, "pack", hullmap_pack_hull_facts(NULL, 0, &facts));
    for (size_t size = 0; size < 1000; size += 3) {
        facts.struct_size = size;
        if (size != sizeof facts) {
            FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "struct_size", hullmap_pack_hull_facts(pack, 0, &facts));
        }
    }
    FAILS(HULLMAP_RESULT_NOT_FOUND, "out of range", hullmap_pack_hull_arrays(pack, 99, &arrays));
    FAILS(HULLMAP_RESULT_NULL, "arrays", hullmap_pack_hull_arrays(pack, 0, NULL));
}

static const double bad_numbers[] = {NAN, -NAN, INFINITY, -INFINITY, 1e39, -1e39, 1e308};

static void shapes(const HullmapPack *pack) {
    HullmapShape *shape;
    HullmapVec3 zero = {0.0, 0.0, 0.0};
    FAILS(HULLMAP_RESULT_NOT_FOUND, "out of range", hullmap_shape_hull(pack, 99, &shape));
    EXPECT(shape == NULL);
    FAILS(HULLMAP_RESULT_NULL, "pack", hullmap_shape_hull(NULL, 0, &shape));
    FAILS(HULLMAP_RESULT_NULL, "shape", hullmap_shape_hull(pack, 0, NULL));
    FAILS(HULLMAP_RESULT_NULL, "pack", hullmap_shape_compound(NULL, &shape));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "scale", hullmap_shape_scaled_hull(pack, 0, zero, &shape));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "normal", hullmap_shape_half_space(zero, 0.0, &shape));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "radius", hullmap_shape_sphere(-1.0, &shape));
    for (size_t i = 0; i < sizeof bad_numbers / sizeof *bad_numbers; ++i) {
        double bad = bad_numbers[i];
        HullmapVec3 vector = {1.0, bad, 1.0}, up = {0.0, 0.0, 1.0};
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "radius", hullmap_shape_sphere(bad, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "half edge", hullmap_shape_cuboid(vector, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "half length", hullmap_shape_capsule(bad, 1.0, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "radius", hullmap_shape_cylinder(1.0, bad, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "half height", hullmap_shape_cone(bad, 1.0, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "end", hullmap_shape_segment(up, vector, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "corner", hullmap_shape_triangle(up, vector, zero, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "offset", hullmap_shape_half_space(up, bad, &shape));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "scale", hullmap_shape_scaled_hull(pack, 0, vector, &shape));
        EXPECT(shape == NULL);
    }
    hullmap_shape_free(NULL);
}

static void queries(const HullmapPack *pack) {
    HullmapShape *hull, *both, *floor, *ball;
    HullmapVec3 up = {0.0, 0.0, 1.0};
    OK(hullmap_shape_hull(pack, 0, &hull));
    OK(hullmap_shape_compound(pack, &both));
    OK(hullmap_shape_half_space(up, 0.0, &floor));
    OK(hullmap_shape_sphere(0.0, &ball));
    HullmapCache *cache;
    OK(hullmap_cache_new(&cache));
    HullmapManifold *manifold;
    OK(hullmap_manifold_new(0, &manifold));
    HullmapPose pose = HULLMAP_POSE_IDENTITY;
    HullmapContact contact;
    HullmapDistance gap;
    HullmapIntersection intersection;
    HullmapManifoldPoints points;
    HullmapImpact impact;
    HullmapRayHit hit;
    HullmapSignedDistance signed_distance;
    HullmapBounds bounds;
    HullmapSupportPoint support;

    /* NULL in each place. */
    FAILS(HULLMAP_RESULT_NULL, "a is", hullmap_contact(NULL, hull, &pose, NULL, cache, &contact));
    FAILS(HULLMAP_RESULT_NULL, "b is", hullmap_contact(hull, NULL, &pose, NULL, cache, &contact));
    FAILS(HULLMAP_RESULT_NULL, "b_in_a", hullmap_contact(hull, hull, NULL, NULL, cache, &contact));
    FAILS(HULLMAP_RESULT_NULL, "out", hullmap_contact(hull, hull, &pose, NULL, cache, NULL));
    FAILS(HULLMAP_RESULT_NULL, "out", hullmap_distance(hull, hull, &pose, NULL, cache, NULL));
    FAILS(HULLMAP_RESULT_NULL, "out", hullmap_intersects(hull, hull, &pose, cache, NULL));
    FAILS(HULLMAP_RESULT_NULL, "manifold", hullmap_manifold_update(NULL, hull, hull, &pose, NULL, &points));
    FAILS(HULLMAP_RESULT_NULL, "out", hullmap_manifold_update(manifold, hull, hull, &pose, NULL, NULL));
    FAILS(HULLMAP_RESULT_NULL, "shape", hullmap_ray(NULL, up, up, NULL, &hit));
    FAILS(HULLMAP_RESULT_NULL, "shape", hullmap_signed_distance(NULL, up, NULL, NULL, &signed_distance));
    FAILS(HULLMAP_RESULT_NULL, "shape", hullmap_bounds(NULL, &pose, &bounds));
    FAILS(HULLMAP_RESULT_NULL, "directions", hullmap_support(hull, NULL, 1, &support));
    FAILS(HULLMAP_RESULT_NULL, "out", hullmap_support(hull, &up, 1, NULL));
    OK(hullmap_support(hull, NULL, 0, NULL));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "count", hullmap_support(hull, &up, SIZE_MAX, &support));
    FAILS(HULLMAP_RESULT_NULL, "cache", hullmap_cache_clear(NULL));
    FAILS(HULLMAP_RESULT_NULL, "cache", hullmap_cache_new(NULL));
    FAILS(HULLMAP_RESULT_NULL, "manifold", hullmap_manifold_clear(NULL));
    FAILS(HULLMAP_RESULT_NULL, "manifold", hullmap_manifold_new(1, NULL));
    FAILS(HULLMAP_RESULT_NULL, "b_in_world", hullmap_pose_relative(&pose, NULL, &pose));
    hullmap_cache_free(NULL);
    hullmap_manifold_free(NULL);

    /* A pointer that is not aligned. */
    double room[sizeof(HullmapPose) / sizeof(double) + 2];
    const HullmapPose *odd = (const HullmapPose *)(const void *)((char *)room + 4);
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "aligned", hullmap_contact(hull, hull, odd, NULL, cache, &contact));

    /* Numbers that are none, in each place. */
    for (size_t i = 0; i < sizeof bad_numbers / sizeof *bad_numbers; ++i) {
        HullmapPose bad = pose;
        double *numbers = &bad.translation.x;
        for (size_t at = 0; at < 3; ++at) {
            bad = pose;
            numbers[at] = bad_numbers[i];
            FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "b_in_a", hullmap_contact(hull, ball, &bad, NULL, cache, &contact));
            FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "translation",
                  hullmap_distance(both, ball, &bad, NULL, cache, &gap));
            FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "b_in_a",
                  hullmap_manifold_update(manifold, floor, ball, &bad, NULL, &points));
            FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "pose", hullmap_bounds(hull, &bad, &bounds));
        }
        HullmapVec3 vector = {bad_numbers[i], 0.0, 0.0};
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "origin", hullmap_ray(hull, vector, up, NULL, &hit));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "direction", hullmap_ray(hull, up, vector, NULL, &hit));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "point",
              hullmap_signed_distance(hull, vector, NULL, NULL, &signed_distance));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "point",
              hullmap_signed_distance(both, vector, NULL, cache, &signed_distance));
        FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "velocity",
              hullmap_cast(hull, ball, &pose, vector, NULL, NULL, &impact));
        /* Any direction has a support point. */
        OK(hullmap_support(hull, &vector, 1, &support));
        HullmapSettings settings = HULLMAP_SETTINGS_DEFAULT;
        settings.tolerance = bad_numbers[i];
        settings.max_iterations = UINT32_MAX;
        OK(hullmap_contact(hull, hull, &pose, &settings, NULL, &contact));
        EXPECT(contact.hit && contact.depth_lower <= contact.depth_upper);
        HullmapManifoldSettings manifold_settings = HULLMAP_MANIFOLD_SETTINGS_DEFAULT;
        manifold_settings.prediction = bad_numbers[i];
        manifold_settings.prediction_kind = i % 2;
        OK(hullmap_manifold_update(manifold, hull, hull, &pose, &manifold_settings, &points));
    }
    HullmapPose unset;
    memset(&unset, 0, sizeof unset);
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "zero quaternion", hullmap_intersects(hull, ball, &unset, NULL, &intersection));

    /* Settings of another version, or without a size. */
    HullmapSettings settings = HULLMAP_SETTINGS_DEFAULT;
    HullmapCastSettings cast_settings = HULLMAP_CAST_SETTINGS_DEFAULT;
    HullmapManifoldSettings manifold_settings = HULLMAP_MANIFOLD_SETTINGS_DEFAULT;
    settings.struct_size = cast_settings.struct_size = manifold_settings.struct_size = 0;
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "struct_size", hullmap_contact(hull, hull, &pose, &settings, NULL, &contact));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "struct_size", hullmap_ray(hull, up, up, &cast_settings, &hit));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "struct_size",
          hullmap_manifold_update(manifold, hull, hull, &pose, &manifold_settings, &points));
    manifold_settings.struct_size = sizeof manifold_settings;
    manifold_settings.prediction_kind = 7;
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "HullmapPrediction",
          hullmap_manifold_update(manifold, hull, hull, &pose, &manifold_settings, &points));
    hullmap_manifold_free(manifold);
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "max_pairs", hullmap_manifold_new(UINT32_MAX, &manifold));
    EXPECT(manifold == NULL);
    OK(hullmap_manifold_new(1, &manifold));

    /* Pairs without such a query. */
    OK(hullmap_contact(hull, floor, &pose, NULL, NULL, &contact));
    FAILS(HULLMAP_RESULT_UNSUPPORTED, "two half-spaces", hullmap_contact(floor, floor, &pose, NULL, NULL, &contact));
    OK(hullmap_cast(both, hull, &pose, up, NULL, NULL, &impact));
    EXPECT(impact.parts[0] == 0 && impact.parts[1] == 0);
    OK(hullmap_ray(both, up, up, NULL, &hit));
    EXPECT(hit.part == 0);
    FAILS(HULLMAP_RESULT_UNSUPPORTED, "one by one", hullmap_support(both, &up, 1, &support));
    FAILS(HULLMAP_RESULT_UNSUPPORTED, "unbounded", hullmap_bounds(floor, &pose, &bounds));

    /* A failed call leaves its answer alone, and the message in place until the next failure. */
    memset(&contact, 0x5a, sizeof contact);
    HullmapContact before = contact;
    FAILS(HULLMAP_RESULT_UNSUPPORTED, "two half-spaces", hullmap_contact(floor, floor, &pose, NULL, NULL, &contact));
    EXPECT(memcmp(&before, &contact, sizeof contact) == 0);
    OK(hullmap_contact(hull, hull, &pose, NULL, NULL, &contact));
    EXPECT(strstr(hullmap_last_error(), "two half-spaces") != NULL);

    /* A cache of other shapes does no harm. */
    for (int i = 0; i < 20; ++i) {
        const HullmapShape *all[] = {hull, both, ball};
        pose.translation.x = 0.05 * i;
        OK(hullmap_contact(all[i % 3], all[i / 3 % 3], &pose, NULL, cache, &contact));
        OK(hullmap_distance(all[i / 3 % 3], all[i % 3], &pose, NULL, cache, &gap));
        OK(hullmap_manifold_update(manifold, all[i % 3], all[i / 3 % 3], &pose, NULL, &points));
        for (size_t at = 0; at < points.count; ++at) {
            points.points[at].impulse[0] = NAN;
            points.points[at].depth = NAN;
        }
    }

    /* Batches: one wrong pair, wrong counts. */
    HullmapPair pairs[3];
    for (int i = 0; i < 3; ++i) {
        pairs[i].a = hull;
        pairs[i].b = ball;
        pairs[i].b_in_a = pose;
    }
    HullmapContact contacts[3];
    OK(hullmap_batch_contact(pairs, 3, NULL, NULL, contacts));
    OK(hullmap_batch_contact(NULL, 0, NULL, NULL, NULL));
    FAILS(HULLMAP_RESULT_NULL, "pairs", hullmap_batch_contact(NULL, 3, NULL, NULL, contacts));
    FAILS(HULLMAP_RESULT_NULL, "out", hullmap_batch_contact(pairs, 3, NULL, NULL, NULL));
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "pairs", hullmap_batch_contact(pairs, SIZE_MAX, NULL, NULL, contacts));
    HullmapCache *caches[3] = {cache, NULL, NULL};
    FAILS(HULLMAP_RESULT_NULL, "caches[1]", hullmap_batch_contact(pairs, 3, NULL, caches, contacts));
    caches[1] = cache;
    FAILS(HULLMAP_RESULT_BUSY, "caches[1]", hullmap_batch_contact(pairs, 2, NULL, caches, contacts));
    OK(hullmap_batch_contact(pairs, 1, NULL, caches, contacts));
    HullmapManifold *manifolds[3] = {manifold, manifold, NULL};
    HullmapManifoldPoints shown[3];
    FAILS(HULLMAP_RESULT_BUSY, "manifolds[1]", hullmap_batch_manifolds(pairs, 2, NULL, manifolds, shown));
    FAILS(HULLMAP_RESULT_NULL, "manifolds[2]", hullmap_batch_manifolds(pairs, 3, NULL, manifolds, shown));
    FAILS(HULLMAP_RESULT_NULL, "manifolds", hullmap_batch_manifolds(pairs, 3, NULL, NULL, shown));
    pairs[2].b_in_a.translation.y = NAN;
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "pairs[2]: b_in_a",
          hullmap_batch_distance(pairs, 3, NULL, NULL, &gap));
    pairs[1].a = NULL;
    FAILS(HULLMAP_RESULT_NULL, "pairs[1]: a", hullmap_batch_intersects(pairs, 3, NULL, &intersection));
    pairs[0].a = pairs[0].b = floor;
    FAILS(HULLMAP_RESULT_UNSUPPORTED, "pairs[0]: two half-spaces", hullmap_batch_contact(pairs, 3, NULL, NULL, contacts));

    hullmap_manifold_free(manifold);
    hullmap_cache_free(cache);
    hullmap_shape_free(ball);
    hullmap_shape_free(floor);
    hullmap_shape_free(both);
    hullmap_shape_free(hull);
}

/* Many threads: one pair of shapes for all, a cache for each, and one cache for all, which is
 * allowed to be busy and nothing else. */

typedef struct {
    const HullmapShape *a, *b;
    HullmapCache *common;
    HullmapContact last;
    unsigned busy, wrong;
} Work;

static void *work(void *argument) {
    Work *work = argument;
    HullmapCache *own;
    work->wrong += hullmap_cache_new(&own) != HULLMAP_RESULT_OK;
    HullmapPose pose = HULLMAP_POSE_IDENTITY;
    for (int i = 0; i < 2000; ++i) {
        pose.translation.x = 0.0005 * i;
        HullmapResult result = hullmap_contact(work->a, work->b, &pose, NULL, work->common, &work->last);
        work->busy += result == HULLMAP_RESULT_BUSY;
        work->wrong += result != HULLMAP_RESULT_BUSY && result != HULLMAP_RESULT_OK;
        work->wrong += result == HULLMAP_RESULT_BUSY && strstr(hullmap_last_error(), "in use") == NULL;
        work->wrong += hullmap_contact(work->a, work->b, &pose, NULL, own, &work->last) != HULLMAP_RESULT_OK;
    }
    HullmapPair pairs[100];
    HullmapContact contacts[100];
    for (int i = 0; i < 100; ++i) {
        pairs[i].a = work->a;
        pairs[i].b = work->b;
        pairs[i].b_in_a = pose;
    }
    work->wrong += hullmap_batch_contact(pairs, 100, NULL, NULL, contacts) != HULLMAP_RESULT_OK;
    work->wrong += contacts[99].depth != contacts[0].depth;
    hullmap_cache_free(own);
    return NULL;
}

static void threads(const HullmapPack *pack) {
    enum { COUNT = 8 };
    pthread_t threads[COUNT];
    Work works[COUNT];
    HullmapShape *a, *b;
    HullmapCache *common;
    OK(hullmap_shape_hull(pack, 0, &a));
    OK(hullmap_shape_compound(pack, &b));
    OK(hullmap_cache_new(&common));
    unsigned busy = 0;
    for (int i = 0; i < COUNT; ++i) {
        memset(&works[i], 0, sizeof works[i]);
        works[i].a = a;
        works[i].b = b;
        works[i].common = common;
        EXPECT(pthread_create(&threads[i], NULL, work, &works[i]) == 0);
    }
    for (int i = 0; i < COUNT; ++i) {
        EXPECT(pthread_join(threads[i], NULL) == 0);
        EXPECT(works[i].wrong == 0);
        EXPECT(works[i].last.depth == works[0].last.depth);
        busy += works[i].busy;
    }
    printf("%u of %d calls found the common cache in use\n", busy, COUNT * 2000);
    hullmap_cache_free(common);
    hullmap_shape_free(b);
    hullmap_shape_free(a);
}

/* Motions and derivatives: answers of a formula, and what is rejected. */
static void moving(void) {
    HullmapPack *pack;
    HullmapShape *hull, *both, *rod, *wall, *floor, *ball;
    HullmapVec3 up = {0.0, 0.0, 1.0};
    OK(hullmap_pack_from_memory(file, length, 0, &pack));
    OK(hullmap_shape_hull(pack, 0, &hull));
    OK(hullmap_shape_compound(pack, &both));
    OK(hullmap_shape_cuboid((HullmapVec3){1.0, 0.01, 0.01}, &rod));
    OK(hullmap_shape_cuboid((HullmapVec3){5.0, 0.1, 5.0}, &wall));
    OK(hullmap_shape_half_space(up, 0.0, &floor));
    OK(hullmap_shape_sphere(0.5, &ball));
    HullmapMotion turning = {HULLMAP_MOTION_KIND_SCREW, HULLMAP_POSE_IDENTITY, HULLMAP_POSE_IDENTITY,
                             {0.0, 0.0, 0.0},           {0.0, 0.0, 1.0},       {0.0, 0.0, 0.0}};
    HullmapMotion still = {HULLMAP_MOTION_KIND_STILL, HULLMAP_POSE_IDENTITY, HULLMAP_POSE_IDENTITY,
                           {0.0, 0.0, 0.0},           {0.0, 0.0, 0.0},       {0.0, 0.0, 0.0}};
    HullmapMotion between = still, bad = turning;
    still.start.translation.y = 0.5;
    HullmapTimeOfImpact found;
    HullmapClearance clear;
    HullmapDerivatives by;
    /* The end of the rod is at height sin(t + 0.01) after the angle t, and the wall is at 0.4. */
    OK(hullmap_cast_motion(rod, &turning, wall, &still, NULL, NULL, &found, &by));
    EXPECT(found.hit && found.t_lower <= found.t && found.t <= found.t_upper);
    EXPECT(found.t > 0.4014 && found.t < 0.4016);
    EXPECT(by.status <= HULLMAP_DIFFERENTIABILITY_INACCURATE);
    OK(hullmap_clear(rod, &turning, wall, &still, NULL, NULL, &clear));
    EXPECT(clear.verdict == HULLMAP_VERDICT_HIT && clear.t_lower <= found.t_upper);
    still.start.translation.y = 1.5;
    HullmapClearSettings clear_settings = HULLMAP_CLEAR_SETTINGS_DEFAULT;
    clear_settings.margin = 0.1;
    OK(hullmap_clear(rod, &turning, wall, &still, &clear_settings, NULL, &clear));
    EXPECT(clear.verdict == HULLMAP_VERDICT_FREE && clear.clearance >= 0.2 && clear.clearance < 0.57);
    /* A ball of radius 0.5 falls by 4 from the height 2. */
    between.kind = HULLMAP_MOTION_KIND_BETWEEN;
    between.start.translation.z = 2.0;
    between.end.translation.z = -2.0;
    still.start.translation.y = 0.0;
    OK(hullmap_cast_motion(floor, &still, ball, &between, NULL, NULL, &found, NULL));
    EXPECT(found.t > 0.37499 && found.t < 0.37501);
    OK(hullmap_cast_motion(ball, &between, floor, &still, NULL, NULL, &found, NULL));
    EXPECT(found.t > 0.37499 && found.t < 0.37501 && found.normal.z < -0.99);
    FAILS(HULLMAP_RESULT_UNSUPPORTED, "two half-spaces",
          hullmap_clear(floor, &still, floor, &still, NULL, NULL, &clear));
    OK(hullmap_clear(floor, &still, ball, &between, NULL, NULL, &clear));
    EXPECT(clear.verdict == HULLMAP_VERDICT_HIT);
    between.end.translation.z = 1.0;
    OK(hullmap_clear(floor, &still, ball, &between, NULL, NULL, &clear));
    EXPECT(clear.verdict == HULLMAP_VERDICT_FREE && clear.clearance >= 0.25 && clear.clearance <= 0.5);
    OK(hullmap_clear(both, &still, hull, &still, NULL, NULL, &clear));
    EXPECT(clear.verdict != HULLMAP_VERDICT_FREE);

    bad.kind = 9;
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "HullmapMotionKind", hullmap_clear(rod, &bad, wall, &still, NULL, NULL, &clear));
    bad.kind = HULLMAP_MOTION_KIND_SCREW;
    bad.angular.x = HUGE_VAL;
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "motion_a",
          hullmap_cast_motion(rod, &bad, wall, &still, NULL, NULL, &found, NULL));
    FAILS(HULLMAP_RESULT_NULL, "motion_b", hullmap_clear(rod, &turning, wall, NULL, NULL, NULL, &clear));
    FAILS(HULLMAP_RESULT_NULL, "out", hullmap_cast_motion(rod, &turning, wall, &still, NULL, NULL, NULL, &by));
    clear_settings.struct_size = 0;
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "struct_size",
          hullmap_clear(rod, &turning, wall, &still, &clear_settings, NULL, &clear));
    HullmapMotionSettings settings = HULLMAP_MOTION_SETTINGS_DEFAULT;
    settings.struct_size = 1;
    FAILS(HULLMAP_RESULT_INVALID_ARGUMENT, "struct_size",
          hullmap_cast_motion(rod, &turning, wall, &still, &settings, NULL, &found, NULL));

    HullmapPose pose = HULLMAP_POSE_IDENTITY;
    HullmapDistance gap;
    HullmapContact contact;
    pose.translation.x = 3.0;
    HullmapWitnessDerivatives witness;
    OK(hullmap_distance_derivatives(ball, ball, &pose, NULL, NULL, &gap, &by, &witness));
    EXPECT(by.status == HULLMAP_DIFFERENTIABILITY_UNIQUE);
    EXPECT(fabs(gap.distance - 2.0) < 1e-12 && fabs(by.by_b.linear.x - 1.0) < 1e-12 && fabs(by.by_a.linear.x + 1.0) < 1e-12);
    /* If B moves along y, the normal turns by a third of that per metre. */
    EXPECT(witness.status == HULLMAP_DIFFERENTIABILITY_UNIQUE && fabs(witness.by_b.normal[1][1] - 1.0 / 3.0) < 1e-12);
    OK(hullmap_contact_derivatives(ball, ball, &pose, NULL, NULL, &contact, &by, &witness));
    EXPECT(!contact.hit && by.status == HULLMAP_DIFFERENTIABILITY_MISSING && by.by_b.linear.x == 0.0);
    FAILS(HULLMAP_RESULT_UNSUPPORTED, "derivatives", hullmap_distance_derivatives(both, ball, &pose, NULL, NULL, &gap, &by, NULL));
    FAILS(HULLMAP_RESULT_NULL, "derivatives", hullmap_distance_derivatives(ball, ball, &pose, NULL, NULL, &gap, NULL, NULL));
    HullmapShape *shapes[6] = {hull, both, rod, wall, floor, ball};
    for (size_t at = 0; at < 6; ++at) hullmap_shape_free(shapes[at]);
    hullmap_pack_free(pack);
}

int main(int count, char **arguments) {
    if (count != 2) {
        fputs("usage: hostile PACK\n", stderr);
        return 2;
    }
    EXPECT(hullmap_last_error()[0] == 0);
    EXPECT(hullmap_abi_version() == HULLMAP_ABI_VERSION);
    read_file(arguments[1]);
    opening(arguments[1]);
    meshes(arguments[1]);
    fields(arguments[1]);
    memory();
    unchecked();
    HullmapPack *pack;
    OK(hullmap_pack_open(arguments[1], 0, &pack));
    packs(pack);
    shapes(pack);
    queries(pack);
    moving();
    threads(pack);
    hullmap_pack_free(pack);
    free(file);
    printf("%u checks, %u failures\n", checks, failures);
    return failures != 0;
}
