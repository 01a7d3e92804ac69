/* Tests of strain and stress from q: closed forms of the StVK material in homogeneous deformations,
 * the energy of the reduced polynomial, the von Mises stress of known states, and the arguments
 * that are refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/closed_forms.h"
#include "tests/support/linear_fields.h"
#include "thrum/polynomial.h"

#define YOUNG 2e6
#define TETS_MAX 64

/* All fields of every tetrahedron of a body of linear fields. */
typedef struct readings {
  double strain[6 * TETS_MAX], second[6 * TETS_MAX], cauchy[6 * TETS_MAX];
  double mises[TETS_MAX], stretch[TETS_MAX];
} readings;

static void read_all(const thrum_stress_points *stress_points, const double *q, readings *r) {
  const thrum_stress_points_output output = {r->strain, r->second, r->cauchy, r->mises, r->stretch};
  assert_true(thrum_stress_points_count(stress_points) <= TETS_MAX);
  double *work = need((size_t)thrum_stress_points_work_count(stress_points), sizeof *work);
  assert_int_equal(thrum_stress_points_read(stress_points, q, work, &output, NULL), THRUM_OK);
  free(work);
}

static void a_bar_in_uniaxial_stretch_has_the_stress_of_the_closed_form(void **state) {
  (void)state;

  // a bar whose lateral contraction is zero
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x0.5x0.5", YOUNG, 0);
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);
  static readings r;

  // in uniaxial stretch every tetrahedron has the same state
  for (double l = 0.3; l < 2; l += 0.1) {
    const double q[FIELDS] = {l - 1};
    read_all(stress_points, q, &r);
    for (int64_t n = 0; n < thrum_stress_points_count(stress_points); n++) {
      assert_within(r.strain[6 * n], (l * l - 1) / 2, 1e-14);
      assert_within(r.second[6 * n], YOUNG * (l * l - 1) / 2, 1e-14 * YOUNG);
      // the section keeps its area at nu = 0, so sigma = P / A = l S
      assert_within(r.cauchy[6 * n], YOUNG * l * (l * l - 1) / 2, 1e-14 * YOUNG);
      assert_within(r.mises[n], fabs(r.cauchy[6 * n]), 1e-14 * YOUNG);
      assert_within(r.stretch[n], fmin(l, 1), 1e-14);
      for (int c = 1; c < 6; c++)
        assert_within(r.cauchy[6 * n + c], 0, 1e-14 * YOUNG);
    }
  }

  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

static void the_stress_of_another_law_is_its_closed_form(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x0.5x0.5", YOUNG, 0.4);
  static readings r;
  const double lambda = YOUNG * 0.4 / (1.4 * 0.2), mu = YOUNG / 2.8;
  for (int law = THRUM_LAW_COROTATIONAL; law <= THRUM_LAW_NEO_HOOKEAN; law++) {
    const char *name = thrum_law_name((thrum_law)law);
    fields.model.point_law = (const uint8_t *)name;
    fields.model.law_bytes = (int64_t)strlen(name) + 1;
    const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);

    // free across: S = P/s, and sigma = P/t^2 is all there is
    for (double s = 0.6; s < 1.5; s += 0.3) {
      double t;
      const double along = tension_form((thrum_law)law, lambda, mu, s, &t);
      const double q[FIELDS] = {s - 1, 0, 0, 0, t - 1, 0, 0, 0, t - 1};
      read_all(stress_points, q, &r);
      for (int64_t n = 0; n < thrum_stress_points_count(stress_points); n++) {
        assert_within(r.second[6 * n], along / s, 1e-10 * YOUNG);
        assert_within(r.cauchy[6 * n], along / (t * t), 1e-10 * YOUNG);
        assert_within(r.mises[n], fabs(r.cauchy[6 * n]), 1e-10 * YOUNG);
      }
    }
    stress_points_free(stress_points);
  }
  linear_fields_free(&fields);
}

