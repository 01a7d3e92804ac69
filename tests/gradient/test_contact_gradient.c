/* Tests of gradients of runs with contact: smooth ones against differences of runs, what is not
 * smooth is refused with its place, and passed by a subgradient on request.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"

#include "thrum/gradient.h"

enum { RANK = 4, STEPS = 60, POINTS = (STEPS + 1) * RANK, VERTICES = 6 };

typedef struct run {
  thrum_integrator integrator;
  double amplitude; /* of the body's nonlinearity */
  double restitution, friction, damping, stiffness;
  double q[RANK], p[RANK], load[RANK], alpha;
  double hardness; /* a factor of Young's modulus */
  thrum_tape_subgradient subgradient;
} run;

typedef struct made {
  random_model body;
  thrum_state *state;
  thrum_contact *contact;
  thrum_tape *tape;
} made;

static double dot(const double *a, const double *b, int64_t n) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

/* Makes the run; returns how many touches its steps had. */
static int64_t make(const run *r, made *m) {
  thrum_error error = {0};
  random_model_make(&m->body, 3, RANK, 20, 90, r->amplitude);
  random_model_add_mesh(&m->body, 4, VERTICES);
  for (int i = 0; i < RANK; i++)
    m->body.omega2[i] *= r->hardness;
  for (int64_t c = 0; c < m->body.model.c3_count; c++)
    m->body.c3[c] *= r->hardness;
  for (int64_t c = 0; c < m->body.model.c4_count; c++)
    m->body.c4[c] *= r->hardness;
  const thrum_model *model = &m->body.model;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = r->integrator;
  def.dt = 0.002;
  def.tolerance = 1e-14;
  def.damping_alpha = r->alpha;
  m->state = state_make(model, &def);
  const double areas[VERTICES - 1] = {1, 1, 1, 1, 1};
  const int32_t vertices[VERTICES - 1] = {1, 2, 3, 4, 5};
  thrum_contact_def contact_def = thrum_default_contact_def();
  contact_def.vertices = vertices;
  contact_def.vertex_count = VERTICES - 1;
  contact_def.areas = areas;
  contact_def.stiffness = 1e3;
  contact_def.tolerance = 1e-14;
  contact_def.sweeps_max = 10000;
  m->contact = contact_make(model, m->state, &contact_def);
  thrum_tape_def tape_def = thrum_default_tape_def();
  tape_def.steps = STEPS;
  tape_def.touches = 15 * STEPS;
  tape_def.subgradient = r->subgradient;
  assert_int_equal(thrum_tape_create(model, &tape_def, &m->tape, &error), THRUM_OK);

  // a floor just below the lowest vertex, inclined
  double least = INFINITY;
  const double normal[3] = {0.1, -0.2, 0.97};
  for (int v = 1; v < VERTICES; v++)
    least = fmin(least, dot(m->body.vertices + 3 * v, normal, 3));
  thrum_obstacle floor = thrum_default_obstacle();
  for (int axis = 0; axis < 3; axis++) {
    floor.normal[axis] = normal[axis];
    floor.centre[axis] = (least - 0.01) * normal[axis] / dot(normal, normal, 3);
  }
  floor.restitution = r->restitution;
  floor.friction = r->friction;
  floor.damping = r->damping;
  floor.stiffness = r->stiffness;
  const thrum_contact_environment environment = {
      .obstacles = &floor, .obstacle_count = 1, .load = r->load};
  double q[RANK], p[RANK];
  memcpy(q, r->q, sizeof q);
  memcpy(p, r->p, sizeof p);
  assert_int_equal(thrum_tape_start(model, m->tape, m->state, q, p, &error), THRUM_OK);
  int64_t touches = 0;
  for (int k = 0; k < STEPS; k++) {
    if (thrum_tape_contact_step(model, m->tape, m->state, m->contact, &environment, &error) < 0)
      fail_msg("%s", error.message);
    touches += thrum_contact_report_get(m->contact).touching;
  }
  return touches;
}

static void end(made *m) {
  thrum_tape_destroy(m->tape);
  free(m->contact);
  state_free(m->state);
  random_model_free(&m->body);
}

