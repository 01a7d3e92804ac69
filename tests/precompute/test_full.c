/* The full-order body: patch test, conservation, agreement of its schemes and solvers, frequencies,
 * and equilibria. SPDX-License-Identifier: Apache-2.0 */
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
#include "precompute/precompute.h"
#include "tests/support/mesh_model.h"
#include "thrum/thrum.h"

static const double tau = 6.28318530717958647693;

/* A model that consists of a mesh, its supports and a material. */
typedef struct body {
  thrum_mesh mesh;
  uint8_t *fixed;
  double material[9];
  thrum_model model;
} body;

static void body_make(body *b, const char *spec, bool clamped) {
  thrum_error error;
  memset(b, 0, sizeof *b);
  if (thrum_mesh_read(spec, 1, &b->mesh, &error) < 0)
    fail_msg("%s", error.message);

  // clamped at x = 0, if at all
  b->fixed = calloc((size_t)b->mesh.vertex_count, 1);
  assert_non_null(b->fixed);
  for (int64_t v = 0; v < b->mesh.vertex_count; v++)
    b->fixed[v] = clamped && b->mesh.vertices[3 * v] < 1e-9 ? 7 : 0;

  // one material, and a model that borrows the mesh's arrays
  b->material[0] = 1e6;
  b->material[1] = 0.3;
  b->material[2] = 1000;
  b->model = mesh_model(&b->mesh, b->material, b->fixed);
}

/* Regions along x of as many laws, one after the other, of a beam of length 1. */
static void body_divide(body *b, int count, const uint8_t *laws) {
  for (int c = 3; c < 3 * count; c++)
    b->material[c] = b->material[c % 3];
  for (int64_t t = 0; t < b->mesh.tet_count; t++) {
    double x = 0;
    for (int a = 0; a < 4; a++)
      x += b->mesh.vertices[3 * (int64_t)b->mesh.tets[4 * t + a]] / 4;
    b->mesh.tet_region[t] = (int32_t)(count * x);
  }
  b->model.region_count = b->model.law_count = count;
  b->model.region_law = laws;
}

static void body_free(body *b) {
  thrum_mesh_free(&b->mesh);
  free(b->fixed);
}

static const uint8_t three_laws[] = {THRUM_LAW_STVK, THRUM_LAW_COROTATIONAL, THRUM_LAW_NEO_HOOKEAN};

static thrum_full *full_make(const thrum_model *model, const uint8_t *held,
                             const thrum_full_def *def) {
  thrum_full *full = NULL;
  thrum_error error;
  if (thrum_full_create(model, held, def, &full, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return full;
}

static void full_steps(thrum_full *full, int count) {
  thrum_error error;
  for (int k = 0; k < count; k++)
    if (thrum_full_step(full, &error) != THRUM_OK)
      fail_msg("%s", error.message);
}

static double *field_make(const body *b) {
  double *field = calloc(3 * (size_t)b->mesh.vertex_count, sizeof *field);
  assert_non_null(field);
  return field;
}

static double largest(const double *field, const double *less, int64_t count) {
  double found = 0;
  for (int64_t c = 0; c < count; c++)
    found = fmax(found, fabs(field[c] - (less ? less[c] : 0)));
  return found;
}

/* A uniform deformation of the surface extends through the whole body, whatever the tetrahedra. */
static void a_uniform_deformation_is_met_exactly(void **state) {
  (void)state;
  static const double gradient[3][3] = {{0.2, 0.1, -0.05}, {0.3, -0.1, 0}, {0, 0.15, 0.1}};
  body b;
  body_make(&b, "beam:4x3x3@1x0.6x0.5", false);
  uint8_t *held = calloc((size_t)b.mesh.vertex_count, 1);
  double *moves = field_make(&b), *u = field_make(&b), *none = field_make(&b);

  // the surface is held and follows a linear map; the vertices inside are free
  int64_t inside = 0;
  for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
    const double *x = b.mesh.vertices + 3 * v;
    const bool surface =
        x[0] < 1e-9 || x[0] > 1 - 1e-9 || fabs(x[1]) > 0.3 - 1e-9 || fabs(x[2]) > 0.25 - 1e-9;
    held[v] = surface ? 7 : 0;
    inside += !surface;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        moves[3 * v + i] += gradient[i][j] * x[j];
  }
  assert_int_equal(inside, 12);

  // both solvers find the linear map inside
  for (int solver = 0; solver < 2; solver++) {
    thrum_full_def def = thrum_default_full_def();
    def.solver = (thrum_full_solver)solver;
    thrum_full *full = full_make(&b.model, held, &def);
    thrum_full_equilibrium found;
    assert_int_equal(thrum_full_rest(full, none, moves, &found, NULL), THRUM_OK);
    thrum_full_get(full, u, NULL);
    assert_true(largest(u, moves, 3 * b.mesh.vertex_count) <= 1e-10);
    assert_int_equal(found.stable, 1);

    // the energy of a uniform strain is the volume times the energy density
    double strain[3][3], trace = 0, square = 0;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        strain[i][j] = 0.5 * (gradient[i][j] + gradient[j][i]);
        for (int k = 0; k < 3; k++)
          strain[i][j] += 0.5 * gradient[k][i] * gradient[k][j];
        square += strain[i][j] * strain[i][j];
        trace += i == j ? strain[i][j] : 0;
      }
    const double lambda = 1e6 * 0.3 / (1.3 * 0.4), mu = 1e6 / 2.6;
    const double energy = 0.3 * (0.5 * lambda * trace * trace + mu * square);
    assert_true(fabs(found.energy - energy) <= 1e-9 * energy);
    thrum_full_free(full);
  }

  free(held);
  free(moves);
  free(u);
  free(none);
  body_free(&b);
}

