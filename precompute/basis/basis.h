/* The basis U from linear modes and modal derivatives, design 2.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_BASIS_H
#define THRUM_PRECOMPUTE_BASIS_BASIS_H

#include "precompute/fem/fem.h"
#include "precompute/options/stage.h"

/* What makes a basis: the linear modes, the static responses, as many directions of the responses'
 * derivatives, the trained fields, and as many directions of the modes' derivatives as the rank
 * leaves. A rank that leaves less than `modes` takes the first of the modes. */
typedef struct thrum_basis_def {
  const thrum_fem *fem;
  const thrum_sparse *mass, *stiffness;
  thrum_selection selection;
  int64_t rank;

  int64_t modes;        /* k */
  double *candidates;   /* n x (k + k (k + 1) / 2), column-major, destroyed: the modes, then the
                           derivatives in the order of thrum_derivatives */
  const double *omega2; /* of the modes, then of the responses, INFINITY for one that is zero */
  const double *shares; /* weights of the candidates in place of those by frequency, those of modes
                           without effect where all modes stay; NULL: by frequency */

  int64_t response_count;
  const double *responses; /* n x response_count, each of unit mass norm or zero, and behind them
                              all derivatives that have one of them */
  int64_t trained_count;   /* of the rank */
  const double *trained;   /* fields of 3 vertex_count, one after the other */
} thrum_basis_def;

typedef enum thrum_coordinate_kind {
  THRUM_COORDINATE_MODE,       /* a linear mode */
  THRUM_COORDINATE_DERIVATIVE, /* what modal derivatives show beside the modes */
  THRUM_COORDINATE_HANDLE,     /* responses of the handles, and their derivatives */
  THRUM_COORDINATE_TRAINED,
  THRUM_COORDINATE_KINDS
} thrum_coordinate_kind;

enum { THRUM_COORDINATE_PAIRS = 3 };

/* What a column of U is. It is of the kind that has the largest share of it, in the norm of the
 * mass; the shares of all kinds add up to 1. */
typedef struct thrum_coordinate {
  thrum_coordinate_kind kind;
  double share;
  int64_t mode; /* of a linear mode: which, from 1 */

  /* Of a derivative: the pairs of modes, from 1, whose weighted derivatives have most strain energy
   * along it, and their shares of that of all pairs; share 0: there is no such pair. */
  int64_t pairs[THRUM_COORDINATE_PAIRS][2];
  double pair_shares[THRUM_COORDINATE_PAIRS];
} thrum_coordinate;

/* basis: U, 3 vertex_count x rank, row-major, zero rows where held, with U^T M U = 1, U^T K U
 * diagonal and ascending, signs and clusters canonical; *orthonormality: max |U^T M U - 1|;
 * coordinates: rank, left alone by THRUM_SELECTION_MASS. THRUM_INVALID_ARGUMENT, with the largest
 * possible rank, when modes and derivatives span less than the rank. */
thrum_status thrum_basis(const thrum_basis_def *def, double *basis, double *orthonormality,
                         thrum_coordinate *coordinates, const thrum_reporter *reporter,
                         thrum_error *error);

#endif
