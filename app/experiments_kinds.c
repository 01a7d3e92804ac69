/* The kinds of `thrum experiments`: their names, what they write, and who runs them.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/experiments.h"

// those that share a function differ in their plan only
static const struct {
  const char *name;
  const experiments_form *form;
  experiments_runner *run;
} kinds[] = {
    [EXPERIMENTS_MATRIX] = {"matrix", &experiments_matrix_form, experiments_matrix},
    [EXPERIMENTS_LONG] = {"long", &experiments_long_form, experiments_long},
    [EXPERIMENTS_SWEEP] = {"sweep", &experiments_sweep_form, experiments_sweep},
    [EXPERIMENTS_EXTREMES] = {"extremes", &experiments_extremes_form, experiments_extremes},
    [EXPERIMENTS_LINEAR] = {"linear", &experiments_linear_form, experiments_linear},
    [EXPERIMENTS_STEP_SIZES] = {"step_sizes", &experiments_matrix_form, experiments_matrix},
    [EXPERIMENTS_WORK_PRECISION] = {"work_precision", &experiments_sweep_form, experiments_sweep},
    [EXPERIMENTS_VARIABLE] = {"variable", &experiments_sweep_form, experiments_sweep},
};

void experiments_kind_fill(experiments_request *request) {
  request->name = kinds[request->kind].name;
  request->form = kinds[request->kind].form;
}

thrum_status experiments_run(const experiments_request *request, const experiments_bodies *bodies,
                             bool *flagged, thrum_error *error) {
  return kinds[request->kind].run(request, bodies, flagged, error);
}
