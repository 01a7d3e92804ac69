/* The functions that JavaScript calls: the scene engine behind numbers and one shared buffer of
 * doubles.
 *
 * A page has one scene. Functions that may fail return a thrum_status, and bridge_message says why;
 * results of several numbers are left in bridge_numbers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#include <stdlib.h>
#include <string.h>

#define BODIES_MAX 256

thrum_scene *bridge_scene;
double bridge_number[NUMBERS];

thrum_error bridge_error;

static int32_t model_of_body[BODIES_MAX];

const char *EXPORT(bridge_message)(void) {
  return bridge_error.message;
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
  return bridge_model_at(model_of_body[body]);
}

/* An empty scene in place of the one before. */
int32_t EXPORT(bridge_begin)(double dt) {
  thrum_scene *made;
  THRUM_TRY(thrum_scene_make(dt, &made, &bridge_error));
  thrum_scene_free(bridge_scene);
  bridge_scene = made;
  bridge_forget_motions();
  return THRUM_OK;
}

/* numbers: position 3, rotation 4 (w, x, y, z), scale, stiffness, density, alpha, beta, velocity 3,
 * spin 3, coordinates that are stepped while the others follow (0: none does), whether it touches
 * other bodies, whether it touches itself, whether rotation and shape are coupled. rank 0: all. q,
 * p: its start, of the model's rank, or NULL. Returns the body's number, or a status below 0. */
int32_t EXPORT(bridge_add_body)(int32_t model, int32_t integrator, int32_t rank, int32_t free_body,
                                const double *q, const double *p) {
  const bridge_model *of = bridge_model_at(model);
  if (of == NULL || thrum_scene_body_count(bridge_scene) == BODIES_MAX)
    return thrum_error_set(&bridge_error, THRUM_INVALID_ARGUMENT,
                           "a body has no model, or there are more than %d bodies", BODIES_MAX);

  // the page hands numbers over in one array, as a call from JavaScript takes few arguments
  const double *n = bridge_number;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &of->model;
  memcpy(def.position, n, sizeof def.position);
  memcpy(def.rotation, n + 3, sizeof def.rotation);
  def.scale = n[7];
  def.stiffness = n[8];
  def.density = n[9];
  def.state.damping_alpha = n[10];
  def.state.damping_beta = n[11];
  def.state.integrator = (thrum_integrator)integrator;
  memcpy(def.velocity, n + 12, sizeof def.velocity);
  memcpy(def.spin, n + 15, sizeof def.spin);

  // the rest comes as arguments, or from the model
  def.condense = (int64_t)n[18];
  def.rank = def.condense > 0 || thrum_model_masters(&of->model) > 0 ? 0 : rank;
  def.q = q;
  def.p = p;
  def.free = free_body;
  def.triangles = of->triangles;
  def.triangle_count = of->triangle_count;
  def.collide = n[19] != 0.0;
  def.self_contact = n[20] != 0.0;
  def.coupled = n[21] != 0.0;
  def.touch = of->touch;
  def.touch_count = of->touch_count;

  // the scene makes a copy, so the page keeps which model it was
  int32_t body;
  THRUM_TRY(thrum_scene_add_body(bridge_scene, &def, &body, &bridge_error));
  model_of_body[body] = model;
  return body;
}

/* Bodies touch each other from now on. numbers: thickness [m] (0: of the bodies' size), friction,
 * restitution; touches: room for all of them together. */
int32_t EXPORT(bridge_set_collisions)(int32_t touches) {
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.thickness = bridge_number[0];
  def.friction = bridge_number[1];
  def.restitution = bridge_number[2];
  def.touch_max = touches;
  return thrum_scene_set_collisions(bridge_scene, &def, &bridge_error);
}

/* numbers: centre 3, normal 3, radius, half sides 3, rotation 4 (w, x, y, z), velocity 3,
 * friction, restitution, stiffness, damping. Returns its number, or a status below 0. */
int32_t EXPORT(bridge_add_obstacle)(int32_t shape, int32_t inside) {
  const double *n = bridge_number;
  thrum_obstacle obstacle = thrum_default_obstacle();
  obstacle.shape = (thrum_obstacle_shape)shape;
  obstacle.inside = inside;

  // members that the shape does not have are ignored
  memcpy(obstacle.centre, n, sizeof obstacle.centre);
  memcpy(obstacle.normal, n + 3, sizeof obstacle.normal);
  obstacle.radius = n[6];
  memcpy(obstacle.half, n + 7, sizeof obstacle.half);
  memcpy(obstacle.velocity, n + 14, sizeof obstacle.velocity);
  obstacle.friction = n[17];
  obstacle.restitution = n[18];
  obstacle.stiffness = n[19];
  obstacle.damping = n[20];
  int32_t number;
  thrum_status status = thrum_scene_axes(n + 10, obstacle.rotation, &bridge_error);
  if (status == THRUM_OK)
    status = thrum_scene_add_obstacle(bridge_scene, &obstacle, &number, &bridge_error);
  return status == THRUM_OK ? number : (int32_t)status;
}

