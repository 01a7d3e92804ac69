/* One step in four parts, so that a batch can evaluate the model for many states together;
 * private to libthrum, see step.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STEP_STEP_H
#define THRUM_CORE_STEP_STEP_H

#include "core/state/solve_report.h"
#include "core/state/state_layout.h"

typedef struct thrum_step_run thrum_step_run;
struct thrum_step_run {
  thrum_state *state;
  thrum_state next; /* the header to be */
  thrum_state_view view;
  double *q, *p, *load; /* those of the state; the view may come to have others */
  thrum_solve_report report;
  bool samples;         /* a hook needs a product before the attempt */
  thrum_status notable; /* what a hook has to say of a state that is committed; THRUM_OK: nothing */
};

/* Checks the state, and lets hooks add to the load and change the scheme; borrowed may be NULL.
 * After a failure there is nothing to end. */
thrum_status thrum_step_begin(const thrum_model *model, thrum_state *state,
                              const thrum_borrowed_workspace *borrowed, thrum_step_run *run,
                              thrum_error *error);

/* Lets hooks choose the scheme, run->next.scheme, by the product that they need, which is made here
 * unless product_there. */
void thrum_step_sample(const thrum_model *model, thrum_step_run *run, bool product_there);

/* One step of that scheme: candidates into the view, nothing that persists is written. THRUM_OK,
 * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_step_attempt(const thrum_model *model, thrum_step_run *run);

/* Ends the step from the status of the attempt on: hooks, commit.
 * Returns what thrum_step returns. */
thrum_status thrum_step_end(const thrum_model *model, thrum_step_run *run, thrum_status attempted,
                            thrum_error *error);

/* All of a step of one state, with what follows its commit; borrowed may be NULL. Returns what
 * thrum_step returns. */
thrum_status thrum_step_alone(const thrum_model *model, thrum_state *state,
                              const thrum_borrowed_workspace *borrowed, thrum_error *error);

/* Ends a step whose candidates come from elsewhere, of a body that exchanges energy with what the
 * state does not have: hooks look at no attempt and settle nothing. */
thrum_status thrum_step_end_coupled(const thrum_model *model, thrum_step_run *run,
                                    thrum_status attempted, thrum_error *error);

#endif