/* The body is thrown so that it rotates and vibrates. */
static void throw_body(const body *b, thrum_full *full) {
  double *u = field_make(b), *v = field_make(b);
  for (int64_t n = 0; n < b->mesh.vertex_count; n++) {
    const double *x = b->mesh.vertices + 3 * n;
    u[3 * n] = 0.1 * x[0];
    u[3 * n + 1] = 0.15 * x[0] * x[0];
    v[3 * n] = 0.3 - 2 * x[1] + 1 * x[2];
    v[3 * n + 1] = -0.2 + 2 * x[0] - 3 * x[2];
    v[3 * n + 2] = 0.5 - 1 * x[0] + 3 * x[1] + 0.5 * x[0] * x[0];
  }
  assert_int_equal(thrum_full_set(full, u, v, NULL), THRUM_OK);
  free(u);
  free(v);
}

static void tumble(const body *b, thrum_law law, int steps) {
  // a tight tolerance, so that the conservation laws hold to rounding
  thrum_full_def def = thrum_default_full_def();
  def.law = law;
  def.dt = 0.01;
  def.tolerance = 1e-13;
  thrum_full *full = full_make(&b->model, NULL, &def);
  throw_body(b, full);

  // the conserved quantities at the start
  const double energy = thrum_full_energy(full).total;
  double linear[3], angular[3], p[3], l[3];
  thrum_full_momentum(full, linear, angular);
  double exchanged = 0, potential = thrum_full_energy(full).potential;

  // they hold at every step
  for (int k = 0; k < steps; k++) {
    full_steps(full, 1);
    const thrum_full_energies now = thrum_full_energy(full);
    thrum_full_momentum(full, p, l);
    assert_true(fabs(now.total - energy) <= 1e-10 * energy);
    exchanged = fmax(exchanged, fabs(now.potential - potential));
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs(p[axis] - linear[axis]) <= 1e-10 * fabs(linear[0]));
      assert_true(fabs(l[axis] - angular[axis]) <= 1e-10 * 100);
    }
  }

  // the motion was not trivial: energy was exchanged, and the body rotates
  assert_true(exchanged > 0.1 * energy);
  assert_true(sqrt(angular[0] * angular[0] + angular[2] * angular[2]) > 1);
  thrum_full_free(full);
}

static void a_tumbling_body_keeps_energy_and_both_momenta(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:5x1x1@1x0.2x0.2", false);
  tumble(&b, THRUM_LAW_STVK, 300);
  tumble(&b, THRUM_LAW_COROTATIONAL, 100);
  tumble(&b, THRUM_LAW_NEO_HOOKEAN, 100);
  body_divide(&b, 3, three_laws);
  tumble(&b, THRUM_LAW_BY_REGION, 100);
  body_free(&b);
}

/* Pressed to 0.4 of its length between two plates: linear elasticity without the rotation says how
 * wide the body becomes, and Saint Venant-Kirchhoff material gives way. */
static void a_corotational_bar_pressed_flat_is_as_wide_as_its_law_says(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:3x2x2@1x0.4x0.4", false);
  uint8_t *held = calloc((size_t)b.mesh.vertex_count, 1);
  double *moves = field_make(&b), *u = field_make(&b), *none = field_make(&b);

  // both ends slide on their plates, two sides on theirs
  for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
    const double *x = b.mesh.vertices + 3 * v;
    held[v] = (uint8_t)((x[0] < 1e-9 || x[0] > 1 - 1e-9 ? 1 : 0) | (x[1] < -0.2 + 1e-9 ? 2 : 0) |
                        (x[2] < -0.2 + 1e-9 ? 4 : 0));
    moves[3 * v] = x[0] > 1 - 1e-9 ? -0.6 : 0;
  }

  thrum_full_def def = thrum_default_full_def();
  def.law = THRUM_LAW_COROTATIONAL;
  thrum_full *full = full_make(&b.model, held, &def);
  thrum_full_equilibrium found;
  assert_int_equal(thrum_full_rest(full, none, moves, &found, NULL), THRUM_OK);
  thrum_full_get(full, u, NULL);
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    for (int axis = 1; axis < 3; axis++)
      assert_true(fabs(u[3 * v + axis] - 0.3 * 0.6 * (b.mesh.vertices[3 * v + axis] + 0.2)) <=
                  1e-10);
  assert_true(fabs(found.energy - 0.16 * 0.5 * 1e6 * 0.36) <= 1e-9 * found.energy);

  thrum_full_free(full);
  free(held);
  free(moves);
  free(u);
  free(none);
  body_free(&b);
}

