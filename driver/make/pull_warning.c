/* Loads that a basis cannot follow, see pull_warning.h. As the reduced static answer is the
 * projection of the full one, what moves along the force is 1 less the square of the share that is
 * missing in the energy norm. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/pull_warning.h"

#include <math.h>
#include <stdlib.h>

#include "config/message.h"
#include "driver/make/precompute_touch.h"
#include "driver/model/model_meta.h"
#include "platform/allocate.h"
#include "precompute/model/load_share.h"

static bool is_pull(const load_spec *load) {
  return !load->gravity && !load->traction && !load->target.all;
}

/* Measures what is missing of the answer to every pull, in their order. */
static thrum_status measure(const thrum_model *model, const load_spec *loads, int64_t count,
                            double *forces, thrum_load_share *shares, thrum_error *error) {
  int64_t pulls = 0;
  for (int64_t n = 0; n < count; n++)
    if (is_pull(&loads[n]))
      THRUM_TRY(
          load_spec_fill(model, &loads[n], forces + 3 * model->vertex_count * pulls++, error));
  return pulls > 0 ? thrum_load_share_measure(model, pulls, forces, shares, error) : THRUM_MISSING;
}

/* Was the model made with touch modes? They follow pulls in the mean over all directions. */
static bool has_touch_modes(const thrum_model *model) {
  cJSON *meta = model_meta_parse(model);
  const bool found = model_meta_find(meta, NULL, "touch") != NULL;
  cJSON_Delete(meta);
  return found;
}

void pull_warning_print(const char *name, const thrum_model *model, const load_spec *loads,
                        int64_t count) {
  if (model->basis == NULL || model->tets == NULL || model->vertex_count > PULL_VERTICES_MOST)
    return;

  // where there is no memory for it the run goes on unwarned
  double *forces = NULL;
  thrum_load_share *shares = NULL;
  thrum_status status = thrum_reserve(&forces, 3 * model->vertex_count * count + 1, sizeof *forces,
                                      "the pulls", NULL);
  THRUM_THEN(status, thrum_reserve(&shares, count + 1, sizeof *shares, "the pulls", NULL));
  THRUM_THEN(status, measure(model, loads, count, forces, shares, NULL));

  // touch modes are no advice for a model that has them
  const char *const advice =
      has_touch_modes(model)
          ? "its touch modes follow pulls in the mean over all directions; add --handles for this "
            "place"
          : "make it with thrum precompute --touch, or with --handles for that place";

  const thrum_load_share *share = shares;
  for (int64_t n = 0; n < count && status >= 0; n++) {
    if (!is_pull(&loads[n]))
      continue;
    const double follows = 1 - share->statics * share->statics;
    share++;
    if (follows < TOUCH_FOLLOWS)
      config_warn("%.100s: this model moves by %.0f %% of what the mesh gives under '%.150s' "
                  "(linear, at rest): %s",
                  name, 100 * follows, loads[n].text, advice);
  }
  free(shares);
  free(forces);
}

thrum_blow pull_measure_blow(const thrum_model *model, const load_spec *loads, int64_t count,
                             double dt) {
  thrum_blow blow = {0};
  const double lasts = count == 1 ? loads->course.until - loads->course.from : INFINITY;
  if (!(lasts <= BLOW_STEPS * dt) || loads->course.shape != THRUM_LOAD_CONSTANT ||
      model->basis == NULL || model->tets == NULL || model->vertex_count > PULL_VERTICES_MOST ||
      thrum_model_masters(model) > 0)
    return blow;

  // a load that ends within a step has its impulse over all of it
  const int64_t steps = (int64_t)fmax(1, round(lasts / dt));
  double *forces = NULL;
  thrum_status status =
      thrum_reserve(&forces, 3 * model->vertex_count, sizeof *forces, "the blow", NULL);
  THRUM_THEN(status, load_spec_fill(model, loads, forces, NULL));
  for (int64_t c = 0; status >= 0 && c < 3 * model->vertex_count; c++)
    forces[c] *= lasts / ((double)steps * dt);
  THRUM_THEN(status, thrum_blow_measure(model, forces, dt, steps, &blow, NULL));
  free(forces);
  return blow;
}
