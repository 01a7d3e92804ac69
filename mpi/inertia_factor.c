/* See inertia_factor.h. SPDX-License-Identifier: Apache-2.0 */
#include "mpi/inertia_factor.h"

#include "mpi/petsc_status.h"

thrum_status inertia_factor_make(Mat matrix, KSP ksp, double threshold, PC *pc, Mat *factor,
                                 thrum_error *error) {
  PETSC_TRY(KSPSetOperators(ksp, matrix, matrix));
  PETSC_TRY(KSPSetType(ksp, KSPPREONLY));
  PETSC_TRY(KSPGetPC(ksp, pc));
  PETSC_TRY(PCSetType(*pc, PCCHOLESKY));
  PETSC_TRY(PCFactorSetMatSolverType(*pc, MATSOLVERMUMPS));
  PETSC_TRY(PCFactorSetUpMatSolverType(*pc));
  PETSC_TRY(PCFactorGetMatrix(*pc, factor));

  // the last pivots are counted too; room for those put off, in percent
  PETSC_TRY(MatMumpsSetCntl(*factor, 1, threshold));
  PETSC_TRY(MatMumpsSetIcntl(*factor, 13, 1));
  PETSC_TRY(MatMumpsSetIcntl(*factor, 14, 50));
  PETSC_TRY(KSPSetUp(ksp));
  return THRUM_OK;
}
