/* A state: planning, laying out, setting and reading it (thrum/state.h).
 *
 * Callers see p at the time of q. A state stores p^- for its explicit modes, so momenta are
 * synchronised on the way out and shifted on the way in (design 5).
 * Cost of reading or setting p: one force evaluation when there are explicit modes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/step/state_private.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/def.h"
#include "core/base/finite.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/discrete_gradient.h"
#include "core/schemes/mode_split.h"
#include "core/schemes/newmark.h"
#include "core/schemes/schemes.h"
#include "core/schemes/staggered_momentum.h"
#include "core/state/motion_norm.h"
#include "core/step/kept_inverse.h"
#include "core/step/state_def.h"
#include "core/step/step_length.h"

#define STATE_MAGIC (UINT64_C(0x7468726d73743030) + THRUM_STATE_VERSION)

/* --- planning and laying out ------------------------------------------------------------------ */

bool thrum_state_uses_energy(const thrum_state_def *def) {
  return def->integrator == THRUM_INTEGRATOR_ENERGY ||
         (thrum_adapts(def->integrator) && (def->adaptive || def->fallback));
}

/* The row of the scheme that a state of this def, which has been checked, begins with. */
static const thrum_scheme_row *first_row(const thrum_state_def *def) {
  return thrum_schemes.rows[thrum_first_scheme(def)];
}

/* Largest |I| that a state of this def can come to, with any dt. */
static int64_t implicit_max(const thrum_model *model, const thrum_state_def *def) {
  if (thrum_state_uses_energy(def))
    return model->rank;
  if (def->integrator == THRUM_INTEGRATOR_VERLET || first_row(def)->is_explicit)
    return 0;
  if (def->integrator == THRUM_INTEGRATOR_IMEXV && def->split_rule == THRUM_SPLIT_COUNT)
    return model->rank - def->explicit_count;
  return model->rank;
}

static void forget_inverses(thrum_state *state) {
  state->inverse_place = 0;
  for (int j = 0; j < THRUM_INVERSES; j++)
    state->inverse_step[j] = -1;
}

void thrum_state_plan(thrum_state *state, const thrum_model *model) {
  const thrum_state_def *def = &state->def;
  const thrum_scheme_row *row = first_row(def);
  const int64_t r = model->rank, n = implicit_max(model, def);
  const bool tangent = thrum_tangent_damped(state);

  // midpoint and Newmark evaluate the whole model; imexv restricts it to fewer than r modes
  state->work_count = (int64_t)thrum_work_count(model);
  state->restricted_count = def->integrator == THRUM_INTEGRATOR_IMEXV
                                ? thrum_restriction_room(model, n < r ? n : r - 1)
                                : 0;
  state->plastic_count = state->shares_count = state->shapes_count = state->ahead_count = 0;
  state->levels_count = 0;

  // tangent damping needs T of all modes, also where few or none are implicit
  state->kept_count = row->keeps_nothing ? 0 : n * n;
  state->next_count = tangent ? r * r : n * n;
  state->tangent_count = tangent || thrum_state_uses_energy(def) ? r * r : 0;

  // what the scheme and others need
  if (row->plan)
    row->plan(model, state);
  THRUM_CALL_HOOKS(thrum_on_plan, plan, model, state);
  state->bytes = thrum_state_layout_bytes(state);
}

/* Forgets what hooks know of the steps so far, and finds the scheme and the split of the def. */
static void begin_scheme(const thrum_model *model, thrum_state *state) {
  state->scheme = thrum_first_scheme(&state->def);
  thrum_step_length_begin(state);
  state->split = thrum_mode_split(model, state);
  THRUM_CALL_HOOKS(thrum_on_forget, forget, state);
}

/* Fills `state`, all zero, with the def and everything that follows from it. */
static void fill_header(thrum_state *state, const thrum_model *model, const thrum_state_def *def) {
  const bool imexv = def->integrator == THRUM_INTEGRATOR_IMEXV;
  state->magic = STATE_MAGIC;
  state->def = *def;
  state->identity = model->identity;
  state->rank = (int32_t)model->rank;
  thrum_state_plan(state, model);
  if (thrum_schemes.mode_steps)
    thrum_schemes.mode_steps->find(model, state);

  // the others do not adapt
  state->def.adaptive = thrum_adapts(def->integrator) ? def->adaptive : 0;
  begin_scheme(model, state);
  state->report.first_switch = -1;
  state->potential_step = -1;
  forget_inverses(state);
  thrum_energy_forget(state);

  // the high modes of the energy report: those that imexv would treat implicitly at rest
  const thrum_split_rule rule = imexv ? def->split_rule : THRUM_SPLIT_CFL;
  state->high_first =
      thrum_mode_split_by(model, rule, def->dt, def->split_safety, def->explicit_count);
}

