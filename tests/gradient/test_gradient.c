/* Tests of gradients of runs: against differences of runs, by the theorem that the pass forward and
 * the one backward are transposes of one another, and what is refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"

#include "thrum/actuation.h"
#include "thrum/batch.h"
#include "thrum/gradient.h"
#include "thrum/step_equation.h"

enum { RANK = 5, STEPS = 40, POINTS = (STEPS + 1) * RANK, FORCES = STEPS * RANK };
enum { ACTUATORS = 4, LEVELS = STEPS * ACTUATORS, GUIDES = 3 };

/* What acts on a random body: one of each kind. */
typedef struct actors {
  int32_t kind[ACTUATORS], ends[ACTUATORS];
  double rest[3 * ACTUATORS], linear[ACTUATORS * RANK], quadratic[ACTUATORS * RANK * RANK];
  double cubic[2 * RANK * RANK * (RANK + 1) / 2];
  double places[3 * GUIDES], rows[3 * GUIDES * RANK];
} actors;

/* The rows of a random cubic form of a chamber: what q_i q_j adds to its gradient. */
static void put_cubic(random_state *random, double *rows) {
  double form[RANK][RANK][RANK];
  for (int i = 0; i < RANK; i++)
    for (int j = i; j < RANK; j++)
      for (int k = j; k < RANK; k++)
        form[i][j][k] = 3 * random_uniform(random);
  for (int i = 0; i < RANK; i++)
    for (int j = i; j < RANK; j++)
      for (int k = 0; k < RANK; k++) {
        int64_t at[3] = {i, j, k};
        random_sort(at, 3);
        *rows++ = (i == j ? 1 : 2) * form[at[0]][at[1]][at[2]];
      }
}

/* Pressure, strain, tendon and gas on a body, with the same random numbers each time. */
static void add_actors(thrum_model *model, actors *a) {
  random_state random = {77};
  memset(a, 0, sizeof *a);
  random_vector(&random, ACTUATORS * RANK, 1, a->linear);
  for (int k = 0; k < ACTUATORS; k++) {
    a->kind[k] = k;
    a->ends[k] = k < THRUM_ACTUATOR_TENDON ? 0 : GUIDES;
    for (int i = 0; i < RANK; i++)
      for (int j = 0; j <= i; j++)
        a->quadratic[(k * RANK + i) * RANK + j] = a->quadratic[(k * RANK + j) * RANK + i] =
            random_uniform(&random);
    a->rest[3 * k] = 8;
    a->rest[3 * k + 1] = k == THRUM_ACTUATOR_GAS ? 50 : 0;
  }
  put_cubic(&random, a->cubic);
  put_cubic(&random, a->cubic + RANK * RANK * (RANK + 1) / 2);
  const double places[] = {0, 0, 0, 1, 0.2, 0, 2, 0, 0.3};
  memcpy(a->places, places, sizeof places);
  random_vector(&random, 3 * GUIDES * RANK, 0.5, a->rows);
  double length = 0;
  for (int n = 0; n < 2; n++) {
    const double *from = places + 3 * n;
    length +=
        sqrt(pow(from[3] - from[0], 2) + pow(from[4] - from[1], 2) + pow(from[5] - from[2], 2));
  }
  a->rest[3 * THRUM_ACTUATOR_TENDON] = length;

  static const char texts[] = "a=0\0b=1\0c=2\0d=3";
  model->actuator_count = ACTUATORS;
  model->actuator_bytes = sizeof texts;
  model->actuator_square = RANK * RANK;
  model->actuator_cube = RANK * RANK * (RANK + 1) / 2;
  model->chamber_count = 2;
  model->guide_count = GUIDES;
  model->actuator_texts = (const uint8_t *)texts;
  model->actuator_kind = a->kind;
  model->actuator_rest = a->rest;
  model->actuator_linear = a->linear;
  model->actuator_quadratic = a->quadratic;
  model->actuator_cubic = a->cubic;
  model->guide_ends = a->ends;
  model->guide_places = a->places;
  model->guide_rows = a->rows;
}

/* A tape for so many steps. */
static thrum_status create(const thrum_model *model, int64_t steps, thrum_tape **tape,
                           thrum_error *error) {
  thrum_tape_def def = thrum_default_tape_def();
  def.steps = steps;
  return thrum_tape_create(model, &def, tape, error);
}

/* All that a run depends on. */
typedef struct inputs {
  double q[RANK], p[RANK], force[FORCES];
  double alpha, beta, stiffness, density;
  double damping[RANK]; /* of single modes */
  double part;          /* share of a part of the energy */
  double levels[LEVELS];
} inputs;

typedef struct run {
  thrum_integrator integrator;
  double h, newmark_beta, newmark_gamma;
  double tolerance; /* 0: 1e-14 */
  bool damped, matched;
  random_model body, other;   /* other: cubic and quartic form of the part, */
  double linear[RANK * RANK]; /* and its stiffness */
  bool parted;                /* the share changes */
  bool acts;                  /* the body has actuators */
  actors actors;
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
  for (int i = 0; i < RANK; i++) {
    r->at.damping[i] = r->damped ? 0.3 * (i + 1) : 0;
    r->along.damping[i] = r->damped && !r->parted ? 0.2 * (RANK - i) : 0;
  }
  r->body.model.damping = r->at.damping;
  random_model_make(&r->other, seed + 5, RANK, 10, 100, 1);
  for (int i = 0; i < RANK; i++)
    for (int j = 0; j <= i; j++)
      r->linear[i * RANK + j] = r->linear[j * RANK + i] = 3000 * random_uniform(&random);
  r->along.part = r->parted ? 0.5 : 0;
  r->along.alpha = r->damped ? 1 : 0;
  r->along.beta = r->damped ? 1e-4 : 0;
  r->along.stiffness = 0.8;
  r->along.density = -0.7;
  random_vector(&random, POINTS, 1, r->q_bar);
  random_vector(&random, POINTS, 0.02, r->p_bar);
  if (!r->acts)
    return;
  add_actors(&r->body.model, &r->actors);
  random_vector(&random, LEVELS, 40, r->at.levels);
  random_vector(&random, LEVELS, 40, r->along.levels);
}

static thrum_state_def def_of(const run *r, const inputs *at) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = r->integrator;
  def.dt = r->h;
  def.tolerance = r->tolerance > 0 ? r->tolerance : 1e-14;
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

/* Diagonalises a symmetric matrix by Jacobi's rotations; columns of `turn` are its vectors. */
static void diagonalise(double *k, double *turn) {
  for (int i = 0; i < RANK * RANK; i++)
    turn[i] = i % (RANK + 1) == 0 ? 1 : 0;
  for (int sweep = 0; sweep < 30; sweep++)
    for (int a = 0; a < RANK; a++)
      for (int b = a + 1; b < RANK; b++) {
        const double angle = 0.5 * atan2(2 * k[a * RANK + b], k[b * RANK + b] - k[a * RANK + a]);
        const double c = cos(angle), s = sin(angle);
        if (k[a * RANK + b] == 0)
          continue;
        for (int i = 0; i < RANK; i++) {
          const double x = k[i * RANK + a], y = k[i * RANK + b];
          k[i * RANK + a] = c * x - s * y;
          k[i * RANK + b] = s * x + c * y;
        }
        for (int i = 0; i < RANK; i++) {
          const double x = k[a * RANK + i], y = k[b * RANK + i];
          k[a * RANK + i] = c * x - s * y;
          k[b * RANK + i] = s * x + c * y;
          const double u = turn[i * RANK + a], v = turn[i * RANK + b];
          turn[i * RANK + a] = c * u - s * v;
          turn[i * RANK + b] = s * u + c * v;
        }
      }
}

