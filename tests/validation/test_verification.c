/* Tests of the published solutions (docs/verification.md) on meshes that a test can afford: each
 * error is within its bound, falls with the mesh, and does so with the order of the theory where
 * there is one. The reference solutions that need a computation are themselves compared to
 * published numbers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "validation/published/published.h"

#define ROWS_MAX 64

typedef struct rows {
  published_row row[ROWS_MAX];
  int count;
} rows;

static void collect(void *context, const published_row *row) {
  rows *all = context;
  assert_true(all->count < ROWS_MAX);
  all->row[all->count++] = *row;
}

static rows solve(published_problem *problem) {
  static rows all;
  thrum_error error = {0};
  const published_sink sink = {collect, &all, 0};
  all.count = 0;
  if (problem(&sink, &error) < 0)
    fail_msg("%s", error.message);
  assert_true(all.count > 0);
  return all;
}

static double error_of(const published_row *row) {
  return row->computed / row->published - 1;
}

/* Returns the last row of this quantity, and the one before it or NULL. */
static const published_row *last_of(const rows *all, const char *quantity,
                                    const published_row **before) {
  const published_row *last = NULL;
  *before = NULL;
  for (int n = 0; n < all->count; n++) {
    if (strcmp(all->row[n].quantity, quantity) == 0) {
      *before = last;
      last = &all->row[n];
    }
  }
  assert_non_null(last);
  return last;
}

/* Asserts that the error of the finest mesh is in [low, high]. */
static void holds(const rows *all, const char *quantity, double low, double high) {
  const published_row *before, *last = last_of(all, quantity, &before);
  const double error = error_of(last);
  if (!(error >= low && error <= high))
    fail_msg("%s on %s: %g, not %g: error %.3g outside [%g, %g]", quantity, last->mesh,
             last->computed, last->published, error, low, high);
}

/* Asserts that the error falls with at least this order. */
static void converges(const rows *all, const char *quantity, double order) {
  const published_row *before, *last = last_of(all, quantity, &before);
  assert_non_null(before);
  const double seen = log(fabs(error_of(before) / error_of(last))) / log(last->size / before->size);
  if (!(seen >= order))
    fail_msg("%s converges with order %.2f, not %.2f", quantity, seen, order);
}

static void known_solutions_are_the_published_ones(void **state) {
  (void)state;
  // Mattiasson 1981, Numerical results from large deflection beam and frame problems analysed by
  // means of elliptic integrals, doi:10.1002/nme.1620170113: P L^2/(E I) = 1, 2, 5, 10
  static const double elastica[4][3] = {
      {1, 0.30172, 0.05643}, {2, 0.49346, 0.16064}, {5, 0.71379, 0.38763}, {10, 0.81061, 0.55500}};
  for (int n = 0; n < 4; n++) {
    double deflection, shortening;
    published_elastica_tip(elastica[n][0], &deflection, &shortening);
    assert_true(fabs(deflection - elastica[n][1]) < 1e-5);
    assert_true(fabs(shortening - elastica[n][2]) < 1e-5);
  }

  // a slender Timoshenko beam is Bernoulli's: 1.8751^2, 4.6941^2 times sqrt(E I / rho A)
  const double thin = 1e-3, scale = thin / sqrt(12);
  assert_true(fabs(published_timoshenko(thin, 1) / scale / 3.5160153 - 1) < 1e-5);
  assert_true(fabs(published_timoshenko(thin, 2) / scale / 22.034492 - 1) < 1e-4);

  // shear and rotary inertia make it slower
  assert_true(published_timoshenko(0.1, 1) < 0.1 / sqrt(12) * 3.5160153);

  // Duffing: 1 + 3/8 e for small e, and the exact frequency at e -> infinity, 0.847213 sqrt(e)
  assert_true(fabs(published_duffing(1e-4) - 1 - 0.375e-4) < 1e-8);
  assert_true(fabs(published_duffing(1e8) / 1e4 - 0.8472131) < 1e-6);
}

static void beams_and_bars_have_the_frequencies_of_theory(void **state) {
  (void)state;

  // linear tetrahedra lock in bending: too stiff, with an error that falls with the squared cell
  // size
  rows all = solve(published_beam);
  holds(&all, "bending 1, Hz", 0, 0.11);
  converges(&all, "bending 1, Hz", 1.7);
  holds(&all, "bending 2, Hz", 0, 0.11);
  converges(&all, "bending 2, Hz", 1.7);

  // ten nodes do not, and begin with one cell over the thickness
  holds(&all, "bending 1, ten nodes, Hz", 0, 0.002);
  holds(&all, "bending 2, ten nodes, Hz", 0, 0.002);
  holds(&all, "axial 1, ten nodes, Hz", 0, 1e-4);

  // in tension there is nothing to lock
  holds(&all, "axial 1, Hz", 0, 1e-4);
  converges(&all, "axial 1, Hz", 1.9);
  all = solve(published_torsion);
  holds(&all, "torsion 1, Hz", 0, 0.6);
}

