/* `thrum info` of a surface that `thrum embed` wrote. SPDX-License-Identifier: Apache-2.0
 */
#include "app/info_surface.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "config/message.h"
#include "core/base/vec3.h"
#include "io/json.h"
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

static void print_table(const char *path, const thrum_embedding *e, const measured *m,
                        const cJSON *meta) {
  char from[200], model[200];
  snprintf(from, sizeof from, "%s", said(meta, "surface"));
  snprintf(model, sizeof model, "%s", said(meta, "model"));
  config_one_line(from);
  config_one_line(model);
  printf("%-18s%s\n", "embedded surface", path);
  printf("%-18s%" PRId64 " vertices, %" PRId64 " triangles, rank %" PRId64 "\n", "size",
         e->vertex_count, e->triangle_count, e->rank);
  printf("%-18s[%.4g, %.4g] x [%.4g, %.4g] x [%.4g, %.4g] m\n", "box", m->box_min[0], m->box_max[0],
         m->box_min[1], m->box_max[1], m->box_min[2], m->box_max[2]);
  printf("%-18s%.3g\n", "largest weight", m->weight_max);
  if (from[0] != 0 || model[0] != 0)
    printf("%-18s%s, in %s\n", "made from", from, model);
}

static void print_json(const char *path, const thrum_embedding *e, const measured *m,
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
  json_print(object);
}

bool info_surface(const char *path, bool json) {
  const thrum_embedding *e = NULL;
  if (thrum_embedding_load(path, &e, NULL) < 0)
    return false;
  const measured m = measure(e);
  cJSON *meta =
      e->meta != NULL ? cJSON_ParseWithLength((const char *)e->meta, (size_t)e->meta_bytes) : NULL;
  (json ? print_json : print_table)(path, e, &m, meta);
  cJSON_Delete(meta);
  thrum_embedding_free(e);
  return true;
}
