/* Runs of bases, and their errors. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "driver/run/condensed_check.h"
#include "platform/clock.h"
#include "thrum/external_load.h"
#include "validation/tradeoff/tradeoff_private.h"

typedef struct taker {
  tradeoff_samples *samples;
  int64_t rank;
  double energy_from, energy_to;
} taker;

static void take(void *context, int64_t index, double share, const double *value) {
  const taker *t = context;
  const size_t bytes = (size_t)t->rank * sizeof *value;
  memcpy(t->samples->q + index * t->rank, value, bytes);
  memcpy(t->samples->p + index * t->rank, value + t->rank, bytes);
  t->samples->energy[index] = (1 - share) * t->energy_from + share * t->energy_to;
}

/* Where the condensed coordinates stand, and the load that acts on those that follow. */
typedef struct follower {
  const tradeoff_space *space;
  bool condensed;
  condensed_check check;
  double x[2 * THRUM_RANK_MAX]; /* masters, and their velocities */
  double load[THRUM_RANK_MAX];  /* of the last step, on all coordinates */
} follower;

/* q and p of all coordinates after a step. */
static thrum_status read_shape(follower *f, thrum_state *state, double *q) {
  const tradeoff_space *space = f->space;
  const int64_t count = space->stepped->rank;
  if (!f->condensed)
    return thrum_state_get(space->stepped, state, q, q + count, NULL);

  THRUM_TRY(thrum_state_get(space->stepped, state, f->x, f->x + THRUM_RANK_MAX, NULL));
  thrum_condensed_shape(space->stepped, f->x, f->load, q);
  thrum_condensed_velocity(space->stepped, f->x, f->x + THRUM_RANK_MAX, q + space->shape->rank);
  return THRUM_OK;
}

/* The steps; those are timed with their load, and not the sampling. */
static int64_t step_all(follower *f, const tradeoff_view *view, const thrum_state_def *def,
                        thrum_state *state, tradeoff_samples *samples, double *spent) {
  const full_motion_script *script = view->script;
  const int64_t rank = f->space->shape->rank, steps = thrum_step_count(script->time, def->dt);
  const int64_t look = steps / TRADEOFF_SAMPLES + 1;
  double from[2 * THRUM_RANK_MAX] = {0}, to[2 * THRUM_RANK_MAX], work[2 * THRUM_RANK_MAX];
  taker t = {samples, rank, 0, 0};

  // the first step begins where the body starts, with what follows at rest
  memcpy(from, view->start, (size_t)rank * sizeof *from);
  if (thrum_state_set(f->space->stepped, state, from, NULL, NULL) < 0)
    return 0;

  for (int64_t k = 0; k < steps; k++) {
    thrum_energies energies;
    const double began = clock_thread_seconds();
    thrum_load_sum(script->courses, view->directions, script->load_count, rank, k, def->dt,
                   f->load);
    if (full_motion_reduced_base(f->space->shape, script, k, def->dt, f->load, NULL) < 0 ||
        thrum_state_set_load(f->space->stepped, state, f->load, NULL) < 0 ||
        thrum_step(f->space->stepped, state, NULL) < 0)
      return k;
    *spent += clock_thread_seconds() - began;
    if (read_shape(f, state, to) < 0 ||
        thrum_state_energies(f->space->stepped, state, &energies, NULL) < 0)
      return k;
    condensed_check_vibrate(&f->check, f->load, NULL, def->dt, f->x);

    // how far a condensed run can be believed is asked about as often as there are samples
    if (f->condensed && k % look == 0)
      condensed_check_look(&f->check, f->x, f->x + THRUM_RANK_MAX, energies.potential);
    t.energy_to = energies.total;
    full_motion_between(script->time, TRADEOFF_SAMPLES, (double)k * def->dt, def->dt, rank, from,
                        to, take, &t, work);
    memcpy(from, to, sizeof from);
    t.energy_from = t.energy_to;
  }
  return steps;
}