/* P along x and the energy density at a stretch s where the cross section stays as it is. */
static double confined_stress(thrum_law law, double lambda, double mu, double s, double *energy) {
  const double whole = lambda + 2 * mu;
  if (law == THRUM_LAW_STVK) {
    *energy = whole * (s * s - 1) * (s * s - 1) / 8;
    return whole * s * (s * s - 1) / 2;
  }
  if (law == THRUM_LAW_COROTATIONAL) {
    *energy = whole * (s - 1) * (s - 1) / 2;
    return whole * (s - 1);
  }
  const double m = 4.0 / 3 * mu, l = lambda + 5.0 / 6 * mu, a = 1 + 0.75 * m / l;
  *energy = m / 2 * (s * s - 1) - m / 2 * log((s * s + 3) / 4) +
            l / 2 * ((s - a) * (s - a) - (1 - a) * (1 - a));
  return m * (1 - 1 / (s * s + 3)) * s + l * (s - a);
}

/* The stretch at which a law bears the stress. */
static double confined_stretch(thrum_law law, double lambda, double mu, double stress) {
  double low = 0.7, high = 3, unused;
  for (int k = 0; k < 100; k++) {
    const double middle = 0.5 * (low + high);
    *(confined_stress(law, lambda, mu, middle, &unused) < stress ? &low : &high) = middle;
  }
  return low;
}

/* A bar whose far end is moved as far as its regions, of these laws and equally long, are stretched
 * by one stress: each region is stretched as its law says. Sides are held where they would move. */
static void pull_in_series(double poisson, bool sides_held, int count, const uint8_t *laws) {
  body b;
  body_make(&b, "beam:6x2x2@1x0.4x0.4", false);
  b.material[1] = poisson;
  body_divide(&b, count, laws);
  const double young = b.material[0], mu = young / (2 * (1 + poisson)),
               lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  double stretch[3], energy = 0, length = 0;

  // one stress in all regions, and what each is stretched by and stores under it
  for (int i = 0; i < count; i++) {
    double density;
    stretch[i] = confined_stretch((thrum_law)laws[i], lambda, mu, 0.4 * young);
    confined_stress((thrum_law)laws[i], lambda, mu, stretch[i], &density);
    energy += 0.16 / count * density;
    length += stretch[i] / count;
  }

  // the far end is moved as far as that
  uint8_t *held = calloc((size_t)b.mesh.vertex_count, 1);
  double *moves = field_make(&b), *u = field_make(&b), *none = field_make(&b);
  for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
    const double *x = b.mesh.vertices + 3 * v;
    const bool y = sides_held || x[1] < -0.2 + 1e-9, z = sides_held || x[2] < -0.2 + 1e-9;
    held[v] = (uint8_t)((x[0] < 1e-9 || x[0] > 1 - 1e-9 ? 1 : 0) | (y ? 2 : 0) | (z ? 4 : 0));
    moves[3 * v] = x[0] > 1 - 1e-9 ? length - 1 : 0;
  }

  // every vertex lies where the stretches have it
  thrum_full_def def = thrum_default_full_def();
  def.law = THRUM_LAW_BY_REGION;
  thrum_full *full = full_make(&b.model, held, &def);
  thrum_full_equilibrium found;
  assert_int_equal(thrum_full_rest(full, none, moves, &found, NULL), THRUM_OK);
  thrum_full_get(full, u, NULL);
  for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
    double expected = -b.mesh.vertices[3 * v];
    for (int i = 0; i < count; i++)
      expected +=
          stretch[i] * fmin(fmax(b.mesh.vertices[3 * v] - i / (double)count, 0), 1.0 / count);
    assert_true(fabs(u[3 * v] - expected) <= 1e-10 && fabs(u[3 * v + 1]) <= 1e-10);
  }
  assert_true(fabs(found.energy - energy) <= 1e-9 * energy);

  thrum_full_free(full);
  free(held);
  free(moves);
  free(u);
  free(none);
  body_free(&b);
}

static void regions_in_series_are_stretched_as_their_laws_say(void **state) {
  (void)state;
  // bars under tension, of materials that do not become narrower
  pull_in_series(0, false, 2, three_laws);

  // bars whose sides are held, of all laws
  pull_in_series(0.3, true, 2, three_laws + 1);
  pull_in_series(0.3, true, 3, three_laws);
}

static void a_body_without_laws_of_its_regions_is_not_stepped_by_them(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:3x1x1@1x0.4x0.4", true);
  thrum_full_def def = thrum_default_full_def();
  thrum_full *full = NULL;
  thrum_error error;
  def.law = THRUM_LAW_BY_REGION;
  assert_int_equal(thrum_full_create(&b.model, NULL, &def, &full, &error), THRUM_MISSING);
  assert_non_null(strstr(error.message, "the regions of this model have no laws of their own"));
  assert_null(full);
  body_free(&b);
}

