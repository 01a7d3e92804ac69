/* What a tape is, private to the library of gradients. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_GRADIENT_TAPE_PRIVATE_H
#define THRUM_GRADIENT_TAPE_PRIVATE_H

#include "gradient/linear_step.h"
#include "thrum/gradient.h"

#define THRUM_TAPE_DIVIDED (-1) /* the form of a step that a fallback level has divided */

struct thrum_tape {
  uint64_t magic, identity; /* of the model that it was started with */
  int64_t most, count;      /* steps: that there is room for, that were made */
  int64_t rank;
  bool started;
  double *kappa, *nu, *damping; /* rank each */
  double *q, *p;                /* (most + 1) x rank */
  double *end_q, *end_p;        /* rank each: of the state that it records, as that has them */
  double *force;                /* (most + 1) x rank: none, then that of each step */
  double *force_bar;            /* most x rank: of a pass back, until it has come through */
  int32_t *form;                /* of each step, or THRUM_TAPE_DIVIDED */

  /* For the passes over the tape. */
  thrum_linear_step step;
  double *change[6]; /* rank each */
};

/* Is this a tape that was started with this model? */
thrum_status thrum_tape_check(const thrum_model *model, const thrum_tape *tape, thrum_error *error);

#endif
