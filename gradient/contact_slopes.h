/* How the forces of a step's contact change with its start and its load. Private to the library of
 * gradients; see contact_slopes.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_GRADIENT_CONTACT_SLOPES_H
#define THRUM_GRADIENT_CONTACT_SLOPES_H

#include "gradient/linear_step.h"
#include "thrum/contact.h"

/* A force F of a step, and to first order dF = -rate a dd + by_q a dq + by_p a dp, with the row a
 * of its place and the displacement d over the step that the contact has predicted. */
typedef struct thrum_contact_slope {
  int32_t vertex;
  double along[3], push[3]; /* in the axes of the mesh: a, and what F of 1 does [N] */
  double rate, by_q, by_p;
} thrum_contact_slope;

/* What is not smooth in a step. */
typedef enum thrum_rough_kind {
  THRUM_ROUGH_NONE,
  THRUM_ROUGH_IMPACT,
  THRUM_ROUGH_REST,
  THRUM_ROUGH_STICK,
  THRUM_ROUGH_STORED,
  THRUM_ROUGH_GIVEN,
  THRUM_ROUGH_AGAIN
} thrum_rough_kind;

/* Of one step. */
typedef struct thrum_contact_step_slopes {
  int64_t first, count;     /* of the slopes */
  double given;             /* share of its impulses that went back after the step */
  bool calmed;              /* coordinates that steps cannot follow were damped after it */
  thrum_rough_kind kind;    /* the first that is not smooth, */
  int32_t vertex, obstacle; /* and where */
} thrum_contact_step_slopes;

/* Reads the contact of a step that was made; made->force has the load alone, and gets the forces of
 * contact added. `slopes` has room for `most`; false where there are more. */
bool thrum_contact_slopes_read(thrum_linear_step *step, const thrum_made_step *made, double *force,
                               thrum_contact *contact, const thrum_contact_environment *environment,
                               thrum_contact_slope *slopes, int64_t most,
                               thrum_contact_step_slopes *of);

/* Before the step is pulled, and after it was pushed: what contact does to p at its end. */
void thrum_contact_slopes_end(const thrum_linear_step *step, const thrum_contact_step_slopes *of,
                              double *p);

/* The transpose of the contact: change->force has the derivative by the whole force of the step and
 * gets that by its load; change->q and p get theirs added. p_end: the derivative by p after the
 * step. */
void thrum_contact_slopes_pull(thrum_linear_step *step, const thrum_made_step *made,
                               const thrum_contact_step_slopes *of,
                               const thrum_contact_slope *slopes, const double *p_end,
                               thrum_step_change *change);

/* The contact: change->force has the change of the load, and gets that of the whole force. `forces`
 * gets the part of the contact alone (rank). */
void thrum_contact_slopes_push(thrum_linear_step *step, const thrum_made_step *made,
                               const thrum_contact_slope *slopes,
                               const thrum_contact_step_slopes *of, thrum_step_change *change,
                               double *forces);

#endif
