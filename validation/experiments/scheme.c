/* The rows of the table of schemes. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/scheme.h"

const char *const experiment_scheme_names[EXPERIMENT_SCHEME_COUNT] = {
#define X(symbol, name, integrator, form, solver, alone, keeps) name,
    EXPERIMENT_SCHEME_LIST(X)
#undef X
};

static const struct {
  thrum_integrator integrator;
  thrum_split_form form;
  thrum_implicit_solver solver;
  bool alone, keeps;
} rows[EXPERIMENT_SCHEME_COUNT] = {
#define X(symbol, name, integrator, form, solver, alone, keeps)                                    \
  {THRUM_INTEGRATOR_##integrator, THRUM_FORM_##form, THRUM_SOLVER_##solver, alone, keeps},
    EXPERIMENT_SCHEME_LIST(X)
#undef X
};

thrum_state_def experiment_scheme_def(experiment_scheme scheme, double dt) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = rows[scheme].integrator;
  def.split_form = rows[scheme].form;
  def.solver = rows[scheme].solver;
  def.fallback = !rows[scheme].alone;

  // with its monitor the row of fox-goodwin would say of many runs what energy does
  def.adaptive = def.fallback && def.integrator == THRUM_INTEGRATOR_IMEXV;
  def.dt = dt;
  return def;
}

bool experiment_scheme_keeps(experiment_scheme scheme) {
  return rows[scheme].keeps;
}

int64_t experiment_flag_count(const bool *flags, int count) {
  int64_t number = 0;
  for (int n = 0; n < count; n++)
    number += flags[n];
  return number;
}
