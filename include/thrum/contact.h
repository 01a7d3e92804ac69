/* Contact of one body with obstacles, and springs that pull it, as a mean load of each step
 * (docs/contact.md).
 *
 * Chosen vertices of a body meet planes, spheres and boxes: a penalty spring that pushes and never
 * pulls, with restitution, damping and Coulomb friction. Springs with damping pull points of the
 * body towards targets, such as a mouse pointer. All forces are solved implicitly at the end of the
 * step in reduced coordinates and handed to the integrator as its mean load, whichever integrator
 * it is; no stiffness is too large for dt. Contact gives back only energy that it took before: see
 * thrum_contact_report. A free body may also move as a whole (thrum_translation,
 * thrum_rigid_frame).
 *
 *   thrum_contact_step(model, state, contact, &environment, &error);   in place of thrum_step
 *
 * or thrum_contact_begin, thrum_step or thrum_batch_step, thrum_contact_end, without the repeated
 * attempts of thrum_contact_step.
 *
 * Memory: a contact is planned (thrum_contact_size), then laid into the caller's memory
 * (thrum_contact_init). It holds no pointer, so within a program a snapshot is memcpy of
 * thrum_contact_bytes bytes; take it together with that of its state. Bytes from elsewhere go
 * through thrum_contact_copy_check first. No function here allocates, prints or keeps a global.
 *
 * Threads: a contact belongs to one thread at a time, with its state and the environment that it
 * moves. The model is only read and may be shared.
 *
 * Units are SI; coordinates are those of the world unless a field says otherwise.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONTACT_H
#define THRUM_CONTACT_H

#include "thrum/api.h"
#include "thrum/fields.h"
#include "thrum/inertia.h"
#include "thrum/rigid_frame.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Stiffnesses and dampings above this are refused [N/m^3, N/m, and so on]. */
#define THRUM_CONTACT_STIFFNESS_MAX 1e30

/* Motion of a free body as a whole, apart from its placement. A plain value that the caller owns.
 */
typedef struct thrum_translation {
  double mass;        /* [kg], finite and > 0; larger: forces move the body less */
  double position[3]; /* displacement from the placement [m], finite */
  double velocity[3]; /* [m/s], finite */
} thrum_translation;

typedef enum thrum_obstacle_shape {
  THRUM_OBSTACLE_PLANE = 0,
  THRUM_OBSTACLE_SPHERE = 1,
  THRUM_OBSTACLE_BOX = 2
} thrum_obstacle_shape;

/* A rigid obstacle. Start from thrum_default_obstacle and change fields. The caller owns it, passes
 * it in every step and may change it between steps. */
typedef struct thrum_obstacle {
  /* Set by thrum_default_obstacle; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* The rows of thrum/fields.h, which have their units, ranges and defaults. Lengths and velocities
   * are within 1e30, laws up to 1e30. The caller moves the centre with the velocity. A stiffness of
   * 0 is that of the contact. A free body strikes an obstacle with a stiffness or a damping by that
   * spring alone, also where it is near-rigid (docs/contact.md). Restitution is that of a
   * near-rigid free body as a whole, and of the points of one that is softer or held; 1: an impact
   * loses no energy to it. */
  THRUM_OBSTACLE_FIELDS(THRUM_MEMBER)
} thrum_obstacle;

/* An obstacle with every default set: the plane z = 0. Any thread. */
THRUM_API thrum_obstacle thrum_default_obstacle(void);

/* Checks an obstacle; `index` is its place in a list, for the message. THRUM_UNINITIALISED_DEF, or
 * THRUM_BAD_VALUE with the field and its range. thrum_contact_begin and _step check each of theirs
 * with it. Any thread. */
THRUM_API thrum_status thrum_obstacle_check(const thrum_obstacle *obstacle, int64_t index,
                                            thrum_error *error);

/* A spring from a point of the body to a target. The point is the weighted mean of three vertices,
 * such as a point of a triangle; the three may be equal. There are no defaults: set every field. */
