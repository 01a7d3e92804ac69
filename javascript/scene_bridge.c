/* Scenes for JavaScript; see engine_bridge.c for the rules. SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "thrum/scene.h"

#define EXPORT(name) __attribute__((export_name(#name))) name

double *js_numbers(void);

static thrum_error failure;

/* Why a function of this file failed last. */
const char *EXPORT(js_scene_message)(void) {
  return failure.message;
}

thrum_scene *EXPORT(js_scene_make)(double dt) {
  thrum_scene *scene = NULL;
  return thrum_scene_make(dt, &scene, &failure) < 0 ? NULL : scene;
}

void EXPORT(js_scene_free)(thrum_scene *scene) {
  thrum_scene_free(scene);
}

/* numbers: position 3, rotation 4, scale, stiffness, density, alpha, beta, velocity 3, spin 3,
 * start amplitude. `of` is the first field of a model's handle. Returns the body's number. */
int32_t EXPORT(js_scene_add_body)(thrum_scene *scene, const thrum_model *const *of,
                                  int32_t integrator, int32_t rank, int32_t condense,
                                  int32_t free_body, int32_t coupled, int32_t collides,
                                  int32_t self_contact, int32_t start_mode,
                                  const int32_t *triangles, int32_t triangle_count,
                                  const int32_t *touch, int32_t touch_count) {
  const double *n = js_numbers();
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = *of;
  memcpy(def.position, n, sizeof def.position);
  memcpy(def.rotation, n + 3, sizeof def.rotation);
  def.scale = n[7];
  def.stiffness = n[8];
  def.density = n[9];
  def.state.damping_alpha = n[10];
  def.state.damping_beta = n[11];
  memcpy(def.velocity, n + 12, sizeof def.velocity);
  memcpy(def.spin, n + 15, sizeof def.spin);
  def.start_amplitude = n[18];

  // what is no measured number comes as an argument
  def.state.integrator = (thrum_integrator)integrator;
  def.rank = rank;
  def.condense = condense;
  def.free = free_body;
  def.coupled = coupled;
  def.collides = collides;
  def.self_contact = self_contact;
  def.start_mode = start_mode;
  def.triangles = triangles;
  def.triangle_count = triangle_count;
  def.touch = touch;
  def.touch_count = touch_count;
  int32_t body = 0;
  THRUM_TRY(thrum_scene_add_body(scene, &def, &body, &failure));
  return body;
}

/* numbers: x, y, z. */
int32_t EXPORT(js_scene_gravity)(thrum_scene *scene) {
  return thrum_scene_set_gravity(scene, js_numbers(), &failure);
}

/* numbers: velocity of the air 3, density, drag. */
int32_t EXPORT(js_scene_wind)(thrum_scene *scene) {
  const double *n = js_numbers();
  return thrum_scene_set_wind(scene, n, n[3], n[4], &failure);
}

/* numbers: centre 3, normal 3, radius, half sides 3, rotation 4, velocity 3, friction, restitution,
 * stiffness, damping. number < 0 adds an obstacle, else that one is replaced. Returns its number.
 */
int32_t EXPORT(js_scene_obstacle)(thrum_scene *scene, int32_t number, int32_t shape,
                                  int32_t inside) {
  const double *n = js_numbers();
  thrum_obstacle obstacle = thrum_default_obstacle();
  obstacle.shape = (thrum_obstacle_shape)shape;
  obstacle.inside = inside;
  memcpy(obstacle.centre, n, sizeof obstacle.centre);
  memcpy(obstacle.normal, n + 3, sizeof obstacle.normal);
  obstacle.radius = n[6];
  memcpy(obstacle.half, n + 7, sizeof obstacle.half);
  THRUM_TRY(thrum_scene_axes(n + 10, obstacle.rotation, &failure));
  memcpy(obstacle.velocity, n + 14, sizeof obstacle.velocity);
  obstacle.friction = n[17];
  obstacle.restitution = n[18];
  obstacle.stiffness = n[19];
  obstacle.damping = n[20];

  if (number < 0)
    THRUM_TRY(thrum_scene_add_obstacle(scene, &obstacle, &number, &failure));
  else
    THRUM_TRY(thrum_scene_set_obstacle(scene, number, &obstacle, &failure));
  return number;
}

/* numbers: vector 3, from, until, frequency. kind: 0 a force on `count` vertices (NULL: all), 2 an
 * acceleration; sine: 1 for a sine over time. */
int32_t EXPORT(js_scene_load)(thrum_scene *scene, int32_t body, int32_t kind, int32_t sine,
                              const int32_t *vertices, int32_t count) {
  const double *n = js_numbers();
  thrum_scene_load load = {
      .kind = (thrum_scene_load_kind)kind, .vertices = vertices, .count = count};
  memcpy(load.vector, n, sizeof load.vector);
  load.course.shape = sine ? THRUM_LOAD_SINE : THRUM_LOAD_CONSTANT;
  load.course.from = n[3];
  load.course.until = n[4];
  load.course.frequency = n[5];
  return thrum_scene_add_load(scene, body, &load, &failure);
}

