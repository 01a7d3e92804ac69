/* Actuators beside closed forms: a thick ring and a sphere under pressure, a bimetal, a
 * piezo bimorph, a body that swells freely. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/acting_body.h"

#define PI 3.14159265358979323846

static void set_material(body *b, double young, double poisson) {
  for (int64_t m = 0; m < b->mesh.region_count; m++)
    b->mesh.materials[m] = (thrum_material){young, poisson, 1000};
}

static void hold(body *b, const char *where) {
  thrum_error error = {0};
  int64_t count = 0;
  if (thrum_mesh_fix(&b->mesh, where, b->fixed, &count, &error) < 0)
    fail_msg("%s", error.message);
}

/* Ten nodes, before the places are mapped: middle nodes come to lie on the curves. */
static void take_middles(body *b) {
  thrum_error error = {0};
  assert_int_equal(thrum_midsides_add(&b->mesh, &error), THRUM_OK);
  free(b->fixed);
  b->fixed = need((size_t)b->mesh.vertex_count, 1);
}

/* The group of all vertices where `value` is `at`. */
static void group_where(body *b, const char *name, double (*value)(const double *), double at) {
  int32_t *list = need((size_t)b->mesh.vertex_count, sizeof *list);
  int64_t count = 0;
  thrum_error error = {0};
  for (int64_t v = 0; v < b->mesh.vertex_count; v++)
    if (fabs(value(b->mesh.vertices + 3 * v) - at) < 1e-9)
      list[count++] = (int32_t)v;
  assert_int_equal(thrum_mesh_add_group(&b->mesh, name, list, count, &error), THRUM_OK);
  free(list);
}

/* What a level of 1 changes the measure of an actuator by, where little moves. */
static double answer_of(const thrum_model *model, int64_t k) {
  double sum = 0;
  for (int64_t i = 0; i < model->rank; i++)
    sum += model->actuator_linear[k * model->rank + i] *
           model->actuator_linear[k * model->rank + i] / model->omega2[i];
  return sum;
}

static double radius_in_plane(const double *x) {
  return sqrt(x[0] * x[0] + x[1] * x[1]);
}

/* Lame: u(a) = (1 + nu)/E p a^2/(b^2 - a^2) [(1 - 2 nu) a + b^2/a] in plane strain. */
static void a_ring_widens_as_lame_has_it(void **state) {
  (void)state;
  static const char *const texts[] = {"air=pressure:inside", NULL};
  const double a = 1, b = 1.1, young = 1e6, poisson = 0.3, deep = 0.1;
  body ring = body_make("beam:10x1x1@1x0.1x0.1", NULL);
  take_middles(&ring);
  for (int64_t v = 0; v < ring.mesh.vertex_count; v++) {
    double *x = ring.mesh.vertices + 3 * v;
    const double angle = 0.5 * PI * x[0], radius = a + x[1] + 0.05;
    x[0] = radius * sin(angle);
    x[1] = radius * cos(angle);

    // the planes of symmetry are planes
    x[0] = fabs(x[0]) < 1e-12 ? 0 : x[0];
    x[1] = fabs(x[1]) < 1e-12 ? 0 : x[1];
  }
  set_material(&ring, young, poisson);
  hold(&ring, "x<1e-9:x");
  hold(&ring, "y<1e-9:y");
  hold(&ring, "z>-9:z");
  group_where(&ring, "inside", radius_in_plane, a);
  acting_body made = act_on(ring, texts, 2, 4);
  const double wide =
      (1 + poisson) / young * a * a / (b * b - a * a) * ((1 - 2 * poisson) * a + b * b / a);
  const double volume = 0.5 * PI * a * wide * deep;
  assert_true(fabs(answer_of(&made.found.model, 0) / volume - 1) < 0.01);
  acting_free(&made);
}

