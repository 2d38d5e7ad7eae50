// hullmap.hpp: hullmap.h for C++17. Handles are freed by their destructors, failures are exceptions,
// and queries return their answers. The rules and units of hullmap.h hold.
// Licence: MIT OR Apache-2.0.

#ifndef HULLMAP_HPP
#define HULLMAP_HPP

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hullmap.h"

namespace hullmap {

using Vec3 = HullmapVec3;
using Quat = HullmapQuat;
using Pose = HullmapPose;
using Bounds = HullmapBounds;
using Settings = HullmapSettings;
using CastSettings = HullmapCastSettings;
using ManifoldSettings = HullmapManifoldSettings;
using SupportPoint = HullmapSupportPoint;
using Intersection = HullmapIntersection;
using Distance = HullmapDistance;
using Contact = HullmapContact;
using RayHit = HullmapRayHit;
using Impact = HullmapImpact;
using SignedDistance = HullmapSignedDistance;
using Motion = HullmapMotion;
using MotionSettings = HullmapMotionSettings;
using ClearSettings = HullmapClearSettings;
using TimeOfImpact = HullmapTimeOfImpact;
using Clearance = HullmapClearance;
using Derivatives = HullmapDerivatives;
using WitnessDerivatives = HullmapWitnessDerivatives;
using ManifoldPoint = HullmapManifoldPoint;
using ManifoldPoints = HullmapManifoldPoints;
using HullFacts = HullmapHullFacts;
using MassProperties = HullmapMassProperties;
using Replacement = HullmapReplacement;
using HullArrays = HullmapHullArrays;
using Pair = HullmapPair;

inline constexpr Pose identity = HULLMAP_POSE_IDENTITY;

// A failure, with the message of the library.
class Error : public std::runtime_error {
public:
    Error(HullmapResult result, const char *message) : std::runtime_error(message), result_(result) {}
    HullmapResult result() const noexcept { return result_; }

private:
    HullmapResult result_;
};

// Throws if a call of hullmap.h has failed.
inline void check(HullmapResult result) {
    if (result != HULLMAP_RESULT_OK) {
        throw Error(result, hullmap_last_error());
    }
}

namespace detail {

template <class T, void (*free)(T *)>
struct Free {
    void operator()(T *handle) const noexcept { free(handle); }
};

template <class T, void (*free)(T *)>
using Handle = std::unique_ptr<T, Free<T, free>>;

// Calls make(&handle).
template <class H, class Make>
H made(Make make) {
    typename H::pointer handle = nullptr;
    check(make(&handle));
    return H(handle);
}

}  // namespace detail

// An open pack. Shapes made from it keep its memory.
class Pack {
public:
    // flags: 0, HULLMAP_OPEN_MAP, HULLMAP_OPEN_SKIP_CONTENTS
    static Pack open(const std::string &path, std::uint32_t flags = 0) {
        return Pack(detail::made<Handle>([&](auto out) { return hullmap_pack_open(path.c_str(), flags, out); }));
    }

    // flags: 0, HULLMAP_OPEN_BORROW, HULLMAP_OPEN_SKIP_CONTENTS
    static Pack from_memory(const void *bytes, std::size_t length, std::uint32_t flags = 0) {
        auto first = static_cast<const std::uint8_t *>(bytes);
        return Pack(
            detail::made<Handle>([&](auto out) { return hullmap_pack_from_memory(first, length, flags, out); }));
    }

    std::size_t hull_count() const { return hullmap_pack_hull_count(get()); }

    // Index of the first hull with this name.
    std::size_t find(const std::string &name) const {
        std::size_t index = 0;
        check(hullmap_pack_find(get(), name.c_str(), &index));
        return index;
    }

    HullFacts facts(std::size_t hull) const {
        HullFacts facts{};
        facts.struct_size = sizeof facts;
        check(hullmap_pack_hull_facts(get(), hull, &facts));
        return facts;
    }

    // The primitive that may replace a hull; its kind is HULLMAP_PRIMITIVE_KIND_NONE if there is none.
    Replacement primitive(std::size_t hull) const {
        Replacement primitive{};
        check(hullmap_pack_hull_primitive(get(), hull, &primitive));
        return primitive;
    }

