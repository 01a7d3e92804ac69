/* A body that several processes share, and the solvers that work on it together.
 *
 * Each process (MPI calls it a rank) has a part: some of the tets, and all vertices of these. A tet
 * is in one part, a vertex between parts is in several. Forces, such as K u, M u and the right
 * sides of equations, are kept as terms: the terms of all parts at a vertex add up to the force.
 * Displacements are kept whole: they agree in all parts that have the vertex. So the matrices of
 * the parts are those of thrum_fem without change, a scalar product of a force and a displacement
 * is the sum of the products of the parts, and combinations of columns need no exchange (the
 * subassembled form of domain decomposition: Toselli, Widlund 2005, doi:10.1007/b137868).
 *
 * Every function here is called by all processes at once, with equal counts. With ranks NULL the
 * process has the whole body, and nothing is done.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_RANKS_H
#define THRUM_PRECOMPUTE_FEM_RANKS_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/status.h"

#include "precompute/options/precompute_options.h"

struct thrum_fem;
struct thrum_sparse;

/* The solver that several processes use, and why. Bytes are what it adds in one process, by an
 * estimate; those of the process with the least to spare for it. Zeros: one process alone. */
typedef struct thrum_solver_use {
  thrum_solver solver;
  double nonzeros; /* of the factor of the whole body; 0: there is none */
  double factor_bytes, cg_bytes;
  double room;          /* bytes that this process may take */
  double solves, steps; /* of conjugate gradients so far: right-hand sides, and steps in all */
} thrum_solver_use;

typedef struct thrum_ranks {
  int64_t size;          /* n of the whole body, free components */
  const int32_t *vertex; /* of each vertex of the part: its number in the whole mesh, ascending */
  const uint8_t *own; /* of each vertex of the part: 1 in one of the parts that have it, else 0 */
  bool free_body;     /* nothing of the whole body is held */
  void *context;

  /* Takes the part of this process, before all others here; the fem must stay. */
  thrum_status (*take)(void *context, const struct thrum_fem *fem, thrum_error *error);

  /* Sums, and largest values, over all processes, in place; all get the same bits. */
  void (*sum)(void *context, double *numbers, int64_t count);
  void (*largest)(void *context, double *numbers, int64_t count);

  /* Adds up the terms of a force on the free components of the part, in place; and the Euclidean
   * norm, over the whole body, of what agrees in all parts. */
  thrum_status (*add_terms)(void *context, double *force, thrum_error *error);
  double (*norm)(void *context, const double *x);

  /* Readies solutions of K x = f of the whole body from the matrices of the parts. */
  thrum_status (*prepare)(void *context, const struct thrum_sparse *stiffness,
                          const struct thrum_sparse *mass, thrum_error *error);

  /* solution = K^-1 right, as thrum_factor_solve or, not `exact`, as thrum_factor_solve_roughly:
   * terms in, displacements out; `context` first. A free body is held by springs (rigid_modes.h).
   */
  thrum_status (*solve)(void *context, bool exact, const double *right, int64_t columns,
                        double *solution, thrum_error *error);

  /* Whether solves that are not exact are cheaper, and those of many columns cheaper together. The
   * modes are then those of thrum_eigen_lowest_block, else of `lowest`. */
  bool (*rough)(const void *context);

  /* The `count` lowest eigenpairs, as thrum_eigen_lowest but for signs and clusters; rigid: Z of
   * the part of a free body, or NULL. */
  thrum_status (*lowest)(void *context, const double *rigid, int64_t count, double *values,
                         double *vectors, thrum_error *error);

  /* Whether eigenvalues can be counted, and how many of K x = s M x lie below a shift. */
  bool (*counts)(const void *context);
  thrum_status (*count_below)(void *context, double shift, int64_t *count, thrum_error *error);

  /* Gives back what only solves and counts need, once there will be no more of them. */
  void (*release)(void *context);

  /* The solver that `prepare` chose. */
  thrum_solver_use (*solver_use)(const void *context);
} thrum_ranks;

void thrum_ranks_sum(const thrum_ranks *ranks, double *numbers, int64_t count);
void thrum_ranks_largest(const thrum_ranks *ranks, double *numbers, int64_t count);

/* Euclidean norm of a force given by terms, on the `count` free components of a part; what is in
 * `force` is then added up. */
thrum_status thrum_ranks_force_norm(const thrum_ranks *ranks, double *force, int64_t count,
                                    double *norm, thrum_error *error);
double thrum_ranks_norm(const thrum_ranks *ranks, const double *x, int64_t count);

/* n of the whole body, where this process has `here` of it. */
int64_t thrum_ranks_size(const thrum_ranks *ranks, int64_t here);

#endif