/* numbers: thickness, friction, restitution. on: 0 for bodies that pass through each other. */
int32_t EXPORT(js_scene_set_collisions)(thrum_scene *scene, int32_t on) {
  const double *n = js_numbers();
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.thickness = n[0];
  def.friction = n[1];
  def.restitution = n[2];
  return thrum_scene_set_collisions(scene, on ? &def : NULL, &failure);
}

/* numbers: touches, groups declined, least distance, depth now, the largest share of its thickness
 * that a touch was deep, normal force, energy stored and lost. */
void EXPORT(js_scene_collisions)(const thrum_scene *scene) {
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  double *n = js_numbers();
  n[0] = (double)report.touching;
  n[1] = (double)report.declined;
  n[2] = report.distance;
  n[3] = report.depth;
  n[4] = report.deepest_share;
  n[5] = report.normal;
  n[6] = report.stored;
  n[7] = report.lost;
}

/* numbers: body, other body or -1, obstacle or -1, depth. */
int32_t EXPORT(js_scene_overlap)(thrum_scene *scene) {
  thrum_scene_overlap found;
  THRUM_TRY(thrum_scene_find_overlap(scene, &found, &failure));
  double *n = js_numbers();
  n[0] = found.body;
  n[1] = found.other;
  n[2] = found.obstacle;
  n[3] = found.depth;
  return THRUM_OK;
}

/* numbers: place 3, other place 3, axis 3, stiffness, damping, length, until. NaN where a place is
 * not given, other -1 for the world, the vertices NULL where there is no list. Returns the link's
 * number. */
int32_t EXPORT(js_scene_add_link)(thrum_scene *scene, int32_t kind, int32_t body, int32_t other,
                                  const int32_t *vertices, int32_t count,
                                  const int32_t *other_vertices, int32_t other_count,
                                  const double *path_times, const double *path_places,
                                  int32_t path_count) {
  const double *n = js_numbers();
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = (thrum_link_kind)kind;
  def.body = body;
  def.other = other;
  def.vertices = vertices;
  def.count = count;
  def.other_vertices = other_vertices;
  def.other_count = other_count;

  // where it is, how stiff, and for how long
  memcpy(def.place, n, sizeof def.place);
  memcpy(def.other_place, n + 3, sizeof def.other_place);
  memcpy(def.axis, n + 6, sizeof def.axis);
  def.stiffness = n[9];
  def.damping = n[10];
  def.length = n[11];
  def.until = n[12];
  def.path_times = path_times;
  def.path_places = path_places;
  def.path_count = path_count;
  int32_t number = 0;
  THRUM_TRY(thrum_scene_add_link(scene, &def, &number, &failure));
  return number;
}

/* numbers: kind, whether it holds, body, other body or -1, length, places 6, force 3, torque 3,
 * drift, largest drift, energy stored, lost and driven. */
int32_t EXPORT(js_link_get)(thrum_scene *scene, int32_t number) {
  thrum_scene_link link;
  THRUM_TRY(thrum_scene_link_get(scene, number, &link, &failure));
  double *n = js_numbers();

  // the package reads the numbers in the order that the comment above gives
  n[0] = link.kind;
  n[1] = link.holds;
  n[2] = link.bodies[0];
  n[3] = link.bodies[1];
  n[4] = link.length;
  memcpy(n + 5, link.places, sizeof link.places);
  memcpy(n + 11, link.report.force, sizeof link.report.force);
  memcpy(n + 14, link.report.torque, sizeof link.report.torque);
  n[17] = link.report.drift;
  n[18] = link.report.largest_drift;
  n[19] = link.report.stored;
  n[20] = link.report.lost;
  n[21] = link.report.driven;
  return THRUM_OK;
}

int32_t EXPORT(js_link_release)(thrum_scene *scene, int32_t number) {
  return thrum_scene_link_release(scene, number, &failure);
}

/* numbers: kinetic, potential, gravity, contact, total, momentum 3, angular momentum 3, energy in
 * the springs of links. */
int32_t EXPORT(js_scene_account)(thrum_scene *scene) {
  thrum_scene_account account;
  THRUM_TRY(thrum_scene_account_get(scene, &account, &failure));
  double *n = js_numbers();
  n[0] = account.kinetic;
  n[1] = account.potential;
  n[2] = account.gravity;
  n[3] = account.contact;
  n[4] = account.total;
  memcpy(n + 5, account.momentum, sizeof account.momentum);
  memcpy(n + 8, account.angular_momentum, sizeof account.angular_momentum);
  n[11] = account.links;
  return THRUM_OK;
}

/* numbers: x, y, z. */
int32_t EXPORT(js_scene_eye)(thrum_scene *scene) {
  return thrum_scene_set_eye(scene, js_numbers(), &failure);
}

int32_t EXPORT(js_scene_update_detail)(thrum_scene *scene) {
  return thrum_scene_update_detail(scene, &failure);
}

/* numbers: beyond, still, jump. masters 0 takes the level of detail away. */
int32_t EXPORT(js_body_set_detail)(thrum_scene *scene, int32_t body, int32_t masters) {
  const double *n = js_numbers();
  const thrum_scene_detail detail = {
      .masters = masters, .beyond = n[0], .still = n[1], .jump = n[2]};
  return thrum_scene_set_detail(scene, body, masters > 0 ? &detail : NULL, &failure);
}