    // All hulls as one rigid body.
    MassProperties mass_properties(double density) const { return mass_properties(0, hull_count(), density); }

    MassProperties mass_properties(std::size_t first, std::size_t count, double density) const {
        MassProperties mass{};
        check(hullmap_pack_mass_properties(get(), first, count, density, &mass));
        return mass;
    }

    HullArrays arrays(std::size_t hull) const {
        HullArrays arrays{};
        check(hullmap_pack_hull_arrays(get(), hull, &arrays));
        return arrays;
    }

    const HullmapPack *get() const noexcept { return handle_.get(); }

private:
    using Handle = detail::Handle<HullmapPack, hullmap_pack_free>;
    explicit Pack(Handle handle) : handle_(std::move(handle)) {}
    Handle handle_;
};

// An open triangle mesh. Shapes made from it keep its memory.
class TriangleMesh {
public:
    static TriangleMesh open(const std::string &path) {
        return TriangleMesh(
            detail::made<Handle>([&](auto out) { return hullmap_triangle_mesh_open(path.c_str(), out); }));
    }

    static TriangleMesh from_memory(const void *bytes, std::size_t length) {
        auto first = static_cast<const std::uint8_t *>(bytes);
        return TriangleMesh(
            detail::made<Handle>([&](auto out) { return hullmap_triangle_mesh_from_memory(first, length, out); }));
    }

    std::size_t triangle_count() const { return hullmap_triangle_mesh_triangle_count(get()); }
    std::size_t vertex_count() const { return hullmap_triangle_mesh_vertex_count(get()); }

    HullmapMeshTriangle triangle(std::size_t index) const {
        HullmapMeshTriangle triangle{};
        check(hullmap_triangle_mesh_triangle(get(), index, &triangle));
        return triangle;
    }

    const HullmapTriangleMesh *get() const noexcept { return handle_.get(); }

private:
    using Handle = detail::Handle<HullmapTriangleMesh, hullmap_triangle_mesh_free>;
    explicit TriangleMesh(Handle handle) : handle_(std::move(handle)) {}
    Handle handle_;
};

// An open height field. Shapes made from it keep its memory.
class HeightField {
public:
    static HeightField open(const std::string &path) {
        return HeightField(
            detail::made<Handle>([&](auto out) { return hullmap_height_field_open(path.c_str(), out); }));
    }

    static HeightField from_memory(const void *bytes, std::size_t length) {
        auto first = static_cast<const std::uint8_t *>(bytes);
        return HeightField(
            detail::made<Handle>([&](auto out) { return hullmap_height_field_from_memory(first, length, out); }));
    }

    std::size_t triangle_count() const { return hullmap_height_field_triangle_count(get()); }

    HullmapFieldLayout layout() const {
        HullmapFieldLayout layout{};
        check(hullmap_height_field_layout(get(), &layout));
        return layout;
    }

    HullmapMeshTriangle triangle(std::size_t index) const {
        HullmapMeshTriangle triangle{};
        check(hullmap_height_field_triangle(get(), index, &triangle));
        return triangle;
    }

    HullmapGround height_at(double x, double y) const {
        HullmapGround ground{};
        check(hullmap_height_field_height_at(get(), x, y, &ground));
        return ground;
    }

