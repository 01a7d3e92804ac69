/* Speed against accuracy: one load script, stepped by the full-order body of the same mesh
 * and by reduced models over rank, precision, integrator, time step and tolerance (design 14).
 *
 * Fields are compared at equally spaced times in the norm of the mass: |U q - u|^2 =
 * |u|^2 - 2 q U^T M u + |q|^2 as U^T M U = 1. Three errors are told apart: of the basis (a tightly
 * solved run in that basis against the full order), in time (a run against the tight one of its
 * basis), and of both together (against the full order).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_TRADEOFF_TRADEOFF_H
#define THRUM_VALIDATION_TRADEOFF_TRADEOFF_H

#include <stdio.h>

#include "precompute/model/model_fem.h"
#include "precompute/precompute.h"
#include "validation/experiments/experiment_body.h"
#include "validation/experiments/scheme.h"

#define TRADEOFF_SAMPLES 64
#define TRADEOFF_LIST_MAX 16

/* The settings to be compared. `model` needs a mesh, a basis and fixed vertices. */
typedef struct tradeoff_problem {
  const thrum_model *model;
  int64_t load_count;
  const thrum_load *courses; /* load_count */
  const double *forces;      /* load_count x 3 vertex_count [N] */
  double damping_alpha, damping_beta;
  double time;    /* [s] */
  double full_dt; /* of the full order [s] */
  int64_t rank_count, dt_count, tolerance_count;
  int64_t modes[2 * TRADEOFF_LIST_MAX]; /* rank_count; 0: the model's own basis, with its rank */
  int64_t ranks[2 * TRADEOFF_LIST_MAX];
  bool single[2 * TRADEOFF_LIST_MAX]; /* coefficients rounded to single precision; not of an own */
  double dts[TRADEOFF_LIST_MAX];
  double tolerances[TRADEOFF_LIST_MAX];
  bool integrators[EXPERIMENT_SCHEME_COUNT];
  int threads;
  /* Called as a stage advances; may be NULL. */
  bool (*progress)(void *context, const char *stage, double fraction);
  void *progress_context;
} tradeoff_problem;

/* Errors relative to the largest of the reference over the time: root mean square of displacement
 * and velocity, largest of the energy. */
typedef struct tradeoff_errors {
  double displacement, velocity, energy;
} tradeoff_errors;

/* A basis, and what its tightly solved run shows. */
typedef struct tradeoff_basis {
  int64_t modes, rank;   /* modes 0: the model's own */
  bool single;           /* its coefficients */
  tradeoff_errors error; /* of the basis */
  double tight_dt;
  double precompute_seconds; /* processor time; NaN: the model's own */
} tradeoff_basis;

typedef struct tradeoff_run {
  int64_t basis; /* which */
  experiment_scheme integrator;
  double dt, tolerance;
  bool stable;                /* came to its end with an energy that a body of this load can have */
  double us_per_step;         /* processor time */
  double cost;                /* processor seconds a simulated second */
  tradeoff_errors error;      /* against the full order; NaN where not stable */
  tradeoff_errors time_error; /* against the tight run of the basis */
  double drift; /* change of the mean energy after the last load; NaN with damping or load */
  /* The mode, among those that the load moves, whose frequency a step gets most wrong: which it is,
   * by how much relatively, and both frequencies [Hz]; stepped NaN: it does not vibrate. */
  int64_t frequency_mode;
  double frequency_error, frequency, stepped_frequency;
  bool front; /* no run is both cheaper and more accurate */
} tradeoff_run;

typedef struct tradeoff_result {
  int64_t basis_count, run_count;
  tradeoff_basis *bases;
  tradeoff_run *runs;
  int64_t free_count;      /* components of the full order */
  double full_us_per_step; /* processor time */
  double full_cost;        /* processor seconds a simulated second */
  int64_t dropped;         /* bases that could not be made, and why the last one could not */
  thrum_error dropped_reason;
  double full_error; /* of the reference in time: the finest basis at full_dt against tight */
} tradeoff_result;

/* Free with tradeoff_free. A basis that the mesh does not have is dropped, unless none is left.
 * THRUM_BAD_VALUE when the load moves nothing in the time; THRUM_INTERRUPTED when progress says so.
 */
thrum_status tradeoff_solve(const tradeoff_problem *problem, tradeoff_result *result,
                            thrum_error *error);
void tradeoff_free(tradeoff_result *result);

/* The cheapest run whose displacement error is at most `error`, or the most accurate whose cost is
 * at most `cost`; NaN: no limit, but one of them must be a number. -1: there is none. */
int64_t tradeoff_choose(const tradeoff_result *result, double error, double cost);

/* The runs as comma-separated values, one row for each. */
void tradeoff_csv(FILE *stream, const tradeoff_result *result);

/* --- inside ----------------------------------------------------------------------------------- */

/* The reference at the sample times, index 1 to TRADEOFF_SAMPLES of time / TRADEOFF_SAMPLES. */
typedef struct tradeoff_reference {
  thrum_model_fem body;
  int64_t n;      /* free components */
  double *mass_u; /* TRADEOFF_SAMPLES x n: M u */
  double *mass_v; /* M v */
  double u_square[TRADEOFF_SAMPLES], v_square[TRADEOFF_SAMPLES], energy[TRADEOFF_SAMPLES];
  double us_per_step;
} tradeoff_reference;

thrum_status tradeoff_reference_make(const tradeoff_problem *problem, tradeoff_reference *reference,
                                     thrum_error *error);
void tradeoff_reference_free(tradeoff_reference *reference);

/* A reduced run's samples: q and p (TRADEOFF_SAMPLES x rank each) and energies. */
typedef struct tradeoff_samples {
  double *q, *p;
  double energy[TRADEOFF_SAMPLES];
} tradeoff_samples;

/* Data that the runs of one basis share. */
typedef struct tradeoff_space {
  const thrum_model *model;
  thrum_precomputed made; /* empty for the model's own */
  void *packed;           /* its coefficients as steps read them, or NULL */
  double *directions;     /* load_count x rank */
  double *reference_q;    /* TRADEOFF_SAMPLES x rank: U^T M u */
  double *reference_p;
  tradeoff_samples tight;
} tradeoff_space;

/* Values and slopes at the two ends of a step to every sample time in it: cubic Hermite. `from` and
 * `to`: q then p (2 x count). */
void tradeoff_sample(double time, double begin, double dt, int64_t count, const double *from,
                     const double *to,
                     void (*take)(void *context, int64_t index, double share, const double *value),
                     void *context, double *work);

#endif
