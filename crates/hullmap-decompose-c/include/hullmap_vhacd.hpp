// The class and the names of V-HACD 4.1 over hullmap's convex decomposition. C++11 and later. For programs
// that were written for V-HACD 4.0, whose ConvexHull has pointers, define HULLMAP_VHACD_4_0 before.
//
// Licence: MIT OR Apache-2.0.
//
// Replace `#include "VHACD.h"` by `#include "hullmap_vhacd.hpp"`, and link libhullmap_decompose. The
// macro ENABLE_VHACD_IMPLEMENTATION has no effect. Do not include V-HACD's own header as well.
//
// Meaning of the parameters here:
//
//   m_maxConvexHulls         maximum number of parts. If the error below takes more parts, the smallest
//                            error with at most this number is searched
//   m_maxNumVerticesPerCH    maximum number of vertices of a part, at least 4
//   m_minimumVolumePercentErrorAllowed
//                            a share of volume, for which hullmap has no equal. A value p bounds how
//                            far a part protrudes, by 2 p percent of the mesh's diagonal: V-HACD's
//                            default of 1 is hullmap's default of 2 %. This bound is proven. Values
//                            below 0.1 count as 0.1
//   m_asyncACD               as in V-HACD: whether Compute of CreateVHACD_ASYNC returns at once
//   m_callback               Update is called in the thread that calls Compute, or IsReady if it is
//                            asynchronous; NotifyVHACDComplete by the thread of the computation
//   m_logger                 gets the message of a failure, in the thread that calls
//   m_resolution, m_maxRecursionDepth, m_minEdgeLength, m_findBestPlane, m_shrinkWrap
//                            no effect: there are no voxels, and parts fit the surface
//   m_fillMode               the solid of a mesh: SURFACE_ONLY is its walls; with RAYCAST_FILL, its holes
//                            are closed, and its inside counts; with FLOOD_FILL, small holes are
//                            closed, and a mesh with large ones is walls
//   m_taskRunner             no effect: the library has a pool of threads
#ifndef HULLMAP_VHACD_HPP
#define HULLMAP_VHACD_HPP

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "hullmap_decompose.h"

namespace VHACD {

enum class FillMode { FLOOD_FILL, SURFACE_ONLY, RAYCAST_FILL };

struct Vertex {
    double mX, mY, mZ;
    Vertex() = default;
    Vertex(double x, double y, double z) : mX(x), mY(y), mZ(z) {}
    const double& operator[](size_t index) const { return index == 0 ? mX : index == 1 ? mY : mZ; }
};

struct Triangle {
    uint32_t mI0, mI1, mI2;
    Triangle() = default;
    Triangle(uint32_t a, uint32_t b, uint32_t c) : mI0(a), mI1(b), mI2(c) {}
};

// A vector's coordinates; V-HACD's arithmetic of vectors is not here.
class Vect3 {
public:
    Vect3() = default;
    Vect3(double x, double y, double z) : at_{x, y, z} {}
    double& operator[](size_t index) { return at_[index]; }
    const double& operator[](size_t index) const { return at_[index]; }
    const double& GetX() const { return at_[0]; }
    const double& GetY() const { return at_[1]; }
    const double& GetZ() const { return at_[2]; }

private:
    double at_[3] = {0, 0, 0};
};

class IVHACD {
public:
    class IUserCallback {
    public:
        virtual ~IUserCallback() {}
        // Progress in percent.
        virtual void Update(const double overallProgress, const double stageProgress, const char* const stage,
                            const char* operation) = 0;
        virtual void NotifyVHACDComplete() {}
    };

    class IUserLogger {
    public:
        virtual ~IUserLogger() {}
        virtual void Log(const char* const msg) = 0;
    };