static void a_free_cube_has_the_mode_of_lame(void **state) {
  (void)state;
  const rows all = solve(published_cube);
  holds(&all, "Lame's mode, Hz", 0, 0.05);
  converges(&all, "Lame's mode, Hz", 1.2);
}

static void the_tapered_membrane_has_the_frequencies_of_nafems(void **state) {
  (void)state;
  const rows all = solve(published_membrane);
  holds(&all, "1, Hz", 0, 0.012);
  converges(&all, "1, Hz", 1.7);
  holds(&all, "2, Hz", 0, 0.014);
  holds(&all, "3, Hz", 0, 0.004);
  holds(&all, "4, Hz", 0, 0.018);
}

static void a_ball_has_the_published_clusters(void **state) {
  (void)state;
  const rows all = solve(published_sphere);
  holds(&all, "5 modes, Hz", 0, 0.1);
  holds(&all, "next 5, Hz", 0, 0.07);
  holds(&all, "next 3, Hz", 0, 0.08);
}

static void a_cantilever_follows_the_elastica(void **state) {
  (void)state;
  const rows all = solve(published_elastica);
  // with the bending stiffness that the mesh has, far into the nonlinear range
  holds(&all, "deflection at P = 1, mesh's own EI", -0.001, 0.001);
  holds(&all, "deflection at P = 5, mesh's own EI", -0.0015, 0.0015);
  holds(&all, "shortening at P = 5, mesh's own EI", -0.002, 0.002);
  // with the bending stiffness of the beam the locking shows
  holds(&all, "deflection at P = 5, ten nodes", -0.01, 0.01);
  holds(&all, "deflection at P = 5, ten nodes, full order", -0.01, 0.01);
  holds(&all, "deflection at P = 1", -0.45, 0);
  holds(&all, "deflection at P = 5", -0.2, 0);
}

static void a_column_buckles_at_the_load_of_euler(void **state) {
  (void)state;
  const rows all = solve(published_column);
  holds(&all, "critical load, ten nodes", -0.01, 0.01);
  holds(&all, "critical load", 0, 0.9);
}

static void a_cantilever_rolls_up_to_a_ring(void **state) {
  (void)state;
  const rows all = solve(published_rollup);
  holds(&all, "half a ring, across", -0.01, 0.01);
  holds(&all, "half a ring, along", -0.01, 0.01);
  holds(&all, "ring, along", -0.01, 0.01);
}

static void the_beam_of_turek_and_hron_sags_towards_the_published_tip(void **state) {
  (void)state;
  const rows all = solve(published_gravity_beam);
  holds(&all, "CSM1 tip, mm", -0.26, 0);
  converges(&all, "CSM1 tip, mm", 1.1);
  holds(&all, "CSM2 tip, mm", -0.27, 0);
  converges(&all, "CSM2 tip, mm", 1.1);
  // ten nodes, two cells over the thickness
  holds(&all, "CSM1 tip, ten nodes, mm", -0.01, 0.01);
  holds(&all, "CSM1 tip, ten nodes, full order, mm", -0.01, 0.01);
  holds(&all, "CSM2 tip, ten nodes, mm", -0.01, 0.01);
  holds(&all, "CSM2 tip, ten nodes, full order, mm", -0.01, 0.01);
}

static void a_clamped_beam_hardens_along_the_backbone(void **state) {
  (void)state;
  const rows all = solve(published_hardening);
  holds(&all, "cubic stiffness, N/m^3", 0, 0.007);
  holds(&all, "linear stiffness, ten nodes, N/m", -0.01, 0.01);
  holds(&all, "cubic stiffness, ten nodes, N/m^3", -0.01, 0.01);
  converges(&all, "linear stiffness, N/m", 1.8);
  // the linear stiffness locks, the cubic one does not: the ratio rises from below
  holds(&all, "frequency ratio at a = h", -0.09, 0);
  const published_row *before, *linear = last_of(&all, "linear stiffness, N/m", &before);
  const published_row *cubic = last_of(&all, "cubic stiffness, N/m^3", &before);
  const published_row *ratio = last_of(&all, "frequency ratio at a = h", &before);
  // with the mesh's own stiffness the steps of imexv follow Duffing's solution
  const double own = 0.02 * 0.02 * cubic->computed / linear->computed;
  assert_true(fabs(ratio->computed / published_duffing(own) - 1) < 2e-4);
}