/* All vertices that are free are moved by up to a cell, which turns tetrahedra inside out. */
static void a_body_turned_inside_out_comes_back_to_rest(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:3x2x2@1x0.4x0.4", true);
  double *u = field_make(&b), *none = field_make(&b);

  const uint8_t mixed[] = {THRUM_LAW_NEO_HOOKEAN, THRUM_LAW_COROTATIONAL};
  body_divide(&b, 2, mixed);
  for (int law = THRUM_LAW_COROTATIONAL; law <= THRUM_LAW_BY_REGION; law++) {
    thrum_full_def def = thrum_default_full_def();
    def.law = (thrum_law)law;
    thrum_full *full = full_make(&b.model, NULL, &def);
    for (int64_t c = 0; c < 3 * b.mesh.vertex_count; c++)
      u[c] = 0.2 * sin(17.0 * (double)(c * c % 101));
    assert_int_equal(thrum_full_set(full, u, NULL, NULL), THRUM_OK);
    assert_true(thrum_full_energy(full).potential > 1e3);

    // Newton finds the shape at rest
    thrum_full_equilibrium found;
    assert_int_equal(thrum_full_rest(full, none, NULL, &found, NULL), THRUM_OK);
    thrum_full_get(full, u, NULL);
    assert_true(largest(u, none, 3 * b.mesh.vertex_count) <= 1e-6);
    thrum_full_free(full);
  }

  free(u);
  free(none);
  body_free(&b);
}

