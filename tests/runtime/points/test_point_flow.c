/* Tests of plastic flow at cubature points: the flow of one point, the account of the energies,
 * what snapshots, batches and clearing do to it, and what is refused. SPDX-License-Identifier:
 * Apache-2.0 */
#include "tests/support/points_support.h"

#include "core/state/state_layout.h"
#include "runtime/points/point_rest.h"

#include "thrum/batch.h"

enum { RANK = 9, POINTS = 40 };

/* Points of this law whose gradients are so large that p of order 1 strains by a tenth or so. */
static void flow_make(both *made, const char *law, uint64_t seed) {
  points_make(made, seed, RANK, POINTS, 0.2);
  points_obey(made, law);
  made->points.identity = thrum_model_identity(&made->points);
}

static thrum_state_def flow_def(double yield) {
  thrum_state_def def = thrum_default_state_def();
  def.dt = 0.05;
  def.plastic.yield = yield;
  return def;
}

static double size_of(const double q[RANK]) {
  double square = 0;
  for (int i = 0; i < RANK; i++)
    square += q[i] * q[i];
  return sqrt(square);
}

/* A state of the model that has been thrown. */
static thrum_state *thrown(const both *made, const thrum_state_def *def) {
  double p[RANK];
  random_state random = {17};
  random_vector(&random, RANK, 1, p);
  thrum_state *state = state_make(&made->points, def);
  state_put(&made->points, state, NULL, p);
  return state;
}

static void a_point_flows_by_the_closed_form(void **context) {
  (void)context;
  both made;
  points_make(&made, 3, RANK, 1, 1);
  points_obey(&made, "corotational");
  made.weights[0] *= 0.05; // it has less stiffness than the body, and sees all of a displacement
  for (int c = 0; c < 81; c++)
    made.gradients[c] = c % 10 == 0 ? 1 : 0;

  // coordinates are the nine components of the gradient, which hardly move in so short a step
  const double s = 0.3, q[RANK] = {s}, size = s * sqrt(2.0 / 3), yield = 0.1;
  static const double creeps[] = {INFINITY, 1e9};
  for (int k = 0; k < 2; k++) {
    thrum_state_def def = flow_def(yield);
    def.dt = 1e-9;
    def.plastic.creep = creeps[k];
    thrum_state *state = state_make(&made.points, &def);
    state_put(&made.points, state, q, NULL);
    const double before = state_energy(&made.points, state).potential;
    state_steps(&made.points, state, 1);

    // the logarithms of the plastic stretches are x dev(s - 1)
    const double x = (k == 0 ? 1 : 1 - exp(-1)) * (1 - yield / size);
    assert_true(fabs(thrum_state_plastic_strain(state) - x * size) < 1e-12);
    const thrum_state_report report = thrum_state_report_get(state);
    const double after = state_energy(&made.points, state).potential;
    assert_true(report.plastic_work > 0);
    assert_true(fabs(before - after - report.plastic_work) < 1e-12 * before);
    state_free(state);
  }
  both_free(&made);
}

/* One point that the coordinates move by its nine components in turn. */
static void one_point_make(both *made, const char *law) {
  points_make(made, 3, RANK, 1, 1);
  points_obey(made, law);
  made->weights[0] *= 0.01;
  for (int c = 0; c < 81; c++)
    made->gradients[c] = c % 10 == 0 ? 1 : 0;
  made->points.identity = thrum_model_identity(&made->points);
}

static void a_point_flows_at_any_strain(void **context) {
  (void)context;
  static const char *const laws[] = {"corotational", "neo-hookean"};
  for (int n = 0; n < 6; n++) {
    both made;
    one_point_make(&made, laws[n % 2]);

    // a strain of 1 to 1e20, and a step so short that nothing else happens
    const double q[RANK] = {pow(1e10, n / 2), 0.1};
    thrum_state_def def = flow_def(0.1);
    def.dt = 1e-9;
    thrum_state *state = state_make(&made.points, &def);
    state_put(&made.points, state, q, NULL);
    state_steps(&made.points, state, 1);
    assert_true(thrum_state_plastic_strain(state) > 0.01);
    assert_true(thrum_state_report_get(state).plastic_work > 0);
    state_free(state);
    both_free(&made);
  }
}

