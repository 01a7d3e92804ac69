/* A tape: its memory, and the steps that it records (thrum/gradient.h).
 *
 * A tape keeps q and p at the ends of its steps and the force of each, and beside them the few
 * matrices that a pass over it works in. With checkpoints it keeps the state at the start of each
 * segment of steps, and the rows of one segment. The others are stepped again, from the bytes of
 * the state that was there, so that they have the same bits.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/def.h"
#include "gradient/tape_private.h"
#include "thrum/actuation.h"
#include "thrum/batch.h"
#include "thrum/condensed_model.h"
#include "thrum/polynomial.h"

#define MAGIC UINT64_C(0x7468726d74617065)
#define BYTES_MOST (SIZE_MAX / 4)
#define KEPT_ROWS 4 /* of a checkpoint */

/* --- memory ----------------------------------------------------------------------------------- */

void thrum_tape_def_init(thrum_tape_def *def, size_t size) {
  const thrum_tape_def defaults = {.cookie = sizeof(thrum_tape_def), .steps = 1, .every = 1};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

/* Steps of a segment. */
static int64_t segment_length(const thrum_tape_def *def) {
  const int64_t segments = def->checkpoints > 0 ? def->checkpoints : 1;
  return def->steps / segments + (def->steps % segments > 0 ? 1 : 0);
}

/* Bytes of a checkpoint: q and the force on masters before it, q and p there, and what persists of
 * the state. */
static size_t kept_size(const thrum_model *model, const thrum_state *state) {
  return thrum_round_up(KEPT_ROWS * (size_t)model->rank * sizeof(double)) +
         thrum_round_up(thrum_state_kept_bytes(state));
}

static thrum_status check_def(const thrum_model *model, const thrum_tape_def *def,
                              thrum_error *error) {
  if (!model)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL");
  if (!def || !thrum_def_fits(def->cookie, sizeof *def))
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def was not made by thrum_tape_def_init");
  if (model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model's rank is %lld, not 1 to %d",
                           (long long)model->rank, THRUM_RANK_MAX);
  if (def->steps < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a tape of %lld steps: it needs 1 or more", (long long)def->steps);
  if (def->every < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "every %lld steps a row: it is 1 or more",
                           (long long)def->every);
  if (def->touches < 0 || (def->touches > 0 && def->checkpoints > 0) ||
      def->subgradient > THRUM_SUBGRADIENT_FIXED)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld touches and %lld checkpoints: there are 0 or more touches, which "
                           "go without checkpoints, and a subgradient of the list",
                           (long long)def->touches, (long long)def->checkpoints);
  if (def->checkpoints < 0 || (def->checkpoints > 0 && !def->state))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld checkpoints: they are 0 or more, and need the state",
                           (long long)def->checkpoints);

  // what grows with the steps, and with the checkpoints
  const int64_t width = thrum_condensed_shape_model(model)->rank;
  const uint64_t each = (uint64_t)(4 * model->rank + width + 1) * sizeof(double);
  const uint64_t kept = def->checkpoints > 0 ? kept_size(model, def->state) : 1;
  const uint64_t levels = (uint64_t)(thrum_model_actuators(model) + 1) * sizeof(double) +
                          (def->touches > 0 ? sizeof(thrum_contact_step_slopes) : 0);
  if ((uint64_t)def->touches >= BYTES_MOST / sizeof(thrum_contact_slope) ||
      (uint64_t)segment_length(def) >= BYTES_MOST / each ||
      (uint64_t)def->checkpoints >= BYTES_MOST / kept ||
      (uint64_t)def->steps >= BYTES_MOST / levels)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "a tape of %lld steps needs more memory than this machine can address",
                           (long long)def->steps);
  return THRUM_OK;
}

/* The arrays of a tape, by where it points to them: of rank, of width and of rank x rank. */
#define AT(member) offsetof(thrum_tape, member)
static const size_t vectors[] = {
    AT(kappa),          AT(nu),           AT(damping),         AT(start_q),
    AT(start_p),        AT(end_q),        AT(end_p),           AT(step.start.force),
    AT(step.end.force), AT(step.kept),    AT(step.d),          AT(step.middle.force),
    AT(step.mean),      AT(step.sigma_d), AT(step.sigma_q),    AT(step.w),
    AT(step.x),         AT(step.y),       AT(step.part_y),     AT(step.part_start),
    AT(step.part_end),  AT(change[0]),    AT(step.part_kappa), AT(step.part_middle),
    AT(change[1]),      AT(change[2]),    AT(change[3]),       AT(change[4]),
    AT(change[5]),      AT(change[6]),    AT(before_q),        AT(step.unscaled),
    AT(p_end),          AT(pressed),      AT(before_master)};
