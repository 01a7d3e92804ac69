/* A soft free body that spins across its length and about it: its rotation and its shape are
 * stepped together (thrum/floating_frame.h). The program says every fifth of a second how fast it
 * turns about each of its axes, how much of its energy its shape has, and how far the whole energy
 * is from the start. spin free.npz SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "thrum/thrum.h"

/* All that a free body consists of. */
typedef struct spinning_body {
  const thrum_model *model;
  thrum_inertia *inertia;
  thrum_state *state;
  thrum_rigid_frame frame;
  double *work; /* scratch, and behind it a shape at rest */
} spinning_body;

/* Starts the body with an angular velocity, and its shape at rest. */
static thrum_status start(spinning_body *body, const double spin[3], thrum_error *error) {
  const thrum_state_def def = thrum_default_state_def();
  THRUM_TRY(thrum_inertia_create(body->model, 0, NULL, &body->inertia, error));
  THRUM_TRY(thrum_state_create(body->model, &def, &body->state, error));
  THRUM_TRY(thrum_rigid_frame_of(body->model, &body->frame, error));

  // the frame has the inertia of its shape from here on
  const size_t count = thrum_floating_frame_work_count(body->inertia);
  body->work = calloc(count + (size_t)body->model->rank, sizeof *body->work);
  if (body->work == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory");
  THRUM_TRY(thrum_floating_frame_settle(body->inertia, body->work + count, NULL, &body->frame,
                                        body->work, error));
  thrum_floating_frame_spin(NULL, spin, &body->frame);
  return THRUM_OK;
}

/* The energy of the shape and that of all [J]. */
static thrum_status energy(const spinning_body *body, double *shape, double *all,
                           thrum_error *error) {
  thrum_energies energies;
  THRUM_TRY(thrum_state_energies(body->model, body->state, &energies, error));
  *shape = energies.potential;
  *all = energies.kinetic + energies.potential + thrum_rigid_frame_energy(&body->frame, NULL);
  return THRUM_OK;
}

static thrum_status run(spinning_body *body, thrum_error *error) {
  const double spin[3] = {8, 0, 30}, none[3] = {0}; // [rad/s], [N m]
  double shape, all, first;
  THRUM_TRY(start(body, spin, error));
  THRUM_TRY(energy(body, &shape, &first, error));

  // a row every 0.2 s of four seconds
  for (int step = 1; step <= 1334; step++) {
    THRUM_TRY(thrum_floating_frame_step(body->model, body->state, body->inertia, NULL, &body->frame,
                                        none, NULL, body->work, error));
    if (step % 67 != 0)
      continue;
    double w[3];
    thrum_rigid_frame_velocity(&body->frame, NULL, w);
    THRUM_TRY(energy(body, &shape, &all, error));
    printf("%.1f s: turns by %7.3f %7.3f %7.3f rad/s, %.3f %% of the energy in the shape, energy "
           "off by %.0e\n",
           0.003 * step, w[0], w[1], w[2], 100 * shape / all, all / first - 1);
  }
  return THRUM_OK;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  spinning_body body = {.model = NULL};
  if (argc != 2 || thrum_model_load(argv[1], &body.model, &error) < 0)
    return fprintf(stderr, "usage: spin MODEL.npz\n%s\n", error.message), 1;

  const thrum_status status = run(&body, &error);
  if (status < 0)
    fprintf(stderr, "spin: %s\n", error.message);
  free(body.work);
  thrum_state_destroy(body.state);
  thrum_inertia_destroy(body.inertia);
  thrum_model_destroy(body.model);
  return status < 0;
}
