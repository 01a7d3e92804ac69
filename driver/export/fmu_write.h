/* A model as a Functional Mock-up Unit for co-simulation and model exchange (docs/fmu.md).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef DRIVER_EXPORT_FMU_WRITE_H
#define DRIVER_EXPORT_FMU_WRITE_H

#include "driver/spec/load_spec.h"
#include "thrum/model.h"
#include "thrum/status.h"

#define FMU_TARGETS_MAX 64

/* A place of an FMU, with the name that its variables begin with, which is borrowed. */
typedef struct fmu_target {
  const char *name;
  load_target target;
} fmu_target;

/* Writes FILE.fmu of FMI `version` 2 or 3, with forces at these targets, or where there are none at
 * each group that moves. THRUM_BAD_VALUE for a file without such a name and for a place without
 * motion, THRUM_UNSUPPORTED for a model of cubature points, a condensed one, and a free body. */
thrum_status fmu_write(const char *path, int version, const thrum_model *model,
                       const fmu_target *targets, int64_t count, thrum_error *error);

#endif
