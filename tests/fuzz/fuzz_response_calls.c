/* Fuzz target of periodic motions, gradients and whole loads: curves and normal forms, tapes and
 * rests, and the equation of a step. Each is called with every kind of model. A call that succeeds
 * leaves finite numbers.
 * sources: response/*.c gradient/*.c core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c contact/*.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_use.h"

#include "thrum/actuation.h"
#include "thrum/batch.h"
#include "thrum/condensed_model.h"
#include "thrum/gradient.h"
#include "thrum/parameters.h"
#include "thrum/response.h"
#include "thrum/step_equation.h"

#define STEPS 3
#define HARMONICS_MOST 4
#define POINTS 12
#define PARAMETERS_MOST 12

/* --- periodic motions ---------------------------------------------------------------------------
 */

typedef struct sizes {
  int64_t rank;
  int32_t harmonics;
} sizes;

/* Every point of a curve is finite, at any phase. */
static bool visit(void *context, const thrum_response_point *point) {
  const sizes *of = context;
  double q[RANK_MOST], p[RANK_MOST];
  must_be_finite(point->coefficients, (2 * of->harmonics + 1) * of->rank);
  const double said[] = {point->omega, point->energy, point->work, point->dissipated, point->tail};
  must_be_finite(said, sizeof said / sizeof said[0]);
  if (thrum_response_kind_name(point->kind) == NULL)
    abort();
  thrum_response_at(of->rank, of->harmonics, point->omega, 1, point->coefficients, q, p);
  must_be_finite(q, of->rank);
  return true;
}

static void use_response(const thrum_model *model, fuzz_draw *draw) {
  const thrum_model *shape = thrum_condensed_shape_model(model);
  double load[RANK_MOST], damping[RANK_MOST];
  thrum_response_def def = thrum_default_response_def();
  draw_vector(draw, shape->rank, 10, load);
  for (int64_t i = 0; i < model->rank; i++)
    damping[i] = draw_above(draw, 1);

  // a backbone, or a forced curve around any frequency
  const bool forced = draw_byte(draw) % 2;
  def.harmonics = (int32_t)draw_index(draw, HARMONICS_MOST + 2);
  def.mode = forced ? -1 : draw_index(draw, model->rank + 1);
  def.from = draw_above(draw, 100);
  def.to = draw_above(draw, 100);
  def.amplitude = draw_above(draw, 1);
  def.points = POINTS;
  def.stability = draw_byte(draw) % 4 == 0;
  def.stability_steps = (int32_t)draw_index(draw, 20);
  def.inertia = draw_byte(draw) % 2;
  def.damping = draw_byte(draw) % 2 ? damping : NULL;
  def.load_cosine = forced ? load : NULL;
  def.periods = 1 + (int32_t)draw_index(draw, 3);
  def.branch = (int32_t)draw_index(draw, 5) - 2;

  thrum_error error = {0};
  size_t size = 0;
  const thrum_status known = thrum_response_size(model, &def, &size, &error);
  fuzz_check(known, &error);
  if (known < 0)
    return;
  void *workspace = block(size);
  sizes of = {model->rank, def.harmonics};
  thrum_response_report report;
  const thrum_status status =
      thrum_response(model, &def, NULL, workspace, size, visit, &of, &report, &error);
  fuzz_check(status, &error);
  if (status >= 0 && thrum_response_end_name(report.end) == NULL)
    abort();
  free(workspace);
}

static void use_normal_form(const thrum_model *model, fuzz_draw *draw) {
  const int64_t mode = draw_index(draw, model->rank + 1);
  thrum_error error = {0};
  size_t size = 0;
  if (thrum_normal_form_size(model, mode, &size, &error) < 0)
    return;
  void *workspace = block(size);
  thrum_normal_form found;
  const thrum_status status =
      thrum_normal_form_find(model, mode, draw_above(draw, 1), workspace, size, &found, &error);
  fuzz_check(status, &error);
  if (status >= 0)
    must_be_finite(found.coefficients, 3);

  // the same of two modes
  thrum_normal_form_pair pair;
  const int64_t modes[2] = {mode, draw_index(draw, model->rank + 1)};
  const thrum_status both = thrum_normal_form_pair_find(
      model, modes, (int32_t)draw_index(draw, 5), (int32_t)draw_index(draw, 5), draw_above(draw, 1),
      workspace, size, &pair, &error);
  fuzz_check(both, &error);
  for (int n = 0; both >= 0 && n < pair.count; n++)
    must_be_finite(&pair.terms[n].coefficient, 1);
  free(workspace);
}

