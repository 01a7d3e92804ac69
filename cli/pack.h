/* The pack: models and the scene they stand in, as the viewer in the browser reads them
 * (docs/viewer.md). SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CLI_PACK_H
#define THRUM_CLI_PACK_H

#include <cjson/cJSON.h>

#include "cli/scene_spec.h"

typedef struct cli_pack_model {
  const char *name, *title;
  const thrum_model *model; /* with a mesh and a basis */
  const char *surface;      /* shown in place of the mesh's skin (cli/shown.h); NULL: the skin */
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

/* The scene of a scene file, without what the viewer knows nothing of (loads, starts, wind, shaking
 * ground, probes); of_body: the place of each body's model among these. NULL: out of memory. */
cJSON *cli_pack_scene_of_spec(const scene_spec *spec, const cli_pack_model *models,
                              const int64_t *of_body);

#endif
