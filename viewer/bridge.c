/* What JavaScript calls: the scene engine behind numbers and one shared buffer of doubles.
 *
 * A page has one scene. Functions that may fail return a thrum_status, and bridge_message says why;
 * results of several numbers are left in bridge_numbers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "bridge.h"

#include <stdlib.h>
#include <string.h>

#define MODELS_MAX 64
#define BODIES_MAX 256

thrum_scene *bridge_scene;
double bridge_number[NUMBERS];

static bridge_model models[MODELS_MAX];
static int32_t model_count;
static int32_t model_of_body[BODIES_MAX];
static thrum_error error;

const char *EXPORT(bridge_message)(void) {
  return error.message;
}

double *EXPORT(bridge_numbers)(void) {
  return bridge_number;
}

/* Aligned to 64; NULL when there is no memory left. Models live as long as the page. */
void *EXPORT(bridge_alloc)(size_t bytes) {
  return aligned_alloc(64, (bytes + 63) / 64 * 64 + 64);
}

void EXPORT(bridge_free)(void *memory) {
  free(memory);
}

const bridge_model *bridge_body_model(int32_t body) {
  if (body < 0 || body >= thrum_scene_body_count(bridge_scene))
    return NULL;
  return &models[model_of_body[body]];
}

static thrum_status no_memory(void) {
  return thrum_error_set(&error, THRUM_OUT_OF_MEMORY, "the page has no memory left");
}

// widens an array; NULL when there is no memory
static double *widen(const float *from, int64_t count) {
  double *to = bridge_alloc((size_t)count * sizeof *to);
  for (int64_t i = 0; to != NULL && i < count; i++)
    to[i] = from[i];
  return to;
}

// the coefficients once more, in the order of the steps
static thrum_status pack(thrum_model *model) {
  size_t size = thrum_model_pack_size(model);
  void *memory = bridge_alloc(size);
  if (memory == NULL)
    return no_memory();
  return thrum_model_pack(model, memory, size, &error);
}

static thrum_status make_surface(bridge_model *made, int64_t triangle_count) {
  thrum_surface_def def = {.triangles = made->triangles, .triangle_count = triangle_count};
  size_t size;
  thrum_status status = thrum_surface_size(&made->model, &def, &size, &error);
  if (status != THRUM_OK)
    return status;
  void *memory = bridge_alloc(size);
  made->positions = bridge_alloc((size_t)made->model.vertex_count * 3 * sizeof(float));
  if (memory == NULL || made->positions == NULL)
    return no_memory();
  return thrum_surface_init(memory, size, &made->model, &def, &made->surface, &error);
}

/* Adds a model of arrays from bridge_alloc, which it keeps, `positions` and `basis` apart; their
 * shapes are those of the pack (docs/viewer.md). Returns its number, or a status below 0. */
int32_t EXPORT(bridge_add_model)(int32_t rank, int32_t vertex_count, int32_t triangle_count,
                                 const double *omega2, const double *c3, const double *c4,
                                 const double *axis_mass, const float *positions,
                                 const float *basis, const int32_t *triangles,
                                 const uint8_t *fixed) {
  if (model_count == MODELS_MAX)
    return thrum_error_set(&error, THRUM_UNSUPPORTED, "a page has at most %d models", MODELS_MAX);
  bridge_model *made = &models[model_count];
  memset(made, 0, sizeof *made);
  thrum_model *model = &made->model;
  model->rank = rank;
  model->c3_count = thrum_c3_count(rank);
  model->c4_count = thrum_c4_count(rank);
  model->vertex_count = vertex_count;
  model->omega2 = omega2;
  model->c3 = c3;
  model->c4 = c4;
  model->axis_mass = axis_mass;
  model->fixed = fixed;
  model->vertices = widen(positions, 3 * (int64_t)vertex_count);
  model->basis = widen(basis, 3 * (int64_t)vertex_count * rank);
  made->triangles = triangles;
  if (model->vertices == NULL || model->basis == NULL)
    return no_memory();
  thrum_status status = pack(model);
  if (status == THRUM_OK)
    status = make_surface(made, triangle_count);
  return status == THRUM_OK ? model_count++ : (int32_t)status;
}

/* An empty scene in place of the one before. */
int32_t EXPORT(bridge_begin)(double dt) {
  thrum_scene *made;
  thrum_status status = thrum_scene_make(dt, &made, &error);
  if (status != THRUM_OK)
    return status;
  thrum_scene_free(bridge_scene);
  bridge_scene = made;
  return THRUM_OK;
}

/* numbers: position 3, rotation 4 (w, x, y, z), scale, stiffness, density, alpha, beta. rank 0: all.
 * Returns the body's number, or a status below 0. */
