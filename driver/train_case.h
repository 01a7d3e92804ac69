/* One run of a training, as the command line names it: LOAD[;LOAD...], loads that act
 * together on the body at rest. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_TRAIN_CASE_H
#define THRUM_DRIVER_TRAIN_CASE_H

#include "config/options.h"
#include "driver/full_motion.h"
#include "driver/load_spec.h"

/* One parsed case; a zeroed one has no loads. */
typedef struct train_case {
  char *texts; /* of the loads; owned, as all that follows */
  load_spec *loads;
  int64_t count;
  thrum_load *courses; /* count */
  double *forces;      /* count x 3 vertex_count at full strength [N]; once it is filled */
} train_case;

/* Parses a case; a failure is a mistake of usage. train_case_free frees, whatever came back. */
thrum_status train_case_parse(const char *text, train_case *c, thrum_error *error);
void train_case_free(train_case *c);

/* Fills the forces on the vertices of a model; `option` is where the case was given, for what a
 * refusal says. */
thrum_status train_case_fill(const thrum_model *model, const char *option, train_case *c,
                             thrum_error *error);

/* directions (count x rank) = U^T of the loads at full strength. */
thrum_status train_case_reduce(const thrum_model *model, const train_case *c, double *directions,
                               thrum_error *error);

/* For `take`: looks at the text of a case, which is parsed again when it is run, and puts it into
 * texts[*count], which has room for it. */
thrum_status train_case_option_take(const config_given *given, const char **texts, int64_t *count);

#endif
