/* `thrum info` of a surface that `thrum embed` wrote. SPDX-License-Identifier: Apache-2.0
 */
#include "app/info_surface.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "core/base/vec3.h"
#include "io/json.h"
#include "io/report.h"
#include "thrum/embedding.h"
#include "thrum/thrum.h"

/* The measures of a surface. */
typedef struct measured {
  double box_min[3], box_max[3]; /* [m] */
  double weight_max;
} measured;

static measured measure(const thrum_embedding *e) {
  measured m = {.weight_max = 0};
  thrum_box3(e->positions, e->vertex_count, m.box_min, m.box_max);
  for (int64_t n = 0; n < 4 * e->vertex_count; n++)
    m.weight_max = fmax(m.weight_max, fabs(e->weights[n]));
  return m;
}

/* A text of meta, "" where there is none. */
static const char *said(const cJSON *meta, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(meta, key);
  return cJSON_IsString(item) ? item->valuestring : "";
}

static const report_line lines[] = {
    REPORT_LINE("embedded surface", "{surface}"),
    REPORT_LINE("size", "{vertices} vertices, {triangles} triangles, rank {rank}"),
    REPORT_LINE("box", REPORT_BOX),
    REPORT_LINE("largest weight", "{weight_max:.3g}"),
    REPORT_LINE("made from", "{made_from}, in {model}", .when = "made_from"),
    {0}};

static cJSON *make_report(const char *path, const thrum_embedding *e, const measured *m,
                          const cJSON *meta) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", "done");
  json_string(object, "surface", path);
  json_number(object, "vertices", (double)e->vertex_count);
  json_number(object, "triangles", (double)e->triangle_count);
  json_number(object, "rank", (double)e->rank);
  json_numbers(object, "box_min_m", m->box_min, 3);
  json_numbers(object, "box_max_m", m->box_max, 3);
  json_number(object, "weight_max", m->weight_max);
  json_string(object, "made_from", said(meta, "surface"));
  json_string(object, "model", said(meta, "model"));
  return object;
}

bool info_surface(const char *path, bool json) {
  const thrum_embedding *e = NULL;
  if (thrum_embedding_load(path, &e, NULL) < 0)
    return false;
  const measured m = measure(e);
  cJSON *meta =
      e->meta != NULL ? cJSON_ParseWithLength((const char *)e->meta, (size_t)e->meta_bytes) : NULL;
  report_show(make_report(path, e, &m, meta), NULL, json, REPORT_LABEL_WIDE, lines);
  cJSON_Delete(meta);
  thrum_embedding_destroy(e);
  return true;
}