int32_t EXPORT(bridge_add_body)(int32_t model, int32_t integrator, int32_t rank) {
  if (model < 0 || model >= model_count || thrum_scene_body_count(bridge_scene) == BODIES_MAX)
    return thrum_error_set(&error, THRUM_INVALID_ARGUMENT, "a page has at most %d bodies",
                           BODIES_MAX);
  const double *n = bridge_number;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &models[model].model;
  memcpy(def.position, n, sizeof def.position);
  memcpy(def.rotation, n + 3, sizeof def.rotation);
  def.scale = n[7];
  def.stiffness = n[8];
  def.density = n[9];
  def.state.damping_alpha = n[10];
  def.state.damping_beta = n[11];
  def.state.integrator = (thrum_integrator)integrator;
  def.rank = rank;
  int32_t body;
  thrum_status status = thrum_scene_add_body(bridge_scene, &def, &body, &error);
  if (status != THRUM_OK)
    return status;
  model_of_body[body] = model;
  return body;
}

int32_t EXPORT(bridge_set_gravity)(double x, double y, double z) {
  const double gravity[3] = {x, y, z};
  return thrum_scene_set_gravity(bridge_scene, gravity, &error);
}

int32_t EXPORT(bridge_set_dt)(double dt) {
  return thrum_scene_set_dt(bridge_scene, dt, &error);
}

int32_t EXPORT(bridge_set_damping)(int32_t body, double alpha, double beta) {
  return thrum_scene_set_damping(bridge_scene, body, alpha, beta, &error);
}

int32_t EXPORT(bridge_set_stiffness)(int32_t body, double stiffness) {
  return thrum_scene_set_stiffness(bridge_scene, body, stiffness, &error);
}

int32_t EXPORT(bridge_set_integrator)(int32_t body, int32_t integrator) {
  return thrum_scene_set_integrator(bridge_scene, body, (thrum_integrator)integrator, &error);
}

int32_t EXPORT(bridge_set_rank)(int32_t body, int32_t rank) {
  return thrum_scene_set_rank(bridge_scene, body, rank, &error);
}

int32_t EXPORT(bridge_reset)(void) {
  return thrum_scene_reset(bridge_scene, &error);
}

int32_t EXPORT(bridge_step)(void) {
  return thrum_scene_step(bridge_scene, &error);
}

double EXPORT(bridge_time)(void) {
  return thrum_scene_time(bridge_scene);
}

/* numbers: q, of the body's rank. */
int32_t EXPORT(bridge_coordinates)(int32_t body) {
  return thrum_scene_body_get(bridge_scene, body, bridge_number, NULL, &error);
}

/* q of the model's full rank, as floats for the GPU. */
int32_t EXPORT(bridge_shape)(int32_t body, float *out) {
  double q[THRUM_RANK_MAX];
  thrum_status status = thrum_scene_body_shape(bridge_scene, body, q, &error);
  if (status != THRUM_OK)
    return status;
  for (int64_t i = 0; i < bridge_body_model(body)->model.rank; i++)
    out[i] = (float)q[i];
  return THRUM_OK;
}

/* numbers: column-major 4 x 4 from the model's coordinates to the world. */
void EXPORT(bridge_matrix)(int32_t body) {
  thrum_scene_body_matrix(bridge_scene, body, bridge_number);
}

/* numbers: kinetic, potential, gravity, total. */
int32_t EXPORT(bridge_energies)(int32_t body) {
  thrum_scene_energies energies;
  thrum_status status = thrum_scene_body_energies(bridge_scene, body, &energies, &error);
  if (status != THRUM_OK)
    return status;
  bridge_number[0] = energies.kinetic;
  bridge_number[1] = energies.potential;
  bridge_number[2] = energies.gravity;
  bridge_number[3] = energies.total;
  return THRUM_OK;
}

/* numbers: status, rank, explicit and implicit modes, iterations of the last step, scheme,
 * steps that needed a fallback, integrator; then omega^2 as stepped. */
int32_t EXPORT(bridge_body)(int32_t body) {
  thrum_scene_body_info info;
  thrum_status status = thrum_scene_body(bridge_scene, body, &info, &error);
  if (status != THRUM_OK)
    return status;
  double *n = bridge_number;
  n[0] = info.status;
  n[1] = (double)info.rank;
  n[2] = info.report.explicit_modes;
  n[3] = info.report.implicit_modes;
  n[4] = info.report.iterations_last;
  n[5] = info.report.scheme;
  n[6] = (double)info.fallback_steps;
  n[7] = info.integrator;
  return THRUM_OK;
}

/* Squared frequencies of the modes as they are stepped, rank of them. */
const double *EXPORT(bridge_omega2)(int32_t body) {
  thrum_scene_body_info info;
  if (thrum_scene_body(bridge_scene, body, &info, &error) != THRUM_OK)
    return NULL;
  return info.stepped->omega2;
}

/* numbers: position and velocity of a vertex in the world. */
int32_t EXPORT(bridge_vertex)(int32_t body, int32_t vertex) {
  return thrum_scene_body_vertex(bridge_scene, body, vertex, bridge_number, bridge_number + 3,
                                 &error);
}
