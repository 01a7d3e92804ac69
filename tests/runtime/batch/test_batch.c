/* Many states stepped side by side end with the bits of each stepped alone, for every kernel, size
 * and partition of the range, mixed defs, and states that fall back or fail.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/sanitized.h"
#include "tests/support/state_support.h"

#include "runtime/batch/batch_kernel.h"
#include "thrum/batch.h"

enum { STATES = 29, STEPS = 30 };

typedef struct batch {
  thrum_state *alone[STATES];
  thrum_state *together[STATES];
  void *workspace;
  size_t size;
} batch;

static void batch_make(batch *c, const thrum_model *model, thrum_state_def (*def_of)(int)) {
  assert_int_equal(thrum_batch_size(model, &c->size, NULL), THRUM_OK);
  c->workspace = aligned_alloc(64, c->size);
  assert_non_null(c->workspace);
  memset(c->workspace, 0xff, c->size);

  // both states of a pair start from the same q and p
  random_state random = {11};
  for (int n = 0; n < STATES; n++) {
    const thrum_state_def def = def_of(n);
    double q[64], p[64];
    c->alone[n] = state_make(model, &def);
    c->together[n] = state_make(model, &def);
    random_vector(&random, model->rank, 0.3, q);
    random_vector(&random, model->rank, 1.0, p);
    state_put(model, c->alone[n], q, p);
    state_put(model, c->together[n], q, p);
  }
}

static void batch_free(batch *c) {
  for (int n = 0; n < STATES; n++) {
    state_free(c->alone[n]);
    state_free(c->together[n]);
  }
  free(c->workspace);
}

/* Sets another load on every state, the same on both of a pair. */
static void batch_push(batch *c, const thrum_model *model, random_state *random, double scale) {
  for (int n = 0; n < STATES; n++) {
    double f[64];
    random_vector(random, model->rank, scale, f);
    state_push(model, c->alone[n], f);
    state_push(model, c->together[n], f);
  }
}

/* Makes one step of both, in runs of `part` states; all states and statuses must be equal. */
static void batch_step(batch *c, const thrum_model *model, int part) {
  thrum_status alone[STATES], together[STATES];
  for (int n = 0; n < STATES; n++)
    alone[n] = thrum_step(model, c->alone[n], NULL);

  // the batch reports the first failure, or else the most notable status
  for (int first = 0; first < STATES; first += part) {
    const int count = first + part < STATES ? part : STATES - first;
    thrum_status worst = THRUM_OK;
    for (int n = first; n < first + count; n++)
      if ((worst >= 0 && alone[n] < 0) ||
          (worst >= 0 && alone[n] > 0 && (worst == THRUM_OK || alone[n] < worst)))
        worst = alone[n];
    thrum_error error;

    assert_int_equal(thrum_batch_step(model, c->together + first, count, together + first,
                                      c->workspace, c->size, &error),
                     worst);
  }

  for (int n = 0; n < STATES; n++) {
    assert_int_equal(together[n], alone[n]);
    assert_memory_equal(c->together[n], c->alone[n], thrum_state_kept_bytes(c->alone[n]));
  }
}

static thrum_state_def plain(int n) {
  (void)n;
  thrum_state_def def = imexv_def();
  def.dt = 0.02;
  def.damping_alpha = 0.1;
  return def;
}

static thrum_state_def avx2(int n) {
  thrum_state_def def = plain(n);
  def.kernel = THRUM_KERNEL_AVX2;
  return def;
}

static thrum_state_def position(int n) {
  thrum_state_def def = plain(n);
  def.split_form = THRUM_FORM_POSITION;
  return def;
}

static thrum_state_def reference(int n) {
  thrum_state_def def = plain(n);
  def.kernel = THRUM_KERNEL_REFERENCE;
  return def;
}

static thrum_state_def energy(int n) {
  thrum_state_def def = plain(n);
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  return def;
}

static thrum_state_def energy_avx2(int n) {
  thrum_state_def def = energy(n);
  def.kernel = THRUM_KERNEL_AVX2;
  return def;
}

static thrum_state_def newmark(int n) {
  thrum_state_def def = plain(n);
  def.integrator = THRUM_INTEGRATOR_NEWMARK;
  return def;
}

static thrum_state_def fox_goodwin(int n) {
  thrum_state_def def = plain(n);
  def.integrator = THRUM_INTEGRATOR_FOX_GOODWIN;
  return def;
}

