/* Surface tractions: their sum, the place where they act, and a bar pulled at its end against the
 * closed form. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "precompute/full/full.h"
#include "precompute/model/traction.h"
#include "tests/support/mesh_model.h"

typedef struct body {
  thrum_mesh mesh;
  uint8_t *fixed;
  thrum_model model;
} body;

static const double material[3] = {1e6, 0.3, 1000};

static void body_make(body *b, const char *spec) {
  memset(b, 0, sizeof *b);
  assert_int_equal(thrum_mesh_read(spec, 1, &b->mesh, NULL), THRUM_OK);
  b->fixed = calloc((size_t)b->mesh.vertex_count, 1);
  assert_non_null(b->fixed);
  b->model = mesh_model(&b->mesh, material, b->fixed);
}

static void body_free(body *b) {
  thrum_mesh_free(&b->mesh);
  free(b->fixed);
}

/* The vertices at the far end. */
static int64_t list_end(const body *b, int32_t *list) {
  int64_t count = 0;
  for (int64_t v = 0; v < b->mesh.vertex_count; v++)
    if (b->mesh.vertices[3 * v] > 1 - 1e-9)
      list[count++] = (int32_t)v;
  return count;
}

static void a_traction_sums_to_its_area_times_itself(void **state) {
  (void)state;
  static const double traction[3] = {3, -2, 7};
  body b;
  body_make(&b, "beam:5x3x2@1x0.3x0.2");
  const int64_t n = b.mesh.vertex_count;
  assert_true(n > 0);

  // a traction on the end face
  double *forces = calloc((size_t)n, 3 * sizeof *forces), area = 0;
  int32_t *list = calloc((size_t)n, sizeof *list);
  const int64_t count = list_end(&b, list);
  assert_int_equal(thrum_traction_fill(&b.model, list, count, traction, forces, &area, NULL), 0);
  assert_true(fabs(area - 0.06) <= 1e-15);

  // it acts there alone, and its resultant is area times traction
  double sum[3] = {0, 0, 0}, moment = 0;
  for (int64_t v = 0; v < n; v++)
    for (int c = 0; c < 3; c++) {
      assert_true(b.mesh.vertices[3 * v] > 1 - 1e-9 || forces[3 * v + c] == 0);
      sum[c] += forces[3 * v + c];
      moment += c == 0 ? forces[3 * v] * b.mesh.vertices[3 * v + 1] : 0;
    }
  for (int c = 0; c < 3; c++)
    assert_true(fabs(sum[c] - 0.06 * traction[c]) <= 1e-14);

  // the resultant acts through the centre of the face
  assert_true(fabs(moment) <= 1e-15);

  // without a list of vertices the traction acts on the whole surface
  memset(forces, 0, 3 * (size_t)n * sizeof *forces);
  assert_int_equal(thrum_traction_fill(&b.model, NULL, 0, traction, forces, &area, NULL), 0);
  assert_true(fabs(area - 2 * (0.3 * 0.2 + 0.3 + 0.2)) <= 1e-13);

  // two vertices span no triangle
  assert_int_equal(thrum_traction_fill(&b.model, list, 2, traction, forces, &area, NULL),
                   THRUM_INVALID_ARGUMENT);

  free(forces);
  free(list);
  body_free(&b);
}

/* A bar that is pulled at its end by s and free to contract sideways stretches by F with
 * s = F S(F), where S = E/2 (F^2 - 1), and so does each of its sections. */
static void a_pulled_bar_stretches_as_the_material_says(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:4x2x2@1x0.3x0.3");
  const int64_t n = b.mesh.vertex_count;
  assert_true(n > 0);

  // supports that let the bar contract: x held at the end, y and z in planes through the axis
  for (int64_t v = 0; v < n; v++) {
    const double *x = b.mesh.vertices + 3 * v;
    b.fixed[v] = (uint8_t)((x[0] < 1e-9 ? 1 : 0) | (fabs(x[1]) < 1e-9 ? 2 : 0) |
                           (fabs(x[2]) < 1e-9 ? 4 : 0));
  }

  // the traction of a stretch of 1.2
  const double stretch = 1.2,
               pull[3] = {stretch * 0.5 * material[0] * (stretch * stretch - 1), 0, 0};
  double *forces = calloc((size_t)n, 3 * sizeof *forces), *u = calloc((size_t)n, 3 * sizeof *u);
  int32_t *list = calloc((size_t)n, sizeof *list);
  const int64_t count = list_end(&b, list);
  assert_int_equal(thrum_traction_fill(&b.model, list, count, pull, forces, NULL, NULL), 0);

  // the full-order equilibrium under it
  const thrum_full_def def = thrum_default_full_def();
  thrum_full *full = NULL;
  thrum_full_equilibrium found;
  assert_int_equal(thrum_full_create(&b.model, NULL, &def, &full, NULL), 0);
  assert_int_equal(thrum_full_rest(full, forces, NULL, &found, NULL), 0);
  thrum_full_get(full, u, NULL);

  // E_yy = -nu E_xx gives the contraction
  const double thin = sqrt(1 - 0.3 * (stretch * stretch - 1));
  for (int64_t v = 0; v < n; v++) {
    const double *x = b.mesh.vertices + 3 * v;
    assert_true(fabs(u[3 * v] - (stretch - 1) * x[0]) <= 1e-9);
    assert_true(fabs(u[3 * v + 1] - (thin - 1) * x[1]) <= 1e-9);
  }

  thrum_full_free(full);
  free(forces);
  free(u);
  free(list);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_traction_sums_to_its_area_times_itself),
      cmocka_unit_test(a_pulled_bar_stretches_as_the_material_says),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
