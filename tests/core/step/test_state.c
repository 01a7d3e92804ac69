/* Tests of the state as an object: refusals, rest, round trips, snapshots, failed steps, counters.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/polynomial.h"

enum { RANK = 6, LOW = 2 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};
static const double push[RANK] = {0.5, -0.4, 0.3, -0.2, 0.1, 0.6};

static void make_model(random_model *m) {
  random_model_make(m, 21, RANK, 1.0, 12.0, 0.5);
}

static thrum_state_def make_def(thrum_integrator integrator, thrum_damping_form form) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.dt = 0.05;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = LOW;
  def.damping_form = form;
  def.damping_alpha = 0.1;
  def.damping_beta = 0.005;
  return def;
}

static void expect_same_bytes(const thrum_state *state, const void *snapshot) {
  assert_memory_equal(state, snapshot, thrum_state_kept_bytes(state));
}

/* --- refusals --------------------------------------------------------------------------------- */

static void expect_refused(const thrum_model *model, const thrum_state_def *def,
                           thrum_status expected, const char *named) {
  size_t size = 77;
  thrum_error error = {.status = THRUM_OK};
  assert_int_equal(thrum_state_size(model, def, &size, &error), expected);
  assert_int_equal(error.status, expected);
  assert_int_equal(size, 77);
  if (!strstr(error.message, named))
    fail_msg("'%s' does not name %s", error.message, named);

  // the refusal is the same without a place for the detail
  assert_int_equal(thrum_state_size(model, def, &size, NULL), expected);
}

static void an_uninitialised_def_is_refused(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def;
  memset(&def, 0, sizeof def);
  expect_refused(&m.model, &def, THRUM_UNINITIALISED_DEF, "thrum_default_state_def");
  expect_refused(&m.model, NULL, THRUM_UNINITIALISED_DEF, "thrum_default_state_def");
  memset(&def, 0xff, sizeof def);
  expect_refused(&m.model, &def, THRUM_UNINITIALISED_DEF, "thrum_default_state_def");
  random_model_free(&m);
}