/* The header of a state to be, which alone knows how much memory it needs; `size`, for that, is
 * only checked. */
static thrum_status make_header(const thrum_model *model, const thrum_state_def *def,
                                const size_t *size, thrum_state *header, thrum_error *error) {
  thrum_state_def whole = thrum_default_state_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  THRUM_TRY(thrum_state_def_check(model, def, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  memset(header, 0, sizeof *header);
  fill_header(header, model, def);
  return THRUM_OK;
}

thrum_status thrum_state_size(const thrum_model *model, const thrum_state_def *def, size_t *size,
                              thrum_error *error) {
  thrum_state header;
  THRUM_TRY(make_header(model, def, size, &header, error));
  if (header.bytes > SIZE_MAX)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "a state of rank %d needs more memory than this machine can address",
                           (int)header.rank);
  *size = (size_t)header.bytes;
  return THRUM_OK;
}

thrum_status thrum_state_init(void *memory, size_t memory_size, const thrum_model *model,
                              const thrum_state_def *def, thrum_state **state, thrum_error *error) {
  thrum_state_def whole = thrum_default_state_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  size_t size;
  THRUM_TRY(thrum_state_size(model, def, &size, error));
  if (!memory || !state)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or state is NULL");
  THRUM_TRY(thrum_alignment_check("state", memory, memory_size, size, error));

  // zero everywhere is a state at rest without history
  memset(memory, 0, size);
  fill_header(memory, model, def);
  *state = memory;
  THRUM_CALL_HOOKS(thrum_on_made, made, model, *state);
  return THRUM_OK;
}

size_t thrum_state_bytes(const thrum_state *state) {
  return state ? (size_t)state->bytes : 0;
}

thrum_status thrum_state_check(const thrum_model *model, const thrum_state *state,
                               thrum_error *error) {
  if (!model || !state)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model or the state is NULL");
  if (state->magic != STATE_MAGIC)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the state was not made by thrum_state_init");

  // a model of the same rank may still be another one
  if (model->rank != state->rank)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the state was made for rank %d, the model has rank %lld",
                           (int)state->rank, (long long)model->rank);
  if (model->identity != state->identity)
    return thrum_error_set(
        error, THRUM_MODEL_MISMATCH,
        "the state was made for another model of rank %d: it has to be made anew "
        "for this one",
        (int)state->rank);
  return THRUM_OK;
}

thrum_status thrum_state_check_ready(const thrum_model *model, const thrum_state *state,
                                     thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (state->def.borrows_scratch && !thrum_state_lent(state))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the state borrows its scratch and has none: thrum_state_lend lends it");
  return THRUM_OK;
}

thrum_status thrum_state_scratch_size(const thrum_model *model, const thrum_state_def *def,
                                      size_t *size, thrum_error *error) {
  thrum_state header;
  THRUM_TRY(make_header(model, def, size, &header, error));
  const uint64_t bytes = thrum_state_layout_scratch(&header);
  if (bytes > SIZE_MAX)
    return thrum_error_set(
        error, THRUM_OUT_OF_MEMORY,
        "the scratch of a state of rank %d is more than this machine can address",
        (int)header.rank);
  *size = (size_t)bytes;
  return THRUM_OK;
}

thrum_status thrum_state_lend(thrum_state *state, void *scratch, size_t size, thrum_error *error) {
  if (!state || state->magic != STATE_MAGIC || !state->def.borrows_scratch)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the state is NULL, was not made by thrum_state_init, or has scratch of "
                           "its own: set borrows_scratch of its def");
  if (scratch)
    THRUM_TRY(thrum_alignment_check("scratch", scratch, size,
                                    (size_t)thrum_state_layout_scratch(state), error));
  thrum_state_set_lent(state, scratch);
  return THRUM_OK;
}

/* --- setting ---------------------------------------------------------------------------------- */

/* Forgets solves and inverses of other implicit modes, and the state before the last step. */
static void forget_solves(thrum_state *state, const thrum_state_view *view) {
  // the arrays from power_explicit to the end of those that persist
  memset(view->power_explicit, 0, (size_t)(view->kept_end - view->power_explicit) * sizeof(double));
  forget_inverses(state);
  state->jacobian_kept = 0;
  state->past_count = 0;
  THRUM_CALL_HOOKS(thrum_on_forget, forget_step, state);
}