/* Where a step is done what has flowed is a number, however often and far the point flows. */
static void a_plastic_strain_is_finite(void **context) {
  (void)context;
  static const char *const laws[] = {"corotational", "neo-hookean"};
  for (int n = 0; n < 60; n++) {
    both made;
    one_point_make(&made, laws[n % 2]);
    const double size = pow(1e5, n / 2), q[RANK] = {size, 0.1 * size};
    thrum_state_def def = flow_def(0.1);
    def.dt = 1e-9;
    thrum_state *state = state_make(&made.points, &def);
    state_put(&made.points, state, q, NULL);
    for (int k = 0; k < 5; k++) {
      thrum_step(&made.points, state, NULL);
      const double strain = thrum_state_plastic_strain(state);
      if (!isfinite(strain))
        fail_msg("%s at a strain of %g: the plastic strain is %g", laws[n % 2], size, strain);
    }
    state_free(state);
    both_free(&made);
  }
}

static void kinetic_stored_and_plastic_energy_are_the_work_of_the_load(void **context) {
  (void)context;
  static const char *const laws[] = {"corotational", "neo-hookean"};
  for (int n = 0; n < 2; n++) {
    both made;
    flow_make(&made, laws[n], 6);
    const thrum_state_def def = flow_def(0.1);
    thrum_state *state = thrown(&made, &def);
    const thrum_energies start = state_energy(&made.points, state);
    double load[RANK], q[2][RANK], p[RANK], work = 0, flowed = 0;
    for (int i = 0; i < RANK; i++)
      load[i] = 0.1 * (i % 3);
    state_push(&made.points, state, load);

    // at each step
    state_read(&made.points, state, q[0], p);
    for (int k = 0; k < 400; k++) {
      state_steps(&made.points, state, 1);
      state_read(&made.points, state, q[(k + 1) % 2], p);
      for (int i = 0; i < RANK; i++)
        work += load[i] * (q[(k + 1) % 2][i] - q[k % 2][i]);
      const thrum_state_report report = thrum_state_report_get(state);
      assert_true(report.plastic_work >= flowed && report.dissipated == report.plastic_work);
      flowed = report.plastic_work;
      const double left = state_energy(&made.points, state).total + flowed - start.total - work;
      if (!(fabs(left) <= 1e-12 * start.total))
        fail_msg("%s, step %d: %g", laws[n], k, left / start.total);
    }
    assert_true(flowed > 0.01 * start.total);
    state_free(state);
    both_free(&made);
  }
}

/* Regions of several laws, the second with a yield of its own where it says so. */
static void regions_make(both *made, uint64_t seed, bool own) {
  static const uint8_t laws[] = {THRUM_LAW_STVK, THRUM_LAW_COROTATIONAL, THRUM_LAW_NEO_HOOKEAN};
  static const double yields[] = {0, 0.1, 0};
  points_make(made, seed, RANK, POINTS, 0.2);
  points_obey_regions(made, laws);
  made->points.region_yield = own ? yields : NULL;
  made->points.identity = thrum_model_identity(&made->points);
}

/* Has something flowed in this region? */
static bool has_flowed(const both *made, const thrum_state *state, int32_t region) {
  const double *plastic = thrum_state_view_of((thrum_state *)(uintptr_t)state).plastic;
  for (int64_t n = 0; n < 9 * POINTS; n++)
    if (made->points.point_region[n / 9] == region && plastic[n] != 0)
      return true;
  return false;
}

