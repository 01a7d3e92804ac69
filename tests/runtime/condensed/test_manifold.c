/* Tests of the step on the manifold of a condensed model: it is the motion of the whole model where
 * the slaves are stiff, it conserves the energy of all coordinates at any step, and it is of order
 * two. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"

#include "runtime/condensed/manifold.h"
#include "thrum/batch.h"

enum { RANK = 9, MASTERS = 3 };

static thrum_state_def def_of(double dt) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_MANIFOLD;
  def.dt = dt;
  return def;
}

/* A model of three coordinates, the third of which follows the first two, V = 1/2 sum w^2 q^2 with
 * 1/2 w_y^2 (y - a x1^2 - b x1 x2)^2 in place of the third term. Condensed, it is linear: the
 * inertia of y alone makes it what it is. */
typedef struct valley {
  double omega2[3], c3[10], c4[15];
  thrum_model model;
  void *memory; /* of the condensed model */
} valley;

/* Returns the valley condensed to its first two coordinates; valley_free frees it. */
static const thrum_model *valley_make(valley *v, double stiff) {
  static const double a = 0.6, b = -0.4;
  memset(v, 0, sizeof *v);
  v->omega2[0] = 4;
  v->omega2[1] = 9;
  v->omega2[2] = stiff;

  // the square, multiplied out
  v->c3[thrum_c3_index(3, 0, 0, 2)] = -stiff * a;
  v->c3[thrum_c3_index(3, 0, 1, 2)] = -stiff * b;
  v->c4[thrum_c4_index(3, 0, 0, 0, 0)] = 0.5 * stiff * a * a;
  v->c4[thrum_c4_index(3, 0, 0, 0, 1)] = stiff * a * b;
  v->c4[thrum_c4_index(3, 0, 0, 1, 1)] = 0.5 * stiff * b * b;

  v->model.rank = 3;
  v->model.c3_count = 10;
  v->model.c4_count = 15;
  v->model.omega2 = v->omega2;
  v->model.c3 = v->c3;
  v->model.c4 = v->c4;

  // the third follows
  const thrum_model *condensed = NULL;
  v->memory = condense(&v->model, 2, &condensed);
  return condensed;
}

static void valley_free(valley *v) {
  free(v->memory);
}

/* A random model of RANK coordinates, and the memory of the one condensed to MASTERS of them. */
typedef struct body {
  random_model m;
  void *memory;
} body;

/* Returns the condensed model; the angular frequencies of all coordinates are in [3, omega_last].
 */
static const thrum_model *body_make(body *b, uint64_t seed, double omega_last) {
  random_model_make(&b->m, seed, RANK, 3, omega_last, 1);
  const thrum_model *condensed = NULL;
  b->memory = condense(&b->m.model, MASTERS, &condensed);
  return condensed;
}

static void body_free(body *b) {
  free(b->memory);
  random_model_free(&b->m);
}

/* x after `time` from momenta p, stepped with the def. */
static void run(const thrum_model *model, const thrum_state_def *def, double time, const double *p,
                double *x, double *v) {
  thrum_state *state = state_make(model, def);
  state_put(model, state, NULL, p);
  state_steps(model, state, (int64_t)(time / def->dt + 0.5));
  state_read(model, state, x, v);
  state_free(state);
}

static void a_stiff_slave_has_its_inertia_which_plain_condensing_leaves_out(void **context) {
  (void)context;
  valley wide;
  const thrum_model *stepped = valley_make(&wide, 1e6);
  const double p[3] = {2, -1, 0};
  double whole[3], x[3], plain[3], v[3];

  // the whole model in steps that resolve the slave, the condensed one in steps that are 100 times
  // as long
  thrum_state_def def = thrum_default_state_def();
  def.dt = 5e-5;
  run(&wide.model, &def, 2, p, whole, v);
  def = def_of(5e-3);
  run(stepped, &def, 2, p, x, v);
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  run(stepped, &def, 2, p, plain, v);
  assert_true(largest_difference(x, whole, 2) < 2e-3);
  assert_true(largest_difference(plain, whole, 2) > 0.1);
  valley_free(&wide);
}

