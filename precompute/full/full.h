/* The full-order body: the tetrahedral mesh of a model, unreduced (design 13). What a reduced model
 * is measured against, and the honest denominator of every speed-up.
 *
 * Same mesh, materials, held components and mass as the model; tetrahedra of Saint Venant-Kirchhoff
 * material or of another law, by the assembly of precompute. Fields are 3 vertex_count numbers, x,
 * y, z of each vertex, held ones included, unless said otherwise; SI units throughout. A body
 * belongs to one thread at a time. Calls may allocate.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_H
#define THRUM_PRECOMPUTE_FULL_FULL_H

#include <stdbool.h>

#include "precompute/fem/fem_inverted.h"
#include "precompute/full/full_loading.h"
#include "precompute/full/full_solver.h"
#include "runtime/material/material_law.h"
#include "runtime/material/plastic_flow.h"
#include "thrum/equilibrium.h"
#include "thrum/model.h"

typedef enum thrum_full_scheme {
  THRUM_FULL_NEWMARK = 0,  /* implicit, full Newton with kept factors */
  THRUM_FULL_ENERGY = 1,   /* conserves energy, momentum and angular momentum: Simo and Tarnow */
  THRUM_FULL_MIDPOINT = 2, /* implicit midpoint */
  THRUM_FULL_CENTRAL = 3   /* explicit central differences, lumped mass */
} thrum_full_scheme;

typedef struct thrum_full_def {
  uint32_t cookie;          /* set by thrum_default_full_def */
  thrum_full_scheme scheme; /* default energy */

  /* Time step [s]; > 0, default 0.003. Larger: fewer and less accurate steps, and more iterations
   * in each. */
  double dt;

  /* C = alpha M + beta K at rest; >= 0 [1/s], [s], default 0; central takes no beta. Larger: motion
   * decays faster, by beta the fast modes above all. */
  double damping_alpha, damping_beta;

  /* Newmark's; beta > 0, default 1/4, gamma in [0, 1], default 1/2. Larger beta: stable at larger
   * steps and less accurate. Larger gamma: numerical damping, and order 1. */
  double newmark_beta, newmark_gamma;

  /* Residual at which a step or an equilibrium is found, relative; > 0, default 1e-10. Larger:
   * fewer iterations, and each step errs by about it. */
  double tolerance;

  /* Iterations of a step; >= 1, default 50. Larger: shorter steps stand in later. */
  int32_t iterations_max;

  thrum_full_solver solver; /* default Cholesky */
  const thrum_full_shared
      *shared; /* processes that share its factor; default NULL: this one alone */

  /* Points at which the elastic forces of ten-node tetrahedra are taken; default exact. Four are
   * cheaper, and stiffness at large strains is then not exact; masses always are. */
  thrum_full_quadrature quadrature;

  /* The law of the material in all of the body, or THRUM_LAW_BY_REGION: the model's laws of its
   * regions, with their yields; default Saint Venant-Kirchhoff. The moduli are the model's, as of
   * small strains. */
  thrum_law law;

  /* Plastic flow, in steps alone: equilibria keep what has flowed. Default none: the yield, the
   * creep and the largest strain are infinite. By region, the yield is that of regions that have
   * none of their own, and Saint Venant-Kirchhoff material does not flow. */
  thrum_plastic plastic;

  /* Residual at which conjugate gradients end, relative; > 0, default 1e-10. Larger: fewer of their
   * iterations, and more of Newton's. */
  double solver_tolerance;
} thrum_full_def;

thrum_full_def thrum_default_full_def(void);

typedef struct thrum_full thrum_full;

/* Counts what a body has done since it was made. */
typedef struct thrum_full_report {
  int64_t free_count;        /* components that move */
  int64_t steps;             /* completed */
  int64_t substep_steps;     /* solved by shorter ones */
  int64_t iterations;        /* Newton's */
  int64_t factorisations;    /* of Cholesky */
  int64_t solver_iterations; /* of conjugate gradients */
  double dt_stable;          /* central: largest stable step at rest [s]; else NaN */
  double plastic_work;       /* that plastic flow took from the strain energy [J] */
} thrum_full_report;

typedef struct thrum_full_energies {
  double kinetic, potential, total; /* [J] */
} thrum_full_energies;

typedef struct thrum_full_equilibrium {
  int32_t load_steps, cut_steps, iterations;
  double energy;      /* V(u) [J] */
  double load_energy; /* -f u [J] */
  double residual;    /* of the forces, relative to the largest on the way, in the energy norm */
  int32_t stable;     /* 1: the tangent stiffness is positive definite */

  /* What a loading with `watch` tells of the branch. Eigenvalues are those of K x = lambda M x with
   * the tangent K [1/s^2]: squared frequencies of small vibrations. */
  double least;                      /* least one of the answer; NaN: not looked at */
  double least_start;                /* and where the path starts */
  double softest, softest_factor;    /* the least of the way, and the factor of the load there */
  thrum_instability instability;     /* how the branch lost its stability first */
  double critical;                   /* factor of the load there; NaN: it did not */
  double critical_from, critical_to; /* factors that enclose it */
  double critical_least;             /* least eigenvalue at the former, the last stable one */
  int32_t jumps;                     /* falls to another branch */
  bool lost;                         /* the branch could not be followed beyond lost_at, and */
  double lost_at;                    /* what was found may be of another one */
} thrum_full_equilibrium;

/* Makes the body of a model, at rest. `held` (vertex_count, may be NULL): bits 0, 1, 2 of x, y, z
 * held beside those of the model. The model must stay. THRUM_MISSING without a mesh;
 * THRUM_INVALID_ARGUMENT when central's dt is not stable: the line names one that is. */