static thrum_state_def midpoint(int n) {
  thrum_state_def def = plain(n);
  def.integrator = THRUM_INTEGRATOR_MIDPOINT;
  return def;
}

/* Gives runs of equal defs, then others, with every integrator, split, form and kernel. */
static thrum_state_def mixed(int n) {
  thrum_state_def def = plain(n);

  // single states that differ from their neighbours
  if (n % 3 == 1)
    def.integrator = every_integrator[n / 3 % INTEGRATOR_COUNT];
  if (n % 11 == 7)
    def.damping_form = THRUM_DAMPING_TANGENT;
  if (n % 11 == 7)
    def.damping_beta = 1e-3;
  if (n % 7 == 6)
    def.split_form = THRUM_FORM_QUADRATIC;
  if (n % 7 == 2 || n % 7 == 3)
    def.split_form = THRUM_FORM_POSITION;

  // the last ones have splits of their own, equal ones first
  if (n > 17)
    def.split_rule = THRUM_SPLIT_COUNT;
  if (n > 17)
    def.explicit_count = n < 24 ? 2 : n % 6;

  def.kernel = n % 9 == 8 ? THRUM_KERNEL_AVX2 : THRUM_KERNEL_BEST;
  def.adaptive = n % 10 != 9;
  def.solver = n % 15 == 4 ? THRUM_SOLVER_NEWTON : THRUM_SOLVER_QUASI_NEWTON;
  return def;
}

static void a_batch_has_the_bits_of_its_states_alone(void **context) {
  (void)context;
  static const int64_t ranks[] = {1, 2, 8, 9, 21};
  static thrum_state_def (*const defs[])(int) = {
      plain, position, avx2, reference, energy, energy_avx2, newmark, midpoint, fox_goodwin};
  static const int parts[] = {1, 2, 5, 8, 9, STATES};
  for (size_t r = 0; r < LENGTH_OF_RUN(sizeof ranks / sizeof ranks[0], 4); r++)
    for (size_t d = 0; d < sizeof defs / sizeof defs[0]; d++) {
      random_model m;
      random_model_make(&m, 7 + r, ranks[r], 5, 300, 5.0);
      random_model_pack(&m);

      batch c;
      batch_make(&c, &m.model, defs[d]);

      // loads change now and then, and the list is cut into parts of changing length
      random_state random = {3};
      for (int k = 0; k < LENGTH_OF_RUN(STEPS, 12); k++) {
        if (k % 10 == 0)
          batch_push(&c, &m.model, &random, 20.0);
        batch_step(&c, &m.model, parts[(size_t)k % (sizeof parts / sizeof parts[0])]);
      }

      // the batch did iterate, so the solves were compared too
      const thrum_state_report report = thrum_state_report_get(c.together[0]);
      assert_true(ranks[r] < 7 || (report.iterations > 0 && (report.explicit_modes > 0 || d > 3)));

      batch_free(&c);
      random_model_free(&m);
    }
}

/* Large models are packed in single precision where nothing is lost. */
static void a_batch_of_single_precision_coefficients_keeps_its_bits(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, 40, 5, 300, 5.0);

  // coefficients that are exact in single precision
  for (int64_t k = 0; k < m.model.c3_count; k++)
    m.c3[k] = (double)(float)m.c3[k];
  for (int64_t k = 0; k < m.model.c4_count; k++)
    m.c4[k] = (double)(float)m.c4[k];
  random_model_pack(&m);
  assert_non_null(m.model.packed_single);

  // the packed form is used with both kernels
  static thrum_state_def (*const defs[])(int) = {plain,       avx2,    energy,
                                                 energy_avx2, newmark, fox_goodwin};
  for (size_t d = 0; d < sizeof defs / sizeof defs[0]; d++) {
    batch c;
    batch_make(&c, &m.model, defs[d]);
    for (int k = 0; k < LENGTH_OF_RUN(5, 2); k++)
      batch_step(&c, &m.model, STATES);

    const thrum_state_report report = thrum_state_report_get(c.together[0]);
    assert_true(report.iterations > 0 && (report.explicit_modes > 0 || d > 1));
    batch_free(&c);
  }
  random_model_free(&m);
}

/* Gives some of the states an explicit mode beyond the bound. */
static thrum_state_def bold(int n) {
  thrum_state_def def = plain(n);
  def.dt = n % 3 == 1 ? 6.6e-3 : 4e-3;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = 8;
  return def;
}

