/* Tests of gradients of runs: against differences of runs, by the theorem that the pass forward and
 * the one backward are transposes of one another, and what is refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"

#include "thrum/gradient.h"
#include "thrum/step_equation.h"

enum { RANK = 5, STEPS = 40, POINTS = (STEPS + 1) * RANK, FORCES = STEPS * RANK };

/* All that a run depends on. */
typedef struct inputs {
  double q[RANK], p[RANK], force[FORCES];
  double alpha, beta, stiffness, density;
} inputs;

typedef struct run {
  thrum_integrator integrator;
  double h, newmark_beta, newmark_gamma;
  bool damped, matched;
  random_model body;
  inputs at, along;
  double q_bar[POINTS], p_bar[POINTS]; /* the loss is their product with the run */
} run;

static void run_make(run *r, uint64_t seed, double amplitude) {
  random_model_make(&r->body, seed, RANK, 20, 200, 1);
  random_state random = {seed + 1};
  random_vector(&random, RANK, amplitude, r->at.q);
  random_vector(&random, RANK, 20 * amplitude, r->at.p);
  random_vector(&random, FORCES, 400 * amplitude, r->at.force);
  r->at.alpha = r->damped ? 1.5 : 0;
  r->at.beta = r->damped ? 2e-4 : 0;
  r->at.stiffness = r->at.density = 1;

  random_vector(&random, RANK, amplitude, r->along.q);
  random_vector(&random, RANK, 20 * amplitude, r->along.p);
  random_vector(&random, FORCES, 400 * amplitude, r->along.force);
  r->along.alpha = r->damped ? 1 : 0;
  r->along.beta = r->damped ? 1e-4 : 0;
  r->along.stiffness = 0.8;
  r->along.density = -0.7;
  random_vector(&random, POINTS, 1, r->q_bar);
  random_vector(&random, POINTS, 0.02, r->p_bar);
}

static thrum_state_def def_of(const run *r, const inputs *at) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = r->integrator;
  def.dt = r->h;
  def.tolerance = 1e-14;
  def.frequency_matched = r->matched;
  def.newmark_beta = r->newmark_beta;
  def.newmark_gamma = r->newmark_gamma;
  def.damping_alpha = at->alpha;
  def.damping_beta = at->beta;
  return def;
}

/* The body with other moduli and another density, in coordinates that stay. */
static void body_of(const run *r, const inputs *at, random_model *body) {
  random_model_make(body, 1, RANK, 20, 200, 1);
  const double by = at->stiffness / at->density;
  for (int i = 0; i < RANK; i++)
    body->omega2[i] = by * r->body.omega2[i];
  for (int64_t c = 0; c < body->model.c3_count; c++)
    body->c3[c] = by * r->body.c3[c];
  for (int64_t c = 0; c < body->model.c4_count; c++)
    body->c4[c] = by * r->body.c4[c];
}

