/* The parts of a scene: what its structures hold. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_PRIVATE_H
#define THRUM_SCENE_SCENE_PRIVATE_H

#include <stdatomic.h>
#include <stdbool.h>

#include "thrum/floating_frame.h"
#include "thrum/scene.h"

/* A model as bodies step it: scaled, cut down, without a mesh. Shared by all bodies that want the
 * same; freed with the last of them. */
/* Numbers of solids, and of ends of links, among the members of a step begin here. */
#define SOLID_MEMBERS (INT32_C(1) << 20)
#define LINK_MEMBERS (INT32_C(1) << 21)

typedef struct scene_model {
  const thrum_model *from, *model; /* the same where nothing had to be changed */
  void *memory;                    /* of the latter; NULL then */
  void *unscaled;                  /* where a scaled condensed model has how its slaves follow */
  int64_t rank;
  bool condensed; /* the other coordinates follow */
  thrum_model_scaling by;
  thrum_inertia *inertia; /* of bodies whose rotation is coupled to their shape; NULL: none yet */
  int32_t users;
  struct scene_model *next;
} scene_model;

/* The part of a body that touches or is pulled: the rows of U' of these points, and the contact
 * that reads them. The points that touch come first, then a slot for each pull. */
typedef struct scene_touch {
  thrum_model model;   /* that the body steps, with these points as its mesh */
  double *rest, *rows; /* count x 3 [m], count x 3 x rank; in model */
  int64_t *vertices;   /* count: of the body's model; -1: a pull's place that is not in use */
  int32_t *places;     /* of the points that touch, one at least: 0, 1, ... */
  int64_t count;
  double material[3];
  bool idle;              /* no point touches: there are pulls alone */
  thrum_contact *contact; /* its own aligned block */
  size_t bytes;
} scene_touch;

/* The surface of a model as bodies touch each other with it; shared by all bodies that want the
 * same; freed with the last of them. */
typedef struct scene_skin {
  const scene_model *of;
  int32_t *triangles; /* triangle_count x 3 vertices of the model as it was given */
  int64_t triangle_count;
  void *memory;
  thrum_skin *skin; /* in memory */
  int32_t users;
  struct scene_skin *next;
} scene_skin;

/* An obstacle with a surface. */
typedef struct scene_solid {
  double *vertices;
  int32_t *triangles;
  int64_t vertex_count, triangle_count;
  double position[3], rotation[4], velocity[3];
  double *times, *places; /* path_count, path_count x 7; NULL: it goes by its velocity */
  int64_t path_count;
  double friction, restitution;
  bool open; /* it has no inside */
  void *memory;
  thrum_skin *skin; /* in memory */
  thrum_contact_solid moving;
  thrum_skin_bound bound; /* in the step to come */
} scene_solid;

typedef struct scene_link {
  int32_t body, other;          /* other -1: the world */
  thrum_scene_link_side *sides; /* 2; owned, so that they stay where they are */
  double *rows[2];              /* those of the sides; owned, NULL of the world */
  double place[3];              /* of the first side as it was added [m] */
  double end[3];                /* of the second, the world's where its path begins [m] */
  double *times, *path;         /* path_count, path_count x 3 */
  int64_t path_count;
  double until;  /* [s] */
  int64_t since; /* step before which it was added */
  double began;  /* energy in the spring as it was added [J] */
  bool released;
  bool holds;                 /* in this step */
  thrum_contact_solid moving; /* the world's end in this step */
  thrum_link tie;
} scene_link;

/* Contact between bodies: its block, and lists with a place for each body of the scene. */
typedef struct scene_pairs {
  thrum_contact_pairs *contact; /* `workers` aligned blocks; NULL: none may touch */
  thrum_contact_pairs_def def;
  size_t size;                   /* of a block; the first holds the touches of all */
  thrum_contact_member *members; /* member_room a worker */
  int64_t member_room;
  int32_t *firsts;             /* the first body of each group */
  thrum_contact_group *groups; /* what their steps did */
  int32_t group_count;
  atomic_int next; /* the group that is stepped next */
  thrum_contact_environment *environments;
  thrum_pull *pulls; /* THRUM_SCENE_PULLS a body */
  thrum_link *ties;  /* tie_room a worker */
  int64_t tie_room;
  thrum_skin_bound *bounds;
  int32_t *order, *group;
  int32_t ordered; /* bodies in `order`, which keeps that of the step before */
} scene_pairs;

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

/* The counts of a state's report, which a scene keeps for as long as the body lives. */
typedef struct scene_counts {
  int64_t fallback_steps;
  double dissipated, plastic_work, work_actuators;
} scene_counts;