/* --- gradients ----------------------------------------------------------------------------------
 */

/* The equation of the last step, where it has one. */
static void use_equation(const thrum_model *model, const thrum_state *state) {
  double kappa[RANK_MOST], nu[RANK_MOST], damping[RANK_MOST];
  thrum_step_equation equation;
  thrum_error error = {0};
  const thrum_status status =
      thrum_step_equation_get(model, state, &equation, kappa, nu, damping, &error);
  fuzz_check(status, &error);
  if (status < 0)
    return;
  must_be_finite(kappa, model->rank);
  must_be_finite(nu, model->rank);
  must_be_finite(damping, model->rank);
  if (thrum_step_form_name(equation.form) == NULL)
    abort();
}

/* Other moduli and densities of a model that has them. */
static void use_parameters(const thrum_model *model, fuzz_draw *draw) {
  size_t size = 0, work_count = 0;
  thrum_error error = {0};
  fuzz_check(thrum_model_parameters_size(model, &size, &work_count, &error), &error);
  const int64_t count = thrum_model_parameter_count(model);
  if (count == 0 || count > PARAMETERS_MOST)
    return;
  double values[PARAMETERS_MOST], turn[RANK_MOST * RANK_MOST], linear[RANK_MOST * RANK_MOST];
  double mass[RANK_MOST * RANK_MOST];
  double *work = block(work_count * sizeof *work), *c3 = block((size_t)model->c3_count * 8);
  double *c4 = block((size_t)model->c4_count * 8);
  void *memory = block(size);
  const thrum_model *set = NULL;
  fuzz_check(thrum_model_parameters_get(model, values, &error), &error);
  values[draw_index(draw, count)] *= draw_above(draw, 4);
  if (thrum_model_set_parameters(memory, size, model, values, turn, work, &set, &error) >= 0)
    fuzz_check(thrum_model_check(set, &error), &error);
  fuzz_check(thrum_model_parameter_slope(model, draw_index(draw, count + 1), linear, c3, c4, mass,
                                         work, &error),
             &error);
  free(work);
  free(c3);
  free(c4);
  free(memory);
}

/* Derivatives by them. */
static void derive_parameters(const thrum_model *model, thrum_tape *tape, const double *q_bar) {
  double values[PARAMETERS_MOST];
  thrum_parameter_parts *parts = NULL;
  thrum_error error = {0};
  fuzz_check(thrum_parameter_parts_create(model, &parts, &error), &error);
  const int64_t count = thrum_parameter_parts_count(parts);
  thrum_tape_gradient gradient = {
      .parts = thrum_parameter_parts_list(parts), .part = values, .part_count = count};
  if (count > 0 && count <= PARAMETERS_MOST)
    fuzz_check(thrum_tape_pull_back(model, tape, q_bar, NULL, &gradient, &error), &error);
  thrum_parameter_parts_destroy(parts);
}

/* Backward and forward passes over what is on the tape. */
static void derive_run(const thrum_model *model, thrum_tape *tape, fuzz_draw *draw) {
  const int64_t r = model->rank, rows = thrum_tape_steps(tape) + 1;
  double q_bar[(STEPS + 3) * RANK_MOST], p_bar[(STEPS + 3) * RANK_MOST];
  double q[RANK_MOST], p[RANK_MOST], force[(STEPS + 2) * RANK_MOST], damping[RANK_MOST];
  if (thrum_tape_q(tape) != NULL) {
    must_be_finite(thrum_tape_q(tape), rows * r);
    must_be_finite(thrum_tape_p(tape), rows * r);
  }
  double levels[(STEPS + 2) * THRUM_ACTUATORS_MAX];
  draw_vector(draw, rows * r, 1, q_bar);
  draw_vector(draw, rows * r, 1, p_bar);
  derive_parameters(model, tape, q_bar);
  thrum_tape_gradient gradient = {
      .q = q, .p = p, .force = force, .levels = levels, .damping = damping};
  thrum_error error = {0};
  thrum_status status = thrum_tape_pull_back(model, tape, q_bar, p_bar, &gradient, &error);
  fuzz_check(status, &error);
  if (status < 0)
    return;
  must_be_finite(q, r);
  must_be_finite(p, r);
  must_be_finite(force, (rows - 1) * thrum_condensed_shape_model(model)->rank);
  must_be_finite(levels, (rows - 1) * thrum_model_actuators(model));

  // the same numbers as a direction
  fuzz_check(thrum_tape_push_forward(model, tape, &gradient, q_bar, p_bar, &error), &error);
}

