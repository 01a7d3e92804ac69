/* The errors of condensed models on swings: for each swing and number of masters the rms of q, in
 * the norm of the mass, against the same model uncondensed at a sixteenth of the step.
 *   thrum_condensed_errors MODEL.npz TIME SWING,... MASTERS,...
 * Momentum in mode 1 that would swing the body by SWING [m], steps of 3 ms for TIME [s], by
 * `energy` and by `manifold`. The last columns are what a run is flagged by, of `energy`.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/model/model_cut.h"
#include "driver/run/condensed_check.h"
#include "platform/allocate.h"

#define STEP 0.003 /* [s] */
#define FINER 16   /* steps of the reference in one */

typedef struct motion {
  int64_t steps, rank; /* recorded after each step, and coordinates of the whole model */
  double *q;           /* steps x rank */
} motion;

// The whole model, or the stepped one of it, from rest with a momentum in its first mode.
static thrum_status run(const thrum_model *model, thrum_integrator integrator, int finer,
                        double momentum, condensed_check *check, motion *out, thrum_error *error) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = integrator;
  def.dt = STEP / finer;
  thrum_state *state = NULL;
  THRUM_TRY(thrum_state_create(model, &def, &state, error));
  double x[THRUM_RANK_MAX] = {0}, v[THRUM_RANK_MAX] = {momentum};
  double *work = NULL;
  thrum_status status =
      thrum_reserve(&work, (int64_t)thrum_work_count(model), sizeof *work, "an energy", error);
  THRUM_THEN(status, thrum_state_set(model, state, NULL, v, error));

  // every step of the coarse run is recorded with all coordinates
  for (int64_t n = 0; n < out->steps && status >= 0; n++) {
    int64_t made;
    status = thrum_steps(model, state, finer, &made, error);
    THRUM_THEN(status, thrum_state_get(model, state, x, v, error));
    if (status < 0)
      break;
    thrum_condensed_shape(model, x, NULL, out->q + n * out->rank);
    if (check != NULL)
      condensed_check_look(check, x, v, thrum_strain_energy(model, x, work));
  }
  thrum_state_destroy(state);
  free(work);
  return status < 0 ? status : THRUM_OK;
}

static double error_of(const motion *found, const motion *truth) {
  double difference = 0, whole = 0;
  for (int64_t i = 0; i < truth->steps * truth->rank; i++) {
    difference += (found->q[i] - truth->q[i]) * (found->q[i] - truth->q[i]);
    whole += truth->q[i] * truth->q[i];
  }
  return sqrt(difference / whole);
}

// one row: `energy` and `manifold` on so many masters; a run that is lost has no error
static thrum_status measure(const thrum_model *whole, const char *name, double swing,
                            int64_t masters, double momentum, const motion *truth, motion *found,
                            thrum_error *error) {
  void *memory = NULL;
  const thrum_model *model;
  THRUM_TRY(model_condense_to(whole, masters, &memory, &model, error));
  condensed_check check;
  thrum_status status = condensed_check_open(model, &check, error);
  if (status >= 0) {
    simulate_figures figures = {0};
    const bool known = run(model, THRUM_INTEGRATOR_ENERGY, 1, momentum, &check, found, error) >= 0;
    const double energy = known ? error_of(found, truth) : NAN;
    condensed_check_report(&check, model, &figures);
    const bool again = run(model, THRUM_INTEGRATOR_MANIFOLD, 1, momentum, NULL, found, error) >= 0;
    printf("%s,%g,%d,%.3f,%.3f,%.3f,%.3f\n", name, swing, (int)masters, 100 * energy,
           100 * (again ? error_of(found, truth) : NAN), 100 * figures.inertia_share,
           100 * figures.energy_defect);
  }
  condensed_check_close(&check);
  free(memory);
  return status;
}

static thrum_status measure_swing(const thrum_model *whole, const char *name, double swing,
                                  const char *masters, motion *truth, motion *found,
                                  thrum_error *error) {
  double extents[THRUM_RANK_MAX];
  THRUM_TRY(thrum_basis_extents(whole, extents, error));
  const double momentum = sqrt(whole->omega2[0]) * swing / extents[0];
  THRUM_TRY(run(whole, THRUM_INTEGRATOR_ENERGY, FINER, momentum, NULL, truth, error));

  // the error of the coarse step alone, then the condensed models
  THRUM_TRY(run(whole, THRUM_INTEGRATOR_ENERGY, 1, momentum, NULL, found, error));
  printf("%s,%g,%d,%.3f,,,\n", name, swing, (int)whole->rank, 100 * error_of(found, truth));
  for (const char *at = masters; at != NULL; at = strchr(at, ',')) {
    at += *at == ',';
    THRUM_TRY(measure(whole, name, swing, atoll(at), momentum, truth, found, error));
  }
  return THRUM_OK;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  const thrum_model *whole = NULL;
  if (argc != 5 || thrum_model_load(argv[1], &whole, &error) < 0)
    return fprintf(stderr,
                   "usage: thrum_condensed_errors MODEL.npz TIME SWING,... MASTERS,...\n%s\n",
                   error.message),
           1;

  // two motions: what is compared with, and what is compared
  motion motions[2];
  thrum_status status = THRUM_OK;
  for (int n = 0; n < 2; n++) {
    motions[n] = (motion){.steps = llround(atof(argv[2]) / STEP), .rank = whole->rank};
    THRUM_THEN(status, thrum_reserve(&motions[n].q, motions[n].steps * whole->rank, sizeof(double),
                                     "a motion", &error));
  }

  // the name of the body is that of its file
  const char *slash = strrchr(argv[1], '/');
  printf("model,swing,masters,energy_percent,manifold_percent,inertia_share_percent,"
         "energy_defect_percent\n");
  for (const char *at = argv[3]; at != NULL && status >= 0; at = strchr(at, ',')) {
    at += *at == ',';
    status = measure_swing(whole, slash ? slash + 1 : argv[1], atof(at), argv[4], &motions[0],
                           &motions[1], &error);
  }
  if (status < 0)
    fprintf(stderr, "%s\n", error.message);
  free(motions[0].q);
  free(motions[1].q);
  thrum_model_destroy(whole);
  return status < 0;
}
