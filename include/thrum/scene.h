/* A scene: placed bodies, the loads and obstacles that act on them, and their steps side by side.
 *
 * It is built over the public headers of libthrum alone: no files, no JSON, no printing, so that
 * the same code serves the program and a browser. A scene starts empty and is filled by the add and
 * set functions. A body keeps its state, a few vectors of its model's rank, and copies of only
 * those rows of the basis that touch, are pulled or are followed; the states work in scratch that
 * all bodies share.
 *
 * Memory: it is allocated while a scene is built or changed, never in a step, and
 * thrum_scene_destroy returns all of it. Models, surfaces and motions stay the caller's and must
 * outlive the scene; bodies share models, and bodies with equal models are stepped together.
 *
 * A point X + U q of a body's model is placed at  x = position + R scale (X + U q),  R the
 * rotation. A free body moves and rotates from there as a rigid frame about its centre of mass
 * (thrum/rigid_frame.h). World vectors (gravity, wind, forces) are rotated into each body's axes.
 * A uniform scale s, a factor e of Young's modulus and d of the density are exact (thrum/model.h,
 * thrum_model_scale).
 *
 * Threads: a scene belongs to one thread at a time; a step may be shared among the caller's threads
 * (thrum_scene_set_workers). Bodies, probes and loads are numbered from 0 in
 * the order in which they were added. Units are SI, vectors are in the world unless a field says
 * otherwise.
 *
 * Errors: a call that fails leaves the scene as it was. Each function refuses a body, load,
 * obstacle, pull or probe that does not exist with THRUM_INVALID_ARGUMENT, a number that is not
 * finite or out of its range with THRUM_BAD_VALUE, and returns THRUM_OUT_OF_MEMORY where it has to
 * allocate and cannot; further failures stand with the function.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_H
#define THRUM_SCENE_H

#include "thrum/api.h"
#include "thrum/fields.h"
#include "thrum/thrum.h"

#ifdef __cplusplus
extern "C" {
#endif

#define THRUM_SCENE_NAME_MAX 64 /* bytes of a body's or a probe's name and its 0 */

typedef struct thrum_scene thrum_scene; /* opaque */

/* Makes an empty scene at time 0 with the time step dt [s] and no gravity; the caller owns it and
 * passes it to thrum_scene_destroy. THRUM_INVALID_ARGUMENT unless dt is finite and > 0. */
THRUM_API thrum_status thrum_scene_create(double dt, thrum_scene **scene, thrum_error *error);

/* Frees a scene with all its bodies; NULL does nothing. */
THRUM_API void thrum_scene_destroy(thrum_scene *scene);

/* How a body is made. Start from thrum_default_scene_body_def and set at least the model. The
 * arrays are only read by thrum_scene_add_body; the model must outlive the scene. */
typedef struct thrum_scene_body_def {
  /* Set by thrum_default_scene_body_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* Name, cut to THRUM_SCENE_NAME_MAX bytes and copied; default NULL: "body" and its number from
   * 1. */
  const char *name;

  /* Model that the body steps; it has no default. */
  const thrum_model *model;

  /* Integrator, damping and solver; default thrum_default_state_def. The scene's dt replaces its
   * dt, and the scene lends scratch to all states whatever borrows_scratch says. */
  thrum_state_def state;

  /* model->rank each: q [kg^1/2 m] and p [kg^1/2 m/s] of the scaled body at the start; default
   * NULL: zero. */
  const double *q, *p;

  /* The rows of thrum/fields.h, which have their units, ranges and defaults. `rank`, `condense` and
   * `start_mode` are at most the model's rank; not both of the first two are set, and
   * THRUM_UNSUPPORTED for a lower rank of a model with cubature points. `free` needs a model with
   * `rigid` (THRUM_MISSING). `coupled` is for the integrator energy and rest damping, all of whose
   * coordinates are stepped (thrum/floating_frame.h): THRUM_UNSUPPORTED otherwise. Bodies touch
   * others (`collide`) where thrum_scene_set_collisions says so. `self_contact` (docs/contact.md)
   * needs triangles and a model with a material, and all of its coordinates: THRUM_MISSING,
   * THRUM_UNSUPPORTED with `condense`; its touches are as thick, rough and elastic as
   * thrum_scene_set_collisions says, or by its defaults. */
  THRUM_BODY_FIELDS(THRUM_MEMBER)
} thrum_scene_body_def;

/* A def with every default set; the model is NULL. size: of the def as the caller knows it, which
 * may be that of an earlier version (docs/versioning.md). state_size: of its member `state`. Any
 * thread. */
THRUM_API void thrum_scene_body_def_init(thrum_scene_body_def *def, size_t size, size_t state_size);

/* The same as a value. */
static inline thrum_scene_body_def thrum_default_scene_body_def(void) {
  thrum_scene_body_def def;
  thrum_scene_body_def_init(&def, sizeof def, sizeof def.state);
  return def;
}

/* Axes of a body or an obstacle with this rotation, a quaternion w, x, y, z of any length > 0:
 * 3 x 3 row-major, from body axes to the world. THRUM_BAD_VALUE for numbers that are not finite or
 * all zero. Any thread. */
THRUM_API thrum_status thrum_scene_axes(const double rotation[4], double axes[9],
                                        thrum_error *error);

/* Rotates a world vector into the axes of a body with this rotation; the two vectors may be the
 * same array. THRUM_BAD_VALUE as thrum_scene_axes. Any thread. */
