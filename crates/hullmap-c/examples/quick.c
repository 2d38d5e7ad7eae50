/* A tour of the interface: quick PACK */
#include <hullmap.h>
#include <stdio.h>

/* Ends the program with the message of the library if a call has failed. */
#define CHECK(call)                                                          \
    do {                                                                     \
        if ((call) != HULLMAP_RESULT_OK) {                                   \
            fprintf(stderr, "quick: %s\n", hullmap_last_error());            \
            return 1;                                                        \
        }                                                                    \
    } while (0)

int main(int count, char **arguments) {
    if (count != 2) {
        fputs("usage: quick PACK\n", stderr);
        return 2;
    }
    printf("hullmap %s\n", hullmap_version());

    HullmapPack *pack;
    CHECK(hullmap_pack_open(arguments[1], 0, &pack));

    HullmapHullFacts facts;
    facts.struct_size = sizeof facts;
    CHECK(hullmap_pack_hull_facts(pack, 0, &facts));
    printf("%.*s: %zu vertices, %zu faces, volume %g\n", (int)facts.name.length, facts.name.data,
           facts.vertex_count, facts.face_count, facts.volume);

    HullmapHullArrays arrays;
    CHECK(hullmap_pack_hull_arrays(pack, 0, &arrays));
    printf("vertex 0 is at (%g, %g, %g)\n", arrays.vertices[0], arrays.vertices[1], arrays.vertices[2]);

    /* A shape keeps what it needs of the pack. */
    HullmapShape *hull, *ball;
    CHECK(hullmap_shape_hull(pack, 0, &hull));
    hullmap_pack_free(pack);
    CHECK(hullmap_shape_sphere(0.5, &ball));

    HullmapVec3 up = {0.0, 0.0, 1.0};
    HullmapSupportPoint top;
    CHECK(hullmap_support(hull, &up, 1, &top));
    printf("the highest vertex is %u, at z = %g\n", (unsigned)top.feature, top.point.z);

    /* The ball a quarter of its radius deep in the hull, and then above it. */
    HullmapCache *cache;
    CHECK(hullmap_cache_new(&cache));
    HullmapPose ball_in_hull = HULLMAP_POSE_IDENTITY;
    ball_in_hull.translation = top.point;
    ball_in_hull.translation.z += 0.375;
    HullmapContact contact;
    CHECK(hullmap_contact(hull, ball, &ball_in_hull, NULL, cache, &contact));
    printf("%s, %.3f deep (certainly between %.9f and %.9f)\n", contact.hit ? "contact" : "no contact",
           contact.depth, contact.depth_lower, contact.depth_upper);

    ball_in_hull.translation.z += 1.0;
    HullmapSettings settings = HULLMAP_SETTINGS_DEFAULT;
    settings.tolerance = 1e-9;
    HullmapDistance gap;
    CHECK(hullmap_distance(hull, ball, &ball_in_hull, &settings, cache, &gap));
    printf("then %.3f apart\n", gap.distance);

    HullmapVec3 origin = top.point, down = {0.0, 0.0, -1.0};
    origin.z += 2.0;
    HullmapRayHit hit;
    CHECK(hullmap_ray(hull, origin, down, NULL, &hit));
    printf("a ray from above hits after %.3f\n", hit.t);

    /* Failures have a code for the program and a message for people. */
    ball_in_hull.rotation.w = 0.0;
    HullmapResult result = hullmap_contact(hull, ball, &ball_in_hull, NULL, cache, &contact);
    printf("%s: %s\n", hullmap_result_name(result), hullmap_last_error());

    hullmap_cache_free(cache);
    hullmap_shape_free(ball);
    hullmap_shape_free(hull);
    return result == HULLMAP_RESULT_INVALID_ARGUMENT && contact.hit && gap.distance > 0.5 && hit.hit ? 0 : 1;
}
