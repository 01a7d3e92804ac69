/* Scenes for JavaScript; see engine_bridge.c for the rules. SPDX-License-Identifier: Apache-2.0 */
#include <stdint.h>
#include <string.h>

#include "javascript/bridge.h"

thrum_scene *EXPORT(js_scene_create)(double dt) {
  thrum_scene *scene = NULL;
  return thrum_scene_create(dt, &scene, &js_failure) < 0 ? NULL : scene;
}

void EXPORT(js_scene_destroy)(thrum_scene *scene) {
  thrum_scene_destroy(scene);
}

/* The def's body, of a model; q and p: its start, or NULL. Returns its number. */
int32_t EXPORT(js_scene_add_body)(thrum_scene *scene, const thrum_model *model, int32_t integrator,
                                  double alpha, double beta, const double *q, const double *p) {
  thrum_scene_body_def *def = js_def_made();
  def->model = model;
  def->state.integrator = (thrum_integrator)integrator;
  def->state.damping_alpha = alpha;
  def->state.damping_beta = beta;
  def->q = q;
  def->p = p;
  int32_t body = 0;
  THRUM_TRY(thrum_scene_add_body(scene, def, &body, &js_failure));
  return body;
}

/* numbers: x, y, z. */
int32_t EXPORT(js_scene_gravity)(thrum_scene *scene) {
  return thrum_scene_set_gravity(scene, js_number, &js_failure);
}

/* The def's wind. */
int32_t EXPORT(js_scene_wind)(thrum_scene *scene) {
  return thrum_scene_set_wind(scene, js_def_made(), &js_failure);
}

/* Turns the def's obstacle by a quaternion, numbers 4. */
int32_t EXPORT(js_obstacle_turn)(void) {
  return thrum_scene_axes(js_number, ((thrum_obstacle *)js_def_made())->rotation, &js_failure);
}

/* The def's obstacle: number < 0 adds it, else it takes the place of that one. Returns its number.
 */
int32_t EXPORT(js_scene_obstacle)(thrum_scene *scene, int32_t number) {
  const thrum_obstacle *def = js_def_made();
  if (number < 0)
    THRUM_TRY(thrum_scene_add_obstacle(scene, def, &number, &js_failure));
  else
    THRUM_TRY(thrum_scene_set_obstacle(scene, number, def, &js_failure));
  return number;
}

/* numbers: where an obstacle's centre is now. */
int32_t EXPORT(js_obstacle_get)(const thrum_scene *scene, int32_t number) {
  thrum_obstacle obstacle;
  THRUM_TRY(thrum_scene_obstacle_get(scene, number, &obstacle, &js_failure));
  memcpy(js_number, obstacle.centre, sizeof obstacle.centre);
  return THRUM_OK;
}

/* The def's solid. Returns its number. */
int32_t EXPORT(js_scene_add_solid)(thrum_scene *scene) {
  int32_t number = 0;
  THRUM_TRY(thrum_scene_add_solid(scene, js_def_made(), &number, &js_failure));
  return number;
}

/* numbers: where a solid is now, 4 x 4, column-major; then the count and the address of its
 * vertices (x 3) and of its triangles (x 3), which stay until something is added. */
int32_t EXPORT(js_solid_get)(const thrum_scene *scene, int32_t number) {
  thrum_scene_solid solid;
  THRUM_TRY(thrum_scene_solid_get(scene, number, &solid, &js_failure));
  double *n = js_number;
  for (int column = 0; column < 4; column++)
    for (int row = 0; row < 4; row++)
      n[4 * column + row] = row == 3      ? column == 3
                            : column == 3 ? solid.now.origin[row]
                                          : solid.now.axes[3 * row + column];
  n[16] = (double)solid.vertex_count;
  n[17] = (double)(uintptr_t)solid.vertices;
  n[18] = (double)solid.triangle_count;
  n[19] = (double)(uintptr_t)solid.triangles;
  return THRUM_OK;
}

/* The def's load on a body. */
int32_t EXPORT(js_scene_load)(thrum_scene *scene, int32_t body) {
  return thrum_scene_add_load(scene, body, js_def_made(), &js_failure);
}

/* The vector [m/s^2] and the course of the def's load move the ground. */
int32_t EXPORT(js_scene_base_motion)(thrum_scene *scene) {
  const thrum_scene_load_def *load = js_def_made();
  return thrum_scene_add_base_motion(scene, load->vector, &load->course, &js_failure);
}

/* A motion of the ground: samples are count times, then count x 3 accelerations, velocities and
 * positions. They and `memory`, js_motion_size bytes, must outlive the scene. */
int32_t EXPORT(js_scene_base_record)(thrum_scene *scene, thrum_base_motion *memory, int32_t count,
                                     const double *samples) {
  *memory = (thrum_base_motion){.count = count,
                                .times = samples,
                                .accelerations = samples + count,
                                .velocities = samples + 4 * count,
                                .positions = samples + 7 * count};
  return thrum_scene_add_base_motion_record(scene, memory, &js_failure);
}

