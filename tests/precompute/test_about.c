/* Models about a state: energy, force and polynomial are those beyond it, and the frequencies of a
 * string, of a heated plate and of a column by closed form. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/monomials.h"
#include "tests/support/precompute_support.h"

#include "driver/make/about.h"
#include "mesh/elastic.h"
#include "mesh/mesh_beam.h"
#include "precompute/fem/about_state.h"
#include "precompute/fem/fem_solids.h"
#include "precompute/model/model_fem.h"
#include "thrum/polynomial.h"

/* Hexahedra of one form, of which what `held` says is held. */
static body hexahedra(const char *name, thrum_solid_form form) {
  body b = {0};
  assert_int_equal(thrum_mesh_beam(name, &b.mesh, NULL), THRUM_OK);
  b.fixed = need((size_t)b.mesh.vertex_count, 1);
  memset(b.mesh.solid_form, (int)form, (size_t)b.mesh.solid_count);
  return b;
}

static void hold_ends(body *b, double length) {
  for (int64_t v = 0; v < b->mesh.vertex_count; v++) {
    const double x = b->mesh.vertices[3 * v];
    b->fixed[v] = x < 1e-9 || x > length - 1e-9 ? 7 : 0;
  }
}

static void find(body *b, const char *text) {
  thrum_error error = {0};
  if (about_find(text, b->fixed, &b->mesh, &error) < 0)
    fail_msg("%s", error.message);
}

/* V(q) = W(u0 + U q) - W(u0) - R(u0) . U q, W the energy of the body without the state; and the
 * unreduced body of the model has that energy, its slope as force and the slope of that as K. The
 * derivatives of modes about the state are those of its polynomial: nothing of c3 that two modes
 * have with another vector is left when they are in the basis (as at rest). */
