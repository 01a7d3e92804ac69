/* The integrators are tested against theorems: observed order, the ends of IMEXv against
 * independent implementations, time reversal, impulses, and Newmark's well-known equivalences.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/polynomial.h"

/* A small nonlinear model: the cubic and quartic terms matter at |q| = 0.5. */
enum { RANK = 5, LOW = 2 };

static void make_model(random_model *m) {
  random_model_make(m, 7, RANK, 1.0, 9.0, 0.5);
}

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2};

static thrum_state_def make_def(thrum_integrator integrator) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.split_form = THRUM_FORM_THESIS;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = LOW;
  def.tolerance = 1e-13;
  return def;
}

/* --- order ------------------------------------------------------------------------------------ */

/* The largest errors of the solution and of the energy at eight times at equal distances. */
typedef struct errors {
  double solution, energy;
} errors;

enum { SAMPLES = 8, COARSE = 30 };
static const double duration = 2.4;

static double energy_of(const thrum_model *model, const double *q, const double *p) {
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  double energy = thrum_strain_energy(model, q, work);
  free(work);
  for (int64_t i = 0; i < model->rank; i++)
    energy += 0.5 * p[i] * p[i];
  return energy;
}

/* Computes the reference solution at the sample times: samples x rank. */
static void reference(const thrum_model *model, const thrum_state_def *def, const test_load *load,
                      double q[SAMPLES][RANK], double p[SAMPLES][RANK]) {
  enum { SUBSTEPS = 400 };
  double q_at[RANK], p_at[RANK];
  memcpy(q_at, start_q, sizeof q_at);
  memcpy(p_at, start_p, sizeof p_at);
  const double span = duration / SAMPLES;
  for (int s = 0; s < SAMPLES; s++) {
    reference_advance(model, def, load, s * span, span / SUBSTEPS, SUBSTEPS, q_at, p_at);
    memcpy(q[s], q_at, sizeof q_at);
    memcpy(p[s], p_at, sizeof p_at);
  }
}

static errors run_errors(const thrum_model *model, thrum_state_def def, const test_load *load,
                         int64_t steps_a_sample, double q_ref[SAMPLES][RANK],
                         double p_ref[SAMPLES][RANK]) {
  def.dt = duration / SAMPLES / (double)steps_a_sample;

  thrum_state *state = state_make(model, &def);
  state_put(model, state, start_q, start_p);
  errors worst = {0, 0};
  for (int64_t k = 0; k < SAMPLES * steps_a_sample; k++) {
    // the load of a step is its exact mean over the step
    double f[RANK], q[RANK], p[RANK];
    for (int64_t i = 0; i < RANK; i++)
      f[i] = test_load_mean(load, i, (double)k * def.dt, (double)(k + 1) * def.dt);
    state_push(model, state, f);
    state_steps(model, state, 1);

    // errors are taken where the reference has a sample
    if ((k + 1) % steps_a_sample != 0)
      continue;

    const int64_t s = k / steps_a_sample;
    state_read(model, state, q, p);
    worst.solution = fmax(worst.solution, fmax(largest_difference(q, q_ref[s], RANK),
                                               largest_difference(p, p_ref[s], RANK)));

    const double energy = energy_of(model, q_ref[s], p_ref[s]);
    worst.energy = fmax(worst.energy, fabs(state_energy(model, state).total - energy));
  }

  state_free(state);
  return worst;
}

/* Computes the orders from two halvings of dt, of which the lower counts. */
static errors observed_order(const thrum_model *model, const thrum_state_def *def,
                             const test_load *load) {
  double q_ref[SAMPLES][RANK], p_ref[SAMPLES][RANK];
  reference(model, def, load, q_ref, p_ref);
  errors e[3];
  for (int level = 0; level < 3; level++)
    e[level] = run_errors(model, *def, load, COARSE << level, q_ref, p_ref);
  const errors order = {
      fmin(log2(e[0].solution / e[1].solution), log2(e[1].solution / e[2].solution)),
      fmin(log2(e[0].energy / e[1].energy), log2(e[1].energy / e[2].energy)),
  };
  return order;
}

