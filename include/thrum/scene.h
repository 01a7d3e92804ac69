/* A scene: placed bodies, what acts on them, and their steps side by side.
 *
 * Built over the public headers of libthrum alone: no files, no JSON, no printing, so that the same
 * code serves the program and a browser. A scene is made empty and filled with what it shall have;
 * only what is named is built: a body keeps its state and a few vectors of its model's rank, and no
 * row of the basis but those of what touches, is pulled or followed. Memory is allocated while a
 * scene is built or changed, never in a step. Models, surfaces and motions stay the caller's and
 * must outlive the scene; models are shared by all bodies, and bodies with equal models are stepped
 * together.
 *
 * A point X + U q of a body's model is placed at  x = position + R scale (X + U q),  R the
 * rotation. A free body moves and turns from there as a rigid frame about its centre of mass
 * (thrum/rigid_frame.h). World vectors (gravity, wind, forces) are turned into each body's axes, so
 * turning a body and all that acts on it changes nothing. A uniform scale s, a factor e of Young's
 * modulus and d of the density are exact (thrum/model.h, thrum_model_scale).
 *
 * A scene belongs to one thread at a time. Bodies, probes and loads are numbered from 0 in the
 * order in which they were added. SI units. A call that fails leaves the scene as it was.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_H
#define THRUM_SCENE_H

#include "thrum/api.h"
#include "thrum/thrum.h"

#ifdef __cplusplus
extern "C" {
#endif

#define THRUM_SCENE_NAME_MAX 64 /* bytes of a body's or a probe's name, with its 0 */

typedef struct thrum_scene thrum_scene; /* opaque */

/* An empty scene at time 0 with time step dt [s] and no gravity. thrum_scene_free frees; NULL is
 * fine there. */
THRUM_API thrum_status thrum_scene_make(double dt, thrum_scene **scene, thrum_error *error);
THRUM_API void thrum_scene_free(thrum_scene *scene);

/* One body. Fill it from thrum_default_scene_body_def. */
typedef struct thrum_scene_body_def {
  uint32_t cookie;
  const char *name;         /* copied; NULL: "body" and its number from 1 */
  const thrum_model *model; /* must stay */
  double position[3];       /* of the model's origin [m] */
  double rotation[4];       /* quaternion w, x, y, z; of any length but 0; default 1, 0, 0, 0 */
  double scale;             /* of lengths, > 0; default 1 */
  double stiffness;         /* factor of Young's modulus, > 0; default 1 */
  double density;           /* factor of the density, > 0; default 1 */
  int64_t rank;             /* coordinates that are stepped; 0 (default): all of the model */
  float colour[3];          /* red, green, blue in [0, 1]; carried along, never used here */
  thrum_state_def state;    /* its dt is ignored: that of the scene holds */
  const double *q, *p;      /* start, of the model's rank, as the scaled body has it; NULL: zero */
  int64_t start_mode;       /* from 1: this basis vector is added to q, 0: none, */
  double start_amplitude;   /* so that the vertex that moves furthest is displaced so far [m] */
  int32_t free;             /* 1: it may move and turn as a whole; of a model with `rigid` */
  double velocity[3];       /* of a free body at the start [m/s] */
  double spin[3];           /* its angular velocity at the start, in the world [rad/s] */
  /* Outer triangles, 3 vertices each, counter-clockwise from outside: for wind, and the areas of
   * what touches; only read here. */
  const int32_t *triangles;
  int64_t triangle_count;
  const int32_t *touch; /* vertices that may touch obstacles, less those held; only read here */
  int64_t touch_count;
  double touch_stiffness; /* pressure per depth [N/m^3]; 0: see thrum_contact_def */
} thrum_scene_body_def;
THRUM_API thrum_scene_body_def thrum_default_scene_body_def(void);

/* Axes of a body or an obstacle with this rotation (a quaternion w, x, y, z of any length but 0): 3
 * x 3 row-major, from them to the world. THRUM_BAD_VALUE for a rotation that is none. */