size_t EXPORT(js_motion_size)(void) {
  return sizeof(thrum_base_motion);
}

/* The def says how bodies touch each other; on: 0 for bodies that pass through each other. */
int32_t EXPORT(js_scene_set_collisions)(thrum_scene *scene, int32_t on) {
  return thrum_scene_set_collisions(scene, on ? js_def_made() : NULL, &js_failure);
}

/* numbers: touches, groups declined, least distance, depth now, the largest share of its thickness
 * that a touch was deep, normal force, energy stored and lost. */
void EXPORT(js_scene_collisions)(const thrum_scene *scene) {
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  double *n = js_number;
  n[0] = (double)report.touching;
  n[1] = (double)report.declined;
  n[2] = report.distance;
  n[3] = report.depth;
  n[4] = report.deepest_share;
  n[5] = report.normal;
  n[6] = report.stored;
  n[7] = report.lost;
}

/* numbers: body, other body or -1, obstacle or -1, depth, solid or -1, diagonal of the body. */
int32_t EXPORT(js_scene_overlap)(thrum_scene *scene) {
  thrum_scene_overlap found;
  THRUM_TRY(thrum_scene_find_overlap(scene, &found, &js_failure));
  double *n = js_number;
  n[0] = found.body;
  n[1] = found.other;
  n[2] = found.obstacle;
  n[3] = found.depth;
  n[4] = found.solid;
  n[5] = found.diagonal;
  return THRUM_OK;
}

/* The def's link of two bodies, or of a body and the world (other -1). Returns its number. */
int32_t EXPORT(js_scene_add_link)(thrum_scene *scene, int32_t body, int32_t other) {
  thrum_scene_link_def *def = js_def_made();
  def->body = body;
  def->other = other;
  int32_t number = 0;
  THRUM_TRY(thrum_scene_add_link(scene, def, &number, &js_failure));
  return number;
}

/* numbers: kind, whether it holds, body, other body or -1, length, places 6, force 3, torque 3,
 * drift, largest drift, energy stored, lost and driven. */
int32_t EXPORT(js_link_get)(thrum_scene *scene, int32_t number) {
  thrum_scene_link link;
  THRUM_TRY(thrum_scene_link_get(scene, number, &link, &js_failure));
  double *n = js_number;

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
  return thrum_scene_link_release(scene, number, &js_failure);
}

/* numbers: kinetic, potential, gravity, contact, total, momentum 3, angular momentum 3, energy in
 * the springs of links, and what bodies that met each other have lost. */
int32_t EXPORT(js_scene_account)(thrum_scene *scene) {
  thrum_scene_account account;
  THRUM_TRY(thrum_scene_account_get(scene, &account, &js_failure));
  double *n = js_number;
  n[0] = account.kinetic;
  n[1] = account.potential;
  n[2] = account.gravity;
  n[3] = account.contact;
  n[4] = account.total;
  memcpy(n + 5, account.momentum, sizeof account.momentum);
  memcpy(n + 8, account.angular_momentum, sizeof account.angular_momentum);
  n[11] = account.links;
  n[12] = thrum_scene_collisions(scene).lost;
  return THRUM_OK;
}

/* numbers: x, y, z. */
int32_t EXPORT(js_scene_eye)(thrum_scene *scene) {
  return thrum_scene_set_eye(scene, js_number, &js_failure);
}

int32_t EXPORT(js_scene_update_detail)(thrum_scene *scene) {
  return thrum_scene_update_detail(scene, &js_failure);
}

/* numbers: beyond, still, jump. masters 0 takes the level of detail away. */
int32_t EXPORT(js_body_set_detail)(thrum_scene *scene, int32_t body, int32_t masters) {
  const double *n = js_number;
  const thrum_scene_detail detail = {
      .masters = masters, .beyond = n[0], .still = n[1], .jump = n[2]};
  return thrum_scene_set_detail(scene, body, masters > 0 ? &detail : NULL, &js_failure);
}

/* numbers: 1 while it steps fewer coordinates, changes, steps with fewer, largest jump, energy. */
int32_t EXPORT(js_body_detail)(const thrum_scene *scene, int32_t body) {
  thrum_scene_detail_report report;
  THRUM_TRY(thrum_scene_body_detail(scene, body, &report, &js_failure));
  double *n = js_number;
  n[0] = report.reduced;
  n[1] = (double)report.changes;
  n[2] = (double)report.reduced_steps;
  n[3] = report.largest_jump;
  n[4] = report.energy;
  return THRUM_OK;
}

int32_t EXPORT(js_scene_step)(thrum_scene *scene) {
  return thrum_scene_step(scene, &js_failure);
}

double EXPORT(js_scene_time)(const thrum_scene *scene) {
  return thrum_scene_time(scene);
}

int32_t EXPORT(js_scene_dt)(thrum_scene *scene, double dt) {
  return thrum_scene_set_dt(scene, dt, &js_failure);
}