static const size_t wides[] = {AT(none), AT(wide[0]), AT(wide[1])};
static const size_t matrices[] = {AT(step.start.tangent),  AT(step.end.tangent),
                                  AT(step.middle.tangent), AT(step.jacobian),
                                  AT(step.slope_kappa),    AT(step.slope_kappa_square),
                                  AT(step.slope_damped),   AT(step.slope_damping)};
#define COUNT(list) (sizeof(list) / sizeof(list)[0])

/* Takes `size` bytes, at `memory` or, with NULL, only counted. */
static unsigned char *cut(unsigned char *memory, size_t size, size_t *at) {
  unsigned char *taken = memory ? memory + *at : NULL;
  *at += thrum_round_up(size);
  return taken;
}

static double *cut_doubles(unsigned char *memory, size_t count, size_t *at) {
  return (double *)(void *)cut(memory, count * sizeof(double), at);
}

/* Cuts an array of `doubles` for each pointer of the list. */
static void cut_list(thrum_tape *tape, const size_t *list, size_t count, size_t doubles,
                     unsigned char *memory, size_t *at) {
  for (size_t n = 0; n < count; n++) {
    double *array = cut_doubles(memory, doubles, at);
    memcpy((unsigned char *)tape + list[n], &array, sizeof array);
  }
}

/* Lays the arrays of a tape behind its header; with NULL they are only counted. Returns their end.
 */
static size_t lay(thrum_tape *tape, const thrum_model *model, unsigned char *memory) {
  const size_t r = (size_t)tape->rank, width = (size_t)tape->width;
  const size_t length = (size_t)tape->length, checkpoints = (size_t)tape->checkpoints;
  size_t at = thrum_round_up(sizeof *tape);
  cut_list(tape, vectors, COUNT(vectors), r, memory, &at);
  cut_list(tape, wides, COUNT(wides), width, memory, &at);
  cut_list(tape, matrices, COUNT(matrices), r * r, memory, &at);
  tape->step.work = cut_doubles(memory, thrum_work_count(model), &at);
  tape->level = cut_doubles(memory, (size_t)tape->actuators, &at);
  tape->end_levels = cut_doubles(memory, (size_t)tape->actuators, &at);
  tape->acting = cut_doubles(memory, (size_t)thrum_model_actuation_count(model), &at);
  tape->step.rows = (int32_t *)(void *)cut(memory, r * sizeof(int32_t), &at);

  // the steps
  tape->q = cut_doubles(memory, (length + 1) * r, &at);
  tape->p = cut_doubles(memory, (length + 1) * r, &at);
  tape->half = cut_doubles(memory, length * r, &at);
  tape->force = cut_doubles(memory, checkpoints > 0 ? 0 : length * width, &at);
  tape->master = cut_doubles(memory, tape->follows ? length * r : 0, &at);
  tape->levels = cut_doubles(memory, (size_t)tape->most * (size_t)tape->actuators, &at);
  tape->form = (int32_t *)(void *)cut(memory, length * sizeof(int32_t), &at);
  tape->slopes =
      (thrum_contact_slope *)(void *)cut(memory, (size_t)tape->touches * sizeof *tape->slopes, &at);
  tape->contacts = NULL;
  if (tape->touches > 0)
    tape->contacts = (thrum_contact_step_slopes *)(void *)cut(
        memory, (size_t)tape->most * sizeof *tape->contacts, &at);
  tape->kept = cut(memory, checkpoints * tape->kept_size, &at);
  tape->again = (thrum_state *)(void *)cut(memory, tape->state_size, &at);
  return at;
}

/* The numbers of a tape by its def. */
static thrum_tape numbers_of(const thrum_model *model, const thrum_tape_def *def) {
  const bool kept = def->checkpoints > 0;
  return (thrum_tape){.magic = MAGIC,
                      .most = def->steps,
                      .rank = model->rank,
                      .follows = model->shape != NULL,
                      .width = thrum_condensed_shape_model(model)->rank,
                      .actuators = thrum_model_actuators(model),
                      .length = segment_length(def),
                      .every = def->every,
                      .subgradient = def->subgradient,
                      .touches = def->touches,
                      .checkpoints = def->checkpoints,
                      .kept_size = kept ? kept_size(model, def->state) : 0,
                      .state_size = kept ? thrum_state_bytes(def->state) : 0};
}