static void the_stress_of_each_region_is_that_of_its_law(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x0.5x0.5", YOUNG, 0.4);
  static readings r;
  static const uint8_t laws[] = {THRUM_LAW_STVK, THRUM_LAW_COROTATIONAL, THRUM_LAW_NEO_HOOKEAN};
  const double material[] = {YOUNG, 0.4, 1000, YOUNG, 0.4, 1000, YOUNG, 0.4, 1000};
  const double lambda = YOUNG * 0.4 / (1.4 * 0.2), mu = YOUNG / 2.8, k = 0.3;
  int32_t regions[64];
  assert_true(fields.model.tet_count <= 64);
  for (int t = 0; t < 64; t++)
    regions[t] = t % 3;
  fields.model.tet_region = regions;
  fields.model.material = material;
  fields.model.region_count = fields.model.law_count = 3;
  fields.model.region_law = laws;
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);

  // in simple shear sigma = P F^T has sigma_xy = P_xy
  const double q[FIELDS] = {0, k};
  read_all(stress_points, q, &r);
  for (int64_t n = 0; n < thrum_stress_points_count(stress_points); n++) {
    const shear_stress shear = shear_form((thrum_law)laws[n % 3], lambda, mu, k);
    assert_within(r.cauchy[6 * n + 3], shear.xy, 1e-10 * YOUNG);
  }
  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

static void the_compressive_force_peaks_at_stretch_one_over_root_three(void **state) {
  (void)state;

  // a single cell without lateral contraction
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", YOUNG, 0);
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);
  static readings r;

  // the largest compressive force over a range of stretches
  double peak = 0, at = 0;
  for (int n = 4000; n <= 8000; n++) {
    const double q[FIELDS] = {n * 1e-4 - 1};
    read_all(stress_points, q, &r);
    if (-r.cauchy[0] > peak) {
      peak = -r.cauchy[0];
      at = n * 1e-4;
    }
  }

  // the derivative of l (l^2 - 1) / 2 vanishes at 1 / sqrt(3)
  assert_within(at, 1 / sqrt(3), 1e-4);
  assert_within(peak / YOUNG, 1 / sqrt(27), 1e-7);

  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

static void a_rotation_strains_nothing_and_turns_the_cauchy_stress(void **state) {
  (void)state;

  linear_fields fields;
  linear_fields_make(&fields, "beam:2x1x1@1x0.5x0.5", YOUNG, 0.3);
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);
  static readings turned, still;
  // a rotation about z by 0.7: R - 1, and R (1 + H) - 1
  const double c = cos(0.7), s = sin(0.7), h[FIELDS] = {0.1, 0.02, 0, 0, -0.05, 0.03, 0.01, 0, 0.2};
  double rigid[FIELDS] = {c - 1, -s, 0, s, c - 1, 0, 0, 0, 0}, both[FIELDS];
  const double rotation[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      both[3 * i + j] = -(i == j);
      for (int k = 0; k < 3; k++)
        both[3 * i + j] += rotation[i][k] * (h[3 * k + j] + (k == j));
    }

  // the rotation alone strains nothing
  read_all(stress_points, rigid, &turned);
  for (int64_t n = 0; n < 6 * thrum_stress_points_count(stress_points); n++)
    assert_within(turned.strain[n], 0, 1e-15);

  // after a deformation the rotation leaves strain and stretch and rotates the stress
  read_all(stress_points, h, &still);
  read_all(stress_points, both, &turned);
  for (int64_t n = 0; n < thrum_stress_points_count(stress_points); n++) {
    for (int m = 0; m < 6; m++)
      assert_within(turned.strain[6 * n + m], still.strain[6 * n + m], 1e-15);
    // R sigma R^T: zz, the trace and von Mises stay, xx changes
    const double *sigma = still.cauchy + 6 * n;
    const double xx = c * c * sigma[0] - 2 * c * s * sigma[3] + s * s * sigma[1];
    assert_within(turned.cauchy[6 * n], xx, 1e-9);
    assert_within(turned.cauchy[6 * n + 2], sigma[2], 1e-9);
    assert_within(turned.mises[n], still.mises[n], 1e-9);
    assert_within(turned.stretch[n], still.stretch[n], 1e-15);
  }

  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