/* A step on a plane, which a tape without touches and bodies that it is not for refuse. */
static void step_on_plane(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                          fuzz_draw *draw) {
  thrum_error error = {0};
  size_t size = 0;
  thrum_contact *contact = NULL;
  thrum_contact_def def = thrum_default_contact_def();
  def.stiffness = 1e4;
  thrum_obstacle floor = thrum_default_obstacle();
  floor.restitution = draw_byte(draw) % 2 ? 1.0 : 0.5;
  floor.friction = draw_byte(draw) % 2 ? 0.0 : 0.5;
  const thrum_contact_environment around = {.obstacles = &floor, .obstacle_count = 1};
  const thrum_status sized = thrum_contact_size(model, state, &def, &size, &error);
  fuzz_check(sized, &error);
  if (sized < 0)
    return;
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  if (memory != NULL && thrum_contact_init(memory, size, model, state, &def, &contact, &error) >= 0)
    fuzz_check(thrum_tape_contact_step(model, tape, state, contact, &around, &error), &error);
  free(memory);
  const double calmed = thrum_contact_calm_factor(1e-3, model->omega2[0]);
  must_be_finite(&calmed, 1);
}

/* A batch of one run, on a tape that may be full. */
static void run_alone(const thrum_model *model, thrum_tape *tape, thrum_state *state) {
  thrum_error error = {0};
  thrum_status status = THRUM_OK;
  size_t size = 0;
  fuzz_check(thrum_batch_size(model, &size, &error), &error);
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  const thrum_tape_batch batch = {.model = model,
                                  .tapes = &tape,
                                  .states = &state,
                                  .count = 1,
                                  .statuses = &status,
                                  .workspace = memory,
                                  .workspace_size = size};
  if (memory != NULL)
    fuzz_check(thrum_tape_batch_run(&batch, NULL, 1, NULL, &error), &error);
  free(memory);
}

static void use_tape(const thrum_model *model, fuzz_draw *draw) {
  thrum_state_def def = draw_def(draw, model->rank);
  double q[RANK_MOST], p[RANK_MOST], force[(STEPS + 1) * RANK_MOST];
  double levels[STEPS * THRUM_ACTUATORS_MAX];
  thrum_error error = {0};
  thrum_state *state = NULL;
  thrum_tape *tape = NULL, *second = NULL;
  size_t size = 0;
  thrum_tape_def tape_def = thrum_default_tape_def();
  const int64_t width = thrum_condensed_shape_model(model)->rank;
  fuzz_check(thrum_state_create(model, &def, &state, &error), &error);
  tape_def.steps = STEPS + 1;
  tape_def.checkpoints = draw_index(draw, 4);
  tape_def.state = state;
  tape_def.touches = tape_def.checkpoints > 0 ? 0 : draw_index(draw, 60);
  tape_def.subgradient = (thrum_tape_subgradient)(draw_byte(draw) % 2);
  tape_def.steps++;
  const thrum_status created = thrum_tape_create(model, &tape_def, &tape, &error);
  fuzz_check(created, &error);
  fuzz_check(thrum_tape_size(model, &tape_def, &size, &error), &error);
  void *memory = block(size);
  if (size > 0)
    fuzz_check(thrum_tape_init(memory, size, model, &tape_def, &second, &error), &error);

  draw_vector(draw, model->rank, 0.1, q);
  draw_vector(draw, model->rank, 1, p);
  draw_vector(draw, (STEPS + 1) * width, 10, force);
  if (state != NULL && tape != NULL && thrum_tape_start(model, tape, state, q, p, &error) >= 0) {
    int64_t made = 0;
    fuzz_check(thrum_tape_step(model, tape, state, force, &error), &error);
    use_equation(model, state);
    draw_vector(draw, STEPS * thrum_model_actuators(model), 1e3, levels);
    if (thrum_model_actuators(model) > 0)
      fuzz_check(
          thrum_tape_run_levels(model, tape, state, force + width, levels, STEPS, &made, &error),
          &error);
    else
      fuzz_check(thrum_tape_run(model, tape, state, force + width, STEPS, &made, &error), &error);
    step_on_plane(model, tape, state, draw);
    run_alone(model, tape, state);
    derive_run(model, tape, draw);
  }
  thrum_tape_destroy(tape);
  thrum_state_destroy(state);
  free(memory);
}

