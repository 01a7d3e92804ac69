/* States of bodies, and the scratch and workspace that they borrow for a step.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_state.h"

#include "scene/scene_memory.h"

#include <stdlib.h>

thrum_status scene_scratch_replace(thrum_scene *scene, int32_t workers, size_t size,
                                   thrum_error *error) {
  void *scratch = size > 0 ? scene_aligned((size_t)workers * size) : NULL;
  if (scratch == NULL && size > 0)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for steps of %zu bytes", size);

  // the states that are there take the new one, which is large enough for all
  for (int32_t n = 0; n < scene->body_count; n++)
    thrum_state_lend(scene->bodies[n]->state, scratch, size, NULL);
  free(scene->scratch);
  scene->scratch = scratch;
  scene->scratch_size = size;
  return THRUM_OK;
}

/* Makes the scratch of the scene as large as a state of this def needs. */
static thrum_status make_scratch(thrum_scene *scene, const thrum_model *model,
                                 const thrum_state_def *def, thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_state_scratch_size(model, def, &size, error));
  return scene_round_up(size) <= scene->scratch_size
             ? THRUM_OK
             : scene_scratch_replace(scene, scene->workers, scene_round_up(size), error);
}

void scene_lend(const thrum_scene *scene, const scene_body *body, int32_t worker) {
  thrum_state_lend(body->state,
                   (unsigned char *)scene->scratch + (size_t)worker * scene->scratch_size,
                   scene->scratch_size, NULL);
}

void *scene_workspace(const thrum_scene *scene, int32_t worker) {
  return (unsigned char *)scene->workspace + (size_t)worker * scene->workspace_size;
}

thrum_status scene_state_make(thrum_scene *scene, const thrum_model *model,
                              const thrum_state_def *def, const double *q, const double *p,
                              thrum_state **state, thrum_error *error) {
  THRUM_TRY(make_scratch(scene, model, def, error));
  THRUM_TRY(thrum_state_create(model, def, state, error));
  thrum_status status = thrum_state_lend(*state, scene->scratch, scene->scratch_size, error);
  THRUM_THEN(status, thrum_state_set(model, *state, q, p, error));
  if (status < 0) {
    thrum_state_destroy(*state);
    *state = NULL;
  }
  return status;
}

/* Slaves x masters are most where there are as many of each. */
thrum_status scene_slopes_make(scene_body *body, thrum_error *error) {
  if (body->slopes != NULL)
    return THRUM_OK;
  const size_t half = (size_t)body->model->rank / 2 + 1;
  body->slopes = calloc(half * half, sizeof *body->slopes);
  return body->slopes != NULL
             ? THRUM_OK
             : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a condensed body");
}