    class IUserTaskRunner {
    public:
        virtual ~IUserTaskRunner() {}
        virtual void* StartTask(std::function<void()> func) = 0;
        virtual void JoinTask(void* task) = 0;
    };

#ifdef HULLMAP_VHACD_4_0
    // A part. The arrays are valid until the next Compute, Clean or Release.
    class ConvexHull {
    public:
        uint32_t m_nPoints{0};
        double* m_points{nullptr};
        uint32_t m_nTriangles{0};
        uint32_t* m_triangles{nullptr};
        double m_volume{0};
        double m_center[3]{0, 0, 0};
        uint32_t m_meshId{0};
        double mBmin[3]{0, 0, 0};
        double mBmax[3]{0, 0, 0};
    };
#else
    // A part.
    class ConvexHull {
    public:
        std::vector<Vertex> m_points;
        std::vector<Triangle> m_triangles;
        double m_volume{0};
        Vect3 m_center;
        uint32_t m_meshId{0};
        Vect3 mBmin, mBmax;
    };
#endif

    class Parameters {
    public:
        IUserCallback* m_callback{nullptr};
        IUserLogger* m_logger{nullptr};
        IUserTaskRunner* m_taskRunner{nullptr};
        uint32_t m_maxConvexHulls{64};
        uint32_t m_resolution{400000};
        double m_minimumVolumePercentErrorAllowed{1};
        uint32_t m_maxRecursionDepth{10};
        bool m_shrinkWrap{true};
        FillMode m_fillMode{FillMode::FLOOD_FILL};
        uint32_t m_maxNumVerticesPerCH{64};
        bool m_asyncACD{true};
        uint32_t m_minEdgeLength{2};
        bool m_findBestPlane{false};
    };

    virtual void Cancel() = 0;
    virtual bool Compute(const float* const points, const uint32_t countPoints, const uint32_t* const triangles,
                         const uint32_t countTriangles, const Parameters& params) = 0;
    virtual bool Compute(const double* const points, const uint32_t countPoints, const uint32_t* const triangles,
                         const uint32_t countTriangles, const Parameters& params) = 0;
    virtual uint32_t GetNConvexHulls() const = 0;
    virtual bool GetConvexHull(const uint32_t index, ConvexHull& ch) const = 0;
    virtual void Clean() = 0;
    virtual void Release() = 0;
    virtual bool ComputeCenterOfMass(double centerOfMass[3]) const = 0;
    virtual bool IsReady() const { return true; }
    // Index of the part nearest to a point. The distance is the greatest height above the planes of
    // the part: 0 inside, and elsewhere at most the true distance.
    virtual uint32_t findNearestConvexHull(const double pos[3], double& distanceToHull) = 0;

protected:
    virtual ~IVHACD() {}
};

namespace hullmap_detail {

// One instance: the thread of its computation, and its parts.
class Decomposer final : public IVHACD {
public:
    explicit Decomposer(bool is_async) : is_async_(is_async) {}

    // Returns at once while another thread is in a Compute that is not asynchronous.
    void Cancel() override {
        ask_to_end();
        if (is_async_) join();
    }

    bool Compute(const float* const points, const uint32_t countPoints, const uint32_t* const triangles,
                 const uint32_t countTriangles, const Parameters& params) override {
        return start(points, countPoints, triangles, countTriangles, params);
    }

    bool Compute(const double* const points, const uint32_t countPoints, const uint32_t* const triangles,
                 const uint32_t countTriangles, const Parameters& params) override {
        return start(points, countPoints, triangles, countTriangles, params);
    }

    uint32_t GetNConvexHulls() const override { return IsReady() ? static_cast<uint32_t>(parts_.size()) : 0; }

    bool GetConvexHull(const uint32_t index, ConvexHull& ch) const override {
        if (index >= GetNConvexHulls()) return false;
        ch = hull_of(parts_[index]);
        ch.m_meshId = index;
        return true;
    }

    void Clean() override {
        ask_to_end();
        join();
        parts_.clear();
        hullmap_decomposition_free(found_);
        found_ = nullptr;
        set_progress(false);
    }

    void Release() override { delete this; }

    // For a closed mesh, its own centre of mass; otherwise the centre of its parts.
    bool ComputeCenterOfMass(double centerOfMass[3]) const override {
        if (GetNConvexHulls() == 0) return false;
        if (facts_.volume > 0) {
            for (int axis = 0; axis < 3; ++axis) centerOfMass[axis] = facts_.center[axis];
            return true;
        }
        double sum[3] = {0, 0, 0}, volume = 0;
        for (uint32_t index = 0; index < GetNConvexHulls(); ++index) {
            volume += parts_[index].volume;
            for (int axis = 0; axis < 3; ++axis) sum[axis] += parts_[index].volume * parts_[index].center[axis];
        }
        if (!(volume > 0)) return false;
        for (int axis = 0; axis < 3; ++axis) centerOfMass[axis] = sum[axis] / volume;
        return true;
    }