static void a_linear_displacement_gives_every_tetrahedron_the_same_tensors(void **state) {
  (void)state;

  // a block of several cells, all of which see the same field
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x0.6x0.7", YOUNG, 0.35);
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);
  static readings r;

  // the Green strain of a random displacement gradient
  double h[3][3], strain[3][3], q[FIELDS];
  for (int i = 0; i < FIELDS; i++)
    q[i] = h[i / 3][i % 3] = 0.3 * random_number();
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      strain[i][j] =
          0.5 * (h[i][j] + h[j][i] + h[0][i] * h[0][j] + h[1][i] * h[1][j] + h[2][i] * h[2][j]);
  const double six[6] = {strain[0][0], strain[1][1], strain[2][2],
                         strain[0][1], strain[1][2], strain[0][2]};

  // Lame's constants give the stress from it
  const double lambda = YOUNG * 0.35 / (1.35 * 0.3), mu = YOUNG / 2.7;
  const double trace = six[0] + six[1] + six[2];

  read_all(stress_points, q, &r);
  for (int64_t n = 0; n < thrum_stress_points_count(stress_points); n++) {
    assert_int_equal(thrum_stress_points_tet(stress_points, n), n);
    for (int c = 0; c < 6; c++) {
      assert_within(r.strain[6 * n + c], six[c], 1e-14);
      assert_within(r.second[6 * n + c], 2 * mu * six[c] + (c < 3 ? lambda * trace : 0),
                    1e-13 * YOUNG);
    }
    // det C is the product of the squared stretches; the least one makes C - s^2 singular
    const double s = 1 - r.stretch[n] * r.stretch[n];
    const double a = 2 * six[0] + s, b = 2 * six[1] + s, c = 2 * six[2] + s;
    const double d = 2 * six[3], e = 2 * six[4], f = 2 * six[5];
    assert_within(a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f), 0, 1e-14);
  }

  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