thrum_status tradeoff_step(const tradeoff_space *space, const tradeoff_view *view,
                           const thrum_state_def *def, tradeoff_samples *samples,
                           tradeoff_pass *pass, thrum_error *error) {
  follower f = {.space = space, .condensed = space->stepped != space->shape};
  thrum_state *state = NULL;
  thrum_status status = thrum_state_create(space->stepped, def, &state, error);
  if (f.condensed)
    THRUM_THEN(status, condensed_check_open(space->stepped, &f.check, error));
  condensed_check_damp(&f.check, def, 1);

  if (status >= 0) {
    double spent = 0;
    const int64_t taken = step_all(&f, view, def, state, samples, &spent);
    pass->seconds = spent / (double)(taken > 0 ? taken : 1);
    pass->whole = taken == thrum_step_count(view->script->time, def->dt);
    const thrum_state_report report = thrum_state_report_get(state);
    pass->fallback_steps = report.newton_steps + report.energy_steps + report.substep_steps;
    pass->grew = report.grown_steps > 0;
    simulate_figures figures = {0};
    condensed_check_report(&f.check, space->stepped, &figures);
    pass->believed =
        !f.condensed || simulate_condensed_believed(figures.inertia_share, figures.energy_defect,
                                                    figures.vibration_share, figures.impact_share);
  }
  condensed_check_close(&f.check);
  thrum_state_destroy(state);
  return status;
}

static double squares(const double *x, int64_t count) {
  double sum = 0;
  for (int64_t i = 0; i < count; i++)
    sum += x[i] * x[i];
  return sum;
}

tradeoff_errors tradeoff_against_full(const tradeoff_view *view, int64_t rank,
                                      const tradeoff_samples *samples) {
  const tradeoff_reference *reference = view->reference;
  double wrong[2] = {0}, whole[2] = {0}, energy = 0, most = 0;

  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++) {
    const double *values[2] = {samples->q + n * rank, samples->p + n * rank};
    const double *known[2] = {view->reference_q + n * rank, view->reference_p + n * rank};
    const double size[2] = {reference->u_square[n], reference->v_square[n]};
    for (int w = 0; w < 2; w++) {
      // what lies outside the basis, and the difference inside it
      wrong[w] += fmax(0, size[w] - squares(known[w], rank));
      for (int64_t i = 0; i < rank; i++)
        wrong[w] += (values[w][i] - known[w][i]) * (values[w][i] - known[w][i]);
      whole[w] += size[w];
    }

    energy = fmax(energy, fabs(samples->energy[n] - reference->energy[n]));
    most = fmax(most, fabs(reference->energy[n]));
  }
  return (tradeoff_errors){sqrt(wrong[0] / whole[0]), sqrt(wrong[1] / whole[1]), energy / most};
}

double tradeoff_outside(const tradeoff_view *view, int64_t rank) {
  double outside = 0, whole = 0;
  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++) {
    const double size = view->reference->u_square[n];
    outside += fmax(0, size - squares(view->reference_q + n * rank, rank));
    whole += size;
  }
  return sqrt(outside / whole);
}

tradeoff_errors tradeoff_against(int64_t rank, const tradeoff_samples *samples,
                                 const tradeoff_samples *other) {
  double wrong[2] = {0}, energy = 0, most = 0;
  for (int64_t i = 0; i < TRADEOFF_SAMPLES * rank; i++) {
    wrong[0] += (samples->q[i] - other->q[i]) * (samples->q[i] - other->q[i]);
    wrong[1] += (samples->p[i] - other->p[i]) * (samples->p[i] - other->p[i]);
  }
  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++) {
    energy = fmax(energy, fabs(samples->energy[n] - other->energy[n]));
    most = fmax(most, fabs(other->energy[n]));
  }
  return (tradeoff_errors){sqrt(wrong[0] / squares(other->q, TRADEOFF_SAMPLES * rank)),
                           sqrt(wrong[1] / squares(other->p, TRADEOFF_SAMPLES * rank)),
                           energy / most};
}
