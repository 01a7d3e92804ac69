/* The file of `thrum static --path`: one row for each equilibrium, of a reduced model or of the
 * whole mesh. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_STATICS_STATIC_PATH_H
#define THRUM_DRIVER_STATICS_STATIC_PATH_H

#include "driver/statics/static_options.h"
#include "io/file.h"

/* Fills the mean displacement [m] of a target of the request at the equilibrium at hand. */
typedef thrum_status static_path_mean(const void *context, const load_target *target,
                                      double mean[3], thrum_error *error);

typedef struct static_path {
  const static_request *request;
  static_path_mean *mean;
  thrum_file_writer writer;
  thrum_status status; /* of the rows so far, with its error */
  thrum_error error;
} static_path;

/* What a row has beside the displacements. */
typedef struct static_path_point {
  double factor, energy; /* of the load [1], and V [J] */
  double least;          /* least eigenvalue of the tangent [1/s^2]; NaN: not known */
  bool jumped;           /* the body fell to this equilibrium */
} static_path_point;

/* Begins the file with its header, where the request wants one; else nothing is done here and
 * below. */
thrum_status static_path_open(const static_request *request, static_path_mean *mean,
                              static_path *path, thrum_error *error);

/* Adds a row; what fails is kept for static_path_close. */
void static_path_put(static_path *path, const static_path_point *point, const void *context);

/* Ends the file, or gives the failure of a row. */
thrum_status static_path_close(static_path *path, thrum_error *error);

/* Leaves no file where it was not closed. */
void static_path_abandon(static_path *path);

#endif