static void expect_order_two(thrum_integrator integrator, thrum_split_form form,
                             double newmark_beta) {
  random_model m;
  make_model(&m);

  // a free body and a loaded one, undamped and with every kind of damping
  static const test_load loads[2] = {{0, 1}, {1.5, 2.3}};
  static const struct {
    double alpha, beta;
    thrum_damping_form form;
  } damping[4] = {{0, 0, THRUM_DAMPING_REST},
                  {0.4, 0.01, THRUM_DAMPING_REST},
                  {0.0, 0.02, THRUM_DAMPING_REST},
                  {0.4, 0.01, THRUM_DAMPING_TANGENT}};

  for (int l = 0; l < 2; l++)
    for (int d = 0; d < 4; d++) {
      thrum_state_def def = make_def(integrator);
      def.newmark_beta = newmark_beta;
      def.split_form = form;
      def.damping_alpha = damping[d].alpha;
      def.damping_beta = damping[d].beta;
      def.damping_form = damping[d].form;

      const errors order = observed_order(&m.model, &def, &loads[l]);

      // energy of a free, undamped body is conserved: there is no error to have an order
      const int kept = integrator == THRUM_INTEGRATOR_ENERGY && l == 0 && d == 0;
      if (!(order.solution > 1.9 && order.solution < 2.2 && (kept || order.energy > 1.9)))
        fail_msg("%s, load %d, damping %d: order %.3f in the solution, %.3f in the energy",
                 thrum_integrator_name(integrator), l, d, order.solution, order.energy);
    }

  random_model_free(&m);
}

static void the_quadratic_split_is_of_order_two(void **context) {
  (void)context;
  expect_order_two(THRUM_INTEGRATOR_IMEXV, THRUM_FORM_QUADRATIC, 0.25);
}

static void the_position_form_is_of_order_two(void **context) {
  (void)context;
  expect_order_two(THRUM_INTEGRATOR_IMEXV, THRUM_FORM_POSITION, 0.25);
}

static void energy_is_of_order_two(void **context) {
  (void)context;
  expect_order_two(THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS, 0.25);
}

static void imexv_is_of_order_two(void **context) {
  (void)context;
  expect_order_two(THRUM_INTEGRATOR_IMEXV, THRUM_FORM_THESIS, 0.25);
}

static void verlet_is_of_order_two(void **context) {
  (void)context;
  expect_order_two(THRUM_INTEGRATOR_VERLET, THRUM_FORM_THESIS, 0.25);
}

static void midpoint_is_of_order_two(void **context) {
  (void)context;
  expect_order_two(THRUM_INTEGRATOR_MIDPOINT, THRUM_FORM_THESIS, 0.25);
}

static void newmark_is_of_order_two_for_any_beta(void **context) {
  (void)context;
  expect_order_two(THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_THESIS, 0.25);
  expect_order_two(THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_THESIS, 0.0);
  expect_order_two(THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_THESIS, 0.15);
}

static void newmark_is_of_order_one_for_gamma_beyond_one_half(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(THRUM_INTEGRATOR_NEWMARK);
  def.newmark_gamma = 0.9;
  def.newmark_beta = 0.49;
  const test_load none = {0, 1};
  const errors order = observed_order(&m.model, &def, &none);
  assert_true(order.solution > 0.8 && order.solution < 1.2);
  random_model_free(&m);
}

/* --- the ends of IMEXv, and an independent IMEXv ---------------------------------------------- */

