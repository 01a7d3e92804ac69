/* The check of the modes finds a missed mode and recovers it: repeated frequencies, several parts,
 * several materials (design 2). SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "mesh/mesh_fix.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/mode_check.h"

typedef struct discrete {
  thrum_fem fem;
  thrum_sparse stiffness, mass;
  thrum_factor *factor;
} discrete;

static discrete discrete_make(const body *b) {
  discrete s = {.fem = body_fem(b)};
  assert_int_equal(thrum_fem_pattern(&s.fem, &s.stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&s.fem, NULL, &s.stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&s.fem, THRUM_MASS_CONSISTENT, &s.stiffness, &s.mass, NULL),
                   THRUM_OK);
  assert_int_equal(thrum_factor_create(&s.stiffness, &s.factor, NULL), THRUM_OK);
  return s;
}

static void discrete_free(discrete *s) {
  thrum_factor_free(s->factor);
  thrum_sparse_free(&s->stiffness);
  thrum_sparse_free(&s->mass);
  thrum_fem_free(&s->fem);
}

/* The modes in the bit mask `missing` are removed from the lowest 12; the search, given the rest,
 * must recover the lowest modes. */
static void recover(const discrete *s, unsigned missing) {
  // the complete set
  const int64_t n = s->fem.free_count;
  double values[12], kept_values[12], next;
  double *vectors = need((size_t)(12 * n), sizeof *vectors);
  double *kept = need((size_t)(12 * n), sizeof *kept);
  assert_int_equal(
      thrum_eigen_lowest(&s->stiffness, &s->mass, s->factor, 12, values, vectors, NULL, NULL),
      THRUM_OK);

  // the set with gaps
  int64_t count = 0, gone = 0, recovered = -1;
  for (int i = 0; i < 12; i++) {
    if (missing >> i & 1u) {
      gone++;
      continue;
    }
    kept_values[count] = values[i];
    memcpy(kept + n * count++, vectors + n * i, sizeof *kept * (size_t)n);
  }

  // the search fills every gap
  assert_int_equal(thrum_mode_search(&s->stiffness, &s->mass, s->factor, count, kept_values, kept,
                                     &recovered, &next, NULL),
                   THRUM_OK);
  assert_int_equal(recovered, gone);
  for (int64_t i = 0; i < count; i++)
    assert_close(kept_values[i], values[i], 1e-9);

  // the values not found begin where the found ones end
  assert_true(next >= values[count - 1] * (1 - 1e-6));

  // the recovered vectors are modes, too
  double residual[12];
  assert_int_equal(
      thrum_eigen_residuals(&s->stiffness, &s->mass, count, kept_values, kept, residual, NULL),
      THRUM_OK);
  for (int64_t i = 0; i < count; i++)
    assert_true(residual[i] < 1e-12);

  free(vectors);
  free(kept);
}

static void missed_modes_are_found_by_the_search(void **state) {
  (void)state;
  // bending modes of a square section come in pairs, split only by the cells' diagonals
  body b = body_make("beam:12x3x3@1x0.15x0.15", "left");
  discrete s = discrete_make(&b);
  recover(&s, 0);
  recover(&s, 1u << 0);
  recover(&s, 1u << 1);
  recover(&s, 1u << 6);
  recover(&s, 1u << 0 | 1u << 1 | 1u << 5 | 1u << 8);
  discrete_free(&s);
  body_free(&b);
}

static void modes_below_any_shift_are_counted_exactly(void **state) {
  (void)state;
  body b = body_make("beam:12x3x3@1x0.15x0.15", "left");
  discrete s = discrete_make(&b);

  // the modes' values, between which the shifts lie
  double values[12];
  double *vectors = need((size_t)(12 * s.fem.free_count), sizeof *vectors);
  assert_int_equal(
      thrum_eigen_lowest(&s.stiffness, &s.mass, s.factor, 12, values, vectors, NULL, NULL),
      THRUM_OK);

  // between two values the count is their number, or inertia counts are unavailable
  for (int i = 0; i < 11; i++) {
    int64_t count = -1;
    const thrum_status status =
        thrum_inertia_count(&s.stiffness, &s.mass, 0.5 * (values[i] + values[i + 1]), &count, NULL);
    if (thrum_inertia_available())
      assert_true(status == THRUM_OK && count == i + 1);
    else
      assert_true(status == THRUM_UNSUPPORTED && count == -1);
  }

  free(vectors);
  discrete_free(&s);
  body_free(&b);
}

