/* Points and weights whose sum of energies stands in for the integral over the body, design 18.
 *
 * The points are those of the elements (one of a linear tetrahedron, those of its rule of a
 * ten-node one), and answer by its law. Their weights are the non-negative least squares of
 * internal forces in states of training (energy-conserving sampling and weighting: Farhat, Avery,
 * Chapman & Cortial 2014, doi:10.1002/nme.4668; An, Kim & James 2008, doi:10.1145/1409060.1409118).
 * The linear part of the force stays exact.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_CUBATURE_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_CUBATURE_H

#include "precompute/fem/fem.h"
#include "precompute/options/stage.h"
#include "thrum/model.h"

/* Points drawn at most, of which those of the cubature are chosen, and states that are taken. */
enum { THRUM_CUBATURE_CANDIDATES = 4000, THRUM_CUBATURE_STATES = 280 };

/* Time of a force for each point and coordinate, over that of the polynomial for each of its
 * coefficients while these lie in a cache: measured with AVX-512, 1.3 ns to 0.11 ns. */
#define THRUM_CUBATURE_POINT_COST 12.0

/* Points for each coordinate that bodies usually take, by which it is guessed whether points will
 * pay before they are chosen: 3 to 6 on the bridge for an error of 2 % (docs/precompute.md). */
#define THRUM_CUBATURE_POINTS_USUAL 4

/* The same of points whose gradients are learned: 1 to 2 on the bridge for 0.5 to 1 %. */
#define THRUM_CUBATURE_POINTS_LEARNED 2

typedef struct thrum_cubature_def {
  /* Relative rms of the internal force at which points are enough, in states that were not trained
   * on; > 0. Smaller: more points. */
  double error;

  /* Points at most; >= 1. */
  int64_t most;

  /* The largest displacement of a training state as a share of the body's diagonal; > 0. Larger:
   * more points for the same error. */
  double range;

  /* Coordinates that are drawn at random, the lowest; the others follow them, roughly. 1 to the
   * rank. */
  int64_t masters;

  /* Where points are to be right for a body that flows beyond this yield too; infinite: it is
   * elastic, but for regions that have yields of their own. In every second state something has
   * then flowed. */
  double yield;

  /* Steps in which the gradients of the chosen points are learned
   * (precompute/polynomial/cubature_refine.h), of a body that does not flow; 0: none. Otherwise
   * points are chosen for a multiple of the error. */
  int64_t refine;
} thrum_cubature_def;

typedef struct thrum_cubature_figures {
  int64_t points, candidates, states, test_states;
  double train_error, test_error; /* relative rms of the internal force */
  double chosen_error;            /* test_error before points were refined; 0: they were not */
  double force_cost; /* of a force, over that of the polynomial's, about: above a half no step
                      * gains; for a law that no polynomial holds it says nothing */

  int64_t few; /* points that would begin to be learned; 0: not known, or they were */

  double strain;  /* largest norm of Green's strain at a candidate in these states */
  double plastic; /* largest plastic strain there, 0: nothing flowed */

  /* Relative rms of the displacement in motions that were not trained on, within the range and
   * beyond it, and the processor time of a step of these [s]
   * (precompute/polynomial/cubature_motion.h); NaN: not measured. */
  double motion_error, motion_error_beyond, step_seconds;
} thrum_cubature_figures;

/* The time of a force by so many points over that by the polynomial, about; 1 and above: points do
 * not pay. */
double thrum_cubature_cost(int64_t points, int64_t rank);

/* Time in which the gradients of so many points are learned, about [s]: measured on a processor of
 * 25 Gflop/s in single precision. */
double thrum_cubature_learning(int64_t points, int64_t rank, int64_t steps);

/* Fills the arrays of the points of a model that has its basis and omega2; thrum_model_fill_free
 * frees them. The error that was asked for may
 * be missed: the figures say it. */
thrum_status thrum_cubature(const thrum_fem *fem, const thrum_cubature_def *def, thrum_model *model,
                            thrum_cubature_figures *figures, const thrum_reporter *reporter,
                            thrum_error *error);

/* The points that `places` names, numbers of a point over all points of the mesh, with weights of
 * `count` volumes [m^3], into the arrays of a model that has its basis. */
thrum_status thrum_cubature_fill(const thrum_fem *fem, int64_t count, const int64_t *places,
                                 const double *weights, thrum_model *model, thrum_error *error);

#endif