/* A clamped beam whose tip is thrown up; the largest displacement at rest after `steps`. */
static double bend(const body *b, thrum_law law, thrum_plastic plastic, int steps, double *u) {
  thrum_full_def def = thrum_default_full_def();
  def.law = law;
  def.plastic = plastic;
  def.dt = 0.002;
  def.tolerance = 1e-12;
  thrum_full *full = full_make(&b->model, NULL, &def);
  double *v = field_make(b), *none = field_make(b);
  for (int64_t n = 0; n < b->mesh.vertex_count; n++)
    v[3 * n + 2] = 8 * b->mesh.vertices[3 * n] * b->mesh.vertices[3 * n];
  assert_int_equal(thrum_full_set(full, NULL, v, NULL), THRUM_OK);

  // what is stored, what moves and what has flowed add up
  const double energy = thrum_full_energy(full).total;
  double work = 0;
  for (int k = 0; k < steps; k++) {
    full_steps(full, 1);
    const double flowed = thrum_full_report_get(full).plastic_work;
    assert_true(flowed >= work);
    work = flowed;
    assert_true(fabs(thrum_full_energy(full).total + work - energy) <= 1e-9 * energy);
  }
  thrum_full_get(full, u, NULL);
  assert_true(thrum_full_plastic_strain(full) <= plastic.largest);
  const bool flows = plastic.yield < 1 && plastic.largest > 1e-6;
  assert_true(isinf(plastic.yield) ? work == 0 : work > 0.05 * energy || !flows);

  // brought to rest without a load, as it has become
  thrum_full_equilibrium found;
  assert_int_equal(thrum_full_set(full, NULL, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_full_rest(full, none, NULL, &found, NULL), THRUM_OK);
  thrum_full_get(full, none, NULL);
  const double bent = largest(none, NULL, 3 * b->mesh.vertex_count);

  // cleared it is straight again
  thrum_full_clear_plastic(full);
  assert_true(thrum_full_plastic_strain(full) == 0);
  assert_true(thrum_full_report_get(full).plastic_work == 0);
  assert_int_equal(thrum_full_set(full, NULL, NULL, NULL), THRUM_OK);
  assert_true(thrum_full_energy(full).total == 0);
  free(v);
  free(none);
  thrum_full_free(full);
  return bent;
}

static void a_body_bent_beyond_its_yield_stays_bent_and_its_account_closes(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:6x1x1@1x0.2x0.2", true);
  double *u = field_make(&b), *elastic = field_make(&b);
  const int64_t all = 3 * b.mesh.vertex_count;
  const thrum_plastic none = {INFINITY, INFINITY, INFINITY};

  // each law bends; it bends less with a bound on the plastic strain, and less with time to flow
  for (int law = THRUM_LAW_STVK; law <= THRUM_LAW_NEO_HOOKEAN; law++) {
    const double soft = bend(&b, (thrum_law)law, (thrum_plastic){0.02, INFINITY, INFINITY}, 40, u);
    const double slow = bend(&b, (thrum_law)law, (thrum_plastic){0.02, 30, INFINITY}, 40, u);
    const double bound = bend(&b, (thrum_law)law, (thrum_plastic){0.02, INFINITY, 0.03}, 40, u);
    assert_true(soft > 0.05 && slow > 0.01 && slow < 0.9 * soft && bound < 0.9 * soft);
  }

  // only regions with a yield flow; their own yield comes before that of the body
  static const uint8_t two[] = {THRUM_LAW_COROTATIONAL, THRUM_LAW_STVK};
  static const double own[] = {0.02, 0};
  const thrum_plastic bend_all = {0.02, INFINITY, INFINITY}, stiff = {2, INFINITY, INFINITY};
  body_divide(&b, 2, two);
  const double by_body = bend(&b, THRUM_LAW_BY_REGION, bend_all, 40, u);
  assert_true(by_body > 0.05 && bend(&b, THRUM_LAW_BY_REGION, none, 10, u) <= 1e-9);
  b.model.region_yield = own;
  assert_true(bend(&b, THRUM_LAW_BY_REGION, stiff, 40, elastic) == by_body);

  // a bound far below what a step would flow is reached all the same
  const thrum_plastic narrow = {0.02, INFINITY, 1e-9};
  assert_true(bend(&b, THRUM_LAW_COROTATIONAL, narrow, 10, u) > 1e-11);

  // within the yield it is the elastic body, bit by bit, and comes back
  assert_true(bend(&b, THRUM_LAW_COROTATIONAL, none, 10, elastic) <= 1e-9);
  assert_true(bend(&b, THRUM_LAW_COROTATIONAL, (thrum_plastic){2, 1, 1}, 10, u) <= 1e-9);
  assert_memory_equal(u, elastic, (size_t)all * sizeof *u);
  free(u);
  free(elastic);
  body_free(&b);
}

/* A corner torn away at 150 m/s: the first tries of a step end where no matrix has factors, and
 * shorter steps stand in, with no error left behind. */
static void a_corner_torn_away_is_stepped_by_shorter_steps(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:4x2x2@1x0.15x0.15", false);
  double *v = field_make(&b);
  v[3 * (b.mesh.vertex_count - 1) + 2] = -150;

  for (int k = 0; k < 2; k++) {
    thrum_full_def def = thrum_default_full_def();
    def.law = THRUM_LAW_NEO_HOOKEAN;
    def.solver = k == 0 ? THRUM_FULL_CHOLESKY : THRUM_FULL_CG;
    thrum_full *full = full_make(&b.model, NULL, &def);
    assert_int_equal(thrum_full_set(full, NULL, v, NULL), THRUM_OK);
    const double energy = thrum_full_energy(full).total;
    for (int step = 0; step < 10; step++) {
      thrum_error error = {0};
      assert_int_equal(thrum_full_step(full, &error), THRUM_OK);
      assert_true(error.status == THRUM_OK && error.message[0] == 0);
    }

    // shorter steps were needed, and the energy is that of the start
    assert_true(thrum_full_report_get(full).substep_steps > 0);
    assert_true(fabs(thrum_full_energy(full).total - energy) <= 1e-8 * energy);
    thrum_full_free(full);
  }

  free(v);
  body_free(&b);
}

static void an_impulse_counts_once_in_every_scheme(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:4x1x1@1x0.25x0.25", false);

  // gravity and a point force, both along z
  double *forces = field_make(&b);
  const double g[3] = {0, 0, 4};

  // every scheme: three steps at rest, two under the load, then free flight
  for (int scheme = 0; scheme < 4; scheme++) {
    thrum_full_def def = thrum_default_full_def();
    def.scheme = (thrum_full_scheme)scheme;
    def.dt = 0.0005;
    thrum_full *full = full_make(&b.model, NULL, &def);
    memset(forces, 0, 3 * (size_t)b.mesh.vertex_count * sizeof *forces);
    thrum_full_add_gravity(full, g, forces);
    forces[2] += 10;
    full_steps(full, 3);
    assert_int_equal(thrum_full_set_force(full, forces, NULL), THRUM_OK);
    full_steps(full, 2);
    assert_int_equal(thrum_full_set_force(full, NULL, NULL), THRUM_OK);
    full_steps(full, 20);

    // the momentum is the load's impulse, no more and no less
    double p[3], l[3];
    thrum_full_momentum(full, p, l);
    const double mass = 1000 * 0.0625, whole = (mass * 4 + 10) * 2 * def.dt;
    assert_true(fabs(p[2] - whole) <= 1e-8 * whole);
    assert_true(fabs(p[0]) + fabs(p[1]) <= 1e-8 * whole);
    thrum_full_free(full);
  }

  free(forces);
  body_free(&b);
}

/* u is the displacement of a clamped beam 0.05 s after a strong impulse. */
static void strike(const body *b, thrum_full_scheme scheme, thrum_full_solver solver, double dt,
                   double *u) {
  thrum_full_def def = thrum_default_full_def();
  def.scheme = scheme;
  def.solver = solver;
  def.dt = dt;
  def.solver_tolerance = 1e-12;
  thrum_full *full = full_make(&b->model, NULL, &def);
  double *v = field_make(b);
  for (int64_t n = 0; n < b->mesh.vertex_count; n++)
    v[3 * n + 2] = 6 * b->mesh.vertices[3 * n] * b->mesh.vertices[3 * n];
  assert_int_equal(thrum_full_set(full, NULL, v, NULL), THRUM_OK);
  full_steps(full, (int)(0.05 / dt + 0.5));
  thrum_full_get(full, u, NULL);
  thrum_full_free(full);
  free(v);
}

static void schemes_converge_to_one_motion_with_order_two(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:6x1x1@1x0.2x0.2", true);
  const int64_t all = 3 * b.mesh.vertex_count;
  double *exact = field_make(&b), *coarse = field_make(&b), *fine = field_make(&b);

  // the motion is large enough for the nonlinearity to matter
  strike(&b, THRUM_FULL_CENTRAL, THRUM_FULL_CHOLESKY, 2e-5, exact);
  assert_true(largest(exact, NULL, all) > 0.1);

  // the implicit schemes, against the midpoint rule at a fine step
  for (int scheme = 0; scheme < 3; scheme++) {
    // the lumped mass defines another body, so implicit schemes are compared with each other
    strike(&b, THRUM_FULL_MIDPOINT, THRUM_FULL_CHOLESKY, 1.25e-4, exact);
    strike(&b, (thrum_full_scheme)scheme, THRUM_FULL_CHOLESKY, 2e-3, coarse);
    strike(&b, (thrum_full_scheme)scheme, THRUM_FULL_CHOLESKY, 1e-3, fine);
    const double order = log2(largest(coarse, exact, all) / largest(fine, exact, all));
    assert_true(order > 1.6);
    assert_true(largest(fine, exact, all) <= 0.01 * largest(exact, NULL, all));
  }

  // the explicit scheme against itself
  strike(&b, THRUM_FULL_CENTRAL, THRUM_FULL_CHOLESKY, 2e-5, exact);
  strike(&b, THRUM_FULL_CENTRAL, THRUM_FULL_CHOLESKY, 2e-4, coarse);
  strike(&b, THRUM_FULL_CENTRAL, THRUM_FULL_CHOLESKY, 1e-4, fine);
  assert_true(log2(largest(coarse, exact, all) / largest(fine, exact, all)) > 1.6);

  free(exact);
  free(coarse);
  free(fine);
  body_free(&b);
}

static void conjugate_gradients_give_what_cholesky_gives(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:6x1x1@1x0.2x0.2", true);
  const int64_t all = 3 * b.mesh.vertex_count;
  double *one = field_make(&b), *other = field_make(&b);
  for (int scheme = 0; scheme < 2; scheme++) {
    strike(&b, (thrum_full_scheme)scheme, THRUM_FULL_CHOLESKY, 2e-3, one);
    strike(&b, (thrum_full_scheme)scheme, THRUM_FULL_CG, 2e-3, other);
    assert_true(largest(one, other, all) <= 1e-7 * largest(one, NULL, all));
  }
  free(one);
  free(other);
  body_free(&b);
}

static void central_differences_refuse_an_unstable_step(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:6x1x1@1x0.2x0.2", true);

  // a step far beyond the bound is refused
  thrum_full_def def = thrum_default_full_def();
  def.scheme = THRUM_FULL_CENTRAL;
  def.dt = 1;
  thrum_full *full = NULL;
  thrum_error error;
  assert_int_equal(thrum_full_create(&b.model, NULL, &def, &full, &error), THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "not stable"));

  // the scheme's own estimate of the bound
  def.dt = 1e-5;
  full = full_make(&b.model, NULL, &def);
  const double stable = thrum_full_report_get(full).dt_stable;
  thrum_full_free(full);

  // just below the bound a small motion stays bounded for thousands of steps
  def.dt = 0.9999 * stable;
  full = full_make(&b.model, NULL, &def);
  double *v = field_make(&b);
  for (int64_t n = 0; n < b.mesh.vertex_count; n++)
    v[3 * n + 1] = 1e-7 * (double)((n % 3) - 1);
  assert_int_equal(thrum_full_set(full, NULL, v, NULL), THRUM_OK);
  const double energy = thrum_full_energy(full).total;
  full_steps(full, 3000);

  // near the bound the scheme's conserved energy differs much from the body's, but it is bounded
  assert_true(thrum_full_energy(full).total < 1e4 * energy);

  // just above the bound the step is refused: the estimate is at most one percent too cautious
  def.dt = 1.01 * stable;
  thrum_full *none = NULL;
  assert_int_equal(thrum_full_create(&b.model, NULL, &def, &none, NULL), THRUM_INVALID_ARGUMENT);

  thrum_full_free(full);
  free(v);
  body_free(&b);
}