/* The level of an actuator over time, as given and counted from the scene's origin. */
typedef struct scene_act {
  int64_t actuator;
  double level;
  thrum_load course, now;
} scene_act;

/* A body with a level of detail, as its updates have seen it. */
typedef struct scene_seen {
  double last_time;   /* of the last update [s]; negative: there was none */
  double quiet_since; /* when it moved too fast, or something acted on it, last [s] */
  int64_t last_steps; /* of the scene at the last update */
  uint64_t stirred;   /* of the scene at the last update */
  int64_t far;        /* 1: it was far */
  thrum_scene_detail_report report;
} scene_seen;

/* The level of detail of a body. */
typedef struct scene_detail {
  thrum_scene_detail def;
  int64_t near;          /* masters of the body as it is stepped near; 0: none, all are stepped */
  double *peaks;         /* model's rank: largest length of a basis vector at a vertex; owned */
  double *last;          /* model's rank: coordinates at the last update; owned by peaks */
  double middle[3];      /* of the box around the body, in the axes and lengths of its model, */
  double half[3];        /* and half its sides */
  scene_model *followed; /* as it is stepped far, kept from one change to the next */
  scene_model *whole;    /* as it is stepped near */
  scene_seen seen;       /* what snapshots keep of it, with `last` */
} scene_detail;

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
  double *answered;      /* of a condensed body: the load that its slaves answer to, */
  double *pulled;        /* that of the pulls of the last step, which they answer to as well, */
  double *slopes;        /* slaves x masters, how they follow; room for any number of masters */
  bool q_known, p_known; /* q, p are those of the present step */
  thrum_load *courses;   /* load_count; the first is gravity. As given, */
  thrum_load *now;       /* and counted from the scene's origin */
  double *directions;    /* load_count x r */
  int64_t load_count;
  scene_act *acts; /* act_count */
  int64_t act_count;
  bool free;
  double *parts; /* of a free body, load_count x 9 x r: world axis b of a load along body axis a */
  double *moments;    /* load_count x 9: arm along a times force along b [N m] */
  double *resultants; /* load_count x 3 [N] */
  thrum_translation way;
  thrum_rigid_frame rigid_frame;
  double *inertia_work; /* of a free body whose rotation is coupled to its shape; NULL: it is not */
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
  bool collides;           /* it may touch other bodies, where the scene has them touch */
  bool self_contact;       /* it may touch itself */
  int32_t *triangles;      /* triangle_count x 3, of a body that may; else NULL */
  int64_t triangle_count;
  scene_skin *skin;     /* NULL: it touches no body */
  int32_t tied;         /* links that it has or had */
  int32_t group;        /* of bodies that are near each other in this step; -1: none */
  thrum_status stepped; /* of the step of its group */
  scene_pull pulls[THRUM_SCENE_PULLS];
  scene_wrench wrench; /* of the step to come */
  thrum_status status; /* < 0: stopped */
  double work_load, work_base;
  scene_detail *detail;      /* NULL: none */
  scene_counts before_state; /* of states that changes of parameters have replaced */
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

/* Bodies of one model that step side by side on one worker, in thrum_scene's `side`. */
typedef struct scene_chunk {
  const scene_model *model;
  int32_t from, count;
  thrum_error error;
} scene_chunk;

struct thrum_scene {
  double dt, origin; /* time at step origin_step, from which loads are counted [s] */
  int64_t steps, origin_step;
  double gravity[3];
  double eye[3];       /* that distances of bodies are from [m] */
  double wind[3], air; /* air: 1/2 density drag [kg/m^3], 0: none */
  thrum_obstacle *obstacles, *obstacle_starts;
  int32_t obstacle_count;
  bool collides; /* bodies touch each other; solids are touched whatever this is */
  scene_pairs pairs;
  scene_skin *skins;
  scene_solid *solids;
  int32_t solid_count;
  scene_link *links;
  int32_t link_count;
  uint64_t revision; /* of all but what steps change */
  uint64_t stirred;  /* counts calls that change what acts on bodies */
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
  thrum_error *side_error; /* body_count: of a body's own part of a step */
  scene_chunk *chunks;     /* body_count */
  int32_t workers;         /* at least 1 */
  thrum_scene_run run;     /* NULL: one worker */
  void *run_context;
  void *workspace; /* workers blocks, of thrum_batch_step, for the largest model of two bodies */
  size_t workspace_size;
  void *scratch; /* workers blocks, which the states borrow */
  size_t scratch_size;
};

#endif
