/* A hash of the reduced polynomial, by which a state knows its model (thrum/model.h).
 *
 * It finds accidents: a state that is stepped with another model of its rank would use the
 * inverses, forces and energies of its own. Cost: about four cycles a coefficient.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/mix_numbers.h"
#include "core/base/model_law.h"
#include "core/polynomial/points.h"
#include "thrum/model.h"

/* Mixes the law and the yield at each point in. */
static uint64_t mix_regions(uint64_t hash, const thrum_model *model) {
  for (int64_t p = 0; p < model->point_count; p++) {
    const int32_t region = model->point_region[p];
    const double yield = thrum_law_yield(model, region, 0);
    hash = thrum_mix_number(hash, model->region_law[region]);
    hash = thrum_mix_numbers(hash, &yield, 1);
  }
  return hash;
}

uint64_t thrum_model_identity(const thrum_model *model) {
  if (!model || !thrum_has_energy(model))
    return 0;
  uint64_t hash = thrum_mix_number(0, (uint64_t)model->rank);
  hash = thrum_mix_numbers(hash, model->omega2, model->rank);
  if (thrum_has_points(model)) {
    hash = thrum_mix_numbers(hash, model->point_weights, model->point_count);
    hash = thrum_mix_numbers(hash, model->point_moduli, 2 * model->point_count);
    hash = thrum_mix_numbers(hash, model->point_gradients,
                             THRUM_POINT_ROWS * model->point_count * model->rank);
    const thrum_law law = thrum_law_of_model(model);
    hash = law == THRUM_LAW_STVK ? hash : thrum_mix_number(hash, (uint64_t)law);
    hash = law == THRUM_LAW_BY_REGION ? mix_regions(hash, model) : hash;
  } else {
    hash = thrum_mix_numbers(hash, model->c3, model->c3_count);
    hash = thrum_mix_numbers(hash, model->c4, model->c4_count);
  }

  // a state keeps numbers of each actuator
  if (model->actuator_kind) {
    hash = thrum_mix_numbers(hash, model->actuator_rest, 3 * model->actuator_count);
    hash = thrum_mix_numbers(hash, model->actuator_linear, model->actuator_count * model->rank);
    hash = thrum_mix_numbers(hash, model->guide_places, 3 * model->guide_count);
  }

  // what follows has inertia of its own
  if (model->shape && model->follow) {
    hash = thrum_mix_number(hash, (uint64_t)model->shape->rank);
    hash = thrum_mix_numbers(hash, model->follow,
                             (model->shape->rank - model->rank) *
                                 (model->rank * (model->rank + 1) / 2));
    hash = thrum_mix_numbers(hash, &model->follow_scale, 1);
  }
  return hash ? hash : 1;
}