#define REFUSE(field, value)                                                                       \
  do {                                                                                             \
    thrum_state_def def = imexv_def();                                                             \
    def.field = (value);                                                                           \
    expect_refused(&m.model, &def, THRUM_INVALID_ARGUMENT, #field);                                \
  } while (0)

#define ACCEPT(field, value)                                                                       \
  do {                                                                                             \
    thrum_state_def def = imexv_def();                                                             \
    size_t size;                                                                                   \
    def.field = (value);                                                                           \
    assert_int_equal(thrum_state_size(&m.model, &def, &size, NULL), THRUM_OK);                     \
  } while (0)

static void every_field_of_a_def_is_checked_and_named(void **context) {
  (void)context;
  random_model m;
  make_model(&m);

  // no field of numbers takes one that is not finite
  static const double never[3] = {NAN, INFINITY, -INFINITY};
  for (int i = 0; i < 3; i++) {
    REFUSE(dt, never[i]);
    REFUSE(damping_alpha, never[i]);
    REFUSE(damping_beta, never[i]);
    REFUSE(split_safety, never[i]);
    REFUSE(newmark_beta, never[i]);
    REFUSE(newmark_gamma, never[i]);
    REFUSE(tolerance, never[i]);
  }

  // numbers just outside their ranges
  REFUSE(dt, 0.0);
  REFUSE(dt, -0.003);
  REFUSE(damping_alpha, -1e-9);
  REFUSE(damping_beta, -1e-9);
  REFUSE(split_safety, 0.0);
  REFUSE(split_safety, 1.0001);
  REFUSE(newmark_beta, -0.1);
  REFUSE(newmark_gamma, -0.1);
  REFUSE(newmark_gamma, 1.1);
  REFUSE(tolerance, -1e-3);
  REFUSE(tolerance, 0.02);

  // counts, and choices that do not exist
  REFUSE(iterations_max, 0);
  REFUSE(explicit_count, -1);
  REFUSE(explicit_count, RANK + 1);
  REFUSE(integrator, (thrum_integrator)INTEGRATOR_COUNT);
  REFUSE(integrator, (thrum_integrator)-1);
  REFUSE(split_form, (thrum_split_form)3);
  REFUSE(split_form, (thrum_split_form)-1);
  REFUSE(adaptive, 2);
  REFUSE(adaptive, -1);
  REFUSE(fallback, 2);
  REFUSE(fallback, -1);
  REFUSE(solver, (thrum_implicit_solver)2);
  REFUSE(solver, (thrum_implicit_solver)-1);
  REFUSE(frequency_matched, 2);
  REFUSE(untrained_flow, 2);
  REFUSE(borrows_scratch, 2);
  REFUSE(damping_form, (thrum_damping_form)2);
  REFUSE(split_rule, (thrum_split_rule)3);

  // the ends of the ranges themselves are taken
  ACCEPT(split_safety, 1.0);
  ACCEPT(newmark_beta, 0.0);
  ACCEPT(newmark_gamma, 1.0);
  ACCEPT(tolerance, 0.0);
  ACCEPT(tolerance, 1e-2);
  ACCEPT(explicit_count, RANK);
  ACCEPT(iterations_max, 1);

  random_model_free(&m);
}

static void a_model_that_cannot_be_stepped_is_refused(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_state_def def = imexv_def();
  expect_refused(NULL, &def, THRUM_INVALID_ARGUMENT, "model");

  // a rank out of its range, and a polynomial that is not there
  thrum_model broken = m.model;
  broken.rank = 0;
  expect_refused(&broken, &def, THRUM_INVALID_ARGUMENT, "rank");
  broken.rank = THRUM_RANK_MAX + 1;
  expect_refused(&broken, &def, THRUM_INVALID_ARGUMENT, "rank");
  broken = m.model;
  broken.c4 = NULL;
  expect_refused(&broken, &def, THRUM_MISSING, "c4");

  // eigenvalues that are no numbers or do not ascend
  m.omega2[3] = NAN;
  expect_refused(&m.model, &def, THRUM_BAD_VALUE, "entry 3");
  m.omega2[3] = m.omega2[2] * 0.5;
  expect_refused(&m.model, &def, THRUM_BAD_VALUE, "entry 3");

  random_model_free(&m);
}

static void memory_that_is_short_or_misaligned_is_refused(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_state_def def = imexv_def();
  size_t size;
  assert_int_equal(thrum_state_size(&m.model, &def, &size, NULL), THRUM_OK);
  assert_int_equal(size % 64, 0);

  // the bytes beyond the size show whether anything is written there
  unsigned char *memory = aligned_alloc(64, size + 64);
  assert_non_null(memory);
  memset(memory, 1, size + 64);
  thrum_state *state = (thrum_state *)(void *)memory;
  thrum_state *before = state;

  // every refusal comes before the first write
  assert_int_equal(thrum_state_init(memory, size - 1, &m.model, &def, &state, NULL),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_state_init(memory + 8, size, &m.model, &def, &state, NULL),
                   THRUM_MISALIGNED);
  assert_int_equal(thrum_state_init(NULL, size, &m.model, &def, &state, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_init(memory, size, &m.model, &def, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_ptr_equal(state, before);
  for (size_t i = 0; i < size + 64; i++)
    assert_int_equal(memory[i], 1);

  // the same memory, whole and aligned, is taken
  assert_int_equal(thrum_state_init(memory, size, &m.model, &def, &state, NULL), THRUM_OK);
  assert_int_equal(thrum_state_bytes(state), size);

  // nothing beyond the planned size is written, by no call
  state_put(&m.model, state, start_q, start_p);
  state_steps(&m.model, state, 20);
  for (size_t i = size; i < size + 64; i++)
    assert_int_equal(memory[i], 1);

  free(memory);
  random_model_free(&m);
}

/* Writes NaN wherever no call may look. */
static void spoil_scratch(thrum_state *state) {
  const size_t kept = thrum_state_kept_bytes(state);
  memset((unsigned char *)state + kept, 0xff, thrum_state_bytes(state) - kept);
}

static void what_lies_behind_the_kept_bytes_does_not_count(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int i = 0; i < INTEGRATOR_COUNT; i++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++)
      for (int hard = 0; hard < 2; hard++) {
        thrum_state_def def = make_def(every_integrator[i], (thrum_damping_form)form);

        // a large step and few iterations lead to the fallback levels
        if (hard) {
          def.dt *= 20;
          def.iterations_max = 3;
        }

        // two states of one history, one of which finds NaN in its scratch memory at every call
        thrum_state *state = state_make(&m.model, &def), *spoilt = state_make(&m.model, &def);
        assert_true(thrum_state_kept_bytes(state) < thrum_state_bytes(state));
        spoil_scratch(spoilt);
        state_put(&m.model, state, start_q, start_p);
        state_put(&m.model, spoilt, start_q, start_p);
        expect_same_bytes(spoilt, state);

        // the motion does not depend on it, byte for byte
        for (int k = 0; k < 200; k++) {
          spoil_scratch(spoilt);
          const thrum_status expected = thrum_step(&m.model, state, NULL);
          assert_int_equal(thrum_step(&m.model, spoilt, NULL), expected);
          if (memcmp(spoilt, state, thrum_state_kept_bytes(state)) != 0)
            fail_msg("%s, damping form %d, step %d", thrum_integrator_name(every_integrator[i]),
                     form, k);
        }

        // neither do the answers of the calls that read
        double p[2][RANK] = {{0}};
        thrum_energies energies[2] = {{0}};

        spoil_scratch(spoilt);
        thrum_status expected = thrum_state_get(&m.model, state, NULL, p[0], NULL);
        assert_int_equal(thrum_state_get(&m.model, spoilt, NULL, p[1], NULL), expected);
        assert_memory_equal(p[0], p[1], sizeof p[0]);

        spoil_scratch(spoilt);
        expected = thrum_state_energies(&m.model, state, &energies[0], NULL);
        assert_int_equal(thrum_state_energies(&m.model, spoilt, &energies[1], NULL), expected);
        assert_memory_equal(&energies[0], &energies[1], sizeof energies[0]);
        spoil_scratch(spoilt);

        expected = thrum_state_set_dt(&m.model, state, 2 * def.dt, NULL);
        assert_int_equal(thrum_state_set_dt(&m.model, spoilt, 2 * def.dt, NULL), expected);
        expect_same_bytes(spoilt, state);

        state_free(state);
        state_free(spoilt);
      }
  random_model_free(&m);
}

static void calls_refuse_null_strangers_and_models_of_another_rank(void **context) {
  (void)context;
  random_model m, other;
  make_model(&m);
  random_model_make(&other, 2, RANK - 1, 1.0, 9.0, 0.5);
  const thrum_state_def def = imexv_def();
  thrum_state *state = state_make(&m.model, &def);
  void *stranger = calloc(1, thrum_state_bytes(state)), *kept = state_snapshot(state);

  // memory of zeros is no state, and a model of another rank is not its model
  const struct {
    const thrum_model *model;
    thrum_state *state;
    thrum_status expected;
  } cases[] = {{&other.model, state, THRUM_MODEL_MISMATCH},
               {NULL, state, THRUM_INVALID_ARGUMENT},
               {&m.model, NULL, THRUM_INVALID_ARGUMENT},
               {&m.model, stranger, THRUM_INVALID_ARGUMENT}};

  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    const thrum_model *model = cases[n].model;
    thrum_state *s = cases[n].state;
    double q[RANK] = {7}, p[RANK] = {7};
    thrum_energies energies = {7, 7, 7, 7};
    thrum_error error;

    // each call refuses, and writes to none of its outputs
    assert_int_equal(thrum_step(model, s, &error), cases[n].expected);
    assert_int_equal(thrum_state_set(model, s, q, p, &error), cases[n].expected);
    assert_int_equal(thrum_state_get(model, s, q, p, &error), cases[n].expected);
    assert_int_equal(thrum_state_set_force(model, s, q, &error), cases[n].expected);
    assert_int_equal(thrum_state_set_dt(model, s, 0.1, &error), cases[n].expected);
    assert_int_equal(thrum_state_energies(model, s, &energies, &error), cases[n].expected);
    assert_true(q[0] == 7 && p[0] == 7 && energies.total == 7);
  }

  // the report and the sizes of no state are zero
  assert_int_equal(thrum_state_energies(&m.model, state, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_bytes(NULL), 0);
  assert_int_equal(thrum_state_kept_bytes(NULL), 0);
  assert_int_equal(thrum_state_report_get(NULL).steps, 0);

  expect_same_bytes(state, kept);

  free(stranger);
  free(kept);
  state_free(state);
  random_model_free(&m);
  random_model_free(&other);
}

/* The inverses, forces and energies of a state are those of its model: another one of its rank is
 * refused by every call, and one of the same coefficients is the same model. */
static void another_model_of_its_rank_is_refused(void **context) {
  (void)context;
  random_model m, other;
  make_model(&m);
  make_model(&other);
  m.model.identity = thrum_model_identity(&m.model);
  other.model.identity = thrum_model_identity(&other.model);
  assert_true(m.model.identity == other.model.identity && m.model.identity != 0);
  for (int i = 0; i < INTEGRATOR_COUNT; i++) {
    const thrum_state_def def = make_def(every_integrator[i], THRUM_DAMPING_REST);
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_steps(&other.model, state, 5);

    // the last bit of one coefficient makes another model
    const size_t size = thrum_state_snapshot_size(state);
    void *kept = state_snapshot(state), *sealed = malloc(size);
    assert_non_null(sealed);
    assert_int_equal(thrum_state_snapshot(state, sealed, size, NULL), THRUM_OK);
    double *coefficients[] = {other.omega2, other.c3, other.c4};
    for (int n = 0; n < 3; n++) {
      const double was = coefficients[n][RANK - 1];
      coefficients[n][RANK - 1] = nextafter(was, INFINITY);
      other.model.identity = thrum_model_identity(&other.model);
      double q[RANK] = {7}, p[RANK] = {7};
      thrum_energies energies;
      thrum_error error;
      const thrum_model *model = &other.model;
      assert_int_equal(thrum_step(model, state, &error), THRUM_MODEL_MISMATCH);
      assert_non_null(strstr(error.message, "another model"));
      assert_int_equal(thrum_state_set(model, state, q, p, NULL), THRUM_MODEL_MISMATCH);
      assert_int_equal(thrum_state_get(model, state, q, p, NULL), THRUM_MODEL_MISMATCH);
      assert_int_equal(thrum_state_set_force(model, state, q, NULL), THRUM_MODEL_MISMATCH);
      assert_int_equal(thrum_state_set_dt(model, state, 0.1, NULL), THRUM_MODEL_MISMATCH);
      assert_int_equal(thrum_state_energies(model, state, &energies, NULL), THRUM_MODEL_MISMATCH);
      assert_int_equal(thrum_state_restore(model, state, sealed, size, NULL), THRUM_MODEL_MISMATCH);
      assert_true(q[0] == 7 && p[0] == 7);

      // nor is the snapshot one of a state of that model
      thrum_state *stranger = state_make(model, &def);
      assert_int_equal(thrum_state_restore(model, stranger, sealed, size, NULL),
                       THRUM_MODEL_MISMATCH);
      state_free(stranger);
      coefficients[n][RANK - 1] = was;
    }
    other.model.identity = thrum_model_identity(&other.model);
    expect_same_bytes(state, kept);
    state_steps(&m.model, state, 1);

    free(kept);
    free(sealed);
    state_free(state);
  }
  random_model_free(&m);
  random_model_free(&other);
}

static void values_that_are_not_finite_are_refused(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  static const double bad[3] = {NAN, INFINITY, -INFINITY};
  for (int i = 0; i < INTEGRATOR_COUNT; i++) {
    const thrum_state_def def = make_def(every_integrator[i], THRUM_DAMPING_REST);

    // a state on its way, with a load
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);
    state_steps(&m.model, state, 3);
    void *kept = state_snapshot(state);

    // one bad value in the last place is found
    for (int n = 0; n < 3; n++) {
      double values[RANK] = {0};
      values[RANK - 1] = bad[n];
      assert_int_equal(thrum_state_set(&m.model, state, values, NULL, NULL), THRUM_BAD_VALUE);
      assert_int_equal(thrum_state_set(&m.model, state, NULL, values, NULL), THRUM_BAD_VALUE);
      assert_int_equal(thrum_state_set_force(&m.model, state, values, NULL), THRUM_BAD_VALUE);
      assert_int_equal(thrum_state_set_dt(&m.model, state, bad[n], NULL), THRUM_INVALID_ARGUMENT);
    }
    assert_int_equal(thrum_state_set_dt(&m.model, state, 0, NULL), THRUM_INVALID_ARGUMENT);

    // finite, but the amplitude or the forces overflow
    const double huge[RANK] = {1e200, 1e200};
    assert_int_equal(thrum_state_set(&m.model, state, huge, NULL, NULL), THRUM_NOT_FINITE);
    assert_int_equal(thrum_state_set(&m.model, state, NULL, huge, NULL), THRUM_NOT_FINITE);

    expect_same_bytes(state, kept);
    free(kept);
    state_free(state);
  }
  random_model_free(&m);
}

/* --- rest and round trips --------------------------------------------------------------------- */

static void a_body_at_rest_without_load_stays_at_rest_exactly(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  static const double zero[RANK] = {0};
  for (int i = 0; i < INTEGRATOR_COUNT; i++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      const thrum_state_def def = make_def(every_integrator[i], (thrum_damping_form)form);
      thrum_state *state = state_make(&m.model, &def);
      double q[RANK], p[RANK];

      for (int k = 0; k < 20; k++)
        assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);
      state_read(&m.model, state, q, p);
      for (int j = 0; j < RANK; j++)
        assert_true(q[j] == zero[j] && p[j] == zero[j]);

      // the steps were made, and no solve had anything to do
      const thrum_state_report report = thrum_state_report_get(state);
      assert_int_equal(report.steps, 20);
      assert_int_equal(report.iterations, 0);
      assert_true(state_energy(&m.model, state).total == 0);

      state_free(state);
    }
  random_model_free(&m);
}

static void what_is_set_is_read_back(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int i = 0; i < INTEGRATOR_COUNT; i++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      const thrum_state_def def = make_def(every_integrator[i], (thrum_damping_form)form);
      thrum_state *state = state_make(&m.model, &def);
      double q[RANK], p[RANK];

      // a state that has moved is set to another q and p
      state_push(&m.model, state, push);
      state_steps(&m.model, state, 5);
      state_put(&m.model, state, start_q, start_p);
      state_read(&m.model, state, q, p);
      assert_memory_equal(q, start_q, sizeof q);
      assert_true(largest_difference(p, start_p, RANK) < 1e-14);

      // NULL is zero, and either output may be left out
      state_put(&m.model, state, start_q, NULL);
      state_read(&m.model, state, NULL, p);
      for (int j = 0; j < RANK; j++)
        assert_true(fabs(p[j]) < 1e-14);
      state_put(&m.model, state, NULL, start_p);
      state_read(&m.model, state, q, NULL);
      for (int j = 0; j < RANK; j++)
        assert_true(q[j] == 0);

      // setting a state does not count as a step, and does not reset the count
      assert_int_equal(thrum_state_report_get(state).steps, 5);

      state_free(state);
    }
  random_model_free(&m);
}

