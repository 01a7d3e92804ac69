/* The pack: models and the scene they stand in, as the viewer in the browser reads them
 * (docs/viewer.md). SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_VIEW_VIEW_ARCHIVE_H
#define THRUM_APP_VIEW_VIEW_ARCHIVE_H

#include <cjson/cJSON.h>

#include "driver/scene_run.h"

typedef struct cli_pack_model {
  const char *name, *title;
  const thrum_model *model; /* with a mesh and a basis */
  const char
      *surface; /* shown in place of the mesh's skin (driver/render_mesh.h); NULL: the skin */
} cli_pack_model;

typedef struct cli_pack {
  unsigned char *bytes; /* malloc; cli_pack_free frees */
  size_t size;
} cli_pack;

/* Puts the models' arrays behind one JSON text; `scene` becomes its "scene" and is deleted, also on
 * failure. */
thrum_status cli_pack_make(const cli_pack_model *models, int64_t count, cJSON *scene,
                           cli_pack *pack, thrum_error *error);
void cli_pack_free(cli_pack *pack);

/* The scene of models that stand in none: the first one alone, held as its mesh says, without
 * gravity. The viewer lets people choose among the others. NULL: out of memory. */
cJSON *cli_pack_scene_of_models(const cli_pack_model *models);

/* The scene of a scene file that was built and made no step yet, without its probes; of_body: the
 * place of each body's model in the pack. NULL: out of memory. */
cJSON *cli_pack_scene_of_run(const scene_run *run, const int64_t *of_body);

/* pack_effects.c: what acts over time. Adds "q", "p" and "loads" of body n where it has any; and
 * "base_motion" and "wind" of all. */
void cli_pack_add_loads(cJSON *body, const scene_run *run, int32_t n);
void cli_pack_add_air_and_ground(cJSON *scene, const scene_run *run);

#endif
