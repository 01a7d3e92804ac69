/* What a body touches and what pulls it, as a mean load of each step (docs/contact.md).
 *
 * Chosen vertices of a body meet planes, spheres and boxes: a penalty spring that pushes and never
 * pulls, with restitution, damping and Coulomb friction. Springs with damping pull points of the
 * body to where somebody drags them. All of it is solved implicitly at the end of the step in
 * reduced coordinates and handed to the integrator as its mean load, whichever integrator it is;
 * no stiffness is too large for dt. What contact gives back it took before: see
 * thrum_contact_report. A body that nothing holds may move as a whole (thrum_translation,
 * thrum_rigid_frame).
 *
 *   thrum_contact_step(model, state, contact, &environment, &error);   in place of thrum_step
 *
 * or thrum_contact_begin, thrum_step or thrum_batch_step, thrum_contact_end, without the second
 * attempts of thrum_contact_step.
 *
 * A contact is planned (thrum_contact_size), then laid into the caller's memory
 * (thrum_contact_init). It holds no pointer, so a snapshot is memcpy of thrum_contact_bytes bytes;
 * take it together with that of its state. It belongs to one thread at a time. No function here
 * allocates, prints or keeps a global. SI units; world coordinates unless a field says otherwise.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONTACT_H
#define THRUM_CONTACT_H

#include "thrum/api.h"
#include "thrum/rigid_frame.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Stiffnesses and dampings above this are refused [N/m^3, N/m, and so on]. */
#define THRUM_CONTACT_STIFFNESS_MAX 1e30

/* How far a body that nothing holds has moved as a whole, besides its placement. */
typedef struct thrum_translation {
  double mass;        /* [kg], > 0 */
  double position[3]; /* [m] */
  double velocity[3]; /* [m/s] */
} thrum_translation;

typedef enum thrum_obstacle_shape {
  THRUM_OBSTACLE_PLANE = 0,
  THRUM_OBSTACLE_SPHERE = 1,
  THRUM_OBSTACLE_BOX = 2
} thrum_obstacle_shape;

/* Something in the way. The one definition is passed in every step and may change between steps. */
typedef struct thrum_obstacle {
  uint32_t cookie;            /* set by thrum_default_obstacle */
  thrum_obstacle_shape shape; /* default plane */
  int32_t inside;     /* sphere and box: 1: the inside is free, a bowl or a room; default 0 */
  double centre[3];   /* of sphere and box; a point of the plane [m]; default 0 */
  double normal[3];   /* of the plane, to its free side, any length > 0; default z */
  double radius;      /* of the sphere [m], > 0 */
  double half[3];     /* half sides of the box [m], > 0 */
  double rotation[9]; /* of the box, 3 x 3 row-major: its axes are the columns */
  double velocity[3]; /* of the obstacle during the step [m/s]; the caller moves its centre */
  double stiffness;   /* pressure per depth [N/m^3]; 0: the contact's; default 0 */
  double damping;     /* pressure per speed of depth [N s/m^3], >= 0; default 0 */
  double restitution; /* speed away over speed towards, in [0, 1]; default 0.5 */
  double friction;    /* Coulomb's coefficient, >= 0; default 0.5 */
} thrum_obstacle;

/* An obstacle with every default set: the plane z = 0. */
THRUM_API thrum_obstacle thrum_default_obstacle(void);

/* Says what is wrong with an obstacle, under its place `index` in a list. thrum_contact_begin and
 * _step check each of theirs so. */
THRUM_API thrum_status thrum_obstacle_check(const thrum_obstacle *obstacle, int64_t index,
                                            thrum_error *error);

/* A spring from a point of the body to a target. The point is the mean of three vertices with
 * weights, such as a point of a triangle; equal vertices are fine. */
typedef struct thrum_pull {
  int32_t vertices[3]; /* 0-based vertices of the model */
  double weights[3];   /* that sum to 1 */
  double target[3];    /* at the start of the step [m] */
  double velocity[3];  /* of the target during the step [m/s] */
  double stiffness;    /* [N/m], >= 0 */
  double damping;      /* [N s/m], >= 0; negative: critical for what the point feels of the mass */
  double force_max;    /* [N], the pull is no stronger; 0: what would displace the point by the
                          diagonal of the body's box at rest, and twice the force on the translation */
} thrum_pull;

typedef struct thrum_contact_def {
  uint32_t cookie;         /* set by thrum_default_contact_def */
  const int32_t *vertices; /* 0-based vertices that may touch; NULL: all; copied */
  int64_t vertex_count;    /* of `vertices` */
  const double *areas;     /* vertex_count, what each stands for [m^2]; NULL: equal shares of the
                              surface of the vertices' box; copied */
  double stiffness;        /* pressure per depth [N/m^3]; 0: ten times Young's modulus over the
                              diagonal of the vertices' box; default 0 */
  int64_t touch_max;       /* points that may touch at once; 0: twice the vertices; default 0 */
  int64_t pull_max;        /* pulls of a step; default 1 */
  int32_t sweeps_max;      /* of the solver in one step, >= 1; default 20 */
  double tolerance;        /* of the solver, relative to the displacement of a step, in (0, 1e-2];
                              default 1e-4 */
} thrum_contact_def;

THRUM_API thrum_contact_def thrum_default_contact_def(void);

/* Opaque: lives at the start of the memory given to thrum_contact_init. */
typedef struct thrum_contact thrum_contact;

