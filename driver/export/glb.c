/* glTF 2.0 binary files: u(t) = U q(t) is linear in q, so the columns of U at the surface are morph
 * targets and q(t) their weights; nothing is lost but the digits beyond single precision. Normals
 * are linearised in q, and players make them of unit length.
 * Khronos, glTF 2.0 Specification, 3.7.2.2 (morph targets) and 4 (binary). Thrum's z is up, glTF's
 * y. Size of a body: 24 bytes x vertices x (r + 1) + 4 bytes x rows x (r + 1).
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/glb.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/export/smooth_normals.h"
#include "io/file.h"
#include "io/json.h"
#include "thrum/thrum.h"

enum { FLOAT = 5126, UNSIGNED = 5125, VERTICES = 34962, INDICES = 34963 };

/* A body in the making. Its accessors follow each other: the surface at rest, a target for each
 * coordinate, triangles, times, weights, normals at rest, their targets, and the place of a body
 * that moves as a whole. */
typedef struct body {
  const recorded_run *run;
  const render_mesh *shown;
  const char *name;
  smooth_normals smooth; /* the surface is split where it has edges */
  double *scale;         /* rank: weights are q / scale */
  int64_t first, node;   /* its first accessor and its node */
} body;

/* The file in the making; accessors and views are numbered alike. */
typedef struct glb {
  cJSON *root, *views, *accessors;
  body *bodies;
  int64_t count;
  double bytes; /* of the views so far */
} glb;

typedef enum vector_kind { POSITIONS, NORMALS } vector_kind;

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

/* The bounds of what was added last. */
static void add_bounds(glb *g, const double *least, const double *most, int count) {
  cJSON *accessor = cJSON_GetArrayItem(g->accessors, cJSON_GetArraySize(g->accessors) - 1);
  json_numbers(accessor, "min", least, count);
  json_numbers(accessor, "max", most, count);
}

/* A component of the surface at rest (column -1), or of a morph target. */
static float value_at(const body *b, vector_kind kind, int64_t vertex, int axis, int64_t column) {
  const render_mesh *shown = b->shown;
  const int64_t from = kind == POSITIONS ? b->smooth.source[vertex] : vertex, row = 3 * from + axis;
  if (column < 0)
    return kind == POSITIONS ? (float)shown->positions[row] : b->smooth.normals[row];
  const float *changes = kind == POSITIONS ? shown->basis : b->smooth.change;
  return (float)((double)changes[row * shown->rank + column] * b->scale[column]);
}

/* A view of positions with their bounds, which glTF demands. */
static void add_positions(glb *g, const body *b, int64_t column) {
  double least[3], most[3];
  for (int axis = 0; axis < 3; axis++) {
    least[axis] = most[axis] = (double)value_at(b, POSITIONS, 0, axis, column);
    for (int64_t v = 1; v < b->smooth.vertex_count; v++) {
      const double value = (double)value_at(b, POSITIONS, v, axis, column);
      least[axis] = fmin(least[axis], value);
      most[axis] = fmax(most[axis], value);
    }
  }
  add_view(g, b->smooth.vertex_count, 3, FLOAT, "VEC3", VERTICES);
  add_bounds(g, least, most, 3);
}

/* Views and accessors of a body, in the order that put_body writes. */
static void plan_body(glb *g, body *b) {
  const recorded_run *run = b->run;
  b->first = cJSON_GetArraySize(g->accessors);

  // the surface at rest, one morph target for each coordinate, then the triangles
  for (int64_t column = -1; column < run->rank; column++)
    add_positions(g, b, column);
  add_view(g, 3 * b->shown->triangle_count, 1, UNSIGNED, "SCALAR", INDICES);

  // times need their bounds too, in the precision in which they are stored
  add_view(g, run->rows, 1, FLOAT, "SCALAR", 0);
  const double least = (double)(float)run->times[0];
  const double most = (double)(float)run->times[run->rows - 1];
  add_bounds(g, &least, &most, 1);

  // a weight for each target and time
  add_view(g, run->rows * run->rank, 1, FLOAT, "SCALAR", 0);

  // normals have a target for each coordinate as well
  for (int64_t column = -1; column < run->rank; column++)
    add_view(g, b->smooth.vertex_count, 3, FLOAT, "VEC3", VERTICES);

  // the motion of a free body
  if (run->places != NULL) {
    add_view(g, run->rows, 3, FLOAT, "VEC3", 0);
    add_view(g, run->rows, 4, FLOAT, "VEC4", 0);
  }
}

