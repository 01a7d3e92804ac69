/* A model as the sum of what moduli and densities of its regions give it, and bodies of others
 * (thrum/parameters.h). SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_IDENTIFY_REGION_BODY_H
#define THRUM_DRIVER_IDENTIFY_REGION_BODY_H

#include "thrum/gradient.h"

typedef struct region_shares {
  thrum_model model;                /* with parameters, without basis and rigid modes */
  int64_t count;                    /* regions */
  bool whole;                       /* one region, all of whose energy stands for that of mu */
  double *values;                   /* 3 count: lambda, mu and density of each */
  double *energy, *mass, *material; /* those that the file did not have; NULL */
} region_shares;

/* A model of other values. Its coordinates are its own modes, q = turn q'. */
typedef struct region_body {
  thrum_model model;              /* `damping` is free for the caller */
  double *turn, *back;            /* rank x rank each, q' = back q */
  const thrum_energy_part *parts; /* 3 count, by lambda, mu and density of each region */
  thrum_parameter_parts *list;
  void *memory;
} region_body;

/* Splits a model, which must stay. by_material: also a body of one region into lambda, mu and
 * density, for which it needs its mesh unless it has parameters. THRUM_UNSUPPORTED for a model
 * without polynomial, THRUM_MISSING without the mesh. */
thrum_status region_shares_open(const thrum_model *model, bool by_material, region_shares *shares,
                                thrum_error *error);
void region_shares_close(region_shares *shares);

/* The body of these values (3 count). region_body_free frees, whatever came back. */
thrum_status region_body_make(const region_shares *shares, const double *values, region_body *body,
                              thrum_error *error);
void region_body_free(region_body *body);

#endif