typedef struct thrum_pull {
  /* 0-based vertices of the model. */
  int32_t vertices[3];

  /* Weights of the vertices [1]; finite, with the sum 1. */
  double weights[3];

  /* Target at the start of the step [m]; finite. */
  double target[3];

  /* Velocity of the target during the step [m/s]; finite. */
  double velocity[3];

  /* Stiffness of the spring [N/m]; 0 to 1e30. Larger: the point follows the target more closely. */
  double stiffness;

  /* Damping of the spring [N s/m]; at most 1e30. Larger: the point follows more slowly; negative:
   * critical damping for the mass that the point feels. */
  double damping;

  /* Largest force of the pull [N]; 0 to 1e30. Larger: it can deform the body more. 0: the force
   * that displaces the point by the diagonal of the body's box at rest, and twice the force on the
   * translation. */
  double force_max;

  /* How far what is not stepped gives way where the pull acts, at rest and in the world [m/N]: 3 x
   * 3, symmetric, entries up to 1e30, no eigenvalue negative; it is in series with the spring.
   * Larger: the spring pulls the steps less. Zeros: all that moves is stepped. */
  double give[9];
} thrum_pull;

/* How a contact is made. Start from thrum_default_contact_def and change fields. The arrays are
 * only read while the contact is planned and made. */
typedef struct thrum_contact_def {
  /* Set by thrum_default_contact_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* vertex_count: 0-based vertices of the model that may touch; default NULL: all. */
  const int32_t *vertices;

  /* Number of `vertices`; 1 to 2^31, ignored without them. Larger: a finer contact surface, and
   * time and memory in proportion. */
  int64_t vertex_count;

  /* vertex_count: area of the surface that each vertex stands for [m^2]; finite and >= 0. Larger: a
   * stiffer contact at that vertex. Default NULL: equal shares of the surface of the vertices'
   * box. */
  const double *areas;

  /* Pressure per depth against obstacles without their own [N/m^3]; 0 to 1e30. Larger: the body
   * sinks in less. Default 0: ten times Young's modulus over the diagonal of the vertices' box, and
   * a thousand times that where a free body meets an obstacle with a restitution below 1
   * (docs/contact.md). */
  double stiffness;

  /* Diagonal of the body's box at rest [m]; finite and >= 0. Larger: pulls without a force_max are
   * stronger. Default 0: that of the model's vertices, for a model that has all of the body's. */
  double diagonal;

  /* Largest number of points that touch at once; 0 to 2^31. Larger: more memory, and fewer touches
   * are dropped. Default 0: twice the vertices. */
  int64_t touch_max;

  /* Largest number of pulls in a step; 0 to 2^31, default 1. Larger: more memory, and more pulls
   * are taken before the next is refused. */
  int64_t pull_max;

  /* Largest number of sweeps of the solver in one step; >= 1, default 20. Larger: more exact
   * forces where many stiff points touch, and a slower step there. */
  int32_t sweeps_max;

  /* Change of the displacement at which the solver ends, relative to the displacement of a step; in
   * (0, 1e-2], default 1e-4. Larger: fewer sweeps and less exact forces. */
  double tolerance;
} thrum_contact_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_contact_def_init(thrum_contact_def *def, size_t size);

/* The same as a value. */
static inline thrum_contact_def thrum_default_contact_def(void) {
  thrum_contact_def def;
  thrum_contact_def_init(&def, sizeof def);
  return def;
}

/* Opaque: lives at the start of the memory given to thrum_contact_init. */
typedef struct thrum_contact thrum_contact;

/* The surroundings of a body in one step; zero-initialise it and set what applies. The caller owns
 * everything that it points to; the step only reads it, but for translation and rigid_frame. */
