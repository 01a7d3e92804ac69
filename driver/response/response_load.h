/* What drives a forced curve, as the command line names it.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_LOAD_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_LOAD_H

#include "driver/spec/load_spec.h"

/* A load or a motion of the base. `text` is borrowed from argv. */
typedef struct response_load {
  const char *text;
  bool base;        /* spec is not of use then, but */
  double vector[3]; /* the acceleration of the base [m/s^2] */
  load_spec spec;
  char vertex[40]; /* "vertex=N" where it acts at one; "": elsewhere */
  bool swings;     /* at the frequency of the curve; false: it is constant */
  double phase;    /* ahead of sin(Omega t) [rad] */
} response_load;

/* Parses a load: sine:X,Y,Z@TARGET[,phase=DEGREES] swings; constant:, gravity: and traction: are
 * always there. *load is untouched on failure, a mistake of usage. */
thrum_status response_load_parse(const char *text, response_load *load, thrum_error *error);

/* The same of a base: sine:AX,AY,AZ[,phase=DEGREES], accelerations in m/s^2. */
thrum_status response_base_parse(const char *text, response_load *load, thrum_error *error);

/* mean, cosine and sine (rank each) += what the load has in them. reduced (rank) is scratch. */
thrum_status response_load_add(const thrum_model *model, const response_load *load, double *mean,
                               double *cosine, double *sine, double *reduced, thrum_error *error);

#endif
