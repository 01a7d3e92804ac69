/* The equations of a whole body, spread over all processes in PETSc's matrices: stiffness, mass and
 * the solver of K x = f, and the ranks (precompute/fem/ranks.h) that stand on them.
 *
 * Rows are 3 place + axis, the places of body_part.h, so that a process has the rows of the
 * vertices that its part owns. Components that are held are rows of their own with a typical
 * stiffness and no mass: they stay zero, and every vertex has three rows, which algebraic multigrid
 * counts on.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_BODY_SYSTEM_H
#define THRUM_MPI_BODY_SYSTEM_H

#include <slepceps.h>

#include "mpi/block_gradients.h"
#include "mpi/body_part.h"
#include "precompute/options/precompute_options.h"
#include "precompute/precompute.h"

typedef struct body_system {
  MPI_Comm comm;
  const body_part *part;
  const thrum_precompute_options *options;
  thrum_solver_use use; /* the solver, once it is chosen */
  int64_t size;         /* free components of the whole body, of the part: */
  int64_t free_count;
  const int32_t *component; /* free_count, of the part's fem */
  Mat stiffness, mass;      /* NULL once conjugate gradients have taken what they need */
  KSP ksp;                  /* NULL with conjugate gradients for blocks, which are: */
  block_gradients *gradients;
  double *block;       /* rows of this process x BLOCK_COLUMNS */
  Vec all, local;      /* rows of this process, and the free components of its part */
  VecScatter spread;   /* from local to all */
  double typical;      /* stiffness of a held component and of a spring */
  thrum_error failure; /* of a solve that SLEPc asked for; status 0: none */
} body_system;

/* An empty system of a part; all must stay. */
body_system body_system_begin(MPI_Comm comm, const body_part *part,
                              const thrum_precompute_options *options);
void body_system_free(body_system *system); /* leaves it empty */

/* The functions of thrum_ranks that need no eigensolver; the context is the system. */
thrum_ranks body_system_ranks(body_system *system);

/* Memory that either solver would take for these matrices of the part, without times. */
thrum_status body_system_estimate(body_system *system, const thrum_fem *fem,
                                  const thrum_sparse *stiffness, const thrum_sparse *mass,
                                  thrum_shared_estimate *estimate, thrum_error *error);

/* solution = K^-1 right by rows, both of this process. */
thrum_status body_system_solve_rows(body_system *system, Vec right, Vec solution,
                                    thrum_error *error);

/* Between the free components of the part and the rows of this process: adds up terms, or hands
 * values out. */
thrum_status body_system_add(body_system *system, const double *terms, Vec rows,
                             thrum_error *error);
thrum_status body_system_hand_out(body_system *system, Vec rows, double *values,
                                  thrum_error *error);

/* Adds the springs of a free body to a matrix, `times` their strength. */
thrum_status body_system_add_springs(const body_system *system, double times, Mat matrix,
                                     thrum_error *error);

#endif