/* Solves (1 + c T(x)) dx = b densely by Gauss elimination without pivoting; for tests. */
static void eliminate(int64_t n, double a[RANK][RANK], double *b) {
  for (int64_t k = 0; k < n; k++)
    for (int64_t i = k + 1; i < n; i++) {
      const double factor = a[i][k] / a[k][k];
      for (int64_t j = k; j < n; j++)
        a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  for (int64_t i = n - 1; i >= 0; i--) {
    for (int64_t j = i + 1; j < n; j++)
      b[i] -= a[i][j] * b[j];
    b[i] /= a[i][i];
  }
}

/* Makes one step of (2)-(5) as they are written: position form of the explicit modes with p at the
 * same time as q, rest damping, load means f_before and f. */
static void plain_step(const thrum_model *model, const thrum_state_def *def, int64_t split,
                       double *q, double *p_minus, const double *f_before, const double *f,
                       double *work) {
  const double h = def->dt;
  double force[RANK], d[RANK], q_next[RANK], p_plus[RANK];

  // the kick and the drift of the explicit modes
  thrum_internal_force(model, q, force, work);
  for (int64_t i = 0; i < RANK; i++) {
    d[i] = def->damping_alpha + def->damping_beta * model->omega2[i];
    q_next[i] = q[i];
    p_plus[i] = p_minus[i];
    if (i < split) {
      p_plus[i] = (p_minus[i] * (1 - h * d[i] / 2) - h * force[i] + h * (f_before[i] + f[i]) / 2) /
                  (1 + h * d[i] / 2);
      q_next[i] = q[i] + h * p_plus[i];
    }
  }

  // full Newton on the implicit modes, always twelve iterations
  double middle[RANK], tangent[RANK * RANK];
  for (int iteration = 0; iteration < 13; iteration++) {
    double a[RANK][RANK], b[RANK];
    for (int64_t i = 0; i < RANK; i++)
      middle[i] = (q[i] + q_next[i]) / 2;
    thrum_internal_force(model, middle, force, work);
    thrum_tangent_stiffness(model, middle, tangent, work);

    // the residual and the Jacobian of the implicit modes alone
    for (int64_t i = split; i < RANK; i++) {
      b[i - split] = q_next[i] - q[i] - h * p_plus[i] +
                     h * h / 2 * (force[i] + d[i] * (q_next[i] - q[i]) / h - f[i]);
      for (int64_t j = split; j < RANK; j++)
        a[i - split][j - split] =
            h * h / 4 * tangent[i * RANK + j] + (i == j ? 1 + h / 2 * d[i] : 0);
    }

    // the last pass only computes the force at the solution
    if (iteration == 12)
      break;
    eliminate(RANK - split, a, b);
    for (int64_t i = split; i < RANK; i++)
      q_next[i] -= b[i - split];
  }

  // the momenta of the implicit modes are kicked by the force of the middle
  for (int64_t i = 0; i < RANK; i++) {
    p_minus[i] = p_plus[i];
    if (i >= split)
      p_minus[i] -= h * (force[i] + d[i] * (q_next[i] - q[i]) / h - f[i]);
    q[i] = q_next[i];
  }
}

/* Computes the synchronised momentum of the plain step, by half a kick. */
static void plain_synchronise(const thrum_model *model, const thrum_state_def *def, int64_t split,
                              const double *q, const double *p_minus, const double *f_before,
                              double *p, double *work) {
  double force[RANK];
  thrum_internal_force(model, q, force, work);
  for (int64_t i = 0; i < RANK; i++) {
    const double d = def->damping_alpha + def->damping_beta * model->omega2[i];
    p[i] = i < split ? (p_minus[i] - def->dt / 2 * (force[i] - f_before[i])) / (1 + def->dt / 2 * d)
                     : p_minus[i];
  }
}

/* Runs `def` beside the plain step with `split` explicit modes; returns the largest difference. */
static double difference_from_plain(const thrum_state_def *def, int64_t split) {
  random_model m;
  make_model(&m);
  thrum_state *state = state_make(&m.model, def);
  state_put(&m.model, state, start_q, start_p);

  // the plain step begins with momenta half a step before q, in its explicit modes
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  double q[RANK], p[RANK], force[RANK], f_before[RANK] = {0}, worst = 0;

  random_state random = {5};
  memcpy(q, start_q, sizeof q);
  memcpy(p, start_p, sizeof p);
  thrum_internal_force(&m.model, q, force, work);
  for (int64_t i = 0; i < split; i++)
    p[i] += def->dt / 2 *
            (force[i] + (def->damping_alpha + def->damping_beta * m.model.omega2[i]) * p[i]);

  // the load changes every step
  for (int k = 0; k < 60; k++) {
    double f[RANK], q_state[RANK], p_state[RANK], p_plain[RANK];
    random_vector(&random, RANK, 1.0, f);

    state_push(&m.model, state, f);
    state_steps(&m.model, state, 1);

    plain_step(&m.model, def, split, q, p, f_before, f, work);
    memcpy(f_before, f, sizeof f);
    plain_synchronise(&m.model, def, split, q, p, f_before, p_plain, work);
    state_read(&m.model, state, q_state, p_state);

    worst = fmax(worst, fmax(largest_difference(q, q_state, RANK),
                             largest_difference(p_plain, p_state, RANK)));
  }

  free(work);
  state_free(state);
  random_model_free(&m);
  return worst;
}

static void imexv_equals_its_equations_for_every_split(void **context) {
  (void)context;
  for (int32_t split = 0; split <= RANK; split++)
    for (int damped = 0; damped < 2; damped++) {
      thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
      def.explicit_count = split;
      def.dt = 0.05;
      def.damping_alpha = damped ? 0.3 : 0;
      def.damping_beta = damped ? 0.02 : 0;
      assert_true(difference_from_plain(&def, split) < 1e-10);

      // and not those of another split
      assert_true(difference_from_plain(&def, split == RANK ? 0 : split + 1) > 1e-5);
    }
}

static void verlet_and_midpoint_equal_their_equations(void **context) {
  (void)context;
  thrum_state_def def = make_def(THRUM_INTEGRATOR_VERLET);
  def.dt = 0.05;
  assert_true(difference_from_plain(&def, RANK) < 1e-10);
  def.integrator = THRUM_INTEGRATOR_MIDPOINT;
  assert_true(difference_from_plain(&def, 0) < 1e-10);
}

/* Runs two defs side by side and asks for the same bits in q and synchronised p. */
static void expect_same_bits(thrum_state_def a, thrum_state_def b) {
  random_model m;
  make_model(&m);
  thrum_state *states[2] = {state_make(&m.model, &a), state_make(&m.model, &b)};
  double q[2][RANK], p[2][RANK];
  static const double load[RANK] = {0.3, -0.2, 0.1, 0.4, -0.5};

  // the same start, load and number of steps for both
  for (int s = 0; s < 2; s++) {
    state_put(&m.model, states[s], start_q, start_p);
    state_push(&m.model, states[s], load);
    state_steps(&m.model, states[s], 200);
    state_read(&m.model, states[s], q[s], p[s]);
    state_free(states[s]);
  }

  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(p[0], p[1], sizeof p[0]);
  random_model_free(&m);
}

static void ends_of_imexv_are_verlet_and_midpoint_bit_for_bit(void **context) {
  (void)context;
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
    thrum_state_def imexv = make_def(THRUM_INTEGRATOR_IMEXV);
    imexv.dt = 0.03;
    imexv.damping_alpha = 0.2;
    imexv.damping_beta = 0.01;
    imexv.damping_form = (thrum_damping_form)form;

    // all modes explicit, then none
    thrum_state_def other = imexv;
    imexv.explicit_count = RANK;
    other.integrator = THRUM_INTEGRATOR_VERLET;
    expect_same_bits(imexv, other);

    imexv.explicit_count = 0;
    other.integrator = THRUM_INTEGRATOR_MIDPOINT;
    expect_same_bits(imexv, other);
  }
}

