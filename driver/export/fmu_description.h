/* What an FMU tells of itself: modelDescription.xml of FMI 2.0 and 3.0, and buildDescription.xml.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef DRIVER_EXPORT_FMU_DESCRIPTION_H
#define DRIVER_EXPORT_FMU_DESCRIPTION_H

#include <stddef.h>
#include <stdio.h>

#include "driver/export/fmu/fmu_body.h"
#include "io/made_text.h"
#include "thrum/status.h"

typedef struct fmu_description {
  int version;               /* of FMI, 2 or 3 */
  const char *name;          /* of the model and its functions */
  const fmu_head *head;      /* of its numbers */
  const double *start;       /* alpha, beta, stiffness and step */
  const char *const *places; /* their names */
  const char *const *sources;
  int source_count;
  double stop; /* of the experiment that is proposed [s] */
} fmu_description;

/* The text (malloc, the caller frees), `*size` bytes. THRUM_OUT_OF_MEMORY. */
thrum_status fmu_model_description(const fmu_description *of, char **text, size_t *size,
                                   thrum_error *error);
thrum_status fmu_build_description(const fmu_description *of, char **text, size_t *size,
                                   thrum_error *error);

/* A text that `put` writes, which the caller frees; no part of it is lost without a failure. */
thrum_status fmu_text(made_text_put *put, const void *of, char **text, size_t *size,
                      thrum_error *error);

#endif
