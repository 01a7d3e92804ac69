/* A model as the matrices and exponents of harmonic balance programs, in a file of MATLAB
 * (docs/exchange.md). SPDX-License-Identifier: Apache-2.0 */
#ifndef DRIVER_EXPORT_NLVIB_H
#define DRIVER_EXPORT_NLVIB_H

#include "driver/export/fmu_write.h"
#include "driver/spec/damping_spec.h"
#include "thrum/model.h"

/* Writes M, D, K (rank x rank), p and E (monomials x rank) with M q'' + D q' + K q + E' z = f,
 * z_i the product of all q_j^p_ij; and where there are places T (3 places x rank), their mean
 * displacements along x, y and z, whose transpose shares forces out. Refuses cubature points and
 * condensed models. */
thrum_status nlvib_write(const char *path, const thrum_model *model, const damping_spec *damping,
                         const fmu_target *places, int64_t place_count, thrum_error *error);

#endif
