// Drops a box on the first hull of a pack, and waits until it rests: settle PACK
//
// The hull must be flat on top, such as baked/cube.hullmap. From other hulls the box falls off.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <hullmap.hpp>

using hullmap::Vec3;

static Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vec3 operator*(double s, Vec3 v) { return {s * v.x, s * v.y, s * v.z}; }
static double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

// q after a turn by the small vector v. Queries normalise it; so does this, to keep its length.
static hullmap::Quat turned(hullmap::Quat q, Vec3 v) {
    Vec3 u{q.x, q.y, q.z}, w = u + 0.5 * (q.w * v + cross(v, u));
    double s = q.w - 0.5 * dot(v, u), length = std::sqrt(dot(w, w) + s * s);
    return {w.x / length, w.y / length, w.z / length, s / length};
}

int main(int count, char **arguments) try {
    if (count != 2) return std::fputs("usage: settle PACK\n", stderr), 2;
    auto pack = hullmap::Pack::open(arguments[1]);
    auto ground = hullmap::Shape::hull(pack, 0);
    const double half = 0.25, step = 1.0 / 60.0, inertia = 2.0 / 3.0 * half * half;  // of a cube of mass 1
    auto box = hullmap::Shape::cuboid({half, half, half});

    const double top = pack.facts(0).bounds.max.z;
    hullmap::Pose pose{{0.1, 0.0, top + 1.0}, {0.2, 0.1, 0.0, 1.0}};
    Vec3 velocity{}, spin{};
    hullmap::Manifold manifold;
    for (int i = 0; i < 600; ++i) {
        velocity.z -= 9.81 * step;
        manifold.update(ground, box, pose);
        auto push = [&](const hullmap::ManifoldPoint &p, double impulse) {
            velocity = velocity + impulse * p.normal;
            spin = spin + impulse / inertia * cross(p.point_b - pose.translation, p.normal);
        };
        for (auto &p : manifold) push(p, p.impulse[0]);  // what held it in the last step
        for (int k = 0; k < 20; ++k) {
            for (auto &p : manifold) {
                Vec3 arm = p.point_b - pose.translation, lever = cross(arm, p.normal);
                // Close a gap within this step, but push overlapping surfaces apart slowly.
                double depth = p.depth < 0.0 ? p.depth : 0.2 * std::max(p.depth - 0.005, 0.0);
                double speed = depth / step - dot(velocity + cross(spin, arm), p.normal);
                double total = std::max(p.impulse[0] + speed / (1.0 + dot(lever, lever) / inertia), 0.0);
                push(p, total - p.impulse[0]);
                p.impulse[0] = total;  // kept until the next step
            }
        }
        pose = {pose.translation + step * velocity, turned(pose.rotation, step * spin)};
    }
    bool rests = manifold.size() == 4 && dot(velocity, velocity) + dot(spin, spin) < 1e-6;
    std::printf("%zu points, %.4f above the hull, %s\n", manifold.size(), pose.translation.z - top,
                rests ? "at rest" : "moving");
    return rests && std::abs(pose.translation.z - top - half) < 0.01 ? 0 : 1;
} catch (const hullmap::Error &error) {
    std::fprintf(stderr, "settle: %s\n", error.what());
    return 2;
}
