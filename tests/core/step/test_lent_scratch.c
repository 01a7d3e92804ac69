/* States that borrow their scratch: many share one, with the bits of states that own theirs.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "thrum/batch.h"

enum { RANK = 9, LOW = 3, STEPS = 60 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};

static thrum_state_def make_def(int integrator, int form, int32_t borrows) {
  thrum_state_def def = imexv_def();
  def.integrator = every_integrator[integrator];
  def.dt = 0.03;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = LOW;
  def.damping_form = form == 0 ? THRUM_DAMPING_REST : THRUM_DAMPING_TANGENT;
  def.damping_alpha = 0.1;
  def.damping_beta = 0.002;
  def.borrows_scratch = borrows;
  return def;
}

/* Scratch that is large enough for every state here. */
static void *make_scratch(const thrum_model *model, size_t *size) {
  *size = 0;
  for (int i = 0; i < INTEGRATOR_COUNT; i++)
    for (int form = 0; form < 2; form++) {
      const thrum_state_def def = make_def(i, form, 1);
      size_t needed = 0;
      assert_int_equal(thrum_state_scratch_size(model, &def, &needed, NULL), THRUM_OK);
      *size = needed > *size ? needed : *size;
    }
  void *scratch = aligned_alloc(64, *size);
  assert_non_null(scratch);
  return memset(scratch, 0xff, *size);
}

/* All that persists is equal but for the def, which says whose the scratch is, and for the
 * size. */
static void expect_same_motion(const thrum_model *model, thrum_state *a, thrum_state *b) {
  double q[2][RANK], p[2][RANK];
  state_read(model, a, q[0], p[0]);
  state_read(model, b, q[1], p[1]);
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(p[0], p[1], sizeof p[0]);
  const thrum_state_report of_a = thrum_state_report_get(a), of_b = thrum_state_report_get(b);
  assert_memory_equal(&of_a, &of_b, sizeof of_a);
  const thrum_energies energy = state_energy(model, a);
  assert_true(energy.total == state_energy(model, b).total);
}

static void states_that_share_scratch_step_to_the_bits_of_their_own(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 40.0, 0.5);
  size_t size;
  void *scratch = make_scratch(&m.model, &size);

  // every integrator with each damping, twice, step by step in turns
  enum { COUNT = 2 * INTEGRATOR_COUNT };
  thrum_state *lean[COUNT], *own[COUNT];
  for (int n = 0; n < COUNT; n++) {
    const thrum_state_def borrows = make_def(n / 2, n % 2, 1), owns = make_def(n / 2, n % 2, 0);
    lean[n] = state_make(&m.model, &borrows);
    own[n] = state_make(&m.model, &owns);
    assert_true(thrum_state_bytes(lean[n]) == thrum_state_kept_bytes(lean[n]) + 64);
    assert_true(thrum_state_bytes(lean[n]) < thrum_state_bytes(own[n]));
    assert_int_equal(thrum_state_lend(lean[n], scratch, size, NULL), THRUM_OK);
    state_put(&m.model, lean[n], start_q, start_p);
    state_put(&m.model, own[n], start_q, start_p);
  }

  random_state random = {5};
  for (int k = 0; k < STEPS; k++) {
    double f[RANK];
    random_vector(&random, RANK, 3.0, f);
    const double dt = 0.02 + 0.001 * (k % 7);
    for (int n = 0; n < COUNT; n++) {
      state_push(&m.model, lean[n], f);
      state_push(&m.model, own[n], f);
      if (k % 5 == 4) {
        assert_int_equal(thrum_state_set_dt(&m.model, lean[n], dt, NULL), THRUM_OK);
        assert_int_equal(thrum_state_set_dt(&m.model, own[n], dt, NULL), THRUM_OK);
      }
      assert_int_equal(thrum_step(&m.model, lean[n], NULL), thrum_step(&m.model, own[n], NULL));
      memset(scratch, 0xff, size);
    }
  }
  for (int n = 0; n < COUNT; n++) {
    expect_same_motion(&m.model, lean[n], own[n]);
    state_free(lean[n]);
    state_free(own[n]);
  }
  free(scratch);
  random_model_free(&m);
}

static void a_batch_lends_its_own_workspace(void **context) {
  (void)context;
  enum { COUNT = 21 };
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 40.0, 0.5);
  random_model_pack(&m);
  size_t size, scratch_size;
  assert_int_equal(thrum_batch_size(&m.model, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, size), *scratch = make_scratch(&m.model, &scratch_size);
  assert_non_null(workspace);

  // groups of imexv, energy and newmark, and single states of all others
  thrum_state *lean[COUNT], *own[COUNT];
  for (int n = 0; n < COUNT; n++) {
    const int integrator = n % 7 == 6 ? n / 7 : n / 7 == 0 ? 0 : n / 7 == 1 ? 4 : 3;
    const thrum_state_def borrows = make_def(integrator, n == 12, 1);
    const thrum_state_def owns = make_def(integrator, n == 12, 0);
    double p[RANK];
    random_state random = {(uint64_t)n + 1};
    random_vector(&random, RANK, 1.0, p);
    lean[n] = state_make(&m.model, &borrows);
    own[n] = state_make(&m.model, &owns);
    state_put(&m.model, own[n], start_q, p);

    // to set p takes scratch, which is taken back
    assert_int_equal(thrum_state_lend(lean[n], scratch, scratch_size, NULL), THRUM_OK);
    state_put(&m.model, lean[n], start_q, p);
    assert_int_equal(thrum_state_lend(lean[n], NULL, 0, NULL), THRUM_OK);
  }

  for (int k = 0; k < STEPS; k++) {
    assert_true(thrum_batch_step(&m.model, lean, COUNT, NULL, workspace, size, NULL) >= 0);
    for (int n = 0; n < COUNT; n++)
      state_steps(&m.model, own[n], 1);
  }
  for (int n = 0; n < COUNT; n++) {
    assert_int_equal(thrum_state_lend(lean[n], scratch, scratch_size, NULL), THRUM_OK);
    expect_same_motion(&m.model, lean[n], own[n]);
    state_free(lean[n]);
    state_free(own[n]);
  }
  free(scratch);
  free(workspace);
  random_model_free(&m);
}

