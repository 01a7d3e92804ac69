/* A body whose basis vectors are the nine linear displacement fields u = H X: q is H, row by row,
 * and the displacement gradient is H in every tetrahedron. It serves tests of measurements on a
 * mesh. Header only; needs cmocka. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_LINEAR_FIELDS_H
#define THRUM_TESTS_SUPPORT_LINEAR_FIELDS_H

#include "tests/support/precompute_support.h"
#include "thrum/thrum.h"

#define FIELDS 9

typedef struct linear_fields {
  body body;
  thrum_model model; /* no polynomial: nothing steps it */
  double *basis;
  double material[3];
} linear_fields;

/* |x - y| <= tolerance, absolute. */
static inline void assert_within(double x, double y, double tolerance) {
  if (!(fabs(x - y) <= tolerance))
    fail_msg("%.17g is not %.17g: distance %.3g exceeds %.3g", x, y, fabs(x - y), tolerance);
}

/* Nothing is fixed. */
static inline void linear_fields_make(linear_fields *out, const char *mesh, double young,
                                      double poisson) {
  memset(out, 0, sizeof *out);
  out->body = body_make(mesh, NULL);
  const thrum_mesh *m = &out->body.mesh;
  out->basis = need((size_t)(3 * m->vertex_count * FIELDS), sizeof *out->basis);

  // column 3 i + j is the field u_i = x_j, all of a constant gradient
  for (int64_t v = 0; v < m->vertex_count; v++)
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        out->basis[(3 * v + i) * FIELDS + 3 * i + j] = m->vertices[3 * v + j];

  // one material, that of the call
  out->material[0] = young;
  out->material[1] = poisson;
  out->material[2] = m->materials[0].density;
  out->model = (thrum_model){.rank = FIELDS,
                             .vertex_count = m->vertex_count,
                             .tet_count = m->tet_count,
                             .region_count = 1,
                             .vertices = m->vertices,
                             .tets = m->tets,
                             .tet_region = m->tet_region,
                             .material = out->material,
                             .fixed = out->body.fixed,
                             .basis = out->basis};
}

static inline void linear_fields_free(linear_fields *fields) {
  free(fields->basis);
  body_free(&fields->body);
}

/* Stress points in a block of exactly their size, so that a sanitizer sees an access beyond it. */
static inline const thrum_stress_points *stress_points_make(const thrum_model *model,
                                                            const int32_t *tets, int64_t count) {
  const thrum_stress_points_def def = {tets, count};
  size_t size = 0;
  thrum_error error = {0};
  if (thrum_stress_points_size(model, &def, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  const thrum_stress_points *stress_points = NULL;
  if (thrum_stress_points_init(memory, size, model, &def, &stress_points, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return stress_points;
}

static inline void stress_points_free(const thrum_stress_points *stress_points) {
  free((void *)(uintptr_t)stress_points);
}

#endif
