/* Strain and stress at the centres of chosen tetrahedra, or of all of them, straight from q; and
 * stress at the nodes, where it is largest on a surface that is bent or twisted.
 *
 * A linear tetrahedron has one displacement gradient, G(q) = sum_i q_i G_i, so its Green strain
 *   E(q) = 1/2 (G + G^T + G^T G)
 * is a quadratic polynomial of q, evaluated exactly up to rounding: the stresses belong to the same
 * body that the model steps. In a ten-node tetrahedron G depends on the place, and G(q) is that at
 * its centre. Of a model of hexahedra, wedges or solid-shells the tetrahedra are the shape alone,
 * so it has no stress points. The second Piola-Kirchhoff stress is S = lambda tr(E) 1 + 2 mu
 * E, or that of the model's point_law or of the region's, whose quotient by J is not finite where J
 * = 0; with F = 1 + G and J = det F the Cauchy stress, force over deformed area, is sigma = F S F^T
 * / J, from which von Mises' equivalent stress is taken.
 *
 * Memory: a set of stress points is planned (thrum_stress_points_size), then laid into the caller's
 * memory (thrum_stress_points_init); afterwards it needs the model no longer. No function here
 * allocates.
 *
 * Threads: a set is immutable and may be shared by any number of threads; outputs and workspace
 * belong to one thread each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_STRESS_H
#define THRUM_STRESS_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where stress points lie; zero-initialise it for all tetrahedra. It is only read while stress
 * points are planned and made. */
typedef struct thrum_stress_points_def {
  /* tet_count: 0-based tetrahedra of the model in the order of the output; NULL: all. */
  const int32_t *tets;

  /* Number of `tets`; 1 to 2^29, ignored without them. Larger: more output, and time and memory in
   * proportion. */
  int64_t tet_count;
} thrum_stress_points_def;

/* Opaque: lives at the start of the memory given to thrum_stress_points_init. */
typedef struct thrum_stress_points thrum_stress_points;

/* Output arrays of the caller; NULL leaves a quantity out. A symmetric tensor is six numbers xx,
 * yy, zz, xy, yz, xz, not doubled off the diagonal. */
typedef struct thrum_stress_points_output {
  double *strain;       /* count x 6, Green strain E [1] */
  double *second_piola; /* count x 6, S [Pa] */
  double *cauchy;       /* count x 6, sigma [Pa]; NaN where J <= 0: the tet is inverted */
  double *von_mises;    /* count, equivalent stress of sigma [Pa]; NaN where J <= 0 */
  double *stretch;      /* count, least principal stretch [1]; below 0 where J < 0 */
} thrum_stress_points_output;

/* Bytes of a set of stress points of this model, into *size. THRUM_INVALID_ARGUMENT for NULL or a
 * tetrahedron out of range, THRUM_MISSING for a model without a mesh and a basis, THRUM_UNSUPPORTED
 * for one of elements that are no tetrahedra. */
THRUM_API thrum_status thrum_stress_points_size(const thrum_model *model,
                                                const thrum_stress_points_def *def, size_t *size,
                                                thrum_error *error);

/* Lays the stress points into `memory`, aligned to 64 bytes and of at least
 * thrum_stress_points_size bytes. The caller owns the memory and frees it when done; *stress_points
 * points into it. THRUM_BAD_VALUE for a tetrahedron without a positive volume, THRUM_MISALIGNED,
 * THRUM_BUFFER_TOO_SMALL, or the failures of thrum_stress_points_size. */
THRUM_API thrum_status thrum_stress_points_init(void *memory, size_t memory_size,
                                                const thrum_model *model,
                                                const thrum_stress_points_def *def,
                                                const thrum_stress_points **stress_points,
                                                thrum_error *error);

/* Number of tetrahedra of a set; 0 for NULL. */
THRUM_API int64_t thrum_stress_points_count(const thrum_stress_points *stress_points);

