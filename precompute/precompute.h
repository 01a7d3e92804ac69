/* The offline pipeline: mesh -> K, M -> modes -> modal derivatives -> U -> polynomial -> model.
 * design 1-3. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_PRECOMPUTE_H
#define THRUM_PRECOMPUTE_PRECOMPUTE_H

#include "mesh/mesh.h"
#include "precompute/basis/basis.h"
#include "precompute/fem/ranks.h"
#include "precompute/options/precompute_options.h"
#include "precompute/polynomial/cubature.h"
#include "thrum/model.h"

/* The result: a model (arrays owned here, except meta, which is left empty for the caller to add
 * and to free) and figures. */
enum { THRUM_ORDER_ERRORS_MAX = 5, THRUM_CUBIC_ERRORS_MAX = 2 };

typedef struct thrum_precomputed {
  thrum_model model;
  int64_t mode_count;
  double *mode_omega2;             /* mode_count, of the linear modes [1/s^2]; behind them three a
                                      handle, Rayleigh quotients of the static responses */
  double *mode_vectors;            /* mode_count x 3 vertex_count where asked for, else NULL */
  thrum_coordinate *coordinates;   /* model.rank, of what the basis is made; NULL: it is imported */
  thrum_imported_figures imported; /* zero without an imported basis; then there are no modes */
  double *mode_residual;           /* mode_count, |K psi - w^2 M psi| / (|K| |psi|) */

  /* How much too high the first frequencies of linear tets are, by an estimate; of more than 50,000
   * tets the first two alone, of ten nodes none. */
  int64_t order_error_count;
  double order_error[THRUM_ORDER_ERRORS_MAX]; /* f_i / f - 1 */

  /* The same of ten-node tets beside functions of third degree, of the first two modes; of linear
   * ones, and of more than 20,000 tets, none. */
  int64_t cubic_error_count;
  double cubic_error[THRUM_CUBIC_ERRORS_MAX];

  /* How it was made sure that no mode is missing. */
  bool mode_counted;       /* by inertia; else by the search alone */
  bool modes_complete;     /* what was counted is what was found; true for a search */
  int64_t modes_recovered; /* missed at first, found by the search */
  double next_omega2;      /* of the first mode left out, from above; INFINITY: there is none */
  double shift;            /* [1/s^2], and how many modes were counted below it, */
  int64_t shift_count;     /* rigid ones included; 0 where not counted */

  /* How far the result can be trusted, and the body. */
  double basis_orthonormality; /* max |U^T M U - 1| */
  double basis_diagonality;    /* max off-diagonal |U^T K U| / max omega2 */
  int quadrature_order; /* of ten-node tetrahedra, those asked for or the usual one; 0: linear */
  thrum_cubature_figures cubature; /* zero without points */
  double single_error; /* of options.single: relative error of R, see single_precision.c; else 0 */
  int64_t free_dofs;
  int64_t factor_nonzeros;
  thrum_solver_use solver; /* of several processes; else zeros */
  double mass;             /* [kg] */
  double volume;           /* [m^3] */
  int64_t rigid_count;     /* 6 for a free body, whose rigid modes are model.rigid; else 0 */
  double rigid_residual;   /* largest |K z| / (|K| |z|) of them */

  /* The cost of each stage. */
  double seconds[THRUM_STAGE_COUNT];
  double cpu_seconds[THRUM_STAGE_COUNT]; /* of all threads; less than seconds on a busy machine */
  double peak_mb[THRUM_STAGE_COUNT];     /* most memory of the process so far [2^20 bytes] */
  double flops[THRUM_STAGE_COUNT]; /* of the factor, of solves, of the Gram product; 0: uncounted */
} thrum_precomputed;

/* `fixed`: vertex_count bytes, as filled by thrum_mesh_fix. Refuses, with a line that says what to
 * do: bad materials (nu outside (-1, 1/2), E or rho <= 0), too little fixed, modes or rank too
 * large for the mesh, rank beyond the numerical rank of the candidates, more
 * memory than there is (estimated once the factor is planned, before it is taken). Nothing fixed
 * makes a free body: one part, six rigid modes kept apart in model.rigid, U mass-orthogonal to
 * them. On failure *result is untouched. One call at a time in a process: ARPACK is not re-entrant,
 * and the thread count of the numerical libraries is set for the while. Equal input, threads and
 * machine give equal bits. */
thrum_status thrum_precompute(const thrum_mesh *mesh, const uint8_t *fixed,
                              const thrum_precompute_options *options, thrum_precomputed *result,
                              thrum_error *error);

/* Estimated memory and time of one solver on several processes. */
typedef struct thrum_shared_solver {
  double held, more, room; /* bytes of the process with least to spare: that it holds, that the
                              solver adds with modes and derivatives, and that it may still take */
  double processes;        /* with as much room each that would do */
  double seconds;          /* of the whole precompute, where each process has a core */
} thrum_shared_solver;

typedef struct thrum_shared_estimate {
  int processes; /* that share the body */
  int64_t free_dofs;
  double nonzeros, flops; /* of the factor of the whole body */
  thrum_solver solver;    /* which would be taken */
  thrum_shared_solver factor, cg;
} thrum_shared_estimate;

/* How several processes make a model together: takes the place of thrum_precompute, with complete
 * and checked options and the whole mesh, in the one process that has it. */
typedef struct thrum_precompute_shared {
  void *context;
  thrum_status (*precompute)(void *context, const thrum_mesh *mesh, const uint8_t *fixed,
                             const thrum_precompute_options *options, thrum_precomputed *result,
                             thrum_error *error);
  /* Estimates what that would take with either solver; makes nothing. */
  thrum_status (*estimate)(void *context, const thrum_mesh *mesh, const uint8_t *fixed,
                           const thrum_precompute_options *options, thrum_shared_estimate *estimate,
                           thrum_error *error);
} thrum_precompute_shared;

/* The same stages on this process's part of a body (fem/ranks.h), called by all that share it, with
 * complete and checked options. The model is that of the part: its rows of the basis, and the
 * polynomial of the whole body. */
thrum_status thrum_precompute_part(const thrum_mesh *part, const uint8_t *fixed,
                                   const thrum_precompute_options *options,
                                   const thrum_ranks *ranks, thrum_precomputed *result,
                                   thrum_error *error);

void thrum_precomputed_free(thrum_precomputed *result);

#endif
