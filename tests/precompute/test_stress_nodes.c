/* Stress at the nodes: constant and linear fields are exact, a jump between regions stays, and a
 * twisted bar has the stress of theory at its surface. SPDX-License-Identifier: Apache-2.0 */
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
#include "thrum/thrum.h"

#define YOUNG 2e11
#define POISSON 0.3
#define SHEAR (YOUNG / (2 * (1 + POISSON)))

/* A beam along x, of two regions where x < 1/2 and beyond. */
typedef struct beam {
  thrum_mesh mesh;
  uint8_t *fixed;
  int32_t *region;
  double *u, *cauchy, *von_mises; /* 3 vertex_count, and room for two stresses a vertex */
  double material[6];
  thrum_model model;
  void *memory;
  const thrum_stress_nodes *nodes;
} beam;

static void *need(size_t count, size_t size) {
  void *memory = calloc(count, size);
  assert_non_null(memory);
  return memory;
}

static void nodes_make(beam *b) {
  size_t size = 0;
  assert_int_equal(thrum_stress_nodes_size(&b->model, &size, NULL), THRUM_OK);
  free(b->memory);
  b->memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_non_null(b->memory);
  assert_int_equal(thrum_stress_nodes_init(b->memory, size, &b->model, &b->nodes, NULL), THRUM_OK);
}

static void beam_make(beam *b, const char *spec, bool ten) {
  thrum_error error;
  memset(b, 0, sizeof *b);
  if (thrum_mesh_read(spec, 1, &b->mesh, &error) < 0 ||
      (ten && thrum_midsides_add(&b->mesh, &error) < 0))
    fail_msg("%s", error.message);
  const size_t count = (size_t)b->mesh.vertex_count;
  b->fixed = need(count, 1);
  b->region = need((size_t)b->mesh.tet_count, sizeof *b->region);
  b->u = need(3 * count, sizeof *b->u);
  b->cauchy = need(12 * count, sizeof *b->cauchy);
  b->von_mises = need(2 * count, sizeof *b->von_mises);
  for (int n = 0; n < 2; n++) {
    b->material[3 * n] = YOUNG;
    b->material[3 * n + 1] = POISSON;
    b->material[3 * n + 2] = 7800;
  }
  b->model = (thrum_model){.vertex_count = b->mesh.vertex_count,
                           .tet_count = b->mesh.tet_count,
                           .region_count = 2,
                           .vertices = b->mesh.vertices,
                           .tets = b->mesh.tets,
                           .midsides = b->mesh.midsides,
                           .tet_region = b->region,
                           .material = b->material,
                           .fixed = b->fixed};
  for (int64_t t = 0; t < b->mesh.tet_count; t++) {
    double middle = 0;
    for (int a = 0; a < 4; a++)
      middle += b->mesh.vertices[3 * b->mesh.tets[4 * t + a]] / 4;
    b->region[t] = middle > 0.5;
  }
  nodes_make(b);
}

static void beam_free(beam *b) {
  thrum_mesh_free(&b->mesh);
  free(b->fixed);
  free(b->region);
  free(b->u);
  free(b->cauchy);
  free(b->von_mises);
  free(b->memory);
}

static void read(beam *b) {
  assert_int_equal(thrum_stress_nodes_read(b->nodes, b->u, b->cauchy, b->von_mises, NULL),
                   THRUM_OK);
}

static const double *place_of(const beam *b, int64_t n) {
  return b->mesh.vertices + 3 * (int64_t)thrum_stress_nodes_vertex(b->nodes, n);
}

