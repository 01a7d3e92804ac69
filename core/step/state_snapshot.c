/* Snapshots of a state that leave the program, and what makes bytes from elsewhere a state
 * (thrum/state.h).
 *
 * A snapshot is the head of core/base/seal.h and the bytes that persist. The checksum finds
 * accidents. Bytes that were made on purpose pass it, so each number that is an index, a size or a
 * choice is checked against the model and the def as well, and every other for being finite.
 * Cost: about two cycles a byte. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/seal.h"
#include "core/polynomial/packed.h"
#include "core/schemes/schemes.h"
#include "core/solve/spurious_work.h"
#include "core/state/state_layout.h"
#include "core/step/state_private.h"

/* Steps and counters beyond this could overflow when they are counted on. */
#define COUNT_MAX (INT64_C(1) << 62)

/* Doubles that are looked at at once; a copy, as the bytes may lie at any address. */
#define PIECE 64

static const thrum_seal_kind kind = {{'t', 'h', 'r', 'u', 'm', 's', 't', 'a'}, THRUM_STATE_VERSION};

size_t thrum_state_snapshot_size(const thrum_state *state) {
  return state ? THRUM_SEAL_BYTES + thrum_state_kept_bytes(state) : 0;
}

thrum_status thrum_state_snapshot(const thrum_state *state, void *memory, size_t size,
                                  thrum_error *error) {
  const size_t needed = thrum_state_snapshot_size(state);
  if (!state || !memory)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the state or the memory is NULL");
  if (size < needed)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "a snapshot of this state has %zu bytes, the memory %zu", needed, size);
  memcpy((unsigned char *)memory + THRUM_SEAL_BYTES, state, thrum_state_kept_bytes(state));
  thrum_seal_put(memory, needed, kind);
  return THRUM_OK;
}

/* --- what makes bytes a state ----------------------------------------------------------------- */

static thrum_status refuse(const char *what, thrum_error *error) {
  return thrum_error_set(error, THRUM_BAD_VALUE, "the snapshot's %s is out of its range", what);
}

/* The sizes are those that follow from the def, and the block is as large as the state's. */
static thrum_status check_sizes(const thrum_model *model, const thrum_state *state,
                                const thrum_state *header, thrum_error *error) {
  thrum_state planned = *header;
  thrum_state_plan(&planned, model);

  // scratch that is lent is no part of the bytes, but a step writes all of it
  const uint64_t scratch = thrum_state_layout_scratch(&planned);
  if (planned.bytes != state->bytes || scratch != thrum_state_layout_scratch(state) ||
      thrum_state_kept_bytes(&planned) != thrum_state_kept_bytes(state))
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the snapshot is of a state of another def: it has %llu bytes and %llu "
                           "of scratch where the state has %llu and %llu",
                           (unsigned long long)planned.bytes, (unsigned long long)scratch,
                           (unsigned long long)state->bytes,
                           (unsigned long long)thrum_state_layout_scratch(state));

  // what the header itself says of its arrays
  if (header->bytes != planned.bytes || header->work_count != planned.work_count ||
      header->restricted_count != planned.restricted_count ||
      header->kept_count != planned.kept_count || header->next_count != planned.next_count ||
      header->tangent_count != planned.tangent_count ||
      header->plastic_count != planned.plastic_count ||
      header->shares_count != planned.shares_count ||
      header->shapes_count != planned.shapes_count ||
      header->levels_count != planned.levels_count || header->ahead_count != planned.ahead_count)
    return refuse("size of an array", error);
  return THRUM_OK;
}

