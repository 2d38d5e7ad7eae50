// Drops a box on the first hull of a pack, and waits until it rests: settle PACK
//
// The hull must be flat on top, such as baked/cube.hullmap. From other hulls the box falls off.
#include <cmath>
#include <cstdio>
#include <hullmap.hpp>
using namespace hullmap::vectors;

int main(int, char **arguments) try {
    auto pack = hullmap::Pack::open(arguments[1] ? arguments[1] : "baked/cube.hullmap");
    auto ground = hullmap::Shape::hull(pack), box = hullmap::Shape::cuboid({0.25, 0.25, 0.25});
    const double top = pack.facts(0).bounds.max.z, step = 1.0 / 60.0, inertia = 0.125 / 3.0;  // at mass 1
    hullmap::Pose pose{{0.1, 0.0, top + 1.0}, {0.2, 0.1, 0.0, 1.0}};
    hullmap::Vec3 velocity{}, spin{};
    hullmap::Manifold manifold;
    for (int i = 0; i < 600; ++i) {
        velocity.z -= 9.81 * step;
        manifold.update(ground, box, pose);
        for (int k = 0; k < 20; ++k) for (auto &p : manifold) {
            auto arm = p.point_b - pose.translation, lever = cross(arm, p.normal);
            // Close a gap within this step, but push overlapping surfaces apart slowly.
            double speed = (p.depth < 0.005 ? std::fmin(p.depth, 0.0) : 0.2 * (p.depth - 0.005)) / step;
            double change = (speed - dot(velocity + cross(spin, arm), p.normal)) / (1.0 + dot(lever, lever) / inertia);
            double held = k ? p.impulse[0] : 0.0;  // the first time, push as much as at the end of the last step
            if (k) p.impulse[0] = std::fmax(held + change, 0.0);
            velocity += (p.impulse[0] - held) * p.normal;
            spin += (p.impulse[0] - held) / inertia * cross(arm, p.normal);
        }
        pose = hullmap::moved(pose, step * velocity, step * spin);
    }
    bool rests = manifold.size() == 4 && length(velocity) + length(spin) < 1e-3;
    std::printf("%zu points, %.4f above the hull, %s\n", manifold.size(), pose.translation.z - top,
                rests ? "at rest" : "moving");
    return !rests;
} catch (const hullmap::Error &error) {
    return std::fprintf(stderr, "settle: %s\n", error.what()), 2;
}
