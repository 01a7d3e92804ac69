/* Several states in one step together; private to the runtime, see batch_group.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_BATCH_BATCH_GROUP_H
#define THRUM_RUNTIME_BATCH_BATCH_GROUP_H

#include "core/schemes/discrete_gradient.h"
#include "core/schemes/imexv.h"
#include "core/solve/quasi_newton.h"
#include "core/step/step.h"
#include "runtime/batch/batch_kernel.h"

/* One state of a group. */
typedef struct thrum_batch_member {
  thrum_step_run run;
  thrum_solver solver;
  thrum_quasi quasi;
  thrum_step_start from; /* energy: the end of the step before */
  thrum_status status;
  double *own;   /* workspace that it borrows */
  int64_t index; /* in the caller's list */
  bool solving;
} thrum_batch_member;

/* A group and its arrays, each by coordinate and then by state. */
typedef struct thrum_batch_group {
  const thrum_model *model;
  const thrum_batch_kernel *kernel;
  thrum_batch_member *members; /* THRUM_BATCH_LANES_MAX */
  int64_t count;
  int32_t scheme, split;
  double *q, *force, *value, *restricted, *hessian, *work;
  double *one_work, *one_restricted; /* workspace that one state after the other borrows */
} thrum_batch_group;

/* Runs the stability monitor of all members. After it a member's step may be of another kind. */
void thrum_batch_monitor(thrum_batch_group *g);

/* True for the steps that are made in groups. */
static inline bool thrum_batch_takes(const thrum_state *state) {
  if (state->def.solver != THRUM_SOLVER_QUASI_NEWTON)
    return false;
  switch ((thrum_scheme)state->scheme) {
  case THRUM_SCHEME_POSITION:
  case THRUM_SCHEME_THESIS:
  case THRUM_SCHEME_ENERGY:
  case THRUM_SCHEME_FOX_GOODWIN:
    return true;
  case THRUM_SCHEME_NEWMARK:
    return state->def.newmark_beta > 0.0;
  default:
    return false;
  }
}

/* Attempts the step of all members, which have the scheme and split of the group. */
void thrum_batch_attempt(thrum_batch_group *g);

#endif
