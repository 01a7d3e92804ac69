/* Writes the viewer archive (docs/viewer.md): 8 bytes of magic, the length of the JSON, the JSON,
 * then arrays, each at a multiple of 8 bytes so that a browser may view them in place.
 * Little-endian, as every machine that this program runs on. Only vertices of the surface go in: at
 * rank r each costs 12 (r + 1) bytes. SPDX-License-Identifier: Apache-2.0 */
#include "app/view/view_archive.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/export/render_mesh.h"
#include "driver/make/pull_warning.h"
#include "io/json.h"
#include "mesh/model_quality.h"
#include "precompute/model/solid_inertia.h"
#include "precompute/model/touch.h"
#include "runtime/material/material_law.h"
#include "thrum/response.h"
#include "thrum/thrum.h"

#define MAGIC "THRUMPK1"
#define HEAD_BYTES 16
#define PACK_FORMAT 1

/* The data section in the making. */
typedef struct data_section {
  unsigned char *bytes;
  size_t size, room;
  bool failed;
} data_section;

static size_t aligned(size_t size) {
  return (size + 7) / 8 * 8;
}

/* The bytes of an element: of "f8", 8. */
static size_t width_of(const char *kind) {
  return (size_t)(kind[1] - '0');
}

/* Room for an array of `count` elements, zeroed, noted in `arrays` as [offset, count, kind]; NULL:
 * out of memory. It moves when the next one is added. */
static void *add_array(data_section *data, cJSON *arrays, const char *name, int64_t count,
                       const char *kind) {
  // room for the array, doubled so that many arrays move it seldom
  const size_t size = data->size + aligned((size_t)count * width_of(kind));
  if (size > data->room) {
    const size_t room = 2 * size;
    unsigned char *grown = realloc(data->bytes, room);
    data->failed = data->failed || grown == NULL;
    if (grown == NULL)
      return NULL;
    data->bytes = grown;
    data->room = room;
  }

  // the array begins as zeros, and its place is noted
  void *array = data->bytes + data->size;
  memset(array, 0, size - data->size);
  cJSON *place = cJSON_AddArrayToObject(arrays, name);
  cJSON_AddItemToArray(place, json_number_item((double)data->size));
  cJSON_AddItemToArray(place, json_number_item((double)count));
  cJSON_AddItemToArray(place, cJSON_CreateString(kind));
  data->size = size;
  return array;
}

/* The values as they are. */
static void add_copy(data_section *data, cJSON *arrays, const char *name, const void *values,
                     int64_t count, const char *kind) {
  void *array = add_array(data, arrays, name, count, kind);
  if (array != NULL && count > 0)
    memcpy(array, values, (size_t)count * width_of(kind));
}

static void add_doubles(data_section *data, cJSON *arrays, const char *name, const double *values,
                        int64_t count) {
  add_copy(data, arrays, name, values, count, "f8");
}

/* Numbers in single precision, which is enough to be looked at. */
static void add_floats(data_section *data, cJSON *arrays, const char *name, const double *values,
                       int64_t count) {
  float *array = add_array(data, arrays, name, count, "f4");
  for (int64_t n = 0; n < count && array != NULL; n++)
    array[n] = (float)values[n];
}

static void add_surface(data_section *data, cJSON *arrays, const render_mesh *shown) {
  const int64_t rows = 3 * shown->vertex_count;
  add_floats(data, arrays, "positions", shown->positions, rows);
  add_copy(data, arrays, "basis", shown->basis, rows * shown->rank, "f4");
  add_copy(data, arrays, "triangles", shown->triangles, 3 * shown->triangle_count, "i4");
  add_copy(data, arrays, "fixed", shown->fixed, shown->vertex_count, "u1");
}

/* These give the inertia of a free body: the corners of its first tetrahedron, and the
 * rigid modes there. */
static void add_rigid(data_section *data, cJSON *arrays, const thrum_model *model) {
  double corners[12], modes[72];
  if (model->rigid == NULL || model->tet_count < 1)
    return;
  for (int n = 0; n < 4; n++) {
    memcpy(corners + 3 * n, model->vertices + 3 * (int64_t)model->tets[n], 3 * sizeof *corners);
    memcpy(modes + 18 * n, model->rigid + 18 * (int64_t)model->tets[n], 18 * sizeof *modes);
  }
  add_doubles(data, arrays, "tet", corners, 12);
  add_doubles(data, arrays, "tet_rigid", modes, 72);
}

/* Adds the arrays of the strain energy: coefficients, of what is stepped alone where the others
 * follow, or cubature points. */