/* The scheme and the split of the modes are ones that a state of this def can come to. */
static thrum_status check_scheme(const thrum_model *model, const thrum_state *header,
                                 thrum_error *error) {
  const thrum_state_def *def = &header->def;
  const thrum_scheme scheme = (thrum_scheme)header->scheme;
  const bool imexv = def->integrator == THRUM_INTEGRATOR_IMEXV;
  const bool its_own = scheme == THRUM_SCHEME_THESIS || scheme == THRUM_SCHEME_QUADRATIC ||
                       scheme == THRUM_SCHEME_POSITION ||
                       (scheme == THRUM_SCHEME_ENERGY && thrum_state_uses_energy(def));
  const bool changed = (imexv && its_own) || (thrum_adapts(def->integrator) && def->adaptive &&
                                              scheme == THRUM_SCHEME_ENERGY);
  const bool first = header->scheme == thrum_first_scheme(def);
  if (!thrum_scheme_name(scheme) || !thrum_schemes.rows[scheme] || (!first && !changed))
    return refuse("scheme", error);
  const thrum_scheme_row *row = thrum_row_of(header);

  thrum_state found = *header;
  memset(found.following, 0, sizeof found.following);
  if (thrum_schemes.mode_steps)
    thrum_schemes.mode_steps->find(model, &found);
  if (memcmp(found.following, header->following, sizeof found.following) != 0)
    return refuse("modes that follow others", error);

  // the inverses have room for as many implicit modes as the def allows, where any are kept
  const int64_t rank = header->rank;
  if (header->split < 0 || header->split > rank || header->high_first < 0 ||
      header->high_first > rank)
    return refuse("split of the modes", error);
  const int64_t implicit = rank - header->split;
  if (!row->keeps_nothing && implicit * implicit > header->kept_count)
    return refuse("split of the modes", error);

  // V is restricted to the implicit modes where both kinds are there
  if (row->restricts && header->split > 0 && implicit > 0 &&
      thrum_restriction_room(model, implicit) > header->restricted_count)
    return refuse("split of the modes", error);
  if (!(header->split_dt > 0.0 && header->longest_dt > 0.0))
    return refuse("length of the steps", error);
  return THRUM_OK;
}

static bool are_counts(const int64_t *counts, size_t n, int64_t least) {
  for (size_t k = 0; k < n; k++)
    if (counts[k] < least || counts[k] > COUNT_MAX)
      return false;
  return true;
}

static thrum_status check_counts(const thrum_state *header, thrum_error *error) {
  const thrum_state_report *report = &header->report;
  const thrum_stability_monitor *monitor = &header->monitor;
  const thrum_spurious_work *spurious = &header->spurious;

  // what was counted, and steps at which something was or will be done, which may lie before 0
  const int64_t counts[] = {report->steps,           report->iterations,    report->factorisations,
                            report->newton_steps,    report->energy_steps,  report->substep_steps,
                            report->switched_steps,  report->split_changes, report->corrections,
                            report->scheme_switches, report->grown_steps,   report->single_steps,
                            report->tightened};
  const int64_t times[] = {
      report->first_switch,      monitor->samples,     monitor->windows,     monitor->window_end,
      monitor->switch_deadline,  monitor->before_step, monitor->quiet_end,   monitor->energy_step,
      header->balance.begin,     header->target.begin, header->eager_end,    header->potential_step,
      header->average_field_end, spurious->samples,    spurious->window_end, header->jacobian_step,
      header->jacobian_due,      header->split_end,    monitor->sample_step};
  if (!are_counts(counts, sizeof counts / sizeof counts[0], 0) ||
      !are_counts(times, sizeof times / sizeof times[0], -COUNT_MAX) ||
      !are_counts(header->inverse_step, THRUM_INVERSES, -COUNT_MAX))
    return refuse("counter", error);

  // switches, and places in the rings of past solves and inverses
  if (monitor->drifting < 0 || monitor->drifting > 1 || header->past_discrete < 0 ||
      header->past_discrete > 1 || header->jacobian_kept < 0 || header->jacobian_kept > 1 ||
      header->target.status < THRUM_ENERGY_CORRECTION_CLOSED ||
      header->target.status > THRUM_ENERGY_CORRECTION_PENDING || header->carried < 0 ||
      header->carried > 1 || header->balance.grew < 0 || header->balance.grew > 1)
    return refuse("switch", error);
  if (header->jacobian_interval < 0 || spurious->halvings < 0 ||
      spurious->halvings > THRUM_HALVINGS_MOST || spurious->quiet < 0 ||
      spurious->quiet > THRUM_WAIT_MOST || spurious->wait < 0 || spurious->wait > THRUM_WAIT_MOST)
    return refuse("plan of the energy integrator", error);
  if ((header->release_due != 0 && header->release_due != 1) || header->past_count < 0 ||
      header->past_count > THRUM_PAST_SOLVES || header->inverse_place < 0 ||
      header->inverse_place >= THRUM_INVERSES)
    return refuse("place of a past solve", error);
  return THRUM_OK;
}

