/* What a tape is, private to the library of gradients. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_GRADIENT_TAPE_PRIVATE_H
#define THRUM_GRADIENT_TAPE_PRIVATE_H

#include "gradient/contact_slopes.h"
#include "gradient/linear_step.h"
#include "thrum/gradient.h"

struct thrum_tape {
  uint64_t magic, identity; /* of the model that it was started with */
  int64_t most, count;      /* steps: that there is room for, that were made */
  int64_t divided;          /* the first step that a fallback level has divided; -1: none */
  int64_t rank, width;      /* of q and p, and of a force */
  int64_t every;            /* steps from one row of what is seen to the next */
  bool started;
  bool astray;                  /* a segment stepped again has not ended where the run did */
  double *kappa, *nu, *damping; /* rank each */
  double *start_q, *start_p;    /* rank each */
  thrum_step_equation running;  /* of the step that is being made, */
  int64_t divided_before;       /* and how many were divided before it */
  double *end_q, *end_p;        /* rank each: of the state that it records, as that keeps them */

  /* The rows of the steps from `first` on: all of them, or those of one segment. */
  int64_t length, first;
  double *q, *p;    /* (length + 1) x rank */
  double *half;     /* length x rank: of verlet, p in the middle of each step */
  double *before_q; /* rank: of the step before `first` */
  bool follows;     /* the model is condensed: then of verlet also the force on the masters */
  double *master, *before_master; /* length x rank, rank */
  int32_t *form;                  /* length */

  /* Forces: the tape's own rows, or with checkpoints the caller's. */
  double *force, *none; /* most x width, width zeros */
  const double *forces; /* NULL: none */

  /* Of a model with actuators: the levels of each step, those that the state had at the end, and
   * the model with those of the step that is passed. */
  int64_t actuators;
  double *levels;     /* most x actuators */
  double *end_levels; /* actuators */
  double *acting;     /* thrum_model_actuation_count */
  thrum_model seen;

  /* Contact: of each step, and the slopes of all of them. */
  thrum_tape_subgradient subgradient;
  int64_t touches, slope_count;        /* that there is room for, that there are */
  thrum_contact_slope *slopes;         /* touches */
  thrum_contact_step_slopes *contacts; /* most; NULL: the tape takes none */

  /* Checkpoints: what persists of the state at the start of each segment, and a state that goes on
   * from there. */
  int64_t checkpoints;
  size_t kept_size, state_size;
  unsigned char *kept;
  thrum_state *again;

  /* For the passes over the tape. */
  thrum_linear_step step;
  double *change[7];       /* rank each */
  double *p_end, *pressed; /* rank: derivative by p after a step, change of the contact forces */
  double *wide[2];         /* width each */
  double *level;           /* actuators */
};

/* Is this a tape that was started with this model? */
thrum_status thrum_tape_check(const thrum_model *model, const thrum_tape *tape, thrum_error *error);

/* Brings the rows of the segment of step k, 0 <= k < count, and steps to them again where they are
 * not there. THRUM_INVALID_ARGUMENT where that leads elsewhere: the forces are no more those of the
 * run. */
thrum_status thrum_tape_reach(const thrum_model *model, thrum_tape *tape, int64_t k,
                              thrum_error *error);

/* The force of step k (width); before the first it is zero. */
const double *thrum_tape_force(const thrum_tape *tape, int64_t k);

/* The levels of step k (actuators). */
static inline double *thrum_tape_levels(const thrum_tape *tape, int64_t k) {
  return tape->levels + k * tape->actuators;
}

/* Step k, whose rows are there. */
thrum_made_step thrum_tape_made(const thrum_tape *tape, int64_t k);

/* Gives the linear step the model and what follows from the def of the state. */
void thrum_tape_prepare(const thrum_model *model, thrum_tape *tape);

/* The force of step k on what is stepped (rank), of a condensed model by verlet. */
const double *thrum_tape_master(const thrum_tape *tape, int64_t k);

/* Where the force of step k sees what follows of a condensed model: in the middle of the step,
 * extrapolated from its start and the place before (rank, into `to`). */
void thrum_tape_ahead(const thrum_tape *tape, int64_t k, double *to);

#endif