THRUM_API thrum_status thrum_scene_axes(const double rotation[4], double axes[9],
                                        thrum_error *error);

/* Turns a world vector into the axes of a body with this rotation, in place if the two are one;
 * THRUM_BAD_VALUE for a rotation that is none. */
THRUM_API thrum_status thrum_scene_to_body(const double rotation[4], const double in_world[3],
                                           double in_body[3], thrum_error *error);

/* Adds a body at its start; *body (may be NULL) gets its number. */
THRUM_API thrum_status thrum_scene_add_body(thrum_scene *scene, const thrum_scene_body_def *def,
                                            int32_t *body, thrum_error *error);
THRUM_API int32_t thrum_scene_body_count(const thrum_scene *scene);
/* The body called `name`, or -1. */
THRUM_API int32_t thrum_scene_find_body(const thrum_scene *scene, const char *name);

/* What acts on bodies. Gravity [m/s^2] needs models with axis_mass, forces models with a basis. */
THRUM_API thrum_status thrum_scene_set_gravity(thrum_scene *scene, const double gravity[3],
                                               thrum_error *error);
THRUM_API void thrum_scene_gravity(const thrum_scene *scene, double gravity[3]);

/* A load over time on one body, in world axes: `force` [N] is shared evenly by `count` vertices
 * (NULL: all of the body); or a field of forces, vertex_count x 3 [N]; or an acceleration [m/s^2]
 * of the whole body; or what thrum_scene_body_load gave of a body with the same model, scale,
 * density, rotation and freedom. Only read here. */
typedef enum thrum_scene_load_kind {
  THRUM_SCENE_FORCE = 0,
  THRUM_SCENE_FIELD = 1,
  THRUM_SCENE_ACCELERATION = 2,
  THRUM_SCENE_REDUCED = 3
} thrum_scene_load_kind;
typedef struct thrum_scene_load {
  thrum_scene_load_kind kind;
  double vector[3];        /* force or acceleration */
  const int32_t *vertices; /* of a force, 0-based */
  int64_t count;
  const double *field; /* of a field */
  thrum_load course;   /* times the load; its time is the scene's */
  /* Of a reduced one: what it is on the coordinates of the scaled body, rank of its model; and of
   * a free body, which may turn, 3 x 3 x rank: row [a, b] of the load's world component b along
   * the body's axis a. */
  const double *reduced, *parts;
  double moments[9];   /* of a free body, [a, b]: arm along a times force b, at rest [N m] */
  double resultant[3]; /* of a free body, in the world [N] */
} thrum_scene_load;
THRUM_API thrum_status thrum_scene_add_load(thrum_scene *scene, int32_t body,
                                            const thrum_scene_load *load, thrum_error *error);
/* Load `number` of a body, from 0 in the order in which they were added, as a reduced one; its
 * arrays are the scene's and stay until something is added. A body without it:
 * THRUM_INVALID_ARGUMENT. */
THRUM_API int64_t thrum_scene_load_count(const thrum_scene *scene,
                                         int32_t body); /* no such body: 0 */
THRUM_API thrum_status thrum_scene_body_load(const thrum_scene *scene, int32_t body, int64_t number,
                                             thrum_scene_load *load, thrum_error *error);

/* The ground under all bodies accelerates: by a motion sampled in time, which must stay, and of
 * which velocities are known; or by `amplitude` [m/s^2] times a course. Bodies, obstacles and
 * probes are then seen from the ground. Needs models with axis_mass. */
THRUM_API thrum_status thrum_scene_add_base_motion_record(thrum_scene *scene,
                                                          const thrum_base_motion *motion,
                                                          thrum_error *error);
THRUM_API thrum_status thrum_scene_add_base_motion(thrum_scene *scene, const double amplitude[3],
                                                   const thrum_load *course, thrum_error *error);
/* Where the ground is, all base motions together [m]. */
THRUM_API void thrum_scene_ground(const thrum_scene *scene, double position[3]);