static void shifts_lie_in_gaps(void **state) {
  (void)state;
  const double values[] = {1, 2, 3, 3.0000001};
  int64_t below;
  double shift = thrum_mode_shift(4, values, 4, &below);
  assert_true(below == 4 && shift > 3.0000001 && shift < 4);
  // the repeated value continues beyond the last mode, so the shift must lie below it
  shift = thrum_mode_shift(4, values, 3.0000002, &below);
  assert_true(below == 2 && shift > 2 && shift < 3);
  shift = thrum_mode_shift(1, values, 1, &below);
  assert_true(below == 0 && shift > 0 && shift < 1);
  shift = thrum_mode_shift(4, values, (double)INFINITY, &below);
  assert_true(below == 4 && shift > 3.0000001);
}

/* `copies` of a body side by side that share no vertex; each is held as the first is. */
static body make_copies(const body *one, int copies) {
  const int64_t v = one->mesh.vertex_count, t = one->mesh.tet_count;

  // arrays for all copies; material as in the original
  body all = {.mesh = one->mesh};
  all.mesh.vertex_count = copies * v;
  all.mesh.tet_count = copies * t;
  all.mesh.vertices = need((size_t)(3 * copies * v), sizeof(double));
  all.mesh.tets = need((size_t)(4 * copies * t), sizeof(int32_t));
  all.mesh.tet_region = need((size_t)(copies * t), sizeof(int32_t));
  all.mesh.materials = need(1, sizeof *all.mesh.materials);
  all.mesh.materials[0] = one->mesh.materials[0];
  all.mesh.groups = NULL;
  all.mesh.group_count = 0;
  all.fixed = need((size_t)(copies * v), 1);

  // each copy is shifted by 1 along y and has its own vertices
  for (int64_t i = 0; i < 3 * copies * v; i++)
    all.mesh.vertices[i] =
        one->mesh.vertices[i % (3 * v)] + (i % 3 == 1 ? (double)(i / (3 * v)) : 0);
  for (int64_t i = 0; i < 4 * copies * t; i++)
    all.mesh.tets[i] = one->mesh.tets[i % (4 * t)] + (int32_t)(i / (4 * t) * v);
  for (int64_t i = 0; i < copies * v; i++)
    all.fixed[i] = one->fixed[i % v];
  return all;
}

static void equal_parts_have_every_frequency_as_often_as_there_are_parts(void **state) {
  (void)state;
  enum { COPIES = 5, EACH = 4 };
  body one = body_make("beam:8x2x2@1x0.2x0.15", "left"), all = make_copies(&one, COPIES);

  // the parts together have each value of one part COPIES times
  thrum_precomputed single = body_precompute(&one, EACH, EACH);
  thrum_precomputed several = body_precompute(&all, COPIES * EACH, COPIES * EACH);
  for (int i = 0; i < COPIES * EACH; i++)
    assert_close(several.mode_omega2[i], single.mode_omega2[i / COPIES], 1e-10);

  // no mode is missed, and the inertia count confirms it where it is available
  assert_true(several.modes_complete);
  assert_int_equal(several.mode_counted, thrum_inertia_available());
  if (several.mode_counted)
    assert_int_equal(several.shift_count, COPIES * EACH);

  // the result is deterministic to the bit, although values repeat
  thrum_precomputed again = body_precompute(&all, COPIES * EACH, COPIES * EACH);
  assert_memory_equal(again.model.basis, several.model.basis,
                      sizeof(double) * (size_t)(3 * all.mesh.vertex_count * COPIES * EACH));

  thrum_precomputed_free(&again);
  thrum_precomputed_free(&single);
  thrum_precomputed_free(&several);
  body_free(&one);
  body_free(&all);
}

