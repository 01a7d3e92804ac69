/* Strain and stress in chosen tetrahedra, or all of them, straight from q.
 *
 * A linear tetrahedron has one displacement gradient, G(q) = sum_i q_i G_i, so its Green strain
 *   E(q) = 1/2 (G + G^T + G^T G)
 * is a quadratic polynomial of q, evaluated exactly (to rounding): what the model steps and what is
 * recovered here is the same body. Second Piola-Kirchhoff S = lambda tr(E) 1 + 2 mu E; with
 * F = 1 + G and J = det F the Cauchy stress is sigma = F S F^T / J, force over present area, and
 * von Mises' equivalent stress is taken of sigma.
 *
 * A set of stress points is planned (thrum_stress_points_size), then laid into the caller's memory
 * (thrum_stress_points_init); afterwards it needs the model no longer, is immutable and may be
 * shared by any number of threads. Nothing is allocated.
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

/* Where stress points sit. Only read while stress points are planned and made. */
typedef struct thrum_stress_points_def {
  const int32_t *tets; /* 0-based tetrahedra of the model in the order of the output; NULL: all */
  int64_t tet_count;   /* of `tets`; ignored when that is NULL */
} thrum_stress_points_def;

/* Opaque: lives at the start of the memory given to thrum_stress_points_init. */
typedef struct thrum_stress_points thrum_stress_points;

/* What to write; NULL: not wanted. Symmetric tensors are six numbers xx, yy, zz, xy, yz, xz, not
 * doubled off the diagonal. */
typedef struct thrum_stress_points_output {
  double *strain;       /* count x 6, Green strain E */
  double *second_piola; /* count x 6, S [Pa] */
  double *cauchy;       /* count x 6, sigma [Pa]; NaN where J <= 0: the tet is inverted */
  double *von_mises;    /* count, of sigma [Pa]; NaN where J <= 0 */
  double *stretch;      /* count, least principal stretch; below 0 where J < 0 */
} thrum_stress_points_output;

/* Bytes of a set of stress points. Needs a model with a mesh and a basis (THRUM_MISSING otherwise);
 * checks the def. */
THRUM_API thrum_status thrum_stress_points_size(const thrum_model *model,
                                                const thrum_stress_points_def *def, size_t *size,
                                                thrum_error *error);

/* Lays the stress points into `memory`, aligned to 64, at least thrum_stress_points_size bytes,
 * which the caller owns. THRUM_BAD_VALUE for a tetrahedron without a positive volume. */
THRUM_API thrum_status thrum_stress_points_init(void *memory, size_t memory_size,
                                                const thrum_model *model,
                                                const thrum_stress_points_def *def,
                                                const thrum_stress_points **stress_points,
                                                thrum_error *error);

/* Tetrahedra of a set; 0 for NULL. */
THRUM_API int64_t thrum_stress_points_count(const thrum_stress_points *stress_points);

/* The model's tetrahedron (0-based) of place n, 0 <= n < count. */
THRUM_API int32_t thrum_stress_points_tet(const thrum_stress_points *stress_points, int64_t n);

/* Doubles of workspace of thrum_stress_points_read. */
THRUM_API int64_t thrum_stress_points_work_count(const thrum_stress_points *stress_points);

/* Reads all stress points at q (rank). `work`: thrum_stress_points_work_count doubles, not shared
 * between threads; NULL: the same bits without a workspace, up to eight times slower for stress
 * points on all tets. THRUM_BAD_VALUE when q is not finite. Values that overflow are infinite or
 * NaN. */
THRUM_API thrum_status thrum_stress_points_read(const thrum_stress_points *stress_points,
                                                const double *q, double *work,
                                                const thrum_stress_points_output *output,
                                                thrum_error *error);

/* Von Mises' equivalent stress of one stress tensor of six numbers, in its unit: 0 of a pressure,
 * |s| of a uniaxial s, sqrt(3) |t| of a pure shear t. */
THRUM_API double thrum_von_mises(const double stress[6]);

#ifdef __cplusplus
}
#endif
#endif