THRUM_API thrum_status thrum_scene_to_body(const double rotation[4], const double in_world[3],
                                           double in_body[3], thrum_error *error);

/* Adds a body at its start; *body (may be NULL) gets its number. THRUM_UNINITIALISED_DEF,
 * THRUM_INVALID_ARGUMENT with the field, THRUM_MISSING where the model lacks an array that the body
 * or the scene's gravity and base motions need. */
THRUM_API thrum_status thrum_scene_add_body(thrum_scene *scene, const thrum_scene_body_def *def,
                                            int32_t *body, thrum_error *error);

/* Number of bodies. */
THRUM_API int32_t thrum_scene_body_count(const thrum_scene *scene);

/* Number of the first body called `name`; -1 where there is none. */
THRUM_API int32_t thrum_scene_find_body(const thrum_scene *scene, const char *name);

/* Sets gravity [m/s^2] for all bodies; larger: heavier bodies. THRUM_MISSING for a model without
 * axis_mass. */
THRUM_API thrum_status thrum_scene_set_gravity(thrum_scene *scene, const double gravity[3],
                                               thrum_error *error);

/* Gravity [m/s^2], 0 until it is set. */
THRUM_API void thrum_scene_gravity(const thrum_scene *scene, double gravity[3]);

/* How a load acts on a body. */
typedef enum thrum_scene_load_kind {
  THRUM_SCENE_FORCE = 0,        /* one force that vertices share equally */
  THRUM_SCENE_FIELD = 1,        /* a force on each vertex */
  THRUM_SCENE_ACCELERATION = 2, /* an acceleration of the whole body */
  THRUM_SCENE_REDUCED = 3       /* as thrum_scene_load_get gave it */
} thrum_scene_load_kind;

/* A load over time on one body, in world axes. Start from thrum_default_scene_load_def and set the
 * fields of its kind and the course. The arrays are only read by thrum_scene_add_load. */
typedef struct thrum_scene_load_def {
  /* Set by thrum_default_scene_load_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* The rows of thrum/fields.h, which have their units and defaults. A reduced load fits a body
   * with the same model, scale, density, rotation and freedom as that which it was got from. */
  THRUM_LOAD_FIELDS(THRUM_MEMBER)

  /* Factor of the load over the scene's time. */
  thrum_load course;
} thrum_scene_load_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_scene_load_def_init(thrum_scene_load_def *def, size_t size);

/* The same as a value. */
static inline thrum_scene_load_def thrum_default_scene_load_def(void) {
  thrum_scene_load_def def;
  thrum_scene_load_def_init(&def, sizeof def);
  return def;
}

/* Adds a load to a body. THRUM_UNINITIALISED_DEF, THRUM_INVALID_ARGUMENT or THRUM_BAD_VALUE with
 * the field, THRUM_MODEL_MISMATCH for arrays of another model's length, THRUM_MISSING for a force
 * or field on a model without a basis, or an acceleration of one without axis_mass. */
THRUM_API thrum_status thrum_scene_add_load(thrum_scene *scene, int32_t body,
                                            const thrum_scene_load_def *load, thrum_error *error);

/* Number of loads of a body; 0 where there is no such body. */
THRUM_API int64_t thrum_scene_load_count(const thrum_scene *scene, int32_t body);

/* Load `index` of a body into *load, as a reduced one. The scene owns its arrays, which stay until
 * something is added. */
THRUM_API thrum_status thrum_scene_load_get(const thrum_scene *scene, int32_t body, int64_t index,
                                            thrum_scene_load_def *load, thrum_error *error);

/* Adds a course of the level of an actuator (0-based) of a body: `level` (Pa, strain or N) times
 * the course over the scene's time (thrum/actuation.h); those of one actuator add up. The levels
 * are of the mesh in its file: a scaled body is under the same pressures and strains, and the same
 * tensions in newtons. A body with them steps all of its coordinates: it is not condensed, and has
 * neither fewer nor a level of detail (THRUM_UNSUPPORTED, whichever comes first).
 * THRUM_INVALID_ARGUMENT where there is no such actuator, THRUM_BAD_VALUE for what is not a number.
 * Levels that no state takes stop the body in its step. */
THRUM_API thrum_status thrum_scene_add_actuation(thrum_scene *scene, int32_t body, int64_t actuator,
                                                 double level, const thrum_load *course,
                                                 thrum_error *error);

/* Accelerates the ground under all bodies: by a motion sampled in time, which must outlive the
 * scene and have velocities and positions; or by `amplitude` [m/s^2] times a course. Bodies,
 * obstacles and probes are then relative to the ground. THRUM_MISSING for a model without axis_mass
 * or a motion without velocities or positions; THRUM_BAD_VALUE where the ground would go beyond
 * 1e30 m, or a course begins beyond 1e30 s or has a frequency that is not 0 to 1e30 Hz. */
THRUM_API thrum_status thrum_scene_add_base_motion_record(thrum_scene *scene,
                                                          const thrum_base_motion *motion,
                                                          thrum_error *error);
THRUM_API thrum_status thrum_scene_add_base_motion(thrum_scene *scene, const double amplitude[3],
                                                   const thrum_load *course, thrum_error *error);

/* Position of the ground [m], the sum of the base motions that are sampled in time or follow a
 * sine; the others only accelerate the bodies. */
THRUM_API void thrum_scene_ground(const thrum_scene *scene, double position[3]);