/* Every vertex is there once, and where two regions meet twice, by vertex and then by region. */
static void each_region_has_its_nodes(void **state) {
  (void)state;
  beam b;
  beam_make(&b, "beam:4x2x2@1x0.5x0.5", true);
  int64_t wanted = 0;
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    wanted += fabs(b.mesh.vertices[3 * v] - 0.5) < 1e-9 ? 2 : 1;
  assert_int_equal(thrum_stress_nodes_count(b.nodes), wanted);
  assert_true(thrum_stress_nodes_extrapolated(b.nodes) == 1);
  for (int64_t n = 0; n < wanted; n++) {
    const double x = place_of(&b, n)[0];
    const int32_t region = thrum_stress_nodes_region(b.nodes, n);
    assert_true(region == 0 ? x < 0.5 + 1e-9 : x > 0.5 - 1e-9);
    const int64_t v = thrum_stress_nodes_vertex(b.nodes, n);
    assert_true(n == 0 || v > thrum_stress_nodes_vertex(b.nodes, n - 1) ||
                (v == thrum_stress_nodes_vertex(b.nodes, n - 1) && region == 1));
  }
  beam_free(&b);
}

/* The patch test, at large strain and with curved edges too: F constant gives one stress. */
static void a_constant_stress_is_that_of_all_nodes(void **state) {
  (void)state;
  static const double g[3][3] = {{0.1, 0.04, -0.03}, {0.02, -0.05, 0.06}, {-0.01, 0.05, 0.2}};
  for (int ten = 0; ten < 2; ten++) {
    beam b;
    beam_make(&b, "beam:4x2x3@1x0.5x0.5", ten == 1);
    for (int64_t c = 0; c < 3 * b.mesh.vertex_count; c++) {
      const double *x = b.mesh.vertices + c / 3 * 3;
      b.u[c] = 0.3 + g[c % 3][0] * x[0] + g[c % 3][1] * x[1] + g[c % 3][2] * x[2];
    }
    read(&b);
    const double size = b.von_mises[0];
    for (int64_t n = 0; n < thrum_stress_nodes_count(b.nodes); n++) {
      for (int c = 0; c < 6; c++)
        assert_true(fabs(b.cauchy[6 * n + c] - b.cauchy[c]) <= 1e-12 * size);
      assert_true(fabs(b.von_mises[n] - size) <= 1e-12 * size);
    }
    beam_free(&b);
  }
}

/* Pure bending: sigma_xx = E k z up to the surface, which averages of linear patches do not reach.
 */
static void bending_is_exact_at_the_surface(void **state) {
  (void)state;
  const double k = 1e-7;
  double largest[2] = {0};
  for (int ten = 0; ten < 2; ten++) {
    beam b;
    beam_make(&b, "beam:4x2x2@1x0.5x0.5", ten == 1);
    for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
      const double *x = b.mesh.vertices + 3 * v;
      b.u[3 * v] = k * x[0] * x[2];
      b.u[3 * v + 1] = -POISSON * k * x[1] * x[2];
      b.u[3 * v + 2] = -k / 2 * (x[0] * x[0] + POISSON * (x[2] * x[2] - x[1] * x[1]));
    }
    read(&b);
    for (int64_t n = 0; n < thrum_stress_nodes_count(b.nodes); n++) {
      const double wanted = YOUNG * k * place_of(&b, n)[2];
      if (ten)
        assert_true(fabs(b.cauchy[6 * n] - wanted) <= 1e-6 * YOUNG * k * 0.25);
      largest[ten] = fmax(largest[ten], b.cauchy[6 * n]);
    }
    assert_true(thrum_stress_nodes_extrapolated(b.nodes) == ten);
    beam_free(&b);
  }
  assert_true(fabs(largest[0] / largest[1] - 1) > 0.02);
}

/* Two moduli under one strain have two stresses, and the nodes between them both. */
static void a_jump_between_regions_stays(void **state) {
  (void)state;
  for (int ten = 0; ten < 2; ten++) {
    beam b;
    beam_make(&b, "beam:4x2x2@1x0.5x0.5", ten == 1);
    b.material[3] = YOUNG / 4;
    for (int64_t v = 0; v < b.mesh.vertex_count; v++)
      b.u[3 * v] = 1e-6 * b.mesh.vertices[3 * v];
    read(&b);
    for (int64_t n = 0; n < thrum_stress_nodes_count(b.nodes); n++) {
      const double share = thrum_stress_nodes_region(b.nodes, n) == 0 ? 1 : 0.25;
      assert_true(fabs(b.von_mises[n] - share * b.von_mises[0]) <= 1e-9 * b.von_mises[0]);
    }
    beam_free(&b);
  }
}

