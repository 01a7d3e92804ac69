/* Tests of scaled models: they agree with the model of the scaled mesh in the squared frequencies,
 * the energy at the same displacement, the reduced gravity and the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_fix.h"
#include "thrum/external_load.h"
#include "thrum/polynomial.h"

// three different sides, so that no frequency is repeated and the basis is unique
#define MESH "beam:8x2x1@1x0.2x0.13"

static void *scale_model(const thrum_model *model, const thrum_model_scaling *by,
                         const thrum_model **scaled) {
  size_t size = 0;
  thrum_error error;
  if (thrum_model_scale_size(model, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  size = (size + 63) / 64 * 64;
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  if (thrum_model_scale(memory, size, model, by, scaled, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return memory;
}

/* Makes the body of MESH with its lengths, stiffness and density multiplied. */
static thrum_precomputed precompute_scaled(const thrum_model_scaling *by, body *made,
                                           const char *fix) {
  thrum_error error = {0};
  *made = (body){0};
  if (thrum_mesh_read(MESH, by->length, &made->mesh, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  for (int64_t n = 0; n < made->mesh.region_count; n++) {
    made->mesh.materials[n].young *= by->stiffness;
    made->mesh.materials[n].density *= by->density;
  }
  made->fixed = need((size_t)made->mesh.vertex_count, 1);
  int64_t count;
  if (fix && thrum_mesh_fix(&made->mesh, fix, made->fixed, &count, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return body_precompute(made, 5, 12);
}

/* Compares the energies of two models at the same displacement field in the span of both bases. */
static void compare_energies(const thrum_model *scaled, const thrum_model *anew) {
  const int64_t r = anew->rank, n = 3 * anew->vertex_count;
  double *work = need(thrum_work_count(anew), sizeof *work);
  double *q = random_vector(r, 0.01), *turned = need((size_t)r, sizeof *turned);

  for (int64_t i = 0; i < r; i++) {
    // the basis vectors are the same up to their sign
    double dot = 0, square = 0;
    for (int64_t c = 0; c < n; c++) {
      dot += scaled->basis[c * r + i] * anew->basis[c * r + i];
      square += anew->basis[c * r + i] * anew->basis[c * r + i];
    }
    assert_close(fabs(dot), square, 1e-6);

    // the axis masses follow the sign of the basis vector
    turned[i] = copysign(q[i], q[i] * dot);
    for (int axis = 0; axis < 3 && anew->axis_mass; axis++)
      assert_true(
          fabs(copysign(1, dot) * scaled->axis_mass[axis * r + i] - anew->axis_mass[axis * r + i]) <
          1e-6 * norm_of(anew->axis_mass, 3 * r) + 1e-9);
  }

  assert_close(thrum_strain_energy(scaled, turned, work), thrum_strain_energy(anew, q, work), 1e-6);
  free(turned);
  free(q);
  free(work);
}

static void check_scaling(const thrum_model_scaling *by, const char *fix) {
  body small, large;

  // the model of the small body, and that of the scaled mesh
  const thrum_model_scaling one = {1, 1, 1};
  char fix_large[32];
  if (fix)
    snprintf(fix_large, sizeof fix_large, "x<%g", 0.01 * by->length);
  thrum_precomputed given = precompute_scaled(&one, &small, fix);
  thrum_precomputed anew = precompute_scaled(by, &large, fix ? fix_large : NULL);

  // the scaled model has the numbers of the other
  const thrum_model *scaled = NULL;
  void *memory = scale_model(&given.model, by, &scaled);
  assert_int_equal(thrum_model_check(scaled, NULL), THRUM_OK);
  assert_near(scaled->omega2, anew.model.omega2, scaled->rank, 1e-6);
  assert_near(scaled->vertices, anew.model.vertices, 3 * scaled->vertex_count, 1e-14);
  assert_near(scaled->material, anew.model.material, 3 * scaled->region_count, 1e-14);
  compare_energies(scaled, &anew.model);

  if (fix == NULL)
    // the first rigid modes are translations: 1 / sqrt(mass)
    assert_close(fabs(scaled->rigid[0]), fabs(anew.model.rigid[0]), 1e-10);

  free(memory);
  thrum_precomputed_free(&given);
  thrum_precomputed_free(&anew);
  body_free(&small);
  body_free(&large);
}

static void a_scaled_model_is_that_of_the_scaled_mesh(void **context) {
  (void)context;
  check_scaling(&(thrum_model_scaling){2, 1, 1}, "x<0.01");
  check_scaling(&(thrum_model_scaling){1, 3, 1}, "x<0.01");
  check_scaling(&(thrum_model_scaling){1, 1, 5}, "x<0.01");
  check_scaling(&(thrum_model_scaling){0.3, 7, 0.2}, "x<0.01");
}

static void a_free_body_is_scaled_with_its_rigid_modes(void **context) {
  (void)context;
  check_scaling(&(thrum_model_scaling){3, 0.5, 2}, NULL);
}

static void a_scale_of_one_keeps_every_bit(void **context) {
  (void)context;

  // a model of a held body, scaled by one
  body small;
  const thrum_model_scaling one = {1, 1, 1};
  thrum_precomputed given = precompute_scaled(&one, &small, "x<0.01");
  const thrum_model *m = &given.model, *scaled = NULL;
  void *memory = scale_model(m, &one, &scaled);

  // every array is equal
  const size_t r = (size_t)m->rank, d = sizeof(double);
  assert_memory_equal(scaled->omega2, m->omega2, r * d);
  assert_memory_equal(scaled->c3, m->c3, (size_t)m->c3_count * d);
  assert_memory_equal(scaled->c4, m->c4, (size_t)m->c4_count * d);
  assert_memory_equal(scaled->basis, m->basis, 3 * (size_t)m->vertex_count * r * d);
  assert_memory_equal(scaled->axis_mass, m->axis_mass, 3 * r * d);

  // so it is the same model for a state; another scale makes another one
  const thrum_model_scaling stiffer = {1, 1.5, 1};
  const thrum_model *other = NULL;
  void *stiff = scale_model(m, &stiffer, &other);
  assert_true(scaled->identity == thrum_model_identity(m));
  assert_true(other->identity == thrum_model_identity(other));
  assert_true(other->identity != scaled->identity);
  free(stiff);

  // the copy is packed for itself
  assert_true(scaled->packed != NULL || scaled->packed_single != NULL);
  assert_ptr_equal(scaled->packed_c4, scaled->c4);

  free(memory);
  thrum_precomputed_free(&given);
  body_free(&small);
}

static void bad_scales_are_refused(void **context) {
  (void)context;

  // a model of one coordinate without a mesh
  static const double zero[1] = {0}, one[1] = {1};
  static const int32_t format[2] = {1, 0};
  const thrum_model m = {.rank = 1,
                         .c3_count = 1,
                         .c4_count = 1,
                         .format = format,
                         .omega2 = one,
                         .c3 = zero,
                         .c4 = one};

  // factors that are not positive or not finite, or whose products overflow
  const thrum_model_scaling bad[] = {{0, 1, 1},     {-1, 1, 1},        {1, 0, 1},
                                     {1, 1, 0},     {NAN, 1, 1},       {1, INFINITY, 1},
                                     {1e-80, 1, 1}, {1e-60, 1, 1e-60}, {1, 1e300, 1e-300}};

  // one block serves all calls, since the size does not depend on the factors
  size_t size = 0;
  assert_int_equal(thrum_model_scale_size(&m, &size, NULL), THRUM_OK);
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  const thrum_model *scaled = NULL;
  for (size_t n = 0; n < sizeof bad / sizeof bad[0]; n++)
    assert_true(thrum_model_scale(memory, size, &m, &bad[n], &scaled, NULL) < 0);

  // memory that is too small or misaligned, and a missing model
  const thrum_model_scaling good = {1, 1, 1};
  assert_int_equal(thrum_model_scale(memory, size - 1, &m, &good, &scaled, NULL),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_model_scale((char *)memory + 8, size, &m, &good, &scaled, NULL),
                   THRUM_MISALIGNED);
  assert_int_equal(thrum_model_scale(memory, size, NULL, &good, &scaled, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_null(scaled);

  free(memory);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_scaled_model_is_that_of_the_scaled_mesh),
      cmocka_unit_test(a_free_body_is_scaled_with_its_rigid_modes),
      cmocka_unit_test(a_scale_of_one_keeps_every_bit),
      cmocka_unit_test(bad_scales_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