static void reading_leaves_every_byte_as_it_was(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int i = 0; i < INTEGRATOR_COUNT; i++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      const thrum_state_def def = make_def(every_integrator[i], (thrum_damping_form)form);
      thrum_state *state = state_make(&m.model, &def);
      double q[RANK], p[RANK];

      // a loaded state after some steps
      state_put(&m.model, state, start_q, start_p);
      state_push(&m.model, state, push);
      state_steps(&m.model, state, 7);

      // every call that reads, and a time step that is the same as before
      void *kept = state_snapshot(state);
      state_read(&m.model, state, q, p);
      state_energy(&m.model, state);
      thrum_state_report_get(state);
      assert_int_equal(thrum_state_set_dt(&m.model, state, def.dt, NULL), THRUM_OK);
      expect_same_bytes(state, kept);

      free(kept);
      state_free(state);
    }
  random_model_free(&m);
}

static void energies_are_those_of_the_definition(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  for (int i = 0; i < INTEGRATOR_COUNT; i++) {
    thrum_state_def def = make_def(every_integrator[i], THRUM_DAMPING_REST);

    // omega = 1, 3.2, 5.4, ...: h omega <= 1 holds for three modes, and for all of them later
    def.split_rule = THRUM_SPLIT_CFL;
    def.dt = 0.15;

    thrum_state *state = state_make(&m.model, &def);
    double q[RANK], p[RANK];
    state_put(&m.model, state, start_q, start_p);

    for (int turn = 0; turn < 2; turn++) {
      state_steps(&m.model, state, 5);
      state_read(&m.model, state, q, p);

      // sum the kinetic energy, and the energy of the modes beyond the third, from q and p
      double kinetic = 0, high = 0;
      for (int j = 0; j < RANK; j++) {
        kinetic += 0.5 * p[j] * p[j];
        high += j < 3 ? 0 : 0.5 * (p[j] * p[j] + m.omega2[j] * q[j] * q[j]);
      }

      const thrum_energies energies = state_energy(&m.model, state);
      assert_true(fabs(energies.kinetic - kinetic) < 1e-13);
      assert_true(fabs(energies.potential - thrum_strain_energy(&m.model, q, work)) < 1e-13);
      assert_true(energies.total == energies.kinetic + energies.potential);

      // the set of the high modes is that of the start, whatever dt becomes
      assert_true(fabs(energies.high - high) < 1e-13);
      assert_int_equal(thrum_state_set_dt(&m.model, state, 0.01, NULL), THRUM_OK);
    }

    state_free(state);
  }
  free(work);
  random_model_free(&m);
}