int32_t EXPORT(js_scene_reset)(thrum_scene *scene) {
  return thrum_scene_reset(scene, &js_failure);
}

size_t EXPORT(js_scene_snapshot_size)(const thrum_scene *scene) {
  return thrum_scene_snapshot_size(scene);
}

int32_t EXPORT(js_scene_snapshot)(const thrum_scene *scene, void *memory, size_t size) {
  return thrum_scene_snapshot(scene, memory, size, &js_failure);
}

int32_t EXPORT(js_scene_restore)(thrum_scene *scene, const void *memory, size_t size) {
  return thrum_scene_restore(scene, memory, size, &js_failure);
}

int32_t EXPORT(js_body_damping)(thrum_scene *scene, int32_t body, double alpha, double beta) {
  return thrum_scene_set_damping(scene, body, alpha, beta, &js_failure);
}

int32_t EXPORT(js_body_stiffness)(thrum_scene *scene, int32_t body, double stiffness) {
  return thrum_scene_set_stiffness(scene, body, stiffness, &js_failure);
}

int32_t EXPORT(js_body_integrator)(thrum_scene *scene, int32_t body, int32_t integrator) {
  return thrum_scene_set_integrator(scene, body, (thrum_integrator)integrator, &js_failure);
}

int32_t EXPORT(js_body_rank)(thrum_scene *scene, int32_t body, int32_t rank) {
  return thrum_scene_set_rank(scene, body, rank, &js_failure);
}

/* numbers: status, rank, coordinates that show it, touches, scheme, steps that fell back, steps
 * that grew, steps after a switch, integrator, explicit and implicit modes, iterations of the last
 * step, steps before the first switch to energy (-1: none). */
int32_t EXPORT(js_body_info)(const thrum_scene *scene, int32_t body) {
  thrum_scene_body_info info;
  THRUM_TRY(thrum_scene_body(scene, body, &info, &js_failure));
  double *n = js_number;
  n[0] = info.status;
  n[1] = (double)info.rank;
  n[2] = (double)info.shown;
  n[3] = info.contact.touching;
  n[4] = info.report.scheme;
  n[5] = (double)info.fallback_steps;
  n[6] = (double)info.report.grown_steps;
  n[7] = (double)info.report.switched_steps;
  n[8] = info.integrator;
  n[9] = info.report.explicit_modes;
  n[10] = info.report.implicit_modes;
  n[11] = info.report.iterations_last;
  n[12] = (double)info.report.first_switch;
  return THRUM_OK;
}

/* numbers: kinetic, potential, gravity, contact, total. */
int32_t EXPORT(js_body_energies)(thrum_scene *scene, int32_t body) {
  thrum_scene_energies energies;
  THRUM_TRY(thrum_scene_body_energies(scene, body, &energies, &js_failure));
  double *n = js_number;
  n[0] = energies.kinetic;
  n[1] = energies.potential;
  n[2] = energies.gravity;
  n[3] = energies.contact;
  n[4] = energies.total;
  return THRUM_OK;
}

int32_t EXPORT(js_body_coordinates)(thrum_scene *scene, int32_t body, double *q, double *p) {
  return thrum_scene_body_get(scene, body, q, p, &js_failure);
}

int32_t EXPORT(js_body_positions)(thrum_scene *scene, int32_t body, const thrum_surface *surface,
                                  float *out) {
  return thrum_scene_body_positions(scene, body, surface, out, 3, &js_failure);
}

/* numbers: 4 x 4, column-major. */
void EXPORT(js_body_matrix)(const thrum_scene *scene, int32_t body) {
  thrum_scene_body_matrix(scene, body, js_number);
}

/* numbers: position 3, velocity 3. */
int32_t EXPORT(js_body_vertex)(thrum_scene *scene, int32_t body, int32_t vertex) {
  return thrum_scene_body_vertex(scene, body, vertex, js_number, js_number + 3, &js_failure);
}

/* numbers: target 3, stiffness, damping. Returns the pull's number. */
int32_t EXPORT(js_pull_start)(thrum_scene *scene, int32_t body, int32_t vertex) {
  const double *n = js_number;
  int32_t pull = 0;
  THRUM_TRY(thrum_scene_pull_start(scene, body, vertex, n, n[3], n[4], &pull, &js_failure));
  return pull;
}

/* numbers: target 3. */
int32_t EXPORT(js_pull_move)(thrum_scene *scene, int32_t pull) {
  return thrum_scene_pull_move(scene, pull, js_number, &js_failure);
}

int32_t EXPORT(js_pull_end)(thrum_scene *scene, int32_t pull) {
  return thrum_scene_pull_end(scene, pull, &js_failure);
}

/* numbers: point 3, force 3. */
int32_t EXPORT(js_pull_get)(thrum_scene *scene, int32_t pull) {
  return thrum_scene_pull_get(scene, pull, js_number, js_number + 3, &js_failure);
}
