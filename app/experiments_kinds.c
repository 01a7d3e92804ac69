/* The kinds of `thrum experiments`: their names, what they write, and who runs them.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/experiments.h"

const char *experiments_kind_name(experiments_kind kind) {
  static const char *const names[] = {"matrix", "long",       "sweep",          "extremes",
                                      "linear", "step_sizes", "work_precision", "variable"};
  return names[kind];
}

const experiments_form *experiments_kind_form(experiments_kind kind) {
  static const experiments_form *const forms[] = {
      [EXPERIMENTS_MATRIX] = &experiments_matrix_form,
      [EXPERIMENTS_LONG] = &experiments_long_form,
      [EXPERIMENTS_SWEEP] = &experiments_sweep_form,
      [EXPERIMENTS_EXTREMES] = &experiments_extremes_form,
      [EXPERIMENTS_LINEAR] = &experiments_linear_form,
      [EXPERIMENTS_STEP_SIZES] = &experiments_matrix_form,
      [EXPERIMENTS_WORK_PRECISION] = &experiments_sweep_form,
      [EXPERIMENTS_VARIABLE] = &experiments_sweep_form,
  };
  return forms[kind];
}

thrum_status experiments_run(const experiments_request *request, const experiments_bodies *bodies,
                             bool *flagged, thrum_error *error) {
  typedef thrum_status kind(const experiments_request *request, const experiments_bodies *bodies,
                            bool *flagged, thrum_error *error);

  // those that share a function differ in their plan only
  static kind *const kinds[] = {
      [EXPERIMENTS_MATRIX] = experiments_matrix,  [EXPERIMENTS_LONG] = experiments_long,
      [EXPERIMENTS_SWEEP] = experiments_sweep,    [EXPERIMENTS_EXTREMES] = experiments_extremes,
      [EXPERIMENTS_LINEAR] = experiments_linear,  [EXPERIMENTS_STEP_SIZES] = experiments_matrix,
      [EXPERIMENTS_VARIABLE] = experiments_sweep, [EXPERIMENTS_WORK_PRECISION] = experiments_sweep,
  };
  return kinds[request->kind](request, bodies, flagged, error);
}