/* A test plants NaN in each of them, so that a field which is added and not listed is found. */
static bool is_finite_header(const thrum_state *header) {
  const thrum_state_report *report = &header->report;
  const thrum_stability_monitor *m = &header->monitor;
  const thrum_spurious_work *s = &header->spurious;
  const double values[] = {report->time,
                           report->corrected,
                           report->stability_number_last,
                           report->stability_number_peak,
                           report->balance_last,
                           report->balance_peak,
                           report->dissipated,
                           report->plastic_work,
                           report->residual_last,
                           m->work,
                           m->moved,
                           m->recent,
                           m->scale,
                           m->scale_before,
                           m->motion,
                           m->motion_before,
                           m->middle_balance,
                           m->balance_sum,
                           m->reference,
                           m->modified_reference,
                           m->drift_sum,
                           m->block_sum,
                           m->block_square,
                           m->corrected,
                           m->energy_error,
                           m->quiet_peak,
                           m->switched_energy,
                           m->number_rate,
                           header->balance.explained,
                           header->balance.scale,
                           header->balance.moved,
                           header->balance.motion,
                           header->target.energy,
                           header->target.carry,
                           header->target.moved,
                           header->potential,
                           header->potential_end,
                           header->contraction,
                           header->step_recent,
                           report->spurious,
                           s->work,
                           s->square,
                           s->energy[0],
                           s->energy[1],
                           header->guess_last,
                           header->amplitude,
                           m->before_dt,
                           header->split_dt,
                           header->longest_dt};

  // the lengths of past steps are an array already
  return thrum_all_finite(values, sizeof values / sizeof values[0]) &&
         thrum_all_finite(header->past_dt, THRUM_PAST_SOLVES);
}

/* The arrays behind the header hold doubles alone. */
static bool is_finite_content(const unsigned char *bytes, size_t count) {
  double piece[PIECE];
  for (size_t at = sizeof(thrum_state); at < count;) {
    const size_t left = count - at, size = left < sizeof piece ? left : sizeof piece;
    memcpy(piece, bytes + at, size);
    if (!thrum_all_finite(piece, (int64_t)(size / sizeof *piece)))
      return false;
    at += size;
  }
  return true;
}

thrum_status thrum_state_copy_check(const thrum_model *model, const thrum_state *state,
                                    const void *copy, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!copy)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the copy of a state is NULL");

  // a copy of its own, as the bytes may lie at any address
  thrum_state header;
  size_t size;
  memcpy(&header, copy, sizeof header);
  THRUM_TRY(thrum_state_check(model, &header, error));
  THRUM_TRY(thrum_state_size(model, &header.def, &size, error));
  THRUM_TRY(check_sizes(model, state, &header, error));
  THRUM_TRY(check_scheme(model, &header, error));
  THRUM_TRY(check_counts(&header, error));

  if (!is_finite_header(&header) || !is_finite_content(copy, thrum_state_kept_bytes(state)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the snapshot holds a number that is not finite");
  return THRUM_OK;
}

thrum_status thrum_state_restore(const thrum_model *model, thrum_state *state, const void *memory,
                                 size_t size, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  THRUM_TRY(thrum_seal_check(memory, size, kind, thrum_state_snapshot_size(state), error));
  const unsigned char *content = (const unsigned char *)memory + THRUM_SEAL_BYTES;
  THRUM_TRY(thrum_state_copy_check(model, state, content, error));
  memcpy(state, content, thrum_state_kept_bytes(state));
  return THRUM_OK;
}