/* The monitor makes modes implicit while their state is in a group. */
static void states_that_leave_their_group_keep_their_bits(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, 9, 5, 300, 5.0);
  random_model_pack(&m);
  batch c;
  batch_make(&c, &m.model, bold);

  int64_t switches = 0, stayed = 0;
  for (int k = 0; k < 2 * STEPS; k++)
    batch_step(&c, &m.model, STATES);

  // some states changed their split, and some kept it
  for (int n = 0; n < STATES; n++) {
    const thrum_state_report report = thrum_state_report_get(c.together[n]);
    switches += report.split_changes;
    stayed += report.explicit_modes == 8 ? 1 : 0;
  }

  assert_true(switches > 0 && stayed > 0);
  batch_free(&c);
  random_model_free(&m);
}

static thrum_state_def unstable(int n) {
  thrum_state_def def = plain(n);
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = 8;
  def.damping_alpha = 0;
  return def;
}

/* Violent motion: imexv gives way to energy in many states, some of which need fallback levels or
 * the average vector field; they are stepped in groups from then on. */
static void states_that_have_switched_to_energy_keep_their_bits(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, 9, 5, 120, 0.5);
  random_model_pack(&m);
  batch c;
  batch_make(&c, &m.model, unstable);
  for (int k = 0; k < 6 * STEPS; k++)
    batch_step(&c, &m.model, k % 3 == 0 ? 11 : STATES);

  // the bits were compared in each step; this makes sure that they were those of energy
  int switched = 0;
  for (int n = 0; n < STATES; n++)
    switched += thrum_state_report_get(c.together[n]).scheme == THRUM_SCHEME_ENERGY ? 1 : 0;
  assert_true(switched > STATES / 2);
  batch_free(&c);
  random_model_free(&m);
}

/* Each has a time step of its own, which changes at times. */
static void states_of_many_time_steps_keep_their_bits(void **context) {
  (void)context;
  static thrum_state_def (*const defs[])(int) = {position, energy, newmark, fox_goodwin};
  random_model m;
  random_model_make(&m, 7, 9, 5, 120, 1.0);
  random_model_pack(&m);

  // a third of the states gets another length in each step
  for (size_t d = 0; d < sizeof defs / sizeof defs[0]; d++) {
    batch c;
    batch_make(&c, &m.model, defs[d]);
    for (int k = 0; k < STEPS; k++) {
      for (int n = k % 3; n < STATES; n += 3) {
        const double dt = 0.01 + 0.001 * ((7 * n + k) % 10);
        assert_int_equal(thrum_state_set_dt(&m.model, c.alone[n], dt, NULL), THRUM_OK);
        assert_int_equal(thrum_state_set_dt(&m.model, c.together[n], dt, NULL), THRUM_OK);
      }
      batch_step(&c, &m.model, STATES);
    }
    batch_free(&c);
  }
  random_model_free(&m);
}

static void states_of_different_defs_keep_their_bits(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 5, 9, 5, 300, 1.0);
  random_model_pack(&m);

  // the states of a part are sorted into groups of equal defs
  for (int part = 3; part <= STATES; part += 13) {
    batch c;
    batch_make(&c, &m.model, mixed);

    random_state random = {3};
    for (int k = 0; k < STEPS; k++) {
      if (k % 10 == 0)
        batch_push(&c, &m.model, &random, 20.0);
      batch_step(&c, &m.model, part);
    }

    batch_free(&c);
  }
  random_model_free(&m);
}

