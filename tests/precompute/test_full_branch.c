/* The branch of equilibria of the full order: columns and arches lose their stability where theory
 * and displacement control say so. SPDX-License-Identifier: Apache-2.0 */
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
#include "precompute/full/full.h"
#include "tests/support/mesh_model.h"
#include "thrum/thrum.h"

#define YOUNG 1e6
#define RISE 0.03

static const double tau = 6.28318530717958647693;

/* A beam of ten nodes along x, from 0 to 1, clamped at one end or at both, nu = 0. */
typedef struct beam {
  thrum_mesh mesh;
  uint8_t *fixed;
  double *forces, *moves; /* 3 vertex_count */
  double material[3];
  thrum_model model;
} beam;

static void beam_make(beam *b, const char *spec, bool arch) {
  thrum_error error;
  memset(b, 0, sizeof *b);
  if (thrum_mesh_read(spec, 1, &b->mesh, &error) < 0 || thrum_midsides_add(&b->mesh, &error) < 0)
    fail_msg("%s", error.message);
  const size_t count = (size_t)b->mesh.vertex_count;
  b->fixed = calloc(count, 1);
  b->forces = calloc(3 * count, sizeof *b->forces);
  b->moves = calloc(3 * count, sizeof *b->moves);
  assert_true(b->fixed != NULL && b->forces != NULL && b->moves != NULL);

  // an arch has the shape of a cosine and stays in its plane
  for (size_t v = 0; v < count; v++) {
    double *place = (double *)b->mesh.vertices + 3 * v;
    const bool end = place[0] < 1e-9 || (arch && place[0] > 1 - 1e-9);
    b->fixed[v] = end ? 7 : arch ? 2 : 0;
    if (arch)
      place[2] += RISE * (1 - cos(tau * place[0])) / 2;
  }

  b->material[0] = YOUNG;
  b->material[2] = 1000;
  b->model = mesh_model(&b->mesh, b->material, b->fixed);
}

static void beam_free(beam *b) {
  thrum_mesh_free(&b->mesh);
  free(b->fixed);
  free(b->forces);
  free(b->moves);
}

