/* Reaction forces of a body at rest: R(u) - f at what is held. The sum of R over all vertices is
 * zero, and so is that of its moments where the vertices are now, since no element pulls or turns
 * itself. Reactions and loads are therefore balanced where the free vertices are, which a basis
 * does as far as it can. SPDX-License-Identifier: Apache-2.0 */
#include "driver/statics/static_forces.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "core/base/vec3.h"
#include "driver/spec/actuate_spec.h"
#include "io/file.h"
#include "io/json.h"
#include "platform/allocate.h"
#include "precompute/fem/fem_actuators.h"
#include "precompute/fem/fem_inverted.h"
#include "precompute/model/load_share.h"
#include "precompute/model/model_fem.h"
#include "thrum/displacement.h"

#define LEFT_SAID 0.1 /* of the load: what reactions may leave over without a word */
#define LEFT_MOST 1.0 /* and without being refused */

void static_forces_free(static_forces *forces) {
  free(forces->groups);
  *forces = (static_forces){0};
}

/* Is a vertex held, or on springs to the ground? */
static bool is_supported(const static_body *body, int64_t v) {
  const double *springs = body->model->springs != NULL ? body->model->springs + 3 * v : NULL;
  return body->held[v] != 0 || (springs != NULL && springs[0] + springs[1] + springs[2] > 0);
}

/* The force that holds a vertex: zero along what is free. */
static void reaction_of(const static_body *body, int64_t v, double force[3]) {
  for (int axis = 0; axis < 3; axis++)
    force[axis] =
        body->held[v] >> axis & 1 ? body->internal[3 * v + axis] - body->loads[3 * v + axis] : 0;

  // a spring pulls back
  for (int axis = 0; axis < 3 && body->model->springs != NULL; axis++)
    force[axis] -= body->model->springs[3 * v + axis] * body->u[3 * v + axis];
}

static void add(const static_body *body, int64_t v, const double force[3], static_resultant *sum) {
  double place[3], moment[3];
  for (int axis = 0; axis < 3; axis++)
    place[axis] = body->model->vertices[3 * v + axis] + body->u[3 * v + axis];
  thrum_cross3(place, force, moment);
  for (int axis = 0; axis < 3; axis++) {
    sum->force[axis] += force[axis];
    sum->moment[axis] += moment[axis];
  }
  sum->size += sqrt(thrum_dot3(force, force));
  sum->vertices++;
}

static void add_reactions(const static_body *body, const int32_t *vertices, int64_t count,
                          static_resultant *sum) {
  for (int64_t k = 0; k < count; k++) {
    const int64_t v = vertices != NULL ? vertices[k] : k;
    double force[3];
    reaction_of(body, v, force);
    if (is_supported(body, v))
      add(body, v, force, sum);
  }
}

/* Is all of a group held, along something that does not hold the body as a whole? */
static bool is_held(const static_body *body, const int32_t *vertices, int64_t count) {
  uint8_t whole = 7;
  for (int64_t v = 0; v < body->model->vertex_count; v++)
    whole &= body->held[v];
  for (int64_t k = 0; k < count; k++)
    if ((body->held[vertices[k]] & ~whole) == 0)
      return false;
  return true;
}

/* Does a --move or --rotate name this group? */
static bool is_moved(const static_request *request, const char *name) {
  for (int64_t n = 0; n < request->move_count; n++)
    if (request->moves[n].kind <= STATIC_ROTATE && strcmp(request->moves[n].target.name, name) == 0)
      return true;
  return false;
}

/* Groups of the model all of whose vertices are held, and what is moved. */
static thrum_status sum_groups(const static_request *request, const static_body *body,
                               static_forces *forces, thrum_error *error) {
  const thrum_model *model = body->model;
  THRUM_TRY(thrum_reserve(&forces->groups, model->group_count + request->move_count,
                          sizeof *forces->groups, "the reactions", error));
  for (int64_t g = 0; g < model->group_count; g++) {
    static_group group = {.name = thrum_model_group_name(model, g)};
    const int32_t *vertices = NULL;
    int64_t count = 0;
    THRUM_TRY(thrum_model_group(model, group.name, &vertices, &count, error));
    if (is_moved(request, group.name) || !is_held(body, vertices, count))
      continue;
    add_reactions(body, vertices, count, &group.sum);
    forces->groups[forces->group_count++] = group;
  }

  // what is moved is held there; a target of two options is shown once
  for (int64_t n = 0; n < request->move_count; n++) {
    const static_move *move = &request->moves[n];
    bool seen = move->kind > STATIC_ROTATE;
    for (int64_t k = 0; k < n && !seen; k++)
      seen = request->moves[k].kind <= STATIC_ROTATE &&
             load_target_equal(&request->moves[k].target, &move->target);
    const char *at = strchr(move->text, '@');
    static_group group = {.option = static_move_names[move->kind],
                          .name = at != NULL ? at + 1 : move->text};
    load_vertices held;
    if (seen)
      continue;
    THRUM_TRY(load_target_find(model, &move->target, &held, error));
    add_reactions(body, held.list, held.count, &group.sum);
    load_vertices_free(&held);
    forces->groups[forces->group_count++] = group;
  }
  return THRUM_OK;
}

