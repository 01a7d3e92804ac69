/* Tests that each array of a state is used within its length: arrays begin at whole alignments, and
 * what lies between the end of one and the begin of the next keeps its bits through all that a step
 * may do. No sanitizer sees these places, as a state is one block of memory.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"

#include "core/state/state_layout.h"

/* Neither a whole number of lanes, nor its square, nor that of the masters. */
enum { RANK = 9, MASTERS = 5 };

/* The places behind the used lengths of the arrays of a state. */
typedef struct gaps {
  double *at[1024];
  int64_t count;
} gaps;

static void add_gap(gaps *g, double *array, int64_t used) {
  for (int64_t k = used; k % 8 != 0; k++) {
    assert_true(g->count < 1024);
    g->at[g->count++] = array + k;
  }
}

/* Vectors, and matrices of as many rows as the state has coordinates or implicit ones. */
static void find_gaps(thrum_state *state, gaps *g) {
  const thrum_state_view view = thrum_state_view_of(state);
  g->count = 0;

  // how much of each row of an array is padding; 0 where all of it is scratch
#define LENGTH_vector state->rank
#define LENGTH_past 0
#define LENGTH_pairs 0
#define LENGTH_inverses 0
#define LENGTH_work 0
#define LENGTH_restricted 0
#define LENGTH_next state->next_count
#define LENGTH_tangent state->tangent_count
#define LENGTH_plastic 0
#define LENGTH_levels 0
#define LENGTH_ahead state->ahead_count
#define X(name, size) add_gap(g, view.name, LENGTH_##size);
  THRUM_STATE_ARRAYS(X)
  THRUM_STATE_SCRATCH(X)
#undef X
}

static void expect_gaps_kept(const thrum_model *model, const thrum_state_def *def) {
  static const double mark = -7.25e77;
  thrum_state *state = state_make(model, def);
  random_state random = {61};
  double p[RANK], load[RANK];
  random_vector(&random, model->rank, 3, p);
  random_vector(&random, model->rank, 8, load);
  state_put(model, state, NULL, p);
  gaps g;
  find_gaps(state, &g);
  for (int64_t n = 0; n < g.count; n++)
    *g.at[n] = mark;

  // loads, readings and another time step come on the way
  for (int k = 0; k < 60; k++) {
    if (k == 20)
      state_push(model, state, load);
    if (k == 40)
      assert_true(thrum_state_set_dt(model, state, 0.7 * def->dt, NULL) >= 0);
    assert_true(thrum_step(model, state, NULL) >= 0);
    state_energy(model, state);
  }
  for (int64_t n = 0; n < g.count; n++)
    if (*g.at[n] != mark)
      fail_msg("%s: gap %d of %d", thrum_integrator_name(def->integrator), (int)n, (int)g.count);
  state_free(state);
}

static void no_step_writes_behind_an_array_of_its_state(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 62, RANK, 3, 150, 1);
  const thrum_model *condensed = NULL;
  void *memory = condense(&m.model, MASTERS, &condensed);

  // every integrator without damping and with either form, and either solver
  for (int n = 0; n < 4 * INTEGRATOR_COUNT; n++) {
    thrum_state_def def = thrum_default_state_def();
    def.integrator = every_integrator[n / 4];
    const bool is_explicit =
        def.integrator == THRUM_INTEGRATOR_VERLET || def.integrator == THRUM_INTEGRATOR_RK4;
    def.dt = is_explicit ? 0.0005 : 0.01;
    def.damping_alpha = n % 4 > 0 ? 0.1 : 0;
    def.damping_beta = n % 4 > 0 ? 1e-4 : 0;
    def.damping_form = n % 4 > 1 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;
    def.solver = n % 4 > 2 ? THRUM_SOLVER_NEWTON : THRUM_SOLVER_QUASI_NEWTON;
    expect_gaps_kept(def.integrator == THRUM_INTEGRATOR_MANIFOLD ? condensed : &m.model, &def);
  }
  free(memory);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_step_writes_behind_an_array_of_its_state),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
