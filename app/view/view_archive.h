/* The archive: models and the scene they stand in, as the viewer in the browser reads them
 * (docs/viewer.md). SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_VIEW_VIEW_ARCHIVE_H
#define THRUM_APP_VIEW_VIEW_ARCHIVE_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "driver/response/response_read.h"
#include "driver/scene/scene_read.h"
#include "driver/scene/scene_run.h"

typedef struct view_archive_model {
  const char *name, *title;
  const thrum_model *model; /* with a mesh and a basis */
  const char *
      surface; /* shown in place of the mesh's skin (driver/export/render_mesh.h); NULL: the skin */
  bool coupled; /* rotation and shape of one of its bodies act on each other */
} view_archive_model;

/* The recorded motion of the bodies of a scene, in its order. */
typedef struct view_archive_motion {
  const recorded_run *runs;    /* count */
  int64_t count;               /* 0: bodies are stepped, and nothing was recorded */
  const recorded_scene *scene; /* that has the runs, for its links; NULL: of a body alone */
  const recorded_curve *curve; /* periodic motions of a body; NULL: there are none */
} view_archive_motion;

typedef struct view_archive {
  unsigned char *bytes; /* malloc; view_archive_free frees */
  size_t size;
} view_archive;

/* Puts the models' arrays, and those of what was recorded, behind one JSON text; `scene` becomes
 * its "scene" and is deleted, also on failure. */
thrum_status view_archive_pack(const view_archive_model *models, int64_t count, cJSON *scene,
                               view_archive_motion motion, view_archive *archive,
                               thrum_error *error);
void view_archive_free(view_archive *archive);

/* The scene of models that stand in none: the first one alone, held as its mesh says, without
 * gravity. The viewer lets people choose among the others. NULL: out of memory. */
cJSON *view_archive_scene_of_models(const view_archive_model *models);

/* The scene of a scene file that was built and made no step yet, without its probes; of_body: the
 * place of each body's model in the archive. NULL: out of memory. */
cJSON *view_archive_scene_of_run(const scene_run *run, const int64_t *of_body);

/* The scene of a finished run; of_body: as above; names: of the bodies. Obstacles come from a scene
 * file that was read again and whose obstacles were made; NULL: none. NULL: out of memory. */
cJSON *view_archive_scene_of_motion(view_archive_motion motion, const char *const *names,
                                    const int64_t *of_body, const scene_run *obstacles);

/* Adds the members of a def that scene files have as keys, by the rows of thrum/fields.h, but for
 * those that `object` has. */
void view_archive_add_fields(cJSON *object, thrum_scene_record record, const void *def);

/* The folder of a finished run, or of a curve, that is to be played. */
typedef struct view_run_request {
  const char *path;
  const char *surface; /* of the one body of a run of a model; NULL: the skin */
  const char *output;  /* the page, which must be no file of the run */
  double fps;          /* rows a second, at most; 0: all */
  bool quiet;
} view_run_request;

/* view_archive_run.c: reads a finished run, of a model or of a scene. */
thrum_status view_archive_of_run(const view_run_request *request, view_archive *archive,
                                 thrum_error *error);

/* view_archive_run.c: reads the curve that `thrum response` left in a folder. */
thrum_status view_archive_of_curve(const view_run_request *request, view_archive *archive,
                                   thrum_error *error);

/* view_archive_effects.c: what acts over time. Adds "q", "p" and "loads" of body n where it has
 * any; "base_motion" and "wind" of all; and the "links" between them. */
void view_archive_add_loads(cJSON *body, const scene_run *run, int32_t n);
void view_archive_add_air_and_ground(cJSON *scene, const scene_run *run);
void view_archive_add_links(cJSON *scene, const scene_run *run);

#endif