/* numbers: where an obstacle's centre is now. */
int32_t EXPORT(bridge_obstacle)(int32_t number) {
  thrum_obstacle obstacle;
  THRUM_TRY(thrum_scene_obstacle(bridge_scene, number, &obstacle, &bridge_error));
  memcpy(bridge_number, obstacle.centre, sizeof obstacle.centre);
  return THRUM_OK;
}

/* numbers: centre 3, rotation 4 (w, x, y, z), velocity 3, friction, restitution. The arrays are
 * vertices (x 3), triangles (x 3), times and places (x 7) of the path. Returns the solid's number,
 * or a status below 0. */
int32_t EXPORT(bridge_add_solid)(int32_t vertex_count, const double *vertices,
                                 int32_t triangle_count, const int32_t *triangles,
                                 int32_t path_count, const double *times, const double *places) {
  const double *n = bridge_number;
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.shape = THRUM_SOLID_MESH;
  def.vertices = vertices;
  def.vertex_count = vertex_count;
  def.triangles = triangles;
  def.triangle_count = triangle_count;
  def.path_times = times;
  def.path_places = places;
  def.path_count = path_count;
  memcpy(def.position, n, sizeof def.position);
  memcpy(def.rotation, n + 3, sizeof def.rotation);
  memcpy(def.velocity, n + 7, sizeof def.velocity);
  def.friction = n[10];
  def.restitution = n[11];
  int32_t number;
  const thrum_status status = thrum_scene_add_solid(bridge_scene, &def, &number, &bridge_error);
  return status == THRUM_OK ? number : (int32_t)status;
}

/* numbers: where a solid is now, as the 4 x 4 matrix of its place, column by column. */
int32_t EXPORT(bridge_solid)(int32_t number) {
  thrum_scene_solid solid;
  THRUM_TRY(thrum_scene_solid_get(bridge_scene, number, &solid, &bridge_error));
  for (int column = 0; column < 4; column++)
    for (int row = 0; row < 4; row++)
      bridge_number[4 * column + row] = row == 3      ? column == 3
                                        : column == 3 ? solid.now.origin[row]
                                                      : solid.now.axes[3 * row + column];
  return THRUM_OK;
}

int32_t EXPORT(bridge_set_gravity)(double x, double y, double z) {
  const double gravity[3] = {x, y, z};
  return thrum_scene_set_gravity(bridge_scene, gravity, &bridge_error);
}

int32_t EXPORT(bridge_set_dt)(double dt) {
  return thrum_scene_set_dt(bridge_scene, dt, &bridge_error);
}

int32_t EXPORT(bridge_set_damping)(int32_t body, double alpha, double beta) {
  return thrum_scene_set_damping(bridge_scene, body, alpha, beta, &bridge_error);
}

int32_t EXPORT(bridge_set_stiffness)(int32_t body, double stiffness) {
  return thrum_scene_set_stiffness(bridge_scene, body, stiffness, &bridge_error);
}

int32_t EXPORT(bridge_set_integrator)(int32_t body, int32_t integrator) {
  return thrum_scene_set_integrator(bridge_scene, body, (thrum_integrator)integrator,
                                    &bridge_error);
}

int32_t EXPORT(bridge_set_rank)(int32_t body, int32_t rank) {
  return thrum_scene_set_rank(bridge_scene, body, rank, &bridge_error);
}

int32_t EXPORT(bridge_reset)(void) {
  return thrum_scene_reset(bridge_scene, &bridge_error);
}

int32_t EXPORT(bridge_step)(void) {
  return thrum_scene_step(bridge_scene, &bridge_error);
}

double EXPORT(bridge_time)(void) {
  return thrum_scene_time(bridge_scene);
}

/* numbers: q, of the coordinates that show the body. */
int32_t EXPORT(bridge_coordinates)(int32_t body) {
  return thrum_scene_body_get(bridge_scene, body, bridge_number, NULL, &bridge_error);
}

/* q of the model's full rank, as floats for the GPU. */
int32_t EXPORT(bridge_shape)(int32_t body, float *out) {
  double q[THRUM_RANK_MAX];
  THRUM_TRY(thrum_scene_body_shape(bridge_scene, body, q, &bridge_error));
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
  THRUM_TRY(thrum_scene_body_energies(bridge_scene, body, &energies, &bridge_error));
  bridge_number[0] = energies.kinetic;
  bridge_number[1] = energies.potential;
  bridge_number[2] = energies.gravity;
  bridge_number[3] = energies.total;
  return THRUM_OK;
}

/* numbers: kinetic, potential, gravity, contact, springs between places, total; of all bodies
 * together, with what bodies that touch each other hold between them. */
int32_t EXPORT(bridge_account)(void) {
  thrum_scene_account account;
  THRUM_TRY(thrum_scene_account_get(bridge_scene, &account, &bridge_error));
  bridge_number[0] = account.kinetic;
  bridge_number[1] = account.potential;
  bridge_number[2] = account.gravity;
  bridge_number[3] = account.contact;
  bridge_number[4] = account.links;
  bridge_number[5] = account.total;
  bridge_number[6] = thrum_scene_collisions(bridge_scene).lost;
  return THRUM_OK;
}

