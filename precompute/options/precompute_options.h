/* A precompute is asked for by these: its stages and its options. Lowest header of precompute.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_OPTIONS_PRECOMPUTE_OPTIONS_H
#define THRUM_PRECOMPUTE_OPTIONS_PRECOMPUTE_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "runtime/material/material_law.h"

typedef enum thrum_mass { THRUM_MASS_CONSISTENT = 0, THRUM_MASS_LUMPED = 1 } thrum_mass;

/* How to check that no linear mode was missed: a fresh search of the complement, which also
 * recovers what was missed; after it, an exact count by MUMPS, which takes about as long as the
 * factor and is not built in everywhere. AUTO counts where it can up to 30,000 free components. */
typedef enum thrum_check { THRUM_CHECK_AUTO, THRUM_CHECK_SEARCH, THRUM_CHECK_INERTIA } thrum_check;

/* How K x = f is solved: by a factor, or by conjugate gradients with algebraic multigrid, which
 * take less memory and are there where processes share the work (mpi/README.md). AUTO is a factor
 * where it fits into memory, and always one without such processes. */
typedef enum thrum_solver { THRUM_SOLVER_AUTO, THRUM_SOLVER_FACTOR, THRUM_SOLVER_CG } thrum_solver;

/* How modes and derivatives are chosen: all modes, and the directions of what derivatives show
 * beside them that have most strain energy; or by one analysis of both in the norm of the mass,
 * which may leave modes out, as the thesis has it. */
typedef enum thrum_selection { THRUM_SELECTION_MODES, THRUM_SELECTION_MASS } thrum_selection;

/* The stages, in order; they do not overlap. X(name, text) */
#define THRUM_STAGE_LIST(X)                                                                        \
  X(assemble, "stiffness and mass")                                                                \
  X(factor, "stiffness solver")                                                                    \
  X(modes, "linear modes")                                                                         \
  X(derivatives, "modal derivatives")                                                              \
  X(basis, "basis")                                                                                \
  X(polynomial, "reduced polynomial")

typedef enum thrum_stage {
#define X(name, text) THRUM_STAGE_##name,
  THRUM_STAGE_LIST(X)
#undef X
      THRUM_STAGE_COUNT
} thrum_stage;

/* A place where a user will pull: a group of vertices that share a force evenly, or one vertex. */
typedef struct thrum_handle {
  const char *name;
  int64_t count;
  const int32_t *vertices; /* count, 0-based; NULL: the one `vertex` */
  int32_t vertex;
} thrum_handle;

/* A basis made elsewhere, of any independent columns, and its polynomial where that is known. */
typedef struct thrum_imported_basis {
  int64_t rows, rank; /* rows: 3 per vertex of the mesh's file */
  double *basis;      /* rows x rank, row-major */
  double *linear;     /* rank x rank, of V = 1/2 q^T linear q + ...; NULL: no polynomial */
  double *c3, *c4;    /* block order of thrum/model.h */
  double defect;      /* by how much its force was no gradient */
} thrum_imported_basis;

/* Says what became of it. */
typedef struct thrum_imported_figures {
  bool changed;                /* it was not in Thrum's form: its basis was changed */
  double orthonormality;       /* max |U^T M U - 1| in the file, */
  double orthonormality_after; /* and after the change of basis */
  double defect;               /* of the polynomial's force, see thrum_imported_basis */
  double linear_difference;    /* of the linear part from U^T K U, relative */
  double energy_difference;    /* of V from the body's at large displacements, relative */
} thrum_imported_figures;

