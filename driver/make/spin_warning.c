/* Spins that a basis cannot follow, see spin_warning.h. The centrifugal force of a spin stretches a
 * body; as the reduced static answer is the projection of the full one, the model shows 1 less the
 * square of the share that is missing in the energy norm. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/spin_warning.h"

#include <math.h>
#include <stdlib.h>

#include "config/message.h"
#include "core/base/vec3.h"
#include "driver/make/pull_warning.h"
#include "platform/allocate.h"
#include "precompute/model/load_share.h"

#define SHOWN 0.95         /* of the stretch: a model that shows less is warned of */
#define STRETCH_LEAST 1e-5 /* of the largest side: what stretches by less is not looked at */

void spin_warning_print(const char *name, const thrum_model *model, const thrum_model_scaling *by,
                        const double spin[3]) {
  if (model->basis == NULL || model->tets == NULL || model->vertex_count > PULL_VERTICES_MOST ||
      (spin[0] == 0 && spin[1] == 0 && spin[2] == 0))
    return;

  // where there is no memory for it the run goes on unwarned
  double *forces = NULL;
  thrum_load_share share;
  thrum_status status =
      thrum_reserve(&forces, 3 * model->vertex_count, sizeof *forces, "the spin", NULL);
  THRUM_THEN(status, thrum_load_fill_spin(model, spin, forces, NULL));
  THRUM_THEN(status, thrum_load_share_measure(model, 1, forces, &share, NULL));
  free(forces);
  if (status < 0)
    return;

  // a scaled body is stretched by another share of its size, and shows as much of it
  const double stretch = by->density * by->length * by->length / by->stiffness * share.reach;
  const double shown = 1 - share.statics * share.statics;
  if (shown < SHOWN &&
      stretch > STRETCH_LEAST * thrum_box3_longest(model->vertices, model->vertex_count))
    config_warn(
        "%.100s: this model shows %.0f %% of what its spin stretches the mesh by (linear, "
        "at rest), which is %.2g m: make it by thrum precompute, with twice its rank of %d, "
        "say",
        name, 100 * shown, stretch * by->length, (int)model->rank);
}
