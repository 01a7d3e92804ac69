/* How much lower the frequencies of a body become when functions are added to its finite elements
 * (Bank & Smith 1993, A posteriori error estimates based on hierarchical bases,
 * doi:10.1137/0730048). The modes psi of the given space start a step of subspace iteration in the
 * larger one: K x = M psi is solved for each, and the eigenvalues of K and M on the span of all x
 * stand beside those of psi. What the given space holds by locking, the share of its own nodes
 * included, is let go in x. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_HIERARCHY_H
#define THRUM_PRECOMPUTE_BASIS_HIERARCHY_H

#include "mesh/mesh.h"
#include "precompute/fem/fem.h"

enum { THRUM_ORDER_MODES_MAX = 8 };

/* A body of linear or ten-node tets with the factor of its stiffness. */
typedef struct thrum_order_body {
  const thrum_mesh *mesh;
  const thrum_fem *fem;             /* of the mesh */
  thrum_factor *factor;             /* of a free body deflated, as thrum_factor_deflate makes it */
  const double *rigid, *rigid_dual; /* Z and M Z of a free body, free_count x 6; else NULL */
} thrum_order_body;

/* Fields are free_count numbers of the nodes and then three for each function that is added. */
typedef struct hierarchy hierarchy;
struct hierarchy {
  void (*multiply)(const hierarchy *s, const double *field, double *image); /* image = K field */
  void (*weigh)(const hierarchy *s, const double *field, double *image);    /* image = M field */
  const void *context;                                                      /* of these two */
  thrum_factor *factor;
  const double *rigid, *rigid_dual;
  int64_t nodes;              /* free_count */
  int64_t count;              /* of functions that are added */
  int64_t size;               /* of a field */
  uint8_t *held;              /* count: axes that are held, a bit each */
  double *inverse;            /* count x 9: of the diagonal blocks of K */
  double *x, *load, *weighed; /* modes x size: x, K x and M x */
  double *r, *z, *p, *image;  /* size */
  thrum_scope memory;         /* of these arrays; begun by the caller, who frees it */
};

/* Makes the arrays, zeroed, in the scope that s->memory is. */
thrum_status hierarchy_allocate(const thrum_order_body *body, int64_t added, int64_t modes,
                                hierarchy *s);

/* Makes s->inverse, which holds the diagonal blocks, into their inverses without held axes. */
void hierarchy_invert_blocks(hierarchy *s);

/* Makes what is held zero in the added part of a field. */
void hierarchy_clear_held(const hierarchy *s, double *field);

/* errors[i] = f_i / f - 1 of `count` modes (free_count x count, column-major), where f is the
 * frequency in the larger space. Unchanged on failure. */
thrum_status hierarchy_errors(hierarchy *s, int64_t count, const double *modes, double *errors,
                              thrum_error *error);

#endif
