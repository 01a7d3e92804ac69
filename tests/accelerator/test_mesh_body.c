/* Tests of a whole mesh on a device: against the full-order body, for both kinds of tetrahedra and
 * both laws; implicit Euler by its own equation; what is refused. They need a driver of OpenCL.
 * SPDX-License-Identifier: Apache-2.0 */
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
#include "mesh/midsides.h"
#include "precompute/fem/fem.h"
#include "precompute/full/full.h"
#include "tests/support/mesh_model.h"
#include "thrum/accelerator.h"

/* A model that is a mesh of rubber, held at x = 0; two vectors for each vertex. */
typedef struct body {
  thrum_mesh mesh;
  uint8_t *fixed;
  double material[3];
  thrum_model model;
  double *load, *here, *there;
} body;

static void body_make(body *b, bool quadratic) {
  thrum_error error;
  memset(b, 0, sizeof *b);
  if (thrum_mesh_read("beam:4x2x2@0.4x0.1x0.1", 1, &b->mesh, &error) < 0 ||
      (quadratic && thrum_midsides_add(&b->mesh, &error) < 0))
    fail_msg("%s", error.message);
  const size_t vertices = (size_t)b->mesh.vertex_count;
  b->fixed = calloc(vertices, 1);
  b->load = calloc(3 * vertices, sizeof *b->load);
  b->here = calloc(3 * vertices, sizeof *b->here);
  b->there = calloc(3 * vertices, sizeof *b->there);
  assert_true(b->fixed && b->load && b->here && b->there);

  // bent down at once, far beyond what is linear
  for (size_t v = 0; v < vertices; v++) {
    b->fixed[v] = b->mesh.vertices[3 * v] < 1e-9 ? 7 : 0;
    b->load[3 * v + 2] = -60.0 / (double)vertices;
    b->load[3 * v + 1] = 9.0 / (double)vertices;
  }
  memcpy(b->material, (const double[3]){1e5, 0.3, 1000}, sizeof b->material);
  b->model = mesh_model(&b->mesh, b->material, b->fixed);
}

static void body_free(body *b) {
  thrum_mesh_free(&b->mesh);
  free(b->fixed);
  free(b->load);
  free(b->here);
  free(b->there);
}

static thrum_accelerator *take_device(int32_t single) {
  thrum_accelerator_def def = thrum_default_accelerator_def();
  def.single = single;
  thrum_accelerator *accelerator;
  assert_int_equal(thrum_accelerator_create(&def, &accelerator, NULL), THRUM_OK);
  return accelerator;
}