/* A form of the fourth degree, or of the third with the last index 0, in turned coordinates. */
static void turn_form(const double *from, const double *turn, int degree, double *to) {
  enum { ALL = RANK * RANK * RANK * RANK };
  static double full[ALL], next[ALL];
  const int size = degree == 4 ? ALL : ALL / RANK;
  memset(full, 0, sizeof full);
  for (int n = 0; n < size; n++) {
    int64_t at[4] = {n % RANK, n / RANK % RANK, n / RANK / RANK % RANK, n / RANK / RANK / RANK};
    random_sort(at, degree);
    const bool ordered = at[0] == n % RANK && at[1] == n / RANK % RANK &&
                         at[2] == n / RANK / RANK % RANK &&
                         (degree == 3 || at[3] == n / RANK / RANK / RANK);
    if (ordered)
      full[n] = degree == 4 ? from[thrum_c4_index(RANK, at[0], at[1], at[2], at[3])]
                            : from[thrum_c3_index(RANK, at[0], at[1], at[2])];
  }

  // each index in turn
  for (int d = 0, stride = 1; d < degree; d++, stride *= RANK) {
    memset(next, 0, sizeof next);
    for (int n = 0; n < size; n++)
      for (int j = 0; j < RANK; j++) {
        const int i = n / stride % RANK;
        next[n + (j - i) * stride] += turn[i * RANK + j] * full[n];
      }
    memcpy(full, next, sizeof full);
  }
  for (int n = 0; n < size; n++) {
    int64_t at[4] = {n % RANK, n / RANK % RANK, n / RANK / RANK % RANK, n / RANK / RANK / RANK};
    random_sort(at, degree);
    to[degree == 4 ? thrum_c4_index(RANK, at[0], at[1], at[2], at[3])
                   : thrum_c3_index(RANK, at[0], at[1], at[2])] += full[n];
  }
}

/* Adds the part to the body and finds its modes anew; columns of `turn` are the new coordinates. */
static void add_part(const run *r, double share, random_model *body, double *turn) {
  double k[RANK * RANK], omega2[RANK];
  for (int i = 0; i < RANK * RANK; i++)
    k[i] = share * r->linear[i] + (i % (RANK + 1) == 0 ? body->omega2[i / RANK] : 0);
  diagonalise(k, turn);

  // in ascending order
  for (int i = 0; i < RANK; i++)
    for (int j = i + 1; j < RANK; j++)
      if (k[j * RANK + j] < k[i * RANK + i]) {
        const double kept = k[i * RANK + i];
        k[i * RANK + i] = k[j * RANK + j];
        k[j * RANK + j] = kept;
        for (int v = 0; v < RANK; v++) {
          const double entry = turn[v * RANK + i];
          turn[v * RANK + i] = turn[v * RANK + j];
          turn[v * RANK + j] = entry;
        }
      }
  for (int i = 0; i < RANK; i++)
    omega2[i] = k[i * RANK + i];
  memcpy(body->omega2, omega2, sizeof omega2);

  double *forms = random_alloc(body->model.c4_count, sizeof(double));
  for (int degree = 3; degree <= 4; degree++) {
    const int64_t count = degree == 3 ? body->model.c3_count : body->model.c4_count;
    double *to = degree == 3 ? body->c3 : body->c4;
    const double *part = degree == 3 ? r->other.c3 : r->other.c4;
    for (int64_t c = 0; c < count; c++)
      forms[c] = to[c] + share * part[c];
    memset(to, 0, (size_t)count * sizeof *to);
    turn_form(forms, turn, degree, to);
  }
  free(forms);
}

/* to = turn v or turn^T v, rows of RANK */
static void turn_rows(const double *turn, bool transposed, int64_t count, const double *from,
                      double *to) {
  for (int64_t n = 0; n < count; n++)
    for (int i = 0; i < RANK; i++) {
      double sum = 0;
      for (int j = 0; j < RANK; j++)
        sum += turn[transposed ? j * RANK + i : i * RANK + j] * from[n * RANK + j];
      to[n * RANK + i] = sum;
    }
}

/* The levels of a step in coordinates that stay: strains follow the stiffness, and all are divided
 * by the density. */
static void levels_of(const inputs *at, int step, double *levels) {
  for (int k = 0; k < ACTUATORS; k++)
    levels[k] = at->levels[step * ACTUATORS + k] *
                (k == THRUM_ACTUATOR_STRAIN ? at->stiffness : 1) / at->density;
}