typedef struct thrum_contact_environment {
  const thrum_placement *placement; /* NULL: where the mesh is */
  thrum_translation *translation;   /* moved by the step; NULL: the body is held */
  const thrum_obstacle *obstacles;  /* obstacle_count; may be NULL when that is 0 */
  int64_t obstacle_count;           /* >= 0; larger: a slower search for touches */
  const thrum_pull *pulls;          /* pull_count; may be NULL when that is 0 */
  int64_t pull_count;               /* 0 to the contact's pull_max; larger: a slower solve */
  const double *load; /* rank: mean of the other reduced loads over the step; NULL: 0 */
  double force[3];    /* other force on the translation, such as its weight [N]; larger: faster */
  thrum_rigid_frame *rigid_frame; /* rotated by the step; NULL: the body does not rotate */
  double torque[3]; /* other torque about the centre of mass [N m]; larger: faster rotation */
  const thrum_inertia *inertia; /* of a body whose rotation and shape are stepped together
                                   (thrum/floating_frame.h), with a settled rigid_frame; NULL: the
                                   two are apart */
  double *inertia_work; /* scratch that thrum_floating_frame_step needs; NULL without inertia */
} thrum_contact_environment;

/* Counters and energies of a contact since init or reset. The work that the obstacles did on the
 * body is
 *
 *   work on the body = driven + granted - stored - lost,    stored >= 0,
 *
 * and lost >= 0 after every thrum_contact_step up to rounding: obstacles at rest give back no more
 * than they took. With an inertia, what impacts change of the energy that holds the velocity of the
 * shape is in `lost` as well, and may be of either sign (docs/contact.md). */
typedef struct thrum_contact_report {
  int64_t steps;    /* completed steps */
  int64_t redone;   /* attempts after the first of thrum_contact_step */
  int64_t declined; /* steps made without contact, because no attempt kept the energy bound */
  int64_t dropped;  /* touches for which touch_max was too small */
  int64_t sweeps;   /* sweeps of the solver over all steps */
  int64_t impacts;  /* places at which impacts struck the body as a whole, over all steps */
  int32_t struck;   /* of those the ones of the last step, which are listed behind its touches */
  int32_t touching; /* touches of the last step */
  double depth;     /* largest depth after the last step [m] */
  double normal;    /* sum of the normal forces in the last step [N] */
  double stored;    /* energy in the contact springs now [J] */
  double lost;      /* energy lost to restitution, damping and friction, and that of vibration which
                       steps cannot follow [J] */
  double driven;    /* work of moving obstacles [J] */
  double granted;   /* energy of springs that a body began with inside an obstacle [J] */
  double pulled;    /* work of the pulls on the body [J] */
} thrum_contact_report;

/* One touch of the last step, or one place of an impact in it. */
typedef struct thrum_touch {
  int32_t vertex;    /* 0-based vertex of the model */
  int32_t obstacle;  /* 0-based place among the obstacles */
  double force[3];   /* on the body, mean over the step [N] */
  double normal[3];  /* unit vector away from the obstacle */
  double gap;        /* distance after the step [m], negative inside; of an impact 0 */
  double impulse[3]; /* of an impact on the body [N s]; its force is 0, and this that of a touch */
  double stiffness;  /* of its spring in the last step [N/m]; 0 of an impact */
} thrum_touch;

/* Bytes of a contact for this model and for states of the same size as `state`, into *size. Checks
 * the def: THRUM_UNINITIALISED_DEF, THRUM_INVALID_ARGUMENT or THRUM_BAD_VALUE with the field and
 * its range; THRUM_MISSING for a model without a basis, or without a material where the def leaves
 * the stiffness to it; THRUM_MODEL_MISMATCH for a state of another model. */
THRUM_API thrum_status thrum_contact_size(const thrum_model *model, const thrum_state *state,
                                          const thrum_contact_def *def, size_t *size,
                                          thrum_error *error);

/* Lays a contact that touches nothing into `memory`, aligned to 64 bytes and of at least
 * thrum_contact_size bytes. The caller owns the memory and frees it when done; *contact points into
 * it. THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, or the failures of thrum_contact_size. */
THRUM_API thrum_status thrum_contact_init(void *memory, size_t memory_size,
                                          const thrum_model *model, const thrum_state *state,
                                          const thrum_contact_def *def, thrum_contact **contact,
                                          thrum_error *error);

/* Bytes of a contact, those of thrum_contact_size; 0 for NULL. */
THRUM_API size_t thrum_contact_bytes(const thrum_contact *contact);

