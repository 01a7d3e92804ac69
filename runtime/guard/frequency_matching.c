/* Frequency matching: the energy integrator's step in which slow modes turn at their own frequency
 * (design 7). Each mode takes the trapezoidal rule with a time step of its own,
 *
 *   lambda h = 2/omega tan(h omega/2)   for h omega <= 1,   h for the others,
 *
 * known as the prewarped bilinear transform. Over a whole step such a mode moves by q' - q =
 * lambda h (p + p')/2, and the velocity in the middle of the step, on which damping acts, is
 *
 *   v = nu (q' - q)/h,   nu = x/sin(x),  x = h omega/2,
 *
 * nu^2 = 1/lambda^2 + x^2. 1/lambda = x/tan(x) is a continued fraction, cut where its error is
 * 3e-16 at h omega = 1, so that all machines compute the same bits.
 *
 * A mode s that follows the square of a softer one j, as stretching follows bending, does not
 * vibrate at omega_s: there lambda would only change its inertia. So it keeps h. It is one that
 * takes up much of the quartic energy of j when it is let free,
 *
 *   c3_jjs^2/(2 omega_s^2) > FOLLOWING_SHARE c4_jjjj   for an omega_j < omega_s/APART,
 *
 * where c4_jjjj of a condensed model is that from before its slaves took their part.
 *
 * Cost: two divisions and a square root a mode; r^2 operations when a state is made.
 * Sources: Tustin 1947, doi:10.1049/ji-2a.1947.0020 (the transform); Cieslinski & Ratkiewicz 2011,
 * doi:10.1088/1751-8113/44/15/155206 (locally exact discrete gradients in one dimension).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/guard/frequency_matching.h"

#include <math.h>
#include <string.h>

#include "core/polynomial/points.h"
#include "runtime/condensed/following.h"
#include "thrum/polynomial.h"

#define ANGLE_MOST 1.0 /* h omega at rest of a mode whose frequency is matched */
#define FOLLOWING_SHARE                                                                            \
  0.15            /* of the quartic energy of a softer mode, taken up by one that follows */
#define APART 3.0 /* its frequency over that of the softer mode, at least */

/* c3_jjs of every s > j, into c3, and c4_jjjj. */
static void along(const thrum_model *model, int64_t j, double *c3, double *c4) {
  const int64_t r = model->rank;
  if (thrum_has_points(model)) {
    thrum_passes.along(model, j, c3, c4);
    return;
  }
  for (int64_t s = j + 1; s < r; s++)
    c3[s] = model->c3[thrum_c3_index(r, j, j, s)];
  *c4 = model->c4[thrum_c4_index(r, j, j, j, j)];
}

/* The share that the slaves of a condensed model took of c4_jjjj, by their frequencies and how they
 * follow. */
static double taken_by_slaves(const thrum_model *model, int64_t j) {
  if (model->shape == NULL)
    return 0;
  const int64_t r = model->rank, pairs = r * (r + 1) / 2, at = pairs - (r - j) * (r - j + 1) / 2;
  double taken = 0;
  for (int64_t s = 0; s < thrum_slave_count(model); s++) {
    const double follows = model->follow_scale * model->follow[s * pairs + at];
    taken += 0.5 * thrum_slave_omega2(model, s) * follows * follows;
  }
  return taken;
}

void thrum_find_following(const thrum_model *model, thrum_state *state) {
  memset(state->following, 0, sizeof state->following);
  const int64_t r = model->rank;
  for (int64_t j = 0; j < r && APART * APART * model->omega2[j] < model->omega2[r - 1]; j++) {
    double c3[THRUM_RANK_MAX], c4 = 0;
    along(model, j, c3, &c4);
    c4 = fmax(c4 + taken_by_slaves(model, j), 0.0);
    for (int64_t s = j + 1; s < r; s++)
      if (APART * APART * model->omega2[j] < model->omega2[s] &&
          c3[s] * c3[s] > 2.0 * FOLLOWING_SHARE * model->omega2[s] * c4)
        state->following[s / 64] |= UINT64_C(1) << (s % 64);
  }
}

int32_t thrum_matched_modes(const thrum_model *model, const thrum_state *state) {
  if (!state->def.frequency_matched)
    return 0;
  const double h = state->def.dt;
  int32_t count = 0;
  while (count < model->rank && h * h * model->omega2[count] <= ANGLE_MOST * ANGLE_MOST)
    count++;
  return count;
}

/* x cot(x) = over/under with z = x^2. */
static inline double over(double z) {
  return 135135.0 - z * (62370.0 - z * (3150.0 - z * 28.0));
}

static inline double under(double z) {
  return 135135.0 - z * (17325.0 - z * (378.0 - z));
}

static bool is_following(const thrum_state *state, int32_t i) {
  return state->following[i / 64] >> (i % 64) & 1;
}

thrum_matched_step thrum_matched_step_of(const thrum_model *model, const thrum_state *state,
                                         int32_t i) {
  if (is_following(state, i))
    return (thrum_matched_step){1.0, 1.0, 1.0};
  const double h = state->def.dt, z = 0.25 * (h * h * model->omega2[i]);
  const double inverse = over(z) / under(z);
  return (thrum_matched_step){under(z) / over(z), inverse, sqrt(inverse * inverse + z)};
}

void thrum_match_steps(const thrum_model *model, const thrum_state *state, int32_t count,
                       double *stretch, double *inverse, double *speed) {
  const double h2 = state->def.dt * state->def.dt, *omega2 = model->omega2;
  double *restrict to_stretch = stretch, *restrict to_inverse = inverse, *restrict square = speed;

  // divisions are made side by side, which roots with their error numbers would prevent
  for (int32_t i = 0; i < count; i++) {
    const double z = 0.25 * (h2 * omega2[i]), above = over(z), below = under(z);
    const double ratio = above / below;
    to_stretch[i] = below / above;
    to_inverse[i] = ratio;
    square[i] = ratio * ratio + z;
  }
  for (int32_t i = 0; i < count; i++)
    speed[i] = sqrt(speed[i]);

  // the modes that follow keep the time step
  for (int32_t i = 0; i < count; i++)
    if (is_following(state, i))
      stretch[i] = inverse[i] = speed[i] = 1.0;
}

const thrum_mode_steps thrum_matched_mode_steps = {
    .find = thrum_find_following,
    .count = thrum_matched_modes,
    .of = thrum_matched_step_of,
    .all = thrum_match_steps,
};
