/* The stepper: one interface to everything that a run can step.
 *
 * Three kinds implement it: a reduced model (stepper_reduced.c), the same body in full order
 * (stepper_full.c) and a scene of several bodies (scene_run_stepper.c). The loop and the recorder
 * (run.h) see nothing else. A single model keeps its own kind although a scene of one body could
 * step it: a scene needs a mesh and an axis_mass to place what it steps, it has no full order, and
 * it sums the energies of a body in another order, so the last bits of energy.csv would change.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_STEPPER_H
#define THRUM_DRIVER_RUN_STEPPER_H

#include <stdbool.h>
#include <stdint.h>

#include "driver/run/simulate_figures.h"
#include "thrum/thrum.h"

/* The functions of one kind; `self` is what its opener made, bodies are numbered from 0. Those that
 * may be NULL say so. */
typedef struct driver_stepper_kind {
  int64_t steps_between_looks; /* at the clock, for the progress */
  bool stands_after_failure;   /* all bodies still stand at the step before a failed one */

  /* One step of all bodies, from `step` to the next. */
  thrum_status (*advance)(void *self, int64_t step, thrum_error *error);
  /* Steps that all bodies have made. */
  int64_t (*steps)(const void *self);

  /* The present energies; THRUM_NOT_FINITE once they overflow. */
  thrum_status (*energies)(void *self, int32_t body, thrum_energies *energies, thrum_error *error);
  /* The present coordinates q of the model (rank), for q.npy, measures and peaks. */
  thrum_status (*coordinates)(void *self, int32_t body, double *q, thrum_error *error);
  /* Raises *peak [m] and its vertex (0-based). NULL: taken from the coordinates and the basis. */
  void (*raise_peak)(void *self, int32_t body, double *peak, int64_t *vertex);
  /* Displacements of all vertices, vertex_count x 3, for a frame. */
  thrum_status (*displacements)(void *self, int32_t body, double *u, thrum_error *error);
  /* Velocities of all vertices, vertex_count x 3; NULL: they are in the snapshot. */
  thrum_status (*velocities)(void *self, double *v);
  /* Position and rotation of a free body as a column-major 4 x 4; NULL: bodies stay in place. */
  void (*placement)(const void *self, int32_t body, double matrix[16]);
  /* Records what else belongs to a row, such as probes; NULL: nothing. */
  thrum_status (*record_row)(void *self, int64_t step, double time, thrum_error *error);

  /* q and p to continue from (rank each); THRUM_NOT_FINITE: there is no such state. */
  thrum_status (*snapshot)(void *self, int32_t body, double *q, double *p, thrum_error *error);
  /* Counters, work and losses into the figures, and the body's own failure into its status. */
  void (*report)(const void *self, int32_t body, simulate_figures *figures);
  void (*close)(void *self);
} driver_stepper_kind;

/* Zeroed: none. */
typedef struct driver_stepper {
  const driver_stepper_kind *kind;
  void *self;
} driver_stepper;

/* Makes a stepper of `model`, which may be a condensed one, at the request's start, under its loads
 * and base motions, which are read here. The request and the model must stay. */
thrum_status driver_stepper_reduced(const simulate_request *request, const thrum_model *model,
                                    driver_stepper *stepper, thrum_error *error);
/* The same from q and p (rank each) in place of the request's starts; NULL: from those. */
thrum_status driver_stepper_reduced_from(const simulate_request *request, const thrum_model *model,
                                         const double *q, const double *p, driver_stepper *stepper,
                                         thrum_error *error);
thrum_status driver_stepper_full(const simulate_request *request, const thrum_model *model,
                                 driver_stepper *stepper, thrum_error *error);

/* Warns of loads, base motions and modes that a reduced model is allowed and hardly meant to have.
 */
void driver_stepper_reduced_warn(const driver_stepper *stepper);

/* Fine on a zeroed stepper. */
void driver_stepper_close(driver_stepper *stepper);

#endif
