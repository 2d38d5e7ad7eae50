/* Jolt's narrow phase on the bodies of `mesh-table`, which compiles and starts this program.
 *
 *   jolt SCENE
 *
 * SCENE is as for `box3d.c`. For each line that the program reads, it computes the contacts of all
 * bodies at their second poses, and prints two times in nanoseconds of processor time per body: with
 * Jolt's default settings, which ignore edges that are not active, and with its enhanced removal of
 * internal edges; the mean number of contact points of a body; and the depth of the deepest contact.
 *
 * The steps are as in PhysicsSystem::ProcessBodyPair, with reduction of manifolds, without Jolt's
 * broad phase and its contact cache. Jolt keeps the contacts of a pair that has barely moved, and
 * computes all others anew. */
#include <Jolt/Jolt.h>
#include <Jolt/Core/Factory.h>
#include <Jolt/Physics/Collision/CollideShape.h>
#include <Jolt/Physics/Collision/CollisionDispatch.h>
#include <Jolt/Physics/Collision/InternalEdgeRemovingCollector.h>
#include <Jolt/Physics/Collision/ManifoldBetweenTwoFaces.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/PhysicsSettings.h>
#include <Jolt/RegisterTypes.h>
#include <cstdio>
#include <ctime>
#include <vector>

using namespace JPH;

struct Placed {
  Vec3 at;
  Quat turn;
};

struct Manifold {
  Vec3 first, sum;
  float depth;
  ContactPoints on1, on2;
};

/* Joins contacts with nearly the same normal. */
class Collector : public CollideShapeCollector {
public:
  void AddHit(const CollideShapeResult &hit) override {
    Vec3 normal = hit.mPenetrationAxis.Normalized();
    Manifold *into = nullptr;
    for (Manifold &known : found) {
      if (normal.Dot(known.first) >= settings.mContactNormalCosMaxDeltaRotation) {
        known.sum += normal;
        known.depth = max(known.depth, hit.mPenetrationDepth);
        into = &known;
        break;
      }
    }
    if (!into) {
      if (found.size() == found.capacity()) return;
      found.push_back({normal, normal, hit.mPenetrationDepth, {}, {}});
      into = &found.back();
    }
    ManifoldBetweenTwoFaces(hit.mContactPointOn1, hit.mContactPointOn2, hit.mPenetrationAxis,
                            settings.mSpeculativeContactDistance + settings.mManifoldTolerance, hit.mShape1Face,
                            hit.mShape2Face, into->on1, into->on2);
    if (into->on1.size() > 32) PruneContactPoints(into->first, into->on1, into->on2);
  }

  PhysicsSettings settings;
  StaticArray<Manifold, 32> found;
};

/* Contacts of one body, and their number of points. Raises a depth to the depth of the deepest one. */
static size_t collide(const Shape *hull, const Shape *ground, const Placed &pose, bool enhanced, float &depth) {
  Collector collector;
  CollideShapeSettings settings;
  settings.mCollectFacesMode = ECollectFacesMode::CollectFaces;
  settings.mMaxSeparationDistance = collector.settings.mSpeculativeContactDistance;
  settings.mActiveEdgeMode = enhanced ? EActiveEdgeMode::CollideWithAll : EActiveEdgeMode::CollideOnlyWithActive;
  Mat44 own = Mat44::sRotation(pose.turn);
  Vec3 offset = pose.at + own * hull->GetCenterOfMass();
  Mat44 of_ground = Mat44::sTranslation(ground->GetCenterOfMass() - offset);
  SubShapeIDCreator part;
  Vec3 one = Vec3::sReplicate(1.0f);
  if (enhanced) {
    InternalEdgeRemovingCollector::sCollideShapeVsShape(hull, ground, one, one, own, of_ground, part, part, settings,
                                                        collector);
  } else {
    CollisionDispatch::sCollideShapeVsShape(hull, ground, one, one, own, of_ground, part, part, settings, collector);
  }
  size_t points = 0;
  for (Manifold &manifold : collector.found) {
    Vec3 normal = manifold.sum.Normalized();
    if (manifold.on1.size() > 4) PruneContactPoints(normal, manifold.on1, manifold.on2);
    points += manifold.on1.size();
    depth = max(depth, manifold.depth);
  }
  return points;
}

/* Nanoseconds of processor time of this thread. */
static double processor_time() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * double(now.tv_sec) + double(now.tv_nsec);
}

int main(int argc, char **argv) {
  FILE *file = argc == 2 ? fopen(argv[1], "r") : nullptr;
  unsigned sizes[4];
  if (!file) return 1;
  for (unsigned &size : sizes) {
    if (fscanf(file, "%u", &size) != 1 || size < 1 || size > 10000000) return 1;
  }
  RegisterDefaultAllocator();
  Factory::sInstance = new Factory();
  RegisterTypes();
  auto numbers = [file](float *to, int count) {
    for (int i = 0; i < count; i++) {
      if (fscanf(file, "%f", to + i) != 1) exit(1);
    }
  };
  VertexList vertices;
  IndexedTriangleList triangles;
  Array<Vec3> corners;
  std::vector<Placed> poses;
  for (unsigned i = 0; i < sizes[0]; i++) {
    float p[3];
    numbers(p, 3);
    vertices.push_back(Float3(p[0], p[1], p[2]));
  }
  for (unsigned i = 0; i < sizes[1]; i++) {
    unsigned c[3];
    if (fscanf(file, "%u %u %u", c, c + 1, c + 2) != 3) return 1;
    triangles.push_back(IndexedTriangle(c[0], c[1], c[2], 0));
  }
  for (unsigned i = 0; i < sizes[2]; i++) {
    float p[3];
    numbers(p, 3);
    corners.push_back(Vec3(p[0], p[1], p[2]));
  }
  for (unsigned i = 0; i < 2 * sizes[3]; i++) {
    float p[7];
    numbers(p, 7);
    poses.push_back({Vec3(p[0], p[1], p[2]), Quat(p[3], p[4], p[5], p[6]).Normalized()});
  }
  fclose(file);
  Shape::ShapeResult ground = MeshShapeSettings(std::move(vertices), std::move(triangles)).Create();
  Shape::ShapeResult hull = ConvexHullShapeSettings(corners, 0.0f).Create();
  if (ground.HasError() || hull.HasError()) {
    fprintf(stderr, "%s\n", (ground.HasError() ? ground : hull).GetError().c_str());
    return 1;
  }
  for (int c = getchar(); c != EOF; c = getchar()) {
    if (c != '\n') continue;
    double times[2];
    size_t points = 0;
    float depth = 0.0f;
    for (int enhanced = 0; enhanced < 2; enhanced++) {
      double start = processor_time();
      points = 0;
      for (unsigned i = sizes[3]; i < 2 * sizes[3]; i++) {
        points += collide(hull.Get(), ground.Get(), poses[i], enhanced, depth);
      }
      times[enhanced] = processor_time() - start;
    }
    printf("%.1f %.1f %.3f %.9g\n", times[0] / sizes[3], times[1] / sizes[3], double(points) / sizes[3], depth);
    fflush(stdout);
  }
  return 0;
}
