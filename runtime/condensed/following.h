/* How the slaves of a condensed model follow its masters (design 16, 17), J(x) = dY/dx; private to
 * the runtime, see following.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONDENSED_FOLLOWING_H
#define THRUM_RUNTIME_CONDENSED_FOLLOWING_H

#include "core/polynomial/kernel_private.h"
#include "core/step/step.h"

/* A condensed model and scratch to follow its masters with. A model that is not condensed has no
 * slaves, and nothing below does anything for it. */
typedef struct thrum_following {
  const thrum_model *model;
  const thrum_kernel *kernel;
  int64_t masters, slaves, pairs;
  double *monomials, *weights; /* pairs */
  double *image;               /* slaves: J v of the last product */
} thrum_following;

/* Number of coordinates that follow; 0 of a model that is not condensed. */
int64_t thrum_slave_count(const thrum_model *model);

/* Doubles that a step takes in view->work: those of the polynomial, or of the drag. */
int64_t thrum_step_work_count(const thrum_model *model);

/* Doubles of scratch behind a thrum_following of this model; 0 where nothing follows. */
int64_t thrum_following_count(const thrum_model *model);

/* With that scratch; one that follows nothing where the model is not condensed. */
thrum_following thrum_following_of(const thrum_model *model, const thrum_kernel *kernel,
                                   double *scratch);

/* Stiffness of a slave at rest [1/s^2], in the scale of the model that is stepped. */
double thrum_slave_omega2(const thrum_model *model, int64_t slave);

/* to (slaves) = J(x) v. */
void thrum_follow(const thrum_following *f, const double *x, const double *v, double *to);

/* to (masters) += J(x)^T what. */
void thrum_follow_back(const thrum_following *f, const double *x, const double *what, double *to);

/* slopes (slaves x masters) = J(x). */
void thrum_follow_slopes(const thrum_following *f, const double *x, double *slopes);

/* to (masters) solves (1 + J(x)^T W J(x)) to = rest by conjugate gradients, up to a square `end` of
 * what is left; W is diagonal, `weight` (slaves, none negative) or 1 for NULL. Overwrites rest;
 * direction and product (masters) are scratch. */
void thrum_follow_solve(const thrum_following *f, const double *weight, const double *x,
                        double *rest, double end, double *direction, double *product, double *to);

/* True where the slaves' damping at rest, beta omega^2, acts on the masters as a force of a step:
 * for all schemes but `manifold`, which has it in its equation, and not for the tangent form, in
 * which what follows is not damped against the masters. */
bool thrum_follow_is_damped(const thrum_model *model, const thrum_state *state);

/* That force in the step to come (masters), from the present q and p; uses view->work. */
void thrum_follow_drag(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                       double *force);

/* As hooks (schemes.h): the scratch of the drag in view->work, and room for the masters half a step
 * ahead, where loads on the slaves act; and the drag, which is a force of
 * the step as well, added to its load. */
void thrum_follow_plan(const thrum_model *model, thrum_state *state);
void thrum_follow_load(const thrum_model *model, thrum_step_run *run);

#endif