static void a_beam_has_its_published_normal_form_and_a_plate_its_backbone(void **state) {
  (void)state;
  // eight modes and all their derivatives
  const rows all = solve(published_periodic);
  holds(&all, "beam: d omega/c^2", -0.004, 0);
  holds(&all, "beam: e omega^2/c^3", -0.005, 0);

  // twelve solid-shells along each side of a plate
  holds(&all, "clamped plate: omega/omega_1 at w = t", -0.012, 0);
}

static void imexv_is_stable_where_the_slow_oscillator_is(void **state) {
  (void)state;
  const rows all = solve(published_fast_slow);
  holds(&all, "quadratic split: largest stable h, s", -2e-3, 1e-3);
  holds(&all, "thesis split: largest stable h, s", -2e-3, 1e-3);
}

static void the_chain_of_fermi_pasta_and_ulam_does_what_is_published(void **state) {
  (void)state;
  const rows all = solve(published_fermi);
  holds(&all, "Verlet: largest stable h, s", -0.03, 0.025);

  // the errors are of the published size, and no larger at a resonance than beside it
  holds(&all, "quadratic split: energy error", -0.5, 0.5);
  holds(&all, "thesis split: energy error", -0.9, 0);
  for (int n = 0; n < all.count; n++)
    if (strstr(all.row[n].quantity, "resonance"))
      assert_true(all.row[n].computed < 3);

  // the time of the exchange of energy
  const published_row *before;
  const double exchange =
      last_of(&all, "quadratic split: time of the exchange, s", &before)->published;
  // it is 78.78 s by Verlet and by the conserving integrator alike
  assert_true(fabs(exchange - 78.77) < 0.05);
  for (int n = 0; n < all.count; n++)
    if (strcmp(all.row[n].quantity, "quadratic split: time of the exchange, s") == 0)
      assert_true(fabs(error_of(&all.row[n])) < 0.07);

  // the thesis split slows the exchange at large h omega, as the page says
  holds(&all, "thesis split: time of the exchange, s", 0, 0.06);
}

static void the_full_order_says_what_the_reduced_one_says(void **state) {
  (void)state;
  const published_row *before;
  rows all = solve(published_gravity_beam);
  const double reduced = last_of(&all, "CSM1 tip, mm", &before)->computed;
  assert_true(fabs(last_of(&all, "CSM1 tip, full order, mm", &before)->computed / reduced - 1) <
              1e-3);
  all = solve(published_elastica);
  const double bent = last_of(&all, "deflection at P = 5", &before)->computed;
  assert_true(fabs(last_of(&all, "deflection at P = 5, full order", &before)->computed / bent - 1) <
              2e-3);
}

static void a_tumbling_body_keeps_what_it_should(void **state) {
  (void)state;
  const rows all = solve(published_tumble);
  holds(&all, "energy step: energy", -1e-10, 1e-10);
  holds(&all, "energy step: angular momentum", -1e-10, 1e-10);
  holds(&all, "energy step: linear momentum", -1e-10, 1e-10);
  // the difference matters: Newmark does not
  const published_row *before;
  assert_true(fabs(error_of(last_of(&all, "Newmark: energy", &before))) > 1e-4);
}

static void a_spinning_body_stretches_and_keeps_what_it_should(void **state) {
  (void)state;
  const rows all = solve(published_spin);
  holds(&all, "stretch of a half of a bar, mm", -0.01, 0.01);
  holds(&all, "energy of a soft top", -1e-11, 1e-11);
  holds(&all, "angular momentum of a soft top", -1e-11, 1e-11);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(known_solutions_are_the_published_ones),
      cmocka_unit_test(beams_and_bars_have_the_frequencies_of_theory),
      cmocka_unit_test(a_free_cube_has_the_mode_of_lame),
      cmocka_unit_test(the_tapered_membrane_has_the_frequencies_of_nafems),
      cmocka_unit_test(a_ball_has_the_published_clusters),
      cmocka_unit_test(a_cantilever_follows_the_elastica),
      cmocka_unit_test(a_column_buckles_at_the_load_of_euler),
      cmocka_unit_test(a_cantilever_rolls_up_to_a_ring),
      cmocka_unit_test(the_beam_of_turek_and_hron_sags_towards_the_published_tip),

      // in large motion
      cmocka_unit_test(a_clamped_beam_hardens_along_the_backbone),
      cmocka_unit_test(the_full_order_says_what_the_reduced_one_says),
      cmocka_unit_test(a_tumbling_body_keeps_what_it_should),
      cmocka_unit_test(a_beam_has_its_published_normal_form_and_a_plate_its_backbone),
      cmocka_unit_test(a_spinning_body_stretches_and_keeps_what_it_should),

      // the split
      cmocka_unit_test(imexv_is_stable_where_the_slow_oscillator_is),
      cmocka_unit_test(the_chain_of_fermi_pasta_and_ulam_does_what_is_published),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