/* A row for each held vertex: its number from 1, where it is now, and the force that holds it. */
static thrum_status write_reactions(const char *path, const static_body *body, thrum_error *error) {
  thrum_file_writer writer = {0};
  char line[256];
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  static const char head[] = "vertex,x_m,y_m,z_m,fx_n,fy_n,fz_n\n";
  thrum_status status = thrum_file_writer_put(&writer, head, strlen(head), error);
  for (int64_t v = 0; v < body->model->vertex_count && status >= 0; v++) {
    const double *x = body->model->vertices + 3 * v, *u = body->u + 3 * v;
    double force[3];
    if (!is_supported(body, v))
      continue;
    reaction_of(body, v, force);
    snprintf(line, sizeof line, "%" PRId64 ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", v + 1,
             x[0] + u[0], x[1] + u[1], x[2] + u[2], force[0], force[1], force[2]);
    status = thrum_file_writer_put(&writer, line, strlen(line), error);
  }
  return thrum_file_writer_end(&writer, status, error);
}

/* The size of loads of which gravity is a part: ten-node tetrahedra share a body force out with
 * some of it turned round at their corners, and the lengths of these forces add up to more than the
 * weight, which is what acts. */
static thrum_status measure_load(const static_request *request, const static_body *body,
                                 static_resultant *load, thrum_error *error) {
  const int64_t all = 3 * body->model->vertex_count;
  bool falls = false;
  for (int64_t n = 0; n < request->load_count; n++)
    falls = falls || request->loads[n].gravity;
  if (!falls || body->model->midsides == NULL)
    return THRUM_OK;

  double *weight = NULL, whole[3] = {0};
  THRUM_TRY(thrum_reserve(&weight, all, sizeof *weight, "the loads", error));
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < request->load_count && status >= 0; n++) {
    const load_spec *spec = &request->loads[n];
    double by[3];
    for (int axis = 0; axis < 3; axis++)
      by[axis] = request->def.factor * spec->vector[axis];
    if (spec->gravity)
      status = thrum_load_fill_gravity(body->model, by, weight, error);
  }

  // the weight as a whole, and the rest vertex by vertex
  double rest = 0;
  for (int64_t v = 0; v < body->model->vertex_count; v++) {
    double other[3];
    for (int axis = 0; axis < 3; axis++) {
      other[axis] = body->loads[3 * v + axis] - weight[3 * v + axis];
      whole[axis] += weight[3 * v + axis];
    }
    rest += sqrt(thrum_dot3(other, other));
  }
  if (status >= 0)
    load->size = rest + sqrt(thrum_dot3(whole, whole));
  free(weight);
  return status;
}

thrum_status static_forces_sum(const static_request *request, const static_body *body,
                               static_forces *forces, thrum_error *error) {
  static_forces made = {
      .known = true, .inverted = forces->inverted, .inverted_tet = forces->inverted_tet};
  add_reactions(body, NULL, body->model->vertex_count, &made.held);
  for (int64_t v = 0; v < body->model->vertex_count; v++)
    if (thrum_dot3(body->loads + 3 * v, body->loads + 3 * v) > 0)
      add(body, v, body->loads + 3 * v, &made.load);
  for (int axis = 0; axis < 3; axis++) {
    made.left[axis] = made.held.force[axis] + made.load.force[axis];
    made.left_moment[axis] = made.held.moment[axis] + made.load.moment[axis];
  }

  thrum_status status = sum_groups(request, body, &made, error);
  THRUM_THEN(status, measure_load(request, body, &made.load, error));

  // forces that are wrong by more than all of the load are no answer
  const double left = static_forces_left(&made);
  if (status >= 0 && request->reactions != NULL && !request->full && !(left <= LEFT_MOST))
    status = thrum_error_set(error, THRUM_NOT_CONVERGED,
                             "--reactions %.200s: not written, for loads and reactions leave "
                             "%.0f %% of the load over: the basis cannot show this shape's forces; "
                             "take them from --full",
                             request->reactions, 100 * left);
  if (request->reactions != NULL)
    THRUM_THEN(status, write_reactions(request->reactions, body, error));
  if (status >= 0)
    *forces = made;
  else
    static_forces_free(&made);
  return status;
}

