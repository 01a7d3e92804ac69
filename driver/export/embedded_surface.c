/* Reading and embedding a surface, and what there is to say about how it lies.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/embedded_surface.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdlib.h>

#include "config/message.h"
#include "config/progress.h"
#include "io/json.h"
#include "io/paths.h"
#include "mesh/formats/surface_read.h"
#include "platform/clock.h"
#include "thrum/thrum.h"

/* Where the surface comes from; to be freed. NULL: no memory. */
static char *make_meta(const char *model_name, const char *path, double scale) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "tool", "thrum");
  cJSON_AddStringToObject(object, "version", thrum_version());
  json_string(object, "model", path_basename(model_name));
  json_string(object, "surface", path_basename(path));
  json_number(object, "scale", scale);
  char *text = json_text(object);
  cJSON_Delete(object);
  return text;
}

#define PATIENCE 0.5 /* [s] a bar appears for what takes longer */

typedef struct embed_progress {
  config_progress bar;
  double began;
} embed_progress;

static void tell(void *context, double fraction) {
  embed_progress *progress = context;
  if (clock_seconds() - progress->began > PATIENCE)
    config_progress_update(&progress->bar, "embedding", fraction);
}

thrum_status embedded_surface_make(const thrum_model *model, const char *model_name,
                                   const char *path, double scale, bool quiet, thrum_embed *embed,
                                   thrum_error *error) {
  thrum_surface_mesh surface = {0};
  THRUM_TRY(thrum_surface_mesh_read(path, scale, &surface, error));
  char *meta = make_meta(model_name, path, scale);
  if (meta == NULL) {
    thrum_surface_mesh_free(&surface);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the surface's origin");
  }
  embed_progress progress = {config_progress_make(quiet), clock_seconds()};
  const thrum_embed_progress reporting = {tell, &progress};
  thrum_status status = thrum_embed_make(model, &surface, meta, &reporting, embed, error);
  config_progress_end(&progress.bar, status >= 0);
  free(meta);
  thrum_surface_mesh_free(&surface);
  return status;
}

bool embedded_surface_warn(const thrum_embed_report *report, const char *path) {
  const bool far = report->distance_max > THRUM_EMBED_FAR * report->extent;
  if (report->outside > 0)
    config_warn(
        "%s: %" PRId64 " vertices lie outside the mesh, vertex %" PRId64
        " the farthest: %.3g m, %.2g of the body's length; they follow the nearest tetrahedron%s",
        path_basename(path), report->outside, report->farthest + 1, report->distance_max,
        report->distance_max / report->extent,
        far ? "; is the scale right (--scale), and the place?" : "");
  return far;
}