/* Forgets everything that a solve kept for the next one. */
static void forget_history(thrum_state *state, const thrum_state_view *view) {
  forget_solves(state, view);
  state->past_discrete = 0;
  state->eager_end = 0;
  state->average_field_end = 0;
  state->potential_step = -1;
  state->potential = 0.0;
  thrum_energy_forget(state);
  state->guess_last = 0.0;
}

static void copy_or_zero(double *to, const double *from, int32_t n) {
  if (from)
    memcpy(to, from, (size_t)n * sizeof *to);
  else
    memset(to, 0, (size_t)n * sizeof *to);
}

static thrum_status refuse_values(thrum_error *error, const char *what) {
  return thrum_error_set(error, THRUM_BAD_VALUE, "%s holds a number that is not finite", what);
}

/* Turns the synchronised p_next at q into the momentum that `changed`, a header to be, stores, and
 * makes its amplitude and the acceleration of Newmark. load_before may be NULL for zero. */
static thrum_status store_synchronised(const thrum_model *model, thrum_state *changed,
                                       thrum_state_view *view, const double *q,
                                       const double *load_before, thrum_error *error) {
  const int32_t r = changed->rank;
  changed->amplitude = thrum_motion_norm(model, changed, q, view->p_next);

  // what each scheme stores besides q: a momentum of its own, and Newmark an acceleration
  memset(view->acceleration_next, 0, (size_t)r * sizeof *view->acceleration_next);
  const thrum_status stored =
      thrum_staggered_unsynchronise(model, changed, view, q, load_before, view->p_next);
  if (stored == THRUM_SINGULAR)
    return thrum_error_set(error, stored,
                           "the momentum that the integrator stores cannot be solved for here");
  if (thrum_carries_acceleration(changed))
    thrum_newmark_acceleration(model, changed, view, q, view->p_next, view->acceleration_next);
  if (stored < 0 || !isfinite(changed->amplitude) || !thrum_all_finite(view->p_next, r) ||
      !thrum_all_finite(view->acceleration_next, r))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the forces at this state are beyond the range of finite numbers");
  return THRUM_OK;
}

thrum_status thrum_state_set(const thrum_model *model, thrum_state *state, const double *q,
                             const double *p, thrum_error *error) {
  THRUM_TRY(thrum_state_check_ready(model, state, error));
  const int32_t r = state->rank;
  if (q && !thrum_all_finite(q, r))
    return refuse_values(error, "q");
  if (p && !thrum_all_finite(p, r))
    return refuse_values(error, "p");

  // candidates in scratch, and a copy of the header, so that a failure leaves no trace
  thrum_model seen;
  model = thrum_seen_model(model, state, &seen);
  thrum_state_view view = thrum_state_view_of(state);
  copy_or_zero(view.q_next, q, r);
  copy_or_zero(view.p_next, p, r);
  thrum_state changed = *state;
  begin_scheme(model, &changed);
  THRUM_TRY(store_synchronised(model, &changed, &view, view.q_next, NULL, error));

  // nothing that persists has been written yet
  const size_t vector = (size_t)r * sizeof(double);
  THRUM_CALL_HOOKS(thrum_on_moved, leave, model, state);
  *state = changed;
  memcpy(view.q, view.q_next, vector);
  memcpy(view.p, view.p_next, vector);
  memcpy(view.q_ahead, view.q_next, (size_t)changed.ahead_count * sizeof *view.q_ahead);
  forget_history(state, &view);

  // there is no step before, and so no load of it
  memcpy(view.acceleration, view.acceleration_next, vector);
  memset(view.load_before, 0, vector);
  THRUM_CALL_HOOKS(thrum_on_moved, arrive, model, state);
  return THRUM_OK;
}

thrum_status thrum_state_set_force(const thrum_model *model, thrum_state *state,
                                   const double *force, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (force && !thrum_all_finite(force, state->rank))
    return refuse_values(error, "force");
  const thrum_state_view view = thrum_state_view_of(state);
  copy_or_zero(view.load, force, state->rank);
  return THRUM_OK;
}

/* The synchronised p into p_next, finite. */
static thrum_status synchronise(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, double *potential, thrum_error *error) {
  if (thrum_staggered_synchronise(model, state, view, potential) < 0)
    return thrum_error_set(error, THRUM_SINGULAR,
                           "the tangent damping cannot be solved for at this state");
  if (!thrum_all_finite(view->p_next, state->rank))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the momentum of this state is beyond the range of finite numbers");
  return THRUM_OK;
}