/* A body with its full-order model and its reduced model, made from a clamped beam. */
typedef struct reduced {
  body b;
  thrum_precomputed made;
} reduced;

static void reduced_make(reduced *r, const char *spec) {
  thrum_error error;
  body_make(&r->b, spec, true);
  r->b.mesh.materials[0] = (thrum_material){1e6, 0.3, 1000};
  r->b.mesh.has_material = true;
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 6;
  options.rank = 20;
  if (thrum_precompute(&r->b.mesh, r->b.fixed, &options, &r->made, &error) < 0)
    fail_msg("%s", error.message);
}

static void reduced_free(reduced *r) {
  thrum_precomputed_free(&r->made);
  body_free(&r->b);
}

/* Released from a linear mode of small amplitude, a body oscillates as a cosine of its frequency,
 * and its coordinates are those of the reduced model. */
static void small_swings_have_the_linear_frequencies(void **state) {
  (void)state;
  reduced r;
  reduced_make(&r, "beam:6x2x2@1x0.2x0.15");
  const thrum_model *model = &r.made.model;
  const int64_t all = 3 * model->vertex_count;
  double *u = field_make(&r.b);
  double q[20] = {0}, now[20];

  // the first three modes, resolved with 400 steps per period
  for (int mode = 0; mode < 3; mode++) {
    const double omega = sqrt(model->omega2[mode]), amplitude = 1e-7;
    thrum_full_def def = thrum_default_full_def();
    def.dt = tau / omega / 400;
    thrum_full *full = full_make(model, NULL, &def);

    // a displacement along one mode has that mode's coordinate alone
    memset(q, 0, sizeof q);
    q[mode] = amplitude;
    assert_int_equal(thrum_displacement(model, q, 0, model->vertex_count, u, NULL), THRUM_OK);
    thrum_full_project(full, u, now);
    for (int i = 0; i < 20; i++)
      assert_true(fabs(now[i] - q[i]) <= 1e-12 * amplitude);

    // the motion from there, over more than a period
    assert_int_equal(thrum_full_set(full, u, NULL, NULL), THRUM_OK);
    for (int k = 1; k <= 500; k++) {
      full_steps(full, 1);
      thrum_full_get(full, u, NULL);
      thrum_full_project(full, u, now);

      // the midpoint rule's phase is late by (omega h)^2/12 of itself
      const double slow = 2 / (def.dt * omega) * atan(def.dt * omega / 2);
      assert_true(fabs(now[mode] - amplitude * cos(slow * omega * def.dt * k)) <= 1e-4 * amplitude);
    }
    thrum_full_free(full);
  }

  // the last state is not the rest state
  assert_true(largest(u, NULL, all) > 0);

  free(u);
  reduced_free(&r);
}