static void regions_flow_beyond_their_own_yield_or_that_of_the_state(void **context) {
  (void)context;
  // by the state's yield, by the second region's, and by both
  for (int n = 0; n < 3; n++) {
    both made;
    regions_make(&made, 6, n > 0);
    const thrum_state_def def = flow_def(n == 1 ? INFINITY : 0.1);
    thrum_state *state = thrown(&made, &def);
    const double start = state_energy(&made.points, state).total;
    for (int k = 0; k < 200; k++) {
      state_steps(&made.points, state, 1);
      const double taken = thrum_state_report_get(state).plastic_work;
      assert_true(fabs(state_energy(&made.points, state).total + taken - start) <= 1e-12 * start);
    }
    assert_true(thrum_state_report_get(state).plastic_work > 0.001 * start);
    assert_false(has_flowed(&made, state, 0));
    assert_true(has_flowed(&made, state, 1));
    assert_true(has_flowed(&made, state, 2) == (n != 1));

    // a state that started from a copy of it goes on as it does
    thrum_state *copy = state_make(&made.points, &def);
    assert_int_equal(thrum_state_take_plastic(copy, state, NULL), THRUM_OK);
    assert_true(thrum_state_plastic_strain(copy) == thrum_state_plastic_strain(state));
    state_free(copy);
    state_free(state);
    both_free(&made);
  }
}

static void a_yield_of_a_region_is_stepped_by_energy_alone(void **context) {
  (void)context;
  both made;
  thrum_error error;
  size_t size;
  regions_make(&made, 6, true);
  thrum_state_def def = flow_def(INFINITY);
  def.integrator = THRUM_INTEGRATOR_NEWMARK;
  assert_int_equal(thrum_state_size(&made.points, &def, &size, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "a region of this model has a yield of its own"));

  // nor does a state flow whose regions are all of Saint Venant-Kirchhoff's law
  static const uint8_t none[3] = {0};
  made.points.region_yield = NULL;
  made.points.region_law = none;
  def = flow_def(0.1);
  assert_int_equal(thrum_state_size(&made.points, &def, &size, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "this model cannot flow"));
  both_free(&made);
}

/* A body of few points, whose stiffness is far from that of its frequencies along all shapes. */
static void few_make(both *made, uint64_t seed) {
  static const char *const laws[] = {"corotational", "neo-hookean"};
  points_make(made, seed, RANK, 1 + (int64_t)seed % 7, seed % 3 == 0 ? 1.5 : 0.4);
  points_obey(made, laws[seed % 2]);
  made->points.identity = thrum_model_identity(&made->points);
}

static void flow_takes_no_more_than_start_and_load_have_given(void **context) {
  (void)context;
  int flowed = 0, stiffer = 0;
  for (uint64_t seed = 1; seed <= 24; seed++) {
    both made;
    few_make(&made, seed);
    const thrum_state_def def = flow_def(seed % 5 == 0 ? 1e-3 : 0.05);
    thrum_state *state = state_make(&made.points, &def);
    random_state random = {seed ^ 31};
    double load[RANK], q[2][RANK], p[RANK], work = 0;

    // violent ones: the body is thrown, and pushed this way and that
    random_vector(&random, RANK, 5, p);
    state_put(&made.points, state, NULL, p);
    const double start = state_energy(&made.points, state).total;
    double most = start, moved = start;
    state_read(&made.points, state, q[0], p);
    for (int k = 0; k < 200; k++) {
      if (k % 40 == 0) {
        random_vector(&random, RANK, k < 160 ? 20 : 0, load);
        state_push(&made.points, state, load);
      }
      state_steps(&made.points, state, 1);
      state_read(&made.points, state, q[(k + 1) % 2], p);
      double done = 0;
      for (int i = 0; i < RANK; i++)
        done += load[i] * (q[(k + 1) % 2][i] - q[k % 2][i]);
      work += done;
      moved += fabs(done);
      most = fmax(most, start + work);

      // no strain energy below zero, no work that was not there, and an account that closes
      const thrum_energies now = state_energy(&made.points, state);
      const double taken = thrum_state_report_get(state).plastic_work;
      const double left = now.total + taken - start - work;
      if (!(now.potential >= -1e-12 * moved && taken <= most + 1e-12 * moved &&
            fabs(left) <= 1e-11 * moved))
        fail_msg("body %d, step %d: V %g, taken %g, given %g, left %g", (int)seed, k, now.potential,
                 taken, most, left);
    }
    flowed += thrum_state_report_get(state).plastic_work > 0.1 * most;
    stiffer += thrum_state_point_stiffness(state) > 2;
    state_free(state);
    both_free(&made);
  }
  assert_true(flowed > 12 && stiffer > 6);
}

