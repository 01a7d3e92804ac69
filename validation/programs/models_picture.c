/* The six models under load, as a picture: thrum_pictures OUT.ppm FOLDER, where FOLDER holds
 * NAME.npz of each. Each is pushed at its group `load` and damped until it rests; colour is
 * displacement over the largest. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_faces.h"
#include "thrum/displacement.h"
#include "validation/experiments/experiment_body.h"
#include "validation/pictures/render.h"

#define COLUMNS 3
#define CELL_WIDTH 420
#define CELL_HEIGHT 380
#define STEPS 600

/* How each is pushed, by so much of its length, and seen. */
typedef struct scene {
  const char *name;
  double direction[3];
  double amplitude;
  double azimuth, elevation;
} scene;

static const scene scenes[] = {
    {"horse", {0, 1, 0}, 0.15, 60, 14},    {"tower", {1, 0, 0}, 0.18, -62, 10},
    {"bridge", {0, 0, -1}, 0.07, -64, 20}, {"basket", {1, 0, 0}, 0.22, -66, 22},
    {"heart", {1, 0, 0}, 0.22, -74, 10},   {"beam", {0, 0, -1}, 0.35, -58, 18},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

/* The rest under a constant force, which is raised until the amplitude is reached. */
static thrum_status bend(const experiment_body *body, double amplitude, double *q,
                         thrum_error *error) {
  const thrum_model *model = body->model;
  thrum_state_def def = thrum_default_state_def();
  thrum_state *state = NULL;
  double push[THRUM_RANK_MAX];
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = 0.2 / sqrt(model->omega2[0]);
  def.damping_alpha = 2 * sqrt(model->omega2[0]);
  thrum_status status = thrum_state_create(model, &def, &state, error);
  double force = amplitude * body->length / body->compliance;
  for (int tries = 0; tries < 6 && status >= 0; tries++) {
    for (int64_t i = 0; i < model->rank; i++)
      push[i] = force * body->push[i];
    status = thrum_state_set_force(model, state, push, error);
    for (int n = 0; n < STEPS && status >= 0; n++)
      status = thrum_step(model, state, error);
    if (status >= 0)
      status = thrum_state_get(model, state, q, NULL, error);
    force *= amplitude / experiment_body_amplitude(body, q);
  }
  thrum_state_destroy(state);
  return status;
}

/* The surface's triangles, going round outwards; malloc'ed. */
static thrum_status find_surface(const thrum_model *model, int32_t **faces, int64_t *count,
                                 thrum_error *error) {
  thrum_mesh mesh = {.vertex_count = model->vertex_count, .tet_count = model->tet_count};
  thrum_mesh_faces found = {0};
  int64_t tets[3];
  // only read
  mesh.vertices = (double *)(uintptr_t)model->vertices;
  mesh.tets = (int32_t *)(uintptr_t)model->tets;
  const thrum_status status = thrum_mesh_find_faces(&mesh, &found, tets, error);
  if (status < 0)
    return status;
  int32_t *list = malloc((size_t)(3 * found.count + 1) * sizeof *list);
  *count = 0;
  for (int64_t n = 0; list != NULL && n < found.count; n++) {
    const thrum_mesh_face *face = &found.faces[n];
    if (face->other >= 0)
      continue;
    int32_t *out = list + 3 * (*count)++;
    out[0] = face->vertices[0];
    out[1] = face->vertices[face->even ? 1 : 2];
    out[2] = face->vertices[face->even ? 2 : 1];
  }
  free(found.faces);
  *faces = list;
  return list != NULL ? THRUM_OK : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
}

/* Moves and colours the vertices and draws them. */
static thrum_status show(const scene *s, const thrum_model *model, const double *q,
                         const experiment_view *view, experiment_image *image, thrum_error *error) {
  const size_t count = (size_t)model->vertex_count;
  double *moved = malloc(3 * count * sizeof *moved), *value = calloc(count, sizeof *value);
  experiment_solid solid = {model->vertex_count, model->vertices, moved, value, 0, NULL};
  int32_t *faces = NULL;
  double largest = 0;
  thrum_status status =
      moved == NULL || value == NULL
          ? thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the %s", s->name)
          : thrum_displacement(model, q, 0, model->vertex_count, moved, error);
  for (size_t v = 0; status >= 0 && v < count; v++) {
    for (int axis = 0; axis < 3; axis++) {
      value[v] += moved[3 * v + axis] * moved[3 * v + axis];
      moved[3 * v + axis] += model->vertices[3 * v + axis];
    }
    value[v] = sqrt(value[v]);
    largest = fmax(largest, value[v]);
  }
  for (size_t v = 0; status >= 0 && v < count; v++)
    value[v] /= largest;
  if (status >= 0)
    status = find_surface(model, &faces, &solid.face_count, error);
  solid.faces = faces;
  if (status >= 0)
    status = experiment_render(&solid, view, image, error);
  free(faces);
  free(moved);
  free(value);
  return status;
}

static thrum_status draw_scene(int index, const char *folder, experiment_image *image,
                               thrum_error *error) {
  const scene *s = &scenes[index];
  const experiment_view view = {
      s->azimuth, s->elevation, index % COLUMNS * CELL_WIDTH, index / COLUMNS * CELL_HEIGHT,
      CELL_WIDTH, CELL_HEIGHT};
  const thrum_model *model = NULL;
  experiment_body body;
  char path[1024];
  double q[THRUM_RANK_MAX];
  snprintf(path, sizeof path, "%s/%s.npz", folder, s->name);
  thrum_status status = thrum_model_load(path, &model, error);
  if (status < 0)
    return status;
  status = experiment_body_init(s->name, model, "load", s->direction, &body, error);
  if (status >= 0) {
    status = bend(&body, s->amplitude, q, error);
    experiment_body_free(&body);
  }
  if (status >= 0)
    status = show(s, model, q, &view, image, error);
  thrum_model_free(model);
  return status;
}

static bool write_image(const char *path, const experiment_image *image) {
  const size_t bytes = (size_t)image->width * (size_t)image->height * 3;
  FILE *file = fopen(path, "wb");
  if (file == NULL)
    return false;
  const bool written = fprintf(file, "P6\n%d %d\n255\n", image->width, image->height) > 0 &&
                       fwrite(image->pixels, 1, bytes, file) == bytes;
  return fclose(file) == 0 && written;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  experiment_image image = {0};
  if (argc != 3) {
    fputs("usage: thrum_pictures OUT.ppm FOLDER\n", stderr);
    return 2;
  }
  thrum_status status =
      experiment_image_make(COLUMNS * CELL_WIDTH, SCENES / COLUMNS * CELL_HEIGHT, &image, &error);
  for (int n = 0; n < SCENES && status >= 0; n++)
    status = draw_scene(n, argv[2], &image, &error);
  if (status >= 0 && !write_image(argv[1], &image))
    status = thrum_error_set(&error, THRUM_IO, "%.300s cannot be written", argv[1]);
  experiment_image_free(&image);
  if (status < 0)
    fprintf(stderr, "thrum_pictures: %s\n", error.message);
  return status < 0 ? 1 : 0;
}