    bool IsReady() const override {
        if (is_done_.load(std::memory_order_acquire)) {
            report();
            return true;
        }
        update();
        return false;
    }

    uint32_t findNearestConvexHull(const double pos[3], double& distanceToHull) override {
        uint32_t nearest = 0;
        distanceToHull = HUGE_VAL;
        for (uint32_t index = 0; index < GetNConvexHulls(); ++index) {
            const double distance = height_above(parts_[index], pos);
            if (distance < distanceToHull) {
                distanceToHull = distance;
                nearest = index;
            }
        }
        return nearest;
    }

private:
    ~Decomposer() override { Clean(); }

    template <typename Number>
    bool start(const Number* points, uint32_t count, const uint32_t* triangles, uint32_t triangle_count,
               const Parameters& params) {
        Clean();
        if (points == nullptr || triangles == nullptr || count == 0 || triangle_count == 0) return false;
        params_ = params;
        points_.assign(points, points + size_t{3} * count);
        triangles_.assign(triangles, triangles + size_t{3} * triangle_count);
        set_progress(true);
        fault_.clear();
        is_reported_.store(false);
        is_done_.store(false, std::memory_order_release);
        worker_ = std::thread([this] { run(); });
        if (is_async_ && params.m_asyncACD) return true;
        while (!is_done_.load(std::memory_order_acquire)) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            update();
        }
        join();
        report();
        return !parts_.empty();
    }

    // The computation, in a thread of its own.
    void run() {
        HullmapDecomposeOptions options = HULLMAP_DECOMPOSE_OPTIONS_DEFAULT;
        options.max_error_share = 0.02 * std::max(params_.m_minimumVolumePercentErrorAllowed, 0.1);
        options.solid = params_.m_fillMode == FillMode::SURFACE_ONLY ? 2 : params_.m_fillMode == FillMode::RAYCAST_FILL;
        options.max_vertices = params_.m_maxNumVerticesPerCH;
        decompose(options, progress_[0]);
        if (facts_.part_count > params_.m_maxConvexHulls && params_.m_maxConvexHulls > 0) {
            options.max_parts = params_.m_maxConvexHulls;
            decompose(options, progress_[1]);
        }
        for (size_t index = 0; index < facts_.part_count; ++index) {
            HullmapDecomposePart part;
            const HullmapDecomposeResult result = hullmap_decomposition_part(found_, index, &part);
            if (result == HULLMAP_DECOMPOSE_RESULT_OK) parts_.push_back(part);
        }
        is_done_.store(true, std::memory_order_release);
        if (is_async_ && params_.m_callback != nullptr) params_.m_callback->NotifyVHACDComplete();
    }

    void decompose(const HullmapDecomposeOptions& options, HullmapDecomposeProgress* progress) {
        hullmap_decomposition_free(found_);
        facts_ = HullmapDecomposeFacts();
        facts_.struct_size = sizeof facts_;
        const HullmapDecomposeResult result =
            hullmap_decompose(points_.data(), points_.size() / 3, triangles_.data(), triangles_.size() / 3, &options,
                              progress, &found_);
        if (result != HULLMAP_DECOMPOSE_RESULT_OK) {
            fault_ = hullmap_decompose_last_error();
            return;
        }
        hullmap_decomposition_facts(found_, &facts_);
    }

