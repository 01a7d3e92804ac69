/* Loads what `thrum view` is to show. SPDX-License-Identifier: Apache-2.0 */
#include "cli/view_pack.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/model_name.h"
#include "cli/scene_models.h"

#define TITLE_MAX 64

/* A file's name without its ending, or one of our names with a capital. */
static void make_title(const char *name, char title[TITLE_MAX]) {
  const char *base = cli_basename(name), *dot = strrchr(base, '.');
  const size_t length = dot != NULL && dot > base ? (size_t)(dot - base) : strlen(base);
  snprintf(title, TITLE_MAX, "%.*s", (int)(length < TITLE_MAX ? length : TITLE_MAX - 1), base);
  for (int n = 0; n < CLI_MODEL_COUNT; n++) {
    if (strcmp(name, cli_model_names[n]) == 0)
      title[0] = (char)toupper(title[0]);
  }
}

/* Models with their titles, for a pack. */
typedef struct model_list {
  cli_pack_model *items; /* owned */
  char (*titles)[TITLE_MAX];
  int64_t count;
} model_list;

static thrum_status make_list(int64_t room, model_list *list, thrum_error *error) {
  list->items = calloc((size_t)room + 1, sizeof *list->items);
  list->titles = calloc((size_t)room + 1, sizeof *list->titles);
  return list->items != NULL && list->titles != NULL
             ? THRUM_OK
             : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the models");
}

static void free_list(model_list *list) {
  free(list->items);
  free(list->titles);
}

static cli_pack_model *add(model_list *list, const char *name, const thrum_model *model) {
  cli_pack_model *item = &list->items[list->count];
  make_title(name, list->titles[list->count]);
  *item = (cli_pack_model){
      .name = cli_basename(name), .title = list->titles[list->count++], .model = model};
  return item;
}

static thrum_status pack_models(const char *const *names, int64_t count, const char *surface,
                                bool quiet, cli_pack *pack, thrum_error *error) {
  model_list list = {0};
  thrum_status status = make_list(count, &list, error);
  for (int64_t n = 0; n < count && status >= 0; n++) {
    const thrum_model *model = NULL;
    status = cli_model_load(names[n], quiet, &model, NULL, error);
    if (status >= 0)
      add(&list, names[n], model)->surface = surface;
  }
  if (status >= 0)
    status = cli_pack_make(list.items, count, cli_pack_scene_of_models(list.items), pack, error);
  for (int64_t n = 0; n < list.count; n++)
    thrum_model_free(list.items[n].model);
  free_list(&list);
  return status;
}

static bool same_surface(const char *left, const char *right) {
  return left == right || (left != NULL && right != NULL && strcmp(left, right) == 0);
}

/* Each file's model once for each surface that it is shown by, of its full rank; of_body: its place
 * for each body. */
static void list_models(const scene_models *models, const scene_spec *spec, model_list *list,
                        int64_t *of_body) {
  for (int64_t body = 0; body < spec->bodies.count; body++) {
    const scene_loaded *item = scene_model_of(models, body)->owner;
    const char *surface = scene_bodies(spec)[body].surface;
    int64_t *place = &of_body[body];
    while (*place < list->count && (list->items[*place].model != item->loaded ||
                                    !same_surface(list->items[*place].surface, surface)))
      ++*place;
    if (*place == list->count)
      add(list, item->first->model, item->loaded)->surface = surface;
  }
}

/* Names what moves bodies that the viewer knows nothing of. */
static void warn_of_rest(const scene_spec *spec) {
  bool loads = false, starts = false, beta = false;
  for (int64_t n = 0; n < spec->bodies.count; n++) {
    const scene_body_spec *body = &scene_bodies(spec)[n];
    loads = loads || body->loads.count > 0;
    starts = starts || body->start.count > 0;
    beta = beta || body->settings.def.damping_beta > 0;
  }
  const struct {
    bool there;
    const char *name;
  } rest[] = {{loads, "loads"},
              {starts, "start"},
              {spec->shake.count > 0, "shake"},
              {spec->wind.at.node != NULL, "wind"},
              {beta, "damping that grows with stiffness"}};
  for (size_t n = 0; n < sizeof rest / sizeof rest[0]; n++) {
    if (rest[n].there)
      cli_warn("%.200s: the viewer leaves out %s", spec->file.name, rest[n].name);
  }
}

static thrum_status pack_scene(const char *path, bool quiet, cli_pack *pack, thrum_error *error) {
  scene_spec spec = {0};
  scene_models models = {0};
  model_list list = {0};
  int64_t *of_body = NULL;
  thrum_status status = cli_scene_read(path, &spec, error);
  if (status >= 0)
    status = cli_scene_models_load(&spec, quiet, &models, error);
  if (status >= 0)
    status = make_list(spec.bodies.count, &list, error);
  if (status >= 0) {
    of_body = calloc((size_t)spec.bodies.count + 1, sizeof *of_body);
    status = of_body != NULL ? THRUM_OK
                             : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for bodies");
  }
  if (status >= 0) {
    list_models(&models, &spec, &list, of_body);
    status = cli_pack_make(list.items, list.count,
                           cli_pack_scene_of_spec(&spec, list.items, of_body), pack, error);
  }
  if (status >= 0 && !quiet)
    warn_of_rest(&spec);
  free(of_body);
  free_list(&list);
  cli_scene_models_free(&models);
  cli_scene_free(&spec);
  return status;
}

thrum_status cli_view_pack(const char *const *names, int64_t count, const char *surface, bool quiet,
                           cli_pack *pack, thrum_error *error) {
  return count == 1 && cli_scene_is_named(names[0])
             ? pack_scene(names[0], quiet, pack, error)
             : pack_models(names, count, surface, quiet, pack, error);
}
