/* The table of schemes: what the experiments compare, and how a state is defined for each.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_SCHEME_H
#define THRUM_VALIDATION_EXPERIMENTS_SCHEME_H

#include <stdbool.h>

#include "thrum/thrum.h"

/* X(symbol, name, integrator, split form, solver, alone, keeps). `alone`: no monitor and no
 * fallback chain, so that what steps is the scheme itself. `keeps`: the scheme keeps the energy, so
 * a lost run is a fault of the program; the others may lose their energy. */
#define EXPERIMENT_SCHEME_LIST(X)                                                                  \
  X(THESIS, "thesis", IMEXV, THESIS, QUASI_NEWTON, true, false)                                    \
  X(THESIS_NEWTON, "thesis-newton", IMEXV, THESIS, NEWTON, true, false)                            \
  X(POSITION, "position", IMEXV, POSITION, QUASI_NEWTON, true, false)                              \
  X(QUADRATIC, "quadratic", IMEXV, QUADRATIC, QUASI_NEWTON, true, false)                           \
  X(VERLET, "verlet", VERLET, THESIS, QUASI_NEWTON, true, false)                                   \
  X(MIDPOINT, "midpoint", MIDPOINT, THESIS, QUASI_NEWTON, true, false)                             \
  X(NEWMARK, "newmark", NEWMARK, THESIS, QUASI_NEWTON, false, false)                               \
  X(NEWMARK_NEWTON, "newmark-newton", NEWMARK, THESIS, NEWTON, true, false)                        \
  X(FOX_GOODWIN, "fox-goodwin", FOX_GOODWIN, THESIS, QUASI_NEWTON, false, false)                   \
  X(IMEXV, "imexv", IMEXV, POSITION, QUASI_NEWTON, false, true)                                    \
  X(ENERGY, "energy", ENERGY, THESIS, QUASI_NEWTON, false, true)                                   \
  X(BACKWARD_EULER, "backward-euler", BACKWARD_EULER, THESIS, QUASI_NEWTON, true, false)           \
  X(SEMI_IMPLICIT_EULER, "semi-implicit-euler", SEMI_IMPLICIT_EULER, THESIS, QUASI_NEWTON, true,   \
    false)                                                                                         \
  X(RK4, "rk4", RK4, THESIS, QUASI_NEWTON, true, false)

typedef enum experiment_scheme {
#define X(symbol, name, integrator, form, solver, alone, keeps) EXPERIMENT_SCHEME_##symbol,
  EXPERIMENT_SCHEME_LIST(X)
#undef X
      EXPERIMENT_SCHEME_COUNT
} experiment_scheme;

extern const char *const experiment_scheme_names[EXPERIMENT_SCHEME_COUNT];

/* The def of a state that this scheme steps, with the defaults otherwise. */
thrum_state_def experiment_scheme_def(experiment_scheme scheme, double dt);

/* How many of the flags are set: of schemes, loads or starts that are asked for. */
int64_t experiment_flag_count(const bool *flags, int count);

/* Whether a run of it that is lost is a fault of the program. */
bool experiment_scheme_keeps(experiment_scheme scheme);

#endif
