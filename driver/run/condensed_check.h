/* Whether a condensed model can be believed: its energy against that of the mesh in the same shape.
 *
 * Condensing leaves terms of V out, and gives the slaves no inertia. The first is seen where the
 * body is bent most: there V of the mesh at u = U q(x) and the condensed V_c(x) should agree.
 *
 * Without inertia the slaves do not vibrate. How they would, as linear oscillators under the load
 * on them and from where the body starts, is stepped beside the run: an axial load on a bar whose
 * masters bend it, a load near a slave's frequency, a start that the masters cannot show, an
 * impact. What an impact gives to their vibration, the masters of the run keep: they rebound with
 * it, and where that takes them is stepped too.
 *
 * Damped at rest, beta y' + y = Y(x), the slaves lag by beta. The run has the force -beta Omega^2
 * Y' of that, which is right while little changes in that time; how they would lag is stepped as
 * well. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_CONDENSED_CHECK_H
#define THRUM_DRIVER_RUN_CONDENSED_CHECK_H

#include "driver/run/simulate_figures.h"
#include "precompute/model/model_fem.h"
#include "thrum/thrum.h"

/* A zeroed one looks at nothing. */
typedef struct condensed_check {
  const thrum_model *model; /* the stepped one */
  thrum_mesh mesh;
  thrum_fem fem;
  double *q, *u;           /* of the shape; owned */
  double energy;           /* V_c of the shape looked at last, the largest so far [J] */
  double defect;           /* |V - V_c| / V_c there [1]; NaN: none was looked at */
  double kinetic, inertia; /* largest kinetic energy with the slaves', and of the slaves [J] */

  /* Slaves beside where they follow, masters beside where impacts would have left them, and the
   * velocities of both (THRUM_RANK_MAX each); owned. */
  double *beside;
  double *turns; /* how each coordinate vibrates in a step of `h`; of `beside` */
  double h;
  double damping_alpha, damping_beta;
  bool damped_at_rest;
  double *lag; /* y - Y(x) of slaves without inertia, at the end of the last step; of `beside` */

  /* Coordinates at the end of the last step, as the masters show them: with damping at rest all,
   * and the masters alone without. */
  double *followed;
  bool follows; /* they are known */

  double struck;       /* net work of contact on the slaves, in the scale of the model [J] */
  double struck_apart; /* of it, what was there when contact ended last */
  bool touched;        /* in the last step */

  /* Sums over the steps of squares: of what the run does not show of the slaves, of what impacts
   * would have moved the masters aside, and of all coordinates. */
  double missing, aside, shown;
} condensed_check;

/* Opens the check of a stepped model. Where its shape has no mesh, only the inertia is checked. */
thrum_status condensed_check_open(const thrum_model *model, condensed_check *check,
                                  thrum_error *error);
void condensed_check_close(condensed_check *check);

/* The damping of the run; times are multiplied by `pace` in the model that is looked at. */
void condensed_check_damp(condensed_check *check, const thrum_state_def *def, double pace);

/* Looks at the masters x with the velocities v, of any scale, and V_c(x) [J]. */
void condensed_check_look(condensed_check *check, const double *x, const double *v,
                          double potential);

/* The body starts at all coordinates q with the velocities p (NULL: at rest), of which the masters
 * are stepped. Nothing happens where all starts are displaced modes: these start where the slaves
 * follow. */
void condensed_check_start(condensed_check *check, const simulate_request *request, const double *q,
                           const double *p);

/* A step of h [s] with a load on all coordinates, NULL for none, that ended at the masters x. The
 * run shows the slaves' static answer to `load`; to the forces of `contact` (the same, or NULL) it
 * shows nothing of it. */
void condensed_check_vibrate(condensed_check *check, const double *load, const double *contact,
                             double h, const double *x);

/* Fills what figures say of a condensed model, stepped as `model`; the check may be a zeroed one.
 */
void condensed_check_report(const condensed_check *check, const thrum_model *model,
                            simulate_figures *figures);

#endif
