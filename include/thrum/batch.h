/* Batches: many states of one model that are stepped together, such as a forest or a sweep of
 * parameters.
 *
 * A call steps a range of states, several at a time, so that each coefficient of the model is
 * loaded once for all of them. Each state ends with the same bits as by thrum_step, whatever the
 * range, the order or the number of threads. The library starts no thread: a caller with several
 * gives each a range and a workspace of its own, and shares the model.
 *
 * States of one range may have been made by different defs. Those that are stepped by energy, also
 * after a switch of imexv, by newmark with beta > 0, by fox-goodwin, by midpoint, or by imexv in
 * its position form or thesis split gain from a batch where, among 256 that follow each other,
 * several have the same scheme and split; the others are stepped one by one.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BATCH_H
#define THRUM_BATCH_H

#include "thrum/api.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of workspace that thrum_batch_step needs for this model, whatever the number of states,
 * into *size. THRUM_INVALID_ARGUMENT for NULL or a model without a valid rank. */
THRUM_API thrum_status thrum_batch_size(const thrum_model *model, size_t *size, thrum_error *error);

/* Advances each of `count` states by one step; one that is listed twice by two. `workspace` has
 * thrum_batch_size bytes and is aligned to 64; its content is undefined before and after, and the
 * caller owns it. `statuses` (count, may be NULL) gets what thrum_step would return for each.
 *
 * Returns the first failure among them, else THRUM_FELL_BACK if one fell back, else THRUM_SWITCHED
 * if one has switched its scheme (thrum_step), else THRUM_OK. A state that fails stays as it was,
 * `error` says why the first one did, and the others make their step. THRUM_INVALID_ARGUMENT,
 * THRUM_MISALIGNED or THRUM_BUFFER_TOO_SMALL before any step. */
THRUM_API thrum_status thrum_batch_step(const thrum_model *model, thrum_state *const *states,
                                        int64_t count, thrum_status *statuses, void *workspace,
                                        size_t workspace_size, thrum_error *error);

/* --- batches as arrays --------------------------------------------------------------------------
 *
 * What goes in and out of all states of a batch at once. Row n of an array belongs to state n: rank
 * doubles, which begin `stride` doubles behind those of row n - 1. A stride of 0 gives all states
 * the same row, where rows are read.
 *
 * Each function goes on after a state that it cannot serve: that state, and its row, stay as they
 * were, and the failure of the first one is returned, with its number in the message. Failures are
 * those of the function for one state; THRUM_INVALID_ARGUMENT for NULL, a count or a stride below
 * 0, and a stride below the rank where rows are written. Nothing is allocated. */

/* Sets the loads of the steps to come: thrum_state_set_force. `forces` NULL: no loads. */
THRUM_API thrum_status thrum_batch_set_forces(const thrum_model *model, thrum_state *const *states,
                                              int64_t count, const double *forces, int64_t stride,
                                              thrum_error *error);

/* Sets the levels of the actuators in the steps to come: thrum_state_set_actuation. Row n of
 * `levels` has thrum_model_actuators numbers. `levels` NULL: all zero. */
THRUM_API thrum_status thrum_batch_set_actuation(const thrum_model *model,
                                                 thrum_state *const *states, int64_t count,
                                                 const double *levels, int64_t stride,
                                                 thrum_error *error);

/* Sets q and p: thrum_state_set. Either may be NULL: zero. `chosen` (count, NULL: all) is 0 where a
 * state stays as it is, such as all but those that begin anew. */
THRUM_API thrum_status thrum_batch_set(const thrum_model *model, thrum_state *const *states,
                                       int64_t count, const uint8_t *chosen, const double *q,
                                       const double *p, int64_t stride, thrum_error *error);

/* Writes q and p: thrum_state_get. Either may be NULL. */
THRUM_API thrum_status thrum_batch_get(const thrum_model *model, thrum_state *const *states,
                                       int64_t count, double *q, double *p, int64_t stride,
                                       thrum_error *error);

/* Writes the energies, `count` of them: thrum_state_energies. */
THRUM_API thrum_status thrum_batch_energies(const thrum_model *model, thrum_state *const *states,
                                            int64_t count, thrum_energies *energies,
                                            thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
