/* The parts of a scene; private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_DATA_H
#define THRUM_SCENE_SCENE_DATA_H

#include <stdbool.h>

#include "thrum/scene.h"

/* A model as bodies step it: scaled, cut down, without a mesh. Shared by all bodies that want the
 * same; freed with the last of them. */
typedef struct scene_model {
  const thrum_model *from, *model; /* the same where nothing had to be changed */
  void *memory;                    /* of the latter; NULL then */
  int64_t rank;
  thrum_model_scaling by;
  int32_t users;
  struct scene_model *next;
} scene_model;

/* What of a body touches or is pulled: the rows of U' of these points, and the contact that reads
 * them. The points that touch come first, then a slot for each pull. */
typedef struct scene_touch {
  thrum_model model;   /* that the body steps, with these points as its mesh */
  double *rest, *rows; /* count x 3 [m], count x 3 x rank; in model */
  int32_t *places;     /* of the points that touch, one at least: 0, 1, ... */
  int64_t count;
  double material[3];
  bool idle;              /* no point touches: there are pulls alone */
  thrum_contact *contact; /* its own aligned block */
  size_t bytes;
} scene_touch;

/* A pull in one of a body's slots. */
typedef struct scene_pull {
  bool used;
  int64_t vertex;
  double target[3], stiffness, damping;
} scene_pull;

/* Force and torque on a free body as a whole, in the world. */
typedef struct scene_wrench {
  double force[3];  /* [N] */
  double torque[3]; /* about the centre of mass [N m] */
} scene_wrench;

/* One body. Vectors are of its model's full rank r, the first `rank` entries are in use. */
typedef struct scene_body {
  char name[THRUM_SCENE_NAME_MAX];
  const thrum_model *model;
  scene_model *derived;
  thrum_placement placement, here; /* at the start, and now */
  double k, g, mass;               /* U' = k U, q of the model = g q', U'^T M' = mass U^T M */
  float colour[3];
  thrum_state_def def;
  thrum_state *state; /* its own aligned block */
  double *vectors;    /* of all that follow, each r long */
  double *start_q, *start_p, *force, *inertia, *before, *q, *p;
  bool q_known, p_known; /* q, p are those of the present step */
  thrum_load *courses;   /* load_count; the first is gravity. As given, */
  thrum_load *now;       /* and counted from the scene's origin */
  double *directions;    /* load_count x r */
  int64_t load_count;
  bool free;
  double *parts; /* of a free body, load_count x 9 x r: world axis b of a load along body axis a */
  double *moments;    /* load_count x 9: arm along a times force along b [N m] */
  double *resultants; /* load_count x 3 [N] */
  thrum_translation way;
  thrum_rigid_frame rigid_frame;
  double start_momentum[3]; /* [kg m^2/s] */
  double start_velocity[3];
  int32_t *surface; /* surface_count vertices of the triangles, ascending */
  double *areas;    /* surface_count x 3, outward, of the scaled body [m^2] */
  double *stretch;  /* surface_count, |rows of U|^2 */
  int64_t surface_count;
  int32_t *touching;   /* touch_count vertices that may touch, */
  double *touch_areas; /* and what each stands for [m^2] */
  bool areas_known;    /* false: they are shared evenly */
  int64_t touch_count;
  double touch_stiffness;
  scene_touch *touch;      /* NULL: nothing to touch and no pull */
  scene_touch *touch_next; /* while obstacles are added */
  scene_pull pulls[THRUM_SCENE_PULLS];
  scene_wrench wrench; /* of the step to come */
  thrum_status status; /* < 0: stopped */
  int64_t fallback_steps;
  double work_load, work_base, dissipated;
} scene_body;

typedef struct scene_base_motion {
  const thrum_base_motion *motion; /* or NULL, and */
  double amplitude[3];
  thrum_load course, now;
} scene_base_motion;

typedef struct scene_probe {
  char name[THRUM_SCENE_NAME_MAX];
  int32_t body;
  double rest[3];
  double *rows; /* 3 x r, the mean of its vertices' rows of U */
} scene_probe;

struct thrum_scene {
  double dt, origin; /* time at step origin_step, from which loads are counted [s] */
  int64_t steps, origin_step;
  double gravity[3];
  double wind[3], air; /* air: 1/2 density drag [kg/m^3], 0: none */
  thrum_obstacle *obstacles, *obstacle_starts;
  int32_t obstacle_count;
  uint64_t revision; /* of all but what steps change */
  scene_body **bodies;
  int32_t body_count;
  scene_model *models;
  scene_base_motion *base_motions;
  int32_t base_motion_count;
  scene_probe *probes;
  int32_t probe_count;
  thrum_state **side; /* body_count: states of one model, for the step */
  thrum_status *side_status;
  int32_t *side_body;
  void *workspace; /* of thrum_batch_step, for the largest model that two bodies share */
  size_t workspace_size;
};

#endif
