/* A contact in memory and a step of it in the making, private to the runtime: one header, then
 * arrays at offsets that follow from the sizes in the header; no pointer is stored
 * (thrum/contact.h, docs/contact.md).
 *
 * What persists from step to step are the touches and the forces of the pulls; rows and vectors are
 * made anew by thrum_contact_begin and read by thrum_contact_end.
 *
 * A step goes through these files in this order: contact_check.c, contact_predict.c,
 * contact_pull.c, contact_rows.c, contact_guess.c, contact_solve.c and contact_pairs_solve.c
 * (thrum_contact_begin), then contact_energy.c (thrum_contact_end). contact_point.h has the
 * kinematics of one point, contact_row.h what one row does, contact_law.h its forces,
 * obstacle_private.h the shapes. Impacts of near-rigid bodies change their ways before a step is
 * solved (contact_impact.c).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PRIVATE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PRIVATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/base/vec3.h"
#include "thrum/contact.h"

#define THRUM_TOLERANCE_MOST 1e-2          /* that a definition may ask for */
#define THRUM_COUNT_MAX (INT64_C(1) << 62) /* of a snapshot: counting on cannot overflow */

struct thrum_contact {
  uint64_t magic;
  uint64_t bytes;       /* size of the whole block */
  uint64_t state_bytes; /* what a snapshot of the state holds */
  int64_t point_count;
  int64_t touch_max;
  int64_t pull_max;
  int64_t touch_count; /* of the last step */
  int64_t row_count;   /* of the step that has begun */
  int64_t pull_count;  /* of the step that has begun */
  double tolerance;    /* of the def */
  double stiffness;    /* of obstacles without their own [N/m^3] */
  double middle[3];    /* of the points' box, in the mesh [m] */
  double radius;       /* of the points about it [m] */
  double diagonal;     /* of the box of all vertices [m] */
  double flow;         /* forces times the free displacements of their points, summed [J] */
  double stored, lost, driven, granted, pulled;     /* report [J] */
  double depth, normal;                             /* report */
  int64_t steps, redone, declined, dropped, sweeps; /* report */
  int64_t impacts, struck;     /* the latter at the end of the touches, backwards */
  double moved[3], force[3];   /* of the translation in the step that has begun [m], [N] */
  double turned[3], torque[3]; /* of the rotation [rad], [N m] */
  double pressed[3];           /* force of contact and links in the last step [N], */
  double whirled[3];           /* and their torque about the centre of mass [N m] */
  int32_t rank;
  int32_t sweeps_max;
  int32_t fresh;   /* 1: no step yet, so what overlaps began so */
  int32_t begun;   /* 1: between begin and end */
  int32_t springy; /* 1: the def asked for a stiffness, so impacts are those of its springs */
  double impact;   /* lost to impacts of the body as a whole [J] */
  double owed;     /* of touches that take no energy: it goes back in the next one [J] */
};

/* History of a touch between a point and an obstacle (or one wall of a room). */
typedef struct thrum_touching {
  int32_t point, obstacle, face;
  int32_t towards; /* 1: the point was last seen moving towards the obstacle */
  double normal[3];
  double force;       /* along the normal [N] */
  double friction[3]; /* [N] */
  double approach;    /* speed towards the obstacle of the last approach [m/s] */
  double stored;      /* what the spring took and has not given back [J] */
  double gap;         /* after the step [m] */
} thrum_touching;

/* The part of a row in an impact of bodies as a whole (contact_impact.c). */
typedef enum thrum_strike_part {
  THRUM_NO_PART = 0,
  THRUM_STRIKES = 1, /* its places strike each other */
  THRUM_BEARS = 2    /* they touched before, and may not give way */
} thrum_strike_part;

