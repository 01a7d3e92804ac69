/* glTF 2.0 binary files: u(t) = U q(t) is linear in q, so the columns of U at the surface are morph
 * targets and q(t) their weights; nothing is lost but the digits beyond single precision.
 * Khronos, glTF 2.0 Specification, 3.7.2.2 (morph targets) and 4 (binary). Thrum's z is up, glTF's
 * y. Size: 12 bytes x vertices x (r + 1) + 4 bytes x rows x (r + 1).
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/glb.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "io/json.h"
#include "thrum/thrum.h"

enum { FLOAT = 5126, UNSIGNED = 5125, VERTICES = 34962, INDICES = 34963 };

/* The file in the making; accessors and views are numbered alike. */
typedef struct glb {
  cJSON *root, *views, *accessors;
  const recorded_run *run;
  const render_mesh *shown;
  double *scale; /* rank: weights are q / scale */
  double bytes;  /* of the views so far */
} glb;

static void add_view(glb *g, int64_t count, int width, int kind, const char *type, int target) {
  cJSON *view = cJSON_CreateObject(), *accessor = cJSON_CreateObject();
  const double bytes = 4.0 * (double)count * width;
  json_number(view, "buffer", 0);
  json_number(view, "byteOffset", g->bytes);
  json_number(view, "byteLength", bytes);

  // only vertices and indices have a target
  if (target != 0)
    json_number(view, "target", target);

  // each view has one accessor, under the same number
  json_number(accessor, "bufferView", cJSON_GetArraySize(g->views));
  json_number(accessor, "componentType", kind);
  json_number(accessor, "count", (double)count);
  cJSON_AddStringToObject(accessor, "type", type);
  cJSON_AddItemToArray(g->views, view);
  cJSON_AddItemToArray(g->accessors, accessor);
  g->bytes += bytes;
}

/* A component of the surface at rest (column -1), or of a morph target. */
static float value_at(const glb *g, int64_t vertex, int axis, int64_t column) {
  const render_mesh *shown = g->shown;
  const int64_t row = 3 * vertex + axis;
  return column < 0 ? (float)shown->positions[row]
                    : (float)((double)shown->basis[row * shown->rank + column] * g->scale[column]);
}

/* A view of vectors with their bounds. */
static void add_vectors(glb *g, int64_t column) {
  double least[3], most[3];
  for (int axis = 0; axis < 3; axis++) {
    least[axis] = most[axis] = (double)value_at(g, 0, axis, column);
    for (int64_t v = 1; v < g->shown->vertex_count; v++) {
      const double value = (double)value_at(g, v, axis, column);
      least[axis] = fmin(least[axis], value);
      most[axis] = fmax(most[axis], value);
    }
  }

  // glTF demands the bounds of positions
  add_view(g, g->shown->vertex_count, 3, FLOAT, "VEC3", VERTICES);
  cJSON *accessor = cJSON_GetArrayItem(g->accessors, cJSON_GetArraySize(g->accessors) - 1);
  json_numbers(accessor, "min", least, 3);
  json_numbers(accessor, "max", most, 3);
}

/* Views and accessors: rest, targets, indices, times, weights, positions, rotations. */
static void plan_buffer(glb *g) {
  const recorded_run *run = g->run;
  g->views = cJSON_CreateArray();
  g->accessors = cJSON_CreateArray();

  // the surface at rest, one morph target for each coordinate, then the triangles
  for (int64_t column = -1; column < run->rank; column++)
    add_vectors(g, column);
  add_view(g, 3 * g->shown->triangle_count, 1, UNSIGNED, "SCALAR", INDICES);

  // times need their bounds too, in the precision in which they are stored
  add_view(g, run->rows, 1, FLOAT, "SCALAR", 0);
  cJSON *times = cJSON_GetArrayItem(g->accessors, cJSON_GetArraySize(g->accessors) - 1);
  const double least = (double)(float)run->times[0];
  const double most = (double)(float)run->times[run->rows - 1];
  json_numbers(times, "min", &least, 1);
  json_numbers(times, "max", &most, 1);

  // a weight for each target and time, and the motion of a free body
  add_view(g, run->rows * run->rank, 1, FLOAT, "SCALAR", 0);
  if (run->places != NULL) {
    add_view(g, run->rows, 3, FLOAT, "VEC3", 0);
    add_view(g, run->rows, 4, FLOAT, "VEC4", 0);
  }
}