thrum_status static_forces_check(const static_request *request, const thrum_model *model,
                                 thrum_error *error) {
  if (request->reactions == NULL || (model->tets != NULL && model->basis != NULL))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "--reactions: the model has no %s, so the forces on its vertices are "
                         "unknown: precompute it from a mesh",
                         model->tets == NULL ? "mesh" : "basis");
}

thrum_status static_forces_reduced(const static_request *request, const thrum_model *model,
                                   const double *q, static_forces *forces, thrum_error *error) {
  const int64_t count = model->vertex_count, all = 3 * count;
  double *memory = NULL;
  thrum_model_fem body = {0};
  if (model->tets == NULL || model->basis == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_reserve(&memory, 3 * all, sizeof *memory, "the reactions", error));
  double *u = memory, *internal = u + all, *loads = internal + all;

  // the loads at their factor, and the mesh's own forces where the model has it
  thrum_status status = thrum_displacement(model, q, 0, count, u, error);
  for (int64_t n = 0; n < request->load_count && status >= 0; n++)
    status = load_spec_fill(model, &request->loads[n], loads, error);
  for (int64_t c = 0; c < all; c++)
    loads[c] *= request->def.factor;
  THRUM_THEN(status, thrum_model_fem_elements(model, &body, error));
  if (status >= 0 && actuate_specs_act(model, request->actuate_count)) {
    status = thrum_model_fem_actuate(model, &body, error);
    if (status >= 0)
      actuate_specs_strength(model, request->actuates, request->actuate_count, request->def.factor,
                             body.acting->levels);
  }
  if (status >= 0) {
    const thrum_fem_inversion inversion = thrum_fem_inverted(&body.fem, u);
    forces->inverted = inversion.count;
    forces->inverted_tet = inversion.tet;
    thrum_fem_acting_loads(&body.fem, u, loads);
    body.fem.acting = NULL;
    thrum_fem_energy(&body.fem, u, internal);
  }

  const static_body rest = {model, u, internal, loads, model->fixed};
  THRUM_THEN(status, static_forces_sum(request, &rest, forces, error));
  thrum_model_fem_free(&body);
  free(memory);
  return status;
}

double static_forces_left(const static_forces *forces) {
  const double size = forces->load.size > 0 ? forces->load.size : forces->held.size;
  return size > 0 ? sqrt(thrum_dot3(forces->left, forces->left)) / size : 0;
}

void static_forces_warn(const static_request *request, const static_forces *forces) {
  const double left = static_forces_left(forces);
  if (request->full || !forces->known || forces->held.vertices == 0 || left <= LEFT_SAID)
    return;
  config_warn("the reactions are wrong by about %.3g N, %.0f %% of the load, which this model "
              "balances as far as its basis goes: take them from --full",
              sqrt(thrum_dot3(forces->left, forces->left)), 100 * left);
}

static void add_resultant(cJSON *object, const static_resultant *sum) {
  json_number(object, "vertices", (double)sum->vertices);
  json_numbers(object, "force_n", sum->force, 3);
  json_numbers(object, "moment_nm", sum->moment, 3);
}

void static_forces_json(const static_forces *forces, cJSON *object) {
  json_number(object, "inverted_tets", forces->known ? (double)forces->inverted : NAN);
  cJSON *reactions = json_section(object, "reactions", forces->known);
  if (reactions == NULL)
    return;
  add_resultant(reactions, &forces->held);

  // moments are about the origin, where the vertices are now
  json_numbers(reactions, "load_force_n", forces->load.force, 3);
  json_numbers(reactions, "load_moment_nm", forces->load.moment, 3);
  json_numbers(reactions, "imbalance_n", forces->left, 3);
  json_numbers(reactions, "imbalance_nm", forces->left_moment, 3);
  json_number(reactions, "imbalance_share", static_forces_left(forces));
  cJSON *groups = cJSON_AddArrayToObject(reactions, "groups");
  for (int64_t n = 0; n < forces->group_count; n++) {
    cJSON *row = json_add_row(groups);
    json_string(row, "target", forces->groups[n].name);
    json_string(row, "option", forces->groups[n].option);
    add_resultant(row, &forces->groups[n].sum);
  }
}

const report_line static_forces_lines[] = {
    REPORT_LINE("reaction",
                "{reactions.force_n:.6g} N; {reactions.moment_nm:.6g} N m about the origin "
                "({reactions.vertices} "
                "vertices)",
                .when = "reactions.vertices"),
    REPORT_LINE("  at {target}:",
                "{force_n:.6g} N; {moment_nm:.6g} N m about the origin ({vertices} vertices)",
                .when = "reactions.vertices", .each = "reactions.groups"),
    REPORT_LINE(
        "balance",
        "{reactions.imbalance_share:%} of the forces that act is left over by loads and reactions",
        .when = "reactions.vertices"),
    {0}};