static void use_spring(const thrum_model *model, fuzz_draw *draw) {
  double linear[RANK_MOST * RANK_MOST], direction[3];
  thrum_error error = {0};
  const int32_t vertex = (int32_t)draw_index(draw, model->vertex_count + 1);
  draw_vector(draw, 3, 1, direction);
  const thrum_status status = thrum_spring_linear(
      model, &vertex, 1, draw_byte(draw) % 2 ? direction : NULL, linear, &error);
  fuzz_check(status, &error);
  if (status >= 0)
    must_be_finite(linear, model->rank * model->rank);
}

static void use_rest(const thrum_model *model, fuzz_draw *draw) {
  use_parameters(model, draw);
  use_spring(model, draw);
  const size_t r = (size_t)model->rank;
  double q[RANK_MOST], q_bar[RANK_MOST], force_bar[RANK_MOST], stiffness_bar = 0;
  double *work = block((r * (r + 3) + thrum_work_count(model)) * sizeof *work);
  thrum_error error = {0};
  draw_vector(draw, model->rank, 0.1, q);
  draw_vector(draw, model->rank, 1, q_bar);
  const thrum_status status =
      thrum_rest_pull_back(model, q, q_bar, force_bar, &stiffness_bar, work, &error);
  fuzz_check(status, &error);
  if (status >= 0)
    must_be_finite(force_bar, model->rank);
  free(work);
}

/* --- whole loads, and what a failure says -------------------------------------------------------
 */

static void use_whole_load(const thrum_model *model, fuzz_draw *draw) {
  const thrum_model *shape = thrum_condensed_shape_model(model);
  thrum_state_def def = draw_def(draw, model->rank);
  double load[RANK_MOST], reduced[RANK_MOST];
  thrum_error error = {0};
  thrum_state *state = NULL;
  draw_vector(draw, shape->rank, 10, load);
  fuzz_check(thrum_state_create(model, &def, &state, &error), &error);
  for (int n = 0; n < STEPS && state != NULL; n++) {
    const thrum_status status = thrum_state_reduce_load(model, state, load, reduced, &error);
    fuzz_check(status, &error);
    if (status >= 0)
      must_be_finite(reduced, model->rank);
    fuzz_check(thrum_state_set_load(model, state, load, &error), &error);
    fuzz_check(thrum_step(model, state, &error), &error);
  }
  thrum_state_destroy(state);

  // a failure that a field is to blame for has its name, and its reason without it
  thrum_error_set_field(&error, "dt", THRUM_BAD_VALUE, " is %g", draw_any(draw));
  if (strstr(error.message, "dt") != error.message || *thrum_error_reason(&error) == ' ')
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static void (*const uses[])(const thrum_model *, fuzz_draw *) = {
      use_response, use_normal_form, use_tape, use_rest, use_whole_load,
  };
  enum { USES = sizeof uses / sizeof uses[0] };
  if (size < PLAN_BYTES)
    return 0;
  fuzz_draw draw = {data, PLAN_BYTES};
  fuzz_opened opened = fuzz_open(data, size, &draw);
  const unsigned choice = draw_byte(&draw) % USES;
  if (opened.model != NULL && thrum_condensed_shape_model(opened.model)->rank <= RANK_MOST)
    uses[choice](opened.model, &draw);
  fuzz_close(&opened);
  return 0;
}