static void add_mesh(const body *b, int64_t number, cJSON *meshes) {
  const int64_t rank = b->run->rank, normals = b->first + rank + 4;
  cJSON *mesh = cJSON_CreateObject(), *primitive = cJSON_CreateObject();
  cJSON *attributes = cJSON_AddObjectToObject(primitive, "attributes");
  json_number(attributes, "POSITION", (double)b->first);
  json_number(attributes, "NORMAL", (double)normals);
  json_number(primitive, "indices", (double)(b->first + rank + 1));
  json_number(primitive, "material", (double)number);

  // the weights at first are those of the first row
  cJSON *targets = cJSON_AddArrayToObject(primitive, "targets");
  cJSON *weights = cJSON_AddArrayToObject(mesh, "weights");
  cJSON *extras = cJSON_AddObjectToObject(mesh, "extras");
  cJSON *names = cJSON_AddArrayToObject(extras, "targetNames");
  for (int64_t n = 0; n < rank; n++) {
    char name[32];
    cJSON *target = json_add_row(targets);
    json_number(target, "POSITION", (double)(b->first + n + 1));
    json_number(target, "NORMAL", (double)(normals + n + 1));
    cJSON_AddItemToArray(weights, json_number_item(b->run->q[n] / b->scale[n]));
    snprintf(name, sizeof name, "q%lld", (long long)n + 1);
    cJSON_AddItemToArray(names, cJSON_CreateString(name));
  }

  // q is the weight times its scale, for programs that want q back
  json_numbers(extras, "scale", b->scale, rank);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(mesh, "primitives"), primitive);
  cJSON_AddItemToArray(meshes, mesh);
}

/* The body's node, where it stands in its scene; one that has no place of its own stands at the
 * origin. */
static cJSON *node_of(const body *b, int64_t number) {
  const run_placement *place = &b->run->place;
  cJSON *node = cJSON_CreateObject();
  if (b->name != NULL)
    json_string(node, "name", b->name);
  if (place->placed) {
    const double scale[3] = {place->scale, place->scale, place->scale};
    const double *r = place->rotation, xyzw[4] = {r[1], r[2], r[3], r[0]};
    json_numbers(node, "translation", place->position, 3);
    json_numbers(node, "rotation", xyzw, 4);
    json_numbers(node, "scale", scale, 3);
  }
  json_number(node, "mesh", (double)number);
  return node;
}

