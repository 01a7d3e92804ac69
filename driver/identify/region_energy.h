/* The strain energy of a model as the sum of those of its regions, V = sum e_g V_g with a factor
 * e_g of Young's modulus of each. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_IDENTIFY_REGION_ENERGY_H
#define THRUM_DRIVER_IDENTIFY_REGION_ENERGY_H

#include "thrum/gradient.h"

typedef struct region_energy {
  const thrum_model *model; /* whose coordinates these are */
  int64_t count;            /* regions */
  double *block;            /* of each region L, c3 and c4, one after the other */
} region_energy;

/* A model of other moduli. Its coordinates are its own modes, q = turn x. */
typedef struct region_body {
  thrum_model model; /* without a mesh; `damping` is free for the caller */
  double *turn;      /* rank x rank */
  thrum_energy_part *parts;
  thrum_model *forms; /* of the parts */
  double *block;
  void *packed;
} region_body;

/* Splits the energy of the model, which must stay. THRUM_UNSUPPORTED for one that has no
 * polynomial, THRUM_MISSING for one of several regions without its mesh. */
thrum_status region_energy_open(const thrum_model *model, region_energy *energy,
                                thrum_error *error);
void region_energy_close(region_energy *energy);

/* The body whose Young's moduli are `factors` (count) times those of the model, and the parts in
 * its coordinates, each times nothing. region_body_free frees, whatever came back. */
thrum_status region_energy_body(const region_energy *energy, const double *factors,
                                region_body *body, thrum_error *error);
void region_body_free(region_body *body);

#endif
