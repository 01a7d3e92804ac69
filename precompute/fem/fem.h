/* The full-order body: tetrahedra of four or of ten nodes, of Saint Venant-Kirchhoff material,
 * design 1, or of another law, design 19. Sparse matrices act on the free components of
 * displacement alone; the functions of a displacement take and give all components, 3 v + axis,
 * held ones included.
 *
 * Integrals over a tet are sums over its points. A linear tet has one, and its volume as weight;
 * ten nodes take the points of thrum_quadrature, the same for all tets of a mesh: where no order is
 * asked for, those for curved edges where any edge is curved.
 *
 * Where the mesh has solids (mesh.h), the body consists of these alone, fem_solids.h, and has no
 * tets.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_FEM_H
#define THRUM_PRECOMPUTE_FEM_FEM_H

#include "core/base/quadratic_tet.h"
#include "mesh/mesh.h"
#include "platform/allocate.h"
#include "precompute/fem/ranks.h"
#include "precompute/fem/solid_elements.h"
#include "precompute/fem/sparse.h"
#include "precompute/options/precompute_options.h"
#include "runtime/material/material_law.h"

enum { THRUM_FEM_NODES_MAX = THRUM_SOLID_NODES_MAX };

typedef struct thrum_fem {
  thrum_scope memory; /* of the arrays that are not the mesh's */
  int64_t vertex_count;
  int64_t tet_count;
  int64_t free_count; /* n, components that may move */
  int64_t region_count;
  int node_count;            /* of a tet: 4 or 10 */
  int point_count;           /* of a tet: 1, or those of the rule */
  const double *vertices;    /* the mesh's, vertex_count x 3 [m] */
  const int32_t *nodes;      /* tet_count x node_count, corners first; of linear tets the mesh's */
  const int32_t *tet_region; /* the mesh's, tet_count */
  thrum_quadratic_point *rule;              /* point_count; NULL: linear tets */
  int usual_order;                          /* of the rule where none is asked for */
  double (*slopes)[THRUM_FEM_NODES_MAX][3]; /* point_count, of the shape functions; NULL: linear */
  int32_t *dof;                 /* vertex_count x 3: index among the free components, -1 held */
  int32_t *component;           /* free_count: 3 v + axis of each free component */
  double *gradient;             /* tet_count x point_count x 9: gradients of the barycentric
                                   coordinates 1, 2, 3 [1/m], in a linear tet its shape functions */
  double *weight;               /* tet_count x point_count: of the points [m^3] */
  double *volume;               /* tet_count, the sum of the weights [m^3] */
  double *lambda, *mu;          /* region_count, Lame's constants [Pa] */
  thrum_law law;                /* of all regions; Saint Venant-Kirchhoff as it is made */
  const thrum_region_law *laws; /* the mesh's, region_count, where the law is that by region */
  const double *plastic; /* tet_count x point_count x 9: F_p^-1 - 1 of plastic flow, borrowed;
                            NULL, as it is made: none */
  double *density;       /* region_count [kg/m^3] */
  const double *springs; /* the mesh's, vertex_count x 3 [N/m]; NULL: none hold it to the ground */
  const double *about; /* the mesh's: displacements are those from this state on, energy and forces
                          those beyond its own, which dead loads balance; NULL: nothing stressed */
  double *about_force; /* vertex_count x 3: forces of that state [N], */
  double about_energy; /* and its energy [J] */
  const struct thrum_fem_acting *acting; /* fem_actuators.h, borrowed; NULL: nothing acts */
  int64_t *incident_begin;               /* vertex_count + 1 */
  int64_t *incident;           /* node_count tet_count: node_count t + node of the tets around each
                                  vertex; of solids their numbers alone, as often as they have nodes */
  thrum_solid_elements solids; /* where the mesh has some: all elements, and there are no tets */
  const thrum_ranks *ranks; /* of whose body this is a part; NULL: the whole body, as it is made */
} thrum_fem;

/* The mesh must stay while the fem is used; `fixed` may go. Refuses bad materials, tets of no or
 * negative volume or whose map folds over at a point, and a body with no component free. */
thrum_status thrum_fem_create(const thrum_mesh *mesh, const uint8_t *fixed, thrum_fem *fem,
                              thrum_error *error);

/* The same, where ten-node tets take the points of this order of thrum_quadrature. With 2, which is
 * for comparison with programs that take four points, their mass is not exact. */