/* The wind. Start from thrum_default_scene_wind_def and set the velocity. */
typedef struct thrum_scene_wind_def {
  /* Set by thrum_default_scene_wind_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* The rows of thrum/fields.h, which have their units, ranges and defaults. */
  THRUM_WIND_FIELDS(THRUM_MEMBER)
} thrum_scene_wind_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_scene_wind_def_init(thrum_scene_wind_def *def, size_t size);

/* The same as a value. */
static inline thrum_scene_wind_def thrum_default_scene_wind_def(void) {
  thrum_scene_wind_def def;
  thrum_scene_wind_def_init(&def, sizeof def);
  return def;
}

/* Sets a wind that drags on the triangles of all bodies: each vertex gets 1/2 density drag A |v| v
 * with the velocity v of the air past it and A the area that its share of the triangles at rest
 * faces to the wind. The part that comes from the body's own motion is limited so that no dt is too
 * large. THRUM_BAD_VALUE with the field. Source: Hoerner 1965, Fluid-dynamic drag. */
THRUM_API thrum_status thrum_scene_set_wind(thrum_scene *scene, const thrum_scene_wind_def *def,
                                            thrum_error *error);

/* Adds an obstacle (thrum/contact.h), which moves with its velocity; *number (may be NULL) gets its
 * number. It fails as thrum_obstacle_check, or as thrum_contact_size for a body that may touch. */
THRUM_API thrum_status thrum_scene_add_obstacle(thrum_scene *scene, const thrum_obstacle *obstacle,
                                                int32_t *number, thrum_error *error);

/* Number of obstacles. */
THRUM_API int32_t thrum_scene_obstacle_count(const thrum_scene *scene);