thrum_status thrum_tape_size(const thrum_model *model, const thrum_tape_def *def, size_t *size,
                             thrum_error *error) {
  thrum_tape_def own;
  thrum_tape_def_init(&own, sizeof own);
  def = thrum_def_whole(def, &own, sizeof own);
  THRUM_TRY(check_def(model, def, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  thrum_tape counted = numbers_of(model, def);
  *size = lay(&counted, model, NULL);
  return THRUM_OK;
}

thrum_status thrum_tape_init(void *memory, size_t memory_size, const thrum_model *model,
                             const thrum_tape_def *def, thrum_tape **tape, thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_tape_size(model, def, &size, error));
  if (!memory || !tape)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or tape is NULL");
  THRUM_TRY(thrum_alignment_check("tape", memory, memory_size, size, error));

  thrum_tape_def own;
  thrum_tape_def_init(&own, sizeof own);
  thrum_tape *made = memory;
  *made = numbers_of(model, thrum_def_whole(def, &own, sizeof own));
  lay(made, model, memory);
  memset(made->none, 0, (size_t)made->width * sizeof *made->none);
  *tape = made;
  return THRUM_OK;
}

thrum_status thrum_tape_create(const thrum_model *model, const thrum_tape_def *def,
                               thrum_tape **tape, thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_tape_size(model, def, &size, error));
  if (!tape)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "tape is NULL");
  void *memory = aligned_alloc(THRUM_ALIGNMENT, size);
  if (!memory)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "a tape of %lld steps needs %zu bytes",
                           (long long)def->steps, size);
  return thrum_tape_init(memory, size, model, def, tape, error);
}

void thrum_tape_destroy(thrum_tape *tape) {
  free(tape);
}

/* --- recording -------------------------------------------------------------------------------- */

static thrum_status check_made(const thrum_model *model, const thrum_tape *tape,
                               thrum_error *error) {
  if (!model || !tape || tape->magic != MAGIC)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the model is NULL, or the tape was not made by thrum_tape_init");
  if (model->rank != tape->rank || thrum_condensed_shape_model(model)->rank != tape->width ||
      thrum_model_actuators(model) != tape->actuators)
    return thrum_error_set(
        error, THRUM_MODEL_MISMATCH,
        "the tape was made for rank %lld and %lld actuators, the model has rank %lld and %lld",
        (long long)tape->rank, (long long)tape->actuators, (long long)model->rank,
        (long long)thrum_model_actuators(model));
  return THRUM_OK;
}

thrum_status thrum_tape_check(const thrum_model *model, const thrum_tape *tape,
                              thrum_error *error) {
  THRUM_TRY(check_made(model, tape, error));
  if (!tape->started)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the tape is not started: thrum_tape_start starts it");
  if (model->identity != tape->identity)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH, "the tape was started with another model");
  return THRUM_OK;
}

/* Can a run of this state be recorded here? Fills the equation. */
static thrum_status check_state(const thrum_model *model, const thrum_tape *tape,
                                const thrum_state *state, thrum_step_equation *equation,
                                thrum_error *error) {
  THRUM_TRY(check_made(model, tape, error));
  THRUM_TRY(thrum_step_equation_get(model, state, equation, NULL, NULL, NULL, error));
  if (model->shape && equation->damping_beta > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "of a condensed model steps with damping_beta, by which what follows "
                           "drags, have no derivative here");
  if (tape->checkpoints > 0 &&
      (kept_size(model, state) != tape->kept_size || thrum_state_bytes(state) != tape->state_size))
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the state has another size than that of the tape's def");
  return THRUM_OK;
}

/* The checkpoint of a segment: the q before it, q and p at its start, and the state. */
static double *kept_rows(const thrum_tape *tape, int64_t segment) {
  return (double *)(void *)(tape->kept + (size_t)segment * tape->kept_size);
}

static unsigned char *kept_state(const thrum_tape *tape, int64_t segment) {
  return (unsigned char *)kept_rows(tape, segment) +
         thrum_round_up(KEPT_ROWS * (size_t)tape->rank * sizeof(double));
}

/* Keeps the state before step `count`, the first of a segment, whose rows begin anew. */
static void keep_start(thrum_tape *tape, const thrum_state *state) {
  const int64_t r = tape->rank, rows = tape->count - tape->first;
  const size_t vector = (size_t)r * sizeof(double);
  if (rows > 0) {
    memcpy(tape->before_q, tape->q + (rows - 1) * r, vector);
    if (tape->follows)
      memcpy(tape->before_master, tape->master + (rows - 1) * r, vector);
    memmove(tape->q, tape->q + rows * r, vector);
    memmove(tape->p, tape->p + rows * r, vector);
  }
  tape->first = tape->count;
  if (tape->checkpoints == 0)
    return;
  const int64_t segment = tape->count / tape->length;
  double *kept = kept_rows(tape, segment);
  memcpy(kept, tape->before_q, vector);
  memcpy(kept + r, tape->q, vector);
  memcpy(kept + 2 * r, tape->p, vector);
  memcpy(kept + 3 * r, tape->before_master, vector);
  memcpy(kept_state(tape, segment), state, thrum_state_kept_bytes(state));
}

