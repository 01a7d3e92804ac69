/* Says what is wrong with what is around a body (thrum/contact.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "contact/contact_check.h"

#include <math.h>
#include <stdbool.h>

#include "core/base/finite.h"

#define NEARLY 1e-12 /* of the largest entry: what is unequal by less is rounding */

/* Whether a give has entries of a size that stays finite, is symmetric and answers no force against
 * itself: no eigenvalue is negative beyond rounding, as no principal minor is. */
static bool is_give(const double give[9]) {
  double most = 0.0;
  for (int i = 0; i < 9; i++) {
    if (!(fabs(give[i]) <= THRUM_CONTACT_STIFFNESS_MAX))
      return false;
    most = fmax(most, fabs(give[i]));
  }
  const double near = NEARLY * most;

  // minors of one and two rows, which bound what is beside the diagonal
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3;
    const double across = give[3 * i + j];
    if (!(give[4 * i] >= 0.0) || !(fabs(across - give[3 * j + i]) <= near) ||
        !(across * across <= give[4 * i] * give[4 * j] + near * most))
      return false;
  }

  // and of all three
  const double determinant = give[0] * (give[4] * give[8] - give[5] * give[7]) -
                             give[1] * (give[3] * give[8] - give[5] * give[6]) +
                             give[2] * (give[3] * give[7] - give[4] * give[6]);
  return determinant >= -near * most * most;
}

static thrum_status check_pull(const thrum_model *model, const thrum_pull *pull, int64_t index,
                               thrum_error *error) {
  for (int corner = 0; corner < 3; corner++)
    if (pull->vertices[corner] < 0 || pull->vertices[corner] >= model->vertex_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "pull %lld: vertex %lld is outside 0..%lld", (long long)index,
                             (long long)pull->vertices[corner], (long long)model->vertex_count - 1);

  if (!thrum_all_finite(pull->weights, 3) || !thrum_all_finite(pull->target, 3) ||
      !thrum_all_finite(pull->velocity, 3))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "pull %lld: a weight, its target or velocity is not finite",
                           (long long)index);
  if (!is_give(pull->give))
    return thrum_error_set(
        error, THRUM_BAD_VALUE,
        "pull %lld: give must be symmetric, of entries up to 1e30, and without a "
        "negative eigenvalue",
        (long long)index);

  // written so that NaN is refused as well
  if (!(pull->stiffness >= 0.0 && pull->stiffness <= THRUM_CONTACT_STIFFNESS_MAX) ||
      !(pull->damping <= THRUM_CONTACT_STIFFNESS_MAX) ||
      !(pull->force_max >= 0.0 && pull->force_max <= THRUM_CONTACT_STIFFNESS_MAX))
    return thrum_error_set(
        error, THRUM_BAD_VALUE,
        "pull %lld: stiffness and force_max must be 0 to 1e30, the damping at most "
        "that",
        (long long)index);
  return THRUM_OK;
}

static thrum_status check_motion(const thrum_contact_environment *environment, thrum_error *error) {
  const thrum_placement *placement = environment->placement;
  const thrum_translation *translation = environment->translation;
  if (placement &&
      (!thrum_all_finite(placement->axes, 9) || !thrum_all_finite(placement->origin, 3)))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the placement is not finite");

  if (translation &&
      (!(translation->mass > 0.0) || !isfinite(translation->mass) ||
       !thrum_all_finite(translation->position, 3) || !thrum_all_finite(translation->velocity, 3)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the translation is not finite, or its mass is not above 0 [kg]");
  if (!thrum_all_finite(environment->force, 3) || !thrum_all_finite(environment->torque, 3))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the force or the torque is not finite");

  // a frame that is not finite would turn all points into NaN
  const thrum_rigid_frame *rigid_frame = environment->rigid_frame;
  if (rigid_frame &&
      (!thrum_all_finite(rigid_frame->centre, 3) || !thrum_all_finite(rigid_frame->inverse, 9) ||
       !thrum_all_finite(rigid_frame->attitude, 9) || !thrum_all_finite(rigid_frame->momentum, 3) ||
       !thrum_all_finite(rigid_frame->internal, 3)))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the rigid frame is not finite");
  if (environment->inertia && (!rigid_frame || !environment->inertia_work))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "an inertia comes with a rigid frame and with work");
  return THRUM_OK;
}

thrum_status thrum_contact_environment_check(const thrum_model *model, const thrum_contact *contact,
                                             const thrum_contact_environment *environment,
                                             thrum_error *error) {
  if (!environment || environment->obstacle_count < 0 || environment->pull_count < 0 ||
      (environment->obstacle_count > 0 && !environment->obstacles) ||
      (environment->pull_count > 0 && !environment->pulls))
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "the environment is NULL, or its obstacles or pulls do not fit their counts");
  if (environment->pull_count > contact->pull_max)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld pulls, where the contact was made for %lld",
                           (long long)environment->pull_count, (long long)contact->pull_max);
  if (environment->load && !thrum_all_finite(environment->load, contact->rank))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the load holds a number that is not finite");

  // every obstacle and pull: a bad one would spoil the state at once
  thrum_status status = check_motion(environment, error);
  for (int64_t n = 0; n < environment->obstacle_count && status == THRUM_OK; n++)
    status = thrum_obstacle_check(environment->obstacles + n, n, error);
  for (int64_t n = 0; n < environment->pull_count && status == THRUM_OK; n++)
    status = check_pull(model, environment->pulls + n, n, error);
  return status;
}
