/* A part of a body: some of its tets, the vertices of these, and what this process must know of the
 * whole. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_BODY_PART_H
#define THRUM_MPI_BODY_PART_H

#include <mpi.h>

#include "mpi/body_cut.h"
#include "precompute/fem/rigid_modes.h"

/* The numbers that every part has, which stay few. */
typedef struct part_facts {
  int64_t free_count; /* of the whole body */
  int64_t vertices, tets, own, regions;
  bool free_body, quadratic;
  thrum_support support; /* of a free body, vertices in the order of the cut */
} part_facts;

typedef struct body_part {
  thrum_scope memory; /* of the arrays but the mesh's */
  part_facts facts;
  thrum_mesh mesh;        /* of the part */
  uint8_t *fixed;         /* a byte a vertex of the part, as all of these */
  uint8_t *own;           /* this part owns it */
  int32_t *vertex;        /* number in the whole mesh, ascending */
  int32_t *place;         /* in the order of the cut */
  int32_t *inner, *outer; /* own: of the vertices that the part owns, ascending */
} body_part;

/* Rank 0 gives the body with its cut; every process, this one too, gets its part. The others give
 * NULL. `facts` of rank 0 say what is of the whole body. */
thrum_status body_part_share(MPI_Comm comm, const thrum_mesh *mesh, const uint8_t *fixed,
                             const body_cut *cut, const part_facts *facts, body_part *part,
                             thrum_error *error);
void body_part_free(body_part *part); /* leaves it empty; an empty (zeroed) one is fine */

/* Brings rows of the vertices that a part owns, `width` numbers each, together in rank 0: part_rows
 * has one for each vertex of the part, whole (rank 0) for each of the mesh. */
thrum_status body_part_gather(MPI_Comm comm, const body_part *part, const body_cut *cut,
                              int64_t whole_count, int64_t width, const double *part_rows,
                              double *whole, thrum_error *error);

#endif