static void a_new_dt_brings_its_own_split_and_keeps_the_motion(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV, (thrum_damping_form)form);
    def.split_rule = THRUM_SPLIT_CFL;
    def.adaptive = 0;

    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);

    // the number of modes that are explicit at each step, by h omega <= 1
    static const struct {
      double dt;
      int32_t modes;
    } cases[] = {{0.2, 2}, {0.01, 6}, {5.0, 0}, {0.1, 5}};
    for (int n = 0; n < 4; n++) {
      // neither q nor p changes with the step
      double q[2][RANK], p[2][RANK];
      state_read(&m.model, state, q[0], p[0]);
      assert_int_equal(thrum_state_set_dt(&m.model, state, cases[n].dt, NULL), THRUM_OK);
      state_read(&m.model, state, q[1], p[1]);
      assert_int_equal(thrum_state_report_get(state).explicit_modes, cases[n].modes);
      assert_memory_equal(q[0], q[1], sizeof q[0]);
      assert_true(largest_difference(p[0], p[1], RANK) < 1e-13 * (1 + cases[n].dt * 100));

      state_steps(&m.model, state, 3);
    }

    state_free(state);
  }
  random_model_free(&m);
}

/* --- snapshots and determinism ---------------------------------------------------------------- */

/* Makes `count` steps under a load that changes every step. */
static void run(const thrum_model *model, thrum_state *state, uint64_t seed, int count) {
  random_state random = {seed};
  for (int k = 0; k < count; k++) {
    double f[RANK];
    random_vector(&random, RANK, 1.0, f);
    state_push(model, state, f);
    state_steps(model, state, 1);
  }
}