/* Where the tape ends, as the state keeps it. */
static void keep_end(const thrum_model *model, thrum_tape *tape, const thrum_state *state,
                     const thrum_step_equation *equation) {
  const size_t vector = (size_t)tape->rank * sizeof(double);
  memcpy(tape->end_q, equation->q, vector);
  memcpy(tape->end_p, equation->p, vector);
  if (tape->actuators > 0)
    thrum_state_actuation(model, state, tape->end_levels, NULL);
}

thrum_status thrum_tape_start(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                              const double *q, const double *p, thrum_error *error) {
  thrum_step_equation equation;
  THRUM_TRY(check_state(model, tape, state, &equation, error));
  THRUM_TRY(thrum_state_set(model, state, q, p, error));

  // the start is as it was given
  const size_t vector = (size_t)tape->rank * sizeof(double);
  thrum_step_equation_get(model, state, &equation, tape->kappa, tape->nu, tape->damping, NULL);
  for (int64_t i = 0; i < tape->rank; i++) {
    tape->start_q[i] = q ? q[i] : 0.0;
    tape->start_p[i] = p ? p[i] : 0.0;
  }
  memcpy(tape->q, tape->start_q, vector);
  memcpy(tape->p, tape->start_p, vector);
  keep_end(model, tape, state, &equation);
  tape->step.equation = tape->running = equation;
  tape->identity = model->identity;
  tape->count = tape->first = tape->slope_count = 0;
  tape->divided = -1;
  tape->astray = false;
  tape->forces = NULL;
  if (tape->checkpoints > 0)
    memcpy(tape->again, state, tape->state_size);
  keep_start(tape, state);
  tape->started = true;
  return THRUM_OK;
}

/* Steps that were not made by the equation of the state's scheme. */
static int64_t divided_steps(const thrum_state *state) {
  const thrum_state_report report = thrum_state_report_get(state);
  return report.substep_steps + report.energy_steps + report.switched_steps;
}

/* p at the start of step k of verlet, from those in the middle of the steps before and after: the
 * kick is half there, but for a load that jumps. */
static void put_verlet_start(thrum_tape *tape, int64_t k, const double *half_before) {
  const int64_t r = tape->rank, row = k - tape->first;
  const double h = tape->step.equation.dt, *half = tape->half + row * r;
  const thrum_made_step made = thrum_tape_made(tape, k);
  const double *force = made.force, *force_before = made.force_before;
  double *p = tape->p + row * r;
  for (int64_t i = 0; i < r; i++)
    p[i] = 0.5 * (half_before[i] + half[i]) +
           0.25 * h * (force_before[i] - force[i]) / (1.0 + 0.5 * h * tape->damping[i]);
  if (row == 0 && tape->checkpoints > 0)
    memcpy(kept_rows(tape, k / tape->length) + 2 * r, p, (size_t)r * sizeof *p);
}

/* How a step is made: with contact, or with levels (NULL: those of the state); `seen`: as of
 * make_step. */
typedef struct step_maker {
  thrum_contact *contact;
  const thrum_contact_environment *environment;
  const double *levels;
  bool seen, goes_on; /* goes_on: from the step before, in one call */
} step_maker;

static thrum_status take_step(const thrum_model *model, thrum_state *state, const double *force,
                              const step_maker *by, thrum_error *error) {
  if (by->contact)
    return thrum_contact_step(model, state, by->contact, by->environment, error);
  THRUM_TRY(thrum_state_set_load(model, state, force, error));
  return thrum_step(model, state, error);
}

/* Reads the contact of step k, whose rows are there. */
static thrum_status keep_contact(const thrum_model *model, thrum_tape *tape, int64_t k,
                                 const step_maker *by, const thrum_contact_report *before,
                                 thrum_error *error) {
  thrum_contact_step_slopes *of = tape->contacts + k;
  *of = (thrum_contact_step_slopes){.first = tape->slope_count};
  if (!by->contact)
    return THRUM_OK;
  const thrum_made_step made = thrum_tape_made(tape, k);
  thrum_tape_prepare(model, tape);
  tape->step.equation.form = (thrum_step_form)tape->form[k - tape->first];
  if (!thrum_contact_slopes_read(&tape->step, &made, tape->force + k * tape->width, by->contact,
                                 by->environment, tape->slopes + tape->slope_count,
                                 tape->touches - tape->slope_count, of))
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "step %lld was made, and the tape has no room for what touches in it: "
                           "give its def more touches than %lld",
                           (long long)k, (long long)tape->touches);
  const thrum_contact_report after = thrum_contact_report_get(by->contact);
  const bool again = after.redone > before->redone || after.declined > before->declined;
  if (again && of->kind == THRUM_ROUGH_NONE)
    of->kind = THRUM_ROUGH_AGAIN;
  tape->slope_count += of->count;
  return THRUM_OK;
}