/* Plastic strains of this size as a state has them. */
static double *flowed_array(const thrum_model *model, double size, random_state *random) {
  const int64_t r = model->rank;
  double *plastic = random_alloc(thrum_points_plastic_count(model), sizeof *plastic);
  double *shapes = random_alloc(r * r, sizeof *shapes), *work = random_alloc(r * r, sizeof *work);
  double shares[RANK];
  random_vector(random, 9 * model->point_count, size, plastic);
  thrum_rest_shares(model, shapes, shares, work);
  thrum_rest_prepare(model, shapes, shares, plastic);
  thrum_rest_release(model, shapes, shares, plastic);
  free(shapes);
  free(work);
  return plastic;
}

static void no_plastic_strain_and_no_shape_make_strain_energy_negative(void **context) {
  (void)context;
  for (uint64_t seed = 1; seed <= 200; seed++) {
    both made;
    few_make(&made, seed);
    random_state random = {seed ^ 5};
    thrum_model model = made.points;
    double *plastic = flowed_array(&model, pow(10, (double)(seed % 5) - 4), &random);
    double *work = random_alloc((int64_t)thrum_work_count(&model), sizeof *work), q[RANK];
    model.point_plastic = plastic;

    // small and large shapes; rounding is that of the terms which cancel
    for (int k = 0; k < 20; k++) {
      random_vector(&random, RANK, pow(10, k % 6 - 4), q);
      double size = 0;
      for (int i = 0; i < RANK; i++)
        size += model.omega2[i] * q[i] * q[i];
      const double least = -1e-12 * (size + fabs(thrum_released_energy(&model, q)));
      const double energy = thrum_strain_energy(&model, q, work);
      if (!(energy >= least))
        fail_msg("body %d, shape %d: %g below %g", (int)seed, k, energy, least);
    }

    free(work);
    free(plastic);
    both_free(&made);
  }
}

static void the_force_of_what_was_released_is_the_slope_of_its_energy(void **context) {
  (void)context;
  for (uint64_t seed = 1; seed <= 6; seed++) {
    both made;
    few_make(&made, seed);
    random_state random = {seed ^ 13};
    thrum_model model = made.points;
    double *plastic = flowed_array(&model, 0.1, &random);
    double *work = random_alloc((int64_t)thrum_work_count(&model), sizeof *work);
    model.point_plastic = plastic;
    double q[RANK], v[RANK], force[2][RANK], product[RANK], tangent[RANK * RANK], energy[2];
    random_vector(&random, RANK, 0.3, q);
    random_vector(&random, RANK, 1, v);
    thrum_tangent_product(&model, q, v, product, work);
    thrum_tangent_stiffness(&model, q, tangent, work);

    // along v, by central differences
    const double h = 1e-5;
    double slope = 0, force_size = 0, worst = 0;
    for (int k = 0; k < 2; k++) {
      double at[RANK];
      for (int i = 0; i < RANK; i++)
        at[i] = q[i] + (k ? h : -h) * v[i];
      energy[k] = thrum_internal_force(&model, at, force[k], work);
      assert_true(fabs(energy[k] - thrum_strain_energy(&model, at, work)) <=
                  1e-12 * fabs(energy[k]));
    }
    for (int i = 0; i < RANK; i++) {
      slope += 0.5 * (force[0][i] + force[1][i]) * v[i];
      force_size += fabs(force[0][i] * v[i]);
      double row = 0;
      for (int j = 0; j < RANK; j++)
        row += tangent[i * RANK + j] * v[j];
      worst = fmax(worst, fabs(row - product[i]));
      worst = fmax(worst, 1e-4 * fabs((force[1][i] - force[0][i]) / (2 * h) - product[i]));
    }
    assert_true(fabs((energy[1] - energy[0]) / (2 * h) - slope) <= 1e-6 * force_size);
    assert_true(worst <= 1e-10 * force_size);
    free(work);
    free(plastic);
    both_free(&made);
  }
}