static void a_restored_snapshot_steps_to_the_same_bits(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int i = 0; i < INTEGRATOR_COUNT; i++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      const thrum_state_def def = make_def(every_integrator[i], (thrum_damping_form)form);
      thrum_state *state = state_make(&m.model, &def);
      const size_t size = thrum_state_bytes(state);

      // the states in the middle and at the end of a run
      state_put(&m.model, state, start_q, start_p);
      run(&m.model, state, 1, 40);
      void *middle = state_snapshot(state);
      run(&m.model, state, 2, 60);
      void *end = state_snapshot(state);

      // restored in place
      memcpy(state, middle, size);
      run(&m.model, state, 2, 60);
      expect_same_bytes(state, end);

      // the snapshot can be stepped where it lies, as a state has no address in it
      run(&m.model, middle, 2, 60);
      expect_same_bytes(middle, end);

      free(middle);
      free(end);
      state_free(state);
    }
  random_model_free(&m);
}

static void two_states_of_one_history_have_the_same_bytes(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int i = 0; i < INTEGRATOR_COUNT; i++) {
    const thrum_state_def def = make_def(every_integrator[i], THRUM_DAMPING_REST);
    thrum_state *a = state_make(&m.model, &def), *b = state_make(&m.model, &def);
    state_put(&m.model, a, start_q, start_p);
    state_put(&m.model, b, start_q, start_p);

    random_state random = {3};
    for (int k = 0; k < 50; k++) {
      double f[RANK], q[RANK];
      random_vector(&random, RANK, 1.0, f);
      state_push(&m.model, a, f);
      state_push(&m.model, b, f);
      state_steps(&m.model, a, 1);
      state_steps(&m.model, b, 1);

      // reading one of them changes nothing
      state_read(&m.model, a, q, NULL);
      state_energy(&m.model, a);
    }

    expect_same_bytes(a, b);
    state_free(a);
    state_free(b);
  }
  random_model_free(&m);
}