static void a_cluster_that_is_cut_is_no_missed_mode(void **state) {
  (void)state;
  body one = body_make("beam:8x2x2@1x0.2x0.15", "left"), all = make_copies(&one, 3);
  // the first four of two triples: the fifth and sixth equal the fourth
  thrum_precomputed result = body_precompute(&all, 4, 4);
  assert_true(result.modes_complete);
  assert_int_equal(result.modes_recovered, 0);
  assert_close(result.next_omega2, result.mode_omega2[3], 1e-6);
  if (result.mode_counted)
    assert_int_equal(result.shift_count, 3);
  thrum_precomputed_free(&result);
  body_free(&one);
  body_free(&all);
}

/* A cube has modes of the same frequency, in pairs and threes. Lanczos from one vector misses some
 * of these, and the list may end between two of them: all are as exact as the others. */
static void repeated_modes_of_a_cube_are_exact(void **state) {
  (void)state;
  int64_t recovered = 0;
  body cube = body_quadratic("beam:2x2x2@1x1x1", NULL, 0, 0);
  for (int64_t modes = 5; modes <= 20; modes += modes < 7 ? 1 : 13) {
    thrum_precomputed result = body_precompute(&cube, modes, modes);
    recovered += result.modes_recovered;
    assert_true(result.modes_complete);
    for (int64_t i = 0; i < modes; i++)
      if (!(result.mode_residual[i] < 2e-13))
        fail_msg("mode %d of %d leaves %g", (int)i + 1, (int)modes, result.mode_residual[i]);
    thrum_precomputed_free(&result);
  }

  // the case is there: some of them were missed at first
  assert_true(recovered > 0);
  body_free(&cube);
}

/* A bar of two materials in series with nu = 0 can move only along its length: between clamped
 * ends, tan(k1 a) / z1 + tan(k2 b) / z2 = 0 with k = omega / c, z = sqrt(E rho). */
static void a_bar_of_two_materials_sounds_as_wave_theory_says(void **state) {
  (void)state;
  const thrum_material soft = {1e6, 0, 1000}, hard = {9e6, 0, 1000};

  // the soft material fills the first half, the hard one the other half
  body b = body_make("beam:120x1x1@1x0.02x0.02", "x<0.0001");
  thrum_material two[2] = {soft, hard};
  free(b.mesh.materials);
  b.mesh.materials = need(2, sizeof *b.mesh.materials);
  memcpy(b.mesh.materials, two, sizeof two);
  b.mesh.region_count = 2;
  for (int64_t t = 0; t < b.mesh.tet_count; t++) {
    double middle = 0;
    for (int a = 0; a < 4; a++)
      middle += b.mesh.vertices[3 * b.mesh.tets[4 * t + a]] / 4;
    b.mesh.tet_region[t] = middle > 0.5;
  }

  // both ends clamped, lateral motion suppressed everywhere
  int64_t count;
  assert_int_equal(thrum_mesh_fix(&b.mesh, "x>0.9999", b.fixed, &count, NULL), THRUM_OK);
  assert_int_equal(thrum_mesh_fix(&b.mesh, "x<2:yz", b.fixed, &count, NULL), THRUM_OK);
  thrum_precomputed result = body_precompute(&b, 4, 4);

  // c = 31.62 and 94.87 m/s over 0.5 m each: the frequency equation changes sign at its roots
  const double c1 = sqrt(1e3), c2 = sqrt(9e3), z1 = sqrt(1e9), z2 = sqrt(9e9);
  int found = 0;
  double before = 0;
  for (double w = 1; found < 4; w += 0.01) {
    const double value =
        sin(w * 0.5 / c1) * cos(w * 0.5 / c2) / z1 + cos(w * 0.5 / c1) * sin(w * 0.5 / c2) / z2;
    if (w > 1 && value * before < 0)
      assert_close(sqrt(result.mode_omega2[found++]), w - 0.005, 2e-3);
    before = value;
  }

  assert_true(result.modes_complete);

  thrum_precomputed_free(&result);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(missed_modes_are_found_by_the_search),
      cmocka_unit_test(modes_below_any_shift_are_counted_exactly),
      cmocka_unit_test(shifts_lie_in_gaps),
      cmocka_unit_test(equal_parts_have_every_frequency_as_often_as_there_are_parts),
      cmocka_unit_test(a_cluster_that_is_cut_is_no_missed_mode),
      cmocka_unit_test(repeated_modes_of_a_cube_are_exact),
      cmocka_unit_test(a_bar_of_two_materials_sounds_as_wave_theory_says),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
