/* The motion of the full-order body under loads, at equally spaced times: what bases are trained on
 * and reduced models are measured against. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_FULL_MOTION_H
#define THRUM_DRIVER_MAKE_FULL_MOTION_H

#include <stdbool.h>

#include "driver/spec/base_motion_spec.h"
#include "precompute/model/model_fem.h"

/* Samples of a run: those that errors are measured at, and the snapshots that a basis is trained
 * on, every second of which is one of the former. */
#define FULL_MOTION_SAMPLES 64
#define FULL_MOTION_SNAPSHOTS (2 * FULL_MOTION_SAMPLES)

/* Loads and base motions that act together on a body, from where it starts, and for how long it is
 * followed. */
typedef struct full_motion_script {
  int64_t load_count;
  const thrum_load *courses; /* load_count */
  const double *forces;      /* load_count x 3 vertex_count, at full strength [N] */
  int64_t base_motion_count;
  const base_motion_spec *base_motions; /* base_motion_count, read; displacements are relative */
  const double *held_by; /* 3 vertex_count: the body starts at the equilibrium under these [N], */
  const double *start;   /* and is displaced by these from there [m]; NULL: neither */
  double damping_alpha, damping_beta;
  double time;  /* [s] */
  double yield; /* beyond which the body flows at once; 0: it does not */
} full_motion_script;

/* Values and slopes at the two ends of a step to every sample time in it, index 0 to samples - 1 at
 * (index + 1) time / samples: cubic Hermite. `from` and
 * `to`: values, then slopes (2 x count), as `take` gets them with where in the step the sample
 * lies; `work` (2 x count) holds them. */
void full_motion_between(double time, int64_t samples, double begin, double dt, int64_t count,
                         const double *from, const double *to,
                         void (*take)(void *context, int64_t index, double share,
                                      const double *value),
                         void *context, double *work);

/* `take` receives the samples, and `progress` is told how far the run is; it may be NULL, and stops
 * the run where it answers false. */
typedef struct full_motion_observer {
  int64_t samples;
  /* u and v: 3 vertex_count each; energy: kinetic and potential [J]. */
  void (*take)(void *context, int64_t index, const double *u, const double *v, double energy);
  void *context;
  bool (*progress)(void *context, double fraction);
  void *progress_context;
} full_motion_observer;

/* Steps the full order of the model's mesh (`energy`) through the script. *us_per_step: processor
 * time of a step; may be NULL. THRUM_INTERRUPTED when progress says so. */
thrum_status full_motion_run(const thrum_model *model, const full_motion_script *script, double dt,
                             const full_motion_observer *observer, double *us_per_step,
                             thrum_error *error);

/* The same script on a reduced model, whose loads the caller has. q (rank) is where it starts: the
 * model's own equilibrium, and from there U^T M of the displacement; `body` is its mesh. */
thrum_status full_motion_reduced_start(const thrum_model *model, const thrum_model_fem *body,
                                       const full_motion_script *script, double *q,
                                       thrum_error *error);

/* force (rank) += the inertia of the base's mean acceleration over a step. */
thrum_status full_motion_reduced_base(const thrum_model *model, const full_motion_script *script,
                                      int64_t step, double dt, double *force, thrum_error *error);

#endif