/* Before a step: what is known no more after it. */
static void enter_step(thrum_tape *tape, const thrum_state *state) {
  tape->divided_before = divided_steps(state);
  memcpy(tape->step.w, tape->running.p, (size_t)tape->rank * sizeof(double));
}

/* Puts the end of step k, which was made, and its form into their rows. The p that verlet has at
 * the end takes a force: without `seen` it is left to the next step, unless levels or touches
 * change the forces between them. Of energy the form is that of the step. */
static thrum_status leave_step(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                               int64_t k, const double *force, bool seen, thrum_error *error) {
  thrum_step_equation *equation = &tape->running;
  const int64_t r = tape->rank, row = k - tape->first;
  const size_t vector = (size_t)r * sizeof(double);
  const bool verlet = equation->form == THRUM_STEP_VERLET;
  const bool halves = verlet && tape->actuators == 0 && !tape->contacts;
  const double *half_before = tape->step.w;

  // where it led, and by which equation
  double *q = tape->q + (row + 1) * r, *p = tape->p + (row + 1) * r;
  memcpy(q, equation->q, vector);
  if (!verlet)
    memcpy(p, equation->p, vector);
  else if (seen || !halves)
    THRUM_TRY(thrum_state_get(model, state, NULL, p, error));
  if (equation->form == THRUM_STEP_TRAPEZOID || equation->form == THRUM_STEP_AVERAGE)
    THRUM_TRY(thrum_step_equation_get(model, state, equation, NULL, NULL, NULL, error));
  tape->form[row] = (int32_t)equation->form;
  if (tape->divided < 0 && divided_steps(state) > tape->divided_before)
    tape->divided = k;

  double *own = tape->checkpoints > 0 ? NULL : tape->force + k * tape->width;
  for (int64_t i = 0; own && i < tape->width; i++)
    own[i] = force ? force[i] : 0.0;
  if (verlet && tape->follows) {
    thrum_tape_ahead(tape, k, tape->step.x);
    thrum_condensed_load(model, tape->step.x, thrum_tape_force(tape, k), tape->master + row * r);
  }
  if (verlet) {
    memcpy(tape->half + row * r, equation->p, vector);
    if (k > 0 && halves)
      put_verlet_start(tape, k, half_before);
  }
  return THRUM_OK;
}

/* Makes step k from where the state is, and keeps it. */
static thrum_status make_step(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                              int64_t k, const double *force, const step_maker *by,
                              thrum_error *error) {
  thrum_contact_report before = {0};
  if (by->contact)
    before = thrum_contact_report_get(by->contact);
  enter_step(tape, state);
  const thrum_status status = take_step(model, state, force, by, error);
  THRUM_TRY(status);
  THRUM_TRY(leave_step(model, tape, state, k, force, by->seen, error));
  if (tape->contacts)
    THRUM_TRY(keep_contact(model, tape, k, by, &before, error));
  return status;
}

thrum_status thrum_tape_reach(const thrum_model *model, thrum_tape *tape, int64_t k,
                              thrum_error *error) {
  const int64_t segment = k / tape->length, r = tape->rank;
  if (tape->first == segment * tape->length && !tape->astray)
    return THRUM_OK;

  // from the state that was kept
  const double *kept = kept_rows(tape, segment);
  const size_t vector = (size_t)r * sizeof(double);
  memcpy(tape->before_q, kept, vector);
  memcpy(tape->q, kept + r, vector);
  memcpy(tape->p, kept + 2 * r, vector);
  memcpy(tape->before_master, kept + 3 * r, vector);
  memcpy(tape->again, kept_state(tape, segment), thrum_state_kept_bytes(tape->again));
  tape->first = segment * tape->length;
  tape->astray = true;
  const int64_t end = tape->first + tape->length;
  THRUM_TRY(thrum_step_equation_get(model, tape->again, &tape->running, NULL, NULL, NULL, error));
  for (int64_t n = tape->first; n < tape->count && n < end; n++) {
    const double *force = tape->forces ? thrum_tape_force(tape, n) : NULL;
    if (tape->actuators > 0)
      THRUM_TRY(thrum_state_set_actuation(model, tape->again, thrum_tape_levels(tape, n), error));
    const step_maker by = {.seen = n + 1 == tape->count};
    THRUM_TRY(make_step(model, tape, tape->again, n, force, &by, error));
  }

  // its end is the start of the next, to the bit if the forces are those of the run
  const int64_t rows = (end < tape->count ? end : tape->count) - tape->first;
  const double *led = end < tape->count ? kept_rows(tape, segment + 1) + r : tape->end_q;
  if (memcmp(tape->q + rows * r, led, vector) != 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "stepped again, step %lld ends elsewhere: the forces that a tape with "
                           "checkpoints reads again have been changed since the run",
                           (long long)(tape->first + rows));
  if (end < tape->count)
    memcpy(tape->p + tape->length * r, kept_rows(tape, segment + 1) + 2 * r, vector);
  tape->astray = false;
  return THRUM_OK;
}

