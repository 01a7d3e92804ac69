/* A model fitted to a recorded motion by least squares. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_IDENTIFY_IDENTIFY_FIT_H
#define THRUM_DRIVER_IDENTIFY_IDENTIFY_FIT_H

#include "driver/identify/identify_options.h"
#include "driver/identify/recording.h"
#include "driver/identify/region_body.h"

typedef enum identify_kind {
  IDENTIFY_YOUNG,   /* E of region `index`, of which x is the logarithm of a factor */
  IDENTIFY_DENSITY, /* its density, likewise */
  IDENTIFY_POISSON, /* its Poisson's ratio, (exp x - 2)/(2 exp x + 2) with x between all numbers */
  IDENTIFY_RATIO,   /* damping ratio `index`; x is its logarithm, as of the next two */
  IDENTIFY_ALPHA,   /* of the mass */
  IDENTIFY_BETA,    /* of the stiffness */
  IDENTIFY_START_Q, /* coordinate `index` at time 0; x is the number itself, as of the next */
  IDENTIFY_START_P
} identify_kind;

typedef struct identify_parameter {
  identify_kind kind;
  int64_t index;
  char name[128];
  const char *unit;
  double first;     /* value from which the fit began */
  double value;     /* that was found */
  double deviation; /* standard deviation; infinite: the recording does not show it */
  double doubt;     /* that over the value, of a start as motion over that recorded */
} identify_parameter;

typedef struct identify_fit {
  const identify_request *request;
  const thrum_model *model;
  recording recording;
  region_shares shares;
  int64_t modes;  /* coordinates that are linear modes */
  double *seen;   /* columns x rank: displacement by coordinate of the model */
  double *q, *p;  /* the start that was given, rank each */
  double dt;      /* [s] */
  int64_t steps;  /* up to the last row */
  double *fitted; /* rows x columns [m] */

  identify_parameter *parameters;
  int64_t count;
  double *x;            /* count, what is fitted */
  double *best_x, best; /* that of the least sum of squares over the whole recording, and this */
  double rms;           /* of what is left [m] */
  double motion;        /* root mean square of the recording [m] */
  double repeated;      /* share of what is left, of its square, that is no noise; 0: all may be */
  int64_t iterations, runs;
  bool converged;
  double seconds;

  /* Of the fit under way. */
  thrum_tape *tape;
  double *change, *jacobian, *residual, *normal; /* as identify_fit.c says */
} identify_fit;

/* Reads the recording and makes ready what is asked for; the model and the request stay the
 * caller's. identify_fit_close frees, whatever came back. */
thrum_status identify_fit_open(const identify_request *request, const thrum_model *model,
                               identify_fit *fit, thrum_error *error);
void identify_fit_close(identify_fit *fit);

/* Does the fit leave so much of the motion that it explains nothing? Deviations are infinite then.
 */
bool identify_fit_poor(const identify_fit *fit);

/* Is much of the motion left that is no noise? Then the model is wrong, and parameters make up for
 * it by more than their deviations, which are those of noise. */
bool identify_fit_misses(const identify_fit *fit);

/* By how much a parameter may be off where all of that is of its own kind; NaN: it is not known. */
double identify_fit_off(const identify_fit *fit, const identify_parameter *parameter);

/* Fits. What does not converge is done, and says so. */
thrum_status identify_fit_run(identify_fit *fit, thrum_error *error);

#endif