/* |x - whole| over |whole| of the valley after 1.5 s. */
static double damped_error(const thrum_model *stepped, thrum_state_def def, const double *whole) {
  const double p[2] = {0.1, -0.05};
  double x[2], v[2], square = 0, size = 0;
  run(stepped, &def, 1.5, p, x, v);
  for (int i = 0; i < 2; i++) {
    square += (x[i] - whole[i]) * (x[i] - whole[i]);
    size += whole[i] * whole[i];
  }
  return sqrt(square / size);
}

static void the_damping_of_a_stiff_slave_slows_its_masters(void **context) {
  (void)context;
  static const thrum_integrator all[] = {THRUM_INTEGRATOR_MANIFOLD, THRUM_INTEGRATOR_ENERGY,
                                         THRUM_INTEGRATOR_NEWMARK,  THRUM_INTEGRATOR_FOX_GOODWIN,
                                         THRUM_INTEGRATOR_IMEXV,    THRUM_INTEGRATOR_VERLET,
                                         THRUM_INTEGRATOR_MIDPOINT, THRUM_INTEGRATOR_RK4};
  valley wide;
  const thrum_model *stepped = valley_make(&wide, 4e5);
  const double p[3] = {0.1, -0.05, 0};
  double whole[3], v[3];

  // the whole model, whose slave is resolved
  thrum_state_def def = thrum_default_state_def();
  def.damping_beta = 0.005;
  def.dt = 2e-4;
  run(&wide.model, &def, 1.5, p, whole, v);

  // condensed it is linear, so that its tangent form of damping is that of the masters alone
  def.dt = 2e-3;
  def.damping_form = THRUM_DAMPING_TANGENT;
  assert_true(damped_error(stepped, def, whole) > 0.3);
  def.damping_form = THRUM_DAMPING_REST;
  for (size_t n = 0; n < sizeof all / sizeof *all; n++) {
    def.integrator = all[n];
    assert_true(damped_error(stepped, def, whole) < 0.04);
  }
  valley_free(&wide);
}

static void the_drag_of_slaves_is_accounted_for_and_feeds_nothing_at_any_size(void **context) {
  (void)context;
  valley wide;
  const thrum_model *stepped = valley_make(&wide, 1e4);
  const double p[2] = {2, -1};

  // from a drag that is hardly felt to one that stops the masters within a step
  for (double beta = 1e-4; beta < 1e3; beta *= 100) {
    thrum_state_def def = thrum_default_state_def();
    def.dt = 0.05;
    def.damping_beta = beta;
    thrum_state *state = state_make(stepped, &def);
    state_put(stepped, state, NULL, p);
    const double begin = state_energy(stepped, state).total;
    for (int k = 0; k < 100; k++) {
      state_steps(stepped, state, 1);
      const double lost = thrum_state_report_get(state).dissipated;
      assert_true(fabs(state_energy(stepped, state).total + lost - begin) <= 1e-11 * begin);
      assert_true(lost > 0);
    }
    state_free(state);
  }
  valley_free(&wide);
}

static void the_energy_of_all_coordinates_stays_at_any_step(void **context) {
  (void)context;
  body b;
  const thrum_model *stepped = body_make(&b, 21, 100);
  const double p[MASTERS] = {4, -6, 4};
  for (double dt = 0.001; dt < 1; dt *= 10) {
    const thrum_state_def def = def_of(dt);
    thrum_state *state = state_make(stepped, &def);
    state_put(stepped, state, NULL, p);
    const double begin = state_energy(stepped, state).total;
    double moved = 0;
    for (int k = 0; k < 400; k++) {
      state_steps(stepped, state, 1);
      double x[MASTERS], v[MASTERS];
      state_read(stepped, state, x, v);
      moved = fmax(moved, thrum_condensed_inertia_share(stepped, x, v));

      // what is reported is the energy of the velocities of all coordinates
      double all[RANK], kinetic = 0;
      thrum_condensed_velocity(stepped, x, v, all);
      for (int i = 0; i < RANK; i++)
        kinetic += 0.5 * all[i] * all[i];
      const thrum_energies now = state_energy(stepped, state);
      assert_true(fabs(now.kinetic - kinetic) <= 1e-13 * begin);
      assert_true(fabs(now.total - begin) <= 1e-11 * begin);
    }
    assert_true(moved > 1e-4);
    state_free(state);
  }
  body_free(&b);
}

