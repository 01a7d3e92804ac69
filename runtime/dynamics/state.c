/* The state's block: planning, laying out, setting and reading it (thrum/state.h).
 *
 * Momenta pass through synchronisation (design 5): a state stores p^- for its explicit modes,
 * callers see p at the time of q.
 * Cost of reading or setting p: one force evaluation when there are explicit modes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/dynamics/state_private.h"

#include <math.h>
#include <string.h>

#include "runtime/base/alignment_check.h"
#include "runtime/dynamics/secant.h"
#include "runtime/polynomial/polynomial_private.h"

#define STATE_MAGIC UINT64_C(0x7468726d73743033)
#define STATE_ALIGNMENT 64

/* Doubles of each kind of array, rounded up to whole alignments. */
typedef struct sizes {
  uint64_t vector, past, pairs, work, restricted, inverse, inverses, next, tangent;
} sizes;

static uint64_t round_up(uint64_t doubles) {
  const uint64_t lane = STATE_ALIGNMENT / sizeof(double);
  return (doubles + lane - 1) / lane * lane;
}

static sizes sizes_of(const thrum_state *state) {
  const uint64_t vector = round_up((uint64_t)state->rank);
  const uint64_t inverse = round_up((uint64_t)state->kept_count);
  const sizes s = {
      .vector = vector,
      .past = THRUM_PAST * vector,
      .pairs = 2 * THRUM_SECANT_PAIRS * vector,
      .work = round_up((uint64_t)state->work_count),
      .restricted = round_up((uint64_t)state->restricted_count),
      .inverse = inverse,
      .inverses = THRUM_INVERSES * inverse,
      .next = round_up((uint64_t)state->next_count),
      .tangent = round_up((uint64_t)state->tangent_count),
  };
  return s;
}

static uint64_t header_doubles(void) {
  return round_up((sizeof(thrum_state) + sizeof(double) - 1) / sizeof(double));
}

size_t thrum_state_kept_bytes(const thrum_state *state) {
  if (!state)
    return 0;
  const sizes s = sizes_of(state);
  uint64_t doubles = header_doubles();
#define X(name, size) doubles += s.size;
  THRUM_STATE_ARRAYS(X)
#undef X
  return (size_t)(doubles * sizeof(double));
}

thrum_state_view thrum_state_view_of(thrum_state *state) {
  const sizes s = sizes_of(state);
  double *at = (double *)(void *)state + header_doubles();
  thrum_state_view view;
  memset(&view, 0, sizeof view);
#define X(name, size)                                                                              \
  view.name = at;                                                                                  \
  at += s.size;
  THRUM_STATE_ARRAYS(X)
  THRUM_STATE_SCRATCH(X)
#undef X
  for (int j = 0; j < THRUM_INVERSES; j++) {
    const int place = (state->inverse_place + THRUM_INVERSES - j) % THRUM_INVERSES;
    view.inverse[j] = view.inverses + (size_t)place * s.inverse;
  }
  view.stride = (int64_t)s.vector;
  view.kernel = thrum_kernel_get(state->kernel);
  return view;
}

/* What of a view is lent as vectors, by the size of its arrays. */
#define LENT_vector(stride) (stride)
#define LENT_pairs(stride) (2 * THRUM_SECANT_PAIRS * (stride))
#define LENT_work(stride) 0
#define LENT_restricted(stride) 0
#define LENT_next(stride) 0
#define LENT_tangent(stride) 0

int64_t thrum_lent_vectors(int64_t rank) {
  const int64_t stride = (int64_t)round_up((uint64_t)rank);
  int64_t count = 0;
#define X(name, size) count += LENT_##size(stride);
  THRUM_STATE_SCRATCH(X)
#undef X
  return count;
}

void thrum_state_lend(thrum_state_view *view, const thrum_lent *lent) {
  if (lent->work)
    view->work = lent->work;
  if (lent->restricted)
    view->restricted = lent->restricted;
  if (!lent->vectors)
    return;
  double *at = lent->vectors;
#define X(name, size)                                                                              \
  if (LENT_##size(view->stride) > 0) {                                                             \
    view->name = at;                                                                               \
    at += LENT_##size(view->stride);                                                               \
  }
  THRUM_STATE_SCRATCH(X)
#undef X
}

/* May a state of this def take steps of design 7? */
static bool uses_energy(const thrum_state_def *def) {
  return def->integrator == THRUM_INTEGRATOR_ENERGY ||
         (def->integrator == THRUM_INTEGRATOR_IMEXV && (def->adaptive || def->fallback));
}