static void a_body_that_does_not_flow_yet_has_the_bits_of_the_elastic_one(void **context) {
  (void)context;
  both made;
  points_make(&made, 6, RANK, POINTS, 0.05);
  points_obey(&made, "corotational");
  made.points.identity = thrum_model_identity(&made.points);
  const thrum_state_def def = flow_def(100), rigid = flow_def(INFINITY);
  thrum_state *state = thrown(&made, &def), *elastic = thrown(&made, &rigid);
  const double stiffness = thrum_state_point_stiffness(state);
  assert_true(stiffness > 0 && stiffness <= 1 && thrum_state_point_stiffness(elastic) == 0);

  // the yield is never reached
  double q[2][RANK], p[2][RANK];
  state_steps(&made.points, state, 50);
  state_steps(&made.points, elastic, 50);
  state_read(&made.points, state, q[0], p[0]);
  state_read(&made.points, elastic, q[1], p[1]);
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(p[0], p[1], sizeof p[0]);
  state_free(state);
  state_free(elastic);
  both_free(&made);
}

static void what_has_flowed_is_taken_over_with_what_it_released(void **context) {
  (void)context;
  both made;
  flow_make(&made, "corotational", 6);
  const thrum_state_def def = flow_def(0.1);
  thrum_state *state = thrown(&made, &def), *other = state_make(&made.points, &def);
  state_steps(&made.points, state, 30);

  // with the same coordinates and the same flow, both have the same energy
  double q[RANK], p[RANK];
  state_read(&made.points, state, q, p);
  assert_int_equal(thrum_state_take_plastic(other, state, NULL), THRUM_OK);
  state_put(&made.points, other, q, p);
  assert_true(state_energy(&made.points, other).potential ==
              state_energy(&made.points, state).potential);
  state_free(other);
  state_free(state);
  both_free(&made);
}

static void a_body_that_has_flowed_stays_bent_until_it_is_cleared(void **context) {
  (void)context;
  both made;
  flow_make(&made, "corotational", 6);
  thrum_state_def def = flow_def(0.1);
  def.damping_alpha = 0.5;
  thrum_state *state = thrown(&made, &def);
  def.plastic.yield = INFINITY;
  thrum_state *elastic = thrown(&made, &def);
  double q[RANK], p[RANK];
  state_steps(&made.points, elastic, 1200);
  state_read(&made.points, elastic, q, p);
  const double straight = size_of(q);
  state_steps(&made.points, state, 1200);
  state_read(&made.points, state, q, p);
  const double strain = thrum_state_plastic_strain(state);
  assert_true(size_of(q) > 0.005 && straight < 1e-2 * size_of(q) && strain > 0.01);
  state_free(elastic);

  // setting q and p moves the body and not its material
  state_put(&made.points, state, NULL, NULL);
  assert_true(thrum_state_plastic_strain(state) == strain);
  assert_true(state_energy(&made.points, state).potential > 0);

  // cleared, it has no strain energy there any more, and no account of what it had
  assert_int_equal(thrum_state_clear_plastic(&made.points, state, NULL), THRUM_OK);
  assert_true(thrum_state_plastic_strain(state) == 0);
  assert_true(state_energy(&made.points, state).total == 0);
  const thrum_state_report report = thrum_state_report_get(state);
  assert_true(report.plastic_work == 0 && report.dissipated > 0);
  state_steps(&made.points, state, 3);
  assert_true(state_energy(&made.points, state).total == 0);

  // a call that fails after that leaves every byte that persists
  state_put(&made.points, state, q, p);
  assert_int_equal(thrum_state_clear_plastic(&made.points, state, NULL), THRUM_OK);
  const size_t kept = thrum_state_kept_bytes(state);
  unsigned char *before = random_alloc((int64_t)kept, 1);
  memcpy(before, state, kept);
  for (int i = 0; i < RANK; i++)
    q[i] = 1e200;
  assert_int_equal(thrum_state_set(&made.points, state, q, q, NULL), THRUM_NOT_FINITE);
  assert_memory_equal(state, before, kept);
  free(before);

  // a bound holds, and one far below what a step would flow does not stop all flow
  def.plastic = (thrum_plastic){0.1, INFINITY, 1e-9};
  thrum_state *bounded = thrown(&made, &def);
  state_steps(&made.points, bounded, 20);
  assert_true(thrum_state_plastic_strain(bounded) <= 1e-9);
  assert_true(thrum_state_plastic_strain(bounded) > 0.5e-9);
  state_free(bounded);
  state_free(state);
  both_free(&made);
}