/* Air that drags on the triangles of all bodies: on each vertex  1/2 density drag A |v| v,  v the
 * speed of the air past it and A the area that its share of the triangles at rest turns to the
 * wind. What the body's own motion adds is limited to what a step can take, so that no dt is too
 * large. density 0: none. */
THRUM_API thrum_status thrum_scene_set_wind(thrum_scene *scene, const double velocity[3],
                                            double density, double drag, thrum_error *error);

/* Something in the way, see thrum/contact.h. One with a velocity moves. */
THRUM_API thrum_status thrum_scene_add_obstacle(thrum_scene *scene, const thrum_obstacle *obstacle,
                                                int32_t *number, thrum_error *error);
THRUM_API int32_t thrum_scene_obstacle_count(const thrum_scene *scene);
/* As it is now, or from now on; its count stays. */
THRUM_API thrum_status thrum_scene_obstacle(const thrum_scene *scene, int32_t number,
                                            thrum_obstacle *obstacle, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_obstacle(thrum_scene *scene, int32_t number,
                                                const thrum_obstacle *obstacle, thrum_error *error);

/* A spring that pulls a vertex of a body to a target in the world, such as the mouse: stiffness
 * [N/m]; damping [N s/m], negative for critical. At most THRUM_SCENE_PULLS a body; *pull numbers
 * it until it ends. */
#define THRUM_SCENE_PULLS 4
THRUM_API thrum_status thrum_scene_pull_start(thrum_scene *scene, int32_t body, int64_t vertex,
                                              const double target[3], double stiffness,
                                              double damping, int32_t *pull, thrum_error *error);
THRUM_API thrum_status thrum_scene_pull_move(thrum_scene *scene, int32_t pull,
                                             const double target[3], thrum_error *error);
THRUM_API thrum_status thrum_scene_pull_end(thrum_scene *scene, int32_t pull, thrum_error *error);
/* The pulled point, and the mean force of the last step [N]; either may be NULL. */
THRUM_API thrum_status thrum_scene_pull_get(thrum_scene *scene, int32_t pull, double point[3],
                                            double force[3], thrum_error *error);

/* One step of every body that has not stopped. A body whose step fails keeps its state and stops:
 * the others go on, its status says why, and thrum_scene_reset starts it anew. Returns the first
 * failure in this step, else THRUM_FELL_BACK if a body did, else THRUM_OK. */
THRUM_API thrum_status thrum_scene_step(thrum_scene *scene, thrum_error *error);
THRUM_API double thrum_scene_time(const thrum_scene *scene); /* [s] */
THRUM_API int64_t thrum_scene_steps(const thrum_scene *scene);
THRUM_API double thrum_scene_dt(const thrum_scene *scene);

/* Changes between two steps; q and p stay. Rank: coordinates that go are lost, those that come are
 * at rest. What a body was given at first comes back with thrum_scene_reset only for q, p, time. */
THRUM_API thrum_status thrum_scene_set_dt(thrum_scene *scene, double dt, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_damping(thrum_scene *scene, int32_t body, double alpha,
                                               double beta, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_stiffness(thrum_scene *scene, int32_t body, double stiffness,
                                                 thrum_error *error);
THRUM_API thrum_status thrum_scene_set_integrator(thrum_scene *scene, int32_t body,
                                                  thrum_integrator integrator, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_rank(thrum_scene *scene, int32_t body, int64_t rank,
                                            thrum_error *error);
/* Back to time 0 and to the start of every body. */
THRUM_API thrum_status thrum_scene_reset(thrum_scene *scene, thrum_error *error);

/* All that steps change, in `size` = thrum_scene_snapshot_size bytes of the caller's. A snapshot
 * can be restored as long as nothing was added, no pull started or ended, and no rank, integrator,
 * stiffness, damping or dt was changed (THRUM_MODEL_MISMATCH). Steps after a restore have the bits
 * of those before. */
THRUM_API size_t thrum_scene_snapshot_size(const thrum_scene *scene);
THRUM_API thrum_status thrum_scene_snapshot(const thrum_scene *scene, void *memory, size_t size,
                                            thrum_error *error);
THRUM_API thrum_status thrum_scene_restore(thrum_scene *scene, const void *memory, size_t size,
                                           thrum_error *error);

/* What a body is now. */
typedef struct thrum_scene_body_info {
  const char *name;
  const thrum_model *model;   /* as it was given */
  const thrum_model *stepped; /* scaled, of the rank below, and without a mesh where it differs */
  int64_t rank;
  double scale, stiffness, density;
  thrum_integrator integrator;
  double damping_alpha, damping_beta;
  float colour[3];
  thrum_status status;    /* < 0: stopped, and why */
  int64_t fallback_steps; /* since the start */
  double work_load,
      work_base;     /* done by loads and gravity, and by the ground, since the start [J] */
  double dissipated; /* by damping, rest form [J] */
  int32_t free;
  double mass;                  /* of a free body [kg]; 0: held */
  thrum_contact_report contact; /* zero where nothing touches or pulls */
  thrum_state_report report;    /* counters are since the last change of the state */
  size_t bytes;                 /* heap memory of this body alone, shared models apart */
} thrum_scene_body_info;
THRUM_API thrum_status thrum_scene_body(const thrum_scene *scene, int32_t body,
                                        thrum_scene_body_info *info, thrum_error *error);

/* Energies of a body [J]. */
typedef struct thrum_scene_energies {
  double kinetic, potential; /* as thrum_energies */
  double gravity;            /* -f q, zero at rest in place; with the way of a free body */
  double contact;            /* in the springs of contact */
  double total;              /* the sum */
  double high;               /* as thrum_energies; not in the sum */
} thrum_scene_energies;
THRUM_API thrum_status thrum_scene_body_energies(thrum_scene *scene, int32_t body,
                                                 thrum_scene_energies *energies,
                                                 thrum_error *error);

/* q and p (either may be NULL) of the body's rank, as the scaled body has them. */
THRUM_API thrum_status thrum_scene_body_get(thrum_scene *scene, int32_t body, double *q, double *p,
                                            thrum_error *error);

/* The coordinates q of the model as it was given, of its full rank, that have the body's shape:
 * what is built over that model (a surface, stress points, a monitor) serves all bodies of it.
 * Positions are then in the model's axes and lengths; thrum_scene_body_matrix puts them in place.
 */
THRUM_API thrum_status thrum_scene_body_shape(thrum_scene *scene, int32_t body, double *q,
                                              thrum_error *error);
/* From the model's coordinates to the world: column-major 4 x 4, as OpenGL and three.js have it. */
THRUM_API void thrum_scene_body_matrix(const thrum_scene *scene, int32_t body, double matrix[16]);
/* X + U q of a surface of the body's model, see thrum_surface_positions: for the matrix above. */
THRUM_API thrum_status thrum_scene_body_positions(thrum_scene *scene, int32_t body,
                                                  const thrum_surface *surface, float *out,
                                                  int64_t stride, thrum_error *error);
/* Position [m] and velocity [m/s] of one vertex in the world; velocity may be NULL. */
THRUM_API thrum_status thrum_scene_body_vertex(thrum_scene *scene, int32_t body, int64_t vertex,
                                               double position[3], double velocity[3],
                                               thrum_error *error);

/* A point to be followed: the mean of `count` vertices of a body (0-based; NULL: all). */
THRUM_API thrum_status thrum_scene_add_probe(thrum_scene *scene, const char *name, int32_t body,
                                             const int32_t *vertices, int64_t count,
                                             thrum_error *error);
THRUM_API int32_t thrum_scene_probe_count(const thrum_scene *scene);
THRUM_API const char *thrum_scene_probe_name(const thrum_scene *scene,
                                             int32_t probe);                       /* NULL: none */
THRUM_API int32_t thrum_scene_probe_body(const thrum_scene *scene, int32_t probe); /* -1: none */
THRUM_API thrum_status thrum_scene_probe(thrum_scene *scene, int32_t probe, double position[3],
                                         double velocity[3], thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