static void add_mesh(glb *g) {
  const int64_t rank = g->run->rank;
  cJSON *mesh = cJSON_CreateObject(), *primitive = cJSON_CreateObject();

  // accessors: rest at 0, targets from 1, indices after them
  json_number(cJSON_AddObjectToObject(primitive, "attributes"), "POSITION", 0);
  json_number(primitive, "indices", (double)(rank + 1));
  json_number(primitive, "material", 0);

  // the weights at first are those of the first row
  cJSON *targets = cJSON_AddArrayToObject(primitive, "targets");
  cJSON *weights = cJSON_AddArrayToObject(mesh, "weights");
  cJSON *extras = cJSON_AddObjectToObject(mesh, "extras");
  cJSON *names = cJSON_AddArrayToObject(extras, "targetNames");
  for (int64_t n = 0; n < rank; n++) {
    char name[32];
    cJSON *target = json_add_row(targets);
    json_number(target, "POSITION", (double)(n + 1));
    cJSON_AddItemToArray(weights, json_number_item(g->run->q[n] / g->scale[n]));
    snprintf(name, sizeof name, "q%lld", (long long)n + 1);
    cJSON_AddItemToArray(names, cJSON_CreateString(name));
  }

  // q is the weight times its scale, for programs that want q back
  json_numbers(extras, "scale", g->scale, rank);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(mesh, "primitives"), primitive);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(g->root, "meshes"), mesh);
}

/* The body's node: under the one that turns z up where it has a place of its own. */
static void add_nodes(glb *g) {
  static const double up[4] = {-0.70710678118654757, 0, 0, 0.70710678118654757}, one = 1;
  const run_placement *place = &g->run->place;

  // the root turns Thrum's z up into glTF's y up
  cJSON *nodes = cJSON_AddArrayToObject(g->root, "nodes");
  cJSON *turned = cJSON_CreateObject(), *body = turned;
  json_numbers(turned, "rotation", up, 4);
  cJSON_AddItemToArray(nodes, turned);

  // a body of a scene has a node of its own below the root
  if (place->placed) {
    const double scale[3] = {place->scale, place->scale, place->scale};
    const double *r = place->rotation, xyzw[4] = {r[1], r[2], r[3], r[0]};
    body = cJSON_CreateObject();
    json_numbers(turned, "children", &one, 1);
    json_numbers(body, "translation", place->position, 3);
    json_numbers(body, "rotation", xyzw, 4);
    json_numbers(body, "scale", scale, 3);
    cJSON_AddItemToArray(nodes, body);
  }

  json_number(body, "mesh", 0);
}

static void add_scene(glb *g) {
  static const double colour[4] = {0.62, 0.69, 0.78, 1}, zero = 0;
  cJSON *asset = cJSON_AddObjectToObject(g->root, "asset");
  cJSON_AddStringToObject(asset, "version", "2.0");
  cJSON_AddStringToObject(asset, "generator", "thrum");

  // one scene with the root node
  json_number(g->root, "scene", 0);
  cJSON *scene = cJSON_CreateObject();
  json_numbers(scene, "nodes", &zero, 1);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(g->root, "scenes"), scene);
  add_nodes(g);

  // a matt grey
  cJSON *material = cJSON_CreateObject();
  cJSON *surface = cJSON_AddObjectToObject(material, "pbrMetallicRoughness");
  json_numbers(surface, "baseColorFactor", colour, 4);
  json_number(surface, "metallicFactor", 0);
  json_number(surface, "roughnessFactor", 0.7);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(g->root, "materials"), material);
}

/* The course of one property of the body's node. */
static void add_channel(const glb *g, cJSON *samplers, cJSON *channels, const char *path,
                        int64_t output) {
  cJSON *sampler = cJSON_CreateObject(), *channel = cJSON_CreateObject();
  json_number(sampler, "input", (double)(g->run->rank + 2));
  json_number(sampler, "output", (double)output);
  cJSON_AddStringToObject(sampler, "interpolation", "LINEAR");
  json_number(channel, "sampler", cJSON_GetArraySize(samplers));
  cJSON *target = cJSON_AddObjectToObject(channel, "target");
  json_number(target, "node", g->run->place.placed ? 1 : 0);
  cJSON_AddStringToObject(target, "path", path);
  cJSON_AddItemToArray(samplers, sampler);
  cJSON_AddItemToArray(channels, channel);
}

static void add_animation(glb *g) {
  const int64_t rank = g->run->rank;
  cJSON *animation = cJSON_CreateObject();

  // other programs show the name of an animation
  if (g->run->stepped_by[0] != 0)
    cJSON_AddStringToObject(animation, "name", g->run->stepped_by);
  cJSON *samplers = cJSON_AddArrayToObject(animation, "samplers");
  cJSON *channels = cJSON_AddArrayToObject(animation, "channels");
  add_channel(g, samplers, channels, "weights", rank + 3);
  if (g->run->places != NULL) {
    add_channel(g, samplers, channels, "translation", rank + 4);
    add_channel(g, samplers, channels, "rotation", rank + 5);
  }
  cJSON_AddItemToArray(cJSON_AddArrayToObject(g->root, "animations"), animation);
}