static void setting_a_state_forgets_the_solvers_history(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int i = 0; i < INTEGRATOR_COUNT; i++) {
    const thrum_state_def def = make_def(every_integrator[i], THRUM_DAMPING_REST);
    thrum_state *used = state_make(&m.model, &def), *fresh = state_make(&m.model, &def);
    double q[2][RANK], p[2][RANK];

    // one state has moved before both are set to the same q and p
    run(&m.model, used, 4, 30);
    state_put(&m.model, used, start_q, start_p);
    state_put(&m.model, fresh, start_q, start_p);

    // from there on they have the same bits
    run(&m.model, used, 5, 30);
    run(&m.model, fresh, 5, 30);

    state_read(&m.model, used, q[0], p[0]);
    state_read(&m.model, fresh, q[1], p[1]);
    assert_memory_equal(q[0], q[1], sizeof q[0]);
    assert_memory_equal(p[0], p[1], sizeof p[0]);

    state_free(used);
    state_free(fresh);
  }
  random_model_free(&m);
}

/* --- failed steps and the second attempt ------------------------------------------------------ */

static void
a_failed_step_leaves_every_byte_and_the_run_goes_on_as_if_it_had_not_been(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int i = 0; i < INTEGRATOR_COUNT; i++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      const thrum_state_def def = make_def(every_integrator[i], (thrum_damping_form)form);
      thrum_state *state = state_make(&m.model, &def), *other = state_make(&m.model, &def);

      state_put(&m.model, state, start_q, start_p);
      state_put(&m.model, other, start_q, start_p);
      run(&m.model, state, 6, 30);
      run(&m.model, other, 6, 30);

      // a load that overflows the step
      double load[RANK] = {0};
      load[0] = load[RANK - 1] = 1e250;
      state_push(&m.model, state, load);
      void *kept = state_snapshot(state);

      // the step fails each time, and names its number
      for (int k = 0; k < 3; k++) {
        thrum_error error = {.status = THRUM_OK};
        assert_int_equal(thrum_step(&m.model, state, &error), THRUM_NOT_FINITE);
        assert_int_equal(error.status, THRUM_NOT_FINITE);
        assert_non_null(strstr(error.message, "step 30"));
        expect_same_bytes(state, kept);
      }

      // with other loads both go on to the same bytes
      run(&m.model, state, 7, 30);
      run(&m.model, other, 7, 30);
      expect_same_bytes(state, other);

      free(kept);
      state_free(state);
      state_free(other);
    }
  random_model_free(&m);
}

