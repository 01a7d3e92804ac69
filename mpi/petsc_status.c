/* Failures of PETSc and SLEPc as ours, see petsc_status.h. SPDX-License-Identifier: Apache-2.0 */
#include "mpi/petsc_status.h"

#include <petscsys.h>

thrum_status petsc_status(int code, thrum_error *error) {
  if (code == PETSC_ERR_MEM)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "no memory for the solver: use more processes, or a coarser mesh");
  const char *text = NULL;
  PetscErrorMessage(code, &text, NULL);
  return thrum_error_set(error, THRUM_NOT_CONVERGED, "the solver failed (PETSc code %d: %.200s)",
                         code, text != NULL ? text : "unknown");
}
