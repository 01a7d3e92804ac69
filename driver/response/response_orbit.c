/* A period of a reduced model; see response_orbit.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/response/response_orbit.h"

#include <math.h>
#include <string.h>

#include "core/base/pi.h"
#include "thrum/thrum.h"

#define STEPS RESPONSE_ORBIT_STEPS

/* Where the coefficients of a motion are summed. */
typedef struct sums {
  int64_t rank, harmonics, steps;
  double *coefficients;
} sums;

void response_orbit_means(int64_t step, double *cosine, double *sine) {
  const double h = THRUM_TWO_PI / STEPS, from = h * (double)step, to = from + h;
  *cosine = (sin(to) - sin(from)) / h;
  *sine = (cos(from) - cos(to)) / h;
}

thrum_status response_orbit_run(const response_orbit *orbit, const double *q, const double *p,
                                thrum_status (*visit)(void *context, int64_t step, const double *q,
                                                      thrum_error *error),
                                void *context, thrum_error *error) {
  thrum_model damped = *orbit->model;
  damped.damping = orbit->rates;
  thrum_state_def def = thrum_default_state_def();
  def.dt = THRUM_TWO_PI / orbit->omega / STEPS;
  def.frequency_matched = 0;
  thrum_state *state = NULL;
  double now[THRUM_RANK_MAX], force[THRUM_RANK_MAX];
  THRUM_TRY(thrum_state_create(&damped, &def, &state, error));
  thrum_status status = thrum_state_set(&damped, state, q, p, error);
  for (int64_t step = 0; step < STEPS * orbit->periods && status >= 0; step++) {
    double cosine = 0, sine = 0;
    response_orbit_means(step, &cosine, &sine);
    for (int64_t i = 0; i < damped.rank; i++)
      force[i] = orbit->loads[0][i] + cosine * orbit->loads[1][i] + sine * orbit->loads[2][i];
    status = thrum_state_set_force(&damped, state, force, error);
    THRUM_THEN(status, thrum_step(&damped, state, error));
    THRUM_THEN(status, thrum_state_get(&damped, state, now, NULL, error));
    THRUM_THEN(status, visit(context, step, now, error));
  }
  thrum_state_destroy(state);
  return status;
}

static thrum_status add_step(void *context, int64_t step, const double *q, thrum_error *error) {
  const sums *s = context;
  const double share = 1 / (double)s->steps, phase = THRUM_TWO_PI * (double)(step + 1) * share;
  (void)error;
  for (int64_t k = 0; k <= s->harmonics; k++) {
    const double cosine = (k > 0 ? 2 : 1) * cos((double)k * phase) * share;
    const double sine = 2 * sin((double)k * phase) * share;
    for (int64_t i = 0; i < s->rank; i++) {
      s->coefficients[k * s->rank + i] += cosine * q[i];
      if (k > 0)
        s->coefficients[(s->harmonics + k) * s->rank + i] += sine * q[i];
    }
  }
  return THRUM_OK;
}

thrum_status response_orbit_coefficients(const response_orbit *orbit, const double *q,
                                         const double *p, int64_t rank, int64_t harmonics,
                                         double *coefficients, thrum_error *error) {
  sums s = {rank, harmonics, STEPS * orbit->periods, coefficients};
  memset(coefficients, 0, (size_t)((2 * harmonics + 1) * rank) * sizeof *coefficients);
  return response_orbit_run(orbit, q, p, add_step, &s, error);
}
