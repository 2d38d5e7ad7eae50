// A program that was written for V-HACD 4.1, or with HULLMAP_VHACD_4_0 for 4.0: only the name of the header has
// changed.
#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

#include "hullmap_vhacd.hpp"

namespace {

int checks = 0, failures = 0;

void check(bool is_true, const char* what) {
    ++checks;
    if (!is_true) {
        ++failures;
        std::printf("failed: %s\n", what);
    }
}

struct Callback : VHACD::IVHACD::IUserCallback {
    double last = 0;
    std::atomic<bool> is_complete{false};
    void Update(const double overall, const double, const char* const, const char*) override { last = overall; }
    void NotifyVHACDComplete() override { is_complete = true; }
};

struct Logger : VHACD::IVHACD::IUserLogger {
    int count = 0;
    void Log(const char* const) override { ++count; }
};

// Two boxes that share a corner, and one index of an outward triangle each.
std::vector<float> points;
std::vector<uint32_t> triangles;

void add_box(float x, float y, float z) {
    const uint32_t first = static_cast<uint32_t>(points.size() / 3);
    for (int i = 0; i < 8; ++i) {
        points.push_back(x + static_cast<float>(i & 1));
        points.push_back(y + static_cast<float>(i >> 1 & 1));
        points.push_back(z + static_cast<float>(i >> 2));
    }
    const uint32_t quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& q : quads) {
        for (const uint32_t corner : {q[0], q[1], q[2], q[0], q[2], q[3]}) triangles.push_back(first + corner);
    }
}

}  // namespace

int main() {
    add_box(0, 0, 0);
    add_box(1, 1, 1);
    const uint32_t count = static_cast<uint32_t>(points.size() / 3);
    const uint32_t triangle_count = static_cast<uint32_t>(triangles.size() / 3);

    Callback callback;
    Logger logger;
    VHACD::IVHACD::Parameters parameters;
    parameters.m_callback = &callback;
    parameters.m_logger = &logger;
    VHACD::IVHACD* interface = VHACD::CreateVHACD();
    check(interface->GetNConvexHulls() == 0 && interface->IsReady(), "nothing yet");
    check(interface->Compute(points.data(), count, triangles.data(), triangle_count, parameters), "Compute");
    check(interface->GetNConvexHulls() == 2, "two boxes");
    for (uint32_t index = 0; index < interface->GetNConvexHulls(); ++index) {
        VHACD::IVHACD::ConvexHull hull;
        check(interface->GetConvexHull(index, hull), "GetConvexHull");
#ifdef HULLMAP_VHACD_4_0
        check(hull.m_nPoints == 8 && hull.m_nTriangles == 12 && hull.m_meshId == index, "a box");
        const double x = hull.m_points[3 * hull.m_triangles[0]];
#else
        check(hull.m_points.size() == 8 && hull.m_triangles.size() == 12 && hull.m_meshId == index, "a box");
        const double x = hull.m_points[hull.m_triangles[0].mI0].mX;
        check(hull.m_center.GetX() == hull.m_center[0] && hull.m_points[0][2] == hull.m_points[0].mZ, "coordinates");
#endif
        check(std::min(std::abs(x - hull.mBmin[0]), std::abs(x - hull.mBmax[0])) < 1e-6, "a corner");
        // The boxes are symmetric about a slanted plane, so they are grown by what rounding moves.
        check(hull.m_volume > 1 - 1e-12 && hull.m_volume < 1 + 3e-6, "volume");
        for (int axis = 0; axis < 3; ++axis) {
            check(std::abs(hull.mBmax[axis] - hull.mBmin[axis] - 1) < 1e-6, "bounds");
            check(std::abs(hull.m_center[axis] - (hull.mBmin[axis] + hull.mBmax[axis]) / 2) < 1e-6, "centre");
        }
        double distance = 1;
        check(interface->findNearestConvexHull(&hull.m_center[0], distance) == index && distance == 0, "nearest");
    }
    VHACD::IVHACD::ConvexHull none;
    check(!interface->GetConvexHull(2, none), "no third part");
    double center[3];
    check(interface->ComputeCenterOfMass(center) && std::abs(center[0] - 1) < 1e-6, "centre of mass");

    parameters.m_maxConvexHulls = 1;
    const std::vector<double> doubles(points.begin(), points.end());
    check(interface->Compute(doubles.data(), count, triangles.data(), triangle_count, parameters), "doubles");
    check(interface->GetNConvexHulls() == 1 && logger.count == 0, "one part");
    interface->Clean();
    check(interface->GetNConvexHulls() == 0, "Clean");
    std::vector<uint32_t> bad(triangles);
    bad[5] = 999;
    check(!interface->Compute(points.data(), count, bad.data(), triangle_count, parameters), "a wrong index");
    check(logger.count > 0 && interface->GetNConvexHulls() == 0, "is logged");
    interface->Release();

    parameters.m_maxConvexHulls = 64;
    interface = VHACD::CreateVHACD_ASYNC();
    check(interface->Compute(points.data(), count, triangles.data(), triangle_count, parameters), "asynchronous");
    while (!interface->IsReady()) std::this_thread::yield();
    check(interface->GetNConvexHulls() == 2, "the same parts");
    interface->Clean();
    check(callback.is_complete, "NotifyVHACDComplete");
    check(interface->Compute(points.data(), count, triangles.data(), triangle_count, parameters), "asynchronous");
    interface->Cancel();
    check(interface->IsReady(), "cancelled, or done before");
    interface->Release();

    // Another thread cancels a Compute that is not asynchronous, before, while and after it runs.
    interface = VHACD::CreateVHACD();
    for (int round = 0; round < 20; ++round) {
        std::atomic<bool> is_over{false};
        std::thread other([&] {
            while (!is_over.load()) interface->Cancel();
        });
        interface->Compute(points.data(), count, triangles.data(), triangle_count, parameters);
        is_over = true;
        other.join();
    }
    parameters.m_fillMode = VHACD::FillMode::SURFACE_ONLY;
    check(interface->Compute(points.data(), count, triangles.data(), triangle_count, parameters), "walls");
    check(interface->GetNConvexHulls() > 2, "walls of boxes are more parts");
    interface->Release();
    std::printf("%d checks, %d failures\n", checks, failures);
    return failures != 0;
}
