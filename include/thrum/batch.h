/* Many states of one model side by side: a forest, a batch, a sweep of parameters.
 *
 * A call steps a range of states, several at a time, so that a coefficient of the model that is
 * loaded once serves them all. Each state ends with the same bits as by thrum_step, whatever the
 * range, the order or the number of threads. The library starts no thread: a caller with several
 * gives each a range and a workspace of its own; the model is shared.
 *
 * States of one range may have been made by different defs. Those that imexv steps in its component
 * split gain where, among 256 that follow each other, several have equal splits; the others are
 * stepped one by one.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BATCH_H
#define THRUM_BATCH_H

#include "thrum/api.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of workspace of thrum_batch_step for this model; any number of states. */
THRUM_API thrum_status thrum_batch_size(const thrum_model *model, size_t *size, thrum_error *error);

/* Advances each of `count` states by one step; one that is listed twice by two. `workspace`:
 * thrum_batch_size bytes, aligned to 64; its content is undefined before and after. `statuses`
 * (count, may be NULL): what thrum_step would return for each. Returns the first failure among
 * them, else THRUM_FELL_BACK if one did, else THRUM_OK; a failure of one state, which `error`
 * describes, leaves that state as it was and does not keep the others from their step. */
THRUM_API thrum_status thrum_batch_step(const thrum_model *model, thrum_state *const *states,
                                        int64_t count, thrum_status *statuses, void *workspace,
                                        size_t workspace_size, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
