/* Loads what `thrum view` is to show. SPDX-License-Identifier: Apache-2.0 */
#include "app/view/view_archive_make.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "app/view/view_archive.h"
#include "app/view/view_archive_list.h"
#include "config/message.h"
#include "driver/make/named_model.h"
#include "driver/model/locking.h"
#include "driver/scene/scene_run.h"
#include "driver/scene/scene_run_build.h"
#include "driver/spec/model_names.h"
#include "io/paths.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

static thrum_status pack_models(const char *const *names, int64_t count, const char *surface,
                                bool quiet, view_archive *archive, thrum_error *error) {
  // every model is loaded, or none is shown
  view_archive_list list = {0};
  thrum_status status = view_archive_list_make(count, &list, error);
  for (int64_t n = 0; n < count && status >= 0; n++) {
    const thrum_model *model = NULL;
    status = named_model_load_touch(names[n], quiet, &model, error);
    if (status >= 0)
      view_archive_list_add(&list, names[n], model)->surface = surface;
  }

  // the first one stands in the scene
  THRUM_THEN(status, view_archive_pack(list.items, count, view_archive_scene_of_models(list.items),
                                       (view_archive_motion){0}, archive, error));

  for (int64_t n = 0; n < list.count; n++) {
    if (status >= 0)
      locking_warn(path_basename(names[n]), list.items[n].model);
    thrum_model_destroy(list.items[n].model);
  }
  view_archive_list_free(&list);
  return status;
}

static bool same_surface(const char *left, const char *right) {
  return left == right || (left != NULL && right != NULL && strcmp(left, right) == 0);
}

/* Each file's model once for each surface that it is shown by, of its full rank; of_body: its place
 * for each body. */
static void list_models(const scene_run *run, view_archive_list *list, int64_t *of_body) {
  for (int64_t body = 0; body < run->spec.bodies.count; body++) {
    const scene_loaded *item = scene_model_of(&run->models, body);
    const char *surface = run->bodies[body].spec->surface;
    int64_t *place = &of_body[body];
    while (*place < list->count && (list->items[*place].model != item->model ||
                                    !same_surface(list->items[*place].surface, surface)))
      ++*place;
    if (*place == list->count)
      view_archive_list_add(list, item->first->model, item->model)->surface = surface;
    list->items[*place].coupled |= run->bodies[body].def.coupled != 0;
  }
}

/* Names what acts on bodies that the viewer knows nothing of. */
static void warn_of_rest(const scene_spec *spec) {
  bool beta = false, flows = false;
  for (int64_t n = 0; n < spec->bodies.count; n++) {
    beta = beta || scene_bodies(spec)[n].settings.def.damping_beta > 0;
    flows = flows || isfinite(scene_bodies(spec)[n].material.plastic.yield);
  }

  // one line for each
  if (flows)
    config_warn("%.200s: the viewer leaves out plastic flow: bodies are elastic there",
                spec->file.name);
  if (beta)
    config_warn("%.200s: the viewer leaves out damping that grows with stiffness", spec->file.name);
}

static thrum_status pack_run(const scene_run *run, view_archive *archive, thrum_error *error) {
  const int64_t count = run->spec.bodies.count;
  view_archive_list list = {0};
  int64_t *of_body = NULL;
  thrum_status status = thrum_reserve(&of_body, count, sizeof *of_body, "bodies", error);
  THRUM_THEN(status, view_archive_list_make(count, &list, error));
  if (status >= 0) {
    list_models(run, &list, of_body);
    status = view_archive_pack(list.items, list.count, view_archive_scene_of_run(run, of_body),
                               (view_archive_motion){0}, archive, error);
  }
  free(of_body);
  view_archive_list_free(&list);
  return status;
}

/* Builds the scene as `thrum simulate` does, so that the same scenes are refused here. */
static thrum_status pack_scene(const char *path, bool quiet, view_archive *archive,
                               thrum_error *error) {
  const scene_request request = {.path = path, .output = "", .quiet = quiet};
  scene_run *run = NULL;
  THRUM_TRY(thrum_reserve(&run, 1, sizeof *run, "the scene", error));

  run->request = &request;

  // a damping that the page leaves out is named once the archive is there
  thrum_status status = scene_run_read(run, error);
  THRUM_THEN(status, scene_run_build(run, error));
  THRUM_THEN(status, pack_run(run, archive, error));
  if (status >= 0)
    scene_models_warn(&run->spec, &run->models);
  if (status >= 0 && !quiet)
    warn_of_rest(&run->spec);

  scene_run_close(run);
  free(run);
  return status;
}

thrum_status view_archive_of_names(const char *const *names, int64_t count, const char *surface,
                                   bool quiet, view_archive *archive, thrum_error *error) {
  return count == 1 && is_scene_name(names[0])
             ? pack_scene(names[0], quiet, archive, error)
             : pack_models(names, count, surface, quiet, archive, error);
}