/* A search that fails leaves the load of the steps to come as it was, too. */
static void a_failed_search_leaves_the_load(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:2x1x1@1x0.2x0.2", true);
  thrum_full_def def = thrum_default_full_def();
  def.dt = 0.002;
  double *forces = field_make(&b), *seen = field_make(&b), *alone = field_make(&b);

  // the first one searches before it steps, the second does not
  for (int n = 0; n < 2; n++) {
    thrum_full *full = full_make(&b.model, NULL, &def);
    memset(forces, 0, 3 * (size_t)b.mesh.vertex_count * sizeof *forces);
    forces[3 * b.mesh.vertex_count - 1] = 2;
    assert_int_equal(thrum_full_set_force(full, forces, NULL), THRUM_OK);

    // forces that no body of this kind bears
    thrum_full_equilibrium found;
    forces[3 * b.mesh.vertex_count - 1] = 1e200;
    if (n == 0)
      assert_true(thrum_full_rest(full, forces, NULL, &found, NULL) < 0);
    full_steps(full, 3);
    thrum_full_get(full, n == 0 ? seen : alone, NULL);
    thrum_full_free(full);
  }
  assert_true(largest(alone, NULL, 3 * b.mesh.vertex_count) > 0);
  assert_memory_equal(seen, alone, 3 * (size_t)b.mesh.vertex_count * sizeof *seen);
  free(forces);
  free(seen);
  free(alone);
  body_free(&b);
}

