/* Newton's method for the increment of a step, of the manifold and of the floating frame; private
 * to the runtime, see increment_solve.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONDENSED_INCREMENT_SOLVE_H
#define THRUM_RUNTIME_CONDENSED_INCREMENT_SOLVE_H

#include <stdbool.h>

#include "core/state/solve_report.h"
#include "core/state/state_layout.h"

/* A step whose increment is sought. */
typedef struct thrum_increment {
  const thrum_model *model;
  const thrum_state *state;
  thrum_state_view *view;
  double tolerance; /* of a residual over the step, where the def names none */

  /* The residual of view->unknown into view->residual; false: there is none. */
  bool (*evaluate)(void *of);
  /* The inverse of the Jacobian there into view->jacobian_next; false: there is none. */
  bool (*invert)(void *of, thrum_solve_report *report);
  void *of;
} thrum_increment;

/* Solves from the guess in view->unknown, where the increment stays, with `inverse` (rank x rank,
 * as products read it) or, NULL, one that is made. THRUM_NOT_CONVERGED, THRUM_NOT_FINITE. */
thrum_status thrum_increment_solve(const thrum_increment *s, const double *inverse,
                                   thrum_solve_report *report);

#endif