thrum_status thrum_fem_create_of_order(const thrum_mesh *mesh, const uint8_t *fixed, int order,
                                       thrum_fem *fem, thrum_error *error);
void thrum_fem_free(thrum_fem *fem); /* leaves it empty; an empty (zeroed) one is fine */

/* The nodes of the element of an entry of `incident`. */
static inline const int32_t *thrum_fem_around(const thrum_fem *fem, int64_t entry, int *count) {
  if (fem->solids.count > 0) {
    *count = thrum_solid_node_count(&fem->solids, fem->incident[entry]);
    return thrum_solid_nodes(&fem->solids, fem->incident[entry]);
  }
  *count = fem->node_count;
  return fem->nodes + fem->incident[entry] / fem->node_count * fem->node_count;
}

/* Elements of the body, tets or solids, and points at which strains are taken or would be. */
static inline int64_t thrum_fem_elements(const thrum_fem *fem) {
  return fem->solids.count > 0 ? fem->solids.count : fem->tet_count;
}
static inline int64_t thrum_fem_points(const thrum_fem *fem) {
  return fem->solids.count > 0 ? fem->solids.point_begin[fem->solids.count]
                               : fem->tet_count * fem->point_count;
}

/* The law of a region. */
static inline thrum_law thrum_fem_law(const thrum_fem *fem, int64_t region) {
  return fem->law == THRUM_LAW_BY_REGION ? fem->laws[region].law : fem->law;
}

/* As thrum_law_yield, and thrum_law_has_yield. */
double thrum_fem_yield(const thrum_fem *fem, int64_t region, double yield);
bool thrum_fem_has_yield(const thrum_fem *fem);

/* Gradients of the node_count shape functions of tet `t` at its point `p`, node 0 first [1/m]. */
void thrum_fem_shape_gradients(const thrum_fem *fem, int64_t t, int p,
                               double gradients[THRUM_FEM_NODES_MAX][3]);

/* Makes the n x n pattern of the stiffness; values are zero. */
thrum_status thrum_fem_pattern(const thrum_fem *fem, thrum_sparse *stiffness, thrum_error *error);

/* Fills the pattern with K_full(u), the tangent stiffness at u (3 vertex_count; NULL: at rest, or
 * in the state about which the body is). */
thrum_status thrum_fem_stiffness(const thrum_fem *fem, const double *u, thrum_sparse *stiffness,
                                 thrum_error *error);

/* The same where the tangent of each point is made positive semidefinite. `u` is not NULL. */
void thrum_fem_stiffness_positive(const thrum_fem *fem, const double *u, thrum_sparse *stiffness);

/* The mass matrix; it borrows nothing from the pattern it is built from. Ten-node tets are lumped
 * by scaling their diagonal to their mass (Hinton, Rock & Zienkiewicz 1976,
 * doi:10.1002/eqe.4290040305): their row sums are negative at corners. */
thrum_status thrum_fem_mass(const thrum_fem *fem, thrum_mass kind, const thrum_sparse *pattern,
                            thrum_sparse *mass, thrum_error *error);

/* Volume [m^3] and mass [kg] of all elements. */
void thrum_fem_weigh(const thrum_fem *fem, double *volume, double *mass);

/* Row sums of the mass matrix of all vertices, so M 1: vertex_count [kg]. Of linear tets both kinds
 * have the same. */
void thrum_fem_vertex_mass(const thrum_fem *fem, thrum_mass kind, double *mass);

/* V_full(u) [J] and R_full(u) = grad V_full [N]; u and force: 3 vertex_count, force may be NULL. */
double thrum_fem_energy(const thrum_fem *fem, const double *u, double *force);

/* image += S u, S the stiffness of the springs to the ground, a diagonal; all components (3
 * vertex_count), `lanes` displacements side by side. Returns u.S u / 2 [J], of all lanes. */
double thrum_fem_add_springs(const thrum_fem *fem, int lanes, const double *u, double *image);

/* The same of the free components alone (free_count). */
void thrum_fem_add_free_springs(const thrum_fem *fem, const double *u, double *image);

/* Between all components (3 vertex_count) and the free ones (free_count). */
void thrum_fem_gather(const thrum_fem *fem, const double *all, double *free_ones);
void thrum_fem_scatter(const thrum_fem *fem, const double *free_ones, double *all);

#endif