/* Would the thrum_contact_bytes bytes at `copy`, at any address, be a contact with the same points
 * when copied over `contact`? They are a copy between two steps, not one after thrum_contact_begin.
 * THRUM_MODEL_MISMATCH for another model, def or points, THRUM_BAD_VALUE for numbers that no
 * contact can have, THRUM_INVALID_ARGUMENT for NULL. It finds no changed bit of a number that
 * remains in its range: keep a checksum of the bytes. */
THRUM_API thrum_status thrum_contact_copy_check(const thrum_contact *contact, const void *copy,
                                                thrum_error *error);

/* Pressure per depth against obstacles without their own [N/m^3], as the def has it or by default
 * before it is made harder for a free body. */
THRUM_API double thrum_contact_stiffness(const thrum_contact *contact);

/* Predicts the step, solves for contact and pulls, and sets the state's force to the environment's
 * load and theirs. THRUM_INVALID_ARGUMENT for a contact that init did not make or an environment
 * that does not fit it, THRUM_MODEL_MISMATCH for a state of another model or size, THRUM_BAD_VALUE
 * for numbers that are not finite or out of their range, THRUM_UNSUPPORTED for an environment with
 * an inertia, which thrum_contact_step alone steps with. */
THRUM_API thrum_status thrum_contact_begin(const thrum_model *model, thrum_state *state,
                                           thrum_contact *contact,
                                           const thrum_contact_environment *environment,
                                           thrum_error *error);

/* Call after the state's step, with the environment of begin: adds up the energies of contact and
 * moves the translation and the rigid frame. THRUM_INVALID_ARGUMENT without a begin before it;
 * otherwise it fails as begin. */
THRUM_API thrum_status thrum_contact_end(const thrum_model *model, thrum_state *state,
                                         thrum_contact *contact,
                                         const thrum_contact_environment *environment,
                                         thrum_error *error);

/* Makes a whole step: begin, thrum_step, end. Where contact would give back more energy than it
 * took, the step is repeated from its start with a corrected prediction, then without restitution
 * and friction, at last without contact. A failure leaves state, contact, translation and rigid
 * frame as they were; statuses are those of thrum_step and of begin. */
THRUM_API thrum_status thrum_contact_step(const thrum_model *model, thrum_state *state,
                                          thrum_contact *contact,
                                          const thrum_contact_environment *environment,
                                          thrum_error *error);

/* Forgets touches, friction and energies, as after init; call it when a body was put elsewhere.
 * NULL does nothing. */
THRUM_API void thrum_contact_reset(thrum_contact *contact);

/* The report of a contact; all zero for NULL. */
THRUM_API thrum_contact_report thrum_contact_report_get(const thrum_contact *contact);

/* Touch `index` (0-based, below the report's touching) of the last step into *touch, behind them
 * the places of impacts (as many as the report's struck); THRUM_INVALID_ARGUMENT beyond the last.
 */
THRUM_API thrum_status thrum_contact_touch_get(thrum_contact *contact, int64_t index,
                                               thrum_touch *touch, thrum_error *error);

/* Force of pull `index` (0-based) on the body, mean over the last step [N], into `force`;
 * THRUM_INVALID_ARGUMENT beyond the last. */
THRUM_API thrum_status thrum_contact_pull_force(thrum_contact *contact, int64_t index,
                                                double force[3], thrum_error *error);

/* By how much the momentum of a mode is made smaller after a step of dt [s] in which a body rests
 * on an obstacle: 1 where steps follow it (docs/contact.md). omega2: its squared frequency [1/s^2].
 * Any thread. */
THRUM_API double thrum_contact_calm_factor(double dt, double omega2);

/* Moves a translation by one step of dt [s] under a mean force [N]; exact for a constant force. Any
 * thread. */
THRUM_API void thrum_translation_step(thrum_translation *translation, const double force[3],
                                      double dt);

/* Signed distance of the point x [m] from the obstacle [m], negative inside; for a room that of the
 * nearest wall. `normal` gets the unit vector along which the distance grows. Any thread. */
THRUM_API double thrum_obstacle_gap(const thrum_obstacle *obstacle, const double x[3],
                                    double normal[3]);

#ifdef __cplusplus
}
#endif
#endif
