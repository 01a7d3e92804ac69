/* Failures of PETSc and SLEPc as ours. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_PETSC_STATUS_H
#define THRUM_MPI_PETSC_STATUS_H

#include "thrum/status.h"

/* THRUM_OUT_OF_MEMORY or THRUM_NOT_CONVERGED with PETSc's own words; `code` is not 0. */
thrum_status petsc_status(int code, thrum_error *error);

/* Passes a failure of a call of PETSc on, as THRUM_TRY does with ours. */
#define PETSC_TRY(call)                                                                            \
  do {                                                                                             \
    const int petsc_code_ = (int)(call);                                                           \
    if (petsc_code_ != 0)                                                                          \
      return petsc_status(petsc_code_, error);                                                     \
  } while (0)

/* The same for who has something to free, as THRUM_THEN. */
#define PETSC_THEN(status, call)                                                                   \
  do {                                                                                             \
    if ((status) >= 0) {                                                                           \
      const int petsc_code_ = (int)(call);                                                         \
      if (petsc_code_ != 0)                                                                        \
        (status) = petsc_status(petsc_code_, error);                                               \
    }                                                                                              \
  } while (0)

#endif