static void half_the_step_leaves_a_quarter_of_the_error(void **context) {
  (void)context;
  valley wide;
  const thrum_model *stepped = valley_make(&wide, 400);
  const double p[2] = {2, -1};

  // the reference has 64 times more steps
  double fine[2], v_fine[2], error[3];
  thrum_state_def def = def_of(0.02 / 64);
  def.tolerance = 1e-10;
  run(stepped, &def, 2, p, fine, v_fine);

  // the error in positions and velocities at h, h/2, h/4
  for (int n = 0; n < 3; n++) {
    double x[2], v[2];
    def.dt = 0.02 / (1 << n);
    run(stepped, &def, 2, p, x, v);
    error[n] = fmax(largest_difference(x, fine, 2), largest_difference(v, v_fine, 2));
  }

  // order 2
  for (int n = 0; n < 2; n++)
    assert_true(fabs(log2(error[n] / error[n + 1]) - 2) < 0.15);
  valley_free(&wide);
}

static void loads_and_damping_account_for_every_change_of_the_energy(void **context) {
  (void)context;
  body b;
  const thrum_model *stepped = body_make(&b, 22, 100);
  const double f[MASTERS] = {0.3, 0.2, -0.1};

  // both forms of damping
  for (int form = 0; form < 2; form++) {
    thrum_state_def def = def_of(0.02);
    def.damping_alpha = 0.3;
    def.damping_beta = 0.002;
    def.damping_form = form == 0 ? THRUM_DAMPING_REST : THRUM_DAMPING_TANGENT;
    thrum_state *state = state_make(stepped, &def);
    state_push(stepped, state, f);

    // after each step: energy = work of the load - what the damping took
    double x[MASTERS] = {0}, work = 0, most = 0;
    for (int k = 0; k < 500; k++) {
      double before[MASTERS];
      memcpy(before, x, sizeof x);
      state_steps(stepped, state, 1);
      state_read(stepped, state, x, NULL);
      for (int i = 0; i < MASTERS; i++)
        work += f[i] * (x[i] - before[i]);
      most = fmax(most, work);
      const double lost = thrum_state_report_get(state).dissipated;
      assert_true(fabs(state_energy(stepped, state).total - work + lost) <= 1e-11 * most);
    }
    state_free(state);
  }

  body_free(&b);
}

static void a_scaled_body_moves_as_the_body_scaled(void **context) {
  (void)context;
  body b;
  const thrum_model *stepped = body_make(&b, 23, 100), *scaled = NULL;

  // lengths by 2 and stiffness by 4 keep the times; coordinates grow by 1/g
  const thrum_model_scaling by = {2, 4, 1};
  const double g = 1 / (sqrt(8) * 2);
  size_t size = 0;
  assert_int_equal(thrum_model_scale_size(stepped, &size, NULL), THRUM_OK);
  void *large = aligned_alloc(64, size);
  assert_non_null(large);
  assert_int_equal(thrum_model_scale(large, size, stepped, &by, &scaled, NULL), THRUM_OK);

  const thrum_state_def def = def_of(0.01);
  const double p[MASTERS] = {0.4, -0.3, 0.2};
  double p_large[MASTERS], x[MASTERS], v[MASTERS], x_large[MASTERS], v_large[MASTERS];
  for (int i = 0; i < MASTERS; i++)
    p_large[i] = p[i] / g;
  run(stepped, &def, 3, p, x, v);
  run(scaled, &def, 3, p_large, x_large, v_large);
  for (int i = 0; i < MASTERS; i++)
    assert_true(fabs(g * x_large[i] - x[i]) < 1e-6 && fabs(g * v_large[i] - v[i]) < 1e-5);
  free(large);
  body_free(&b);
}

