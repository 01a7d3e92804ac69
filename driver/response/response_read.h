/* A curve of periodic motions as `thrum response` left it in a folder.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_READ_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_READ_H

#include <stdbool.h>

#include "thrum/model.h"

#define RECORDED_TARGET_MAX 160

/* The motions in a folder, of all coordinates of their model. */
typedef struct recorded_curve {
  const thrum_model *model;
  char *model_path;
  int64_t rows;
  int64_t harmonics; /* of the motion below, 2 harmonics + 1 numbers a coordinate */
  int64_t periods;   /* of the load in one of the motion */
  double *frequency; /* rows: of the load [Hz] */
  double *peak;      /* rows: largest displacement of the first target [m]; NaN: there is none */
  int32_t *unstable; /* rows: multipliers outside of the unit circle; -1: nobody looked */
  int32_t *kind;     /* rows: a thrum_response_kind */
  double *motion;    /* rows x (2 harmonics + 1) x rank: mean, cosines, sines */
  char target[RECORDED_TARGET_MAX]; /* the first; "": there is none */
} recorded_curve;

/* Is there a response.json in the folder? */
bool is_curve_folder(const char *path);

/* Reads the folder and the model that it names (recorded_model_load). recorded_curve_free frees,
 * the model too. */
thrum_status recorded_curve_read(const char *path, recorded_curve *curve, thrum_error *error);
void recorded_curve_free(recorded_curve *curve);

/* Was the curve in the folder read from this file? Nothing may be written there. */
bool recorded_curve_holds(const char *folder, const recorded_curve *curve, const char *path);

#endif