/* Makes the run on a tape of its own. */
static thrum_tape *record(const run *r, const inputs *at, const thrum_model *model,
                          thrum_state **state) {
  thrum_error error;
  thrum_tape *tape = NULL;
  const thrum_state_def def = def_of(r, at);
  *state = state_make(model, &def);
  if (thrum_tape_create(model, STEPS, &tape, &error) != THRUM_OK ||
      thrum_tape_start(model, tape, *state, at->q, at->p, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  for (int k = 0; k < STEPS; k++) {
    double force[RANK];
    for (int i = 0; i < RANK; i++)
      force[i] = at->force[k * RANK + i] / at->density;
    if (thrum_tape_step(model, tape, *state, force, &error) < 0)
      fail_msg("%s", error.message);
  }
  return tape;
}

static double dot(const double *a, const double *b, int64_t n) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

/* The loss of the run with all inputs moved by `by` along the direction. */
static double loss_at(const run *r, double by) {
  inputs at = r->at;
  for (int i = 0; i < RANK; i++) {
    at.q[i] += by * r->along.q[i];
    at.p[i] += by * r->along.p[i];
  }
  for (int i = 0; i < FORCES; i++)
    at.force[i] += by * r->along.force[i];
  at.alpha += by * r->along.alpha;
  at.beta += by * r->along.beta;
  at.stiffness += by * r->along.stiffness;
  at.density += by * r->along.density;

  random_model body;
  thrum_state *state;
  body_of(r, &at, &body);
  thrum_tape *tape = record(r, &at, &body.model, &state);
  const double loss =
      dot(r->q_bar, thrum_tape_q(tape), POINTS) + dot(r->p_bar, thrum_tape_p(tape), POINTS);
  thrum_tape_destroy(tape);
  state_free(state);
  random_model_free(&body);
  return loss;
}

/* The derivative along the direction by central differences of order 8. */
static double by_differences(const run *r, double by) {
  static const double weights[] = {4. / 5, -1. / 5, 4. / 105, -1. / 280};
  double sum = 0;
  for (int n = 1; n <= 4; n++)
    sum += weights[n - 1] * (loss_at(r, n * by) - loss_at(r, -n * by));
  return sum / by;
}

/* The same by the gradient and by the change of the run. */
static void by_passes(const run *r, double *backward, double *forward) {
  thrum_state *state;
  thrum_error error;
  thrum_tape *tape = record(r, &r->at, &r->body.model, &state);
  double q[RANK], p[RANK], force[FORCES], damping[RANK];
  thrum_tape_gradient g = {.q = q, .p = p, .force = force, .damping = damping};
  if (thrum_tape_pull_back(&r->body.model, tape, r->q_bar, r->p_bar, &g, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  const inputs *d = &r->along;
  *backward = dot(q, d->q, RANK) + dot(p, d->p, RANK) + dot(force, d->force, FORCES) +
              g.alpha * d->alpha + g.beta * d->beta + g.stiffness * d->stiffness +
              g.density * d->density;

  // D of each mode beside: by its own derivatives, added to both
  double more[RANK];
  inputs copy = *d;
  for (int i = 0; i < RANK; i++)
    more[i] = r->damped ? 0.1 * i : 0;
  thrum_tape_gradient along = {.q = copy.q,
                               .p = copy.p,
                               .force = copy.force,
                               .damping = more,
                               .alpha = d->alpha,
                               .beta = d->beta,
                               .stiffness = d->stiffness,
                               .density = d->density};
  double *q_change = random_alloc(POINTS, sizeof(double)),
         *p_change = random_alloc(POINTS, sizeof(double));
  if (thrum_tape_push_forward(&r->body.model, tape, &along, q_change, p_change, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  *forward =
      dot(q_change, r->q_bar, POINTS) + dot(p_change, r->p_bar, POINTS) - dot(damping, more, RANK);
  free(q_change);
  free(p_change);
  thrum_tape_destroy(tape);
  state_free(state);
}

static void a_gradient_is_that_of_the_run_and_its_transpose(void **context) {
  (void)context;
  static const run runs[] = {
      {.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.004, .damped = true, .matched = true},
      {.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.004, .damped = true, .matched = false},
      {.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.004, .damped = false, .matched = true},
      {.integrator = THRUM_INTEGRATOR_MIDPOINT, .h = 0.004, .damped = true},
      {.integrator = THRUM_INTEGRATOR_NEWMARK,
       .h = 0.004,
       .damped = true,
       .newmark_beta = 0.25,
       .newmark_gamma = 0.5},
      {.integrator = THRUM_INTEGRATOR_NEWMARK,
       .h = 0.004,
       .damped = true,
       .newmark_beta = 0.3,
       .newmark_gamma = 0.6},
      {.integrator = THRUM_INTEGRATOR_NEWMARK,
       .h = 0.002,
       .damped = true,
       .newmark_beta = 0,
       .newmark_gamma = 0.5},
      {.integrator = THRUM_INTEGRATOR_VERLET, .h = 0.002, .damped = true},
      {.integrator = THRUM_INTEGRATOR_VERLET, .h = 0.002, .damped = false},
  };
  for (size_t n = 0; n < sizeof runs / sizeof runs[0]; n++) {
    run r = runs[n];
    run_make(&r, 7 + n, 0.15);
    double backward, forward;
    by_passes(&r, &backward, &forward);
    const double differences = by_differences(&r, 2e-3);
    printf("%zu: %.15g, relative %.2e (transpose), %.2e (differences)\n", n, backward,
           forward / backward - 1, differences / backward - 1);
    random_model_free(&r.body);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_gradient_is_that_of_the_run_and_its_transpose),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
