/* Many threads share one model: each steps states of its own and gets the bits of a run alone.
 * Under a thread sanitizer this also shows that no call writes to the model or to a global.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include <pthread.h>
#include <stdbool.h>

enum { RANK = 8, LOW = 3, THREADS = 4, STEPS = 300, INTEGRATORS = 5 };

typedef struct worker {
  const thrum_model *model; /* shared */
  uint64_t seed;
  thrum_state *states[INTEGRATORS]; /* its own */
  bool stepped;
} worker;

static bool step_all(const worker *w) {
  double f[RANK], q[RANK], p[RANK];
  thrum_energies energies;

  // the seed gives the loads, so a run alone can have the same ones
  random_state random = {w->seed};
  for (int k = 0; k < STEPS; k++) {
    random_vector(&random, RANK, 0.5, f);
    for (int n = 0; n < INTEGRATORS; n++) {
      thrum_state *state = w->states[n];
      if (thrum_state_set_force(w->model, state, f, NULL) != THRUM_OK ||
          thrum_step(w->model, state, NULL) < 0 ||
          thrum_state_get(w->model, state, q, p, NULL) != THRUM_OK ||
          thrum_state_energies(w->model, state, &energies, NULL) != THRUM_OK)
        return false;
    }
  }
  return true;
}

static void *run(void *context) {
  worker *w = context;
  w->stepped = step_all(w);
  return NULL;
}

static worker make_worker(const thrum_model *model, int number) {
  worker w = {.model = model, .seed = 100 + (uint64_t)number};
  for (int n = 0; n < INTEGRATORS; n++) {
    thrum_state_def def = imexv_def();
    def.integrator = (thrum_integrator)n;
    def.dt = 0.02 + 0.005 * number;
    def.split_rule = THRUM_SPLIT_COUNT;
    def.explicit_count = LOW;
    def.damping_alpha = 0.1;
    def.damping_beta = 0.002;
    def.damping_form = number % 2 == 0 ? THRUM_DAMPING_REST : THRUM_DAMPING_TANGENT;
    w.states[n] = state_make(model, &def);
  }
  return w;
}

static void threads_that_share_a_model_step_to_the_bits_of_a_run_alone(void **context) {
  (void)context;
  random_model m;
  worker together[THREADS], alone;
  pthread_t threads[THREADS];
  random_model_make(&m, 31, RANK, 1.0, 20.0, 0.5);

  // each thread has states of its own, all of one model
  for (int t = 0; t < THREADS; t++)
    together[t] = make_worker(&m.model, t);
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_create(&threads[t], NULL, run, &together[t]), 0);
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_join(threads[t], NULL), 0);

  // the same states stepped alone have the same bytes
  for (int t = 0; t < THREADS; t++) {
    alone = make_worker(&m.model, t);
    assert_true(step_all(&alone) && together[t].stepped);
    for (int n = 0; n < INTEGRATORS; n++) {
      assert_int_equal(thrum_state_report_get(alone.states[n]).steps, STEPS);
      assert_memory_equal(together[t].states[n], alone.states[n],
                          thrum_state_kept_bytes(alone.states[n]));

      state_free(together[t].states[n]);
      state_free(alone.states[n]);
    }
  }
  random_model_free(&m);
}

/* Scratch of a thread, and the states that are its turn. */
typedef struct shift {
  const thrum_model *model;
  thrum_state **states;
  void *scratch;
  size_t size;
  int first;
  bool stepped;
} shift;

/* Steps every other state with the scratch of this thread. */
static void *run_shift(void *context) {
  shift *s = context;
  s->stepped = true;
  for (int n = s->first; n < 2 * THREADS; n += 2) {
    s->stepped =
        s->stepped && thrum_state_lend(s->states[n], s->scratch, s->size, NULL) == THRUM_OK;
    for (int k = 0; k < 20; k++)
      s->stepped = s->stepped && thrum_step(s->model, s->states[n], NULL) >= 0;
  }
  return NULL;
}

/* States that borrow scratch are stepped by the one thread and then by the other, each with its
 * own. */
static void threads_lend_their_scratch_to_the_states_that_they_step(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 31, RANK, 1.0, 20.0, 0.5);
  thrum_state *states[2 * THREADS], *alone[2 * THREADS];
  thrum_state_def def = imexv_def();
  def.dt = 0.02;
  size_t size;
  assert_int_equal(thrum_state_scratch_size(&m.model, &def, &size, NULL), THRUM_OK);
  shift shifts[2];
  for (int t = 0; t < 2; t++) {
    shifts[t] = (shift){.model = &m.model, .states = states, .size = size};
    shifts[t].scratch = aligned_alloc(64, size);
    assert_non_null(shifts[t].scratch);
  }

  // every state has a start of its own
  for (int n = 0; n < 2 * THREADS; n++) {
    random_state random = {(uint64_t)n + 1};
    double p[RANK];
    random_vector(&random, RANK, 1.0, p);
    def.borrows_scratch = 0;
    alone[n] = state_make(&m.model, &def);
    def.borrows_scratch = 1;
    states[n] = state_make(&m.model, &def);
    assert_int_equal(thrum_state_lend(states[n], shifts[0].scratch, size, NULL), THRUM_OK);
    state_put(&m.model, states[n], NULL, p);
    state_put(&m.model, alone[n], NULL, p);
    state_steps(&m.model, alone[n], 20 * 4);
  }

  for (int round = 0; round < 4; round++) {
    pthread_t threads[2];
    for (int t = 0; t < 2; t++) {
      shifts[t].first = (t + round) % 2;
      assert_int_equal(pthread_create(&threads[t], NULL, run_shift, &shifts[t]), 0);
    }
    for (int t = 0; t < 2; t++) {
      assert_int_equal(pthread_join(threads[t], NULL), 0);
      assert_true(shifts[t].stepped);
    }
  }

  for (int n = 0; n < 2 * THREADS; n++) {
    double q[2][RANK];
    state_read(&m.model, states[n], q[0], NULL);
    state_read(&m.model, alone[n], q[1], NULL);
    assert_memory_equal(q[0], q[1], sizeof q[0]);
    state_free(states[n]);
    state_free(alone[n]);
  }
  for (int t = 0; t < 2; t++)
    free(shifts[t].scratch);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_that_share_a_model_step_to_the_bits_of_a_run_alone),
      cmocka_unit_test(threads_lend_their_scratch_to_the_states_that_they_step),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