/* What is around a body in one step. Only read, but for the translation and the turning. */
typedef struct thrum_contact_environment {
  const thrum_placement *placement; /* NULL: where the mesh is */
  thrum_translation *translation;   /* NULL: the body is held; moved by the step */
  const thrum_obstacle *obstacles;  /* obstacle_count; may be NULL when that is 0 */
  int64_t obstacle_count;
  const thrum_pull *pulls; /* pull_count, at most pull_max */
  int64_t pull_count;
  const double *load;             /* rank, mean reduced load of the step besides; NULL: none */
  double force[3];                /* on the translation besides, such as its weight [N] */
  thrum_rigid_frame *rigid_frame; /* NULL: the body does not turn; turned by the step */
  double torque[3];               /* on the turning besides, about its centre [N m] */
} thrum_contact_environment;

/* The energy of contact and what it did, since init. Of what the obstacles did to the body,
 *
 *   work on the body = driven + granted - stored - lost,    stored >= 0,
 *
 * and lost >= 0 after every thrum_contact_step up to rounding: obstacles that stand still give back
 * no more than they took. */
typedef struct thrum_contact_report {
  int64_t steps;
  int64_t redone;   /* attempts after the first of thrum_contact_step */
  int64_t declined; /* steps in which contact was let go, because none of them kept the bound */
  int64_t dropped;  /* touches for which touch_max was too small */
  int64_t sweeps;   /* of the solver */
  int32_t touching; /* points with a force in the last step */
  double depth;     /* the deepest after the last step [m] */
  double normal;    /* sum of the normal forces in the last step [N] */
  double stored;    /* in the springs now [J] */
  double lost;      /* to restitution, damping and friction [J] */
  double driven;    /* work of obstacles that move [J] */
  double granted;   /* in springs of a body that began inside an obstacle [J] */
  double pulled;    /* work of the pulls on the body [J] */
} thrum_contact_report;

/* One touch of the last step. */
typedef struct thrum_touch {
  int32_t vertex;   /* of the model */
  int32_t obstacle; /* its place among the obstacles */
  double force[3];  /* mean over the step, on the body [N] */
  double normal[3]; /* unit, away from the obstacle */
  double gap;       /* after the step [m], negative inside */
} thrum_touch;

/* Bytes of a contact for this model and states made like `state`. Needs a model with a basis
 * (THRUM_MISSING otherwise). Checks the def and says what is wrong with it. */
THRUM_API thrum_status thrum_contact_size(const thrum_model *model, const thrum_state *state,
                                          const thrum_contact_def *def, size_t *size,
                                          thrum_error *error);

/* Lays a contact that touches nothing into `memory`, aligned to 64, which the caller owns. */
THRUM_API thrum_status thrum_contact_init(void *memory, size_t memory_size,
                                          const thrum_model *model, const thrum_state *state,
                                          const thrum_contact_def *def, thrum_contact **contact,
                                          thrum_error *error);

THRUM_API size_t thrum_contact_bytes(const thrum_contact *contact);

/* Pressure per depth that obstacles without their own get [N/m^3]. */
THRUM_API double thrum_contact_stiffness(const thrum_contact *contact);

/* Predicts the step, solves for contact and pulls, and sets the state's force to load and those. */
THRUM_API thrum_status thrum_contact_begin(const thrum_model *model, thrum_state *state,
                                           thrum_contact *contact,
                                           const thrum_contact_environment *environment,
                                           thrum_error *error);

/* After the state's step: moves the translation and keeps the account. `environment` as in begin.
 */
THRUM_API thrum_status thrum_contact_end(const thrum_model *model, thrum_state *state,
                                         thrum_contact *contact,
                                         const thrum_contact_environment *environment,
                                         thrum_error *error);

/* begin, thrum_step, end; a step in which contact gave more than it had is made again with what
 * the attempt taught, at last without contact. A failure leaves state, contact and translation as
 * they were; statuses are those of thrum_step and of begin. */
THRUM_API thrum_status thrum_contact_step(const thrum_model *model, thrum_state *state,
                                          thrum_contact *contact,
                                          const thrum_contact_environment *environment,
                                          thrum_error *error);

/* Forgets touches, friction and accounts, as after init: for a body put elsewhere. */
THRUM_API void thrum_contact_reset(thrum_contact *contact);

THRUM_API thrum_contact_report thrum_contact_report_get(const thrum_contact *contact);

/* Touch `index` of the last step, 0-based; THRUM_INVALID_ARGUMENT beyond the last. */
THRUM_API thrum_status thrum_contact_touch(thrum_contact *contact, int64_t index,
                                           thrum_touch *touch, thrum_error *error);

/* Mean force of pull `index` in the last step, on the body [N]. */
THRUM_API thrum_status thrum_contact_pull_force(thrum_contact *contact, int64_t index,
                                                double force[3], thrum_error *error);

/* Moves by one step under a mean force: exact for a constant one. */
THRUM_API void thrum_translation_step(thrum_translation *translation, const double force[3],
                                      double dt);

/* Signed distance of x from the obstacle [m], negative inside; `normal` gets the way out. For a
 * room the nearest wall. */
THRUM_API double thrum_obstacle_gap(const thrum_obstacle *obstacle, const double x[3],
                                    double normal[3]);

#ifdef __cplusplus
}
#endif
#endif
