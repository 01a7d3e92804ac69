/* A slender beam clamped at both ends stretches as it bends, so its frequency rises with the
 * amplitude a: q'' + w^2 (q + e q^3/a^2) = 0 with e = 0.7193 (a/h)^2 for a rectangular section of
 * thickness h and the linear mode (Woinowsky-Krieger 1950, The effect of an axial force on the
 * vibration of hinged bars, doi:10.1115/1.4010053, and the one-mode solutions after it).
 *
 * The model is the linear mode and its derivative, r = 2; the derivative condensed statically
 * leaves V = 1/2 w^2 q^2 + 1/4 k q^4. The period is measured on steps of imexv.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "core/base/pi.h"
#include "thrum/polynomial.h"
#include "validation/published/published.h"

#define THICKNESS 0.02
#define STIFFNESS 198.463 /* E I / L^3, of the mode of unit amplitude in the middle */
#define HARDENING 0.7193

/* k of the condensed Duffing oscillator. */
static double condensed(const thrum_model *model) {
  const double slave = model->c3[thrum_c3_index(2, 0, 0, 1)];
  return 4 * (model->c4[thrum_c4_index(2, 0, 0, 0, 0)] - slave * slave / (2 * model->omega2[1]));
}

/* Largest displacement in z of a unit of the mode. */
static double middle_of(const thrum_model *model) {
  double most = 0;
  for (int64_t v = 0; v < model->vertex_count; v++)
    most = fmax(most, fabs(model->basis[(3 * v + 2) * 2]));
  return most;
}

/* Angular frequency of free motion from q_0 = amplitude at rest, by the first return to a turning
 * point: a quarter period is where q_0 passes zero. */
static thrum_status measure(const thrum_model *model, double amplitude, double *omega,
                            thrum_error *error) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  const double slave = model->c3[thrum_c3_index(2, 0, 0, 1)];
  double q[2] = {amplitude, -slave * amplitude * amplitude / model->omega2[1]}, before = amplitude;

  // the fast coordinate follows; the slow one is resolved
  def.dt = THRUM_TWO_PI / sqrt(model->omega2[0]) / 2000;
  thrum_state *state = NULL;
  thrum_status status = published_state(model, &def, q, NULL, &state, error);

  // a quarter of a period is over where q_0 passes zero, which lies between two steps
  int64_t step = 0;
  for (; status >= 0 && q[0] > 0 && step < 10000; step++) {
    before = q[0];
    status = thrum_step(model, state, error);
    THRUM_THEN(status, thrum_state_get(model, state, q, NULL, error));
  }
  thrum_state_destroy(state);
  const double quarter = def.dt * ((double)step - 1 + before / (before - q[0]));
  *omega = 0.5 * THRUM_PI / quarter;
  return status < 0 ? status : THRUM_OK;
}

/* The stiffnesses of one mesh, and of linear tetrahedra the frequencies at two amplitudes. */
static thrum_status hardening_rows(const published_sink *sink, int cells, int order,
                                   thrum_error *error) {
  const double linear = STIFFNESS * pow(THICKNESS, 3) / 12; // per unit of width, E = 1
  const double width = THICKNESS / cells;
  const bool ten = order == 2;
  published_body body = {
      .fix = {"x<1e-9", "x>0.999999", "y>-1e9:y"}, .material = {1, 0, 1}, .order = order};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@1x%.9gx%.9g", 50 * cells, cells, width,
           THICKNESS);
  thrum_precomputed made = {0};
  THRUM_TRY(published_precompute(&body, 1, 2, false, &made, error));
  const thrum_model *model = &made.model;

  // in units of the displacement in the middle and of the width
  const double middle = middle_of(model);
  published_add(sink, "hardening",
                ten ? "linear stiffness, ten nodes, N/m" : "linear stiffness, N/m", body.mesh,
                cells, linear, model->omega2[0] / (middle * middle) / width);
  published_add(sink, "hardening",
                ten ? "cubic stiffness, ten nodes, N/m^3" : "cubic stiffness, N/m^3", body.mesh,
                cells, HARDENING * linear / (THICKNESS * THICKNESS),
                condensed(model) / pow(middle, 4) / width);

  thrum_status status = THRUM_OK;
  for (int half = 1; half <= 2 && status >= 0 && !ten; half++) {
    const double ratio = 0.5 * half; // a/h
    double omega = 0;
    status = measure(model, ratio * THICKNESS / middle, &omega, error);
    published_add(sink, "hardening",
                  half == 1 ? "frequency ratio at a = h/2" : "frequency ratio at a = h", body.mesh,
                  cells, published_duffing(HARDENING * ratio * ratio),
                  omega / sqrt(model->omega2[0]));
  }
  thrum_precomputed_free(&made);
  return status;
}

thrum_status published_hardening(const published_sink *sink, thrum_error *error) {
  // each level halves the cells; ten nodes need fewer
  for (int level = 0; level <= sink->level + (sink->level > 0 ? 2 : 1); level++)
    THRUM_TRY(hardening_rows(sink, 1 << level, 0, error));
  for (int level = 0; level <= (sink->level > 1 ? sink->level : 1); level++)
    THRUM_TRY(hardening_rows(sink, 1 << level, 2, error));
  return THRUM_OK;
}
