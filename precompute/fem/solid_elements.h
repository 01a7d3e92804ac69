/* Elements that are no plain tetrahedra: hexahedra, wedges, solid-shells, and the tetrahedra beside
 * them. Their strain energy is an exact quartic polynomial of the displacements.
 *
 * With y_a = x_a - x_0 the edges of an element from its node 0, Green's strain at a point is a sum
 * over products s_ab = y_a . y_b less their values at rest, and so is any fixed combination of such
 * strains (assumed strains) and what is left of them when parameters of the element are condensed
 * (enhanced strains). So there is a matrix R of rows, with
 *   V = 1/2 |R s|^2,   s(u) = Y v + 1/2 v v,   (v w)_ab = v_a . w_b + w_a . v_b, a < b,
 *                                              (v w)_aa = 2 v_a . w_a,
 * v the displacements of the edges. Elements of middle nodes have many products for that, and
 * take Green's strain at their points, but for tetrahedra whose change of volume is one: the mean
 * of that of its points is in the place of each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_SOLID_ELEMENTS_H
#define THRUM_PRECOMPUTE_FEM_SOLID_ELEMENTS_H

#include "mesh/elastic.h"
#include "mesh/mesh.h"
#include "mesh/solid_shape.h"
#include "platform/allocate.h"

enum {
  THRUM_SOLID_ROW_NODES_MAX = 10, /* of an element with rows */
  THRUM_SOLID_EDGES_MAX = THRUM_SOLID_ROW_NODES_MAX - 1,
  THRUM_SOLID_PRODUCTS_MAX = THRUM_SOLID_EDGES_MAX * (THRUM_SOLID_EDGES_MAX + 1) / 2,
  THRUM_SOLID_COMPONENTS_MAX = 3 * THRUM_SOLID_NODES_MAX
};

typedef struct thrum_solid_elements {
  int64_t count;          /* 0: the tets of the mesh are the elements */
  const double *vertices; /* the mesh's */
  const uint8_t *form;
  const int32_t *ends, *nodes, *tet_ends; /* the mesh's */
  int32_t *region;                        /* count */
  thrum_solid_table *tables;              /* THRUM_FORMS */
  int64_t *point_begin;                   /* count + 1 */
  double *weight;                         /* of each point [m^3] */
  double *gradient;   /* of each point: gradients of natural coordinates, 3 x 3 */
  double *volume;     /* count [m^3] */
  int64_t *row_begin; /* count + 1: places in `rows`, whose numbers an element has one row after
                         the other, in units of the root of a stress times a volume, over lengths
                         squared */
  double *rows;
  const double *elastic;  /* the mesh's layers of elasticity with directions; NULL: none */
  int64_t *elastic_begin; /* region_count + 1: those of each region; NULL: none */
  double *stiffness;      /* region_count x 72: C of regions with directions in space, along the
                             axes of space, and R behind it, C = R^T R; NULL: none */
} thrum_solid_elements;

/* Layers of elasticity of a region; 0: it is isotropic. */
static inline int thrum_solid_layers(const thrum_solid_elements *e, int32_t region) {
  return e->elastic_begin ? (int)(e->elastic_begin[region + 1] - e->elastic_begin[region]) : 0;
}

/* C of a region with directions in space; NULL: it is isotropic, or a laminate. */
static inline const double *thrum_solid_stiffness(const thrum_solid_elements *e, int32_t region) {
  if (thrum_solid_layers(e, region) == 0)
    return NULL;
  const double *row = e->elastic + THRUM_ELASTIC_NUMBERS * e->elastic_begin[region];
  return row[THRUM_ELASTIC_THICKNESS] > 0
             ? NULL
             : e->stiffness + 2 * THRUM_STRAINS * THRUM_STRAINS * region;
}

static inline const int32_t *thrum_solid_nodes(const thrum_solid_elements *e, int64_t s) {
  return e->nodes + (s > 0 ? e->ends[s - 1] : 0);
}

static inline int thrum_solid_node_count(const thrum_solid_elements *e, int64_t s) {
  return thrum_solid_forms[e->form[s]].nodes;
}

/* The first tet of an element. */
static inline int64_t thrum_solid_tet(const thrum_solid_elements *e, int64_t s) {
  return s > 0 ? e->tet_ends[s - 1] : 0;
}

/* Has a form rows? Else it has strains at points. */
static inline bool thrum_solid_has_rows(const thrum_solid_elements *e, int64_t s) {
  return thrum_solid_node_count(e, s) <= 8 || e->form[s] == THRUM_FORM_MEAN10;
}

static inline int thrum_solid_products(int nodes) {
  return (nodes - 1) * nodes / 2;
}

/* How many rows an element has; 0 for one of points. */
static inline int thrum_solid_row_count(const thrum_solid_elements *e, int64_t s) {
  return (int)((e->row_begin[s + 1] - e->row_begin[s]) /
               thrum_solid_products(thrum_solid_node_count(e, s)));
}

/* Measures the elements of a mesh that has some and makes their rows; `lambda` and `mu` of each
 * region that is isotropic. Refuses elements that turn inside out at a point, and laminates of
 * other elements than solid-shells. All memory is of the scope. */
thrum_status thrum_solid_elements_make(const thrum_mesh *mesh, const double *lambda,
                                       const double *mu, thrum_scope *memory,
                                       thrum_solid_elements *made, thrum_error *error);

/* Makes the rows again, of other moduli of the regions. They are linear in Young's modulus alone;
 * elements of a region whose moduli are both 0 have none. */
thrum_status thrum_solid_elements_renew(thrum_solid_elements *made, const double *lambda,
                                        const double *mu, thrum_error *error);

/* Axes of six strains or stresses in the order of the rows: xx, yy, zz, yz, xz, xy. */
extern const int thrum_solid_strain_axes[6][2];

/* Second Piola-Kirchhoff stress at the points of an element with rows, of its assumed and enhanced
 * strains: 6 stresses a point by its products, row after row. In a laminate the lower points have
 * the stress of the lowest layer, and the upper ones that of the uppermost. */
thrum_status thrum_solid_stress_matrix(const thrum_solid_elements *e, int64_t s,
                                       const double *lambda, const double *mu, double *matrix,
                                       thrum_error *error);

/* Gradients of the shape functions at point p of an element. */
void thrum_solid_gradients(const thrum_solid_elements *e, int64_t s, int p,
                           double gradients[THRUM_SOLID_NODES_MAX][3]);

/* products = v w, of edges (nodes - 1 x 3). */
void thrum_solid_multiply(int nodes, const double *v, const double *w, double *products);

/* force_a += scale * sum_b S_ab w_b: what the derivative of stress . (v w) by v_a is. */
void thrum_solid_pull(int nodes, const double *stress, const double *w, double scale,
                      double *force);

/* result = R^T R products */
void thrum_solid_stress(int rows, int count, const double *matrix, const double *products,
                        double *result);

/* Edges from node 0 of the places or displacements `of` all vertices. */
void thrum_solid_edges(const int32_t *nodes, int count, const double *of, double *edges);

#endif
