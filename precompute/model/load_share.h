/* Measures what of a load a model's basis cannot show, design 10.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_LOAD_SHARE_H
#define THRUM_PRECOMPUTE_MODEL_LOAD_SHARE_H

#include "thrum/model.h"

typedef struct thrum_load_share {
  double
      statics;  /* |u - u_r|_K / |u|_K of the linear static answers u = K^-1 f and its best in U */
  double load;  /* |f - M U U^T f| / |f| in the norm of M^-1 */
  double reach; /* the largest component of u [m] */
} thrum_load_share;

/* Add to forces (3 vertex_count): one force [N] that `count` vertices share evenly (NULL: all), as
 * thrum_load_add_shared; or an acceleration [m/s^2] of all the mass, as thrum_load_add_gravity.
 */
thrum_status thrum_load_fill(const thrum_model *model, const int32_t *vertices, int64_t count,
                             const double force[3], double *forces, thrum_error *error);
thrum_status thrum_load_fill_gravity(const thrum_model *model, const double acceleration[3],
                                     double *forces, thrum_error *error);

/* Adds the centrifugal force [N] on all the mass of a body that turns about its centre of mass, at
 * rest in its shape, with `spin` [rad/s]. */
thrum_status thrum_load_fill_spin(const thrum_model *model, const double spin[3], double *forces,
                                  thrum_error *error);

/* The shares of `count` loads (each 3 vertex_count). For a free body what the rigid modes take is
 * left out of f. NaN where nothing of a load is left on the free components. Assembles and
 * factorises K and M. THRUM_MISSING without mesh or basis. */
thrum_status thrum_load_share_measure(const thrum_model *model, int64_t count, const double *forces,
                                      thrum_load_share *shares, thrum_error *error);

#endif