static void the_strains_hold_the_energy_of_the_reduced_polynomial(void **state) {
  (void)state;

  // a bent beam and the strains of all its tetrahedra
  body b = body_make("beam:6x2x2@1x0.2x0.3", "x<0.001");
  thrum_precomputed made = body_precompute(&b, 4, 9);
  const thrum_model *model = &made.model;
  const thrum_stress_points *stress_points = stress_points_make(model, NULL, 0);
  const int64_t count = thrum_stress_points_count(stress_points);

  double *strain = need((size_t)(6 * count), sizeof *strain);
  double *second = need((size_t)(6 * count), sizeof *second);
  double *work = need((size_t)thrum_stress_points_work_count(stress_points), sizeof *work);
  double *polynomial = need(thrum_work_count(model), sizeof *polynomial);

  // at random points of comparable energies in all modes
  for (int trial = 0; trial < 5; trial++) {
    double q[9], energy = 0;
    for (int i = 0; i < 9; i++)
      q[i] = 0.3 * random_number() / sqrt(model->omega2[i] / model->omega2[0]);
    const thrum_stress_points_output output = {strain, second, NULL, NULL, NULL};
    assert_int_equal(thrum_stress_points_read(stress_points, q, work, &output, NULL), THRUM_OK);

    // the strain energy is the sum over tetrahedra of half of stress times strain
    for (int64_t n = 0; n < count; n++) {
      const int32_t *v = model->tets + 4 * n;
      double e[3][3];
      for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
          e[a][i] = model->vertices[3 * v[a + 1] + i] - model->vertices[3 * v[0] + i];
      const double volume = (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                             e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                             e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
                            6;
      for (int c = 0; c < 6; c++)
        energy += volume * (c < 3 ? 0.5 : 1) * strain[6 * n + c] * second[6 * n + c];
    }

    assert_close(energy, thrum_strain_energy(model, q, polynomial), 1e-11);
  }

  free(polynomial);
  free(work);
  free(second);
  free(strain);
  stress_points_free(stress_points);
  thrum_precomputed_free(&made);
  body_free(&b);
}

static void chosen_stress_points_read_what_points_on_all_tets_read(void **state) {
  (void)state;

  // chosen tetrahedra in any order, one of them twice
  static const int32_t chosen[4] = {17, 3, 3, 40};
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x0.6x0.7", YOUNG, 0.35);
  // a random basis gives every tetrahedron its own strain
  for (int64_t n = 0; n < 3 * fields.model.vertex_count * FIELDS; n++)
    fields.basis[n] = random_number();

  // stress points on all tetrahedra and on the chosen ones
  const thrum_stress_points *all = stress_points_make(&fields.model, NULL, 0);
  const thrum_stress_points *some = stress_points_make(&fields.model, chosen, 4);
  static readings of_all, of_some, without;

  // the chosen ones are read with and without work space
  double q[FIELDS];
  for (int i = 0; i < FIELDS; i++)
    q[i] = 0.05 * random_number();
  read_all(all, q, &of_all);
  read_all(some, q, &of_some);
  const thrum_stress_points_output output = {without.strain, without.second, without.cauchy,
                                             without.mises, without.stretch};
  assert_int_equal(thrum_stress_points_read(some, q, NULL, &output, NULL), THRUM_OK);

  // every field has the bits that it has among all tetrahedra
  assert_int_equal(thrum_stress_points_count(some), 4);
  for (int n = 0; n < 4; n++) {
    assert_int_equal(thrum_stress_points_tet(some, n), chosen[n]);
    assert_memory_equal(of_some.strain + 6 * n, of_all.strain + 6 * chosen[n], 48);
    assert_memory_equal(of_some.cauchy + 6 * n, of_all.cauchy + 6 * chosen[n], 48);
    assert_memory_equal(of_some.mises + n, of_all.mises + chosen[n], 8);
    assert_memory_equal(of_some.stretch + n, of_all.stretch + chosen[n], 8);
    assert_memory_equal(without.second + 6 * n, of_all.second + 6 * chosen[n], 48);
    assert_memory_equal(without.mises + n, of_all.mises + chosen[n], 8);
  }

  stress_points_free(some);
  stress_points_free(all);
  linear_fields_free(&fields);
}

static void von_mises_of_known_states(void **state) {
  (void)state;
  const double pressure[6] = {-3, -3, -3, 0, 0, 0}, uniaxial[6] = {0, -2, 0, 0, 0, 0};
  const double shear[6] = {0, 0, 0, 0, 5, 0}, plane[6] = {4, 2, 0, 1, 0, 0};
  assert_true(thrum_von_mises(pressure) == 0);
  assert_true(thrum_von_mises(uniaxial) == 2);
  assert_within(thrum_von_mises(shear), sqrt(3) * 5, 1e-15 * 9);
  // sqrt(s1^2 - s1 s2 + s2^2) of the principal stresses 3 +- sqrt(2)
  assert_within(thrum_von_mises(plane), sqrt(15), 1e-15 * 4);
}

static void an_inverted_tetrahedron_has_a_negative_stretch_and_no_cauchy_stress(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", YOUNG, 0.2);
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);
  static readings r;
  const double inverted[FIELDS] = {-1.25}, flat[FIELDS] = {-1};
  read_all(stress_points, inverted, &r);
  assert_within(r.stretch[0], -0.25, 1e-15);
  assert_true(isnan(r.cauchy[0]) && isnan(r.mises[0]));
  assert_true(isfinite(r.second[0]));
  read_all(stress_points, flat, &r);
  assert_true(r.stretch[0] == 0 && isnan(r.mises[0]));
  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

static void missing_arguments_of_stress_points_are_refused(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", YOUNG, 0.2);
  const thrum_stress_points_def all = {NULL, 0};
  size_t size = 77;

  // sizes
  assert_int_equal(thrum_stress_points_size(NULL, &all, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_points_size(&fields.model, NULL, &size, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_points_size(&fields.model, &all, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  thrum_model bare = fields.model;
  bare.tets = NULL;
  assert_int_equal(thrum_stress_points_size(&bare, &all, &size, NULL), THRUM_MISSING);
  assert_int_equal(size, 77);

  // readings from what are no stress points, or to nowhere
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0);
  static double von_mises[TETS_MAX];
  const thrum_stress_points_output output = {.von_mises = von_mises};
  const double q[FIELDS] = {0};
  void *torn = aligned_alloc(64, 4096);
  assert_non_null(torn);
  memset(torn, 0, 4096);
  assert_int_equal(thrum_stress_points_read(torn, q, NULL, &output, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_points_read(stress_points, q, NULL, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  free(torn);

  // no stress points have none; von Mises' stress alone is read without the others
  assert_int_equal(thrum_stress_points_count(NULL), 0);
  assert_int_equal(thrum_stress_points_work_count(NULL), 0);
  von_mises[0] = -1;
  assert_int_equal(thrum_stress_points_read(stress_points, q, NULL, &output, NULL), THRUM_OK);
  assert_true(von_mises[0] == 0);
  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

static void impossible_stress_points_are_refused(void **state) {
  (void)state;

  // good stress points, to compare with
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", YOUNG, 0.2);
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, NULL, 0),
                            *untouched = stress_points;
  static readings r;

  // arguments with one thing wrong
  static const int32_t beyond[1] = {6}, before[1] = {-1}, first[1] = {0};
  double q[FIELDS] = {0, 0, NAN};
  const thrum_stress_points_output output = {.stretch = r.stretch};
  size_t size = 7;
  thrum_error error;
  const thrum_stress_points_def good = {NULL, 0}, high = {beyond, 1}, low = {before, 1},
                                none = {first, 0};

  // reading: coordinates that are not finite, and missing arguments
  assert_int_equal(thrum_stress_points_read(stress_points, q, NULL, &output, &error),
                   THRUM_BAD_VALUE);
  assert_int_equal(thrum_stress_points_read(NULL, q, NULL, &output, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_points_read(stress_points, NULL, NULL, &output, NULL),
                   THRUM_INVALID_ARGUMENT);

  // tetrahedra outside the mesh, and an empty list
  assert_int_equal(thrum_stress_points_size(&fields.model, &high, &size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_points_size(&fields.model, &low, &size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_stress_points_size(&fields.model, &none, &size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(size, 7);

  // a hexahedron, whose strains are not those of the tetrahedra that show it
  const uint8_t hexahedron = 4;
  thrum_model of_solids = fields.model;
  of_solids.solid_count = 1;
  of_solids.solid_form = &hexahedron;
  assert_int_equal(thrum_stress_points_size(&of_solids, &good, &size, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "--element tet"));
  assert_int_equal(size, 7);

  // memory that is too small or misaligned, and a model without a basis
  assert_int_equal(thrum_stress_points_size(&fields.model, &good, &size, &error), THRUM_OK);
  void *memory = aligned_alloc(64, size + 64);
  assert_int_equal(
      thrum_stress_points_init(memory, size - 1, &fields.model, &good, &untouched, &error),
      THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(
      thrum_stress_points_init((char *)memory + 8, size, &fields.model, &good, &untouched, &error),
      THRUM_MISALIGNED);
  thrum_model bare = fields.model;
  bare.basis = NULL;
  assert_int_equal(thrum_stress_points_size(&bare, &good, &size, &error), THRUM_MISSING);

  // a flat tetrahedron is refused when the stress points are made
  double vertices[3 * 8];
  memcpy(vertices, fields.model.vertices, sizeof vertices);
  for (int v = 0; v < 8; v++)
    vertices[3 * v] = 0;
  thrum_model flat = fields.model;
  flat.vertices = vertices;
  assert_int_equal(thrum_stress_points_init(memory, size, &flat, &good, &untouched, &error),
                   THRUM_BAD_VALUE);
  assert_ptr_equal(untouched, stress_points);

  free(memory);
  stress_points_free(stress_points);
  linear_fields_free(&fields);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_bar_in_uniaxial_stretch_has_the_stress_of_the_closed_form),
      cmocka_unit_test(the_stress_of_another_law_is_its_closed_form),
      cmocka_unit_test(the_stress_of_each_region_is_that_of_its_law),
      cmocka_unit_test(the_compressive_force_peaks_at_stretch_one_over_root_three),

      // the fields of any displacement
      cmocka_unit_test(a_rotation_strains_nothing_and_turns_the_cauchy_stress),
      cmocka_unit_test(a_linear_displacement_gives_every_tetrahedron_the_same_tensors),
      cmocka_unit_test(the_strains_hold_the_energy_of_the_reduced_polynomial),
      cmocka_unit_test(chosen_stress_points_read_what_points_on_all_tets_read),
      cmocka_unit_test(von_mises_of_known_states),
      cmocka_unit_test(an_inverted_tetrahedron_has_a_negative_stretch_and_no_cauchy_stress),

      // arguments
      cmocka_unit_test(missing_arguments_of_stress_points_are_refused),
      cmocka_unit_test(impossible_stress_points_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