/* Gets an obstacle where it is now, and sets one from now on; their number stays. */
THRUM_API thrum_status thrum_scene_obstacle_get(const thrum_scene *scene, int32_t number,
                                                thrum_obstacle *obstacle, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_obstacle(thrum_scene *scene, int32_t number,
                                                const thrum_obstacle *obstacle, thrum_error *error);

/* Shapes of a solid, each about its own origin. */
typedef enum thrum_solid_shape {
  THRUM_SOLID_MESH = 0,        /* the triangles of the def */
  THRUM_SOLID_BOX = 1,         /* with the sides 2 half */
  THRUM_SOLID_CYLINDER = 2,    /* about its z axis, with flat ends */
  THRUM_SOLID_CAPSULE = 3,     /* the same with half spheres on its ends */
  THRUM_SOLID_HEIGHT_FIELD = 4 /* over its xy plane, open from below */
} thrum_solid_shape;

/* An obstacle that is touched by its faces, edges and corners, and by those of the bodies, as
 * bodies touch each other (thrum/contact_pairs.h); it may move along a path. Start from
 * thrum_default_scene_solid_def and set the fields of the shape. The arrays are only read by
 * thrum_scene_add_solid. */
typedef struct thrum_scene_solid_def {
  /* Set by thrum_default_scene_solid_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* The rows of thrum/fields.h, which have their units, ranges and defaults. Faces of cylinders are
   * within radius (1 - cos(pi / segments)) of the round. A path rests before its first time and
   * after its last. No position, velocity or vertex may be beyond 1e30. */
  THRUM_SOLID_FIELDS(THRUM_MEMBER)
} thrum_scene_solid_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_scene_solid_def_init(thrum_scene_solid_def *def, size_t size);

/* The same as a value. */
static inline thrum_scene_solid_def thrum_default_scene_solid_def(void) {
  thrum_scene_solid_def def;
  thrum_scene_solid_def_init(&def, sizeof def);
  return def;
}

/* Adds a solid; *number (may be NULL) gets its number, from 0 on, apart from those of obstacles.
 * All bodies with triangles touch it, with their def's restitution and friction replaced by the
 * solid's; condensed bodies do not. THRUM_UNINITIALISED_DEF, THRUM_INVALID_ARGUMENT or
 * THRUM_BAD_VALUE with the field. */
THRUM_API thrum_status thrum_scene_add_solid(thrum_scene *scene, const thrum_scene_solid_def *def,
                                             int32_t *number, thrum_error *error);

/* Number of solids. */
THRUM_API int32_t thrum_scene_solid_count(const thrum_scene *scene);

/* The surface of a solid about its own origin, as thrum_scene_add_solid made it, and where it is
 * now. The scene owns the arrays. */
typedef struct thrum_scene_solid {
  const double *vertices; /* vertex_count x 3 [m] */
  int64_t vertex_count;
  const int32_t *triangles; /* triangle_count x 3 */
  int64_t triangle_count;
  thrum_placement now;
} thrum_scene_solid;

/* Fills *solid. THRUM_INVALID_ARGUMENT for a solid that does not exist. */
THRUM_API thrum_status thrum_scene_solid_get(const thrum_scene *scene, int32_t number,
                                             thrum_scene_solid *solid, thrum_error *error);

/* Makes all bodies with triangles touch each other from now on (thrum/contact_pairs.h): those that
 * are there, whose def has `collide`, and those that are added. Counts of the def, such as its
 * member_max, are found by the scene; touch_max is for all bodies together. NULL: bodies pass
 * through each other, as before the first call. A later change, and a body that needs more room,
 * forget what touches now. Condensed bodies do not touch others. A body with
 * `self_contact` touches itself whatever this is. Fails as thrum_contact_pairs_size
 * and thrum_skin_size. */
THRUM_API thrum_status thrum_scene_set_collisions(thrum_scene *scene,
                                                  const thrum_contact_pairs_def *def,
                                                  thrum_error *error);

/* Counters and energies of contact between the bodies; all zero where they do not touch. */
THRUM_API thrum_contact_pairs_report thrum_scene_collisions(const thrum_scene *scene);

/* Touch `index` (0-based, below the report's touching) of the last step, or an impact behind them
 * (as many as the report's struck); thrum_scene_thing_of says what its bodies are.
 * THRUM_INVALID_ARGUMENT beyond the last. */
THRUM_API thrum_status thrum_scene_collision_get(const thrum_scene *scene, int64_t index,
                                                 thrum_pair_touch *touch, thrum_error *error);

/* What a body touches, by its number among those of its kind. */
typedef enum thrum_scene_kind {
  THRUM_SCENE_ANYTHING = 0, /* all together; no number */
  THRUM_SCENE_BODY = 1,
  THRUM_SCENE_SOLID = 2,
  THRUM_SCENE_OBSTACLE = 3
} thrum_scene_kind;

typedef struct thrum_scene_thing {
  thrum_scene_kind kind;
  int32_t number;
} thrum_scene_thing;

/* The body or the solid that a number in `bodies` of a touch stands for. Any thread. */
THRUM_API thrum_scene_thing thrum_scene_thing_of(int32_t number);

/* The force of contact on a body, mean over the last step [N], into `force`: of another body, of a
 * solid, of an obstacle, or of anything. Impacts that are listed count by their impulse over the
 * step. 0 of what did not touch. THRUM_INVALID_ARGUMENT for what the scene does not have; the scene
 * must not step meanwhile. */
THRUM_API thrum_status thrum_scene_contact_force(const thrum_scene *scene, int32_t body,
                                                 thrum_scene_thing from, double force[3],
                                                 thrum_error *error);

/* A body that lies inside an obstacle or another body. */
typedef struct thrum_scene_overlap {
  int32_t body;     /* -1: none does */
  int32_t other;    /* the body that it is in; -1: none */
  int32_t obstacle; /* that it is in; -1: a body or a solid */
  int32_t solid;    /* that it is in; -1: none */
  double depth;     /* of its deepest point that was found [m] */
  double diagonal;  /* of the body's box [m] */
} thrum_scene_overlap;

/* Finds the overlap at present that is deepest for the size of its body: of vertices that may touch
 * with obstacles, of spheres with bodies, and of bodies that touch each other or solids, or would
 * if they were not condensed, by their vertices, by edges that go through faces, and by points of
 * their middle. A body that begins inside an obstacle is thrown out by the springs that it overlaps
 * (`granted` of its contact); one that begins inside another body is not seen there. It looks at
 * all edges and faces that may meet, and allocates: call it before a run and not in it. */
THRUM_API thrum_status thrum_scene_find_overlap(thrum_scene *scene, thrum_scene_overlap *deepest,
                                                thrum_error *error);

/* A side of a link that was made before, which needs no mesh: thrum_scene_link_made gives it. */
typedef struct thrum_scene_link_side {
  /* 4 x 3, in the axes of the scaled body: the place at rest [m], and three directions at right
   * angles [1]; of the world's side the directions alone are read, which are those of the world. */
  double rest[12];

  /* 4 x 3 x rank: the rows of the scaled body's U of the place [kg^-1/2] and of the directions
   * [kg^-1/2 m^-1]; NULL: the world's side. */
  const double *rows;

  /* Coordinates that the body steps; 0 of the world's side. */
  int64_t rank;
} thrum_scene_link_side;

/* How a link is made (thrum/link.h). Start from thrum_default_scene_link_def and set at least the
 * body. The arrays are only read by thrum_scene_add_link. */
typedef struct thrum_scene_link_def {
  /* Set by thrum_default_scene_link_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* Numbers of the body and of the other one; default 0 and -1: the world. */
  int32_t body, other;

  /* The rows of thrum/fields.h, which have their units, ranges and defaults. A place is in the
   * world now, within 1e6 times the size of the body; vertices are then weighed so that it is
   * theirs, those near it where no list says which. Joints have one place. A path displaces the end
   * in the world by the difference of its position from the first one, at up to 1e30 m/s; it rests
   * before and after, and its times are within 1e30 s. */
  THRUM_LINK_FIELDS(THRUM_MEMBER)

  /* The two sides of a link that was made before, between bodies that stood as they do now and had
   * the same models, scales, densities and ranks. They replace vertices, axis and meshes; `place`
   * and, for a spring, `other_place` must then be given. Default NULL: the sides are made from the
   * meshes. */
  const thrum_scene_link_side *sides;
} thrum_scene_link_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_scene_link_def_init(thrum_scene_link_def *def, size_t size);

/* The same as a value. */
static inline thrum_scene_link_def thrum_default_scene_link_def(void) {
  thrum_scene_link_def def;
  thrum_scene_link_def_init(&def, sizeof def);
  return def;
}

/* Links two bodies, or a body and the world, as they are now; *number (may be NULL) gets the
 * link's number, from 0 on. A joint begins to hold in the next step, and what did not move together
 * there comes to rest in two steps, at a loss. A body that is linked steps on with the coordinates
 * that it has; condensed bodies cannot be linked. After thrum_scene_reset links that were added
 * before the first step hold again, and no others.
 * THRUM_UNINITIALISED_DEF, THRUM_INVALID_ARGUMENT or THRUM_BAD_VALUE with the field, THRUM_MISSING
 * for a model without a basis, THRUM_MODEL_MISMATCH for sides of other ranks than the bodies
 * step. */
THRUM_API thrum_status thrum_scene_add_link(thrum_scene *scene, const thrum_scene_link_def *def,
                                            int32_t *number, thrum_error *error);

/* Link `number` as it was added, into *def, with its sides ready: thrum_scene_add_link makes it of
 * that again, with the same bits, before the first step of a scene whose models may have no mesh.
 * The scene owns the arrays of the def, which stay until something is added.
 * THRUM_INVALID_ARGUMENT for a link that does not exist. */
THRUM_API thrum_status thrum_scene_link_made(const thrum_scene *scene, int32_t number,
                                             thrum_scene_link_def *def, thrum_error *error);

/* Number of links. */
THRUM_API int32_t thrum_scene_link_count(const thrum_scene *scene);

/* Lets a link go from now on; one that has let go stays so. */
THRUM_API thrum_status thrum_scene_link_release(thrum_scene *scene, int32_t number,
                                                thrum_error *error);

/* A link as it is now. */
typedef struct thrum_scene_link {
  thrum_link_kind kind;
  int32_t holds;            /* 0: it has let go, as it does after a body of it failed */
  int32_t bodies[2];        /* numbers; the second -1: the world */
  double length;            /* of a spring without force [m] */
  double places[2][3];      /* where its two ends are [m] */
  thrum_link_report report; /* since the start */
} thrum_scene_link;

/* Fills *link. THRUM_INVALID_ARGUMENT for a link that does not exist. */
THRUM_API thrum_status thrum_scene_link_get(thrum_scene *scene, int32_t number,
                                            thrum_scene_link *link, thrum_error *error);

/* Energy and momentum of all bodies together. Without obstacles, held bodies, loads and pulls the
 * momenta are constant, gravity apart, and the total falls by what damping and contact take. */
typedef struct thrum_scene_account {
  double kinetic, potential, gravity; /* sums over the bodies [J] */
  double contact;                     /* of the springs of obstacles and between bodies [J] */
  double links;                       /* of the springs between places [J] */
  double total;                       /* the sum of the five [J] */
  double momentum[3];                 /* of the free bodies [kg m/s] */
  double angular_momentum[3];         /* of the free bodies, about the world's origin [kg m^2/s] */
} thrum_scene_account;

/* Fills *account at the present time. THRUM_NOT_FINITE where an energy overflows. */
THRUM_API thrum_status thrum_scene_account_get(thrum_scene *scene, thrum_scene_account *account,
                                               thrum_error *error);

/* Largest number of pulls of one body at a time. */
#define THRUM_SCENE_PULLS 4

/* Starts a spring that pulls a vertex of a body (0-based) to a target in the world [m], such as the
 * mouse; *pull gets its number, which holds until it ends. stiffness [N/m], 0 to 1e30; larger: the
 * vertex follows more closely. damping [N s/m], at most 1e30; larger: it follows more slowly;
 * negative: critical damping. THRUM_MISSING for a model without a basis, THRUM_INVALID_ARGUMENT
 * where the body has THRUM_SCENE_PULLS already. */
THRUM_API thrum_status thrum_scene_pull_start(thrum_scene *scene, int32_t body, int64_t vertex,
                                              const double target[3], double stiffness,
                                              double damping, int32_t *pull, thrum_error *error);

/* Moves the target of a pull [m]. */
THRUM_API thrum_status thrum_scene_pull_move(thrum_scene *scene, int32_t pull,
                                             const double target[3], thrum_error *error);

/* Ends a pull. */
THRUM_API thrum_status thrum_scene_pull_end(thrum_scene *scene, int32_t pull, thrum_error *error);

/* Position of the pulled vertex [m], and the mean force of the last step on it [N]; either may be
 * NULL. */
THRUM_API thrum_status thrum_scene_pull_get(thrum_scene *scene, int32_t pull, double point[3],
                                            double force[3], thrum_error *error);

/* Makes one step of every body that has not stopped. A body whose step fails keeps its state and
 * stops: the others continue, its status says why, and thrum_scene_reset starts it again. Returns
 * the first failure in this step, with the body's name in `error`, else THRUM_FELL_BACK if a body
 * fell back, else THRUM_SWITCHED if one has switched its scheme, else THRUM_OK. Allocates
 * nothing. */
THRUM_API thrum_status thrum_scene_step(thrum_scene *scene, thrum_error *error);

/* Largest number of workers of a scene. */
#define THRUM_SCENE_WORKERS_MAX 256

/* Does `task` once for each index from 0 below `count`, on threads of the caller's, and returns
 * when all are done. `worker` is 0 or more and below the scene's workers; no two tasks that run at
 * the same time have the same. */
typedef void (*thrum_scene_run)(void *context, int32_t count,
                                void (*task)(void *of, int32_t index, int32_t worker), void *of);

/* Makes thrum_scene_step share its bodies among `workers` (1 to THRUM_SCENE_WORKERS_MAX; default 1)
 * by calls of `run`, which gets `context` and may be NULL for one worker. The library starts no
 * thread itself. Every body ends with the same bits, whatever the number of workers. Bodies that
 * are near each other form a group, which steps on one worker; different groups step on different
 * ones. With contact between bodies each worker has room for as many touches as the scene.
 * THRUM_INVALID_ARGUMENT for numbers out of range, THRUM_OUT_OF_MEMORY. */
THRUM_API thrum_status thrum_scene_set_workers(thrum_scene *scene, int32_t workers,
                                               thrum_scene_run run, void *context,
                                               thrum_error *error);

/* Time of the scene [s], its completed steps, and its time step [s]. */
THRUM_API double thrum_scene_time(const thrum_scene *scene);
THRUM_API int64_t thrum_scene_steps(const thrum_scene *scene);
THRUM_API double thrum_scene_dt(const thrum_scene *scene);

/* The next six functions change a parameter between two steps; q and p stay. Ranges are those of
 * thrum_state_def and thrum_scene_body_def, THRUM_INVALID_ARGUMENT beyond them. The lowest
 * `rank` coordinates are stepped, and those beyond follow, as after thrum_scene_set_condensed; the
 * rank of the model steps all. THRUM_UNSUPPORTED for a lower rank of a model with cubature points,
 * and of a body that touches itself, other bodies or obstacles with faces. thrum_scene_reset
 * restores q, p and time, but keeps these parameters. */
THRUM_API thrum_status thrum_scene_set_dt(thrum_scene *scene, double dt, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_damping(thrum_scene *scene, int32_t body, double alpha,
                                               double beta, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_stiffness(thrum_scene *scene, int32_t body, double stiffness,
                                                 thrum_error *error);
THRUM_API thrum_status thrum_scene_set_integrator(thrum_scene *scene, int32_t body,
                                                  thrum_integrator integrator, thrum_error *error);
THRUM_API thrum_status thrum_scene_set_rank(thrum_scene *scene, int32_t body, int64_t rank,
                                            thrum_error *error);

/* As thrum_scene_set_rank: from now on the lowest `masters` coordinates are stepped and the others
 * follow them (1 to one less than the model's rank; larger: more vibration, and slower), or all are
 * stepped again (0). Coordinates that are stepped again go on from where they followed, so the
 * shape does not jump; those that begin to follow jump to where they follow.
 * THRUM_INVALID_ARGUMENT beyond these numbers, and for both calls where the body has a level of
 * detail; THRUM_UNSUPPORTED where a body that touches itself would be condensed. A condensed body
 * does not touch others. */
THRUM_API thrum_status thrum_scene_set_condensed(thrum_scene *scene, int32_t body, int64_t masters,
                                                 thrum_error *error);

/* Level of detail of a body: with how few coordinates it is stepped where it is not looked at
 * closely.
 * Zero-initialise it, and set `masters`, `jump` and `beyond` or `still`. */
typedef struct thrum_scene_detail {
  /* Coordinates that are stepped while the body is far or still, the others following; 1 to one
   * less than the model's rank. Larger: less is lost, and slower. */
  int64_t masters;

  /* The body is far while its middle is further than this from the eye [m]; >= 0, default 0: never.
   * Once far, it is near again within 0.9 of it. */
  double beyond;

  /* The body is still while, for a period of its lowest frequency, no vertex moves or deforms
   * faster than this [m/s], nothing pulls it, no obstacle that moves may reach it, and no load or
   * base motion changes so that a vertex would become as fast; >= 0, default 0: never. Judged by
   * bounds, so that the body is rather stepped whole. Larger: it is still sooner. */
  double still;

  /* No vertex may jump further than this where the number of coordinates changes [m]; > 0. A change
   * that would is put off. Larger: changes come sooner. */
  double jump;
} thrum_scene_detail;

/* Sets the level of detail of a body: from now on thrum_scene_update_detail changes how many
 * coordinates it steps. As it is stepped now is how it is stepped near, and how it starts again
 * after thrum_scene_reset; thrum_scene_set_rank and thrum_scene_set_condensed are refused until it
 * is taken away. NULL: it stays as it is.
 * A body that may touch others is not changed, because condensed bodies do not touch others.
 * THRUM_MISSING for a model without a basis, THRUM_INVALID_ARGUMENT for numbers beyond their
 * ranges, and where fewer coordinates than `masters` are stepped already. */
THRUM_API thrum_status thrum_scene_set_detail(thrum_scene *scene, int32_t body,
                                              const thrum_scene_detail *detail, thrum_error *error);

/* Sets the place that distances are from, such as the camera [m]; the origin until it is set. */
THRUM_API thrum_status thrum_scene_set_eye(thrum_scene *scene, const double eye[3],
                                           thrum_error *error);

/* Looks at all bodies with a level of detail, between two steps, and changes how many coordinates
 * those step that are far or still, or no longer. What comes back goes on from where it followed,
 * so its shape does not jump. A change is one of thrum_scene_set_condensed: it allocates, it ends
 * the validity of snapshots, and the energy of what no longer vibrates is lost. Call it every few
 * steps, at equal distances, and before the next step where a call has changed what acts on bodies:
 * loads on still bodies are looked at for twice the steps since the last update, 256 at most, so
 * that they find all coordinates stepped. It costs some operations for each coordinate and load.
 * THRUM_OUT_OF_MEMORY leaves the body that it came to, and those behind it, as they were. */
THRUM_API thrum_status thrum_scene_update_detail(thrum_scene *scene, thrum_error *error);

/* The level of detail of a body: what it has done since it was set. */
typedef struct thrum_scene_detail_report {
  int32_t set;           /* 1: the body has one; else all is zero */
  int32_t reduced;       /* 1: it steps the fewer coordinates at present */
  int64_t changes;       /* of the number of coordinates */
  int64_t put_off;       /* updates that put a change off for its jump */
  int64_t reduced_steps; /* steps made with the fewer coordinates */
  double largest_jump;   /* of any vertex in any change, measured [m] */
  double energy;         /* that changes have given to the body, mostly negative [J] */
  double distance;       /* of its middle from the eye at the last update [m] */
  double speed;          /* bound of the speed of its vertices then [m/s] */
} thrum_scene_detail_report;

/* Fills *report. */
THRUM_API thrum_status thrum_scene_body_detail(const thrum_scene *scene, int32_t body,
                                               thrum_scene_detail_report *report,
                                               thrum_error *error);

/* Sets the time to 0 and every body, obstacle and counter to its start; stopped bodies start again.
 */
THRUM_API thrum_status thrum_scene_reset(thrum_scene *scene, thrum_error *error);

/* A snapshot holds everything that steps change, in thrum_scene_snapshot_size bytes of the caller's
 * memory; `size` is the size of that memory (THRUM_BUFFER_TOO_SMALL). It can be restored as long as
 * nothing was added, no pull was started or ended, and no rank, level of detail, integrator,
 * stiffness, damping or dt was changed (THRUM_MODEL_MISMATCH). Steps after a restore give the same
 * bits again.
 *
 * The bytes may have been in a file or in another process with the same scene: THRUM_BAD_CHECKSUM
 * for changed ones, THRUM_BAD_FORMAT for none of a snapshot, THRUM_UNSUPPORTED for another version
 * or byte order, THRUM_BAD_VALUE for numbers that no scene can have. The scene then stays as it
 * was. */
THRUM_API size_t thrum_scene_snapshot_size(const thrum_scene *scene);
THRUM_API thrum_status thrum_scene_snapshot(const thrum_scene *scene, void *memory, size_t size,
                                            thrum_error *error);
THRUM_API thrum_status thrum_scene_restore(thrum_scene *scene, const void *memory, size_t size,
                                           thrum_error *error);

/* Parameters and counters of a body at present. The scene owns what the pointers point to. */
typedef struct thrum_scene_body_info {
  const char *name;
  const thrum_model *model; /* as it was given */
  const thrum_model
      *stepped;      /* scaled and of the rank below; without a mesh unless it is `model` */
  int64_t rank;      /* coordinates that are stepped */
  int64_t shown;     /* coordinates that show the body: all of them where the others follow */
  int32_t condensed; /* 1: they follow */
  double scale, stiffness, density;   /* factors of the def [1] */
  thrum_integrator integrator;        /* its integrator */
  double damping_alpha, damping_beta; /* Rayleigh damping [1/s] and [s] */
  float colour[3];                    /* that of the def */
  thrum_status status;                /* < 0: the body stopped for this reason */
  int64_t fallback_steps;             /* steps that fell back since the start */
  double work_load,                   /* work of loads and gravity since the start [J] */
      work_base;                      /* work of the moving ground since the start [J] */
  double work_actuators;              /* work of the actuators since the start [J] */
  double dissipated;                  /* energy that damping and plastic flow took since the
                                         start [J] */
  double plastic_work;                /* of it, that plastic flow took [J] */
  double plastic_strain;              /* thrum_state_plastic_strain */
  double point_stiffness;             /* thrum_state_point_stiffness */
  int32_t free;                       /* 1: it moves and rotates as a whole */
  double mass;                        /* mass of a free body [kg]; 0: held */
  thrum_contact_report contact;       /* zero for a body without contact and pulls */
  thrum_state_report report;          /* counters since the start, or since the last change of
                                         damping, stiffness, integrator or rank */
  size_t bytes;                       /* heap memory of this body without shared models */
} thrum_scene_body_info;

/* Fills *info. */
THRUM_API thrum_status thrum_scene_body(const thrum_scene *scene, int32_t body,
                                        thrum_scene_body_info *info, thrum_error *error);

/* thrum_state_stepped_modes of a body: `modes` has as many entries as it has coordinates that are
 * stepped, the rank of its info. */
THRUM_API thrum_status thrum_scene_body_stepped_modes(const thrum_scene *scene, int32_t body,
                                                      thrum_stepped_mode *modes,
                                                      thrum_error *error);

/* Energies of a body [J]. */
typedef struct thrum_scene_energies {
  double kinetic, potential; /* as thrum_energies; kinetic with that of a free body */
  double gravity; /* -f q and the height of a free body; zero at rest in the initial position */
  double contact; /* energy of the contact springs */
  double total;   /* the sum of the four */
  double high;    /* as thrum_energies; not in the sum */
} thrum_scene_energies;

/* Energies of a body at the present time. THRUM_NOT_FINITE where one overflows. */
THRUM_API thrum_status thrum_scene_body_energies(thrum_scene *scene, int32_t body,
                                                 thrum_scene_energies *energies,
                                                 thrum_error *error);

/* Writes q [kg^1/2 m] and p [kg^1/2 m/s] of the scaled body, of the coordinates that show it (the
 * rank that is stepped, or all that follow it as well: `shown` of its info); either may be NULL. */
THRUM_API thrum_status thrum_scene_body_get(thrum_scene *scene, int32_t body, double *q, double *p,
                                            thrum_error *error);

/* Writes the coordinates q (model->rank) with which the model as it was given has the body's shape,
 * so that one surface, monitor or set of stress points of that model serves all its bodies.
 * Positions are then in the model's axes and lengths; thrum_scene_body_matrix places them. */
THRUM_API thrum_status thrum_scene_body_shape(thrum_scene *scene, int32_t body, double *q,
                                              thrum_error *error);

/* Writes the mean force of obstacles and pulls in the last step, as a load [kg^1/2 m/s^2] on the
 * coordinates q of the model as it was given: load[i] / omega2[i] is how far it holds coordinate i
 * away (model->rank; zero for a body that touches nothing). Of a body whose coordinates follow, it
 * has the part on those as well, which no step knows. Touches of solids and of other bodies are not
 * in it. THRUM_INVALID_ARGUMENT where there is no such body. */
THRUM_API thrum_status thrum_scene_body_contact_load(const thrum_scene *scene, int32_t body,
                                                     double *load, thrum_error *error);

/* Writes the matrix from the model's coordinates to the world, 4 x 4 column-major as in OpenGL and
 * three.js. */
THRUM_API void thrum_scene_body_matrix(const thrum_scene *scene, int32_t body, double matrix[16]);

/* Writes X + U q of all vertices of a surface of the body's model, in the model's coordinates; out,
 * stride and failures as in thrum_surface_positions, and THRUM_MODEL_MISMATCH for a surface of
 * another model. */
THRUM_API thrum_status thrum_scene_body_positions(thrum_scene *scene, int32_t body,
                                                  const thrum_surface *surface, float *out,
                                                  int64_t stride, thrum_error *error);

/* Position [m] and velocity [m/s] of one vertex (0-based) in the world; velocity may be NULL.
 * THRUM_MISSING for a model without a basis, THRUM_NOT_FINITE for a number beyond the range. */
THRUM_API thrum_status thrum_scene_body_vertex(thrum_scene *scene, int32_t body, int64_t vertex,
                                               double position[3], double velocity[3],
                                               thrum_error *error);

/* Adds a probe, a point that is followed: the mean of `count` vertices of a body (0-based; NULL:
 * all). The name is copied; NULL: a default with its number. THRUM_MISSING for a model without a
 * basis. */
THRUM_API thrum_status thrum_scene_add_probe(thrum_scene *scene, const char *name, int32_t body,
                                             const int32_t *vertices, int64_t count,
                                             thrum_error *error);

/* Number of probes; the name of one, NULL where there is no such probe; and its body, or -1. */
THRUM_API int32_t thrum_scene_probe_count(const thrum_scene *scene);
THRUM_API const char *thrum_scene_probe_name(const thrum_scene *scene, int32_t probe);
THRUM_API int32_t thrum_scene_probe_body(const thrum_scene *scene, int32_t probe);

/* Position [m] and velocity [m/s] of a probe in the world; velocity may be NULL. */
THRUM_API thrum_status thrum_scene_probe_get(thrum_scene *scene, int32_t probe, double position[3],
                                             double velocity[3], thrum_error *error);

/* What has fields by the rows of thrum/fields.h. */
typedef enum thrum_scene_record {
  THRUM_SCENE_RECORD_BODY = 0,     /* thrum_scene_body_def */
  THRUM_SCENE_RECORD_OBSTACLE = 1, /* thrum_obstacle */
  THRUM_SCENE_RECORD_SOLID = 2,    /* thrum_scene_solid_def */
  THRUM_SCENE_RECORD_LINK = 3,     /* thrum_scene_link_def */
  THRUM_SCENE_RECORD_PAIRS = 4,    /* thrum_contact_pairs_def */
  THRUM_SCENE_RECORD_WIND = 5,     /* thrum_scene_wind_def */
  THRUM_SCENE_RECORD_LOAD = 6      /* thrum_scene_load_def, with its course */
} thrum_scene_record;

/* What a member holds. */
typedef enum thrum_field_kind {
  THRUM_FIELD_DOUBLE = 0, /* width doubles */
  THRUM_FIELD_FLOAT = 1,  /* width floats */
  THRUM_FIELD_INT64 = 2,
  THRUM_FIELD_INT32 = 3,
  THRUM_FIELD_FLAG = 4,    /* int32_t, 0 or 1 */
  THRUM_FIELD_CHOICE = 5,  /* an enum: see `names` */
  THRUM_FIELD_DOUBLES = 6, /* const double *: rows of width numbers, counted at count_offset */
  THRUM_FIELD_INTS = 7,    /* const int32_t *: the same */
  THRUM_FIELD_GRID = 8 /* const double *: rows x columns, counted at count_offset and behind it */
} thrum_field_kind;

/* A row: its texts are static. */
typedef struct thrum_field {
  const char *name, *about;
  const char *unit;      /* NULL: none */
  const char *otherwise; /* NULL: nothing to say */
  const char *names;     /* of a choice, from 0 on, with blanks between; NULL: it is none */
  thrum_field_kind kind;
  int32_t width;       /* numbers of a member, or of a row of an array */
  double least, most;  /* range of each number; -INFINITY and INFINITY where it has no end */
  int32_t above;       /* 1: least itself is not in it */
  int32_t key;         /* 1: it is a key of scene files too */
  size_t offset;       /* of the member in the def [bytes] */
  size_t count_offset; /* of the int64_t that counts the rows of an array */
} thrum_field;

/* The fields of a record, *count of them, in the order of the rows; NULL and 0 for what is no
 * record. Static storage. Any thread. */
THRUM_API const thrum_field *thrum_scene_fields(thrum_scene_record record, int64_t *count);

/* Bytes of the def of a record; 0 for what is no record. Any thread. */
THRUM_API size_t thrum_scene_record_size(thrum_scene_record record);

/* Fills a def of a record, thrum_scene_record_size bytes at `def`, with its defaults. Any thread.
 */
THRUM_API void thrum_scene_record_default(thrum_scene_record record, void *def);

#ifdef __cplusplus
}
#endif
#endif
