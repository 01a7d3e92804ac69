/* A tape: its memory, and the steps that it records (thrum/gradient.h).
 *
 * A tape keeps q and p at the ends of its steps and the force of each, and beside them the few
 * matrices that a pass over it works in.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <stdlib.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "gradient/tape_private.h"
#include "thrum/polynomial.h"

#define MAGIC UINT64_C(0x7468726d74617065)
#define BYTES_MOST (SIZE_MAX / 4)

/* --- memory ----------------------------------------------------------------------------------- */

static thrum_status check_sizes(const thrum_model *model, int64_t steps, thrum_error *error) {
  if (!model)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL");
  if (model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model's rank is %lld, not 1 to %d",
                           (long long)model->rank, THRUM_RANK_MAX);
  if (steps < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a tape of %lld steps: it needs 1 or more", (long long)steps);
  const uint64_t each = 5 * (uint64_t)model->rank * sizeof(double);
  if ((uint64_t)steps >= BYTES_MOST / each)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "a tape of %lld steps needs more memory than this machine can address",
                           (long long)steps);
  return THRUM_OK;
}

/* The arrays of a tape behind its header; with NULL they are only counted. Returns their end. */
static size_t lay(thrum_tape *tape, const thrum_model *model, int64_t steps,
                  unsigned char *memory) {
  const size_t r = (size_t)model->rank, points = (size_t)steps + 1;
  thrum_linear_step *s = &tape->step;
  struct {
    double **array;
    size_t count;
  } const arrays[] = {{&tape->kappa, r},
                      {&tape->nu, r},
                      {&tape->damping, r},
                      {&tape->q, points * r},
                      {&tape->p, points * r},
                      {&tape->force, points * r},
                      {&tape->force_bar, points * r},
                      {&tape->end_q, r},
                      {&tape->end_p, r},
                      {&s->start.force, r},
                      {&s->start.tangent, r * r},
                      {&s->end.force, r},
                      {&s->end.tangent, r * r},
                      {&s->middle.force, r},
                      {&s->middle.tangent, r * r},
                      {&s->jacobian, r * r},
                      {&s->work, thrum_work_count(model)},
                      {&s->kept, r},
                      {&s->d, r},
                      {&s->mean, r},
                      {&s->sigma_d, r},
                      {&s->sigma_q, r},
                      {&s->w, r},
                      {&s->x, r},
                      {&s->y, r},
                      {&s->slope_kappa, r * r},
                      {&s->slope_kappa_square, r * r},
                      {&s->slope_damped, r * r},
                      {&s->slope_damping, r * r},
                      {&s->part_start, r},
                      {&s->part_middle, r},
                      {&s->part_end, r},
                      {&s->part_kappa, r},
                      {&s->part_y, r},
                      {&tape->change[0], r},
                      {&tape->change[1], r},
                      {&tape->change[2], r},
                      {&tape->change[3], r},
                      {&tape->change[4], r},
                      {&tape->change[5], r}};

  size_t at = thrum_round_up(sizeof *tape);
  for (size_t n = 0; n < sizeof arrays / sizeof arrays[0]; n++) {
    *arrays[n].array = memory ? (double *)(void *)(memory + at) : NULL;
    at += thrum_round_up(arrays[n].count * sizeof(double));
  }
  tape->form = memory ? (int32_t *)(void *)(memory + at) : NULL;
  at += thrum_round_up(points * sizeof(int32_t));
  s->rows = memory ? (int32_t *)(void *)(memory + at) : NULL;
  return at + thrum_round_up(r * sizeof(int32_t));
}

thrum_status thrum_tape_size(const thrum_model *model, int64_t steps, size_t *size,
                             thrum_error *error) {
  THRUM_TRY(check_sizes(model, steps, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  thrum_tape counted;
  *size = lay(&counted, model, steps, NULL);
  return THRUM_OK;
}

thrum_status thrum_tape_init(void *memory, size_t memory_size, const thrum_model *model,
                             int64_t steps, thrum_tape **tape, thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_tape_size(model, steps, &size, error));
  if (!memory || !tape)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or tape is NULL");
  THRUM_TRY(thrum_alignment_check("tape", memory, memory_size, size, error));

  thrum_tape *made = memory;
  memset(made, 0, sizeof *made);
  made->magic = MAGIC;
  made->most = steps;
  made->rank = model->rank;
  lay(made, model, steps, memory);
  *tape = made;
  return THRUM_OK;
}

thrum_status thrum_tape_create(const thrum_model *model, int64_t steps, thrum_tape **tape,
                               thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_tape_size(model, steps, &size, error));
  if (!tape)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "tape is NULL");
  void *memory = aligned_alloc(THRUM_ALIGNMENT, size);
  if (!memory)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "a tape of %lld steps needs %zu bytes",
                           (long long)steps, size);
  return thrum_tape_init(memory, size, model, steps, tape, error);
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
  if (model->rank != tape->rank)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the tape was made for rank %lld, the model has rank %lld",
                           (long long)tape->rank, (long long)model->rank);
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

