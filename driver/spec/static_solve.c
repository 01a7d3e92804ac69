/* Loads, memory and the runtime's search for an equilibrium. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/static_solve.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "core/base/pi.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

#define ROUNDING 1e-9 /* of where an answer began: what is left of it without a load */

static thrum_status add_loads(const thrum_model *model, const load_spec *loads, int64_t count,
                              double *one, double *sum, thrum_error *error) {
  for (int64_t n = 0; n < count; n++) {
    THRUM_TRY(load_spec_reduce(model, &loads[n], one, error));
    for (int64_t i = 0; i < model->rank; i++)
      sum[i] += one[i];
  }
  return THRUM_OK;
}

static double largest_of(int64_t count, const double *values) {
  double largest = 0;
  for (int64_t i = 0; i < count; i++)
    largest = fmax(largest, fabs(values[i]));
  return largest;
}

static void warn_free(const thrum_model *model, const char *said) {
  if (model->rigid != NULL)
    config_warn("%s: nothing holds the body: what would move it as a whole has no effect", said);
}

/* Warns of loads that are allowed and yet hardly meant. */
static void warn_idle(const thrum_model *model, const char *said, const double *load) {
  if (largest_of(model->rank, load) == 0)
    config_warn("%s: the load moves nothing: it is zero, or all that it acts on is held", said);
  else
    warn_free(model, said);
}

/* The model under the levels of the problem; *levels are the caller's to free, and NULL where
 * nothing acts. */
static thrum_status act_on(const static_problem *problem, double **levels, thrum_model *acting,
                           thrum_error *error) {
  double whole[THRUM_ACTUATORS_MAX];
  if (!actuate_specs_act(problem->model, problem->actuate_count))
    return THRUM_OK;
  THRUM_TRY(actuate_specs_check(problem->model, problem->actuates, problem->actuate_count, error));
  actuate_specs_strength(problem->model, problem->actuates, problem->actuate_count, 1, whole);
  THRUM_TRY(thrum_reserve(levels, thrum_model_actuation_count(problem->model), sizeof **levels,
                          "the levels", error));
  const thrum_status status = thrum_model_actuate(problem->model, whole, *levels, acting, error);
  if (status < 0)
    free(*levels);
  return status;
}

/* The equilibrium of the model, which has its levels. */
static thrum_status solve_for(const static_problem *problem, const thrum_model *model, double *q,
                              double *mode, thrum_equilibrium_report *report, thrum_error *error) {
  size_t size = 0;
  double one[THRUM_RANK_MAX], sum[THRUM_RANK_MAX] = {0};
  THRUM_TRY(thrum_equilibrium_size(model, &size, error));
  THRUM_TRY(add_loads(model, problem->loads, problem->count, one, sum, error));
  void *workspace = NULL;
  THRUM_TRY(thrum_reserve_aligned(&workspace, size, "an equilibrium", error));

  // a load that nothing answers is a mistake more often than not
  if (problem->actuate_count == 0)
    warn_idle(model, problem->said, sum);
  else
    warn_free(model, problem->said);

  // an answer is continued from the forces that hold it
  thrum_equilibrium_def def = problem->def;
  def.visit = problem->progress.report;
  def.context = problem->progress.context;
  def.mode = mode;
  double base[THRUM_RANK_MAX];
  const bool unloads =
      problem->from && problem->actuate_count == 0 && largest_of(model->rank, sum) == 0;
  const double began = unloads ? largest_of(model->rank, q) : 0;
  if (problem->from) {
    thrum_internal_force(model, q, base, workspace);
    for (int64_t i = 0; i < model->rank; i++)
      sum[i] = def.factor * sum[i] - base[i];
    def.base = base;
    def.factor = 1;
  }

  const thrum_status status =
      thrum_equilibrium(model, &def, sum, q, workspace, size, report, error);

  // back at rest, what a solve leaves is no displacement of which anything could be told
  if (status >= 0 && unloads && largest_of(model->rank, q) <= ROUNDING * began) {
    memset(q, 0, (size_t)model->rank * sizeof *q);
    report->energy = report->load_energy = 0;
  }
  free(workspace);
  return config_error_in(error, status, "%.200s", problem->said);
}

thrum_status static_solve(const static_problem *problem, double *q, double *mode,
                          thrum_equilibrium_report *report, thrum_error *error) {
  const thrum_model *model = problem->model;
  thrum_model acting;
  double *levels = NULL;
  THRUM_TRY(act_on(problem, &levels, &acting, error));
  model = levels != NULL ? &acting : model;
  const thrum_status status = solve_for(problem, model, q, mode, report, error);
  free(levels);
  return status;
}

double static_hertz(double omega2) {
  return omega2 < 0 ? -sqrt(-omega2) / THRUM_TWO_PI : sqrt(omega2) / THRUM_TWO_PI;
}