/* --- equivalences of Newmark ------------------------------------------------------------------ */

/* Computes the largest absolute difference of q and p over 300 loaded steps; |q| and |p| are about
 * one. */
static double difference_of(const thrum_model *model, const thrum_state_def *a,
                            const thrum_state_def *b) {
  thrum_state *states[2] = {state_make(model, a), state_make(model, b)};
  double q[2][RANK], p[2][RANK], worst = 0;
  random_state random = {9};

  // the same start and loads for both
  for (int s = 0; s < 2; s++)
    state_put(model, states[s], start_q, start_p);
  for (int k = 0; k < 300; k++) {
    double f[RANK];
    random_vector(&random, RANK, 1.0, f);
    for (int s = 0; s < 2; s++) {
      state_push(model, states[s], f);
      state_steps(model, states[s], 1);
      state_read(model, states[s], q[s], p[s]);
    }

    worst = fmax(worst,
                 fmax(largest_difference(q[0], q[1], RANK), largest_difference(p[0], p[1], RANK)));
  }

  for (int s = 0; s < 2; s++)
    state_free(states[s]);
  return worst;
}

static void average_acceleration_newmark_is_midpoint_on_a_linear_model(void **context) {
  (void)context;
  random_model linear, nonlinear;
  random_model_make(&linear, 7, RANK, 1.0, 9.0, INFINITY);
  make_model(&nonlinear);

  thrum_state_def newmark = make_def(THRUM_INTEGRATOR_NEWMARK);
  newmark.dt = 0.1;
  newmark.damping_alpha = 0.2;
  newmark.damping_beta = 0.01;
  thrum_state_def midpoint = newmark;
  midpoint.integrator = THRUM_INTEGRATOR_MIDPOINT;

  // on a nonlinear model the two are different methods
  assert_true(difference_of(&linear.model, &newmark, &midpoint) < 1e-10);
  assert_true(difference_of(&nonlinear.model, &newmark, &midpoint) > 1e-4);

  random_model_free(&linear);
  random_model_free(&nonlinear);
}