static double loss(const run *r, const run *along, double by, const double *q_bar,
                   const double *p_bar) {
  run at = *r;
  for (int i = 0; i < RANK; i++) {
    at.q[i] += by * along->q[i];
    at.p[i] += by * along->p[i];
    at.load[i] += by * along->load[i];
  }
  at.alpha += by * along->alpha;
  at.hardness += by * along->hardness;
  made m;
  make(&at, &m);
  const double value =
      dot(q_bar, thrum_tape_q(m.tape), POINTS) + dot(p_bar, thrum_tape_p(m.tape), POINTS);
  end(&m);
  return value;
}

/* The run at which all is differentiated, and a direction. */
static void choose(run *r, run *along, double *q_bar, double *p_bar) {
  random_state random = {11};
  memset(along, 0, sizeof *along);
  random_vector(&random, POINTS, 1, q_bar);
  random_vector(&random, POINTS, 0.02, p_bar);
  random_vector(&random, RANK, 0.02, r->q);
  random_vector(&random, RANK, 1, r->p);
  random_vector(&random, RANK, 30, r->load);
  random_vector(&random, RANK, 0.02, along->q);
  random_vector(&random, RANK, 1, along->p);
  random_vector(&random, RANK, 30, along->load);
  r->alpha = 2;
  along->alpha = 1;
  along->hardness = 0.3;
}