    const HullmapHeightField *get() const noexcept { return handle_.get(); }

private:
    using Handle = detail::Handle<HullmapHeightField, hullmap_height_field_free>;
    explicit HeightField(Handle handle) : handle_(std::move(handle)) {}
    Handle handle_;
};

inline std::string_view text(const HullmapText &text) { return {text.data, text.length}; }

// A shape. Threads may share it.
class Shape {
public:
    static Shape hull(const Pack &pack, std::size_t index = 0) {
        return make([&](auto out) { return hullmap_shape_hull(pack.get(), index, out); });
    }
    static Shape scaled_hull(const Pack &pack, std::size_t index, Vec3 scale) {
        return make([&](auto out) { return hullmap_shape_scaled_hull(pack.get(), index, scale, out); });
    }
    static Shape compound(const Pack &pack) {
        return make([&](auto out) { return hullmap_shape_compound(pack.get(), out); });
    }
    static Shape triangle_mesh(const TriangleMesh &mesh) {
        return make([&](auto out) { return hullmap_shape_triangle_mesh(mesh.get(), out); });
    }
    static Shape height_field(const HeightField &field) {
        return make([&](auto out) { return hullmap_shape_height_field(field.get(), out); });
    }
    static Shape sphere(double radius) {
        return make([&](auto out) { return hullmap_shape_sphere(radius, out); });
    }
    static Shape cuboid(Vec3 half_edges) {
        return make([&](auto out) { return hullmap_shape_cuboid(half_edges, out); });
    }
    static Shape capsule(double half_length, double radius) {
        return make([&](auto out) { return hullmap_shape_capsule(half_length, radius, out); });
    }
    static Shape cylinder(double half_height, double radius) {
        return make([&](auto out) { return hullmap_shape_cylinder(half_height, radius, out); });
    }
    static Shape cone(double half_height, double radius) {
        return make([&](auto out) { return hullmap_shape_cone(half_height, radius, out); });
    }
    static Shape segment(Vec3 start, Vec3 end) {
        return make([&](auto out) { return hullmap_shape_segment(start, end, out); });
    }
    static Shape triangle(Vec3 a, Vec3 b, Vec3 c) {
        return make([&](auto out) { return hullmap_shape_triangle(a, b, c, out); });
    }
    // The points p with dot(normal, p) <= offset. Two half-spaces have no query.
    static Shape half_space(Vec3 normal, double offset) {
        return make([&](auto out) { return hullmap_shape_half_space(normal, offset, out); });
    }

    SupportPoint support(Vec3 direction) const {
        SupportPoint found{};
        check(hullmap_support(get(), &direction, 1, &found));
        return found;
    }
    Bounds bounds(const Pose &pose = identity) const {
        Bounds found{};
        check(hullmap_bounds(get(), &pose, &found));
        return found;
    }
    RayHit ray(Vec3 origin, Vec3 direction, const CastSettings *settings = nullptr) const {
        RayHit found{};
        check(hullmap_ray(get(), origin, direction, settings, &found));
        return found;
    }

