/* The status that a failed call of LAPACKE stands for. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_LAPACK_STATUS_H
#define THRUM_PRECOMPUTE_FEM_LAPACK_STATUS_H

#include <lapacke.h>

#include "thrum/status.h"

/* LAPACKE takes its workspace itself, and returns a code of its own where there is no memory for
 * it. `info` is what the call returned: THRUM_OK for 0, THRUM_OUT_OF_MEMORY for those codes, else
 * `failure` with the text. */
static inline thrum_status thrum_lapack_status(lapack_int info, thrum_status failure,
                                               const char *text, thrum_error *error) {
  if (info == 0)
    return THRUM_OK;
  if (info == LAPACK_WORK_MEMORY_ERROR || info == LAPACK_TRANSPOSE_MEMORY_ERROR)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the work of LAPACK");
  return thrum_error_set(error, failure, "%s", text);
}

#endif