/* The JSON of the file (malloc), padded to four bytes; NULL: out of memory. */
static char *make_json(glb *g, size_t *length) {
  g->root = cJSON_CreateObject();

  // views are planned first: the rest refers to them by number
  plan_buffer(g);
  add_scene(g);
  add_mesh(g);
  add_animation(g);

  // one buffer holds all views
  cJSON *buffer = cJSON_CreateObject();
  json_number(buffer, "byteLength", g->bytes);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(g->root, "buffers"), buffer);
  cJSON_AddItemToObject(g->root, "bufferViews", g->views);
  cJSON_AddItemToObject(g->root, "accessors", g->accessors);

  // chunks of the file are multiples of four bytes
  char *text = json_text(g->root);
  cJSON_Delete(g->root);
  if (text == NULL)
    return NULL;
  *length = strlen(text);
  char *padded = malloc(*length + 4);
  if (padded != NULL) {
    memcpy(padded, text, *length);
    while (*length % 4 != 0)
      padded[(*length)++] = ' ';
  }
  free(text);
  return padded;
}

/* glTF is little-endian, and so is every machine that this program runs on (the model file too). */
static void put(const thrum_file_writer *writer, const void *data, size_t size) {
  fwrite(data, 1, size, writer->stream); // an error leaves its mark on the stream
}

static void put_number(const thrum_file_writer *writer, uint32_t number) {
  put(writer, &number, sizeof number);
}

static void put_buffer(const glb *g, const thrum_file_writer *writer) {
  const recorded_run *run = g->run;

  // vectors of the surface at rest and of the morph targets
  for (int64_t column = -1; column < run->rank; column++)
    for (int64_t v = 0; v < g->shown->vertex_count; v++) {
      const float vector[3] = {value_at(g, v, 0, column), value_at(g, v, 1, column),
                               value_at(g, v, 2, column)};
      put(writer, vector, sizeof vector);
    }

  put(writer, g->shown->triangles, (size_t)g->shown->triangle_count * 3 * sizeof(int32_t));

  // times and weights, row by row
  for (int64_t n = 0; n < run->rows; n++) {
    const float time = (float)run->times[n];
    put(writer, &time, sizeof time);
  }
  for (int64_t n = 0; n < run->rows * run->rank; n++) {
    const float weight = (float)(run->q[n] / g->scale[n % run->rank]);
    put(writer, &weight, sizeof weight);
  }

  // the place of a free body: positions, then rotations with w last
  for (int64_t n = 0; run->places != NULL && n < run->rows; n++) {
    const double *at = run->places + RUN_PLACEMENT_COLUMNS * n;
    const float position[3] = {(float)at[0], (float)at[1], (float)at[2]};
    put(writer, position, sizeof position);
  }
  for (int64_t n = 0; run->places != NULL && n < run->rows; n++) {
    const double *turn = run->places + RUN_PLACEMENT_COLUMNS * n + 3;
    const float xyzw[4] = {(float)turn[1], (float)turn[2], (float)turn[3], (float)turn[0]};
    put(writer, xyzw, sizeof xyzw);
  }
}

static thrum_status write_file(const char *path, const glb *g, const char *json, size_t length,
                               thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  const double total = 28 + (double)length + g->bytes;
  if (total >= 4294967296.0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: %.1f GB, and a .glb holds 4: write fewer rows (--fps)", path,
                           1e-9 * total);

  // a header of 12 bytes, then the chunks of JSON and of the buffer
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  put(&writer, "glTF", 4);
  put_number(&writer, 2);
  put_number(&writer, (uint32_t)total);
  put_number(&writer, (uint32_t)length);
  put(&writer, "JSON", 4);
  put(&writer, json, length);
  put_number(&writer, (uint32_t)g->bytes);
  put(&writer, "BIN", 4);
  put_buffer(g, &writer);
  return thrum_file_writer_commit(&writer, error);
}

/* glTF wants times that ascend, and has them in single precision. */
static thrum_status check_times(const char *path, const recorded_run *run, thrum_error *error) {
  for (int64_t n = 1; n < run->rows; n++) {
    if (!((float)run->times[n] > (float)run->times[n - 1]))
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "%.200s: rows at %.9g and %.9g s are one in single precision: write "
                             "fewer (--fps)",
                             path, run->times[n - 1], run->times[n]);
  }
  return THRUM_OK;
}

thrum_status glb_write(const char *path, const recorded_run *run, const render_mesh *shown,
                       thrum_error *error) {
  THRUM_TRY(check_times(path, run, error));
  glb g = {.run = run, .shown = shown};
  size_t length = 0;
  char *json = NULL;

  // weights are q over its largest magnitude, so that they lie between -1 and 1
  g.scale = calloc((size_t)run->rank, sizeof *g.scale);
  if (g.scale != NULL) {
    for (int64_t n = 0; n < run->rows * run->rank; n++)
      g.scale[n % run->rank] = fmax(g.scale[n % run->rank], fabs(run->q[n]));
    for (int64_t n = 0; n < run->rank; n++)
      g.scale[n] = g.scale[n] > 0 ? g.scale[n] : 1;
    json = make_json(&g, &length);
  }

  const thrum_status status =
      json != NULL ? write_file(path, &g, json, length, error)
                   : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %.200s", path);
  free(json);
  free(g.scale);
  return status;
}