typedef struct thrum_row_strike {
  thrum_strike_part part;
  double impulse[3]; /* on the first place [N s] */
  double before[3];  /* velocity of the first place against the second before it [m/s] */
  double away;       /* speed along the normal that is asked for after it [m/s] */
  double friction;
  double along,
      across; /* velocity under a unit impulse: along the normal, bound across it [1/kg] */

  /* A solve of all rows at once has these (contact_impact_newton.c). */
  double force, tangential[3]; /* along the normal and across it, that the row goes on from [N s] */
  double most;                 /* bound of the latter [N s] */
  double at[3], way[3];        /* velocity, and what a step of the solve adds to it [m/s] */
} thrum_row_strike;

/* A body as a whole in the impacts of a step. */
typedef struct thrum_impact_body {
  bool taken;                  /* by the impact that is being made */
  bool struck;                 /* by an impact of this step: it starts on another way */
  double axes[9], origin[3];   /* where it really is at the start of the step, if struck */
  double moved, turned;        /* bounds of how far from there its new way starts [m], [rad] */
  double limit;                /* square of the speed up to which it is near-rigid [m^2/s^2] */
  double inverse_mass;         /* [1/kg] */
  double inverse[9];           /* of the inertia, in the world [1/(kg m^2)] */
  double velocity[3];          /* of the centre of mass before the impact [m/s] */
  double spin[3];              /* [rad/s] */
  double passed[3];            /* way of the centre from the start of the step to the impact [m] */
  double gyration;             /* the energy gyration_of() before the impact [J] */
  double impulse[3], whirl[3]; /* on the centre, and about it [N s], [N m s] */
  int64_t column;              /* of its six in a solve of all rows at once; below 0: it has none */
  double root[9];              /* of its inverse inertia there */
} thrum_impact_body;

/* A touch in a step. Gaps are linear in the point's displacement dx over the step:
 * gap' = gap + normal (dx - drift). */
typedef struct thrum_contact_row {
  thrum_touching touch;
  double lever[3];    /* of the point about the centre of mass, about halfway [m] */
  double gap;         /* at the start [m] */
  double drift[3];    /* of the obstacle over the step [m] */
  double response[9]; /* G: displacement at the end of the step under a mean force [m/N] */
  double along;       /* n G n */
  double across;      /* bound of G on the tangent plane */

  /* Its law: a spring and a damper along the normal, friction across it. */
  double stiffness; /* k [N/m] */
  double damping;   /* c/h [N/m] */
  double restitution, friction;

  /* The step has found this of it so far. */
  double speed;           /* along the normal at the start, relative to the obstacle [m/s] */
  double gained;          /* change of it towards the obstacle in the step without contact [m/s] */
  double unloaded_length; /* length of the displacement without contact and pulls [m] */
  double ceiling;         /* the spring pushes only while gap' is below [m] */
  double slide[3];        /* tangential displacement that friction aims at: 0 to this [m] */
  double seen[3];         /* displacement of the point when its row was last solved [m] */
  double work, rubbed, driven; /* of the step made: on the body, and of the moving obstacle [J] */
  thrum_row_strike strike;
} thrum_contact_row;

/* A pull in a step. */
typedef struct thrum_pull_row {
  double force[3];    /* [N] */
  double lever[3];    /* as in a row [m] */
  double offset[3];   /* point less target at the start [m] */
  double velocity[3]; /* of the point less that of the target [m/s] */
  double drift[3];    /* of the target [m] */
  double response[9]; /* G */
  double rate;        /* K: force per displacement [N/m] */
  double bias[3];     /* force without displacement [N] */
  double series[9];   /* 1 + k C with what is not stepped [1] */
  double most;        /* force is no larger [N] */
  double seen[3];     /* as in a row [m] */
} thrum_pull_row;