/* The full-order equilibrium is no stiffer than the reduced one, and near to it. */
static void reduced_and_full_equilibria_agree(void **state) {
  (void)state;
  reduced r;
  reduced_make(&r, "beam:8x2x2@1x0.2x0.2");
  const thrum_model *model = &r.made.model;

  // the full-order equilibrium under gravity
  const double g[3] = {0, 0, -9.81};
  double *forces = field_make(&r.b), *u = field_make(&r.b);
  thrum_full_def def = thrum_default_full_def();
  thrum_full *full = full_make(model, NULL, &def);
  thrum_full_add_gravity(full, g, forces);
  thrum_full_equilibrium found;
  thrum_error error;
  if (thrum_full_rest(full, forces, NULL, &found, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_true(found.residual <= 1e-10);

  // the reduced one
  double load[20] = {0}, q[20] = {0}, seen[20];
  assert_int_equal(thrum_load_add_gravity(model, g, load, NULL), THRUM_OK);
  size_t size = 0;
  thrum_equilibrium_size(model, &size, NULL);
  void *workspace = aligned_alloc(64, size);
  const thrum_equilibrium_def search = thrum_default_equilibrium_def();
  thrum_equilibrium_report report;
  assert_int_equal(thrum_equilibrium(model, &search, load, q, workspace, size, &report, NULL),
                   THRUM_OK);

  // the full space contains the reduced one, so its minimum of the energy is lower, but not by much
  const double full_energy = found.energy + found.load_energy;
  const double reduced_energy = report.energy + report.load_energy;
  assert_true(full_energy <= reduced_energy);
  assert_true(reduced_energy - full_energy <= 0.02 * fabs(full_energy));

  // the displacements agree too
  thrum_full_get(full, u, NULL);
  assert_true(largest(u, NULL, 3 * model->vertex_count) > 0.05);
  thrum_full_project(full, u, seen);
  assert_true(fabs(seen[0] - q[0]) <= 0.02 * fabs(q[0]) ||
              fabs(seen[1] - q[1]) <= 0.02 * fabs(q[1]));

  // the body rests in its equilibrium
  for (int k = 0; k < 20; k++)
    assert_int_equal(thrum_full_step(full, NULL), THRUM_OK);
  assert_true(thrum_full_energy(full).kinetic <= 1e-15 * found.energy);

  free(workspace);
  free(forces);
  free(u);
  thrum_full_free(full);
  reduced_free(&r);
}

static void impossible_definitions_and_loads_are_refused(void **state) {
  (void)state;
  body b;
  body_make(&b, "beam:4x1x1@1x0.2x0.2", true);

  // a definition that no default function filled
  thrum_full_def def = {0};
  thrum_full *full = NULL;
  assert_int_equal(thrum_full_create(&b.model, NULL, &def, &full, NULL), THRUM_UNINITIALISED_DEF);

  // a negative time step
  def = thrum_default_full_def();
  def.dt = -1;
  assert_int_equal(thrum_full_create(&b.model, NULL, &def, &full, NULL), THRUM_INVALID_ARGUMENT);

  // with beta = 0 Newmark's scheme would be explicit
  def = thrum_default_full_def();
  def.scheme = THRUM_FULL_NEWMARK;
  def.newmark_beta = 0;
  assert_int_equal(thrum_full_create(&b.model, NULL, &def, &full, NULL), THRUM_INVALID_ARGUMENT);

  // a model without a mesh
  const thrum_model empty = {.rank = 1};
  def = thrum_default_full_def();
  assert_int_equal(thrum_full_create(&empty, NULL, &def, &full, NULL), THRUM_MISSING);

  // states and forces that are not numbers
  full = full_make(&b.model, NULL, &def);
  double *bad = field_make(&b);
  bad[5] = NAN;
  assert_int_equal(thrum_full_set(full, bad, NULL, NULL), THRUM_BAD_VALUE);
  assert_int_equal(thrum_full_set_force(full, bad, NULL), THRUM_BAD_VALUE);

  free(bad);
  thrum_full_free(full);
  body_free(&b);
}

/* A body that flies without deforming loses speed to alpha alone: each scheme of order 2 multiplies
 * it by (1 - alpha h/2) / (1 + alpha h/2) in a step, Newmark's with its usual numbers as well. */
static void a_flying_body_is_slowed_by_alpha(void **state) {
  (void)state;
  static const thrum_full_scheme schemes[] = {THRUM_FULL_NEWMARK, THRUM_FULL_ENERGY,
                                              THRUM_FULL_MIDPOINT, THRUM_FULL_CENTRAL};
  body b;
  body_make(&b, "beam:2x1x1@1x0.5x0.5", false);
  const int64_t all = 3 * b.mesh.vertex_count;
  double *v = calloc(2 * (size_t)all, sizeof *v);
  assert_non_null(v);
  for (size_t n = 0; n < sizeof schemes / sizeof *schemes; n++) {
    thrum_full_def def = thrum_default_full_def();
    def.scheme = schemes[n];
    def.dt = 1e-3;
    def.damping_alpha = 200;
    thrum_full *full = full_make(&b.model, NULL, &def);
    for (int64_t c = 0; c < all; c++)
      v[c] = 1 + (double)(c % 3);
    thrum_error error;
    assert_int_equal(thrum_full_set(full, NULL, v, &error), THRUM_OK);
    for (int k = 0; k < 10; k++)
      if (thrum_full_step(full, &error) < 0)
        fail_msg("%s", error.message);
    thrum_full_get(full, NULL, v + all);
    const double left = pow((1 - 0.1) / (1 + 0.1), 10);
    for (int64_t c = 0; c < all; c++)
      assert_true(fabs(v[all + c] - left * v[c]) <= 1e-8);
    thrum_full_free(full);
  }
  free(v);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_uniform_deformation_is_met_exactly),
      cmocka_unit_test(a_flying_body_is_slowed_by_alpha),
      cmocka_unit_test(a_tumbling_body_keeps_energy_and_both_momenta),
      cmocka_unit_test(a_corotational_bar_pressed_flat_is_as_wide_as_its_law_says),
      cmocka_unit_test(regions_in_series_are_stretched_as_their_laws_say),
      cmocka_unit_test(a_body_without_laws_of_its_regions_is_not_stepped_by_them),
      cmocka_unit_test(a_body_turned_inside_out_comes_back_to_rest),
      cmocka_unit_test(a_body_bent_beyond_its_yield_stays_bent_and_its_account_closes),

      // what all schemes and solvers have in common
      cmocka_unit_test(a_corner_torn_away_is_stepped_by_shorter_steps),
      cmocka_unit_test(an_impulse_counts_once_in_every_scheme),
      cmocka_unit_test(schemes_converge_to_one_motion_with_order_two),
      cmocka_unit_test(conjugate_gradients_give_what_cholesky_gives),
      cmocka_unit_test(central_differences_refuse_an_unstable_step),
      cmocka_unit_test(small_swings_have_the_linear_frequencies),
      cmocka_unit_test(reduced_and_full_equilibria_agree),
      cmocka_unit_test(a_failed_search_leaves_the_load),
      cmocka_unit_test(impossible_definitions_and_loads_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