static thrum_mesh_body *make_there(thrum_accelerator *accelerator, const body *b,
                                   const thrum_mesh_body_def *def) {
  thrum_mesh_body *there;
  thrum_error error;
  if (thrum_mesh_body_create(accelerator, &b->model, def, &there, &error) != THRUM_OK ||
      thrum_mesh_body_set_forces(there, b->load, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return there;
}

static void step_there(thrum_accelerator *accelerator, body *b, const thrum_mesh_body_def *def,
                       int64_t steps) {
  thrum_mesh_body *there = make_there(accelerator, b, def);
  thrum_error error;
  if (thrum_mesh_body_step(there, steps, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_int_equal(thrum_mesh_body_get(there, b->there, NULL, NULL), THRUM_OK);
  thrum_mesh_body_report report;
  assert_int_equal(thrum_mesh_body_get_report(there, &report, NULL), THRUM_OK);
  assert_true(report.steps == steps && report.iterations >= steps);
  assert_true(report.solver_iterations > report.iterations);
  thrum_mesh_body_destroy(there);
}

/* Largest difference over the largest displacement, which is a fifth of the length or more. */
static double differ(const body *b) {
  double most = 0, all = 0;
  for (int64_t i = 0; i < 3 * b->mesh.vertex_count; i++) {
    most = fmax(most, fabs(b->here[i] - b->there[i]));
    all = fmax(all, fabs(b->here[i]));
  }
  assert_true(all > 0.08);
  return most / all;
}

static void test_midpoint_is_that_of_the_full_order(void **unused) {
  (void)unused;
  enum { STEPS = 12 };
  const thrum_law laws[] = {THRUM_LAW_STVK, THRUM_LAW_NEO_HOOKEAN};
  const thrum_mesh_law there[] = {THRUM_MESH_STVK, THRUM_MESH_NEO_HOOKEAN};
  thrum_accelerator *const accelerator = take_device(0);
  for (int k = 0; k < 4; k++) {
    body b;
    body_make(&b, k >= 2);
    thrum_full_def full_def = thrum_default_full_def();
    full_def.scheme = THRUM_FULL_MIDPOINT;
    full_def.dt = 0.01;
    full_def.damping_alpha = 2;
    full_def.law = laws[k % 2];
    thrum_full *full;
    assert_int_equal(thrum_full_create(&b.model, NULL, &full_def, &full, NULL), THRUM_OK);
    assert_int_equal(thrum_full_set_force(full, b.load, NULL), THRUM_OK);
    for (int n = 0; n < STEPS; n++)
      assert_int_equal(thrum_full_step(full, NULL), THRUM_OK);
    thrum_full_get(full, b.here, NULL);
    thrum_full_free(full);

    thrum_mesh_body_def def = thrum_default_mesh_body_def();
    def.dt = 0.01;
    def.damping = 2;
    def.law = there[k % 2];
    step_there(accelerator, &b, &def, STEPS);
    const double off = differ(&b);
    assert_true(off < 1e-10);
    body_free(&b);
  }
  thrum_accelerator_destroy(accelerator);
}

/* A step of implicit Euler satisfies its equation, of which all else is the full-order body's. */
static void test_implicit_euler_satisfies_its_equation(void **unused) {
  (void)unused;
  const double h = 0.02;
  thrum_accelerator *const accelerator = take_device(0);
  body b;
  body_make(&b, false);
  const int64_t count = 3 * b.mesh.vertex_count;
  double *const before = calloc((size_t)count, sizeof *before);
  double *const speed = calloc((size_t)count, sizeof *speed);
  assert_true(before && speed);
  thrum_mesh_body_def def = thrum_default_mesh_body_def();
  def.scheme = THRUM_MESH_IMPLICIT_EULER;
  def.dt = h;
  thrum_mesh_body *there = make_there(accelerator, &b, &def);
  assert_int_equal(thrum_mesh_body_step(there, 5, NULL), THRUM_OK);
  assert_int_equal(thrum_mesh_body_get(there, before, speed, NULL), THRUM_OK);
  assert_int_equal(thrum_mesh_body_step(there, 1, NULL), THRUM_OK);
  assert_int_equal(thrum_mesh_body_get(there, b.there, b.here, NULL), THRUM_OK);
  thrum_mesh_body_destroy(there);

  // v' = d/h, and M (d - h v)/h^2 + R(u') - f = 0 on what is free
  thrum_material material = {.young = 1e5, .poisson = 0.3, .density = 1000};
  b.mesh.materials = &material;
  b.mesh.region_count = 1;
  thrum_fem fem;
  thrum_sparse pattern, mass;
  thrum_error error;
  if (thrum_fem_create(&b.mesh, b.fixed, &fem, &error) < 0 ||
      thrum_fem_pattern(&fem, &pattern, &error) < 0 ||
      thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &pattern, &mass, &error) < 0)
    fail_msg("%s", error.message);
  double *const force = calloc((size_t)count, sizeof *force);
  double *const push = calloc((size_t)count, sizeof *push);
  double *const image = calloc((size_t)count, sizeof *image);
  assert_true(force && push && image);
  thrum_fem_energy(&fem, b.there, force);
  for (int64_t i = 0; i < fem.free_count; i++) {
    const int32_t c = fem.component[i];
    const double d = b.there[c] - before[c];
    assert_true(fabs(b.here[c] - d / h) < 1e-12);
    push[i] = (d - h * speed[c]) / (h * h);
  }
  thrum_sparse_product(&mass, push, 1, image);
  double off = 0, all = 0;
  for (int64_t i = 0; i < fem.free_count; i++) {
    const int32_t c = fem.component[i];
    off = fmax(off, fabs(image[i] + force[c] - b.load[c]));
    all = fmax(all, fabs(force[c]));
  }
  assert_true(off < 1e-8 * all);
  free(force);
  free(push);
  free(image);
  free(before);
  free(speed);
  thrum_sparse_free(&pattern);
  thrum_sparse_free(&mass);
  thrum_fem_free(&fem);
  b.mesh.materials = NULL;
  body_free(&b);
  thrum_accelerator_destroy(accelerator);
}

/* The same bits in each run; in single precision about five digits. */
static void test_bits_and_single(void **unused) {
  (void)unused;
  enum { STEPS = 12 };
  body b;
  body_make(&b, false);
  thrum_accelerator *accelerator = take_device(0);
  thrum_mesh_body_def def = thrum_default_mesh_body_def();
  def.dt = 0.01;
  step_there(accelerator, &b, &def, STEPS);
  memcpy(b.here, b.there, 3 * (size_t)b.mesh.vertex_count * sizeof *b.here);
  step_there(accelerator, &b, &def, STEPS);
  assert_memory_equal(b.here, b.there, 3 * (size_t)b.mesh.vertex_count * sizeof *b.here);
  thrum_accelerator_destroy(accelerator);

  accelerator = take_device(1);
  step_there(accelerator, &b, &def, STEPS);
  const double off = differ(&b);
  assert_true(off < 1e-3 && off > 1e-9);
  body_free(&b);
  thrum_accelerator_destroy(accelerator);
}

/* What is not solved leaves the body where it was. */
static void test_what_is_not_solved_stays(void **unused) {
  (void)unused;
  thrum_accelerator *const accelerator = take_device(0);
  body b;
  body_make(&b, false);
  const size_t bytes = 3 * (size_t)b.mesh.vertex_count * sizeof(double);
  thrum_mesh_body_def def = thrum_default_mesh_body_def();
  def.dt = 0.01;
  def.iterations = 1;
  thrum_mesh_body *there = make_there(accelerator, &b, &def);
  thrum_error error;
  assert_int_equal(thrum_mesh_body_step(there, 1, &error), THRUM_NOT_CONVERGED);
  assert_non_null(strstr(error.message, "step 1 is not solved after 1 iterations"));
  assert_int_equal(thrum_mesh_body_get(there, b.there, b.here, NULL), THRUM_OK);
  for (int64_t i = 0; i < 3 * b.mesh.vertex_count; i++)
    assert_true(b.there[i] == 0 && b.here[i] == 0);

  // corrections of which each is a part of the one that is needed are small, and solve nothing
  thrum_mesh_body_destroy(there);
  def.iterations = 12;
  def.solver_iterations = 2;
  def.tolerance = 0.5;
  there = make_there(accelerator, &b, &def);
  assert_int_equal(thrum_mesh_body_step(there, 1, &error), THRUM_NOT_CONVERGED);
  assert_non_null(strstr(error.message, "more solver_iterations"));

  // what is held is not moved, and what is refused sets nothing
  for (int64_t i = 0; i < 3 * b.mesh.vertex_count; i++)
    b.here[i] = 1e-3;
  assert_int_equal(thrum_mesh_body_set(there, b.here, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_mesh_body_get(there, b.there, NULL, NULL), THRUM_OK);
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    assert_true(b.there[3 * v] == (b.fixed[v] ? 0 : 1e-3));
  memcpy(b.load, b.there, bytes);
  b.here[5] = NAN;
  assert_int_equal(thrum_mesh_body_set(there, b.load, b.here, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "the velocity of vertex 1 is nan"));
  assert_int_equal(thrum_mesh_body_get(there, b.there, NULL, NULL), THRUM_OK);
  assert_memory_equal(b.there, b.load, bytes);
  thrum_mesh_body_destroy(there);
  thrum_mesh_body_destroy(NULL);
  body_free(&b);
  thrum_accelerator_destroy(accelerator);
}

/* A damped body comes to rest under its load, where increments are rounding, and stays solved; a
 * body whose forces are beyond the range of numbers is not. */
static void test_rest(void **unused) {
  (void)unused;
  for (int32_t single = 0; single < 2; single++) {
    thrum_accelerator *const accelerator = take_device(single);
    body b;
    body_make(&b, false);
    const int64_t count = 3 * b.mesh.vertex_count;
    thrum_mesh_body_def def = thrum_default_mesh_body_def();
    def.scheme = THRUM_MESH_IMPLICIT_EULER;
    def.dt = 0.1;
    def.damping = 5;
    thrum_mesh_body *there = make_there(accelerator, &b, &def);
    thrum_error error;
    if (thrum_mesh_body_step(there, 60, &error) != THRUM_OK)
      fail_msg("%s", error.message);
    assert_int_equal(thrum_mesh_body_get(there, b.there, b.here, NULL), THRUM_OK);
    for (int64_t i = 0; i < count; i++)
      assert_true(fabs(b.here[i]) < 1e-5 && fabs(b.there[i]) < 1);

    for (int64_t i = 0; i < count; i++)
      b.here[i] = (single ? 1e20 : 1e200) * (double)(i % 7);
    assert_int_equal(thrum_mesh_body_set(there, b.here, NULL, NULL), THRUM_OK);
    assert_int_equal(thrum_mesh_body_step(there, 1, &error), THRUM_NOT_CONVERGED);
    thrum_mesh_body_destroy(there);
    body_free(&b);
    thrum_accelerator_destroy(accelerator);
  }
}

static void refused(thrum_accelerator *accelerator, const thrum_model *model,
                    const thrum_mesh_body_def *def, thrum_status status, const char *part) {
  thrum_mesh_body *there = NULL;
  thrum_error error;
  assert_int_equal(thrum_mesh_body_create(accelerator, model, def, &there, &error), status);
  assert_null(there);
  if (!strstr(error.message, part))
    fail_msg("%s", error.message);
}

static void test_refusals(void **unused) {
  (void)unused;
  thrum_accelerator *const accelerator = take_device(0);
  body b;
  body_make(&b, true);
  thrum_mesh_body_def def = thrum_default_mesh_body_def();
  thrum_model empty = b.model;
  empty.tets = NULL;
  refused(accelerator, &empty, &def, THRUM_MISSING, "has no mesh");
  const double springs[] = {1};
  empty = b.model;
  empty.springs = springs;
  refused(accelerator, &empty, &def, THRUM_UNSUPPORTED, "springs");
  def.dt = 0;
  refused(accelerator, &b.model, &def, THRUM_INVALID_ARGUMENT, "dt is not above 0");
  def.dt = 0.01;
  def.solver_tolerance = 1;
  refused(accelerator, &b.model, &def, THRUM_INVALID_ARGUMENT, "solver_tolerance");
  def.solver_tolerance = 1e-3;
  def.law = (thrum_mesh_law)5;
  refused(accelerator, &b.model, &def, THRUM_INVALID_ARGUMENT, "law is neither");
  def = (thrum_mesh_body_def){0};
  refused(accelerator, &b.model, &def, THRUM_UNINITIALISED_DEF, "thrum_mesh_body_def_init");

  // the middle of an edge that is off it
  def = thrum_default_mesh_body_def();
  const int32_t middle = b.mesh.midsides[0];
  b.mesh.vertices[3 * (int64_t)middle + 2] += 1e-3;
  refused(accelerator, &b.model, &def, THRUM_UNSUPPORTED, "tetrahedron 1 has curved edges");
  body_free(&b);
  thrum_accelerator_destroy(accelerator);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_midpoint_is_that_of_the_full_order),
      cmocka_unit_test(test_implicit_euler_satisfies_its_equation),
      cmocka_unit_test(test_bits_and_single),
      cmocka_unit_test(test_what_is_not_solved_stays),
      cmocka_unit_test(test_rest),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