static void a_model_is_what_the_body_does_beyond_the_state(void **state) {
  (void)state;
  enum { R = 8 };
  for (int of = 0; of < 3; of++) {
    body b = of == 0   ? hexahedra("beam:4x2x1@1x0.4x0.1,hex", THRUM_FORM_SHELL8)
             : of == 1 ? hexahedra("beam:4x2x1@1x0.4x0.3,hex", THRUM_FORM_HEX8)
                       : body_quadratic("beam:2x1x1@1x0.4x0.3", NULL, 0, 0.01);
    hold_ends(&b, 1);
    find(&b, "stretch:0.1,0.02,-0.01");
    thrum_precomputed result = body_precompute(&b, 4, R);
    thrum_fem plain = body_fem(&b), fem = body_fem(&b);
    assert_int_equal(thrum_fem_take_state(&b.mesh, &fem, NULL), THRUM_OK);
    const thrum_model *model = &result.model;
    const int64_t all = 3 * fem.vertex_count;
    double *stated = b.mesh.about, *u = need((size_t)all, sizeof *u);
    double q[R], *force = need((size_t)all, sizeof *force), *sum = need((size_t)all, sizeof *sum);
    for (int i = 0; i < R; i++)
      q[i] = 0.3 * random_number();
    for (int64_t c = 0; c < all; c++) {
      u[c] = dot_of(model->basis + R * c, q, R);
      sum[c] = stated[c] + u[c];
    }
    const double before = thrum_fem_energy(&plain, stated, force);
    const double beyond = thrum_fem_energy(&plain, sum, NULL) - before - dot_of(force, u, all);
    assert_close(polynomial_of(model, q), beyond, 1e-8);
    assert_close(thrum_fem_energy(&fem, u, NULL), beyond, 1e-8);

    // nothing pulls at what is free, and what is held is where the state has it
    double most = 0;
    for (int64_t c = 0; c < all; c++) {
      if (fem.dof[c] >= 0)
        most = fmax(most, fabs(force[c]));
      else
        assert_true(fabs(stated[c] - (c % 3 == 0   ? 0.1
                                      : c % 3 == 1 ? 0.02
                                                   : -0.01) *
                                         b.mesh.vertices[c]) < 1e-12);
    }
    assert_true(most < 1e-6 * norm_of(force, all));

    // the model has the shape of the state, and its body is the same again
    assert_int_equal(model->format[1], THRUM_MODEL_FORMAT_MINOR_ABOUT);
    for (int64_t c = 0; c < all; c++)
      assert_true(fabs(model->vertices[c] - model->about[c] - b.mesh.vertices[c]) < 1e-14);
    thrum_model_fem again = {0};
    assert_int_equal(thrum_model_fem_create(model, &again, NULL), THRUM_OK);
    assert_close(thrum_fem_energy(&again.fem, u, force), beyond, 1e-8);
    double *mean = need((size_t)all, sizeof *mean), *zero = need((size_t)all, sizeof *zero);
    thrum_fem_solids_mean_force(&again.fem, zero, u, mean);
    assert_close(dot_of(mean, u, all), beyond, 1e-8);
    free(mean);
    free(zero);

    // Phi_00 solves K Phi = -d2R, so that it is the answer to what two small amounts of a mode pull
    const double h = 1e-3, *phi = model->basis;
    double square = 0, mixed = 0, *pull = need((size_t)all, sizeof *pull);
    for (int sign = -1; sign <= 1; sign += 2) {
      for (int64_t c = 0; c < all; c++)
        u[c] = sign * h * phi[R * c];
      thrum_fem_energy(&fem, u, force);
      for (int64_t c = 0; c < all; c++)
        pull[c] += force[c] / (h * h);
    }
    for (int64_t j = 0; j < R; j++) {
      double work = 0;
      for (int64_t c = 0; c < all; c++)
        work += pull[c] * phi[R * c + j];
      const int64_t at = thrum_c3_index(R, 0, 0, j);
      const double c3 = model->c3[at] * (j == 0 ? 6 : 2);
      square += c3 * c3;
      mixed += (work - c3) * (work - c3);
    }
    assert_true(mixed <= 1e-6 * square + 1e-6);
    free(pull);
    thrum_model_fem_free(&again);
    free(u);
    free(force);
    free(sum);
    thrum_fem_free(&plain);
    thrum_fem_free(&fem);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

/* A string of L = 1 m, 2 mm thick, stretched by e: S = E (e + e^2/2), f_n = n/(2 L) sqrt(S / rho)
 * (1 + 2 k + (4 + n^2 pi^2 / 2) k^2), k = sqrt(E I / (T L^2)), clamped (Fletcher, Rossing 1998, The
 * physics of musical instruments, 2.18). */
static void a_string_has_its_pitch(void **state) {
  (void)state;
  const double length = 1, thick = 0.002, e = 0.02, young = 5e6, density = 1000;
  body b = hexahedra("beam:60x1x1@1x0.002x0.002,hex", THRUM_FORM_SHELL8);
  hold_ends(&b, length);
  b.mesh.materials[0] = (thrum_material){young, 0.3, density};
  find(&b, "stretch:0.02,0,0");
  thrum_precomputed result = body_precompute(&b, 4, 4);
  const double stress = young * (e + e * e / 2), stretched = length * (1 + e);
  const double bend = young * pow(thick, 4) / 12;
  const double k = sqrt(bend / (stress * (1 + e) * thick * thick)) / stretched;
  for (int n = 1; n <= 2; n++) {
    const double stiff = 1 + 2 * k + (4 + n * n * TWO_PI * TWO_PI / 8) * k * k;
    assert_close(sqrt(result.mode_omega2[2 * n - 2]) / TWO_PI,
                 n / (2 * length) * sqrt(stress / density) * stiff, 0.003);
  }
  thrum_precomputed_free(&result);
  body_free(&b);
}

/* A simply supported square plate whose edges may not part: the square of its first frequency falls
 * as 1 - DT/DT_c, alpha DT_c = pi^2 h^2 / (6 (1 + nu) a^2) (Boley, Weiner 1960, Theory of thermal
 * stresses, 13.4), and begins at 4 pi^4 D / (rho h a^4). */
static void a_heated_plate_has_the_frequencies_of_its_temperature(void **state) {
  (void)state;
  const double a = 1, h = 0.01, nu = 0.3, young = 70e9, density = 2700, pi = TWO_PI / 2;
  const double critical = pi * pi * h * h / (6 * (1 + nu) * a * a);
  const double rest = sqrt(young * h * h / (3 * (1 - nu * nu) * density)) * pi * pi / (a * a);
  for (int n = 0; n < 4; n++) {
    char text[80];
    body b = hexahedra("beam:12x12x2@1x1x0.01,hex", THRUM_FORM_SHELL8);
    b.mesh.materials[0] = (thrum_material){young, nu, density};

    // hinged: the middle of each edge is held, and above and below it what goes along
    for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
      const double *x = b.mesh.vertices + 3 * v;
      const bool side = x[0] < 1e-9 || x[0] > a - 1e-9, other = fabs(x[1]) > a / 2 - 1e-9;
      const bool middle = fabs(x[2]) < 1e-9;
      b.fixed[v] = (uint8_t)(middle && (side || other) ? 7 : (side ? 2 : 0) | (other ? 1 : 0));
    }
    snprintf(text, sizeof text, "temperature:%.17g,1e-5", 0.3 * n * critical / 1e-5);
    if (n > 0)
      find(&b, text);
    thrum_precomputed result = body_precompute(&b, 1, 1);
    assert_close(result.mode_omega2[0] / (rest * rest) + 0.3 * n, 1, 0.03);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

/* A column between clamps that come nearer buckles at a strain of 4 pi^2 I / (A L^2), Euler's; its
 * first frequency is small before, and there is no model behind it. */
static void a_column_gives_way_at_its_buckling_load(void **state) {
  (void)state;
  const double critical = TWO_PI * TWO_PI / 12 * 0.02 * 0.02;
  double square[2];
  for (int n = 0; n < 3; n++) {
    static const double shares[3] = {0.5, 0.9, 1.04};
    char text[80];
    thrum_error error = {0};
    body b = hexahedra("beam:30x1x1@1x0.03x0.02,hex", THRUM_FORM_HEX8);
    b.mesh.materials[0] = (thrum_material){5e6, 0, 1000};
    hold_ends(&b, 1);
    snprintf(text, sizeof text, "stretch:%.17g,0,0", -shares[n] * critical);
    const thrum_status status = about_find(text, b.fixed, &b.mesh, &error);
    if (n == 2) {
      assert_int_equal(status, THRUM_SINGULAR);
      assert_non_null(strstr(error.message, "gives way"));
    } else {
      assert_int_equal(status, THRUM_OK);
      thrum_precomputed result = body_precompute(&b, 1, 1);
      square[n] = result.mode_omega2[0];
      thrum_precomputed_free(&result);
    }
    body_free(&b);
  }

  // the line through both squares ends at the load
  const double end = 0.5 + 0.4 * square[0] / (square[0] - square[1]);
  assert_close(end, 1, 0.02);
}

static void what_is_no_state_is_refused(void **state) {
  (void)state;
  body b = hexahedra("beam:2x1x1@1x0.1x0.1,hex", THRUM_FORM_HEX8);
  thrum_error error = {0};

  // a free body takes none, whatever it says
  static const char *const states[] = {"missing.npy", "stretch:0.1,0,0", "temperature:1,1e-5"};
  for (int n = 0; n < 3; n++) {
    assert_int_equal(about_find(states[n], b.fixed, &b.mesh, &error), THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "nothing is held"));
    assert_null(b.mesh.about);
  }
  hold_ends(&b, 1);
  assert_true(about_find("missing.npy", b.fixed, &b.mesh, &error) < 0);
  assert_null(strstr(error.message, "nothing is held"));
  assert_null(b.mesh.about);

  // a stretch of what is held at one end moves nothing, and nothing buckles
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    b.fixed[v] = b.mesh.vertices[3 * v] < 1e-9 ? 7 : 0;
  assert_int_equal(about_find("stretch:0.1,0,0", b.fixed, &b.mesh, &error), THRUM_OK);
  for (int64_t c = 0; c < 3 * b.mesh.vertex_count; c++)
    assert_true(fabs(b.mesh.about[c]) < 1e-9);
  free(b.mesh.about);
  b.mesh.about = NULL;

  // springs do not go with one
  b.mesh.springs = need(3 * (size_t)b.mesh.vertex_count, sizeof(double));
  b.mesh.about = need(3 * (size_t)b.mesh.vertex_count, sizeof(double));
  thrum_precompute_options options = thrum_default_precompute_options();
  thrum_precomputed result = {0};
  assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &result, &error),
                   THRUM_UNSUPPORTED);
  body_free(&b);
}