/* A part of a colour as people name it, in the linear scale of glTF: sRGB of IEC 61966-2-1. */
static double linear_colour(double value) {
  return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

/* A matt surface of the body's colour. */
static cJSON *material_of(const body *b) {
  cJSON *material = cJSON_CreateObject();
  cJSON *surface = cJSON_AddObjectToObject(material, "pbrMetallicRoughness");
  double colour[4] = {0, 0, 0, 1};
  for (int n = 0; n < 3; n++)
    colour[n] = linear_colour(b->run->place.colour[n]);
  json_numbers(surface, "baseColorFactor", colour, 4);
  json_number(surface, "metallicFactor", 0);
  json_number(surface, "roughnessFactor", 0.7);
  return material;
}

/* One scene: below a node that turns Thrum's z up into glTF's y up, all bodies. */
static void add_scene(glb *g) {
  static const double up[4] = {-0.70710678118654757, 0, 0, 0.70710678118654757}, zero = 0;

  // the file's only scene has one root
  cJSON *asset = cJSON_AddObjectToObject(g->root, "asset");
  cJSON_AddStringToObject(asset, "version", "2.0");
  cJSON_AddStringToObject(asset, "generator", "thrum");
  json_number(g->root, "scene", 0);
  cJSON *scene = json_add_row(cJSON_AddArrayToObject(g->root, "scenes"));
  json_numbers(scene, "nodes", &zero, 1);

  // the root turns, and each body is a child of it with a mesh and a material of its own
  cJSON *nodes = cJSON_AddArrayToObject(g->root, "nodes");
  cJSON *meshes = cJSON_AddArrayToObject(g->root, "meshes");
  cJSON *materials = cJSON_AddArrayToObject(g->root, "materials");
  cJSON *turned = json_add_row(nodes);
  json_numbers(turned, "rotation", up, 4);
  cJSON *children = cJSON_AddArrayToObject(turned, "children");
  for (int64_t n = 0; n < g->count; n++) {
    g->bodies[n].node = cJSON_GetArraySize(nodes);
    cJSON_AddItemToArray(children, json_number_item((double)g->bodies[n].node));
    cJSON_AddItemToArray(nodes, node_of(&g->bodies[n], n));
    cJSON_AddItemToArray(materials, material_of(&g->bodies[n]));
    add_mesh(&g->bodies[n], n, meshes);
  }
}

/* The course of one property of the body's node. */
static void add_channel(const body *b, cJSON *animation, const char *path, int64_t output) {
  cJSON *samplers = cJSON_GetObjectItemCaseSensitive(animation, "samplers");
  cJSON *channels = cJSON_GetObjectItemCaseSensitive(animation, "channels");
  cJSON *channel = json_add_row(channels);
  json_number(channel, "sampler", cJSON_GetArraySize(samplers));
  cJSON *sampler = json_add_row(samplers);
  json_number(sampler, "input", (double)(b->first + b->run->rank + 2));
  json_number(sampler, "output", (double)output);
  cJSON_AddStringToObject(sampler, "interpolation", "LINEAR");
  cJSON *target = cJSON_AddObjectToObject(channel, "target");
  json_number(target, "node", (double)b->node);
  cJSON_AddStringToObject(target, "path", path);
}

/* One animation moves all bodies together. */
static void add_animation(glb *g) {
  cJSON *animation = json_add_row(cJSON_AddArrayToObject(g->root, "animations"));

  // other programs show the name of an animation; several bodies may be stepped each by its own
  const char *stepped_by = g->bodies[0].run->stepped_by;
  if (g->count == 1 && stepped_by[0] != 0)
    cJSON_AddStringToObject(animation, "name", stepped_by);
  cJSON_AddArrayToObject(animation, "samplers");
  cJSON_AddArrayToObject(animation, "channels");
  for (int64_t n = 0; n < g->count; n++) {
    const body *b = &g->bodies[n];
    const int64_t rank = b->run->rank;
    add_channel(b, animation, "weights", b->first + rank + 3);
    if (b->run->places != NULL) {
      add_channel(b, animation, "translation", b->first + 2 * rank + 5);
      add_channel(b, animation, "rotation", b->first + 2 * rank + 6);
    }
  }
}

/* The JSON of the file (malloc), padded to four bytes; NULL: out of memory. */
static char *make_json(glb *g, size_t *length) {
  g->root = cJSON_CreateObject();
  g->views = cJSON_CreateArray();
  g->accessors = cJSON_CreateArray();

  // views are planned first: the rest refers to them by number
  for (int64_t n = 0; n < g->count; n++)
    plan_body(g, &g->bodies[n]);
  add_scene(g);
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

/* Vectors of the surface at rest and of the morph targets. */
static void put_vectors(const body *b, vector_kind kind, const thrum_file_writer *writer) {
  for (int64_t column = -1; column < b->run->rank; column++)
    for (int64_t v = 0; v < b->smooth.vertex_count; v++) {
      const float vector[3] = {value_at(b, kind, v, 0, column), value_at(b, kind, v, 1, column),
                               value_at(b, kind, v, 2, column)};
      put(writer, vector, sizeof vector);
    }
}

/* The place of a free body: positions, then rotations with w last. */
static void put_places(const recorded_run *run, const thrum_file_writer *writer) {
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

/* The views of a body, in the order of plan_body. */
static void put_body(const body *b, const thrum_file_writer *writer) {
  const recorded_run *run = b->run;
  put_vectors(b, POSITIONS, writer);
  put(writer, b->smooth.triangles, (size_t)b->shown->triangle_count * 3 * sizeof(int32_t));

  // times and weights, row by row
  for (int64_t n = 0; n < run->rows; n++) {
    const float time = (float)run->times[n];
    put(writer, &time, sizeof time);
  }
  for (int64_t n = 0; n < run->rows * run->rank; n++) {
    const float weight = (float)(run->q[n] / b->scale[n % run->rank]);
    put(writer, &weight, sizeof weight);
  }
  put_vectors(b, NORMALS, writer);
  put_places(run, writer);
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
  for (int64_t n = 0; n < g->count; n++)
    put_body(&g->bodies[n], &writer);
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

/* Normals and scales of a body. */
static thrum_status prepare(const char *path, const glb_body *given, body *b, thrum_error *error) {
  *b = (body){.run = given->run, .shown = given->shown, .name = given->name};
  const recorded_run *run = b->run;
  THRUM_TRY(check_times(path, run, error));
  THRUM_TRY(smooth_normals_make(b->shown, &b->smooth, error));
  THRUM_TRY(thrum_reserve(&b->scale, run->rank, sizeof *b->scale, path, error));

  // weights are q over its largest magnitude, so that they lie between -1 and 1
  for (int64_t n = 0; n < run->rows * run->rank; n++)
    b->scale[n % run->rank] = fmax(b->scale[n % run->rank], fabs(run->q[n]));
  for (int64_t n = 0; n < run->rank; n++)
    b->scale[n] = b->scale[n] > 0 ? b->scale[n] : 1;
  return THRUM_OK;
}

thrum_status glb_write(const char *path, const glb_body *bodies, int64_t count,
                       thrum_error *error) {
  glb g = {.count = count};
  THRUM_TRY(thrum_reserve(&g.bodies, count, sizeof *g.bodies, path, error));
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < count && status >= 0; n++)
    status = prepare(path, &bodies[n], &g.bodies[n], error);

  size_t length = 0;
  char *json = status >= 0 ? make_json(&g, &length) : NULL;
  if (status >= 0)
    status = json != NULL
                 ? write_file(path, &g, json, length, error)
                 : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %.200s", path);
  free(json);
  for (int64_t n = 0; n < count; n++) {
    smooth_normals_free(&g.bodies[n].smooth);
    free(g.bodies[n].scale);
  }
  free(g.bodies);
  return status;
}