static void add_energy(data_section *data, cJSON *arrays, const thrum_model *model) {
  const int64_t points = model->point_count;

  // a model whose others follow has the polynomial of what is stepped
  if (thrum_model_masters(model) > 0) {
    add_doubles(data, arrays, "slave_map", model->slave_map,
                model->slave_count * model->slave_pairs);
    add_doubles(data, arrays, "condensed_c3", model->condensed_c3, model->condensed_c3_count);
    add_doubles(data, arrays, "condensed_c4", model->condensed_c4, model->condensed_c4_count);
    return;
  }

  if (points == 0) {
    add_doubles(data, arrays, "c3", model->c3, model->c3_count);
    add_doubles(data, arrays, "c4", model->c4, model->c4_count);
    return;
  }

  add_doubles(data, arrays, "point_weights", model->point_weights, points);
  add_doubles(data, arrays, "point_moduli", model->point_moduli, 2 * points);
  add_doubles(data, arrays, "point_gradients", model->point_gradients, 9 * points * model->rank);
  if (model->point_law != NULL)
    add_copy(data, arrays, "point_law", model->point_law, model->law_bytes, "u1");
  if (model->region_law != NULL) {
    add_copy(data, arrays, "point_region", model->point_region, points, "i4");
    add_copy(data, arrays, "region_law", model->region_law, model->law_count, "u1");
  }
}

/* The page makes the inertia of a coupled body's shape of these, for which it has too few of the
 * mesh. */
static thrum_status add_inertia(data_section *data, cJSON *arrays, const thrum_model *model,
                                thrum_error *error) {
  thrum_inertia *inertia = NULL;
  THRUM_TRY(thrum_solid_inertia_create(model, &inertia, error));
  double *array = add_array(data, arrays, "inertia", thrum_inertia_number_count(model->rank), "f8");
  if (array != NULL)
    thrum_inertia_numbers(inertia, array);
  thrum_inertia_destroy(inertia);
  return THRUM_OK;
}

/* Adds the per cent of the mesh's linear answer by which the model follows a pull at each vertex,
 * so that the page can say it where the user pulls. It is left out where it cannot be measured, or
 * would take too long. */
static void add_follows(data_section *data, cJSON *arrays, const thrum_model *model,
                        const render_mesh *shown) {
  if (model->tets == NULL || model->vertex_count > PULL_VERTICES_MOST)
    return;
  thrum_touch *touch = NULL;
  thrum_touch_coverage coverage;
  double *follows = NULL;
  thrum_status status = thrum_touch_create(model, &touch, NULL);
  THRUM_THEN(status,
             thrum_reserve(&follows, shown->vertex_count, sizeof *follows, "the pulls", NULL));

  // a page without them for lack of memory would be another page
  data->failed = data->failed || status == THRUM_OUT_OF_MEMORY;

  // whole per cents are enough to be read
  unsigned char *array =
      status < 0 ? NULL : add_array(data, arrays, "follows", shown->vertex_count, "u1");
  if (array != NULL) {
    thrum_touch_measure(touch, model, &coverage);
    thrum_touch_spread(touch, shown->positions, shown->vertex_count, follows);
    for (int64_t v = 0; v < shown->vertex_count; v++)
      array[v] = (unsigned char)(100 * fmin(1, fmax(0, follows[v])));
  }
  free(follows);
  thrum_touch_free(touch);
}

static thrum_status add_model(data_section *data, cJSON *list, const view_archive_model *item,
                              bool pulled, thrum_error *error) {
  // what the viewer cannot show is refused
  const thrum_model *model = item->model;
  render_mesh shown = {0};
  thrum_quality quality;
  if (model->vertices == NULL || model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "%.200s: the model has no mesh or no basis, so nothing can be shown",
                           item->name);
  if (model->axis_mass == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "%.200s: the model has no axis_mass, so gravity cannot act on it",
                           item->name);

  // a recorded motion is that of the flow already
  if (pulled && thrum_law_has_yield(model))
    config_warn("%.200s: the viewer leaves out plastic flow: bodies are elastic there", item->name);

  // the page needs the body's mass and the surface that is shown
  THRUM_TRY(thrum_quality_measure(model, &quality, error));
  THRUM_TRY(render_mesh_make(model, item->surface, &shown, error));

  // the model's description, and its arrays
  cJSON *object = json_add_row(list);
  json_string(object, "name", item->name);
  json_string(object, "title", item->title);
  json_number(object, "rank", (double)model->rank);
  if (thrum_model_masters(model) > 0)
    json_number(object, "masters", (double)thrum_model_masters(model));
  json_number(object, "vertex_count", (double)shown.vertex_count);
  json_number(object, "triangle_count", (double)shown.triangle_count);
  json_number(object, "mass", quality.mass);
  json_number(object, "young", model->material[0]);
  json_number(object, "unit_energy", thrum_model_unit_energy(model));
  json_number(object, "poisson", model->material[1]);
  json_number(object, "regions", (double)model->region_count);
  cJSON *arrays = cJSON_AddObjectToObject(object, "arrays");
  add_doubles(data, arrays, "omega2", model->omega2, model->rank);
  add_energy(data, arrays, model);
  add_doubles(data, arrays, "axis_mass", model->axis_mass, 3 * model->rank);
  add_rigid(data, arrays, model);
  add_surface(data, arrays, &shown);
  if (pulled)
    add_follows(data, arrays, model, &shown);
  render_mesh_free(&shown);
  return item->coupled ? add_inertia(data, arrays, model, error) : THRUM_OK;
}