/* Makes the run on a tape of its own. */
static thrum_tape *record(const run *r, const inputs *at, const thrum_model *model,
                          thrum_state **state) {
  thrum_error error;
  thrum_tape *tape = NULL;
  const thrum_state_def def = def_of(r, at);
  *state = state_make(model, &def);
  if (create(model, STEPS, &tape, &error) != THRUM_OK ||
      thrum_tape_start(model, tape, *state, at->q, at->p, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  for (int k = 0; k < STEPS; k++) {
    double force[RANK];
    for (int i = 0; i < RANK; i++)
      force[i] = at->force[k * RANK + i] / at->density;
    double levels[ACTUATORS];
    levels_of(at, k, levels);
    if (r->acts && thrum_state_set_actuation(model, *state, levels, &error) < 0)
      fail_msg("%s", error.message);
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
  for (int i = 0; i < LEVELS; i++)
    at.levels[i] += by * r->along.levels[i];
  at.alpha += by * r->along.alpha;
  at.beta += by * r->along.beta;
  at.stiffness += by * r->along.stiffness;
  at.density += by * r->along.density;
  for (int i = 0; i < RANK; i++)
    at.damping[i] += by * r->along.damping[i];

  random_model body;
  actors own;
  thrum_state *state;
  body_of(r, &at, &body);
  body.model.damping = at.damping;
  if (r->acts) {
    add_actors(&body.model, &own);
    own.rest[3 * THRUM_ACTUATOR_GAS + 1] /= at.density;
  }

  // the modes are found anew, and the run is seen in the coordinates that stay
  inputs turned = at;
  double turn[RANK * RANK];
  static double q[POINTS], p[POINTS];
  if (r->parted) {
    add_part(r, by * r->along.part, &body, turn);
    turn_rows(turn, true, 1, at.q, turned.q);
    turn_rows(turn, true, 1, at.p, turned.p);
    turn_rows(turn, true, STEPS, at.force, turned.force);
  }
  thrum_tape *tape = record(r, &turned, &body.model, &state);
  memcpy(q, thrum_tape_q(tape), sizeof q);
  memcpy(p, thrum_tape_p(tape), sizeof p);
  if (r->parted) {
    turn_rows(turn, false, STEPS + 1, thrum_tape_q(tape), q);
    turn_rows(turn, false, STEPS + 1, thrum_tape_p(tape), p);
  }
  const double loss = dot(r->q_bar, q, POINTS) + dot(r->p_bar, p, POINTS);
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
  double q[RANK], p[RANK], force[FORCES], damping[RANK], levels[LEVELS] = {0};
  double none[RANK] = {0};
  thrum_model form = r->other.model;
  form.omega2 = none;
  const thrum_energy_part part = {.linear = r->linear, .form = &form};
  double by_part = 0;
  thrum_tape_gradient g = {.q = q,
                           .p = p,
                           .force = force,
                           .levels = levels,
                           .damping = damping,
                           .parts = &part,
                           .part = &by_part,
                           .part_count = 1};
  if (thrum_tape_pull_back(&r->body.model, tape, r->q_bar, r->p_bar, &g, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  const inputs *d = &r->along;
  *backward = dot(q, d->q, RANK) + dot(p, d->p, RANK) + dot(force, d->force, FORCES) +
              g.alpha * d->alpha + g.beta * d->beta + g.stiffness * d->stiffness +
              g.density * d->density + dot(damping, d->damping, RANK) + by_part * d->part +
              dot(levels, d->levels, LEVELS);

  // D of each mode beside: by its own derivatives, added to both
  double more[RANK];
  inputs copy = *d;
  for (int i = 0; i < RANK; i++)
    more[i] = d->damping[i] + (r->damped ? 0.1 * i : 0);
  thrum_tape_gradient along = {.q = copy.q,
                               .p = copy.p,
                               .force = copy.force,
                               .levels = copy.levels,
                               .damping = more,
                               .alpha = d->alpha,
                               .beta = d->beta,
                               .stiffness = d->stiffness,
                               .density = d->density,
                               .parts = &part,
                               .part = &copy.part,
                               .part_count = 1};
  double *q_change = random_alloc(POINTS, sizeof(double)),
         *p_change = random_alloc(POINTS, sizeof(double));
  if (thrum_tape_push_forward(&r->body.model, tape, &along, q_change, p_change, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  *forward = dot(q_change, r->q_bar, POINTS) + dot(p_change, r->p_bar, POINTS) -
             dot(damping, more, RANK) + dot(damping, d->damping, RANK);
  free(q_change);
  free(p_change);
  thrum_tape_destroy(tape);
  state_free(state);
}

/* How often steps of the run took this form. */
static int steps_of(const run *r, thrum_step_form form) {
  thrum_error error;
  thrum_tape *tape = NULL;
  const thrum_model *model = &r->body.model;
  const thrum_state_def def = def_of(r, &r->at);
  thrum_state *state = state_make(model, &def);
  assert_int_equal(create(model, STEPS, &tape, &error), THRUM_OK);
  assert_int_equal(thrum_tape_start(model, tape, state, r->at.q, r->at.p, &error), THRUM_OK);
  int count = 0;
  for (int k = 0; k < STEPS; k++) {
    thrum_step_equation equation;
    if (r->acts)
      assert_int_equal(
          thrum_state_set_actuation(model, state, r->at.levels + k * ACTUATORS, &error), THRUM_OK);
    assert_true(thrum_tape_step(model, tape, state, r->at.force + k * RANK, &error) >= 0);
    assert_int_equal(thrum_step_equation_get(model, state, &equation, NULL, NULL, NULL, NULL),
                     THRUM_OK);
    count += equation.form == form ? 1 : 0;
  }
  thrum_tape_destroy(tape);
  state_free(state);
  return count;
}

static void a_gradient_is_that_of_the_run_and_its_transpose(void **context) {
  (void)context;
  static const struct {
    run r;
    double amplitude;
    thrum_step_form form; /* that some of the steps take */
  } cases[] = {
      {{.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.004, .damped = true, .matched = true},
       0.15,
       THRUM_STEP_TRAPEZOID},
      {{.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.004, .damped = true, .matched = false},
       0.15,
       THRUM_STEP_TRAPEZOID},
      {{.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.004, .damped = false, .matched = true},
       0.15,
       THRUM_STEP_TRAPEZOID},
      {{.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.0225, .damped = true, .matched = true},
       0.8,
       THRUM_STEP_AVERAGE},
      {{.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.11, .damped = true, .matched = true},
       0.2,
       THRUM_STEP_AVERAGE},
      {{.integrator = THRUM_INTEGRATOR_MIDPOINT, .h = 0.004, .damped = true},
       0.15,
       THRUM_STEP_MIDPOINT},
      {{.integrator = THRUM_INTEGRATOR_NEWMARK,
        .h = 0.004,
        .damped = true,
        .newmark_beta = 0.25,
        .newmark_gamma = 0.5},
       0.15,
       THRUM_STEP_NEWMARK},
      {{.integrator = THRUM_INTEGRATOR_NEWMARK,
        .h = 0.004,
        .damped = true,
        .newmark_beta = 0.3,
        .newmark_gamma = 0.6},
       0.15,
       THRUM_STEP_NEWMARK},
      {{.integrator = THRUM_INTEGRATOR_NEWMARK,
        .h = 0.002,
        .damped = true,
        .newmark_beta = 0,
        .newmark_gamma = 0.5},
       0.15,
       THRUM_STEP_NEWMARK},
      {{.integrator = THRUM_INTEGRATOR_VERLET, .h = 0.002, .damped = true},
       0.15,
       THRUM_STEP_VERLET},
      {{.integrator = THRUM_INTEGRATOR_VERLET, .h = 0.002, .damped = false},
       0.15,
       THRUM_STEP_VERLET},
      {{.integrator = THRUM_INTEGRATOR_ENERGY,
        .h = 0.004,
        .damped = true,
        .matched = true,
        .parted = true},
       0.15,
       THRUM_STEP_TRAPEZOID},
      {{.integrator = THRUM_INTEGRATOR_ENERGY,
        .h = 0.11,
        .damped = true,
        .matched = true,
        .parted = true},
       0.2,
       THRUM_STEP_AVERAGE},
      {{.integrator = THRUM_INTEGRATOR_MIDPOINT, .h = 0.004, .damped = true, .parted = true},
       0.15,
       THRUM_STEP_MIDPOINT},
      {{.integrator = THRUM_INTEGRATOR_NEWMARK,
        .h = 0.004,
        .damped = true,
        .parted = true,
        .newmark_beta = 0.25,
        .newmark_gamma = 0.5},
       0.15,
       THRUM_STEP_NEWMARK},
      {{.integrator = THRUM_INTEGRATOR_VERLET, .h = 0.002, .damped = true, .parted = true},
       0.15,
       THRUM_STEP_VERLET},
      {{.integrator = THRUM_INTEGRATOR_ENERGY,
        .h = 0.004,
        .damped = true,
        .matched = true,
        .acts = true},
       0.15,
       THRUM_STEP_TRAPEZOID},
      {{.integrator = THRUM_INTEGRATOR_ENERGY,
        .h = 0.11,
        .damped = true,
        .matched = true,
        .acts = true},
       0.2,
       THRUM_STEP_AVERAGE},
      {{.integrator = THRUM_INTEGRATOR_MIDPOINT, .h = 0.004, .damped = true, .acts = true},
       0.15,
       THRUM_STEP_MIDPOINT},
      {{.integrator = THRUM_INTEGRATOR_NEWMARK,
        .h = 0.004,
        .damped = true,
        .acts = true,
        .newmark_beta = 0.25,
        .newmark_gamma = 0.5},
       0.15,
       THRUM_STEP_NEWMARK},
      {{.integrator = THRUM_INTEGRATOR_VERLET, .h = 0.002, .damped = true, .acts = true},
       0.15,
       THRUM_STEP_VERLET},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    run r = cases[n].r;
    run_make(&r, 9, cases[n].amplitude);
    const int taken = steps_of(&r, cases[n].form);
    if (taken <= STEPS / 2)
      fail_msg("case %zu: %d steps of its form", n, taken);

    double backward = 0, forward = 0;
    by_passes(&r, &backward, &forward);
    assert_true(fabs(forward / backward - 1) < 1e-12);
    const double differences = by_differences(&r, 2e-4);

    // steps of the average vector field are larger, and what their solves leave is felt more
    const double most = cases[n].form == THRUM_STEP_AVERAGE ? 1e-7 : 1e-8;
    if (!(fabs(differences / backward - 1) < most))
      fail_msg("case %zu: %.15g, by differences %.15g", n, backward, differences);
    random_model_free(&r.body);
    random_model_free(&r.other);
  }
}

/* A default tolerance leaves a residual, by which the gradient errs. */
static void a_gradient_errs_by_the_tolerance_of_the_steps(void **context) {
  (void)context;
  run r = {.integrator = THRUM_INTEGRATOR_ENERGY, .h = 0.004, .damped = true, .matched = true};
  run_make(&r, 9, 0.15);
  double exact = 0, loose = 0, forward = 0;
  by_passes(&r, &exact, &forward);
  r.tolerance = 1e-5;
  by_passes(&r, &loose, &forward);
  assert_true(fabs(loose / exact - 1) < 1e-3);
  assert_true(fabs(loose / exact - 1) > 1e-9);
  random_model_free(&r.body);
  random_model_free(&r.other);
}

/* A linear mode under verlet: q_{k+1} = 2 c q_k - q_{k-1}, so q_n = T_n(c) q_0, c = 1 - (h w)^2/2
 * for p_0 = 0, and dq_n/ds = n U_{n-1}(c) dc/ds q_0. */
static void a_linear_mode_has_the_gradient_of_its_closed_form(void **context) {
  (void)context;
  enum { COUNT = 200 };
  random_model body;
  random_model_make(&body, 3, 1, 50, 50, INFINITY);
  const thrum_model *model = &body.model;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_VERLET;
  thrum_state *state = state_make(model, &def);
  thrum_tape *tape = NULL;
  const double h = def.dt, start = 0.3, none = 0;
  assert_int_equal(create(model, COUNT, &tape, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_start(model, tape, state, &start, &none, NULL), THRUM_OK);
  for (int k = 0; k < COUNT; k++)
    assert_int_equal(thrum_tape_step(model, tape, state, NULL, NULL), THRUM_OK);

  // the loss is the last q
  double q_bar[COUNT + 1] = {0}, by_q = 0, by_force[COUNT];
  q_bar[COUNT] = 1;
  thrum_tape_gradient gradient = {.q = &by_q, .force = by_force};
  assert_int_equal(thrum_tape_pull_back(model, tape, q_bar, NULL, &gradient, NULL), THRUM_OK);
  const double w2 = body.omega2[0], angle = acos(1 - 0.5 * h * h * w2);
  const double by_c = COUNT * sin(COUNT * angle) / sin(angle);
  assert_true(fabs(by_q - cos(COUNT * angle)) < 1e-11);
  assert_true(fabs(gradient.stiffness + by_c * 0.5 * h * h * w2 * start) < 1e-11);
  assert_true(fabs(gradient.density + gradient.stiffness) < 1e-15);
  thrum_tape_destroy(tape);
  state_free(state);
  random_model_free(&body);
}

/* R(q) = s f is solved by Newton's method; its derivative by f and s agrees with the solved one. */
static void a_rest_has_the_gradient_of_its_solutions(void **context) {
  (void)context;
  random_model body;
  random_model_make(&body, 11, RANK, 20, 60, 1);
  const thrum_model *model = &body.model;
  double *work = random_alloc(RANK * (RANK + 3) + (int64_t)thrum_work_count(model), sizeof(double));
  random_state random = {5};
  double q[RANK], q_bar[RANK], load_bar[RANK], along[RANK], values[2], stiffness_bar = 0;
  random_vector(&random, RANK, 0.3, q);
  random_vector(&random, RANK, 1, q_bar);
  random_vector(&random, RANK, 100, along);
  thrum_error error;
  assert_int_equal(thrum_rest_pull_back(model, q, q_bar, load_bar, &stiffness_bar, work, &error),
                   THRUM_OK);

  // the body under the load of q, moved by e along the direction, and stiffer by 0.5 e
  const double e = 1e-4;
  for (int side = 0; side < 2; side++) {
    const double by = side ? e : -e;
    double load[RANK], at[RANK], force[RANK], step[RANK];
    thrum_internal_force(model, q, load, work);
    memcpy(at, q, sizeof q);
    for (int it = 0; it < 30; it++) {
      thrum_internal_force(model, at, force, work);
      for (int i = 0; i < RANK; i++)
        step[i] = (load[i] + by * along[i]) - (1 + 0.5 * by) * force[i];
      assert_int_equal(thrum_rest_pull_back(model, at, step, force, NULL, work, NULL), THRUM_OK);
      for (int i = 0; i < RANK; i++)
        at[i] += force[i];
    }
    values[side] = dot(at, q_bar, RANK);
  }
  const double differences = (values[1] - values[0]) / (2 * e);
  const double exact = dot(load_bar, along, RANK) + 0.5 * stiffness_bar;
  assert_true(fabs(differences / exact - 1) < 1e-7);

  // what is refused
  q_bar[1] = NAN;
  assert_int_equal(thrum_rest_pull_back(model, q, q_bar, load_bar, NULL, work, NULL),
                   THRUM_BAD_VALUE);
  assert_int_equal(thrum_rest_pull_back(model, NULL, q_bar, load_bar, NULL, work, NULL),
                   THRUM_INVALID_ARGUMENT);
  free(work);
  random_model_free(&body);
}

/* A rest under levels, R(q) = 0, moves with each of them as its gradient says. */
static void a_rest_moves_with_the_levels(void **context) {
  (void)context;
  random_model body;
  actors own;
  random_model_make(&body, 11, RANK, 20, 60, 1);
  add_actors(&body.model, &own);
  thrum_model acting;
  double *work = random_alloc(RANK * (RANK + 3) + (int64_t)thrum_work_count(&body.model) +
                                  thrum_model_actuation_count(&body.model),
                              sizeof(double));
  double *memory = work + RANK * (RANK + 3) + (int64_t)thrum_work_count(&body.model);
  const double q_bar[RANK] = {1, -2, 0.5, 1, 3}, along[ACTUATORS] = {3, 2, -1, 2};
  double values[2], exact = 0, force[RANK], step[RANK], q[RANK] = {0};
  for (int side = 2; side >= 0; side--) {
    double levels[ACTUATORS] = {30, 20, 40, 10};
    for (int k = 0; k < ACTUATORS; k++)
      levels[k] += side == 2 ? 0 : 1e-3 * (2 * side - 1) * along[k];
    assert_int_equal(thrum_model_actuate(&body.model, levels, memory, &acting, NULL), THRUM_OK);
    for (int it = 0; it < 30; it++) {
      thrum_internal_force(&acting, q, force, work);
      assert_int_equal(thrum_rest_pull_back(&acting, q, force, step, NULL, work, NULL), THRUM_OK);
      for (int i = 0; i < RANK; i++)
        q[i] -= step[i];
    }
    if (side < 2) {
      values[side] = dot(q, q_bar, RANK);
      continue;
    }
    double force_bar[RANK];
    assert_int_equal(thrum_rest_pull_back(&acting, q, q_bar, force_bar, NULL, work, NULL),
                     THRUM_OK);
    for (int k = 0; k < ACTUATORS; k++) {
      assert_int_equal(thrum_model_actuation_force(&acting, k, q, force, NULL, NULL), THRUM_OK);
      exact += along[k] * dot(force_bar, force, RANK);
    }
  }
  assert_true(fabs((values[1] - values[0]) / 2e-3 / exact - 1) < 1e-6);

  // what is refused
  q[0] = NAN;
  assert_int_equal(thrum_model_actuation_force(&acting, 0, q, force, NULL, NULL), THRUM_BAD_VALUE);
  assert_int_equal(thrum_model_actuation_force(&acting, ACTUATORS, q_bar, force, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_actuation_force(&body.model, 0, q_bar, force, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  free(work);
  random_model_free(&body);
}

/* What cannot be differentiated is refused when a tape is started, with the reason. */
static void refuse(const thrum_model *model, const thrum_state_def *def, const char *reason) {
  thrum_error error;
  thrum_tape *tape = NULL;
  thrum_state *state = state_make(model, def);
  assert_int_equal(create(model, 3, &tape, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_start(model, tape, state, NULL, NULL, &error), THRUM_UNSUPPORTED);
  if (strstr(error.message, reason) == NULL)
    fail_msg("%s", error.message);
  thrum_tape_destroy(tape);
  state_free(state);
}

static void what_has_no_gradient_is_refused(void **context) {
  (void)context;
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  thrum_state_def def = imexv_def();
  refuse(&body.model, &def, "imexv");
  def = thrum_default_state_def();
  def.damping_beta = 1e-4;
  def.damping_form = THRUM_DAMPING_TANGENT;
  refuse(&body.model, &def, "tangent");
  const thrum_model *condensed = NULL;
  void *memory = condense(&body.model, 2, &condensed);
  def = thrum_default_state_def();
  def.damping_beta = 1e-4;
  refuse(condensed, &def, "condensed");
  free(memory);
  random_model_free(&body);
}

/* A step that is divided is made, but there is no way back over it. */
static void a_divided_step_is_not_passed(void **context) {
  (void)context;
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_NEWMARK;
  def.dt = 0.05;
  def.iterations_max = 3;
  thrum_state *state = state_make(&body.model, &def);
  thrum_tape *tape = NULL;
  thrum_error error;
  double q[RANK] = {0.8, -0.6}, before[RANK];
  assert_int_equal(create(&body.model, 20, &tape, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_start(&body.model, tape, state, q, NULL, NULL), THRUM_OK);
  for (int k = 0; k < 20; k++)
    if (thrum_tape_step(&body.model, tape, state, NULL, &error) < 0)
      fail_msg("%s", error.message);
  assert_true(thrum_state_report_get(state).substep_steps > 0);
  memcpy(before, q, sizeof q);
  thrum_tape_gradient gradient = {.q = q};
  assert_int_equal(thrum_tape_pull_back(&body.model, tape, NULL, NULL, &gradient, &error),
                   THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "divided"));
  assert_memory_equal(q, before, sizeof q);
  thrum_tape_destroy(tape);
  state_free(state);
  random_model_free(&body);
}

/* A tape has the steps of one state, and all of them. */
static void a_state_that_is_elsewhere_is_not_recorded(void **context) {
  (void)context;
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  const thrum_model *model = &body.model;
  const thrum_state_def def = thrum_default_state_def();
  thrum_state *state = state_make(model, &def), *second = state_make(model, &def);
  thrum_tape *tape = NULL;
  double q[RANK] = {0.01};
  assert_int_equal(create(model, 3, &tape, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_start(model, tape, state, q, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_step(model, tape, second, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_true(thrum_tape_step(model, tape, state, NULL, NULL) >= 0);
  assert_true(thrum_step(model, state, NULL) >= 0);
  assert_int_equal(thrum_tape_step(model, tape, state, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_tape_steps(tape), 1);
  thrum_tape_destroy(tape);
  state_free(state);
  state_free(second);
  random_model_free(&body);
}

/* Forces of late steps that are finite are not written where those of early ones are not. */
static void a_gradient_that_overflows_writes_nothing(void **context) {
  (void)context;
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  const thrum_state_def def = thrum_default_state_def();
  thrum_state *state = state_make(&body.model, &def);
  thrum_tape *tape = NULL;
  double q[RANK] = {0.01}, bar[4 * RANK] = {0}, force[3 * RANK] = {0};
  assert_int_equal(create(&body.model, 3, &tape, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_start(&body.model, tape, state, q, NULL, NULL), THRUM_OK);
  assert_true(thrum_tape_run(&body.model, tape, state, NULL, 3, NULL, NULL) >= 0);
  for (int n = 0; n < 3 * RANK; n++)
    bar[n] = 1.7e308;
  bar[3 * RANK] = 1;
  thrum_tape_gradient gradient = {.q = q, .force = force, .alpha = 7};
  assert_int_equal(thrum_tape_pull_back(&body.model, tape, bar, bar, &gradient, NULL),
                   THRUM_NOT_FINITE);
  for (int n = 0; n < 3 * RANK; n++)
    assert_true(force[n] == 0);
  assert_true(q[0] == 0.01 && gradient.alpha == 7);
  thrum_tape_destroy(tape);
  state_free(state);
  random_model_free(&body);
}

/* A run of a condensed model under forces on all coordinates, those that follow among them. */
typedef struct condensed_run {
  const thrum_model *model;
  thrum_integrator integrator;
  double q[2], p[2], force[FORCES];
  double q_bar[(STEPS + 1) * 2], p_bar[(STEPS + 1) * 2];
} condensed_run;

static thrum_tape *record_condensed(const condensed_run *r, int64_t checkpoints) {
  thrum_tape *tape = NULL;
  thrum_error error;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = r->integrator;
  def.tolerance = 1e-14;
  def.damping_alpha = 0.4;
  thrum_state *state = state_make(r->model, &def);
  thrum_tape_def room = thrum_default_tape_def();
  room.steps = STEPS;
  room.checkpoints = checkpoints;
  room.state = state;
  if (thrum_tape_create(r->model, &room, &tape, &error) != THRUM_OK ||
      thrum_tape_start(r->model, tape, state, r->q, r->p, &error) != THRUM_OK ||
      thrum_tape_run(r->model, tape, state, r->force, STEPS, NULL, &error) < 0)
    fail_msg("%s", error.message);
  state_free(state);
  return tape;
}

static double condensed_loss(condensed_run r, double by, const condensed_run *along) {
  for (int i = 0; i < 2; i++) {
    r.q[i] += by * along->q[i];
    r.p[i] += by * along->p[i];
  }
  for (int i = 0; i < FORCES; i++)
    r.force[i] += by * along->force[i];
  thrum_tape *tape = record_condensed(&r, 0);
  const double loss = dot(r.q_bar, thrum_tape_q(tape), 2 * (STEPS + 1)) +
                      dot(r.p_bar, thrum_tape_p(tape), 2 * (STEPS + 1));
  thrum_tape_destroy(tape);
  return loss;
}

/* Forces on what follows act by how it follows, which changes with the motion; with checkpoints
 * the gradient has the same bits. */
static void what_follows_is_differentiated(void **context) {
  (void)context;
  const thrum_integrator integrators[] = {THRUM_INTEGRATOR_ENERGY, THRUM_INTEGRATOR_NEWMARK,
                                          THRUM_INTEGRATOR_VERLET};
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  condensed_run r, along;
  void *memory = condense(&body.model, 2, &r.model);
  random_state random = {3};
  random_vector(&random, 2, 0.1, r.q);
  random_vector(&random, 2, 2, r.p);
  random_vector(&random, FORCES, 400, r.force);
  random_vector(&random, 2 * (STEPS + 1), 1, r.q_bar);
  random_vector(&random, 2 * (STEPS + 1), 0.02, r.p_bar);
  random_vector(&random, 2, 0.1, along.q);
  random_vector(&random, 2, 2, along.p);
  random_vector(&random, FORCES, 400, along.force);
  for (int n = 0; n < 3; n++) {
    r.integrator = integrators[n];
    const double e = 1e-4;
    const double differences =
        (8 * (condensed_loss(r, e, &along) - condensed_loss(r, -e, &along)) -
         (condensed_loss(r, 2 * e, &along) - condensed_loss(r, -2 * e, &along))) /
        (12 * e);
    double force[2][FORCES], q[2][2], p[2][2];
    double q_change[2 * (STEPS + 1)], p_change[2 * (STEPS + 1)];
    const thrum_tape_gradient direction = {.q = along.q, .p = along.p, .force = along.force};
    for (int kept = 0; kept < 2; kept++) {
      thrum_tape *tape = record_condensed(&r, 7 * kept);
      thrum_tape_gradient g = {.q = q[kept], .p = p[kept], .force = force[kept]};
      assert_int_equal(thrum_tape_pull_back(r.model, tape, r.q_bar, r.p_bar, &g, NULL), THRUM_OK);
      assert_int_equal(thrum_tape_push_forward(r.model, tape, &direction, q_change, p_change, NULL),
                       THRUM_OK);
      thrum_tape_destroy(tape);
    }
    assert_memory_equal(force[0], force[1], sizeof force[0]);
    const double backward =
        dot(q[1], along.q, 2) + dot(p[1], along.p, 2) + dot(force[1], along.force, FORCES);
    const double forward =
        dot(q_change, r.q_bar, 2 * (STEPS + 1)) + dot(p_change, r.p_bar, 2 * (STEPS + 1));
    if (!(fabs(backward / differences - 1) < 1e-8 && fabs(forward / backward - 1) < 1e-11))
      fail_msg("%s: %.17g %.17g %.17g", thrum_integrator_name(r.integrator), differences, backward,
               forward);
  }
  free(memory);
  random_model_free(&body);
}

/* What a tape with checkpoints has of a run: the same bits, in less memory. */
static void checkpoints_give_the_same_bits(void **context) {
  (void)context;
  static const thrum_integrator integrators[] = {THRUM_INTEGRATOR_ENERGY, THRUM_INTEGRATOR_VERLET};
  enum { LONG = 1000 };
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  actors acting;
  add_actors(&body.model, &acting);
  const thrum_model *model = &body.model;
  double *levels = random_alloc(3 * LONG * ACTUATORS, sizeof *levels);
  double *by_levels = levels + LONG * ACTUATORS;
  double *force = random_alloc(2 * LONG * RANK, sizeof *force), *bar = force + LONG * RANK;
  double *by_force = random_alloc(2 * LONG * RANK, sizeof *by_force);
  double *q_bar = random_alloc((LONG + 1) * RANK, sizeof *q_bar);
  random_state random = {9};
  random_vector(&random, LONG * RANK, 300, force);
  random_vector(&random, LONG * ACTUATORS, 30, levels);
  random_vector(&random, LONG * RANK, 1, bar);
  memcpy(q_bar + RANK, bar, LONG * RANK * sizeof *bar);
  for (int n = 0; n < 2; n++) {
    thrum_state_def def = thrum_default_state_def();
    def.integrator = integrators[n];
    def.dt = 0.002;
    double q[2][RANK], along[RANK] = {0.1, 0.2}, scalars[2];
    size_t sizes[2];
    for (int kept = 0; kept < 2; kept++) {
      thrum_state *state = state_make(model, &def);
      thrum_tape_def room = thrum_default_tape_def();
      room.steps = LONG;
      room.checkpoints = 8 * kept;
      room.state = state;
      thrum_tape *tape = NULL;
      thrum_tape_gradient g = {.q = q[kept],
                               .force = by_force + kept * LONG * RANK,
                               .levels = by_levels + kept * LONG * ACTUATORS};
      assert_int_equal(thrum_tape_size(model, &room, &sizes[kept], NULL), THRUM_OK);
      assert_int_equal(thrum_tape_create(model, &room, &tape, NULL), THRUM_OK);
      assert_int_equal(thrum_tape_start(model, tape, state, along, NULL, NULL), THRUM_OK);

      // a pass in between has the tape go on as before
      assert_true(thrum_tape_run_levels(model, tape, state, force, levels, 333, NULL, NULL) >= 0);
      assert_int_equal(thrum_tape_pull_back(model, tape, q_bar, NULL, &g, NULL), THRUM_OK);
      assert_true(thrum_tape_run_levels(model, tape, state, force + 333 * RANK,
                                        levels + 333 * ACTUATORS, LONG - 333, NULL, NULL) >= 0);
      assert_int_equal(thrum_tape_pull_back(model, tape, q_bar, NULL, &g, NULL), THRUM_OK);
      scalars[kept] = g.stiffness + g.beta;
      assert_true((thrum_tape_q(tape) == NULL) == (kept == 1));
      thrum_tape_destroy(tape);
      state_free(state);
    }
    assert_memory_equal(q[0], q[1], sizeof q[0]);
    assert_memory_equal(by_force, by_force + LONG * RANK, LONG * RANK * sizeof *by_force);
    assert_memory_equal(by_levels, by_levels + LONG * ACTUATORS,
                        LONG * ACTUATORS * sizeof *by_levels);
    assert_true(scalars[0] == scalars[1]);
    assert_true(sizes[1] < sizes[0] / 4 * 3);
  }
  free(levels);
  free(force);
  free(by_force);
  free(q_bar);
  random_model_free(&body);
}

/* A loss that sees each eighth step needs rows of those alone. */
static void a_loss_may_see_some_steps(void **context) {
  (void)context;
  enum { EVERY = 8, ROWS = (STEPS / EVERY + 1) * RANK };
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  const thrum_model *model = &body.model;
  const thrum_state_def def = thrum_default_state_def();
  thrum_state *state = state_make(model, &def);
  random_state random = {9};
  double start[RANK], some[ROWS], all[POINTS] = {0}, q[2][RANK];
  double changed[2][2][POINTS], along[RANK] = {1, 2, 3};
  random_vector(&random, RANK, 0.1, start);
  random_vector(&random, ROWS, 1, some);
  for (int k = 0; k * EVERY <= STEPS; k++)
    memcpy(all + k * EVERY * RANK, some + k * RANK, RANK * sizeof *all);
  for (int side = 0; side < 2; side++) {
    thrum_tape *tape = NULL;
    thrum_tape_def room = thrum_default_tape_def();
    room.steps = STEPS;
    room.every = side ? EVERY : 1;
    room.checkpoints = 3 * side;
    room.state = state;
    assert_int_equal(thrum_tape_create(model, &room, &tape, NULL), THRUM_OK);
    assert_int_equal(thrum_tape_start(model, tape, state, start, NULL, NULL), THRUM_OK);
    assert_true(thrum_tape_run(model, tape, state, NULL, STEPS, NULL, NULL) >= 0);
    thrum_tape_gradient g = {.q = q[side]}, direction = {.q = along};
    assert_int_equal(thrum_tape_pull_back(model, tape, side ? some : all, NULL, &g, NULL),
                     THRUM_OK);
    assert_int_equal(
        thrum_tape_push_forward(model, tape, &direction, changed[side][0], changed[side][1], NULL),
        THRUM_OK);
    thrum_tape_destroy(tape);
  }
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  for (int k = 0; k * EVERY <= STEPS; k++)
    for (int n = 0; n < 2; n++)
      assert_memory_equal(changed[0][n] + k * EVERY * RANK, changed[1][n] + k * RANK,
                          RANK * sizeof(double));
  state_free(state);
  random_model_free(&body);
}

/* Runs side by side have the bits of runs alone, on their tapes and in their gradients. */
static void a_batch_of_runs_has_the_bits_of_each(void **context) {
  (void)context;
  enum { RUNS = 5 };
  static const thrum_integrator integrators[] = {THRUM_INTEGRATOR_ENERGY, THRUM_INTEGRATOR_VERLET};
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  const thrum_model *model = &body.model;
  double *force = random_alloc(RUNS * FORCES, sizeof *force), bar[POINTS], start[RUNS][RANK];
  random_state random = {9};
  random_vector(&random, RUNS * FORCES, 300, force);
  random_vector(&random, POINTS, 1, bar);
  random_vector(&random, RUNS * RANK, 0.1, start[0]);
  size_t size = 0;
  assert_int_equal(thrum_batch_size(model, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, (size + 63) / 64 * 64);
  for (int n = 0; n < 2; n++) {
    thrum_state_def def = thrum_default_state_def();
    def.integrator = integrators[n];
    def.dt = 0.002;
    thrum_tape *tapes[RUNS], *alone = NULL;
    thrum_state *states[RUNS];
    thrum_status statuses[RUNS];
    for (int k = 0; k < RUNS; k++) {
      states[k] = state_make(model, &def);
      assert_int_equal(create(model, STEPS, &tapes[k], NULL), THRUM_OK);
      assert_int_equal(thrum_tape_start(model, tapes[k], states[k], start[k], NULL, NULL),
                       THRUM_OK);
    }
    const thrum_tape_batch batch = {.model = model,
                                    .tapes = tapes,
                                    .states = states,
                                    .count = RUNS,
                                    .statuses = statuses,
                                    .workspace = workspace,
                                    .workspace_size = size};
    int64_t made = 0;
    assert_true(thrum_tape_batch_run(&batch, force, STEPS, &made, NULL) >= 0);
    assert_int_equal(made, STEPS);
    assert_int_equal(thrum_tape_batch_run(&batch, NULL, 1, &made, NULL), THRUM_BUFFER_TOO_SMALL);
    assert_int_equal(made, 0);
    thrum_state *state = state_make(model, &def);
    assert_int_equal(create(model, STEPS, &alone, NULL), THRUM_OK);
    for (int k = 0; k < RUNS; k++) {
      double q[2][RANK], by_force[2][FORCES];
      assert_int_equal(thrum_tape_start(model, alone, state, start[k], NULL, NULL), THRUM_OK);
      assert_true(thrum_tape_run(model, alone, state, force + k * FORCES, STEPS, NULL, NULL) >= 0);
      assert_memory_equal(thrum_tape_q(alone), thrum_tape_q(tapes[k]), POINTS * sizeof(double));
      assert_memory_equal(thrum_tape_p(alone), thrum_tape_p(tapes[k]), POINTS * sizeof(double));
      for (int side = 0; side < 2; side++) {
        thrum_tape_gradient g = {.q = q[side], .force = by_force[side]};
        assert_int_equal(thrum_tape_pull_back(model, side ? alone : tapes[k], bar, NULL, &g, NULL),
                         THRUM_OK);
      }
      assert_memory_equal(q[0], q[1], sizeof q[0]);
      assert_memory_equal(by_force[0], by_force[1], sizeof by_force[0]);
    }

    // one that fails ends all, and the tapes of the others have its step
    for (int k = 0; k < RUNS; k++)
      assert_int_equal(thrum_tape_start(model, tapes[k], states[k], start[k], NULL, NULL),
                       THRUM_OK);
    for (int i = 0; i < RANK; i++)
      force[(2 * 3 + 1) * RANK + i] = 1e300;
    assert_true(thrum_tape_batch_run(&batch, force, 3, &made, NULL) < 0);
    assert_int_equal(made, 1);
    for (int k = 0; k < RUNS; k++)
      assert_int_equal(thrum_tape_steps(tapes[k]), k == 2 ? 1 : 2);
    random_vector(&random, RUNS * FORCES, 300, force);
    assert_int_equal(thrum_tape_batch_run(NULL, force, 3, &made, NULL), THRUM_INVALID_ARGUMENT);

    // one whose state was set elsewhere is refused, however often it is asked
    assert_int_equal(thrum_state_set(model, states[1], start[0], NULL, NULL), THRUM_OK);
    for (int again = 0; again < 2; again++)
      assert_int_equal(thrum_tape_batch_run(&batch, force, 1, &made, NULL), THRUM_INVALID_ARGUMENT);
    assert_int_equal(thrum_tape_steps(tapes[1]), 2);
    for (int k = 0; k < RUNS; k++) {
      thrum_tape_destroy(tapes[k]);
      state_free(states[k]);
    }
    thrum_tape_destroy(alone);
    state_free(state);
  }
  free(workspace);
  free(force);
  random_model_free(&body);
}

/* With checkpoints the forces are one array. */
static void a_force_of_another_array_is_refused(void **context) {
  (void)context;
  random_model body;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  const thrum_state_def def = thrum_default_state_def();
  thrum_state *state = state_make(&body.model, &def);
  thrum_tape_def room = thrum_default_tape_def();
  room.steps = 3;
  room.checkpoints = 2;
  room.state = state;
  thrum_tape *tape = NULL;
  double force[3 * RANK] = {0};
  assert_int_equal(thrum_tape_create(&body.model, &room, &tape, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_start(&body.model, tape, state, NULL, NULL, NULL), THRUM_OK);
  assert_true(thrum_tape_step(&body.model, tape, state, force, NULL) >= 0);
  assert_int_equal(thrum_tape_step(&body.model, tape, state, force, NULL), THRUM_INVALID_ARGUMENT);
  assert_true(thrum_tape_step(&body.model, tape, state, force + RANK, NULL) >= 0);
  assert_true(thrum_tape_step(&body.model, tape, state, force + 2 * RANK, NULL) >= 0);

  // one that is no more what it was gives no derivative, and when it is again, gives it
  double bar[4 * RANK] = {1}, start[RANK];
  thrum_tape_gradient g = {.q = start};
  for (int k = 0; k < 4; k++) {
    force[0] = k < 2 ? 5 : 0;
    assert_int_equal(thrum_tape_pull_back(&body.model, tape, bar, NULL, &g, NULL),
                     k < 2 ? THRUM_INVALID_ARGUMENT : THRUM_OK);
  }
  thrum_tape_destroy(tape);
  state_free(state);
  random_model_free(&body);
}

static void bad_calls_are_refused(void **context) {
  (void)context;
  random_model body, other;
  random_model_make(&body, 4, RANK, 20, 200, 1);
  random_model_make(&other, 4, RANK - 1, 20, 200, 1);
  const thrum_model *model = &body.model;
  const thrum_state_def def = thrum_default_state_def();
  thrum_state *state = state_make(model, &def), *state_other = state_make(&other.model, &def);
  thrum_tape *tape = NULL;
  size_t size = 0;
  assert_int_equal(create(model, 0, &tape, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(create(NULL, 1, &tape, NULL), THRUM_INVALID_ARGUMENT);
  thrum_tape_def room = thrum_default_tape_def();
  room.steps = INT64_MAX;
  assert_int_equal(thrum_tape_size(model, &room, &size, NULL), THRUM_OUT_OF_MEMORY);
  room.steps = 2;
  room.every = 0;
  assert_int_equal(thrum_tape_size(model, &room, &size, NULL), THRUM_INVALID_ARGUMENT);
  room.every = 1;
  room.checkpoints = -1;
  assert_int_equal(thrum_tape_size(model, &room, &size, NULL), THRUM_INVALID_ARGUMENT);
  room.checkpoints = 1;
  assert_int_equal(thrum_tape_size(model, &room, &size, NULL), THRUM_INVALID_ARGUMENT);
  room.checkpoints = 0;
  assert_int_equal(thrum_tape_size(model, &room, &size, NULL), THRUM_OK);
  const thrum_tape_def none = {0};
  assert_int_equal(thrum_tape_size(model, &none, &size, NULL), THRUM_UNINITIALISED_DEF);

  // memory of the caller
  unsigned char *memory = aligned_alloc(64, size + 64);
  assert_int_equal(thrum_tape_init(memory + 8, size, model, &room, &tape, NULL), THRUM_MISALIGNED);
  assert_int_equal(thrum_tape_init(memory, size - 1, model, &room, &tape, NULL),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_tape_init(memory, size, model, &room, &tape, NULL), THRUM_OK);

  // out of order, too long, of another model
  double q[3 * RANK] = {0};
  thrum_tape_gradient gradient = {.q = q};
  assert_int_equal(thrum_tape_step(model, tape, state, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_tape_start(&other.model, tape, state_other, NULL, NULL, NULL),
                   THRUM_MODEL_MISMATCH);
  assert_int_equal(thrum_tape_start(model, tape, state, NULL, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_pull_back(model, tape, NULL, NULL, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  q[0] = NAN;
  assert_int_equal(thrum_tape_step(model, tape, state, q, NULL), THRUM_BAD_VALUE);
  assert_int_equal(thrum_tape_pull_back(model, tape, q, NULL, &gradient, NULL), THRUM_BAD_VALUE);
  int64_t made = 0;
  q[0] = 0;
  assert_int_equal(thrum_tape_run(model, tape, state, NULL, -1, &made, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_tape_run_levels(model, tape, state, NULL, q, 1, &made, NULL),
                   THRUM_UNSUPPORTED);
  assert_int_equal(thrum_tape_run(model, tape, state, q, 3, &made, NULL), THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(made, 2);
  assert_int_equal(thrum_tape_step(model, tape, state, NULL, NULL), THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_tape_steps(tape), 2);
  assert_int_equal(thrum_tape_start(model, tape, state, NULL, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_steps(tape), 0);
  assert_int_equal(thrum_state_set_dt(model, state, 0.001, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_step(model, tape, state, NULL, NULL), THRUM_UNSUPPORTED);
  free(memory);
  state_free(state);
  state_free(state_other);
  random_model_free(&body);
  random_model_free(&other);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_gradient_is_that_of_the_run_and_its_transpose),
      cmocka_unit_test(a_gradient_errs_by_the_tolerance_of_the_steps),
      cmocka_unit_test(a_linear_mode_has_the_gradient_of_its_closed_form),
      cmocka_unit_test(a_rest_has_the_gradient_of_its_solutions),
      cmocka_unit_test(a_rest_moves_with_the_levels),
      cmocka_unit_test(what_has_no_gradient_is_refused),
      cmocka_unit_test(a_divided_step_is_not_passed),
      cmocka_unit_test(a_state_that_is_elsewhere_is_not_recorded),
      cmocka_unit_test(a_gradient_that_overflows_writes_nothing),
      cmocka_unit_test(what_follows_is_differentiated),
      cmocka_unit_test(checkpoints_give_the_same_bits),
      cmocka_unit_test(a_batch_of_runs_has_the_bits_of_each),
      cmocka_unit_test(a_loss_may_see_some_steps),
      cmocka_unit_test(a_force_of_another_array_is_refused),
      cmocka_unit_test(bad_calls_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