/* The model's tetrahedron (0-based) at place n of the output, 0 <= n < count. */
THRUM_API int32_t thrum_stress_points_tet(const thrum_stress_points *stress_points, int64_t n);

/* Number of doubles in the workspace of thrum_stress_points_read. */
THRUM_API int64_t thrum_stress_points_work_count(const thrum_stress_points *stress_points);

/* Evaluates all stress points at q (rank). `work`: thrum_stress_points_work_count doubles, not
 * shared between threads; NULL: the same bits without a workspace, up to eight times slower for
 * stress points on all tetrahedra. Values that overflow are infinite or NaN. THRUM_BAD_VALUE where
 * q is not finite, THRUM_INVALID_ARGUMENT for NULL or stress points that init did not make. */
THRUM_API thrum_status thrum_stress_points_read(const thrum_stress_points *stress_points,
                                                const double *q, double *work,
                                                const thrum_stress_points_output *output,
                                                thrum_error *error);

/* Opaque: Cauchy stress at the nodes of a mesh, one tensor for each vertex and each region that
 * meets there. In a ten-node tetrahedron the stress at the four points of quadrature is
 * extrapolated to its nodes; a node has the mean of the tetrahedra of one region around it,
 * weighted by their volumes, so that a jump between two regions stays. In linear tetrahedra the
 * mean of their constant stresses is the average of a patch, and lags behind the stress at a
 * surface. */
typedef struct thrum_stress_nodes thrum_stress_nodes;

/* Bytes of the nodes of this model, into *size. THRUM_MISSING for a model without a mesh,
 * THRUM_UNSUPPORTED for one of solids, whose strains are not those of its tetrahedra. */
THRUM_API thrum_status thrum_stress_nodes_size(const thrum_model *model, size_t *size,
                                               thrum_error *error);

/* Lays the nodes into `memory`, aligned to 64 and of at least thrum_stress_nodes_size bytes, which
 * the caller owns. The model must stay. THRUM_BAD_VALUE for a tetrahedron without a positive
 * volume, THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, or the failures of thrum_stress_nodes_size. */
THRUM_API thrum_status thrum_stress_nodes_init(void *memory, size_t memory_size,
                                               const thrum_model *model,
                                               const thrum_stress_nodes **nodes,
                                               thrum_error *error);

/* Number of pairs of a vertex and a region, by vertex and then by region; 0 for NULL. */
THRUM_API int64_t thrum_stress_nodes_count(const thrum_stress_nodes *nodes);

/* Vertex and region (0-based) of place n of the output, 0 <= n < count. */
THRUM_API int32_t thrum_stress_nodes_vertex(const thrum_stress_nodes *nodes, int64_t n);
THRUM_API int32_t thrum_stress_nodes_region(const thrum_stress_nodes *nodes, int64_t n);

/* 1: stresses are extrapolated to the nodes; 0: they are averages of patches of linear tetrahedra,
 * or nodes is NULL. */
THRUM_API int32_t thrum_stress_nodes_extrapolated(const thrum_stress_nodes *nodes);

/* Cauchy stress (count x 6, xx, yy, zz, xy, yz, xz [Pa]) and von Mises' equivalent of it (count
 * [Pa], may be NULL) at displacements u of all vertices (3 vertex_count [m], as thrum_displacement
 * gives them). NaN next to a tetrahedron that is turned inside out. THRUM_BAD_VALUE where u is not
 * finite, THRUM_INVALID_ARGUMENT for NULL or nodes that init did not make. Allocates nothing. */
THRUM_API thrum_status thrum_stress_nodes_read(const thrum_stress_nodes *nodes, const double *u,
                                               double *cauchy, double *von_mises,
                                               thrum_error *error);

/* Von Mises' equivalent stress of one stress tensor of six numbers, in its unit: 0 for a pressure,
 * |s| for a uniaxial stress s, sqrt(3) |t| for a pure shear t. Any thread. */
THRUM_API double thrum_von_mises(const double stress[6]);

#ifdef __cplusplus
}
#endif
#endif
