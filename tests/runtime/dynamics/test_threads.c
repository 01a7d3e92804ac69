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
    thrum_state_def def = thrum_default_state_def();
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

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_that_share_a_model_step_to_the_bits_of_a_run_alone),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