static double radius_of(const double *x) {
  return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

/* Lame: u(a) = p a^3/(E (b^3 - a^3)) [(1 - 2 nu) a + (1 + nu) b^3/(2 a^2)]. */
static void a_sphere_widens_as_lame_has_it(void **state) {
  (void)state;
  static const char *const texts[] = {"air=chamber:inside", NULL};
  const double a = 1, b = 1.25, young = 1e6, poisson = 0.3;
  body shell = body_make("beam:8x8x8@2x2x2", NULL);
  int64_t kept = 0;
  for (int64_t t = 0; t < shell.mesh.tet_count; t++) {
    double farthest = 0;
    for (int axis = 0; axis < 3; axis++) {
      double at = axis == 0 ? -1 : 0;
      for (int n = 0; n < 4; n++)
        at += shell.mesh.vertices[3 * (int64_t)shell.mesh.tets[4 * t + n] + axis] / 4;
      farthest = fmax(farthest, fabs(at));
    }
    if (farthest < 0.75)
      continue;
    memmove(shell.mesh.tets + 4 * kept, shell.mesh.tets + 4 * t, 4 * sizeof(int32_t));
    shell.mesh.tet_region[kept++] = shell.mesh.tet_region[t];
  }
  shell.mesh.tet_count = kept;
  int64_t dropped = 0;

  // vertices within the hole go, and cubes become spheres
  int32_t *number = need((size_t)shell.mesh.vertex_count, sizeof *number);
  for (int64_t v = 0; v < shell.mesh.vertex_count; v++) {
    double *x = shell.mesh.vertices + 3 * v;
    const double far = fmax(fabs(x[0] - 1), fmax(fabs(x[1]), fabs(x[2])));
    number[v] = far < 0.74 ? -1 : (int32_t)(v - dropped);
    dropped += far < 0.74;
    if (number[v] >= 0)
      memmove(shell.mesh.vertices + 3 * (int64_t)number[v], x, 3 * sizeof *x);
  }
  shell.mesh.vertex_count -= dropped;
  for (int64_t n = 0; n < 4 * kept; n++)
    shell.mesh.tets[n] = number[shell.mesh.tets[n]];
  free(number);
  for (int64_t g = 0; g < shell.mesh.group_count; g++)
    shell.mesh.groups[g].count = 1, shell.mesh.groups[g].vertices[0] = 0;
  take_middles(&shell);
  for (int64_t v = 0; v < shell.mesh.vertex_count; v++) {
    double *x = shell.mesh.vertices + 3 * v;
    x[0] -= 1;
    const double far = fmax(fabs(x[0]), fmax(fabs(x[1]), fabs(x[2])));
    const double by = (a + (b - a) * (far - 0.75) / 0.25) / radius_of(x);
    for (int axis = 0; axis < 3; axis++)
      x[axis] *= by;
  }
  set_material(&shell, young, poisson);
  group_where(&shell, "inside", radius_of, a);
  acting_body made = act_on(shell, texts, 2, 4);
  assert_true(fabs(made.found.model.actuator_rest[0] / (4.0 / 3 * PI) - 1) < 2e-3);
  const double wide = a * a * a / (young * (b * b * b - a * a * a)) *
                      ((1 - 2 * poisson) * a + (1 + poisson) * b * b * b / (2 * a * a));
  assert_true(fabs(answer_of(&made.found.model, 0) / (4 * PI * a * a * wide) - 1) < 0.01);
  acting_free(&made);
}

/* How far the end of a held strip of two equal layers, the regions 1 below and 3 above, goes down
 * under these levels, where little moves. */
static double bend_of(const char *const *texts, const double *levels, double poisson) {
  const double length = 1;
  body strip = body_make("beam:12x1x2@1x0.05x0.1", NULL);
  body_divide(&strip, length);
  for (int64_t t = 0; t < strip.mesh.tet_count; t++) {
    double z = 0;
    for (int n = 0; n < 4; n++)
      z += strip.mesh.vertices[3 * (int64_t)strip.mesh.tets[4 * t + n] + 2] / 4;
    strip.mesh.tet_region[t] = z > 0 ? 2 : 0;
  }
  free(strip.mesh.laws);
  strip.mesh.laws = NULL;
  take_middles(&strip);
  set_material(&strip, 1e6, poisson);

  // its end stays plane, and may widen
  hold(&strip, "x<1e-6:x");
  for (int64_t v = 0; v < strip.mesh.vertex_count; v++) {
    const double *x = strip.mesh.vertices + 3 * v;
    if (x[0] < 1e-6 && fabs(x[2]) < 1e-6)
      strip.fixed[v] = 7;
  }
  acting_body made = act_on(strip, texts, 3, 6);
  const thrum_model *model = &made.found.model;

  // the mean of the free end
  double down = 0;
  int64_t count = 0;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    if (model->vertices[3 * v] < length - 1e-9)
      continue;
    count++;
    for (int64_t k = 0; k < model->actuator_count; k++)
      for (int64_t i = 0; i < model->rank; i++)
        down -= levels[k] * model->basis[(3 * v + 2) * model->rank + i] *
                model->actuator_linear[k * model->rank + i] / model->omega2[i];
  }
  acting_free(&made);
  return down / (double)count;
}

