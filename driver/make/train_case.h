/* One run of a training, as the command line names it: PIECE[;PIECE...], where a piece is a load,
 * base-motion:MOTION or start:START, as those options of simulate have them.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_TRAIN_CASE_H
#define THRUM_DRIVER_MAKE_TRAIN_CASE_H

#include "config/options.h"
#include "driver/make/full_motion.h"
#include "driver/spec/load_spec.h"
#include "driver/spec/start_spec.h"
#include "platform/allocate.h"

/* One parsed case; a zeroed one has nothing. */
typedef struct train_case {
  thrum_scope memory; /* of all but the last three, which are owned too */
  char *texts;        /* of the pieces */
  load_spec *loads;
  int64_t count;
  thrum_load *courses; /* count */
  base_motion_spec *base_motions;
  int64_t base_motion_count;
  start_spec *starts;
  int64_t start_count;
  // once it is filled
  double *forces;  /* count x 3 vertex_count at full strength [N] */
  double *held_by; /* 3 vertex_count, of static starts [N]; NULL: none */
  double *start;   /* 3 vertex_count, of the others [m]; NULL: none */
} train_case;

/* Parses a case; a failure is a mistake of usage. Starts from a file are refused: its coordinates
 * are of one basis. train_case_free frees, whatever came back. */
thrum_status train_case_parse(const char *text, train_case *c, thrum_error *error);
void train_case_free(train_case *c);

/* Fills the forces on the vertices of a model and where it starts, mode:K by its basis vector K,
 * and reads the files of base motions; `option` is where the case was given, for what a refusal
 * says. */
thrum_status train_case_fill(const thrum_model *model, const char *option, train_case *c,
                             thrum_error *error);

/* The script of a filled case: damping and time are left to the caller. */
full_motion_script train_case_script(const train_case *c);

/* directions (count x rank) = U^T of the loads at full strength. */
thrum_status train_case_reduce(const thrum_model *model, const train_case *c, double *directions,
                               thrum_error *error);

/* For `take`: looks at the text of a case, which is parsed again when it is run, and puts it into
 * texts[*count], which has room for it. */
thrum_status train_case_option_take(const config_given *given, const char **texts, int64_t *count);

#endif
