/* The surfaces with which bodies touch each other, one for all bodies of a model.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_skin.h"

#include "scene/scene_memory.h"

#include <stdlib.h>
#include <string.h>

thrum_status scene_triangles_keep(const thrum_scene_body_def *def, scene_body *body,
                                  thrum_error *error) {
  const bool kept = def->triangle_count > 0 && def->model->material != NULL;
  body->collides = kept && def->collide != 0;
  body->self_contact = def->self_contact != 0;
  if (body->self_contact && (!kept || def->model->basis == NULL))
    return thrum_error_set(
        error, THRUM_MISSING,
        "a body that touches itself needs triangles, and a model with a mesh and "
        "a material");
  if (body->self_contact && body->derived->condensed)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a body that touches itself steps all of its coordinates: it cannot be "
                           "condensed");
  if (!kept)
    return THRUM_OK;
  const size_t count = 3 * (size_t)def->triangle_count;
  body->triangles = malloc(count * sizeof *body->triangles);
  if (body->triangles == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the triangles of a body");
  memcpy(body->triangles, def->triangles, count * sizeof *body->triangles);
  body->triangle_count = def->triangle_count;
  return THRUM_OK;
}

bool scene_collides(const thrum_scene *scene, const scene_body *body, const scene_model *derived) {
  const bool bodies = (scene->collides && body->collides) || body->self_contact;
  return (bodies || scene->solid_count > 0) && body->triangle_count > 0 && !derived->condensed;
}

/* The vertices of the triangles, ascending, as a model of their own; places (vertex_count) gets
 * where each lies, -1 where it does not. */
static void fill_surface(const scene_body *body, const scene_model *derived, int32_t *places,
                         thrum_model *surface, double *rest, double *rows) {
  const thrum_model *from = body->model;
  int64_t count = 0;
  for (int64_t v = 0; v < from->vertex_count; v++) {
    if (places[v] < 0)
      continue;
    places[v] = (int32_t)count;
    for (int axis = 0; axis < 3; axis++) {
      const double *row = from->basis + (3 * v + axis) * from->rank;
      rest[3 * count + axis] = derived->by.length * from->vertices[3 * v + axis];
      for (int64_t i = 0; i < derived->rank; i++)
        rows[(3 * count + axis) * derived->rank + i] = body->k * row[i];
    }
    count++;
  }
  *surface = *derived->model;
  surface->vertex_count = count;
  surface->vertices = rest;
  surface->basis = rows;
}

/* The stiffest material of the scaled body. */
static void stiffest(const scene_body *body, const scene_model *derived, double material[3]) {
  const thrum_model *from = body->model;
  for (int64_t n = 0; n < from->region_count; n++)
    if (derived->by.stiffness * from->material[3 * n] > material[0])
      material[0] = derived->by.stiffness * from->material[3 * n];
}

/* Lays the skin of these triangles. */
static thrum_status lay(const scene_body *body, const scene_model *derived, scene_skin *skin,
                        int32_t *places, int32_t *triangles, double *rest, double *rows,
                        thrum_error *error) {
  thrum_model surface;
  double material[3] = {0};
  size_t size = 0;
  for (int64_t n = 0; n < 3 * body->triangle_count; n++)
    places[body->triangles[n]] = 0;
  fill_surface(body, derived, places, &surface, rest, rows);
  for (int64_t n = 0; n < 3 * body->triangle_count; n++)
    triangles[n] = places[body->triangles[n]];
  stiffest(body, derived, material);
  surface.material = material;
  surface.region_count = 1;

  THRUM_TRY(thrum_skin_size(&surface, triangles, body->triangle_count, &size, error));
  skin->memory = scene_aligned(size);
  if (skin->memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a skin of %zu bytes", size);
  return thrum_skin_init(skin->memory, size, &surface, triangles, body->triangle_count, &skin->skin,
                         error);
}

static thrum_status make_skin(const scene_body *body, const scene_model *derived, scene_skin *skin,
                              thrum_error *error) {
  const size_t count = (size_t)body->model->vertex_count, r = (size_t)derived->rank;
  const size_t corners = 3 * (size_t)body->triangle_count;
  const size_t used = corners < count ? corners : count;
  int32_t *places = malloc(count * sizeof *places);
  int32_t *triangles = malloc(corners * sizeof *triangles);
  double *rest = malloc(3 * used * sizeof *rest), *rows = malloc(3 * used * r * sizeof *rows);
  skin->triangles = malloc(corners * sizeof *skin->triangles);
  thrum_status status =
      places && triangles && rest && rows && skin->triangles
          ? THRUM_OK
          : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the skin of a body");
  if (status >= 0) {
    memset(places, 0xff, count * sizeof *places);
    memcpy(skin->triangles, body->triangles, corners * sizeof *skin->triangles);
    status = lay(body, derived, skin, places, triangles, rest, rows, error);
  }
  free(places);
  free(triangles);
  free(rest);
  free(rows);
  return status;
}

void scene_skin_drop(thrum_scene *scene, scene_skin *skin) {
  if (skin == NULL || --skin->users > 0)
    return;
  for (scene_skin **at = &scene->skins; *at != NULL; at = &(*at)->next)
    if (*at == skin) {
      *at = skin->next;
      break;
    }
  free(skin->memory);
  free(skin->triangles);
  free(skin);
}

/* Hands a skin to a body, ready for what the body does with it. */
static thrum_status take(const scene_body *body, scene_skin *skin, scene_skin **taken) {
  if (body->self_contact)
    thrum_skin_prepare_own(skin->skin);
  *taken = skin;
  return THRUM_OK;
}

thrum_status scene_skin_take(thrum_scene *scene, const scene_body *body, const scene_model *derived,
                             scene_skin **taken, thrum_error *error) {
  const size_t bytes = 3 * (size_t)body->triangle_count * sizeof *body->triangles;
  *taken = NULL;
  if (!scene_collides(scene, body, derived))
    return THRUM_OK;

  // bodies of one model and surface share it
  for (scene_skin *skin = scene->skins; skin != NULL; skin = skin->next)
    if (skin->of == derived && skin->triangle_count == body->triangle_count &&
        memcmp(skin->triangles, body->triangles, bytes) == 0) {
      skin->users++;
      return take(body, skin, taken);
    }

  scene_skin *skin = calloc(1, sizeof *skin);
  if (skin == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the skin of a body");
  skin->of = derived;
  skin->triangle_count = body->triangle_count;
  skin->users = 1;
  const thrum_status status = make_skin(body, derived, skin, error);
  if (status < 0) {
    scene_skin_drop(scene, skin);
    return status;
  }
  skin->next = scene->skins;
  scene->skins = skin;
  return take(body, skin, taken);
}