const double *thrum_tape_force(const thrum_tape *tape, int64_t k) {
  const double *rows = tape->checkpoints > 0 ? tape->forces : tape->force;
  return k < 0 || !rows ? tape->none : rows + k * tape->width;
}

const double *thrum_tape_master(const thrum_tape *tape, int64_t k) {
  if (k < 0)
    return tape->none;
  return k < tape->first ? tape->before_master : tape->master + (k - tape->first) * tape->rank;
}

thrum_made_step thrum_tape_made(const thrum_tape *tape, int64_t k) {
  const int64_t r = tape->rank, row = k - tape->first;
  const bool masters = tape->follows && tape->step.equation.form == THRUM_STEP_VERLET;
  return (thrum_made_step){
      .q = tape->q + row * r,
      .p = tape->p + row * r,
      .q_next = tape->q + (row + 1) * r,
      .p_next = tape->p + (row + 1) * r,
      .half = tape->half + row * r,
      .force = masters ? thrum_tape_master(tape, k) : thrum_tape_force(tape, k),
      .force_before = masters ? thrum_tape_master(tape, k - 1) : thrum_tape_force(tape, k - 1)};
}

void thrum_tape_prepare(const thrum_model *model, thrum_tape *tape) {
  thrum_linear_step *step = &tape->step;
  step->model = model;
  step->rank = tape->rank;
  step->kappa = tape->kappa;
  step->nu = tape->nu;
  step->damping = tape->damping;
}

void thrum_tape_ahead(const thrum_tape *tape, int64_t k, double *to) {
  const int64_t r = tape->rank, row = k - tape->first;
  const double *at = tape->q + row * r, *before = row > 0 ? at - r : tape->before_q;
  for (int64_t i = 0; i < r; i++)
    to[i] = k > 0 ? 1.5 * at[i] - 0.5 * before[i] : at[i];
}

/* Have the levels of the state been changed since the last step? Its levels come into tape->level.
 */
static bool has_moved_levels(const thrum_model *model, const thrum_tape *tape,
                             const thrum_state *state) {
  if (tape->actuators == 0 || thrum_state_actuation(model, state, tape->level, NULL) < 0)
    return false;
  return memcmp(tape->level, tape->end_levels, (size_t)tape->actuators * sizeof(double)) != 0;
}

/* Is the state where the tape ends? Another one, or one that was stepped elsewhere, is not. Other
 * levels move the p that verlet keeps. */
static thrum_status check_place(const thrum_model *model, const thrum_tape *tape,
                                const thrum_state *state, const thrum_step_equation *equation,
                                thrum_error *error) {
  const size_t vector = (size_t)tape->rank * sizeof(double);
  const bool moved = equation->form == THRUM_STEP_VERLET && has_moved_levels(model, tape, state);
  if (memcmp(equation->q, tape->end_q, vector) != 0 ||
      (!moved && memcmp(equation->p, tape->end_p, vector) != 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the state is not where step %lld of the tape ended: a tape has the "
                           "steps of one state, and all of them",
                           (long long)tape->count);
  return THRUM_OK;
}

/* With checkpoints: is the force of the next step the row of the array behind those before? */
static thrum_status check_row(thrum_tape *tape, const double *force, thrum_error *error) {
  if (tape->checkpoints == 0)
    return THRUM_OK;
  if (tape->count == 0)
    tape->forces = force;
  const double *next = tape->forces ? tape->forces + tape->count * tape->width : NULL;
  if (force != next)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the force of step %lld does not stand behind that of the step before: "
                           "a tape with checkpoints reads one array of them again",
                           (long long)tape->count);
  return THRUM_OK;
}

