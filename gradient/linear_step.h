/* A step to first order: how its end changes with its start, and the transpose of that. Private to
 * the library of gradients; see linear_step.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_GRADIENT_LINEAR_STEP_H
#define THRUM_GRADIENT_LINEAR_STEP_H

#include <stdbool.h>

#include "thrum/gradient.h"
#include "thrum/step_equation.h"

/* R, T and V at an end of a step. */
typedef struct thrum_step_place {
  double *force;   /* rank */
  double *tangent; /* rank x rank; not needed by the midpoint rule and verlet */
  double potential;
} thrum_step_place;

/* A step as it was made: q, p at its ends, its force and that of the step before (rank each). */
typedef struct thrum_made_step {
  const double *q, *p, *q_next, *p_next, *force, *force_before;
  const double *half; /* of verlet: p in the middle of the step */
} thrum_made_step;

typedef struct thrum_linear_step {
  const thrum_model *model; /* of a body that acts, with the levels of the step */
  thrum_step_equation equation;
  int64_t rank;
  const double *kappa, *nu, *damping; /* of thrum_step_equation_get */
  thrum_step_place start, end, middle;
  double *jacobian; /* rank x rank */
  int32_t *rows;    /* rank */
  double *work;     /* thrum_work_count */

  bool has_sigma; /* trapezoid: sigma is no rounding */

  /* Of the average vector field where Simpson's rule is not exact: the energy that it misses, by
   * which p' is scaled; else false. Its derivatives are in sigma_d and sigma_q. */
  bool inexact;
  double missed, part_missed; /* part_missed: the share of a part in it */
  double scale, square;       /* p' over the one before that, whose |p'|^2 is `square` */

  /* Of verlet, rank: backward the half kick at the start of the step after, to which T at the place
   * between them is still to be applied; forward T at the start times the change there. */
  double *kept;
  bool levels_change; /* then T is applied twice there, and nothing is kept */

  /* Scratch, rank each. */
  double *d, *mean, *sigma_d, *sigma_q, *unscaled, *w, *x, *y;

  /* Of parts of the energy: how functions of K change with it (rank x rank each, see
   * thrum_linear_step_prepare_parts), and scratch, rank each. */
  double *slope_kappa, *slope_kappa_square, *slope_damped, *slope_damping;
  double *part_start, *part_middle, *part_end, *part_kappa, *part_y;

  int64_t actuators; /* of the model */
} thrum_linear_step;

/* Derivatives by what a step depends on, or a direction of that. */
typedef struct thrum_step_change {
  double *q, *p;                  /* of the end before the call, of the start after it; pushed, the
                                     other way round */
  double *force, *force_before;   /* rank each */
  double *damping;                /* of D of each mode; what is pulled back is added */
  double stiffness;               /* of a factor of V and of omega^2 in kappa and nu; likewise */
  const thrum_energy_part *parts; /* part_count */
  double *part;                   /* of the share of each; likewise */
  int64_t part_count;
  double *level; /* of the level of each actuator; what is pulled back is that of this step */
  double gas;    /* of a factor of the energy of all gases; what is pulled back is added */
} thrum_step_change;

/* Fills what steps with parts of the energy need, once kappa, nu and damping are known. */
void thrum_linear_step_prepare_parts(thrum_linear_step *step);

/* kappa and nu^2 of a mode by a factor of omega^2. */
double thrum_linear_step_kappa(const thrum_linear_step *step, int64_t i);
double thrum_linear_step_nu(const thrum_linear_step *step, int64_t i);

/* R, T and V of an end, as far as steps of this form need them; verlet has R from its momenta. */
void thrum_linear_step_evaluate(thrum_linear_step *step, const double *q, thrum_step_place *place);

/* The end of one step is the start of the next. */
void thrum_linear_step_turn(thrum_linear_step *step);

/* Factors the Jacobian of a step, with both of its ends evaluated. False where it is singular. */
bool thrum_linear_step_factor(thrum_linear_step *step, const thrum_made_step *made);

/* Before the first step that is pushed, and after the last that is pulled, with the start of the
 * run: what steps of verlet share at it. */
void thrum_linear_step_begin_push(const thrum_linear_step *step, const double *q,
                                  const thrum_step_change *change);
void thrum_linear_step_end_pull(const thrum_linear_step *step, const double *q,
                                thrum_step_change *change);

/* The transpose of the step: from derivatives by its end to those by its start, and by all else. */
void thrum_linear_step_pull(thrum_linear_step *step, const thrum_made_step *made,
                            thrum_step_change *change);

/* The step: from a change of its start, and of all else, to that of its end. */
void thrum_linear_step_push(thrum_linear_step *step, const thrum_made_step *made,
                            thrum_step_change *change);

#endif