/* The derivative along the direction, backward; forward it is the same to `off`. */
static double derivative(const run *r, const run *along, const double *q_bar, const double *p_bar,
                         double off) {
  made m;
  thrum_error error = {0};
  double q[RANK], p[RANK], force[STEPS * RANK], along_force[STEPS * RANK], dq[POINTS], dp[POINTS];
  thrum_tape_gradient g = {.q = q, .p = p, .force = force};
  run copy = *along;
  assert_true(make(r, &m) > 10);
  if (thrum_tape_pull_back(&m.body.model, m.tape, q_bar, p_bar, &g, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  double backward = dot(q, along->q, RANK) + dot(p, along->p, RANK) + g.alpha * along->alpha +
                    g.stiffness * along->hardness;
  for (int k = 0; k < STEPS; k++) {
    backward += dot(force + k * RANK, along->load, RANK);
    memcpy(along_force + k * RANK, along->load, sizeof along->load);
  }
  thrum_tape_gradient direction = {.q = copy.q,
                                   .p = copy.p,
                                   .force = along_force,
                                   .alpha = along->alpha,
                                   .stiffness = along->hardness};
  assert_int_equal(thrum_tape_push_forward(&m.body.model, m.tape, &direction, dq, dp, &error),
                   THRUM_OK);
  const double forward = dot(q_bar, dq, POINTS) + dot(p_bar, dp, POINTS);
  if (!(fabs(forward / backward - 1) < off))
    fail_msg("forward %.15g, backward %.15g", forward, backward);
  end(&m);
  return backward;
}

/* What springs push and what slides: as differences of runs, by all integrators. Where steps of
 * energy give back what they missed, that is held. */
static void smooth_contact_is_differentiated(void **context) {
  (void)context;
  static const struct {
    run r;
    double most;
  } cases[] = {
      {{.integrator = THRUM_INTEGRATOR_MIDPOINT, .amplitude = 1, .restitution = 1}, 1e-8},
      {{.integrator = THRUM_INTEGRATOR_MIDPOINT, .amplitude = 1, .restitution = 1, .damping = 3},
       1e-8},
      {{.integrator = THRUM_INTEGRATOR_MIDPOINT, .amplitude = 1, .restitution = 1, .friction = 0.3},
       1e-5},
      {{.integrator = THRUM_INTEGRATOR_NEWMARK, .amplitude = 1, .restitution = 1}, 1e-8},
      {{.integrator = THRUM_INTEGRATOR_VERLET, .amplitude = 1, .restitution = 1}, 1e-8},
      {{.integrator = THRUM_INTEGRATOR_ENERGY, .amplitude = INFINITY, .restitution = 1}, 1e-8},
      {{.integrator = THRUM_INTEGRATOR_ENERGY, .amplitude = 1, .restitution = 1}, 1e-5},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    run r = cases[n].r, along;
    double q_bar[POINTS], p_bar[POINTS];
    r.stiffness = 300;
    r.hardness = 1;
    choose(&r, &along, q_bar, p_bar);
    const double found = derivative(&r, &along, q_bar, p_bar, 1e-12), e = 1e-4;
    const double differences =
        (8 * (loss(&r, &along, e, q_bar, p_bar) - loss(&r, &along, -e, q_bar, p_bar)) -
         (loss(&r, &along, 2 * e, q_bar, p_bar) - loss(&r, &along, -2 * e, q_bar, p_bar))) /
        (12 * e);
    if (!(fabs(differences / found - 1) < cases[n].most))
      fail_msg("case %zu: %.15g, by differences %.15g", n, found, differences);
  }
}

/* An impact on a hard floor that takes energy is refused with its place, and passed on request: by
 * laws that stay, which leave out how the rebound out of a depth changes. */
static void what_is_not_smooth_is_refused_or_held(void **context) {
  (void)context;
  run r = {.integrator = THRUM_INTEGRATOR_ENERGY, .amplitude = 1, .restitution = 0.5}, along;
  double q_bar[POINTS], p_bar[POINTS], q[RANK];
  made m;
  thrum_error error = {0};
  r.stiffness = 1e6;
  r.hardness = 1;
  choose(&r, &along, q_bar, p_bar);
  make(&r, &m);
  thrum_tape_gradient g = {.q = q};
  assert_int_equal(thrum_tape_pull_back(&m.body.model, m.tape, q_bar, p_bar, &g, &error),
                   THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "step 37 at t = 0.074 s is not smooth: vertex 5"));
  end(&m);
  r.subgradient = THRUM_SUBGRADIENT_FIXED;
  along.hardness = 0;
  const double found = derivative(&r, &along, q_bar, p_bar, 1e-6), e = 1e-5;
  const double differences =
      (loss(&r, &along, e, q_bar, p_bar) - loss(&r, &along, -e, q_bar, p_bar)) / (2 * e);
  if (!(fabs(differences / found - 1) < 0.1))
    fail_msg("%.15g, by differences %.15g", found, differences);
}

static void bad_contact_is_refused(void **context) {
  (void)context;
  run r = {.integrator = THRUM_INTEGRATOR_MIDPOINT, .amplitude = 1, .restitution = 1}, along;
  double q_bar[POINTS], p_bar[POINTS];
  r.stiffness = 300;
  r.hardness = 1;
  choose(&r, &along, q_bar, p_bar);
  made m;
  make(&r, &m);
  const thrum_model *model = &m.body.model;
  thrum_obstacle ball = thrum_default_obstacle();
  ball.shape = THRUM_OBSTACLE_SPHERE;
  thrum_contact_environment around = {.obstacles = &ball, .obstacle_count = 1};
  assert_int_equal(thrum_tape_start(model, m.tape, m.state, NULL, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_tape_contact_step(model, m.tape, m.state, m.contact, &around, NULL),
                   THRUM_UNSUPPORTED);
  assert_int_equal(thrum_tape_contact_step(model, m.tape, m.state, NULL, &around, NULL),
                   THRUM_INVALID_ARGUMENT);
  thrum_translation free_to_move = {.mass = 1};
  around.translation = &free_to_move;
  around.obstacle_count = 0;
  assert_int_equal(thrum_tape_contact_step(model, m.tape, m.state, m.contact, &around, NULL),
                   THRUM_UNSUPPORTED);
  size_t size = 0;
  thrum_tape_def def = thrum_default_tape_def();
  def.touches = 1;
  def.checkpoints = 1;
  def.state = m.state;
  assert_int_equal(thrum_tape_size(model, &def, &size, NULL), THRUM_INVALID_ARGUMENT);
  end(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(smooth_contact_is_differentiated),
      cmocka_unit_test(what_is_not_smooth_is_refused_or_held),
      cmocka_unit_test(bad_contact_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