/* numbers: 1 while it steps fewer coordinates, changes, steps with fewer, largest jump, energy. */
int32_t EXPORT(js_body_detail)(const thrum_scene *scene, int32_t body) {
  thrum_scene_detail_report report;
  THRUM_TRY(thrum_scene_body_detail(scene, body, &report, &failure));
  double *n = js_numbers();
  n[0] = report.reduced;
  n[1] = (double)report.changes;
  n[2] = (double)report.reduced_steps;
  n[3] = report.largest_jump;
  n[4] = report.energy;
  return THRUM_OK;
}

int32_t EXPORT(js_scene_step)(thrum_scene *scene) {
  return thrum_scene_step(scene, &failure);
}

double EXPORT(js_scene_time)(const thrum_scene *scene) {
  return thrum_scene_time(scene);
}

int32_t EXPORT(js_scene_dt)(thrum_scene *scene, double dt) {
  return thrum_scene_set_dt(scene, dt, &failure);
}

int32_t EXPORT(js_scene_reset)(thrum_scene *scene) {
  return thrum_scene_reset(scene, &failure);
}

size_t EXPORT(js_scene_snapshot_size)(const thrum_scene *scene) {
  return thrum_scene_snapshot_size(scene);
}

int32_t EXPORT(js_scene_snapshot)(const thrum_scene *scene, void *memory, size_t size) {
  return thrum_scene_snapshot(scene, memory, size, &failure);
}

int32_t EXPORT(js_scene_restore)(thrum_scene *scene, const void *memory, size_t size) {
  return thrum_scene_restore(scene, memory, size, &failure);
}

int32_t EXPORT(js_body_damping)(thrum_scene *scene, int32_t body, double alpha, double beta) {
  return thrum_scene_set_damping(scene, body, alpha, beta, &failure);
}

/* numbers: status, rank, coordinates that show it, touches, scheme, steps that fell back, steps
 * that grew, steps after a switch. */
int32_t EXPORT(js_body_info)(const thrum_scene *scene, int32_t body) {
  thrum_scene_body_info info;
  THRUM_TRY(thrum_scene_body(scene, body, &info, &failure));
  double *n = js_numbers();
  n[0] = info.status;
  n[1] = (double)info.rank;
  n[2] = (double)info.shown;
  n[3] = info.contact.touching;
  n[4] = info.report.scheme;
  n[5] = (double)info.fallback_steps;
  n[6] = (double)info.report.grown_steps;
  n[7] = (double)info.report.switched_steps;
  return THRUM_OK;
}

/* numbers: kinetic, potential, gravity, contact, total. */
int32_t EXPORT(js_body_energies)(thrum_scene *scene, int32_t body) {
  thrum_scene_energies energies;
  THRUM_TRY(thrum_scene_body_energies(scene, body, &energies, &failure));
  double *n = js_numbers();
  n[0] = energies.kinetic;
  n[1] = energies.potential;
  n[2] = energies.gravity;
  n[3] = energies.contact;
  n[4] = energies.total;
  return THRUM_OK;
}

int32_t EXPORT(js_body_coordinates)(thrum_scene *scene, int32_t body, double *q, double *p) {
  return thrum_scene_body_get(scene, body, q, p, &failure);
}

int32_t EXPORT(js_body_positions)(thrum_scene *scene, int32_t body, const thrum_surface *surface,
                                  float *out) {
  return thrum_scene_body_positions(scene, body, surface, out, 3, &failure);
}

/* numbers: 4 x 4, column-major. */
void EXPORT(js_body_matrix)(const thrum_scene *scene, int32_t body) {
  thrum_scene_body_matrix(scene, body, js_numbers());
}

/* numbers: position 3, velocity 3. */
int32_t EXPORT(js_body_vertex)(thrum_scene *scene, int32_t body, int32_t vertex) {
  return thrum_scene_body_vertex(scene, body, vertex, js_numbers(), js_numbers() + 3, &failure);
}

/* numbers: target 3, stiffness, damping. Returns the pull's number. */
int32_t EXPORT(js_pull_start)(thrum_scene *scene, int32_t body, int32_t vertex) {
  const double *n = js_numbers();
  int32_t pull = 0;
  THRUM_TRY(thrum_scene_pull_start(scene, body, vertex, n, n[3], n[4], &pull, &failure));
  return pull;
}

/* numbers: target 3. */
int32_t EXPORT(js_pull_move)(thrum_scene *scene, int32_t pull) {
  return thrum_scene_pull_move(scene, pull, js_numbers(), &failure);
}

int32_t EXPORT(js_pull_end)(thrum_scene *scene, int32_t pull) {
  return thrum_scene_pull_end(scene, pull, &failure);
}

/* numbers: point 3, force 3. */
int32_t EXPORT(js_pull_get)(thrum_scene *scene, int32_t pull) {
  return thrum_scene_pull_get(scene, pull, js_numbers(), js_numbers() + 3, &failure);
}
