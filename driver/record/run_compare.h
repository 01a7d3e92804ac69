/* How far two finished runs of one body are apart. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_RUN_COMPARE_H
#define THRUM_DRIVER_RECORD_RUN_COMPARE_H

#include <stdint.h>

#include "driver/record/run_read.h"

/* What two runs have in common, and by how much they differ there. Lengths are those between places
 * of vertices in the world, but for `shape`, which is in the axes of the body. */
typedef struct run_difference {
  int64_t moments;    /* at which both have a row, and that were looked at */
  double first, last; /* the time of the first and of the last of them [s] */
  double apart;       /* root mean square over vertices and moments [m] */
  double moved;       /* the same of how far the second run is from its first moment [m] */
  double at_end;      /* root mean square over vertices at the last moment [m] */
  double largest;     /* of a vertex at a moment [m] */
  int64_t vertex;     /* that one, from 0 */
  double time;        /* and then [s] */
  double shape;       /* like `apart`, of the displacements in the axes of the body [m] */
  double turn;        /* the largest angle between the axes of the body [rad]; 0 where none turns */
  double energy;      /* the largest difference of kinetic and strain energy together [J] */
  double energy_most; /* the most of that energy in the second run [J] */
} run_difference;

/* Compares two runs whose models have the same vertices, at the rows that both recorded at one
 * time: all of them, or RUN_COMPARE_MOMENTS spread evenly. Refuses runs of other meshes
 * (THRUM_BAD_SHAPE) and runs that have less than two times in common (THRUM_BAD_VALUE). Costs
 * 12 r products a vertex and moment. */
#define RUN_COMPARE_MOMENTS 1000
thrum_status run_compare(const recorded_run *run, const recorded_run *other, run_difference *found,
                         thrum_error *error);

#endif