thrum_status thrum_tape_start(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                              const double *q, const double *p, thrum_error *error) {
  THRUM_TRY(check_made(model, tape, error));
  thrum_step_equation equation;
  THRUM_TRY(thrum_step_equation_get(model, state, &equation, NULL, NULL, NULL, error));
  THRUM_TRY(thrum_state_set(model, state, q, p, error));

  // the start is as it was given
  const size_t vector = (size_t)tape->rank * sizeof(double);
  thrum_step_equation_get(model, state, &equation, tape->kappa, tape->nu, tape->damping, NULL);
  thrum_state_get(model, state, tape->end_q, tape->end_p, NULL);
  for (int64_t i = 0; i < tape->rank; i++) {
    tape->q[i] = q ? q[i] : 0.0;
    tape->p[i] = p ? p[i] : 0.0;
  }
  memset(tape->force, 0, vector);
  tape->step.equation = equation;
  tape->identity = model->identity;
  tape->count = 0;
  tape->started = true;
  return THRUM_OK;
}

/* Steps that were not made by the equation of the state's scheme. */
static int64_t divided_steps(const thrum_state *state) {
  const thrum_state_report report = thrum_state_report_get(state);
  return report.substep_steps + report.energy_steps + report.switched_steps;
}

/* Is the state where the tape ends? Another one, or one that was stepped elsewhere, is not. */
static thrum_status check_place(const thrum_model *model, const thrum_tape *tape,
                                thrum_state *state, thrum_error *error) {
  const size_t vector = (size_t)tape->rank * sizeof(double);
  THRUM_TRY(thrum_state_get(model, state, tape->change[0], tape->change[1], error));
  if (memcmp(tape->change[0], tape->end_q, vector) != 0 ||
      memcmp(tape->change[1], tape->end_p, vector) != 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the state is not where step %lld of the tape ended: a tape has the "
                           "steps of one state, and all of them",
                           (long long)tape->count);
  return THRUM_OK;
}

thrum_status thrum_tape_step(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                             const double *force, thrum_error *error) {
  THRUM_TRY(thrum_tape_check(model, tape, error));
  thrum_step_equation equation;
  THRUM_TRY(thrum_step_equation_get(model, state, &equation, NULL, NULL, NULL, error));
  if (tape->count == tape->most)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL, "the tape is full after %lld steps",
                           (long long)tape->most);
  if (equation.dt != tape->step.equation.dt)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "dt was changed from %g to %g s; all steps of a tape have one",
                           tape->step.equation.dt, equation.dt);

  THRUM_TRY(check_place(model, tape, state, error));
  const int64_t divided = divided_steps(state);
  THRUM_TRY(thrum_state_set_force(model, state, force, error));
  const thrum_status status = thrum_step(model, state, error);
  THRUM_TRY(status);

  // where it led, and by which equation
  const int64_t r = tape->rank, next = tape->count + 1;
  THRUM_TRY(thrum_state_get(model, state, tape->q + next * r, tape->p + next * r, error));
  THRUM_TRY(thrum_step_equation_get(model, state, &equation, NULL, NULL, NULL, error));
  memcpy(tape->end_q, tape->q + next * r, (size_t)r * sizeof(double));
  memcpy(tape->end_p, tape->p + next * r, (size_t)r * sizeof(double));
  for (int64_t i = 0; i < r; i++)
    tape->force[next * r + i] = force ? force[i] : 0.0;
  tape->form[tape->count] =
      divided_steps(state) > divided ? THRUM_TAPE_DIVIDED : (int32_t)equation.form;
  tape->count = next;
  return status;
}

thrum_status thrum_tape_run(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                            const double *force, int64_t count, int64_t *made, thrum_error *error) {
  THRUM_TRY(thrum_tape_check(model, tape, error));
  if (count < 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the number of steps is %lld; it must be 0 or more", (long long)count);
  thrum_status worst = THRUM_OK;
  int64_t done = 0;
  while (done < count && worst >= 0) {
    const double *row = force ? force + done * tape->rank : NULL;
    const thrum_status status = thrum_tape_step(model, tape, state, row, error);
    done += status >= 0 ? 1 : 0;

    // the smaller of two notable statuses is the more notable
    if (status < 0 || (status > 0 && (worst == THRUM_OK || status < worst)))
      worst = status;
  }
  if (made)
    *made = done;
  return worst;
}

int64_t thrum_tape_steps(const thrum_tape *tape) {
  return tape ? tape->count : 0;
}

const double *thrum_tape_q(const thrum_tape *tape) {
  return tape ? tape->q : NULL;
}

const double *thrum_tape_p(const thrum_tape *tape) {
  return tape ? tape->p : NULL;
}