/* numbers: status, rank, explicit and implicit modes, iterations of the last step, scheme,
 * steps that needed a fallback, integrator, steps before the first switch to energy (-1: none),
 * steps with energy that nothing explains. */
int32_t EXPORT(bridge_body)(int32_t body) {
  thrum_scene_body_info info;
  thrum_status status = thrum_scene_body(bridge_scene, body, &info, &bridge_error);
  if (status != THRUM_OK)
    return status;

  // in the order that the page reads
  double *n = bridge_number;
  n[0] = info.status;
  n[1] = (double)info.rank;
  n[2] = info.report.explicit_modes;
  n[3] = info.report.implicit_modes;
  n[4] = info.report.iterations_last;
  n[5] = info.report.scheme;
  n[6] = (double)info.fallback_steps;
  n[7] = info.integrator;
  n[8] = (double)info.report.first_switch;
  n[9] = (double)info.report.grown_steps;
  return THRUM_OK;
}

/* omega^2 of the modes of a body, rank of them. */
const double *EXPORT(bridge_omega2)(int32_t body) {
  thrum_scene_body_info info;
  if (thrum_scene_body(bridge_scene, body, &info, &bridge_error) != THRUM_OK)
    return NULL;
  return info.stepped->omega2;
}

/* Frequencies of its modes as a step gives them [Hz], rank of them; NaN where a mode does not
 * vibrate. */
const double *EXPORT(bridge_stepped_frequencies)(int32_t body) {
  static thrum_stepped_mode modes[THRUM_RANK_MAX];
  static double hertz[THRUM_RANK_MAX];
  thrum_scene_body_info info;
  if (thrum_scene_body(bridge_scene, body, &info, &bridge_error) != THRUM_OK ||
      thrum_scene_body_stepped_modes(bridge_scene, body, modes, &bridge_error) != THRUM_OK)
    return NULL;
  for (int64_t i = 0; i < info.rank; i++)
    hertz[i] = modes[i].stepped_hertz;
  return hertz;
}

/* numbers: position and velocity of a vertex in the world. */
int32_t EXPORT(bridge_vertex)(int32_t body, int32_t vertex) {
  return thrum_scene_body_vertex(bridge_scene, body, vertex, bridge_number, bridge_number + 3,
                                 &bridge_error);
}

/* Displacement per force at a vertex of the body as it is stepped, at rest, summed over the axes
 * [m/N]: tr(U_v diag(1/omega^2) U_v^T). */
static double compliance(int32_t body, int32_t vertex, const thrum_scene_body_info *info) {
  const thrum_model *model = &bridge_body_model(body)->model;
  const double *rows = model->basis + 3 * (int64_t)vertex * model->rank;
  // U' = k U, k^2 = 1 / (density scale^3), has unit mass as U has
  const double k2 = 1.0 / (info->density * info->scale * info->scale * info->scale);
  double sum = 0.0;
  for (int64_t i = 0; i < info->rank; i++)
    for (int axis = 0; axis < 3; axis++) {
      double u = rows[axis * model->rank + i];
      sum += k2 * u * u / info->stepped->omega2[i];
    }

  // what follows gives way as well
  const double scale = info->stiffness / (info->density * info->scale * info->scale);
  for (int64_t i = info->rank; info->condensed && i < model->rank; i++)
    for (int axis = 0; axis < 3; axis++) {
      double u = rows[axis * model->rank + i];
      sum += k2 * u * u / (scale * model->omega2[i]);
    }
  return sum;
}

/* Begins to pull a vertex that is not held towards numbers 0..2 [m], with a spring of `strength`
 * times the stiffness that the body itself has there. Returns its number, or a status below 0. */
int32_t EXPORT(bridge_pull_start)(int32_t body, int32_t vertex, double strength) {
  thrum_scene_body_info info;
  THRUM_TRY(thrum_scene_body(bridge_scene, body, &info, &bridge_error));

  // its compliance is read from the rows of the basis before the scene sees the vertex
  if (vertex < 0 || vertex >= bridge_body_model(body)->model.vertex_count)
    return thrum_error_set(&bridge_error, THRUM_INVALID_ARGUMENT,
                           "the body has no vertex %ld to pull at", (long)vertex);
  int32_t pull;
  thrum_status status = thrum_scene_pull_start(bridge_scene, body, vertex, bridge_number,
                                               strength / compliance(body, vertex, &info), -1.0,
                                               &pull, &bridge_error);
  return status == THRUM_OK ? pull : (int32_t)status;
}

/* numbers: the new target. */
int32_t EXPORT(bridge_pull_move)(int32_t pull) {
  return thrum_scene_pull_move(bridge_scene, pull, bridge_number, &bridge_error);
}

/* numbers: where the pulled vertex is 3, mean force of the last step on it 3 [N]. */
int32_t EXPORT(bridge_pull)(int32_t pull) {
  return thrum_scene_pull_get(bridge_scene, pull, bridge_number, bridge_number + 3, &bridge_error);
}

int32_t EXPORT(bridge_pull_end)(int32_t pull) {
  return thrum_scene_pull_end(bridge_scene, pull, &bridge_error);
}