/* Largest |I| that this def can come to, with any dt. */
static int64_t implicit_max(const thrum_model *model, const thrum_state_def *def) {
  if (uses_energy(def))
    return model->rank;
  if (def->integrator == THRUM_INTEGRATOR_VERLET)
    return 0;
  if (def->integrator == THRUM_INTEGRATOR_IMEXV && def->split_rule == THRUM_SPLIT_COUNT)
    return model->rank - def->explicit_count;
  return model->rank;
}

static int32_t first_scheme(const thrum_state_def *def) {
  switch (def->integrator) {
  case THRUM_INTEGRATOR_NEWMARK:
    return THRUM_SCHEME_NEWMARK;
  case THRUM_INTEGRATOR_ENERGY:
    return THRUM_SCHEME_ENERGY;
  case THRUM_INTEGRATOR_IMEXV:
    return def->split_form == THRUM_FORM_QUADRATIC ? THRUM_SCHEME_QUADRATIC
                                                   : THRUM_SCHEME_COMPONENT;
  case THRUM_INTEGRATOR_VERLET:
  case THRUM_INTEGRATOR_MIDPOINT:
    break;
  }
  return THRUM_SCHEME_COMPONENT;
}

static void forget_inverses(thrum_state *state) {
  state->inverse_place = 0;
  for (int j = 0; j < THRUM_INVERSES; j++)
    state->inverse_step[j] = -1;
}

/* Fills `state`, all zero, with what the def says and the sizes that follow from it. */
static void fill_header(thrum_state *state, const thrum_model *model, const thrum_state_def *def) {
  state->magic = STATE_MAGIC;
  state->rank = (int32_t)model->rank;
  state->integrator = (int32_t)def->integrator;
  state->dt = def->dt;
  state->damping_alpha = def->damping_alpha;
  state->damping_beta = def->damping_beta;
  state->damping_form = (int32_t)def->damping_form;
  state->split_rule = (int32_t)def->split_rule;
  state->split_safety = def->split_safety;
  state->explicit_count = def->explicit_count;
  state->newmark_beta = def->newmark_beta;
  state->newmark_gamma = def->newmark_gamma;
  state->tolerance = def->tolerance;
  state->iterations_max = def->iterations_max;
  state->kernel = (int32_t)def->kernel;
  state->split_form = (int32_t)def->split_form;
  state->scheme = first_scheme(def);
  const bool imexv = def->integrator == THRUM_INTEGRATOR_IMEXV;
  state->adaptive = imexv ? def->adaptive : 0;
  state->fallback = def->fallback;
  state->split = thrum_split_of(model, state);
  thrum_stability_reset(state);
  state->potential_step = -1;
  forget_inverses(state);
  // the high modes of the energy report: what imexv would treat implicitly at rest
  const thrum_split_rule rule = imexv ? def->split_rule : THRUM_SPLIT_CFL;
  state->high_first =
      thrum_split_explicit(model, rule, def->dt, def->split_safety, def->explicit_count);

  const int64_t r = model->rank, n = implicit_max(model, def);
  const bool tangent = thrum_tangent_damped(state);
  const bool energy = uses_energy(def);
  state->work_count = (int64_t)thrum_work_count(model);
  // midpoint and Newmark evaluate the whole model; imexv restricts it to fewer than r modes
  if (imexv)
    state->restricted_count = thrum_restricted_count(n < r ? n : r - 1);
  state->kept_count = n * n;
  state->next_count = tangent ? r * r : n * n;
  state->tangent_count = tangent || energy ? r * r : 0;
  const sizes s = sizes_of(state);
  uint64_t doubles = header_doubles();
#define X(name, size) doubles += s.size;
  THRUM_STATE_ARRAYS(X)
  THRUM_STATE_SCRATCH(X)
#undef X
  state->bytes = doubles * sizeof(double);
}

thrum_status thrum_state_size(const thrum_model *model, const thrum_state_def *def, size_t *size,
                              thrum_error *error) {
  const thrum_status status = thrum_state_def_check(model, def, error);
  if (status != THRUM_OK)
    return status;
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  thrum_state header;
  memset(&header, 0, sizeof header);
  fill_header(&header, model, def);
  if (header.bytes > SIZE_MAX)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "a state of rank %d needs more memory than this machine can address",
                           (int)header.rank);
  *size = (size_t)header.bytes;
  return THRUM_OK;
}