thrum_status thrum_state_set_dt(const thrum_model *model, thrum_state *state, double dt,
                                thrum_error *error) {
  THRUM_TRY(thrum_state_check_ready(model, state, error));
  if (!isfinite(dt) || !(dt > 0.0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "dt is %g; it must be finite and > 0 [s]",
                           dt);
  if (dt == state->def.dt)
    return THRUM_OK;

  // what is scaled by the ratio of the steps stays a number
  if (!isfinite(dt / state->def.dt) || !isfinite(dt / state->longest_dt))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "dt is %g, and was %g: the ratio is not finite", dt, state->def.dt);

  // p at the time of q does not depend on dt; the stored one does
  thrum_model seen;
  model = thrum_seen_model(model, state, &seen);
  thrum_state_view view = thrum_state_view_of(state);
  THRUM_TRY(synchronise(model, state, &view, NULL, error));
  thrum_state changed = *state;
  thrum_step_length_enter(model, &changed, dt);
  THRUM_TRY(store_synchronised(model, &changed, &view, view.q, view.load_before, error));

  // nothing that persists has been written yet
  const thrum_state before = *state;
  const size_t vector = (size_t)state->rank * sizeof(double);
  memcpy(view.p, view.p_next, vector);
  *state = changed;
  if (state->split != before.split)
    forget_solves(state, &view);
  else
    thrum_kept_inverse_convert(model, &before, state, &view);

  // an increment is as long as its step
  state->step_recent = fmin(state->step_recent * (dt / before.def.dt), DBL_MAX);

  // Newmark's acceleration stays, but for the damping of a v that depends on dt
  for (int32_t i = 0; thrum_row_of(state)->velocity_by_dt && i < state->rank; i++)
    view.acceleration[i] = view.acceleration_next[i] + view.load_before[i];
  return THRUM_OK;
}

/* --- reading ---------------------------------------------------------------------------------- */

thrum_status thrum_state_get(const thrum_model *model, thrum_state *state, double *q, double *p,
                             thrum_error *error) {
  THRUM_TRY(thrum_state_check_ready(model, state, error));
  thrum_model seen;
  model = thrum_seen_model(model, state, &seen);
  thrum_state_view view = thrum_state_view_of(state);
  if (p) {
    THRUM_TRY(synchronise(model, state, &view, NULL, error));
    memcpy(p, view.p_next, (size_t)state->rank * sizeof *p);
  }
  if (q)
    memcpy(q, view.q, (size_t)state->rank * sizeof *q);
  return THRUM_OK;
}

thrum_status thrum_state_energies(const thrum_model *model, thrum_state *state,
                                  thrum_energies *energies, thrum_error *error) {
  THRUM_TRY(thrum_state_check_ready(model, state, error));
  if (!energies)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "energies is NULL");

  thrum_model seen;
  model = thrum_seen_model(model, state, &seen);
  thrum_state_view view = thrum_state_view_of(state);
  thrum_energies found = {0.0, 0.0, 0.0, 0.0};
  THRUM_TRY(synchronise(model, state, &view, &found.potential, error));
  for (int32_t i = 0; i < state->rank; i++) {
    const double twice = view.p_next[i] * view.p_next[i];
    found.kinetic += 0.5 * twice;
    if (i >= state->high_first)
      found.high += 0.5 * (twice + model->omega2[i] * (view.q[i] * view.q[i]));
  }

  if (thrum_row_of(state)->kinetic)
    found.kinetic += thrum_row_of(state)->kinetic(model, view.q, view.p_next);

  // what acts on the body has done work on it, and is no energy of its
  if (model->levels)
    found.potential -= thrum_passes.act(view.kernel, model, view.q, NULL, NULL, 0.0);

  // a finite state may have an energy that is not
  found.total = found.kinetic + found.potential;
  if (!isfinite(found.total) || !isfinite(found.high))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the energy of this state is beyond the range of finite numbers");
  *energies = found;
  return THRUM_OK;
}

thrum_state_report thrum_state_report_get(const thrum_state *state) {
  if (!state)
    return (thrum_state_report){0};
  thrum_state_report report = state->report;
  report.scheme = (thrum_scheme)state->scheme;
  report.explicit_modes = thrum_row_of(state)->is_explicit ? state->rank : state->split;
  report.implicit_modes = state->rank - report.explicit_modes;
  return report;
}
