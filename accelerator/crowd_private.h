/* A crowd's arrays, and its passes over a part of the bodies; private to the accelerator library.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACCELERATOR_CROWD_PRIVATE_H
#define THRUM_ACCELERATOR_CROWD_PRIVATE_H

#include "accelerator/device.h"
#include "thrum/step_equation.h"

#define GROUP 8 /* columns of a work-item of the product, as in crowd.cl */

/* X(name): the passes, by their names in crowd.cl. */
#define PASSES(X)                                                                                  \
  X(products)                                                                                      \
  X(shift_back) X(shift_on) X(multiply) X(force) X(begin) X(iterate) X(commit) X(kick) X(energies)

/* X(name): the passes that only a model of cubature points needs. */
#define POINT_PASSES(X) X(increments) X(points) X(point_force) X(point_tangent) X(point_energies)

struct thrum_crowd {
  thrum_accelerator *accelerator;
  thrum_crowd_def def;
  int64_t rank, pairs, points; /* of V: cubature points; 0: a polynomial */
  int64_t columns;             /* of the matrix: for each pair, or nine for each point */
  int64_t all, part;           /* bodies with those that fill up, which rest; bodies of a part */
  thrum_step_form form;
  opencl_program program;
#define X(name) opencl_kernel pass_##name;
  PASSES(X)
  POINT_PASSES(X)
#undef X
  /* of all bodies; of the model; of a part */
  opencl_buffer q, p, timed, load, load_before, stopped;
  opencl_buffer matrix, pair_list, weights, point_moduli, omega2, length, drag;
  opencl_buffer d, x, y3, y4, start3, start4, before, along_before, now, along, factor, worst;
  opencl_buffer g, g_along, pull, pull_along; /* with points */
  opencl_buffer kinetic, strain;
  void *staging;  /* rank x all numbers of the device's precision, or as many counts */
  int64_t *flags; /* all */
  int64_t made;   /* steps since the bodies were set */
};

/* A part of the bodies, from `at` on; `count` is the distance of the rows of all bodies. */
typedef struct crowd_part {
  thrum_crowd *crowd;
  int64_t at, count;
  size_t bodies; /* of it */
} crowd_part;

/* The part that begins there. */
crowd_part crowd_part_at(thrum_crowd *crowd, int64_t at);

/* Puts the passes of a step into the queue; it is step number `made` since the bodies were set. */
thrum_status crowd_step_part(const crowd_part *t, int64_t made, thrum_error *error);

/* p half a step before q from p of the time of q, in its place; or back, into `timed`. */
thrum_status crowd_shift_part(const crowd_part *t, bool back, thrum_error *error);

/* The energies of the bodies, with the momentum p, into `kinetic` and `strain`. */
thrum_status crowd_energies_part(const crowd_part *t, opencl_buffer p, thrum_error *error);

#endif