thrum_status thrum_state_init(void *memory, size_t memory_size, const thrum_model *model,
                              const thrum_state_def *def, thrum_state **state, thrum_error *error) {
  size_t size;
  thrum_status status = thrum_state_size(model, def, &size, error);
  if (status != THRUM_OK)
    return status;
  if (!memory || !state)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or state is NULL");
  status = thrum_alignment_check("state", memory, memory_size, size, error);
  if (status != THRUM_OK)
    return status;
  memset(memory, 0, size);
  fill_header(memory, model, def);
  *state = memory;
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
  if (model->rank != state->rank)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the state was made for rank %d, the model has rank %lld",
                           (int)state->rank, (long long)model->rank);
  return THRUM_OK;
}

bool thrum_all_finite(const double *values, int64_t n) {
  for (int64_t i = 0; i < n; i++)
    if (!isfinite(values[i]))
      return false;
  return true;
}

double thrum_state_amplitude(const thrum_model *model, const thrum_state *state, const double *q,
                             const double *p) {
  const double h = state->dt;
  double sum = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    const double stiff = 0.25 * h * h * model->omega2[i];
    sum += (i < state->split ? stiff : 1.0 + stiff) * (q[i] * q[i]) + h * h * (p[i] * p[i]);
  }
  return sqrt(sum);
}

