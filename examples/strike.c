/* Tunes a strike: which blow at the tip of a beam brings the tip to a given place at a given time?
 * Newton's method asks the gradient of the run for how the place changes with the blow.
 *   strike beam.npz
 * Also links thrum_gradient (pkg-config thrum-gradient). SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/gradient.h"
#include "thrum/thrum.h"

enum { STEPS = 400, STRIKE = 10, AXES = 2 };
static const double dt = 0.001;                  /* [s]: the place is to be reached after 0.4 s, */
static const double place[AXES] = {0.03, -0.08}; /* to the side and down [m] */

typedef struct beam {
  const thrum_model *model;
  thrum_state *state;
  thrum_tape *tape;
  double *force, *force_bar; /* STEPS x rank */
  double *bar;               /* (STEPS + 1) x rank */
  double *unit[AXES];        /* what 1 N at the tip does, y and z: also the tip's y and z of q */
} beam;

static double dot(const double *a, const double *b, int64_t n) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

/* Makes the run of a blow [N] that lasts STRIKE steps, and says where the tip ends. */
static thrum_status strike(beam *b, const double *blow, double *end, thrum_error *error) {
  const int64_t r = b->model->rank;
  for (int64_t k = 0; k < STRIKE; k++)
    for (int64_t i = 0; i < r; i++)
      b->force[k * r + i] = blow[0] * b->unit[0][i] + blow[1] * b->unit[1][i];
  thrum_status status = thrum_tape_start(b->model, b->tape, b->state, NULL, NULL, error);
  if (status >= 0)
    status = thrum_tape_run(b->model, b->tape, b->state, b->force, STEPS, NULL, error);
  for (int axis = 0; axis < AXES && status >= 0; axis++)
    end[axis] = dot(b->unit[axis], thrum_tape_q(b->tape) + STEPS * r, r);
  return status;
}

/* How the end of the run changes with the blow: a row for each axis of the place. */
static thrum_status slopes(beam *b, double slope[AXES][AXES], thrum_error *error) {
  const int64_t r = b->model->rank;
  for (int axis = 0; axis < AXES; axis++) {
    thrum_tape_gradient gradient = {.force = b->force_bar};
    memcpy(b->bar + STEPS * r, b->unit[axis], (size_t)r * sizeof *b->bar);
    const thrum_status status =
        thrum_tape_pull_back(b->model, b->tape, b->bar, NULL, &gradient, error);
    if (status < 0)
      return status;
    for (int by = 0; by < AXES; by++) {
      slope[axis][by] = 0;
      for (int64_t k = 0; k < STRIKE; k++)
        slope[axis][by] += dot(b->force_bar + k * r, b->unit[by], r);
    }
  }
  return THRUM_OK;
}

static thrum_status open_beam(const char *path, beam *b, thrum_error *error) {
  const int32_t *tip;
  int64_t tip_count;
  thrum_state_def def = thrum_default_state_def();
  thrum_tape_def tape_def = thrum_default_tape_def();
  def.dt = dt;
  tape_def.steps = STEPS;
  thrum_status status = thrum_model_load(path, &b->model, error);
  if (status >= 0)
    status = thrum_model_group(b->model, "tip", &tip, &tip_count, error);
  if (status >= 0)
    status = thrum_state_create(b->model, &def, &b->state, error);
  if (status >= 0)
    status = thrum_tape_create(b->model, &tape_def, &b->tape, error);
  if (status < 0)
    return status;

  // a force of 1 N does to q what shows the displacement along it
  const size_t r = (size_t)b->model->rank;
  b->force = calloc((2 * STEPS + STEPS + 1 + AXES) * r, sizeof *b->force);
  if (!b->force)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  b->force_bar = b->force + STEPS * r;
  b->bar = b->force_bar + STEPS * r;
  for (int axis = 0; axis < AXES && status >= 0; axis++) {
    const double newton[3] = {0, axis == 0, axis == 1};
    b->unit[axis] = b->bar + (STEPS + 1) * r + (size_t)axis * r;
    status = thrum_load_add_shared(b->model, tip, tip_count, newton, b->unit[axis], error);
  }
  return status;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  beam b = {0};
  double blow[AXES] = {0, -100}, off = INFINITY;
  if (argc != 2 || open_beam(argv[1], &b, &error) < 0)
    return fprintf(stderr, "usage: strike MODEL.npz\n%s\n", error.message), 1;

  // Newton's method; a run that is far off is followed by half a step
  for (int n = 0; n < 20 && off > 1e-6; n++) {
    double end[AXES], slope[AXES][AXES];
    if (strike(&b, blow, end, &error) < 0 || slopes(&b, slope, &error) < 0)
      return fprintf(stderr, "strike: %s\n", error.message), 1;
    const double y = place[0] - end[0], z = place[1] - end[1];
    off = sqrt(y * y + z * z);
    printf("a blow of %+9.3f, %+9.3f N brings the tip to %+.5f, %+.5f m: %.2g m off\n", blow[0],
           blow[1], end[0], end[1], off);
    const double whole = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
    const double by = off > 0.05 ? 0.5 : 1;
    blow[0] += by * (y * slope[1][1] - z * slope[0][1]) / whole;
    blow[1] += by * (z * slope[0][0] - y * slope[1][0]) / whole;
  }

  thrum_tape_destroy(b.tape);
  thrum_state_destroy(b.state);
  thrum_model_destroy(b.model);
  free(b.force);
  return off > 1e-6; // the place is reached
}