/* X(type, name, count) */
#define THRUM_CONTACT_ARRAYS(X)                                                                    \
  X(int32_t, vertices, point_count)     /* of the model */                                         \
  X(double, areas, point_count)         /* [m^2] */                                                \
  X(double, extents, rank)              /* largest displacement of a point under a unit of q */    \
  X(thrum_touching, touches, touch_max) /* of the last step, by point, obstacle and face */        \
  X(thrum_contact_row, rows, touch_max) /* in the same order */                                    \
  X(double, pull_forces, pull_max * 3)  /* of the last step */                                     \
  X(double, pressing, rank)             /* load of contact and links in it */                      \
  X(thrum_pull_row, pull_rows, pull_max)                                                           \
  X(double, q, rank) /* at the start of the step */                                                \
  X(double, p, rank)                                                                               \
  X(double, weights, rank)  /* displacement over the step under a unit mean load [s^2] */          \
  X(double, unloaded, rank) /* displacement over the step without contact and pulls */             \
  X(double, moved, rank)    /* displacement over the step as predicted with them */                \
  X(double, load, rank)     /* mean load of the step with them */                                  \
  X(double, sought, rank)   /* displacement over the step that a search goes by */                 \
  X(double, pulled, pull_max * 3 * rank) /* rows of U of the points of the pulls */                \
  X(double, made, rank)                  /* displacement over the step as it was made */           \
  X(unsigned char, snapshot, state_bytes)

typedef struct thrum_contact_view {
#define X(type, name, count) type *name;
  THRUM_CONTACT_ARRAYS(X)
#undef X
} thrum_contact_view;

/* A step in the making. */
typedef struct thrum_contact_run {
  const thrum_model *model;
  thrum_state *state;
  thrum_contact *contact;
  const thrum_contact_environment *environment;
  thrum_contact_view view;
  double dt;
  bool linked;               /* to another body or to the world */
  bool foresees;             /* a search goes by other displacements than those without contact */
  bool all;                  /* no point waits without a row */
  int64_t waiting;           /* points that do, as rows from the end on (contact_rows.c) */
  double axes[9], origin[3]; /* of the placement, the translation included in the origin */
  double settling;           /* 1 / omega_1 of the body, 0 for what has no shape [s] */
  double mass_weight;        /* h^2/2 over the mass, 0 for a body that is held [m/N] */
  double unloaded[3];        /* displacement of the translation without contact and pulls [m] */
  double moved[3];           /* with them */
  double force[3];           /* on the translation, with them [N] */
  double centre[3];          /* of mass, in the world; lever arms are from here [m] */
  double turn_weight[9]; /* h^2/2 times the inverse of the inertia, 0 for one that does not turn */
  double spin[3];        /* angular velocity at the start [rad/s] */
  double unloaded_turn[3], turned[3]; /* angle over the step, as unloaded and moved [rad] */
  double turn_matrix[9];     /* displaces a point at an arm as turned does; as it is looked at */
  double sought[3];          /* as moved, that a search goes by [m], */
  double sought_turn[3];     /* and as turned [rad] */
  double foreseen[3];        /* turned as the solve had it, where turned is what the torque makes */
  thrum_rigid_frame stepped; /* with an inertia: the frame after the state's step */
  double torque[3];          /* as force [N m] */
  thrum_impact_body impact;
} thrum_contact_run;

/* contact.c: refuses NULL, memory that is no contact, and a model or state of another rank. */
thrum_status thrum_contact_check(const thrum_model *model, const thrum_state *state,
                                 const thrum_contact *contact, thrum_error *error);

/* contact.c: pointers into the block. */
thrum_contact_view thrum_contact_view_of(thrum_contact *contact);

/* Impact n of the step, whose force and friction are impulses [N s]. Impacts lie behind the touches
 * of the last step, which begin at the other end, as far as these leave room. */
static inline thrum_touching *thrum_contact_impact_at(const thrum_contact *contact,
                                                      const thrum_contact_view *view, int64_t n) {
  return view->touches + (contact->touch_max - 1 - n);
}

/* The motion of a body as a whole as its step began, which impacts of the step change. */
typedef struct thrum_contact_whole {
  thrum_translation way;
  thrum_rigid_frame frame;
} thrum_contact_whole;

#endif
