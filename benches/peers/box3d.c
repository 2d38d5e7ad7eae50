/* Box3D's narrow phase on the bodies of `mesh-table`, which compiles and starts this program.
 *
 *   box3d SCENE
 *
 * SCENE holds the numbers of positions, triangles, corners of the hull and bodies. Then follow the
 * positions, three indices for each triangle, the corners, and twice the poses of all bodies, each as
 * x y z qx qy qz qw. For each line that the program reads, it makes a world with all bodies at their
 * first poses, and prints two times in nanoseconds per body: of the contacts when they are new, and
 * after the bodies moved to their second poses; the mean number of contact points of a body; and the
 * depth of the deepest contact at the first poses.
 *
 * Box3D itself measures the times, for its stage "collide". It runs on this thread.
 * Contacts are not recycled: each is computed. Bodies touch the ground only, and nothing moves them. */
#include <box3d/box3d.h>
#include <box3d/collision.h>
#include <box3d/constants.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct {
  b3Pos at;
  b3Quat turn;
} Placed;

static int read_floats(FILE *file, float *to, int count) {
  for (int i = 0; i < count; i++) {
    if (fscanf(file, "%f", to + i) != 1) return 0;
  }
  return 1;
}

static int read_points(FILE *file, b3Vec3 *to, int count) {
  for (int i = 0; i < count; i++) {
    float p[3];
    if (!read_floats(file, p, 3)) return 0;
    to[i] = (b3Vec3){p[0], p[1], p[2]};
  }
  return 1;
}

static int read_poses(FILE *file, Placed *to, int count) {
  for (int i = 0; i < count; i++) {
    float p[7];
    if (!read_floats(file, p, 7)) return 0;
    to[i].at = (b3Pos){p[0], p[1], p[2]};
    to[i].turn = (b3Quat){{p[3], p[4], p[5]}, p[6]};
  }
  return 1;
}

/* The mean number of contact points of a body. Raises a depth to the depth of the deepest one. Box3D adds an offset to
 * depths on meshes, at which it keeps bodies off them. */
static double points(const b3BodyId *bodies, int count, float *depth) {
  static b3ContactData contacts[64];
  long total = 0;
  for (int i = 0; i < count; i++) {
    int found = b3Body_GetContactData(bodies[i], contacts, 64);
    for (int c = 0; c < found; c++) {
      for (int m = 0; m < contacts[c].manifoldCount; m++) {
        const b3Manifold *manifold = contacts[c].manifolds + m;
        total += manifold->pointCount;
        for (int p = 0; p < manifold->pointCount; p++) {
          *depth = fmaxf(*depth, -manifold->points[p].separation - B3_MESH_REST_OFFSET);
        }
      }
    }
  }
  return (double)total / count;
}

static void measure(const b3MeshData *ground, const b3HullData *hull, const Placed *poses, int count,
                    b3BodyId *bodies) {
  b3WorldDef settings = b3DefaultWorldDef();
  settings.gravity = (b3Vec3){0, 0, 0};
  settings.enableSleep = false;
  settings.enableContinuous = false;
  settings.workerCount = 1;
  b3WorldId world = b3CreateWorld(&settings);
  b3World_SetContactRecycleDistance(world, 0);
  b3BodyDef still = b3DefaultBodyDef();
  b3ShapeDef shape = b3DefaultShapeDef();
  shape.filter.categoryBits = 1;
  b3CreateMeshShape(b3CreateBody(world, &still), &shape, ground, (b3Vec3){1, 1, 1});
  shape.filter.categoryBits = 2;
  shape.filter.maskBits = 1;
  for (int i = 0; i < count; i++) {
    b3BodyDef body = b3DefaultBodyDef();
    body.type = b3_dynamicBody;
    body.position = poses[i].at;
    body.rotation = poses[i].turn;
    bodies[i] = b3CreateBody(world, &body);
    b3CreateHullShape(bodies[i], &shape, hull);
  }
  float times[2], depth = 0;
  double touching = 0;
  for (int step = 0; step < 2; step++) {
    for (int i = 0; step > 0 && i < count; i++) {
      b3Body_SetTransform(bodies[i], poses[count + i].at, poses[count + i].turn);
    }
    b3World_Step(world, 1e-6f, 1);
    times[step] = b3World_GetProfile(world).collide;
    if (step == 0) touching = points(bodies, count, &depth);
  }
  printf("%.1f %.1f %.3f %.9g\n", 1e6 * times[0] / count, 1e6 * times[1] / count, touching, depth);
  fflush(stdout);
  b3DestroyWorld(world);
}

int main(int argc, char **argv) {
  FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
  int sizes[4];
  if (!file) return 1;
  for (int i = 0; i < 4; i++) {
    if (fscanf(file, "%d", sizes + i) != 1 || sizes[i] < 1 || sizes[i] > 10000000) return 1;
  }
  b3Vec3 *positions = calloc((size_t)sizes[0], sizeof *positions);
  int32_t *indices = calloc((size_t)sizes[1], 3 * sizeof *indices);
  b3Vec3 *corners = calloc((size_t)sizes[2], sizeof *corners);
  Placed *poses = calloc((size_t)sizes[3], 2 * sizeof *poses);
  b3BodyId *bodies = calloc((size_t)sizes[3], sizeof *bodies);
  if (!positions || !indices || !corners || !poses || !bodies || !read_points(file, positions, sizes[0])) return 1;
  for (int i = 0; i < 3 * sizes[1]; i++) {
    if (fscanf(file, "%d", indices + i) != 1) return 1;
  }
  if (!read_points(file, corners, sizes[2]) || !read_poses(file, poses, 2 * sizes[3])) return 1;
  fclose(file);
  b3MeshDef mesh = {0};
  mesh.vertices = positions;
  mesh.indices = indices;
  mesh.vertexCount = sizes[0];
  mesh.triangleCount = sizes[1];
  mesh.identifyEdges = true;
  b3MeshData *ground = b3CreateMesh(&mesh, NULL, 0);
  b3HullData *hull = b3CreateHull(corners, sizes[2], sizes[2]);
  if (!ground || !hull) return 1;
  for (int c = getchar(); c != EOF; c = getchar()) {
    if (c == '\n') measure(ground, hull, poses, sizes[3], bodies);
  }
  return 0;
}