static void check_copy_and_batch(thrum_integrator integrator) {
  body b;
  const thrum_model *stepped = body_make(&b, 24, 100);
  thrum_state_def def = def_of(0.01);
  def.integrator = integrator;
  def.damping_beta = 0.002;
  const double p[MASTERS] = {0.4, -0.3, 0.2};
  thrum_state *alone = state_make(stepped, &def);
  state_put(stepped, alone, NULL, p);
  state_steps(stepped, alone, 50);
  thrum_state *other = state_snapshot(alone), *third = state_snapshot(alone);

  // two copies side by side
  size_t size = 0;
  assert_int_equal(thrum_batch_size(stepped, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, size);
  assert_non_null(workspace);
  thrum_state *both[2] = {other, third};
  state_steps(stepped, alone, 20);
  for (int k = 0; k < 20; k++)
    assert_true(thrum_batch_step(stepped, both, 2, NULL, workspace, size, NULL) >= 0);
  for (int n = 0; n < 2; n++)
    assert_memory_equal(both[n], alone, thrum_state_kept_bytes(alone));

  // and a snapshot with its checks
  const size_t bytes = thrum_state_snapshot_size(alone);
  void *kept = malloc(bytes);
  assert_non_null(kept);
  assert_int_equal(thrum_state_snapshot(alone, kept, bytes, NULL), THRUM_OK);
  state_steps(stepped, alone, 20);
  assert_int_equal(thrum_state_restore(stepped, other, kept, bytes, NULL), THRUM_OK);
  state_steps(stepped, other, 20);
  assert_memory_equal(other, alone, thrum_state_kept_bytes(alone));
  free(kept);
  free(workspace);
  state_free(third);
  state_free(other);
  state_free(alone);
  body_free(&b);
}

static void a_copy_and_a_batch_step_to_the_same_bits(void **context) {
  (void)context;
  check_copy_and_batch(THRUM_INTEGRATOR_MANIFOLD);
  check_copy_and_batch(THRUM_INTEGRATOR_ENERGY);
}

static void all_kernels_give_the_same_bits(void **context) {
  (void)context;
  body b;
  const thrum_model *stepped = body_make(&b, 25, 100);
  const double p[MASTERS] = {0.4, -0.3, 0.2};
  double x[2][MASTERS], v[2][MASTERS];

  // the plain C kernel, then the best one of this machine; with the drag of slaves as well
  for (int damped = 0; damped < 2; damped++) {
    for (int n = 0; n < 2; n++) {
      thrum_state_def def = def_of(0.01);
      def.kernel = n == 0 ? THRUM_KERNEL_REFERENCE : THRUM_KERNEL_BEST;
      def.integrator = damped ? THRUM_INTEGRATOR_ENERGY : THRUM_INTEGRATOR_MANIFOLD;
      def.damping_beta = damped ? 0.002 : 0;
      run(stepped, &def, 2, p, x[n], v[n]);
    }

    assert_memory_equal(x[0], x[1], sizeof x[0]);
    assert_memory_equal(v[0], v[1], sizeof v[0]);
  }
  body_free(&b);
}

/* The increment of one step from a bent, moving state under a load, and what contact is told of it
 * and of its answer to a load on each coordinate. */
static void step_from_bent(const thrum_model *stepped, double dt, const double load[2],
                           double made[2], double moved[2], double answers[2]) {
  const thrum_state_def def = def_of(dt);
  thrum_state *state = state_make(stepped, &def);
  const double q[2] = {0.5, -0.3}, p[2] = {1.2, 0.8};
  state_put(stepped, state, q, p);
  state_push(stepped, state, load);

  // told before the step
  thrum_state_view view = thrum_state_view_of(state);
  thrum_internal_force(stepped, q, view.force, view.work);
  assert_true(thrum_manifold_predict(stepped, state, &view, load, moved, answers));
  state_steps(stepped, state, 1);
  state_read(stepped, state, made, NULL);
  for (int i = 0; i < 2; i++)
    made[i] -= q[i];
  state_free(state);
}

/* |predicted - made| of that step. */
static double error_of_prediction(const thrum_model *stepped, double dt) {
  static const double load[2] = {0.4, -0.7};
  double made[2], moved[2], answers[2];
  step_from_bent(stepped, dt, load, made, moved, answers);

  // each coordinate answers a load of its own by as much as the step does
  for (int i = 0; i < 2; i++) {
    double pushed[2] = {load[0], load[1]}, with[2], unused[2];
    pushed[i] += 1;
    step_from_bent(stepped, dt, pushed, with, unused, unused);
    assert_true(fabs(with[i] - made[i] - answers[i]) < 0.01 * answers[i]);
  }
  return hypot(moved[0] - made[0], moved[1] - made[1]);
}

static void contact_is_told_of_the_step_to_third_order(void **context) {
  (void)context;
  valley v;
  const thrum_model *stepped = valley_make(&v, 400);
  const double whole = error_of_prediction(stepped, 2e-3),
               half = error_of_prediction(stepped, 1e-3);
  assert_true(whole < 1e-6);
  assert_true(whole / half > 7);
  valley_free(&v);
}

static void a_body_at_rest_stays_and_leaves_no_residual(void **context) {
  (void)context;
  valley v;
  const thrum_model *stepped = valley_make(&v, 400);
  const thrum_state_def def = def_of(1e-2);
  thrum_state *state = state_make(stepped, &def);
  state_steps(stepped, state, 3);

  // an increment of zero has nothing that a residual could be relative to
  double x[2] = {1, 1}, p[2] = {1, 1};
  state_read(stepped, state, x, p);
  assert_true(x[0] == 0 && x[1] == 0 && p[0] == 0 && p[1] == 0);
  assert_true(thrum_state_report_get(state).residual_last == 0);
  state_free(state);
  valley_free(&v);
}

static void a_small_damped_motion_is_solved_by_one_exact_jacobian(void **context) {
  (void)context;
  body b;
  const thrum_model *stepped = body_make(&b, 26, 100);

  // so small that the equation is linear; the damping outweighs inertia and stiffness
  const double p[MASTERS] = {4e-7, -6e-7, 4e-7};
  for (int form = 0; form < 2; form++) {
    thrum_state_def def = def_of(0.05);
    def.damping_alpha = 3;
    def.damping_beta = 20;
    def.damping_form = form == 0 ? THRUM_DAMPING_REST : THRUM_DAMPING_TANGENT;
    thrum_state *state = state_make(stepped, &def);
    state_put(stepped, state, NULL, p);
    state_steps(stepped, state, 1);
    const thrum_state_report report = thrum_state_report_get(state);
    assert_int_equal(report.factorisations, 1);
    assert_int_equal(report.iterations, 1);
    state_free(state);
  }
  body_free(&b);
}

static void a_smooth_motion_is_guessed_from_the_steps_before(void **context) {
  (void)context;
  body b;
  const thrum_model *stepped = body_make(&b, 27, 30);

  // 500 steps to a period of the fastest master
  const thrum_state_def def = def_of(1e-3);
  const double p[MASTERS] = {0.4, -0.3, 0.2};
  thrum_state *state = state_make(stepped, &def);
  state_put(stepped, state, NULL, p);
  state_steps(stepped, state, 20);
  const int64_t begun = thrum_state_report_get(state).iterations;
  state_steps(stepped, state, 200);
  const int64_t spent = thrum_state_report_get(state).iterations - begun;
  assert_true(spent <= 200);
  state_free(state);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_stiff_slave_has_its_inertia_which_plain_condensing_leaves_out),
      cmocka_unit_test(the_damping_of_a_stiff_slave_slows_its_masters),
      cmocka_unit_test(the_drag_of_slaves_is_accounted_for_and_feeds_nothing_at_any_size),
      cmocka_unit_test(the_energy_of_all_coordinates_stays_at_any_step),
      cmocka_unit_test(half_the_step_leaves_a_quarter_of_the_error),
      cmocka_unit_test(loads_and_damping_account_for_every_change_of_the_energy),

      // in other units, in copies and by other kernels
      cmocka_unit_test(a_scaled_body_moves_as_the_body_scaled),
      cmocka_unit_test(a_copy_and_a_batch_step_to_the_same_bits),
      cmocka_unit_test(all_kernels_give_the_same_bits),

      // what contact is told, and what a solve takes
      cmocka_unit_test(contact_is_told_of_the_step_to_third_order),
      cmocka_unit_test(a_body_at_rest_stays_and_leaves_no_residual),
      cmocka_unit_test(a_small_damped_motion_is_solved_by_one_exact_jacobian),
      cmocka_unit_test(a_smooth_motion_is_guessed_from_the_steps_before),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