/* What stays on a body about a state is against what holds it there: of a stretch nothing, and of
 * any other state as much as pulls at what is held. */
static void the_loads_of_a_state_are_against_what_holds_it(void **state) {
  (void)state;
  thrum_error error = {0};
  double loads[3];
  body b = hexahedra("beam:3x1x1@1x0.2x0.2,hex", THRUM_FORM_HEX8);
  b.mesh.materials[0] = (thrum_material){1e6, 0, 1000};
  hold_ends(&b, 1);
  assert_int_equal(about_find("stretch:0.02,0,0", b.fixed, &b.mesh, &error), THRUM_OK);
  assert_int_equal(about_loads(&b.mesh, b.fixed, loads, &error), THRUM_OK);

  // the pull of what is held, of Saint Venant-Kirchhoff material that does not get thinner
  const double e = 0.02, pull = 1e6 * 0.04 * (1 + e) * (e + e * e / 2);
  assert_true(fabs(loads[0]) < 1e-7 * pull && fabs(loads[2]) < 1e-7 * pull);

  // one end let go: its reaction stays as a load
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    b.fixed[v] = b.mesh.vertices[3 * v] > 0.9 ? 0 : b.fixed[v];
  assert_int_equal(about_loads(&b.mesh, b.fixed, loads, &error), THRUM_OK);
  assert_close(loads[0], pull, 1e-9);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_model_is_what_the_body_does_beyond_the_state),
      cmocka_unit_test(a_string_has_its_pitch),
      cmocka_unit_test(a_heated_plate_has_the_frequencies_of_its_temperature),
      cmocka_unit_test(a_column_gives_way_at_its_buckling_load),
      cmocka_unit_test(what_is_no_state_is_refused),
      cmocka_unit_test(the_loads_of_a_state_are_against_what_holds_it),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
