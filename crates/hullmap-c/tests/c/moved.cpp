// hullmap::moved, frames and hullmap::vectors, compared with what the library does with the poses.
#include <cmath>
#include <cstdio>
#include <hullmap.hpp>
#include <initializer_list>

using hullmap::Pose;
using hullmap::Vec3;
using namespace hullmap::vectors;

static int checks = 0, failures = 0;

static void expect(bool holds, const char *what) {
    ++checks;
    if (!holds) {
        ++failures;
        std::fprintf(stderr, "failed: %s\n", what);
    }
}

static bool near(Vec3 a, Vec3 b) { return length(a - b) < 1e-12; }

int main() {
    const double right = std::acos(0.0);
    const Pose origin = hullmap::identity;

    // A turn to the left around z: what is on the x axis of the world is on -y of the body.
    Pose turned = hullmap::moved(origin, {1.0, 2.0, 3.0}, {0.0, 0.0, right});
    expect(near(turned.translation, {1.0, 2.0, 3.0}), "translation");
    Pose ahead = origin;
    ahead.translation = {2.0, 2.0, 3.0};
    expect(near(hullmap::relative(turned, ahead).translation, {0.0, -1.0, 0.0}), "sense of rotation");

    expect(near(hullmap::point_in(turned, {2.0, 2.0, 3.0}), {0.0, -1.0, 0.0}), "a point in a frame");
    expect(near(hullmap::direction_in(turned, {1.0, 0.0, 0.0}), {0.0, -1.0, 0.0}), "a direction in a frame");

    // Then around x of the world, and not of the body.
    auto brick = hullmap::Shape::cuboid({3.0, 2.0, 1.0});
    expect(near(brick.bounds(hullmap::moved(origin, {}, {0.0, 0.0, right})).max, {2.0, 3.0, 1.0}), "around z");
    Pose both = hullmap::moved(hullmap::moved(origin, {}, {0.0, 0.0, right}), {}, {right, 0.0, 0.0});
    expect(near(brick.bounds(both).max, {2.0, 1.0, 3.0}), "around axes of the outer frame");

    // Many steps are one turn, however small they are; no turn is no turn; the length is 1.
    for (int steps : {1, 7, 100000}) {
        Pose pose{{}, {0.2, 0.1, 0.0, 1.0}}, start = hullmap::moved(pose, {}, {});
        Vec3 turn{0.3, -0.7, 1.1};
        for (int i = 0; i < steps; ++i) {
            pose = hullmap::moved(pose, {}, (1.0 / steps) * turn);
        }
        Pose once = hullmap::moved(start, {}, turn);
        Vec3 found{pose.rotation.x, pose.rotation.y, pose.rotation.z};
        expect(length(found - Vec3{once.rotation.x, once.rotation.y, once.rotation.z}) < 1e-10, "steps");
        expect(std::abs(dot(found, found) + pose.rotation.w * pose.rotation.w - 1.0) < 1e-14, "length");
        expect(std::abs(start.rotation.x / start.rotation.w - 0.2) < 1e-15, "no turn");
    }
    Pose tiny = hullmap::moved(origin, {}, {4e-12, 0.0, 0.0});
    expect(std::abs(tiny.rotation.x - 2e-12) < 1e-26, "tiny turn");

    Vec3 sum{1.0, 2.0, 3.0};
    sum += 2.0 * Vec3{1.0, 0.0, -1.0};
    expect(near(sum, {3.0, 2.0, 1.0}), "+=");
    expect(near(cross({1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}), {0.0, 0.0, 1.0}), "cross");

    hullmap::Manifold first(1), second(1);
    first.update(brick, brick, {{0.0, 0.0, 1.999}, {0.0, 0.0, 0.0, 1.0}});
    expect(first.size() == 4, "a manifold has points");
    second = std::move(first);
    expect(second.size() == 4 && first.size() == 0, "one that was moved from has none");
    std::printf("%d checks, %d failures\n", checks, failures);
    return failures == 0 ? 0 : 1;
}