static void a_copy_and_a_snapshot_go_on_with_the_same_bits(void **context) {
  (void)context;
  both made;
  flow_make(&made, "corotational", 6);
  const thrum_state_def def = flow_def(0.1);
  thrum_state *state = thrown(&made, &def), *other = state_make(&made.points, &def);
  state_steps(&made.points, state, 30);
  const size_t size = thrum_state_snapshot_size(state);
  unsigned char *bytes = malloc(size);
  assert_int_equal(thrum_state_snapshot(state, bytes, size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_restore(&made.points, other, bytes, size, NULL), THRUM_OK);
  assert_true(thrum_state_plastic_strain(other) == thrum_state_plastic_strain(state));
  assert_true(thrum_state_plastic_strain(state) > 0);
  state_steps(&made.points, state, 30);
  state_steps(&made.points, other, 30);
  assert_memory_equal(state, other, thrum_state_kept_bytes(state));

  // a state that does not flow has no room for it
  const thrum_state_def rigid = flow_def(INFINITY);
  thrum_state *elastic = state_make(&made.points, &rigid);
  thrum_error error;
  assert_int_equal(thrum_state_restore(&made.points, elastic, bytes, size, &error),
                   THRUM_MODEL_MISMATCH);
  state_free(elastic);
  state_free(other);
  state_free(state);
  free(bytes);
  both_free(&made);
}

/* The states of a batch of points of this many, by this def, step as each does alone, and within
 * the workspace. */
static void assert_batch(both *made, const thrum_state_def *def) {
  size_t size = 0;
  assert_int_equal(thrum_batch_size(&made->points, &size, NULL), THRUM_OK);
  unsigned char *workspace = aligned_alloc(64, size + 4096);
  memset(workspace, 0xa5, size + 4096);

  // the same bits, and nothing written behind the workspace
  thrum_state *alone = thrown(made, def), *together = thrown(made, def);
  for (int k = 0; k < 10; k++) {
    state_steps(&made->points, alone, 1);
    assert_true(thrum_batch_step(&made->points, &together, 1, NULL, workspace, size, NULL) >= 0);
  }
  assert_memory_equal(alone, together, thrum_state_kept_bytes(alone));
  for (size_t n = size; n < size + 4096; n++)
    assert_int_equal(workspace[n], 0xa5);
  state_free(alone);
  state_free(together);
  free(workspace);
}

static void a_batch_flows_as_each_alone_and_within_its_workspace(void **context) {
  (void)context;
  both made;
  flow_make(&made, "corotational", 6);
  thrum_state_def def = flow_def(0.1);
  assert_batch(&made, &def);

  // many points are more numbers than a small polynomial has, also where imexv restricts them
  both_free(&made);
  points_make(&made, 6, 2, 4000, 0.2);
  points_obey(&made, "corotational");
  def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = 1;
  def.dt = 0.05;
  assert_batch(&made, &def);
  both_free(&made);
}

/* The def is refused with this status and these words. */
static void assert_refused(const thrum_model *model, const thrum_state_def *def,
                           thrum_status status, const char *words) {
  thrum_error error;
  size_t size = 0;
  assert_int_equal(thrum_state_size(model, def, &size, &error), status);
  if (!strstr(error.message, words))
    fail_msg("%s", error.message);
}

static void what_cannot_flow_is_refused(void **context) {
  (void)context;
  both made;
  points_make(&made, 6, RANK, POINTS, 0.2);
  thrum_state_def def = flow_def(0.1);
  assert_refused(&made.points, &def, THRUM_UNSUPPORTED, "this model cannot flow");
  assert_refused(&made.m.model, &def, THRUM_UNSUPPORTED, "this model cannot flow");
  points_obey(&made, "corotational");

  // numbers out of their range, and NaN
  static const double bad[] = {0, -1, NAN};
  for (int n = 0; n < 3; n++) {
    def = flow_def(bad[n]);
    assert_refused(&made.points, &def, THRUM_INVALID_ARGUMENT, "plastic.yield");
    def = flow_def(0.1);
    def.plastic.creep = bad[n];
    assert_refused(&made.points, &def, THRUM_INVALID_ARGUMENT, "plastic.creep");
    def = flow_def(0.1);
    def.plastic.largest = bad[n];
    assert_refused(&made.points, &def, THRUM_INVALID_ARGUMENT, "plastic.largest");
  }

  // other integrators
  for (int k = 0; k < INTEGRATOR_COUNT; k++) {
    def = flow_def(0.1);
    def.integrator = every_integrator[k];
    if (def.integrator != THRUM_INTEGRATOR_ENERGY)
      assert_refused(&made.points, &def, THRUM_UNSUPPORTED, "does not step plastic flow");
  }
  both_free(&made);
}

/* Points say what they were trained on: flow at those that know of none is refused, by a state that
 * does not ask for it, and a yield that nothing reached tells nothing of a smaller one. */
static void flow_at_untrained_points_is_refused(void **context) {
  (void)context;
  static const struct {
    double training[THRUM_TRAINING_NUMBERS];
    const char *says; /* of a yield of 0.05; NULL: it is stepped */
  } cases[] = {
      {{0.3, 0, 0, 0}, "not trained on plastic flow: strain"},
      {{0.3, 0.1, 0, 0}, "not trained on plastic flow beyond so small a yield"},
      {{0.3, 0.1, 0.02, 0}, NULL},
      {{0.3, 0.05, 0, 0}, NULL},
      {{0.3, 0, 0, 1}, "the strain of no place of the body"},
  };
  both made;
  flow_make(&made, "corotational", 6);
  size_t size = 0;
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    made.points.point_training = cases[n].training;
    assert_int_equal(thrum_model_check(&made.points, NULL), THRUM_OK);
    thrum_state_def def = flow_def(0.05);
    if (cases[n].says)
      assert_refused(&made.points, &def, THRUM_UNSUPPORTED, cases[n].says);
    else
      assert_int_equal(thrum_state_size(&made.points, &def, &size, NULL), THRUM_OK);

    // who asks for it has it, and elastic motion needs no such training
    def.untrained_flow = 1;
    assert_int_equal(thrum_state_size(&made.points, &def, &size, NULL), THRUM_OK);
    def = flow_def(INFINITY);
    assert_int_equal(thrum_state_size(&made.points, &def, &size, NULL), THRUM_OK);
  }

  // a model that does not say it is stepped
  made.points.point_training = NULL;
  const thrum_state_def def = flow_def(0.05);
  assert_int_equal(thrum_state_size(&made.points, &def, &size, NULL), THRUM_OK);
  both_free(&made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(flow_at_untrained_points_is_refused),
      cmocka_unit_test(a_point_flows_by_the_closed_form),
      cmocka_unit_test(a_point_flows_at_any_strain),
      cmocka_unit_test(a_plastic_strain_is_finite),
      cmocka_unit_test(kinetic_stored_and_plastic_energy_are_the_work_of_the_load),
      cmocka_unit_test(regions_flow_beyond_their_own_yield_or_that_of_the_state),
      cmocka_unit_test(a_yield_of_a_region_is_stepped_by_energy_alone),

      // energy that flow may take
      cmocka_unit_test(flow_takes_no_more_than_start_and_load_have_given),
      cmocka_unit_test(no_plastic_strain_and_no_shape_make_strain_energy_negative),
      cmocka_unit_test(the_force_of_what_was_released_is_the_slope_of_its_energy),

      // states before, during and after flow
      cmocka_unit_test(a_body_that_does_not_flow_yet_has_the_bits_of_the_elastic_one),
      cmocka_unit_test(what_has_flowed_is_taken_over_with_what_it_released),
      cmocka_unit_test(a_body_that_has_flowed_stays_bent_until_it_is_cleared),
      cmocka_unit_test(a_copy_and_a_snapshot_go_on_with_the_same_bits),
      cmocka_unit_test(a_batch_flows_as_each_alone_and_within_its_workspace),

      // refusals
      cmocka_unit_test(what_cannot_flow_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