    static ConvexHull hull_of(const HullmapDecomposePart& part) {
        ConvexHull hull;
#ifdef HULLMAP_VHACD_4_0
        hull.m_nPoints = part.vertex_count;
        // V-HACD's type is not const.
        hull.m_points = const_cast<double*>(part.vertices);
        hull.m_nTriangles = part.triangle_count;
        hull.m_triangles = const_cast<uint32_t*>(part.triangles);
#else
        for (uint32_t v = 0; v < part.vertex_count; ++v) {
            const double* p = part.vertices + 3 * v;
            hull.m_points.push_back(Vertex(p[0], p[1], p[2]));
        }
        for (uint32_t t = 0; t < part.triangle_count; ++t) {
            const uint32_t* corners = part.triangles + 3 * t;
            hull.m_triangles.push_back(Triangle(corners[0], corners[1], corners[2]));
        }
#endif
        hull.m_volume = part.volume;
        for (int axis = 0; axis < 3; ++axis) {
            hull.m_center[axis] = part.center[axis];
            hull.mBmin[axis] = hull.mBmax[axis] = part.vertices[axis];
            for (uint32_t v = 1; v < part.vertex_count; ++v) {
                hull.mBmin[axis] = std::min(hull.mBmin[axis], part.vertices[3 * v + axis]);
                hull.mBmax[axis] = std::max(hull.mBmax[axis], part.vertices[3 * v + axis]);
            }
        }
        return hull;
    }

    // The greatest height of a point above the planes of a part; 0 inside.
    static double height_above(const HullmapDecomposePart& part, const double pos[3]) {
        double greatest = 0;
        for (uint32_t t = 0; t < part.triangle_count; ++t) {
            const double* a = part.vertices + 3 * part.triangles[3 * t];
            const double* b = part.vertices + 3 * part.triangles[3 * t + 1];
            const double* c = part.vertices + 3 * part.triangles[3 * t + 2];
            const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
            const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
            const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            if (!(length > 0)) continue;
            const double along = n[0] * (pos[0] - a[0]) + n[1] * (pos[1] - a[1]) + n[2] * (pos[2] - a[2]);
            greatest = std::max(greatest, along / length);
        }
        return greatest;
    }

    // Callbacks are called in the thread of the caller, as in V-HACD.
    void update() const {
        double share = 0;
        {
            const std::lock_guard<std::mutex> lock(guard_);
            for (HullmapDecomposeProgress* progress : progress_) share += 0.5 * hullmap_decompose_progress_share(progress);
        }
        update(100 * share);
    }

    void update(double percent) const {
        if (params_.m_callback != nullptr) params_.m_callback->Update(percent, percent, "Decompose", "Decompose");
    }

    // Reports the end of the computation, once.
    void report() const {
        if (is_reported_.exchange(true)) return;
        if (!parts_.empty()) update(100);
        if (!fault_.empty() && params_.m_logger != nullptr) params_.m_logger->Log(fault_.c_str());
    }

    void join() {
        if (worker_.joinable()) worker_.join();
    }

    void ask_to_end() {
        const std::lock_guard<std::mutex> lock(guard_);
        for (HullmapDecomposeProgress* progress : progress_) hullmap_decompose_progress_cancel(progress);
    }

    void set_progress(bool is_new) {
        const std::lock_guard<std::mutex> lock(guard_);
        for (HullmapDecomposeProgress*& progress : progress_) {
            hullmap_decompose_progress_free(progress);
            progress = is_new ? hullmap_decompose_progress_new() : nullptr;
        }
    }

    const bool is_async_;
    std::atomic<bool> is_done_{true};
    std::thread worker_;
    Parameters params_;
    std::vector<double> points_;
    std::vector<uint32_t> triangles_;
    // Held while progress_ is replaced, or used by another thread.
    mutable std::mutex guard_;
    // First for the parts within the error, then for a number of parts, if the error takes more.
    HullmapDecomposeProgress* progress_[2] = {nullptr, nullptr};
    // Written by the computation before it is done.
    std::string fault_;
    mutable std::atomic<bool> is_reported_{true};
    HullmapDecomposition* found_ = nullptr;
    HullmapDecomposeFacts facts_ = HullmapDecomposeFacts();
    std::vector<HullmapDecomposePart> parts_;
};

}  // namespace hullmap_detail

// An instance whose Compute returns when the parts are made.
inline IVHACD* CreateVHACD() { return new hullmap_detail::Decomposer(false); }

// An instance whose Compute returns at once; IsReady says when the parts are made.
inline IVHACD* CreateVHACD_ASYNC() { return new hullmap_detail::Decomposer(true); }

}  // namespace VHACD

#endif  // HULLMAP_VHACD_HPP