/* A square bar that is twisted has tau = 0.6753 G theta a in the middle of its faces (Timoshenko &
 * Goodier 1951, 109), and so has a node there. */
static void a_twisted_bar_has_the_stress_of_theory(void **state) {
  (void)state;
  beam b;
  const double side = 0.2, angle = 1e-3, theta = angle / 1;
  beam_make(&b, "beam:10x4x4@1x0.2x0.2", true);
  uint8_t *held = need((size_t)b.mesh.vertex_count, 1);
  int32_t *end = need((size_t)b.mesh.vertex_count, sizeof *end);
  int64_t count = 0;
  for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
    const double x = b.mesh.vertices[3 * v];
    b.fixed[v] = x < 1e-9 ? 7 : 0;
    held[v] = x > 1 - 1e-9 ? 7 : 0;
    if (held[v])
      end[count++] = (int32_t)v;
  }
  const thrum_full_turn turn = {.vertices = end, .count = count, .by = {angle, 0, 0}};
  const thrum_full_loading loading = {.turns = &turn, .turn_count = 1};
  const thrum_full_def def = thrum_default_full_def();
  thrum_full_equilibrium found;
  thrum_full *full = NULL;
  assert_int_equal(thrum_full_create(&b.model, held, &def, &full, NULL), THRUM_OK);
  assert_int_equal(thrum_full_rest_under(full, &loading, &found, NULL), THRUM_OK);
  thrum_full_get(full, b.u, NULL);
  read(&b);

  // far from both ends, which keep the section from warping
  const double wanted = sqrt(3) * 0.6753 * SHEAR * theta * side;
  double largest = 0;
  for (int64_t n = 0; n < thrum_stress_nodes_count(b.nodes); n++)
    if (fabs(place_of(&b, n)[0] - 0.5) < 0.11)
      largest = fmax(largest, b.von_mises[n]);
  assert_true(fabs(largest / wanted - 1) < 0.03);
  thrum_full_free(full);
  free(held);
  free(end);
  beam_free(&b);
}

static void what_is_wrong_is_refused(void **state) {
  (void)state;
  beam b;
  beam_make(&b, "beam:2x1x1@1x0.5x0.5", true);
  size_t size = 0;
  thrum_model bare = b.model;
  bare.tets = NULL;
  assert_int_equal(thrum_stress_nodes_size(&bare, &size, NULL), THRUM_MISSING);
  assert_int_equal(thrum_stress_nodes_size(NULL, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_nodes_size(&b.model, &size, NULL), THRUM_OK);
  const thrum_stress_nodes *nodes = NULL;
  assert_int_equal(thrum_stress_nodes_init(b.memory, size - 1, &b.model, &nodes, NULL),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_stress_nodes_init((char *)b.memory + 8, size, &b.model, &nodes, NULL),
                   THRUM_MISALIGNED);
  assert_null(nodes);
  assert_int_equal(thrum_stress_nodes_read(NULL, b.u, b.cauchy, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_nodes_read(b.nodes, b.u, NULL, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_nodes_count(NULL), 0);

  // a body that is turned inside out has no stress, and one without a place none to read
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    b.u[3 * v] = -2 * b.mesh.vertices[3 * v];
  read(&b);
  assert_true(isnan(b.von_mises[0]));
  b.u[0] = NAN;
  assert_int_equal(thrum_stress_nodes_read(b.nodes, b.u, b.cauchy, NULL, NULL), THRUM_BAD_VALUE);
  beam_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_region_has_its_nodes),
      cmocka_unit_test(a_constant_stress_is_that_of_all_nodes),
      cmocka_unit_test(bending_is_exact_at_the_surface),
      cmocka_unit_test(a_jump_between_regions_stays),
      cmocka_unit_test(a_twisted_bar_has_the_stress_of_theory),
      cmocka_unit_test(what_is_wrong_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
