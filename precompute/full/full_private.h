/* The full-order body's inside, shared by the files of full/. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_PRIVATE_H
#define THRUM_PRECOMPUTE_FULL_FULL_PRIVATE_H

#include "platform/allocate.h"
#include "precompute/full/full.h"
#include "precompute/full/full_linear_solve.h"
#include "precompute/model/model_fem.h"

/* Vectors of the free components. X(name, meaning) */
#define FULL_VECTORS(X)                                                                            \
  X(u) /* displacement */                                                                          \
  X(v) /* velocity */                                                                              \
  X(a) /* Newmark's acceleration; central's, without damping */                                    \
  X(f) /* load of the steps to come */                                                             \
  X(d) /* of a step: u' - u */                                                                     \
  X(v_next)                                                                                        \
  X(a_next)                                                                                        \
  X(r)       /* residual */                                                                        \
  X(delta)   /* correction */                                                                      \
  X(product) /* of a matrix */                                                                     \
  X(trial)                                                                                         \
  X(lumped) /* mass, central */

/* Fields of all components. */
#define FULL_FIELDS(X)                                                                             \
  X(held)     /* what held components are displaced by */                                          \
  X(place)    /* where forces are taken */                                                         \
  X(place_to) /* and the other end of a step */                                                    \
  X(forces)

struct thrum_full {
  thrum_scope memory; /* of all arrays below */
  thrum_full_def def;
  const thrum_model *model;
  thrum_model_fem body; /* stiffness: at rest; mass: the model's */
  thrum_fem four;       /* the elements with four points; empty without THRUM_FULL_FOUR */
  uint8_t *fixed;       /* vertex_count: held, the model's and others */

  /* Matrices on one pattern, and what solves with them. */
  double *acted;                          /* 6 vertex_count, where actuators act; else NULL */
  double *levels;                         /* of the actuators, as they were set; likewise */
  thrum_sparse tangent;                   /* values of its own on the pattern of the stiffness */
  thrum_sparse system;                    /* the same */
  int64_t *mass_slot;                     /* place of each entry of the mass in that pattern */
  full_linear linear;                     /* of the system */
  full_linear mass;                       /* of the mass, Newmark */
  double *plastic;                        /* points x 9: F_p^-1 - 1; NULL: nothing flows */
  double *plastic_kept;                   /* the same at the start of a step of several parts */
  double plastic_work, plastic_work_kept; /* [J], and the same */
  bool positive; /* the tangents of other laws are made positive semidefinite */

  /* The state of the run. */
  bool fresh; /* the load or the state was set: accelerations are to be taken anew */
  int64_t steps, iterations, substep_steps;
  double dt_stable;
#define X(name) double *name;
  FULL_VECTORS(X)
  FULL_FIELDS(X)
#undef X
};

/* The elements whose points the elastic forces are taken at. */
const thrum_fem *full_elastic(const thrum_full *full);

/* place = the field of u + share d (d NULL: of u), held components displaced. */
void full_place(const thrum_full *full, const double *u, double share, const double *d,
                double *place);

/* V, and r -= R of the place. */
double full_subtract_forces(thrum_full *full, const double *place, double *r);

/* system = of_tangent K(place) + of_mass M + of_damping C, C = alpha M + beta K at rest. */
thrum_status full_assemble(thrum_full *full, const double *place, double of_tangent, double of_mass,
                           double of_damping, thrum_error *error);

/* r -= scale M x, or scale C x. */
void full_subtract_mass(thrum_full *full, double scale, const double *x, double *r);
void full_subtract_damping(thrum_full *full, double scale, const double *x, double *r);

/* Loads that turn with their group, as a search uses them; a zeroed one is fine to free. */
typedef struct full_follower_solver {
  full_followers followers;
  int64_t count;  /* 3 follower_count, products in their derivative */
  double *memory; /* of the products and of the solver */
} full_follower_solver;

thrum_status full_follower_solver_make(thrum_full *full, const thrum_full_loading *loading,
                                       full_follower_solver *solver, thrum_error *error);
void full_follower_solver_free(full_follower_solver *solver);

/* full->delta = (K - factor times the derivative of the loads)^-1 full->r at full->place, with
 * full->tangent K there and factors of it, shifted or not, in full->linear. */
thrum_status full_follower_solve(thrum_full *full, const full_follower_solver *solver,
                                 double factor, thrum_error *error);

/* Memory for plastic flow, where the def has any. */
thrum_status full_plastic_make(thrum_full *full);

/* The flow of a time dt at the present displacement. */
void full_plastic_flow(thrum_full *full, double dt);

/* Keeps what has flowed, and goes back to that. */
void full_plastic_keep(thrum_full *full);
void full_plastic_return(thrum_full *full);

double full_dot(const thrum_full *full, const double *x, const double *y);

/* One step each, candidates into d (u' - u), v_next and a_next. */
thrum_status full_step_implicit(thrum_full *full, thrum_error *error);
thrum_status full_step_central(thrum_full *full, thrum_error *error);

/* central: lumped mass and the largest stable step at rest; refuses a dt beyond it. */
thrum_status full_central_begin(thrum_full *full, thrum_error *error);

#endif
