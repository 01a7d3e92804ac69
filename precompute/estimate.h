/* Estimates what a precompute will take, before it takes it. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_ESTIMATE_H
#define THRUM_PRECOMPUTE_ESTIMATE_H

#include <stdbool.h>

#include "precompute/fem/fem.h"

typedef struct thrum_estimate {
  int64_t free_dofs;
  int64_t factor_nonzeros;
  double factor_flops;
  int64_t rank;      /* of the model, with what parameters add */
  double file;       /* bytes of the model, about */
  double memory;     /* most bytes that the process will hold, what it holds now included */
  double more;       /* of them, what is still to be taken */
  double available;  /* bytes, thrum_memory_available or the limit asked for */
  const char *whose; /* what `available` is the memory of; static storage */
  bool fits;
  bool by_rank, by_refine; /* where it does not: whether a lower rank would take much less, and
                              points whose gradients are not learned less at all */
  double seconds[THRUM_STAGE_COUNT]; /* rough: within a factor of two or so; 0 unless asked for */
} thrum_estimate;

/* Estimates the memory from the planned factor (NULL for an imported basis, which needs none) and
 * the sizes alone. */
void thrum_estimate_memory(const thrum_fem *fem, const thrum_sparse *stiffness,
                           const thrum_factor *factor, const thrum_precompute_options *options,
                           thrum_estimate *estimate);

/* The times of the stages by a factor, from the nonzeros and flops in the estimate; and by
 * conjugate gradients, of a matrix with so many entries (both triangles). Of a part of a body:
 * those of one of several processes, from its share of either. */
void thrum_estimate_times(const thrum_fem *fem, const thrum_precompute_options *options,
                          thrum_estimate *estimate);
void thrum_estimate_times_cg(const thrum_fem *fem, const thrum_precompute_options *options,
                             double entries, thrum_estimate *estimate);

/* Assembles and orders the matrices of a mesh, no more, and fills the whole estimate, times from
 * two probes of this machine's speed of some hundredths of a second. Refuses what thrum_precompute
 * refuses up to there, but not what does not fit. */
thrum_status thrum_precompute_estimate(const thrum_mesh *mesh, const uint8_t *fixed,
                                       const thrum_precompute_options *options,
                                       thrum_estimate *estimate, thrum_error *error);

/* Refuses a grid of cells, each cut into tets, of which no model can be made in the memory that is
 * available, before it is made: its mesh, its modes, and the largest dense block that every order
 * of elimination meets do not fit. What passes may still not fit. */
thrum_status thrum_estimate_grid(const int64_t cells[3], const thrum_precompute_options *options,
                                 thrum_error *error);

/* Seconds that the numbers of a planned factor of this size take, and so many solves of one column
 * with it: rough, from a short measurement of the machine where they may be more than a few. */
double thrum_estimate_solves(const thrum_factor *factor, int64_t size, int64_t solves);

/* The refusal when an estimate does not fit. */
thrum_status thrum_estimate_refuse(const thrum_estimate *estimate, thrum_error *error);

#endif