typedef struct thrum_precompute_options {
  /* k linear modes; >= 1, default 10. Larger: the basis follows faster and more local motion, and
   * modes, derivatives and their memory grow with it, the derivatives with its square. */
  int64_t modes;

  /* r, reduced coordinates: the modes, and directions of their derivatives; up to k (k + 3) / 2,
   * default 0, which stands for thrum_options_usual_rank: 30 for 10 modes. Larger: a more accurate
   * model, whose coefficients and steps grow with about the fourth power. */
  int64_t rank;

  thrum_selection selection; /* default THRUM_SELECTION_MODES */

  /* The model will be condensed to its linear modes: of its polynomial only the monomials of these,
   * and those of two of them and another coordinate, are made, so that it cannot be stepped whole.
   * Without effect on an imported basis; default false. */
  bool condensed;

  bool fit;        /* lower modes and rank to what the body has room for; default false */
  thrum_mass mass; /* default consistent */

  /* Degree to which the points of ten-node tetrahedra are exact; 4 to 20, default 0: 4 for straight
   * edges, where the strain energy is of that degree, and 5 for curved ones, where it is rational.
   * Larger: curved elements are more exact, and the polynomial takes as much longer as there are
   * more points (11, 14, 24, then (order / 2 + 1)^3). */
  int quadrature_order;

  thrum_solver solver; /* default THRUM_SOLVER_AUTO */

  /* How it is checked that no mode was missed; default THRUM_CHECK_AUTO. */
  thrum_check check;

  /* The law of the material, or THRUM_LAW_BY_REGION: the laws of the mesh; default THRUM_LAW_STVK.
   * Another law needs cubature, as a polynomial of degree 4 cannot hold it. */
  thrum_law law;

#define THRUM_CUBATURE_ERROR_MOST 1.0     /* of cubature_error, */
#define THRUM_CUBATURE_RANGE_MOST 10.0    /* of cubature_range, */
#define THRUM_CUBATURE_COUNT_MOST 1000000 /* and of cubature_points and cubature_refine */

  /* V from cubature points in place of the polynomial; default false. The next five need it. */
  bool cubature;

  /* Relative rms of the internal force at which points are enough; > 0 to 1, default 0.001.
   * Smaller: more points, whose number a step's time grows with. */
  double cubature_error;

  /* Points at most; 1 to 1e6, default 2000. Smaller: the error may be missed. */
  int64_t cubature_points;

  /* Largest displacement that points are trained on, as a share of the body's diagonal; > 0 to
   * 10, default 0.2. Larger: more points for the same error, and right for larger motion. */
  double cubature_range;

  /* Steps in which the gradients of the points are learned; 0 to 1e6, default 0: they are those
   * of the mesh; 10000 are usual. Larger: fewer points for the same error, and a longer precompute.
   * Points that flow cannot be learned. */
  int64_t cubature_refine;

  /* Yield strain of a body that flows, which points of another law are then trained on; > 0,
   * default infinite: none, but for regions that have yields of their own. Smaller: more flows in
   * the states of training. */
  double cubature_yield;

  bool single; /* c3 and c4 in single precision; default false */

  /* The model holds what moduli and density of each region add to it (thrum/parameters.h), and of
   * several regions up to 6 (regions - 1) coordinates beside the rank, for shapes that modes gain
   * where these change; default false. */
  bool parameters;

  /* BLAS threads; >= 1, default 1. Larger: a faster precompute on a machine that has the cores, and
   * other rounding. */
  int threads;

  /* Memory that the process may hold [bytes]; >= 0, default 0: what is available. Larger: bodies
   * are refused later. */
  double memory_limit;

  /* Their static responses and as many directions of their derivatives are in the span of U, beside
   * as many vectors of modes and derivatives as the rank leaves, which must be three a handle at
   * least; default none. `rank` 0 then stands for 6 handle_count more. */
  const thrum_handle *handles;

  /* Number of `handles`; >= 0, default 0. Larger: more of the rank goes to them. */
  int64_t handle_count;

  /* Actuators (mesh/actuator.h): their static shapes and as many directions of their derivatives
   * are in the span of U beside the rank that is given, and their polynomials in the model; default
   * none. `rank` 0 then stands for 2 actuator_count more. */
  const struct thrum_actuator *actuators;

  /* Number of `actuators`; 0 to THRUM_ACTUATORS_MAX, default 0. */
  int64_t actuator_count;

  /* Shapes that are in the span of U beside the rank - trained_count vectors of modes and
   * derivatives: trained_count fields of 3 vertex_count each, one after the other, mass-independent
   * of those and of each other; default NULL. Fewer than `rank`. */
  const double *trained;

  /* Number of `trained`; >= 0, default 0. Larger: more of the rank goes to them. */
  int64_t trained_count;

  /* The share of each mode and each derivative in a motion, in the order of the candidates (k + k
   * (k + 1) / 2), times its norm: weights of the basis in place of those by frequency; default
   * NULL. */
  const double *shares;

  /* Takes the place of modes, rank, derivatives and mass-PCA; NULL: none. */
  const thrum_imported_basis *imported;

  /* The processes that make the model together (precompute/precompute.h); default NULL: this one
   * makes it alone. */
  const struct thrum_precompute_shared *shared;

  bool keep_modes;  /* hand out mode_vectors; default false */
  bool order_known; /* leave out the estimate of order_error; default false */

  /* Called as a stage advances, fraction in [0, 1]; return false to stop. May be NULL. */
  bool (*progress)(void *context, thrum_stage stage, double fraction);
  void *progress_context;
} thrum_precompute_options;

thrum_precompute_options thrum_default_precompute_options(void);

#endif