/* The recorded motion of one body. */
static void add_motion(data_section *data, cJSON *list, const recorded_run *run) {
  cJSON *object = json_add_row(list);
  json_number(object, "rank", (double)run->rank);
  json_string(object, "stepped_by", run->stepped_by);
  cJSON *arrays = cJSON_AddObjectToObject(object, "arrays");
  add_doubles(data, arrays, "times", run->times, run->rows);
  add_doubles(data, arrays, "energies", run->energies, 2 * run->rows);
  add_floats(data, arrays, "q", run->q, run->rows * run->rank);
  if (run->places != NULL)
    add_floats(data, arrays, "places", run->places, run->rows * RUN_PLACEMENT_COLUMNS);
}

/* The motions of a curve. */
static void add_curve(data_section *data, cJSON *root, const recorded_curve *curve) {
  cJSON *object = cJSON_AddObjectToObject(root, "curve");
  json_string(object, "target", curve->target);
  json_number(object, "harmonics", (double)curve->harmonics);
  json_number(object, "periods", (double)curve->periods);
  cJSON *kinds = cJSON_AddArrayToObject(object, "kinds");
  for (thrum_response_kind kind = 0; thrum_response_kind_name(kind) != NULL; kind++)
    json_add_string(kinds, thrum_response_kind_name(kind));

  // a row for each motion
  cJSON *arrays = cJSON_AddObjectToObject(object, "arrays");
  add_doubles(data, arrays, "frequency", curve->frequency, curve->rows);
  add_doubles(data, arrays, "peak", curve->peak, curve->rows);
  add_copy(data, arrays, "unstable", curve->unstable, curve->rows, "i4");
  add_copy(data, arrays, "kind", curve->kind, curve->rows, "i4");
  add_floats(data, arrays, "motion", curve->motion,
             curve->rows * (2 * curve->harmonics + 1) * curve->model->rank);
}

/* Adds the links of a recorded scene, by their kinds and names, and the state of each in each row.
 */
static void add_links(data_section *data, cJSON *root, const recorded_scene *scene) {
  if (scene == NULL || scene->link_count == 0)
    return;
  cJSON *object = cJSON_AddObjectToObject(root, "recorded_links");
  cJSON *list = cJSON_AddArrayToObject(object, "links");
  const cJSON *link;
  cJSON_ArrayForEach(link, cJSON_GetObjectItemCaseSensitive(scene->object, "links")) {
    const char *name = json_text_of(link, "name"), *kind = json_text_of(link, "kind");
    cJSON *row = json_add_row(list);
    json_string(row, "kind", kind != NULL ? kind : "");
    if (name != NULL)
      json_string(row, "name", name);
  }

  // doubles, as how far a joint is open may be below what single precision tells of a place
  add_doubles(data, cJSON_AddObjectToObject(object, "arrays"), "links", scene->links,
              scene->runs[0].rows * scene->link_count * SCENE_LINK_COLUMNS);
}

/* Head, JSON padded with spaces, data. */
static thrum_status join(const cJSON *root, const data_section *data, view_archive *archive,
                         thrum_error *error) {
  char *text = json_text(root);
  const size_t length = text != NULL ? strlen(text) : 0, padded = aligned(length);
  const uint32_t numbers[2] = {(uint32_t)padded, 0};
  unsigned char *bytes =
      text != NULL && !data->failed ? malloc(HEAD_BYTES + padded + data->size) : NULL;
  if (bytes == NULL) {
    cJSON_free(text);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the archive of models");
  }

  // head, text and arrays, one after the other
  memcpy(bytes, MAGIC, 8);
  memcpy(bytes + 8, numbers, sizeof numbers);
  memset(bytes + HEAD_BYTES, ' ', padded);
  memcpy(bytes + HEAD_BYTES, text, length);
  if (data->size > 0)
    memcpy(bytes + HEAD_BYTES + padded, data->bytes, data->size);

  cJSON_free(text);
  *archive = (view_archive){bytes, HEAD_BYTES + padded + data->size};
  return THRUM_OK;
}

thrum_status view_archive_pack(const view_archive_model *models, int64_t count, cJSON *scene,
                               view_archive_motion motion, view_archive *archive,
                               thrum_error *error) {
  data_section data = {0};
  cJSON *root = cJSON_CreateObject();
  json_number(root, "format", PACK_FORMAT);
  cJSON_AddItemToObject(root, "scene", scene);
  cJSON *list = cJSON_AddArrayToObject(root, "models");
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < count && status >= 0; n++)
    status = add_model(&data, list, &models[n], motion.count == 0 && motion.curve == NULL, error);
  cJSON *recording = motion.count > 0 ? cJSON_AddArrayToObject(root, "recording") : NULL;
  for (int64_t n = 0; n < motion.count && status >= 0; n++)
    add_motion(&data, recording, &motion.runs[n]);
  add_links(&data, root, motion.scene);
  if (motion.curve != NULL)
    add_curve(&data, root, motion.curve);
  THRUM_THEN(status, join(root, &data, archive, error));
  cJSON_Delete(root);
  free(data.bytes);
  return status;
}

void view_archive_free(view_archive *archive) {
  free(archive->bytes);
  *archive = (view_archive){0};
}
