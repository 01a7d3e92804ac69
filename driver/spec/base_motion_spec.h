/* A base's motion as the command line names it: FILE.csv or sine:AX,AY,AZ,f=HZ[,from=S][,until=S].
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_BASE_MOTION_SPEC_H
#define THRUM_DRIVER_SPEC_BASE_MOTION_SPEC_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/thrum.h"

/* One parsed base motion. `text` is borrowed from where it was given and names the file of one. */
typedef struct base_motion_spec {
  const char *text;
  bool sine;
  double amplitude[3]; /* of the acceleration [m/s^2] */
  thrum_load course;
  thrum_base_motion motion; /* of a file, once it is read; its arrays lie in `memory` */
  double *memory;
} base_motion_spec;

/* Parses a base motion; a failure is a mistake of usage. *base motion is untouched then. */
thrum_status base_motion_parse(const char *text, base_motion_spec *base_motion, thrum_error *error);

/* Reads the file of one that has one; base_motion_close frees. */
thrum_status base_motion_read(base_motion_spec *base_motion, thrum_error *error);
void base_motion_close(base_motion_spec *base_motion);

/* Mean acceleration of the base over a step, of all base motions together [m/s^2]. */
void base_motions_mean(const base_motion_spec *base_motions, int64_t count, int64_t step, double dt,
                       double mean[3]);

/* Where the base is [m]. */
void base_motions_position(const base_motion_spec *base_motions, int64_t count, double time,
                           double position[3]);

/* When the base accelerates for the last time [s]; may be INFINITY. */
double base_motion_end(const base_motion_spec *base_motion);

#endif