/* The list is longer than what is sorted at a time, with states of three kinds in turns. */
static void a_long_list_of_many_kinds_keeps_its_bits(void **context) {
  (void)context;
  enum { MANY = 600 };
  random_model m;
  random_model_make(&m, 5, 9, 5, 300, 1.0);
  random_model_pack(&m);

  static thrum_state *alone[MANY], *together[MANY];
  static thrum_status statuses[MANY];
  size_t size = 0;
  assert_int_equal(thrum_batch_size(&m.model, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, size);
  assert_non_null(workspace);

  // neighbours differ in their split, so that each group is spread over the list
  random_state random = {4};
  for (int n = 0; n < MANY; n++) {
    thrum_state_def def = plain(n);
    def.split_rule = THRUM_SPLIT_COUNT;
    def.explicit_count = 1 + n % 3;

    double q[9], p[9];
    random_vector(&random, 9, 0.1, q);
    random_vector(&random, 9, 1.0, p);

    alone[n] = state_make(&m.model, &def);
    together[n] = state_make(&m.model, &def);
    state_put(&m.model, alone[n], q, p);
    state_put(&m.model, together[n], q, p);
  }

  // statuses agree at each step, and all bytes at the end
  for (int k = 0; k < 5; k++) {
    thrum_batch_step(&m.model, together, MANY, statuses, workspace, size, NULL);
    for (int n = 0; n < MANY; n++)
      assert_int_equal(thrum_step(&m.model, alone[n], NULL), statuses[n]);
  }

  for (int n = 0; n < MANY; n++) {
    assert_memory_equal(together[n], alone[n], thrum_state_kept_bytes(alone[n]));
    assert_int_equal(thrum_state_report_get(together[n]).steps, 5);
    state_free(alone[n]);
    state_free(together[n]);
  }
  free(workspace);
  random_model_free(&m);
}

static thrum_state_def brittle(int n) {
  thrum_state_def def = plain(n);

  // so few iterations that fallback levels are needed; some have no fallback chain and fail
  def.iterations_max = 1 + n % 3;
  def.tolerance = 1e-13;
  def.fallback = n % 2;
  def.adaptive = n % 4 > 1;
  if (n >= STATES / 3)
    def.integrator = n % 5 > 1 ? THRUM_INTEGRATOR_ENERGY : THRUM_INTEGRATOR_NEWMARK;
  return def;
}

/* A state is stepped as often as it stands in the list. */
static void a_state_that_is_listed_again_steps_again(void **context) {
  (void)context;
  static const int listed[] = {0, 1, 2, 1, 3, 4, 5, 6, 7, 8, 9, 0, 0, 10, 11, 12, 13, 14, 15, 2};
  enum { LISTED = sizeof listed / sizeof listed[0] };
  random_model m;
  random_model_make(&m, 19, 9, 5, 300, 5.0);
  random_model_pack(&m);

  batch c;
  batch_make(&c, &m.model, plain);
  thrum_state *list[LISTED];
  for (int n = 0; n < LISTED; n++)
    list[n] = c.together[listed[n]];

  // alone, a state is stepped as often as it stands in the list
  for (int k = 0; k < STEPS; k++) {
    thrum_status statuses[LISTED];
    assert_int_equal(thrum_batch_step(&m.model, list, LISTED, statuses, c.workspace, c.size, NULL),
                     THRUM_OK);
    for (int n = 0; n < LISTED; n++)
      assert_int_equal(thrum_step(&m.model, c.alone[listed[n]], NULL), THRUM_OK);
  }

  assert_int_equal(thrum_state_report_get(c.together[0]).steps, 3 * STEPS);
  for (int n = 0; n < 16; n++)
    assert_memory_equal(c.together[n], c.alone[n], thrum_state_kept_bytes(c.alone[n]));

  batch_free(&c);
  random_model_free(&m);
}

static void states_that_fall_back_or_fail_do_as_alone_and_spoil_no_other(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 5, 9, 5, 300, 0.2);
  random_model_pack(&m);

  batch c;
  batch_make(&c, &m.model, brittle);

  const int steps = LENGTH_OF_RUN(STEPS, 8);
  random_state random = {3};
  for (int k = 0; k < steps; k++) {
    batch_push(&c, &m.model, &random, k % 7 == 6 ? 1e5 : 50.0);

    // one load is beyond all numbers
    double huge[9] = {0};
    huge[k % 9] = 1e308;
    state_push(&m.model, c.alone[k % STATES], huge);
    state_push(&m.model, c.together[k % STATES], huge);
    batch_step(&c, &m.model, STATES);
  }

  // both fallbacks and failures did happen
  int64_t fallback_levels = 0, missed = 0;
  for (int n = 0; n < STATES; n++) {
    const thrum_state_report report = thrum_state_report_get(c.together[n]);
    fallback_levels += report.newton_steps + report.energy_steps + report.substep_steps;
    missed += steps - report.steps;
  }
  assert_true(fallback_levels > 0);
  assert_true(missed > 0);
  batch_free(&c);
  random_model_free(&m);
}