/* Timoshenko: two equal layers, of which one grows by e more, bend with the curvature 3 e/(2 h), so
 * that the free end goes down by half of it times the square of the length. */
static void a_bimetal_bends_as_timoshenko_has_it(void **state) {
  (void)state;
  static const char *const texts[] = {"heat=eigenstrain:3,1,0,0,0,0,0", NULL};
  const double level = 1, high = 0.1;
  assert_true(fabs(bend_of(texts, &level, 0) / (0.5 * 3 / (2 * high)) - 1) < 0.01);
}

/* A piezo bimorph: layers that strain along and across by e = d31 V/t, one as much as the other
 * less, move its tip by 3 e L^2/(2 h) (Smits, Dalke & Cooney 1991,
 * doi:10.1016/0924-4247(91)80007-C). */
static void the_tip_of_a_bimorph_moves_as_its_closed_form(void **state) {
  (void)state;
  static const char *const texts[] = {"above=eigenstrain:3,1,1,0,0,0,0",
                                      "below=eigenstrain:1,1,1,0,0,0,0", NULL};
  const double levels[] = {1e-4, -1e-4}, high = 0.1;
  assert_true(fabs(bend_of(texts, levels, 0.3) / (1e-4 * 3 / (2 * high)) - 1) < 0.01);
}

/* Theorem: a body that nothing holds grows by sqrt(1 + 2 a), at any level, without a strain that
 * costs energy beyond the constant. */
static void a_free_body_swells_to_rounding(void **state) {
  (void)state;
  static const char *const texts[] = {"water=swell:all", NULL};
  body b = body_quadratic("beam:2x1x1@0.4x0.2x0.2", NULL, 0.01, 0);
  set_material(&b, 1e6, 0.3);
  acting_body made = act_on(b, texts, 2, 4);
  const thrum_model *model = &made.found.model;
  const double level = 0.3, grown = sqrt(1 + 2 * level) - 1;
  thrum_model acting;
  thrum_error error = {0};
  size_t size = 0;
  double *memory = need((size_t)thrum_model_actuation_count(model), sizeof *memory);
  double load[64] = {0}, q[64] = {0};
  assert_int_equal(thrum_model_actuate(model, &level, memory, &acting, &error), THRUM_OK);
  assert_int_equal(thrum_equilibrium_size(&acting, &size, &error), THRUM_OK);
  void *workspace = aligned_alloc(64, (size + 63) / 64 * 64);
  const thrum_equilibrium_def def = thrum_default_equilibrium_def();
  thrum_equilibrium_report report;
  if (thrum_equilibrium(&acting, &def, load, q, workspace, size, &report, &error) < 0)
    fail_msg("%s", error.message);

  // between any two vertices
  const int64_t r = model->rank;
  for (int64_t v = 1; v < model->vertex_count; v++)
    for (int axis = 0; axis < 3; axis++) {
      double moved = 0;
      for (int64_t i = 0; i < r; i++)
        moved += (model->basis[(3 * v + axis) * r + i] - model->basis[axis * r + i]) * q[i];
      const double apart = model->vertices[3 * v + axis] - model->vertices[axis];
      assert_true(fabs(moved - grown * apart) < 1e-9);
    }
  free(workspace);
  free(memory);
  acting_free(&made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_ring_widens_as_lame_has_it),
      cmocka_unit_test(a_sphere_widens_as_lame_has_it),
      cmocka_unit_test(a_bimetal_bends_as_timoshenko_has_it),
      cmocka_unit_test(the_tip_of_a_bimorph_moves_as_its_closed_form),
      cmocka_unit_test(a_free_body_swells_to_rounding),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