/* Is the state where the tape ends, with steps as they were? Fills its equation. */
static thrum_status check_state_now(const thrum_model *model, const thrum_tape *tape,
                                    const thrum_state *state, thrum_step_equation *equation,
                                    thrum_error *error) {
  THRUM_TRY(thrum_step_equation_get(model, state, equation, NULL, NULL, NULL, error));
  if (equation->dt != tape->step.equation.dt)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "dt was changed from %g to %g s; all steps of a tape have one",
                           tape->step.equation.dt, equation->dt);
  return check_place(model, tape, state, equation, error);
}

/* All of thrum_tape_step up to the step. */
static thrum_status prepare(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                            const double *force, const step_maker *by, thrum_error *error) {
  if (tape->count == tape->most)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL, "the tape is full after %lld steps",
                           (long long)tape->most);

  // a pass may have brought another segment
  if (tape->count > 0)
    THRUM_TRY(thrum_tape_reach(model, tape, tape->count - 1, error));
  if (!by->goes_on)
    THRUM_TRY(check_state_now(model, tape, state, &tape->running, error));
  THRUM_TRY(check_row(tape, force, error));
  if (by->levels)
    THRUM_TRY(thrum_state_set_actuation(model, state, by->levels, error));
  if (tape->actuators > 0)
    THRUM_TRY(thrum_state_actuation(model, state, thrum_tape_levels(tape, tape->count), error));

  // and the last one may be full
  if (tape->count == tape->first + tape->length)
    keep_start(tape, state);
  return THRUM_OK;
}

/* thrum_tape_step, made so. */
static thrum_status record(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                           const double *force, const step_maker *by, thrum_error *error) {
  THRUM_TRY(prepare(model, tape, state, force, by, error));
  const thrum_status status = make_step(model, tape, state, tape->count, force, by, error);
  THRUM_TRY(status);
  tape->count++;
  return status;
}

/* One step alone. */
static thrum_status record_one(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                               const double *force, const step_maker *by, thrum_error *error) {
  const thrum_status status = record(model, tape, state, force, by, error);
  if (status >= 0)
    keep_end(model, tape, state, &tape->running);
  return status;
}

thrum_status thrum_tape_step(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                             const double *force, thrum_error *error) {
  THRUM_TRY(thrum_tape_check(model, tape, error));
  return record_one(model, tape, state, force, &(step_maker){.seen = true}, error);
}

/* Can steps in these surroundings be differentiated? */
static thrum_status check_contact(const thrum_model *model, const thrum_tape *tape,
                                  const thrum_contact *contact,
                                  const thrum_contact_environment *environment,
                                  thrum_error *error) {
  if (!contact || !environment || !tape->contacts)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the contact or the environment is NULL, or the tape's def has no "
                           "touches");
  if (environment->translation || environment->rigid_frame || environment->inertia ||
      environment->pull_count > 0 || model->shape || tape->actuators > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "steps with contact have a derivative of a body that is held and not "
                           "condensed, without pulls and actuators");
  for (int64_t n = 0; n < environment->obstacle_count; n++) {
    const thrum_obstacle *obstacle = environment->obstacles + n;
    if (obstacle->shape == THRUM_OBSTACLE_SPHERE)
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "obstacle %lld is a sphere: planes and boxes have a derivative here",
                             (long long)n);
    if (tape->step.equation.form == THRUM_STEP_NEWMARK &&
        (obstacle->restitution < 1.0 || obstacle->friction > 0.0))
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "obstacle %lld takes energy, of which steps of newmark have no "
                             "derivative: take energy, midpoint or verlet",
                             (long long)n);
  }
  return THRUM_OK;
}

thrum_status thrum_tape_contact_step(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                                     thrum_contact *contact,
                                     const thrum_contact_environment *environment,
                                     thrum_error *error) {
  THRUM_TRY(thrum_tape_check(model, tape, error));
  THRUM_TRY(check_contact(model, tape, contact, environment, error));
  const step_maker by = {.contact = contact, .environment = environment, .seen = true};
  return record_one(model, tape, state, environment->load, &by, error);
}

thrum_status thrum_tape_run(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                            const double *force, int64_t count, int64_t *made, thrum_error *error) {
  return thrum_tape_run_levels(model, tape, state, force, NULL, count, made, error);
}