static void a_step_that_does_not_converge_leaves_every_byte(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  static const thrum_integrator implicit[3] = {THRUM_INTEGRATOR_IMEXV, THRUM_INTEGRATOR_MIDPOINT,
                                               THRUM_INTEGRATOR_NEWMARK};
  for (int i = 0; i < 3; i++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      thrum_state_def def = make_def(implicit[i], (thrum_damping_form)form);

      // one iteration, a tolerance that it cannot reach and no fallback
      def.iterations_max = 1;
      def.fallback = 0;
      def.tolerance = 1e-14;
      def.dt = 0.2;

      thrum_state *state = state_make(&m.model, &def);
      state_put(&m.model, state, start_q, start_p);
      state_push(&m.model, state, push);
      void *kept = state_snapshot(state);

      // the message says that more iterations may help, in words for programs and scenes alike
      thrum_error error = {.status = THRUM_OK};
      assert_int_equal(thrum_step(&m.model, state, &error), THRUM_NOT_CONVERGED);
      assert_non_null(strstr(error.message, "allow more iterations"));
      expect_same_bytes(state, kept);

      free(kept);
      state_free(state);
    }
  random_model_free(&m);
}

static void an_explicit_run_that_blows_up_ends_in_a_refusal_not_in_nan(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(THRUM_INTEGRATOR_VERLET, THRUM_DAMPING_REST);
  def.dt = 0.5;

  // h omega = 6 is far beyond the bound of 2
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);

  thrum_status status = THRUM_OK, before = THRUM_OK;
  for (int k = 0; k < 1000 && status >= 0; k++) {
    before = status;
    status = thrum_step(&m.model, state, NULL);
  }
  assert_int_equal(before, THRUM_ENERGY_GREW);
  assert_int_equal(status, THRUM_NOT_FINITE);

  // the last state that was reached is finite
  double q[RANK];
  state_read(&m.model, state, q, NULL);
  for (int j = 0; j < RANK; j++)
    assert_true(isfinite(q[j]));

  // set again, it steps again
  state_put(&m.model, state, NULL, NULL);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);

  state_free(state);
  random_model_free(&m);
}

/* Computes the residual of the implicit midpoint rule from q, p to q_next, p_next, without damping
 * or load. */
static double midpoint_residual(const thrum_model *model, double h, const double *q,
                                const double *p, const double *q_next, const double *p_next) {
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  double middle[RANK], force[RANK], worst = 0;

  for (int i = 0; i < RANK; i++)
    middle[i] = 0.5 * (q[i] + q_next[i]);
  thrum_internal_force(model, middle, force, work);
  free(work);
  for (int i = 0; i < RANK; i++) {
    worst = fmax(worst, fabs(q_next[i] - q[i] - 0.5 * h * (p[i] + p_next[i])));
    worst = fmax(worst, h * fabs(p_next[i] - p[i] + h * force[i]));
  }
  return worst;
}

static void full_newton_takes_the_steps_that_quasi_newton_cannot(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(THRUM_INTEGRATOR_MIDPOINT, THRUM_DAMPING_REST);
  def.damping_alpha = def.damping_beta = 0;
  def.dt = 0.4;

  // violent motion at a large step
  thrum_state *state = state_make(&m.model, &def);
  double q[2][RANK], p[2][RANK];
  for (int i = 0; i < RANK; i++)
    p[0][i] = 3.0 * (i + 1) * (i % 2 == 0 ? -1 : 1);
  state_put(&m.model, state, start_q, p[0]);

  int64_t fell_back = 0;

  for (int k = 0; k < 100; k++) {
    state_read(&m.model, state, q[0], p[0]);

    // a step that fell back was taken by full Newton
    const thrum_status status = thrum_step(&m.model, state, NULL);
    const int64_t newton = thrum_state_report_get(state).newton_steps - fell_back;
    assert_true(status >= 0 && newton >= 0 && newton <= 1);
    assert_true(status == THRUM_ENERGY_GREW || (status == THRUM_FELL_BACK) == (newton == 1));
    fell_back += newton;

    // every step solves its equations, by whichever method
    state_read(&m.model, state, q[1], p[1]);
    double size = 0;
    for (int i = 0; i < RANK; i++)
      size = fmax(size, def.dt * fabs(p[1][i]) + fabs(q[1][i]));
    assert_true(midpoint_residual(&m.model, def.dt, q[0], p[0], q[1], p[1]) < 1e-7 * size);
  }

  assert_true(fell_back > 10);

  state_free(state);
  random_model_free(&m);
}