    const HullmapShape *get() const noexcept { return handle_.get(); }

private:
    using Handle = detail::Handle<HullmapShape, hullmap_shape_free>;
    template <class Make>
    static Shape make(Make make) {
        return Shape(detail::made<Handle>(make));
    }
    explicit Shape(Handle handle) : handle_(std::move(handle)) {}
    Handle handle_;
};

// Memory of one pair from query to query; one thread at a time may use it.
class Cache {
public:
    Cache() : handle_(detail::made<Handle>(hullmap_cache_new)) {}
    void clear() { check(hullmap_cache_clear(get())); }
    HullmapCache *get() const noexcept { return handle_.get(); }

private:
    using Handle = detail::Handle<HullmapCache, hullmap_cache_free>;
    Handle handle_;
};

inline Intersection intersects(const Shape &a, const Shape &b, const Pose &b_in_a, Cache *cache = nullptr) {
    Intersection found{};
    check(hullmap_intersects(a.get(), b.get(), &b_in_a, cache ? cache->get() : nullptr, &found));
    return found;
}

inline Distance distance(const Shape &a, const Shape &b, const Pose &b_in_a, Cache *cache = nullptr,
                         const Settings *settings = nullptr) {
    Distance found{};
    check(hullmap_distance(a.get(), b.get(), &b_in_a, settings, cache ? cache->get() : nullptr, &found));
    return found;
}

inline Contact contact(const Shape &a, const Shape &b, const Pose &b_in_a, Cache *cache = nullptr,
                       const Settings *settings = nullptr) {
    Contact found{};
    check(hullmap_contact(a.get(), b.get(), &b_in_a, settings, cache ? cache->get() : nullptr, &found));
    return found;
}

inline Impact cast(const Shape &a, const Shape &b, const Pose &b_in_a, Vec3 velocity, Cache *cache = nullptr,
                   const CastSettings *settings = nullptr) {
    Impact found{};
    check(hullmap_cast(a.get(), b.get(), &b_in_a, velocity, settings, cache ? cache->get() : nullptr, &found));
    return found;
}

inline TimeOfImpact cast_motion(const Shape &a, const Motion &motion_a, const Shape &b, const Motion &motion_b,
                                Cache *cache = nullptr, const MotionSettings *settings = nullptr,
                                Derivatives *derivatives = nullptr) {
    TimeOfImpact found{};
    check(hullmap_cast_motion(a.get(), &motion_a, b.get(), &motion_b, settings, cache ? cache->get() : nullptr, &found,
                              derivatives));
    return found;
}

inline Clearance clear(const Shape &a, const Motion &motion_a, const Shape &b, const Motion &motion_b,
                       Cache *cache = nullptr, const ClearSettings *settings = nullptr) {
    Clearance found{};
    check(hullmap_clear(a.get(), &motion_a, b.get(), &motion_b, settings, cache ? cache->get() : nullptr, &found));
    return found;
}

// The distance. `derivatives` receives its derivatives, and `witness` the derivatives of its normal and points.
inline Distance distance(const Shape &a, const Shape &b, const Pose &b_in_a, Derivatives &derivatives,
                         Cache *cache = nullptr, const Settings *settings = nullptr,
                         WitnessDerivatives *witness = nullptr) {
    Distance found{};
    check(hullmap_distance_derivatives(a.get(), b.get(), &b_in_a, settings, cache ? cache->get() : nullptr, &found,
                                       &derivatives, witness));
    return found;
}

// The contact. `derivatives` receives the derivatives of its depth, and `witness` the derivatives of its
// normal and points.
inline Contact contact(const Shape &a, const Shape &b, const Pose &b_in_a, Derivatives &derivatives,
                       Cache *cache = nullptr, const Settings *settings = nullptr,
                       WitnessDerivatives *witness = nullptr) {
    Contact found{};
    check(hullmap_contact_derivatives(a.get(), b.get(), &b_in_a, settings, cache ? cache->get() : nullptr, &found,
                                      &derivatives, witness));
    return found;
}

// Where a ray enters a convex shape, and the derivatives of t in `derivatives`.
inline RayHit ray(const Shape &shape, Vec3 origin, Vec3 direction, Derivatives &derivatives,
                  const CastSettings *settings = nullptr) {
    RayHit found{};
    check(hullmap_ray_derivatives(shape.get(), origin, direction, settings, &found, &derivatives));
    return found;
}

inline SignedDistance signed_distance(const Shape &shape, Vec3 point, Cache *cache = nullptr,
                                      const Settings *settings = nullptr) {
    SignedDistance found{};
    check(hullmap_signed_distance(shape.get(), point, settings, cache ? cache->get() : nullptr, &found));
    return found;
}

// The pose of B in A, from the poses of both in a world.
inline Pose relative(const Pose &a_in_world, const Pose &b_in_world) {
    Pose b_in_a{};
    check(hullmap_pose_relative(&a_in_world, &b_in_world, &b_in_a));
    return b_in_a;
}

// Vector arithmetic, for programs without a library of their own: using namespace hullmap::vectors.
namespace vectors {

inline Vec3 operator+(Vec3 a, Vec3 b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, Vec3 v) noexcept { return {s * v.x, s * v.y, s * v.z}; }
inline Vec3 &operator+=(Vec3 &a, Vec3 b) noexcept { return a = a + b; }
inline double dot(Vec3 a, Vec3 b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) noexcept {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vec3 v) noexcept { return std::sqrt(dot(v, v)); }
inline Vec3 turned(const Quat &q, Vec3 v) noexcept {
    Vec3 u{q.x, q.y, q.z}, t = 2.0 * cross(u, v);
    return v + q.w * t + cross(u, t);
}

}  // namespace vectors

// The direction and the point of an outer frame in the frame that has this pose there: of a ray in the
// world, in the frame of a shape.
inline Vec3 direction_in(const Pose &pose, Vec3 direction) noexcept {
    const Quat &q = pose.rotation;
    return vectors::turned({-q.x, -q.y, -q.z, q.w}, direction);
}
inline Vec3 point_in(const Pose &pose, Vec3 point) noexcept {
    using namespace vectors;
    return direction_in(pose, point - pose.translation);
}

// A pose moved by a translation, and turned about its own origin by a rotation vector in radians.
// Both are in the outer frame: velocity times step, and angular velocity times step. The rotation of
// the answer is of unit length.
inline Pose moved(const Pose &pose, Vec3 translation, Vec3 rotation) {
    using namespace vectors;
    double angle = length(rotation), c = std::cos(0.5 * angle);
    // sin(angle / 2) / angle tends to 1/2 at 0; below the threshold it has that value.
    Vec3 s = (angle > 1e-9 ? std::sin(0.5 * angle) / angle : 0.5) * rotation;
    const Quat &q = pose.rotation;
    Vec3 u{q.x, q.y, q.z}, v = c * u + q.w * s + cross(s, u);
    double w = c * q.w - dot(s, u), norm = std::sqrt(dot(v, v) + w * w);
    return {pose.translation + translation, {v.x / norm, v.y / norm, v.z / norm, w / norm}};
}

// Contact points of one pair, kept from step to step. Iterate over it to read and write them. max_pairs
// is for parts, triangles of a level and cells of a terrain that touch at the same time, 1 KB for each;
// ManifoldPoints::dropped counts those for which there was no room. Convex shapes need 1.
class Manifold {
public:
    explicit Manifold(std::uint32_t max_pairs = 32)
        : handle_(detail::made<Handle>([&](auto out) { return hullmap_manifold_new(max_pairs, out); })) {}
    // One that was moved from has no points.
    Manifold(Manifold &&other) noexcept
        : handle_(std::move(other.handle_)), points_(std::exchange(other.points_, ManifoldPoints{})) {}
    Manifold &operator=(Manifold &&other) noexcept {
        handle_ = std::move(other.handle_);
        points_ = std::exchange(other.points_, ManifoldPoints{});
        return *this;
    }

