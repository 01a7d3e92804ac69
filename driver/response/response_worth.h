/* What a curve is worth for the mesh: the unreduced body is started on an orbit and stepped for a
 * period. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_WORTH_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_WORTH_H

#include "driver/response/response_curve.h"

#define RESPONSE_WORTH_MOST 16 /* points that are looked at */

/* How far the end of a period is from its start, over the largest displacement on the way (root
 * mean squares over the vertices) [1]. */
typedef struct response_worth_point {
  int64_t row;
  double mesh;  /* of the unreduced body */
  double model; /* of all coordinates of the model, by the same steps */
  double gain; /* of the unreduced body's energy in the period, over what the curve's damping takes;
                  NaN where nothing damps */
} response_worth_point;

typedef struct response_worth {
  response_worth_point points[RESPONSE_WORTH_MOST];
  int64_t count;
  bool stopped;   /* before all that were to be looked at */
  bool left_out;  /* the mesh takes so long that no motion was looked at, as nobody asked for it */
  double largest; /* of the mesh */
  double seconds;
} response_worth;

/* Looks at as many stable motions of the curve as the request asks for, or the size of the mesh
 * allows: the largest one, and others evenly between both ends. */
thrum_status response_worth_find(const response_curve *curve, response_worth *worth,
                                 thrum_error *error);

#endif