thrum_status thrum_full_create(const thrum_model *model, const uint8_t *held,
                               const thrum_full_def *def, thrum_full **full, thrum_error *error);
void thrum_full_free(thrum_full *full); /* NULL is fine */

/* Displacements [m] and velocities [m/s]; NULL means zero, and not wanted. Held components of set
 * are taken as zero. What has flowed stays. */
thrum_status thrum_full_set(thrum_full *full, const double *u, const double *v, thrum_error *error);
/* The same for displacements of held components too, at rest. */
thrum_status thrum_full_displace(thrum_full *full, const double *u, thrum_error *error);
void thrum_full_get(const thrum_full *full, double *u, double *v);

/* Forces [N] of the steps to come: their mean over a step, as of thrum_state_set_force. */
thrum_status thrum_full_set_force(thrum_full *full, const double *forces, thrum_error *error);

/* Levels of the model's actuators in the steps and equilibria to come, one for each (thrum/
 * actuation.h); NULL: zero. THRUM_UNSUPPORTED where it has none. */
thrum_status thrum_full_set_actuation(thrum_full *full, const double *levels, thrum_error *error);

/* What the actuators under their levels add to the energy where the body is [J]; 0 without any.
 * What it falls by in a step is their work. */
double thrum_full_acting_energy(thrum_full *full);

/* One step. THRUM_NOT_CONVERGED and THRUM_NOT_FINITE leave the body as it was. */
thrum_status thrum_full_step(thrum_full *full, thrum_error *error);

/* The equilibrium under `forces`, from where the body is: Newton on the total energy with a line
 * search, the load growing in steps. moves (may be NULL): displacements [m] that held components
 * are brought to along the way. The body is then there, at rest. On failure it is as it was. */
thrum_status thrum_full_rest(thrum_full *full, const double *forces, const double *moves,
                             thrum_full_equilibrium *found, thrum_error *error);

/* The same under a loading. Where the body is displaced at the start, the path begins at the forces
 * and the places that hold it there, and goes from them to the loading: an answer is continued.
 * With followers the way down is Newton's alone, load_energy is NaN, and `stable` speaks of the
 * body's tangent without the loads. THRUM_INVALID_ARGUMENT for followers whose vertices lie on a
 * line. THRUM_NOT_CONVERGED where no equilibrium was found: *found says then how the branch lost
 * its stability, and nothing else. */
thrum_status thrum_full_rest_under(thrum_full *full, const thrum_full_loading *loading,
                                   thrum_full_equilibrium *found, thrum_error *error);

/* The lowest energy of body and load [J] that searches from other places find: from the present
 * displacement, an equilibrium, kicked along each of the fields `kicks` (kick_count x 3
 * vertex_count, [m]) both ways. Infinity: none ended. The body stays as it is. Not with followers.
 */
thrum_status thrum_full_lower(thrum_full *full, const thrum_full_loading *loading,
                              const double *kicks, int64_t kick_count, double *lower,
                              thrum_error *error);

/* At most `most` >= 1 corrections of Newton from the present displacement towards an equilibrium
 * under `forces`, each downhill in the energy: *ended where they came to one. The body stays where
 * they lead. Of *found the iterations, the energies, the residual and `stable` are filled. A matrix
 * that cannot be solved ends them without an error. */
thrum_status thrum_full_correct(thrum_full *full, const double *forces, int32_t most,
                                thrum_full_equilibrium *found, bool *ended, thrum_error *error);

/* R(u) at the present displacement on all components, held ones included (3 vertex_count) [N]: what
 * the elements ask of the loads and of what holds the body. Of all vertices their sum, and that of
 * their moments about where the vertices are, is zero. What actuators push and pull is no part of
 * it, and is added to `loads` (NULL: not wanted). */
void thrum_full_internal_forces(thrum_full *full, double *forces, double *loads);

/* Which tetrahedra are turned inside out at the present displacement. */
thrum_fem_inversion thrum_full_inverted(thrum_full *full);

/* The least principal stretch of all points of quadrature, or of those whose law gives way under
 * compression; negative: one is turned inside out. Infinite where there is none. */
double thrum_full_least_stretch(const thrum_full *full, bool gives_way);

thrum_full_energies thrum_full_energy(const thrum_full *full);
thrum_full_report thrum_full_report_get(const thrum_full *full);

/* The body as if nothing had flowed: no plastic strain and no plastic work. Displacement, velocity
 * and load stay; the strain energy is that of an elastic body there. */
void thrum_full_clear_plastic(thrum_full *full);

/* The largest plastic strain of all points, as thrum_plastic_strain; 0 where nothing flows. */
double thrum_full_plastic_strain(const thrum_full *full);

/* Keeps a running peak: where a vertex is displaced further than *length [m], *length becomes the
 * largest displacement and *vertex (0-based) the vertex. */
void thrum_full_peak(const thrum_full *full, double *length, int64_t *vertex);

/* Mean displacement [m] of `count` > 0 vertices (NULL: all of them), all within the mesh. */
void thrum_full_mean(const thrum_full *full, const int32_t *vertices, int64_t count,
                     double mean[3]);

/* Linear and angular momentum (about the origin) [kg m/s, kg m^2/s]. */
void thrum_full_momentum(const thrum_full *full, double linear[3], double angular[3]);

/* forces += M a of an acceleration [m/s^2] that all of the body feels. */
void thrum_full_add_gravity(const thrum_full *full, const double acceleration[3], double *forces);

/* reduced = U^T M field: the coordinates that come nearest to a field in the norm of M (rank). The
 * model must have a basis. */
void thrum_full_project(const thrum_full *full, const double *field, double *reduced);

#endif
