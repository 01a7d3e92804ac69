/* The offline pipeline: mesh -> K, M -> modes -> modal derivatives -> U -> polynomial -> model.
 * design 1-3. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_PRECOMPUTE_H
#define THRUM_PRECOMPUTE_PRECOMPUTE_H

#include "mesh/mesh.h"
#include "thrum/model.h"

typedef enum thrum_mass { THRUM_MASS_CONSISTENT = 0, THRUM_MASS_LUMPED = 1 } thrum_mass;

/* How to check that no linear mode was missed: a fresh search of the complement, which also
 * recovers what was missed; after it, an exact count by MUMPS, which takes about as long as the
 * factor and is not built in everywhere. AUTO counts where it can up to 30,000 free components. */
typedef enum thrum_check { THRUM_CHECK_AUTO, THRUM_CHECK_SEARCH, THRUM_CHECK_INERTIA } thrum_check;

/* The stages, in order; they do not overlap. X(name, text) */
#define THRUM_STAGE_LIST(X)                                                                        \
  X(assemble, "stiffness and mass")                                                                \
  X(factor, "sparse Cholesky")                                                                     \
  X(modes, "linear modes")                                                                         \
  X(derivatives, "modal derivatives")                                                              \
  X(basis, "mass-PCA basis")                                                                       \
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
typedef struct thrum_given {
  int64_t rows, rank; /* rows: 3 per vertex of the mesh's file */
  double *basis;      /* rows x rank, row-major */
  double *linear;     /* rank x rank, of V = 1/2 q^T linear q + ...; NULL: no polynomial */
  double *c3, *c4;    /* block order of thrum/model.h */
  double defect;      /* by how much its force was no gradient */
} thrum_given;

/* What became of it. */
typedef struct thrum_given_figures {
  bool turned;              /* it was not in Thrum's form and has been turned */
  double orthonormality;    /* max |U^T M U - 1| as given */
  double defect;            /* of the polynomial's force, see thrum_given */
  double linear_difference; /* of the linear part from U^T K U, relative */
  double energy_difference; /* of V from the body's at large displacements, relative */
} thrum_given_figures;

typedef struct thrum_precompute_options {
  int64_t modes;       /* k linear modes; default 10 */
  int64_t rank;        /* r <= k (k + 3) / 2; default 0, which stands for 2 k */
  bool fit;            /* lower modes and rank to what the body has room for; default false */
  thrum_mass mass;     /* default consistent */
  thrum_check check;   /* that no mode was missed; default THRUM_CHECK_AUTO */
  bool single;         /* c3 and c4 in single precision; default false */
  int threads;         /* BLAS threads; default 1 */
  double memory_limit; /* bytes the process may hold; default 0: what is available */
  /* Their static responses are in the span of U, whatever the rank, which must be three a handle at
   * least; default none. `rank` 0 then stands for 2 (k + 3 handle_count). */
  const thrum_handle *handles;
  int64_t handle_count;
  /* Takes the place of modes, rank, derivatives and mass-PCA; NULL: none. */
  const thrum_given *given;
  bool keep_modes; /* hand out mode_vectors; default false */
  /* Called as a stage advances, fraction in [0, 1]; return false to stop. May be NULL. */
  bool (*progress)(void *context, thrum_stage stage, double fraction);
  void *progress_context;
} thrum_precompute_options;

thrum_precompute_options thrum_default_precompute_options(void);

/* The result: a model (arrays owned here, except meta, which is left empty for the caller to add
 * and to free) and figures. */
typedef struct thrum_precomputed {
  thrum_model model;
  int64_t mode_count;
  double *mode_omega2;         /* mode_count, of the linear modes [1/s^2]; behind them three a
                                  handle, Rayleigh quotients of the static responses */
  double *mode_vectors;        /* mode_count x 3 vertex_count where asked for, else NULL */
  thrum_given_figures given;   /* zero without a given basis; then there are no modes */
  double *mode_residual;       /* mode_count, |K psi - w^2 M psi| / (|K| |psi|) */
  bool mode_counted;           /* by inertia; else by the search alone */
  bool modes_complete;         /* what was counted is what was found; true for a search */
  int64_t modes_recovered;     /* missed at first, found by the search */
  double next_omega2;          /* of the first mode left out, from above; INFINITY: there is none */
  double shift;                /* [1/s^2], and how many modes were counted below it, */
  int64_t shift_count;         /* rigid ones included; 0 where not counted */
  double basis_orthonormality; /* max |U^T M U - 1| */
  double basis_diagonality;    /* max off-diagonal |U^T K U| / max omega2 */
  double single_error;         /* of options.single: relative error of R, see precision.h; else 0 */
  int64_t free_dofs;
  int64_t factor_nonzeros;
  double mass;           /* [kg] */
  double volume;         /* [m^3] */
  int64_t rigid_count;   /* 6 for a free body, whose rigid modes are model.rigid; else 0 */
  double rigid_residual; /* largest |K z| / (|K| |z|) of them */
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

void thrum_precomputed_free(thrum_precomputed *result);

#endif