static void a_state_without_scratch_refuses_what_needs_it(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 40.0, 0.5);
  const thrum_state_def def = make_def(0, 0, 1), owns = make_def(0, 0, 0);
  thrum_state *state = state_make(&m.model, &def), *own = state_make(&m.model, &owns);
  void *kept = state_snapshot(state);
  double q[RANK] = {7}, p[RANK] = {7};
  thrum_energies energies = {7, 7, 7, 7};
  thrum_error error;
  assert_int_equal(thrum_step(&m.model, state, &error), THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "thrum_state_lend"));
  assert_int_equal(thrum_state_set(&m.model, state, q, p, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_get(&m.model, state, q, p, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_set_dt(&m.model, state, 0.1, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_energies(&m.model, state, &energies, NULL), THRUM_INVALID_ARGUMENT);
  assert_true(q[0] == 7 && p[0] == 7 && energies.total == 7);
  assert_memory_equal(state, kept, thrum_state_bytes(state));

  // a load, snapshots and reports take none
  state_push(&m.model, state, start_p);
  assert_int_equal(thrum_state_report_get(state).steps, 0);
  const size_t sealed_size = thrum_state_snapshot_size(state);
  void *sealed = malloc(sealed_size);
  assert_non_null(sealed);
  assert_int_equal(thrum_state_snapshot(state, sealed, sealed_size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_restore(&m.model, state, sealed, sealed_size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_restore(&m.model, own, sealed, sealed_size, NULL),
                   THRUM_MODEL_MISMATCH);

  // scratch that does not fit, and states that are lent none
  size_t size = 0;
  assert_int_equal(thrum_state_scratch_size(&m.model, &def, &size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_scratch_size(&m.model, &def, NULL, NULL), THRUM_INVALID_ARGUMENT);
  unsigned char *scratch = aligned_alloc(64, size + 64);
  assert_non_null(scratch);
  assert_int_equal(thrum_state_lend(state, scratch, size - 1, NULL), THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_state_lend(state, scratch + 8, size, NULL), THRUM_MISALIGNED);
  assert_int_equal(thrum_state_lend(own, scratch, size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_lend(NULL, scratch, size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_INVALID_ARGUMENT);

  // with it the state steps, until it is taken back; a restored snapshot keeps it
  assert_int_equal(thrum_state_lend(state, scratch, size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_restore(&m.model, state, sealed, sealed_size, NULL), THRUM_OK);
  state_steps(&m.model, state, 3);
  assert_int_equal(thrum_state_lend(state, NULL, 0, NULL), THRUM_OK);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_INVALID_ARGUMENT);

  free(sealed);
  free(kept);
  free(scratch);
  state_free(state);
  state_free(own);
  random_model_free(&m);
}

/* Two states may keep as many bytes and write scratch of different sizes. */
static void a_snapshot_of_a_state_with_other_scratch_is_refused(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, 16, 1.0, 40.0, 0.5);
  thrum_state_def newmark = thrum_default_state_def(), imexv = imexv_def();
  newmark.integrator = THRUM_INTEGRATOR_NEWMARK;
  newmark.borrows_scratch = imexv.borrows_scratch = 1;

  // as many bytes in a snapshot, but imexv restricts the polynomial in its scratch
  thrum_state *to = state_make(&m.model, &newmark), *from = state_make(&m.model, &imexv);
  assert_int_equal(thrum_state_snapshot_size(to), thrum_state_snapshot_size(from));

  // the state that has less of it does not take the other's snapshot
  const size_t size = thrum_state_snapshot_size(from);
  unsigned char *sealed = malloc(size);
  assert_non_null(sealed);
  assert_int_equal(thrum_state_snapshot(from, sealed, size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_restore(&m.model, to, sealed, size, NULL), THRUM_MODEL_MISMATCH);

  free(sealed);
  state_free(to);
  state_free(from);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(states_that_share_scratch_step_to_the_bits_of_their_own),
      cmocka_unit_test(a_batch_lends_its_own_workspace),
      cmocka_unit_test(a_state_without_scratch_refuses_what_needs_it),
      cmocka_unit_test(a_snapshot_of_a_state_with_other_scratch_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