    const ManifoldPoints &update(const Shape &a, const Shape &b, const Pose &b_in_a,
                                 const ManifoldSettings *settings = nullptr) {
        check(hullmap_manifold_update(get(), a.get(), b.get(), &b_in_a, settings, &points_));
        return points_;
    }
    void clear() {
        check(hullmap_manifold_clear(get()));
        points_ = {};
    }

    ManifoldPoint *begin() const noexcept { return points_.points; }
    ManifoldPoint *end() const noexcept { return points_.count == 0 ? begin() : begin() + points_.count; }
    std::size_t size() const noexcept { return points_.count; }
    HullmapManifold *get() const noexcept { return handle_.get(); }

private:
    using Handle = detail::Handle<HullmapManifold, hullmap_manifold_free>;
    Handle handle_;
    ManifoldPoints points_{};
};

// Many pairs on all cores. caches is empty, or has one for each pair.
namespace batch {

inline HullmapCache *const *pointers(const std::vector<Cache> &caches, std::size_t count,
                                     std::vector<HullmapCache *> &storage) {
    if (caches.empty()) {
        return nullptr;
    }
    if (caches.size() != count) {
        throw std::invalid_argument("a batch requires one cache for each pair, or none");
    }
    for (const Cache &cache : caches) {
        storage.push_back(cache.get());
    }
    return storage.data();
}

inline std::vector<Intersection> intersects(const std::vector<Pair> &pairs, const std::vector<Cache> &caches = {}) {
    std::vector<Intersection> found(pairs.size());
    std::vector<HullmapCache *> storage;
    check(hullmap_batch_intersects(pairs.data(), pairs.size(), pointers(caches, pairs.size(), storage), found.data()));
    return found;
}

inline std::vector<Distance> distance(const std::vector<Pair> &pairs, const std::vector<Cache> &caches = {},
                                      const Settings *settings = nullptr) {
    std::vector<Distance> found(pairs.size());
    std::vector<HullmapCache *> storage;
    check(hullmap_batch_distance(pairs.data(), pairs.size(), settings, pointers(caches, pairs.size(), storage),
                                 found.data()));
    return found;
}

inline std::vector<Contact> contact(const std::vector<Pair> &pairs, const std::vector<Cache> &caches = {},
                                    const Settings *settings = nullptr) {
    std::vector<Contact> found(pairs.size());
    std::vector<HullmapCache *> storage;
    check(hullmap_batch_contact(pairs.data(), pairs.size(), settings, pointers(caches, pairs.size(), storage),
                                found.data()));
    return found;
}

}  // namespace batch

}  // namespace hullmap

#endif  // HULLMAP_HPP
