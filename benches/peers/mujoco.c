/* MuJoCo's convex collision on the pairs of `peer-table`, which compiles and starts this program.
 *
 *   mujoco MODEL.xml POSES
 *
 * POSES holds the number of poses, and for each the numbers x y z qw qx qy qz of B in A's frame. The
 * program prints the depth of each pose, -1 without a contact, and the three components of its normal,
 * one number a line. Then it reads lines of three integers FIRST END STEP, and answers the poses FIRST,
 * FIRST + STEP, ... below END twice. For each line it prints the processor time of the second pass, in
 * nanoseconds per pose.
 *
 * The function is the one that MuJoCo's own pipeline calls for two meshes. The poses of the geoms are
 * computed beforehand, as the pipeline does. */
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Pose of a geom, as in mjData. */
typedef struct {
  mjtNum pos[3], mat[9];
} Pose;

/* Processor time of this thread, in nanoseconds. */
static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* Pose of a geom whose body has the pose x y z qw qx qy qz. MuJoCo moves a mesh to its centre of mass
 * and principal axes, and the geom moves it back. */
static Pose of_geom(const mjModel *m, int geom, const double *body) {
  Pose pose;
  mjtNum turn[9], own[9];
  mju_quat2Mat(turn, body + 3);
  mju_quat2Mat(own, m->geom_quat + 4 * geom);
  mju_mulMatVec3(pose.pos, turn, m->geom_pos + 3 * geom);
  mju_addTo3(pose.pos, body);
  mju_mulMatMat(pose.mat, turn, own, 3, 3, 3);
  return pose;
}

static void place(mjData *d, int geom, const Pose *pose) {
  memcpy(d->geom_xpos + 3 * geom, pose->pos, sizeof pose->pos);
  memcpy(d->geom_xmat + 9 * geom, pose->mat, sizeof pose->mat);
}

/* The poses, or NULL if the file does not hold them. */
static Pose *read_poses(FILE *file, const mjModel *m, int *count) {
  if (fscanf(file, "%d", count) != 1 || *count < 1 || *count > 1000000) return NULL;
  Pose *poses = calloc((size_t)*count, sizeof *poses);
  for (int i = 0; poses && i < *count; i++) {
    double p[7];
    for (int j = 0; j < 7; j++) {
      if (fscanf(file, "%lf", p + j) != 1) return NULL;
    }
    poses[i] = of_geom(m, 1, p);
  }
  return poses;
}

int main(int argc, char **argv) {
  char error[500] = "";
  mjModel *m = argc == 3 ? mj_loadXML(argv[1], NULL, error, sizeof error) : NULL;
  FILE *file = m ? fopen(argv[2], "r") : NULL;
  int count = 0;
  Pose *poses = file ? read_poses(file, m, &count) : NULL;
  if (!poses) {
    fprintf(stderr, "mujoco: cannot read the model or the poses: %s\n", error);
    return 2;
  }
  mjData *d = mj_makeData(m);
  mj_forward(m, d);
  mjfCollision collide = mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH];
  mjPreContact found[64];
  const double here[7] = {0, 0, 0, 1, 0, 0, 0};
  Pose a = of_geom(m, 0, here);
  place(d, 0, &a);
  for (int i = 0; i < count; i++) {
    place(d, 1, poses + i);
    int contacts = collide(m, d, found, 0, 1, 0);
    const mjtNum *n = found[0].normal;
    if (contacts > 0) printf("%.17g\n%.17g\n%.17g\n%.17g\n", -found[0].dist, n[0], n[1], n[2]);
    else printf("-1\n0\n0\n0\n");
  }
  fflush(stdout);
  int first, end, step;
  while (scanf("%d %d %d", &first, &end, &step) == 3 && first >= 0 && first < end && end <= count && step > 0) {
    double start = 0, stop = 0;
    for (int pass = 0; pass < 2; pass++) {
      start = now();
      for (int i = first; i < end; i += step) {
        place(d, 1, poses + i);
        collide(m, d, found, 0, 1, 0);
      }
      stop = now();
    }
    printf("%.3f\n", (stop - start) / ((end - first + step - 1) / step));
    fflush(stdout);
  }
  return 0;
}