/* Undamped, both are the leapfrog with its momentum at the time of q (Kane et al. 2000). */
static void explicit_newmark_is_verlet(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def newmark = make_def(THRUM_INTEGRATOR_NEWMARK), verlet;
  newmark.dt = 0.05;
  newmark.newmark_beta = 0;
  verlet = newmark;
  verlet.integrator = THRUM_INTEGRATOR_VERLET;
  assert_true(difference_of(&m.model, &newmark, &verlet) < 1e-10);
  random_model_free(&m);
}

/* With a beta_N this small v' and a' would be nothing but rounding if they were taken from q'. */
static void newmark_of_a_tiny_beta_is_the_explicit_one(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 1.0);
  thrum_state_def explicit_one = make_def(THRUM_INTEGRATOR_NEWMARK);
  explicit_one.dt = 0.05;
  explicit_one.newmark_beta = 0;
  thrum_state_def tiny = explicit_one;
  tiny.newmark_beta = 1e-12;
  assert_true(difference_of(&m.model, &tiny, &explicit_one) < 1e-7);
  random_model_free(&m);
}

/* --- time reversal and impulses --------------------------------------------------------------- */

/* The integrators for comparison lose energy, and two of them are of order one. */
static bool is_for_comparison(int integrator) {
  return integrator == THRUM_INTEGRATOR_BACKWARD_EULER ||
         integrator == THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER || integrator == THRUM_INTEGRATOR_RK4;
}

static void every_other_integrator_returns_when_time_is_reversed(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  static const double load[RANK] = {0.3, -0.2, 0.1, 0.4, -0.5};
  for (int integrator = 0; integrator < INTEGRATOR_COUNT; integrator++) {
    if (is_for_comparison(integrator))
      continue;
    thrum_state_def def = make_def((thrum_integrator)integrator);
    def.dt = 0.04;

    thrum_state *state = state_make(&m.model, &def);

    // go forward, far enough to be somewhere else
    double q[RANK], p[RANK];
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, load);
    state_steps(&m.model, state, 150);
    state_read(&m.model, state, q, p);
    assert_true(largest_difference(q, start_q, RANK) > 1e-2);

    // turn the momenta round and go back
    for (int i = 0; i < RANK; i++)
      p[i] = -p[i];

    state_put(&m.model, state, q, p);
    state_steps(&m.model, state, 150);
    state_read(&m.model, state, q, p);

    // the start is reached again, with the momenta turned round once more
    for (int i = 0; i < RANK; i++)
      p[i] = -p[i];

    assert_true(largest_difference(q, start_q, RANK) < 1e-9);
    assert_true(largest_difference(p, start_p, RANK) < 1e-9);

    state_free(state);
  }
  random_model_free(&m);
}

/* Without forces of its own the body's momentum is the impulse so far, at every step and for every
 * mode, also when dt changes on the way. */
