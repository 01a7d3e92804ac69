/* How a body is cut into parts. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_BODY_CUT_H
#define THRUM_MPI_BODY_CUT_H

#include <mpi.h>

#include "precompute/fem/fem.h"

/* How a whole body is cut, in the process that has it. */
typedef struct body_cut {
  thrum_scope memory; /* of the arrays */
  int parts;
  int32_t *owner;     /* vertex_count: the part that owns each vertex, one of those that have it */
  int32_t *tet_part;  /* tet_count */
  int32_t *place;     /* vertex_count: number of each vertex where those of part 0 come first, then
                         those of part 1, ..., ascending within a part */
  int64_t *own_count; /* parts: vertices that each owns */
  int32_t *inner, *outer; /* vertex_count: neighbours of the same owner, itself included, and of
                             others */
} body_cut;

/* Cuts the body of `fem`, which rank 0 of `comm` has and the others give as NULL, by PT-Scotch: all
 * call it. *cut is filled in rank 0. */
thrum_status body_cut_make(MPI_Comm comm, const thrum_fem *fem, body_cut *cut, thrum_error *error);

/* Whether every part has tets, and free components on them. */
bool body_cut_is_full(const thrum_fem *fem, const body_cut *cut);
void body_cut_free(body_cut *cut); /* leaves it empty; an empty (zeroed) one is fine */

#endif
