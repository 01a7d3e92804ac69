/* Measures what a step of a condensed model costs: the processor time of `thrum_step` with the
 * whole model and with it condensed to 12, 9 and 4 coordinates. The figure is the least of batches,
 * which take turns within one run. thrum_condensed_cost MODEL.npz SWING The body starts with the
 * momentum in its first mode that would swing it by SWING [m]. SPDX-License-Identifier: Apache-2.0
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "platform/clock.h"
#include "thrum/thrum.h"

#define BATCHES 25
#define STEPS 2000
#define STEP 0.003 /* [s] */

typedef struct runner {
  int64_t masters; /* 0: all coordinates */
  thrum_integrator integrator;
  const thrum_model *model;
  void *memory; /* of a condensed model */
  thrum_state *state;
  double least; /* [us] */
} runner;

// the model that is stepped
static thrum_status condense(const thrum_model *whole, runner *r, thrum_error *error) {
  r->model = whole;
  if (r->masters == 0)
    return THRUM_OK;
  size_t size;
  THRUM_TRY(thrum_model_condense_size(whole, r->masters, &size, error));
  r->memory = thrum_allocate_aligned(size, "a condensed model", error);
  return r->memory ? thrum_model_condense(r->memory, size, whole, r->masters, &r->model, error)
                   : THRUM_OUT_OF_MEMORY;
}

static thrum_status make(const thrum_model *whole, double momentum, runner *r, thrum_error *error) {
  THRUM_TRY(condense(whole, r, error));
  thrum_state_def def = thrum_default_state_def();
  def.integrator = r->integrator;
  def.dt = STEP;
  THRUM_TRY(thrum_state_create(r->model, &def, &r->state, error));
  const double p[THRUM_RANK_MAX] = {momentum};
  r->least = INFINITY;
  return thrum_state_set(r->model, r->state, NULL, p, error);
}

static thrum_status run_batch(runner *r, thrum_error *error) {
  const double begun = clock_process_seconds();
  int64_t made;
  const thrum_status status = thrum_steps(r->model, r->state, STEPS, &made, error);
  r->least = fmin(r->least, 1e6 * (clock_process_seconds() - begun) / STEPS);
  return status < 0 ? status : THRUM_OK;
}

static thrum_status measure(const thrum_model *whole, double swing, thrum_error *error) {
  runner runners[] = {
      {.masters = 0, .integrator = THRUM_INTEGRATOR_ENERGY},
      {.masters = 12, .integrator = THRUM_INTEGRATOR_ENERGY},
      {.masters = 12, .integrator = THRUM_INTEGRATOR_VERLET},
      {.masters = 12, .integrator = THRUM_INTEGRATOR_MANIFOLD},
      {.masters = 9, .integrator = THRUM_INTEGRATOR_ENERGY},
      {.masters = 9, .integrator = THRUM_INTEGRATOR_VERLET},
      {.masters = 4, .integrator = THRUM_INTEGRATOR_ENERGY},
      {.masters = 4, .integrator = THRUM_INTEGRATOR_VERLET},
      {.masters = 4, .integrator = THRUM_INTEGRATOR_MANIFOLD},
  };
  const int count = (int)(sizeof runners / sizeof *runners);
  double extents[THRUM_RANK_MAX];
  THRUM_TRY(thrum_basis_extents(whole, extents, error));
  const double momentum = sqrt(whole->omega2[0]) * swing / extents[0];

  // all of them by turns, so that what else the machine does meets all of them
  thrum_status status = THRUM_OK;
  for (int n = 0; n < count && status >= 0; n++)
    status = make(whole, momentum, &runners[n], error);
  for (int batch = 0; batch < BATCHES; batch++)
    for (int n = 0; n < count && status >= 0; n++)
      status = run_batch(&runners[n], error);

  if (status >= 0)
    printf("coordinates,integrator,us,times_less\n");
  for (int n = 0; n < count; n++) {
    runner *r = &runners[n];
    if (status >= 0)
      printf("%d,%s,%.3f,%.1f\n", (int)r->model->rank, thrum_integrator_name(r->integrator),
             r->least, runners[0].least / r->least);
    thrum_state_destroy(r->state);
    free(r->memory);
  }
  return status;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  const thrum_model *whole = NULL;
  const double swing = argc == 3 ? atof(argv[2]) : 0;
  if (!(swing > 0) || thrum_model_load(argv[1], &whole, &error) < 0 ||
      measure(whole, swing, &error) < 0)
    return fprintf(stderr, "usage: thrum_condensed_cost MODEL.npz SWING\n%s\n", error.message), 1;
  thrum_model_destroy(whole);
  return 0;
}
