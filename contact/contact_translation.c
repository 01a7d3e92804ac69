/* How a body moves as a whole under a force. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/contact.h"

void thrum_translation_step(thrum_translation *translation, const double force[3], double dt) {
  for (int axis = 0; axis < 3; axis++) {
    const double kick = dt * force[axis] / translation->mass;
    translation->position[axis] += dt * (translation->velocity[axis] + 0.5 * kick);
    translation->velocity[axis] += kick;
  }
}