thrum_status thrum_tape_run_levels(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                                   const double *force, const double *levels, int64_t count,
                                   int64_t *made, thrum_error *error) {
  THRUM_TRY(thrum_tape_check(model, tape, error));
  if (count < 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the number of steps is %lld; it must be 0 or more", (long long)count);
  thrum_status worst = THRUM_OK;
  int64_t done = 0;
  while (done < count && worst >= 0) {
    const double *row = force ? force + done * tape->width : NULL;
    const step_maker by = {.levels = levels ? levels + done * tape->actuators : NULL,
                           .seen = done + 1 == count,
                           .goes_on = done > 0};
    const thrum_status status = record(model, tape, state, row, &by, error);
    done += status >= 0 ? 1 : 0;

    // the smaller of two notable statuses is the more notable
    if (status < 0 || (status > 0 && (worst == THRUM_OK || status < worst)))
      worst = status;
  }
  if (done > 0)
    keep_end(model, tape, state, &tape->running);

  // a run that fails ends where the step before has
  if (worst < 0 && done > 0)
    THRUM_TRY(thrum_state_get(model, state, NULL,
                              tape->p + (tape->count - tape->first) * tape->rank, error));
  if (made)
    *made = done;
  return worst;
}

/* --- many runs side by side ------------------------------------------------------------------- */

/* Step k of the call, of all runs. */
static thrum_status batch_step(const thrum_tape_batch *batch, int64_t k, int64_t steps,
                               const double *force, thrum_error *error) {
  const thrum_model *model = batch->model;
  const step_maker by = {.seen = k + 1 == steps, .goes_on = k > 0};
  for (int64_t n = 0; n < batch->count; n++) {
    thrum_tape *tape = batch->tapes[n];
    const double *row = force ? force + (n * steps + k) * tape->width : NULL;
    THRUM_TRY(prepare(model, tape, batch->states[n], row, &by, error));
    THRUM_TRY(thrum_state_set_load(model, batch->states[n], row, error));
  }

  // none of them fails on its way to the step
  for (int64_t n = 0; n < batch->count; n++)
    enter_step(batch->tapes[n], batch->states[n]);
  thrum_status status = thrum_batch_step(model, batch->states, batch->count, batch->statuses,
                                         batch->workspace, batch->workspace_size, error);
  for (int64_t n = 0; n < batch->count; n++) {
    thrum_tape *tape = batch->tapes[n];
    const double *row = force ? force + (n * steps + k) * tape->width : NULL;
    if (batch->statuses[n] < 0)
      continue;
    const bool seen = by.seen || status < 0;
    const thrum_status kept =
        leave_step(model, tape, batch->states[n], tape->count, row, seen, error);
    if (kept < 0 && status >= 0)
      status = kept;
    tape->count++;
  }
  return status;
}

static thrum_status check_batch(const thrum_tape_batch *batch, int64_t steps, thrum_error *error) {
  if (!batch || !batch->model || !batch->tapes || !batch->states || !batch->statuses ||
      batch->count < 1 || steps < 0)
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "a batch has a model, tapes, states and statuses, 1 or more of them, and "
        "makes 0 or more steps");
  for (int64_t n = 0; n < batch->count; n++) {
    THRUM_TRY(thrum_tape_check(batch->model, batch->tapes[n], error));
    batch->statuses[n] = -1;
  }
  return THRUM_OK;
}

thrum_status thrum_tape_batch_run(const thrum_tape_batch *batch, const double *force, int64_t steps,
                                  int64_t *made, thrum_error *error) {
  THRUM_TRY(check_batch(batch, steps, error));
  thrum_status worst = THRUM_OK;
  int64_t done = 0;
  while (done < steps && worst >= 0) {
    const thrum_status status = batch_step(batch, done, steps, force, error);
    done += status >= 0 ? 1 : 0;
    if (status < 0 || (status > 0 && (worst == THRUM_OK || status < worst)))
      worst = status;
  }
  for (int64_t n = 0; n < batch->count; n++) {
    thrum_tape *tape = batch->tapes[n];

    // one that has made no step ends where it did, and not where its state may be now
    if (done == 0 && batch->statuses[n] < 0)
      continue;
    keep_end(batch->model, tape, batch->states[n], &tape->running);
    if (worst < 0)
      THRUM_TRY(thrum_state_get(batch->model, batch->states[n], NULL,
                                tape->p + (tape->count - tape->first) * tape->rank, error));
  }
  if (made)
    *made = done;
  return worst;
}

int64_t thrum_tape_steps(const thrum_tape *tape) {
  return tape ? tape->count : 0;
}

const double *thrum_tape_q(const thrum_tape *tape) {
  return tape && tape->checkpoints == 0 ? tape->q : NULL;
}

const double *thrum_tape_p(const thrum_tape *tape) {
  return tape && tape->checkpoints == 0 ? tape->p : NULL;
}