static void an_impulse_counts_once_and_equally_for_all_modes(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 0.0, 0.0, INFINITY);

  // no stiffness of any order is left
  for (int64_t i = 0; i < m.model.c4_count; i++)
    m.c4[i] = 0;
  for (int64_t i = 0; i < m.model.c3_count; i++)
    m.c3[i] = 0;

  for (int integrator = 0; integrator < INTEGRATOR_COUNT; integrator++) {
    thrum_state_def def = make_def((thrum_integrator)integrator);
    thrum_state *state = state_make(&m.model, &def);
    double impulse[RANK] = {0}, p[RANK], dt = def.dt;

    // a load in every third step, and now and then another time step
    random_state random = {11};
    for (int k = 0; k < 40; k++) {
      double f[RANK];
      random_vector(&random, RANK, k % 3 == 0 ? 100.0 : 0.0, f);

      if (k % 7 == 5) {
        dt *= k % 2 == 0 ? 0.5 : 1.7;
        assert_int_equal(thrum_state_set_dt(&m.model, state, dt, NULL), THRUM_OK);
      }

      // the momentum is the sum of the impulses
      state_push(&m.model, state, f);
      state_steps(&m.model, state, 1);
      state_read(&m.model, state, NULL, p);
      for (int i = 0; i < RANK; i++)
        impulse[i] += dt * f[i];
      assert_true(largest_difference(p, impulse, RANK) < 1e-13);
    }

    state_free(state);
  }
  random_model_free(&m);
}

static void changing_dt_on_the_way_keeps_order_two(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const test_load none = {0, 1};
  for (int integrator = 0; integrator < INTEGRATOR_COUNT; integrator++) {
    if (is_for_comparison(integrator))
      continue;
    thrum_state_def def = make_def((thrum_integrator)integrator);

    // the reference is computed with much shorter steps
    double q_ref[RANK], p_ref[RANK], error[2];
    memcpy(q_ref, start_q, sizeof q_ref);
    memcpy(p_ref, start_p, sizeof p_ref);
    reference_advance(&m.model, &def, &none, 0, 2.0 / 8000, 8000, q_ref, p_ref);

    // steps of one and of two units in turns, and the same with half the unit
    for (int level = 0; level < 2; level++) {
      const double unit = 0.01 / (1 << level);
      def.dt = unit;

      thrum_state *state = state_make(&m.model, &def);
      state_put(&m.model, state, start_q, start_p);

      for (int k = 0; k < 20 << level; k++) {
        assert_int_equal(thrum_state_set_dt(&m.model, state, unit, NULL), THRUM_OK);
        state_steps(&m.model, state, 4);
        assert_int_equal(thrum_state_set_dt(&m.model, state, 2 * unit, NULL), THRUM_OK);
        state_steps(&m.model, state, 3);
      }

      double q[RANK], p[RANK];
      state_read(&m.model, state, q, p);
      error[level] = fmax(largest_difference(q, q_ref, RANK), largest_difference(p, p_ref, RANK));
      assert_true(fabs(thrum_state_report_get(state).time - 2.0) < 1e-12);
      state_free(state);
    }

    // halving the unit divides the error by nearly four
    assert_true(log2(error[0] / error[1]) > 1.9);
  }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(imexv_is_of_order_two),
      cmocka_unit_test(verlet_is_of_order_two),
      cmocka_unit_test(the_quadratic_split_is_of_order_two),
      cmocka_unit_test(the_position_form_is_of_order_two),
      cmocka_unit_test(energy_is_of_order_two),
      cmocka_unit_test(midpoint_is_of_order_two),
      cmocka_unit_test(newmark_is_of_order_two_for_any_beta),
      cmocka_unit_test(newmark_is_of_order_one_for_gamma_beyond_one_half),

      // a scheme is what its equations say
      cmocka_unit_test(imexv_equals_its_equations_for_every_split),
      cmocka_unit_test(verlet_and_midpoint_equal_their_equations),
      cmocka_unit_test(ends_of_imexv_are_verlet_and_midpoint_bit_for_bit),
      cmocka_unit_test(average_acceleration_newmark_is_midpoint_on_a_linear_model),
      cmocka_unit_test(explicit_newmark_is_verlet),
      cmocka_unit_test(newmark_of_a_tiny_beta_is_the_explicit_one),

      // what all schemes have in common
      cmocka_unit_test(every_other_integrator_returns_when_time_is_reversed),
      cmocka_unit_test(an_impulse_counts_once_and_equally_for_all_modes),
      cmocka_unit_test(changing_dt_on_the_way_keeps_order_two),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