/* --- counters --------------------------------------------------------------------------------- */

static void the_report_adds_up_and_factors_are_kept_over_steps(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 5.0);
  for (int i = 0; i < INTEGRATOR_COUNT; i++) {
    const thrum_state_def def = make_def(every_integrator[i], THRUM_DAMPING_REST);
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);

    // sums over the steps agree with the counters of the report
    int64_t iterations = 0;
    for (int k = 1; k <= 200; k++) {
      state_steps(&m.model, state, 1);
      const thrum_state_report report = thrum_state_report_get(state);
      iterations += report.iterations_last;
      assert_int_equal(report.steps, k);
      assert_int_equal(report.iterations, iterations);
      assert_true(fabs(report.time - k * def.dt) < 1e-12);
      assert_true(report.residual_last >= 0);
      const bool accounts =
          def.integrator == THRUM_INTEGRATOR_ENERGY || def.integrator == THRUM_INTEGRATOR_MANIFOLD;
      assert_true(report.residual_last < (accounts ? 1e-4 : 1e-9));
      assert_int_equal(report.explicit_modes + report.implicit_modes, RANK);
    }
    const thrum_state_report report = thrum_state_report_get(state);

    // a Jacobian is factored much less often than the 200 steps
    switch (every_integrator[i]) {
    case THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER:
      assert_int_equal(report.explicit_modes, 0);
      assert_int_equal(report.factorisations, 200);
      break;
    case THRUM_INTEGRATOR_RK4:
    case THRUM_INTEGRATOR_VERLET:
      assert_int_equal(report.explicit_modes, RANK);
      assert_int_equal(report.iterations + report.factorisations, 0);
      break;
    case THRUM_INTEGRATOR_IMEXV:
      assert_int_equal(report.explicit_modes, LOW);
      assert_true(report.factorisations > 0 && report.factorisations < 20);
      break;
    case THRUM_INTEGRATOR_NEWMARK:
    case THRUM_INTEGRATOR_FOX_GOODWIN:
    case THRUM_INTEGRATOR_BACKWARD_EULER:
    case THRUM_INTEGRATOR_MIDPOINT:
    case THRUM_INTEGRATOR_ENERGY:
    case THRUM_INTEGRATOR_MANIFOLD:
      assert_int_equal(report.explicit_modes, 0);

      // a solve that finds late that it needs its Jacobian has every other of 96 steps make one
      assert_true(report.factorisations > 0 && report.factorisations < 70);
      break;
    }

    state_free(state);
  }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_uninitialised_def_is_refused),
      cmocka_unit_test(every_field_of_a_def_is_checked_and_named),
      cmocka_unit_test(a_model_that_cannot_be_stepped_is_refused),
      cmocka_unit_test(memory_that_is_short_or_misaligned_is_refused),
      cmocka_unit_test(what_lies_behind_the_kept_bytes_does_not_count),
      cmocka_unit_test(calls_refuse_null_strangers_and_models_of_another_rank),
      cmocka_unit_test(another_model_of_its_rank_is_refused),
      cmocka_unit_test(values_that_are_not_finite_are_refused),

      // what is set and read
      cmocka_unit_test(a_body_at_rest_without_load_stays_at_rest_exactly),
      cmocka_unit_test(what_is_set_is_read_back),
      cmocka_unit_test(reading_leaves_every_byte_as_it_was),
      cmocka_unit_test(energies_are_those_of_the_definition),
      cmocka_unit_test(a_new_dt_brings_its_own_split_and_keeps_the_motion),

      // copies and snapshots
      cmocka_unit_test(a_restored_snapshot_steps_to_the_same_bits),
      cmocka_unit_test(two_states_of_one_history_have_the_same_bytes),
      cmocka_unit_test(setting_a_state_forgets_the_solvers_history),

      // steps that fail
      cmocka_unit_test(a_failed_step_leaves_every_byte_and_the_run_goes_on_as_if_it_had_not_been),
      cmocka_unit_test(a_step_that_does_not_converge_leaves_every_byte),
      cmocka_unit_test(an_explicit_run_that_blows_up_ends_in_a_refusal_not_in_nan),
      cmocka_unit_test(full_newton_takes_the_steps_that_quasi_newton_cannot),
      cmocka_unit_test(the_report_adds_up_and_factors_are_kept_over_steps),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