static void bad_batches_and_workspaces_are_refused(void **context) {
  (void)context;
  random_model m, other;
  random_model_make(&m, 5, 4, 5, 300, 1.0);
  random_model_make(&other, 5, 5, 5, 300, 1.0);
  thrum_error error;

  // the size of the workspace
  size_t size = 0;
  assert_int_equal(thrum_batch_size(NULL, &size, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_size(&m.model, NULL, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_size(&m.model, &size, &error), THRUM_OK);

  // the second state belongs to another model
  unsigned char *workspace = aligned_alloc(64, size + 64);
  assert_non_null(workspace);
  const thrum_state_def def = plain(0);
  thrum_state *states[3] = {state_make(&m.model, &def), state_make(&other.model, &def),
                            state_make(&m.model, &def)};
  void *before = state_snapshot(states[0]);

  // arguments that are refused leave every state as it was; a list of none is done at once
  assert_int_equal(thrum_batch_step(&m.model, states, 1, NULL, workspace, size - 1, &error),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_batch_step(&m.model, states, 1, NULL, workspace + 8, size, &error),
                   THRUM_MISALIGNED);
  assert_int_equal(thrum_batch_step(&m.model, NULL, 1, NULL, workspace, size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_step(&m.model, states, -1, NULL, workspace, size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_memory_equal(states[0], before, thrum_state_kept_bytes(states[0]));
  assert_int_equal(thrum_batch_step(&m.model, NULL, 0, NULL, workspace, size, &error), THRUM_OK);

  // a state of another model is named, and the others step
  thrum_status statuses[3];
  assert_int_equal(thrum_batch_step(&m.model, states, 3, statuses, workspace, size, &error),
                   THRUM_MODEL_MISMATCH);
  assert_non_null(strstr(error.message, "state 1"));
  assert_int_equal(statuses[0], THRUM_OK);
  assert_int_equal(statuses[1], THRUM_MODEL_MISMATCH);
  assert_int_equal(statuses[2], THRUM_OK);
  assert_int_equal(thrum_state_report_get(states[0]).steps, 1);
  assert_int_equal(thrum_state_report_get(states[2]).steps, 1);

  for (int n = 0; n < 3; n++)
    state_free(states[n]);
  free(before);
  free(workspace);
  random_model_free(&m);
  random_model_free(&other);
}

/* The list is so long that the missing state is one that is prefetched with the next group. */
static void a_missing_state_is_named_and_the_others_step(void **context) {
  (void)context;
  enum { COUNT = 24, MISSING = 13 };
  random_model m;
  random_model_make(&m, 5, 9, 5, 300, 1.0);
  random_model_pack(&m);
  size_t size = 0;
  assert_int_equal(thrum_batch_size(&m.model, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, size);
  assert_non_null(workspace);

  // all states but one are there
  const thrum_state_def def = plain(0);
  thrum_state *states[COUNT];
  thrum_status statuses[COUNT];
  thrum_error error;
  for (int n = 0; n < COUNT; n++)
    states[n] = n == MISSING ? NULL : state_make(&m.model, &def);

  assert_int_equal(thrum_batch_step(&m.model, states, COUNT, statuses, workspace, size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "state 13"));

  for (int n = 0; n < COUNT; n++) {
    assert_int_equal(statuses[n], n == MISSING ? THRUM_INVALID_ARGUMENT : THRUM_OK);
    if (n != MISSING)
      assert_int_equal(thrum_state_report_get(states[n]).steps, 1);
    state_free(states[n]);
  }

  free(workspace);
  random_model_free(&m);
}

/* Arrays in and out of a batch, and the same state by state, with rows that lie apart. */
static void arrays_of_a_batch_are_those_of_its_states(void **context) {
  (void)context;
  enum { COUNT = 5, RANK = 6, STRIDE = 9 };
  random_model m;
  random_model_make(&m, 3, RANK, 5, 40, INFINITY);
  const thrum_model *model = &m.model;
  thrum_state *states[COUNT];
  double in[COUNT * STRIDE], q[COUNT * STRIDE], p[COUNT * STRIDE], alone[2][RANK];
  const uint8_t chosen[COUNT] = {1, 0, 1, 1, 0};
  thrum_energies energies[COUNT];
  random_state random = {5};
  random_vector(&random, COUNT * STRIDE, 0.2, in);
  for (int n = 0; n < COUNT; n++) {
    const thrum_state_def def = energy(n);
    states[n] = state_make(model, &def);
  }

  // set where chosen, got everywhere, with nothing between the rows touched
  assert_int_equal(thrum_batch_set(model, states, COUNT, chosen, in, NULL, STRIDE, NULL), THRUM_OK);
  assert_int_equal(thrum_batch_set_forces(model, states, COUNT, in, 0, NULL), THRUM_OK);
  for (int n = 0; n < COUNT; n++)
    assert_int_equal(thrum_step(model, states[n], NULL), THRUM_OK);
  for (int n = 0; n < COUNT * STRIDE; n++)
    q[n] = p[n] = 7;
  assert_int_equal(thrum_batch_get(model, states, COUNT, q, p, STRIDE, NULL), THRUM_OK);
  assert_int_equal(thrum_batch_energies(model, states, COUNT, energies, NULL), THRUM_OK);
  for (int n = 0; n < COUNT; n++) {
    thrum_energies one;
    const thrum_state_def def = energy(n);
    thrum_state *twin = state_make(model, &def);
    state_put(model, twin, chosen[n] ? in + STRIDE * n : NULL, NULL);
    state_push(model, twin, in);
    assert_int_equal(thrum_step(model, twin, NULL), THRUM_OK);
    assert_memory_equal(twin, states[n], thrum_state_kept_bytes(twin));
    assert_int_equal(thrum_state_get(model, twin, alone[0], alone[1], NULL), THRUM_OK);
    assert_int_equal(thrum_state_energies(model, twin, &one, NULL), THRUM_OK);
    assert_memory_equal(alone[0], q + STRIDE * n, sizeof alone[0]);
    assert_memory_equal(alone[1], p + STRIDE * n, sizeof alone[1]);
    assert_memory_equal(&one, &energies[n], sizeof one);
    for (int k = RANK; k < STRIDE; k++)
      assert_true(q[STRIDE * n + k] == 7);
    state_free(twin);
  }

  // a row that cannot be set is named, and the others are set
  thrum_error error = {.status = THRUM_OK};
  in[STRIDE + 2] = NAN;
  assert_int_equal(thrum_batch_set(model, states, COUNT, NULL, in, NULL, STRIDE, &error),
                   THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "state 1: "));
  memcpy(alone[0], q + STRIDE, sizeof alone[0]);
  assert_int_equal(thrum_batch_get(model, states, COUNT, q, NULL, STRIDE, NULL), THRUM_OK);
  assert_memory_equal(alone[0], q + STRIDE, sizeof alone[0]);
  assert_memory_equal(in + 4 * STRIDE, q + 4 * STRIDE, sizeof alone[0]);
  assert_int_equal(thrum_batch_set_forces(model, states, COUNT, in, STRIDE, &error),
                   THRUM_BAD_VALUE);

  // calls that say nothing
  assert_int_equal(thrum_batch_get(model, states, COUNT, q, p, RANK - 1, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_set_forces(model, NULL, COUNT, in, 0, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_set_forces(model, states, COUNT, in, -1, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_set(NULL, states, COUNT, NULL, in, in, 0, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_energies(model, states, COUNT, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_batch_energies(model, NULL, 0, NULL, NULL), THRUM_OK);
  for (int n = 0; n < COUNT; n++)
    state_free(states[n]);
  random_model_free(&m);
}

static void fast_kernels_have_passes_for_batches(void **context) {
  (void)context;
  static const thrum_kernel_id fast[] = {THRUM_KERNEL_AVX2, THRUM_KERNEL_AVX512};
  for (int n = 0; n < 2; n++)
    if (thrum_kernel_usable(fast[n]))
      assert_non_null(thrum_batch_kernel_of(fast[n]));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(fast_kernels_have_passes_for_batches),
      cmocka_unit_test(a_batch_has_the_bits_of_its_states_alone),
      cmocka_unit_test(a_batch_of_single_precision_coefficients_keeps_its_bits),
      cmocka_unit_test(states_that_leave_their_group_keep_their_bits),

      // states that differ in more than their motion
      cmocka_unit_test(states_that_have_switched_to_energy_keep_their_bits),
      cmocka_unit_test(states_of_many_time_steps_keep_their_bits),
      cmocka_unit_test(states_of_different_defs_keep_their_bits),
      cmocka_unit_test(a_long_list_of_many_kinds_keeps_its_bits),
      cmocka_unit_test(a_state_that_is_listed_again_steps_again),
      cmocka_unit_test(states_that_fall_back_or_fail_do_as_alone_and_spoil_no_other),

      // what goes in and out
      cmocka_unit_test(arrays_of_a_batch_are_those_of_its_states),

      // what is refused
      cmocka_unit_test(bad_batches_and_workspaces_are_refused),
      cmocka_unit_test(a_missing_state_is_named_and_the_others_step),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