static thrum_full *full_make(const beam *b, const uint8_t *held, thrum_full_solver solver) {
  thrum_full *full = NULL;
  thrum_error error;
  thrum_full_def def = thrum_default_full_def();
  def.solver = solver;
  if (thrum_full_create(&b->model, held, &def, &full, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return full;
}

static thrum_full_equilibrium rest(thrum_full *full, const beam *b, bool moved) {
  thrum_full_equilibrium found;
  thrum_error error;
  const thrum_full_loading loading = {
      .forces = b->forces, .moves = moved ? b->moves : NULL, .watch = true};
  if (thrum_full_rest_under(full, &loading, &found, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_false(found.lost);
  return found;
}

/* `force` along x on the face at x = 1, shared equally. */
static void load_tip(beam *b, double force) {
  int64_t count = 0;
  for (int pass = 0; pass < 2; pass++)
    for (int64_t v = 0; v < b->mesh.vertex_count; v++) {
      const bool tip = b->mesh.vertices[3 * v] > 1 - 1e-9;
      count += pass == 0 && tip;
      if (pass == 1 && tip)
        b->forces[3 * v] = force / (double)count;
    }
}

/* Euler's pi^2 E I/(4 L^2), less what shear takes (Timoshenko & Gere 1961, 2.17), whatever the
 * load. */
static void a_column_buckles_under_eulers_load(void **state) {
  (void)state;
  beam b;
  beam_make(&b, "beam:8x1x1@1x0.05x0.05", false);
  const double euler = tau * tau / 4 * YOUNG * pow(0.05, 4) / 12 / 4;
  const double wanted = euler / (1 + 1.2 * euler / (YOUNG / 2 * 0.05 * 0.05));
  static const double loads[] = {1.02, 1.5};
  for (int n = 0; n < 2; n++) {
    thrum_full *full = full_make(&b, NULL, THRUM_FULL_CHOLESKY);
    load_tip(&b, -loads[n] * euler);
    const thrum_full_equilibrium found = rest(full, &b, false);

    // the load is between a stable equilibrium and what leads nowhere
    assert_int_equal(found.instability, THRUM_INSTABILITY_BIFURCATION);
    assert_true(fabs(found.critical * loads[n] * euler / wanted - 1) < 3e-3);
    assert_true(found.critical_from <= found.critical && found.critical <= found.critical_to);
    assert_true(found.critical_to - found.critical_from <= 1e-6 * found.critical_to);
    assert_true(found.critical_least > 0 && found.critical_least < 1e-2 * found.least_start);

    // and the body has fallen to a stable shape
    assert_true(found.jumps >= 1 && found.stable && found.least > 0);
    assert_true(found.energy + found.load_energy < 0);
    thrum_full_free(full);
  }
  beam_free(&b);
}

/* The squared frequency of a column falls with the load nearly in proportion, and rises where it is
 * pulled: it is concave in the load, as the least eigenvalue of a sum is. No such path is flagged.
 */
static void the_softest_vibration_falls_with_the_load(void **state) {
  (void)state;
  beam b;
  beam_make(&b, "beam:8x1x1@1x0.05x0.05", false);
  const double euler = tau * tau / 4 * YOUNG * pow(0.05, 4) / 12 / 4;
  static const double loads[] = {-0.5, -0.25, 0.25};
  for (int n = 0; n < 3; n++) {
    thrum_full *full = full_make(&b, NULL, n == 0 ? THRUM_FULL_CG : THRUM_FULL_CHOLESKY);
    load_tip(&b, loads[n] * euler);
    const thrum_full_equilibrium found = rest(full, &b, false);
    assert_int_equal(found.instability, THRUM_INSTABILITY_NONE);
    assert_true(isnan(found.critical) && found.jumps == 0 && found.stable);
    const double above = found.least / found.least_start - (1 + loads[n]);
    assert_true(loads[n] < 0 ? above > -2e-3 && above < 0.03 : above < 2e-3 && above > -0.03);
    thrum_full_free(full);
  }
  beam_free(&b);
}

static int64_t crown_of(const beam *b) {
  int64_t crown = -1;
  for (int64_t v = 0; v < b->mesh.vertex_count; v++) {
    const double *x = b->mesh.vertices + 3 * v;
    if (fabs(x[0] - 0.5) < 1e-9 && (crown < 0 || x[2] > b->mesh.vertices[3 * crown + 2] + 1e-12))
      crown = v;
  }
  return crown;
}

/* The force that holds the crown of an arch down has a maximum on the way, which is the load under
 * which it snaps through. */
static void an_arch_snaps_through_at_the_largest_force(void **state) {
  (void)state;
  beam b;
  beam_make(&b, "beam:16x1x1@1x0.02x0.02", true);
  const int64_t crown = crown_of(&b);
  double *forces = calloc(3 * (size_t)b.mesh.vertex_count, sizeof *forces);
  uint8_t *held = calloc((size_t)b.mesh.vertex_count, 1);
  assert_true(forces != NULL && held != NULL);

  // brought down in small steps, and a parabola through the largest three forces
  held[crown] = 4;
  thrum_full *full = full_make(&b, held, THRUM_FULL_CHOLESKY);
  double values[25] = {0}, largest = 0;
  int at = 0;
  for (int k = 1; k <= 24; k++) {
    b.moves[3 * crown + 2] = -RISE * k / 24;
    rest(full, &b, true);
    thrum_full_internal_forces(full, forces, NULL);
    values[k] = -forces[3 * crown + 2];
    at = values[k] > values[at] ? k : at;
  }
  assert_true(at > 1 && at < 24);
  const double slope = (values[at + 1] - values[at - 1]) / 2;
  const double curve = values[at + 1] - 2 * values[at] + values[at - 1];
  largest = values[at] - slope * slope / (2 * curve);
  thrum_full_free(full);

  // loaded beyond, it falls to the other side, also where a first step would end there by itself
  static const double beyond[] = {1.5, 10, 45, 200};
  double u[3];
  const int32_t one = (int32_t)crown;
  for (int n = 0; n < 4; n++) {
    full = full_make(&b, NULL, THRUM_FULL_CHOLESKY);
    b.forces[3 * crown + 2] = -beyond[n] * largest;
    const thrum_full_equilibrium found = rest(full, &b, false);
    assert_int_equal(found.instability, THRUM_INSTABILITY_LIMIT);
    assert_true(fabs(beyond[n] * found.critical - 1) < 1e-3);
    thrum_full_mean(full, &one, 1, u);
    assert_true(found.stable && found.jumps == 1 && u[2] < -1.5 * RISE);
    thrum_full_free(full);
  }

  // and just below it does not
  full = full_make(&b, NULL, THRUM_FULL_CHOLESKY);
  b.forces[3 * crown + 2] = -0.99 * largest;
  assert_int_equal(rest(full, &b, false).instability, THRUM_INSTABILITY_NONE);
  thrum_full_mean(full, &one, 1, u);
  assert_true(u[2] > -RISE);
  thrum_full_free(full);
  free(forces);
  free(held);
  beam_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_column_buckles_under_eulers_load),
      cmocka_unit_test(the_softest_vibration_falls_with_the_load),
      cmocka_unit_test(an_arch_snaps_through_at_the_largest_force),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