/* Forgets what a solve kept for the next one. */
static void forget(thrum_state *state, const thrum_state_view *view) {
  memset(view->guide, 0, (size_t)(view->q_next - view->guide) * sizeof(double));
  state->jacobian_kept = 0;
  state->past_count = 0;
  state->past_ends = 0;
  state->eager_end = 0;
  state->potential_step = -1;
  forget_inverses(state);
  state->potential = 0.0;
  state->path_end = 0;
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

/* Takes q_next and the synchronised p_next, seen from `changed`, the header to be: un-synchronises
 * and commits both. `load_before` may be NULL for zero. */
static thrum_status commit_synchronised(const thrum_model *model, thrum_state *state,
                                        const thrum_state *changed, thrum_state_view *view,
                                        const double *load_before, thrum_error *error) {
  const int32_t r = state->rank;
  const double amplitude = thrum_state_amplitude(model, changed, view->q_next, view->p_next);
  memset(view->acceleration_next, 0, (size_t)r * sizeof *view->acceleration_next);
  if (state->integrator == THRUM_INTEGRATOR_NEWMARK)
    thrum_newmark_acceleration(model, changed, view, view->q_next, view->p_next,
                               view->acceleration_next);
  thrum_stagger_delay(model, changed, view, view->q_next, load_before, view->p_next);
  if (!isfinite(amplitude) || !thrum_all_finite(view->p_next, r) ||
      !thrum_all_finite(view->acceleration_next, r))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the forces at this state are beyond the range of finite numbers");
  *state = *changed;
  state->amplitude = amplitude;
  memcpy(view->q, view->q_next, (size_t)r * sizeof *view->q);
  memcpy(view->p, view->p_next, (size_t)r * sizeof *view->p);
  forget(state, view);
  return THRUM_OK;
}

/* imexv as its def has it, with nothing to compare its energy with. */
static void watch_anew(const thrum_model *model, thrum_state *state) {
  if (state->integrator == THRUM_INTEGRATOR_IMEXV)
    state->scheme =
        state->split_form == THRUM_FORM_QUADRATIC ? THRUM_SCHEME_QUADRATIC : THRUM_SCHEME_COMPONENT;
  state->split = thrum_split_of(model, state);
  thrum_stability_reset(state);
}

thrum_status thrum_state_set(const thrum_model *model, thrum_state *state, const double *q,
                             const double *p, thrum_error *error) {
  thrum_status status = thrum_state_check(model, state, error);
  if (status != THRUM_OK)
    return status;
  const int32_t r = state->rank;
  if (q && !thrum_all_finite(q, r))
    return refuse_values(error, "q");
  if (p && !thrum_all_finite(p, r))
    return refuse_values(error, "p");
  thrum_state_view view = thrum_state_view_of(state);
  copy_or_zero(view.q_next, q, r);
  copy_or_zero(view.p_next, p, r);
  thrum_state anew = *state;
  watch_anew(model, &anew);
  status = commit_synchronised(model, state, &anew, &view, NULL, error);
  if (status == THRUM_OK) {
    memcpy(view.acceleration, view.acceleration_next, (size_t)r * sizeof(double));
    memset(view.load_before, 0, (size_t)r * sizeof(double));
  }
  return status;
}

thrum_status thrum_state_set_force(const thrum_model *model, thrum_state *state,
                                   const double *force, thrum_error *error) {
  const thrum_status status = thrum_state_check(model, state, error);
  if (status != THRUM_OK)
    return status;
  if (force && !thrum_all_finite(force, state->rank))
    return refuse_values(error, "force");
  const thrum_state_view view = thrum_state_view_of(state);
  copy_or_zero(view.load, force, state->rank);
  return THRUM_OK;
}

/* Synchronised p into p_next, and checked. */
static thrum_status synchronise(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, double *potential, thrum_error *error) {
  if (thrum_stagger_synchronise(model, state, view, potential) != THRUM_OK)
    return thrum_error_set(error, THRUM_SINGULAR,
                           "the tangent damping cannot be solved for at this state");
  if (!thrum_all_finite(view->p_next, state->rank))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the momentum of this state is beyond the range of finite numbers");
  return THRUM_OK;
}

thrum_status thrum_state_set_dt(const thrum_model *model, thrum_state *state, double dt,
                                thrum_error *error) {
  thrum_status status = thrum_state_check(model, state, error);
  if (status != THRUM_OK)
    return status;
  if (!isfinite(dt) || !(dt > 0.0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "dt is %g; it must be finite and > 0 [s]",
                           dt);
  if (dt == state->dt)
    return THRUM_OK;
  thrum_state_view view = thrum_state_view_of(state);
  status = synchronise(model, state, &view, NULL, error);
  if (status == THRUM_OK) {
    memcpy(view.q_next, view.q, (size_t)state->rank * sizeof(double));
    thrum_state changed = *state;
    changed.dt = dt;
    watch_anew(model, &changed);
    status = commit_synchronised(model, state, &changed, &view, view.load_before, error);
  }
  return status;
}

thrum_status thrum_state_get(const thrum_model *model, thrum_state *state, double *q, double *p,
                             thrum_error *error) {
  thrum_status status = thrum_state_check(model, state, error);
  if (status != THRUM_OK)
    return status;
  thrum_state_view view = thrum_state_view_of(state);
  if (p) {
    status = synchronise(model, state, &view, NULL, error);
    if (status == THRUM_OK)
      memcpy(p, view.p_next, (size_t)state->rank * sizeof *p);
  }
  if (q && status == THRUM_OK)
    memcpy(q, view.q, (size_t)state->rank * sizeof *q);
  return status;
}

thrum_status thrum_state_energies(const thrum_model *model, thrum_state *state,
                                  thrum_energies *energies, thrum_error *error) {
  thrum_status status = thrum_state_check(model, state, error);
  if (status != THRUM_OK)
    return status;
  if (!energies)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "energies is NULL");
  thrum_state_view view = thrum_state_view_of(state);
  thrum_energies found = {0.0, 0.0, 0.0, 0.0};
  status = synchronise(model, state, &view, &found.potential, error);
  for (int32_t i = 0; i < state->rank && status == THRUM_OK; i++) {
    const double twice = view.p_next[i] * view.p_next[i];
    found.kinetic += 0.5 * twice;
    if (i >= state->high_first)
      found.high += 0.5 * (twice + model->omega2[i] * (view.q[i] * view.q[i]));
  }
  if (status != THRUM_OK)
    return status;
  found.total = found.kinetic + found.potential;
  if (!isfinite(found.total) || !isfinite(found.high))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the energy of this state is beyond the range of finite numbers");
  *energies = found;
  return THRUM_OK;
}

thrum_state_report thrum_state_report_get(const thrum_state *state) {
  thrum_state_report report = {0};
  if (!state)
    return report;
  report.steps = state->steps;
  report.time = state->time;
  report.iterations = state->iterations;
  report.factorisations = state->factorisations;
  report.newton_steps = state->newton_steps;
  report.energy_steps = state->energy_steps;
  report.substep_steps = state->substep_steps;
  report.switched_steps = state->switched_steps;
  report.split_changes = state->split_changes;
  report.scheme_switches = state->scheme_switches;
  report.corrections = state->corrections;
  report.corrected = state->corrected;
  report.stability_number_last = state->stability_number_last;
  report.stability_number_peak = state->stability_number_peak;
  report.balance_last = state->balance_last;
  report.balance_peak = state->balance_peak;
  report.scheme = (thrum_scheme)state->scheme;
  report.explicit_modes = state->split;
  report.implicit_modes = state->rank - state->split;
  report.iterations_last = state->iterations_last;
  report.residual_last = state->residual_last;
  return report;
}
