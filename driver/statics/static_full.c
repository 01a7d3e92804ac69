/* The equilibrium of the whole mesh, under loads and with groups moved. The search is that of
 * full/. SPDX-License-Identifier: Apache-2.0 */
#include "driver/statics/static_full.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/spec/shared_options.h"
#include "driver/statics/static_path.h"
#include "io/npy_file.h"
#include "io/vtu.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/threads.h"
#include "thrum/displacement.h"
#include "thrum/monitor.h"

#define DEGREE 0.017453292519943295 /* [rad] */
#define KICK 0.3                    /* of the largest displacement */

/* Memory of one search; fields are 3 vertex_count. */
typedef struct search {
  const thrum_model *model;
  static_path path;
  thrum_full *body;
  uint8_t *held; /* vertex_count */
  double *forces, *moves, *field;
  load_vertices *targets; /* move_count: of the moves */
  thrum_full_follower *followers;
  thrum_full_turn *turns;
  thrum_full_loading loading;
} search;

static thrum_status allocate(const thrum_model *model, int64_t move_count, search *s,
                             thrum_error *error) {
  const size_t vertices = (size_t)model->vertex_count, moves = (size_t)move_count + 1;
  THRUM_TRY(thrum_reserve(&s->held, vertices + 1, 1, "the full order", error));
  THRUM_TRY(
      thrum_reserve(&s->forces, 9 * vertices + 1, sizeof *s->forces, "the full order", error));
  THRUM_TRY(thrum_reserve(&s->targets, moves, sizeof *s->targets, "the full order", error));
  THRUM_TRY(thrum_reserve(&s->followers, moves, sizeof *s->followers, "the full order", error));
  THRUM_TRY(thrum_reserve(&s->turns, moves, sizeof *s->turns, "the full order", error));
  s->moves = s->forces + 3 * vertices;
  s->field = s->moves + 3 * vertices;
  return THRUM_OK;
}

static void hold(const int32_t *vertices, int64_t count, const double *by, search *s) {
  for (int64_t k = 0; k < count; k++) {
    const int64_t v = vertices != NULL ? vertices[k] : k;
    s->held[v] = 7;
    if (by != NULL)
      memcpy(s->moves + 3 * v, by, 3 * sizeof *by);
  }
}

/* The last --move of the same target as a --rotate; NULL: none. */
static const static_move *move_of(const static_request *request, const load_target *target) {
  const static_move *found = NULL;
  for (int64_t n = 0; n < request->move_count; n++)
    if (request->moves[n].kind == STATIC_MOVE &&
        load_target_equal(&request->moves[n].target, target))
      found = &request->moves[n];
  return found;
}

static void add_turn(const static_request *request, const static_move *move,
                     const int32_t *vertices, int64_t count, search *s) {
  const double factor = request->def.factor;
  const static_move *to = move_of(request, &move->target);
  thrum_full_turn *turn = &s->turns[s->loading.turn_count++];
  *turn = (thrum_full_turn){.vertices = vertices, .count = count, .moved = to != NULL};
  for (int axis = 0; axis < 3; axis++) {
    turn->by[axis] = factor * DEGREE * move->by[axis];
    turn->to[axis] = to != NULL ? factor * to->by[axis] : 0;
  }
}

static thrum_status add_follower(const static_request *request, const static_move *move,
                                 const int32_t *vertices, int64_t count, search *s,
                                 thrum_error *error) {
  thrum_full_follower *one = &s->followers[s->loading.follower_count++];
  *one = (thrum_full_follower){.vertices = vertices, .count = count};
  double *into = move->kind == STATIC_MOMENT ? one->moment : one->force;
  for (int axis = 0; axis < 3; axis++)
    into[axis] = request->def.factor * move->by[axis];

  // a group that tells no rotation is named here, where it is known which option has it
  const thrum_full_loading alone = {.followers = one, .follower_count = 1};
  full_followers made = {0};
  THRUM_TRY(config_error_in(error, full_followers_make(&alone, s->model->vertices, &made, error),
                            "--%s '%.100s'", static_move_names[move->kind], move->text));
  full_followers_free(&made);
  return THRUM_OK;
}

static thrum_status take_moves(const static_request *request, const thrum_model *model, search *s,
                               thrum_error *error) {
  for (int64_t n = 0; n < request->move_count; n++) {
    const static_move *move = &request->moves[n];
    load_vertices *at = &s->targets[n];
    const thrum_status status = load_target_find(model, &move->target, at, error);
    THRUM_TRY(
        config_error_in(error, status, "--%s '%.100s'", static_move_names[move->kind], move->text));

    if (move->kind == STATIC_ROTATE && at->count == 1)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--rotate '%.100s': one vertex has no direction to turn; name a group "
                             "or a predicate, or take --move",
                             move->text);

    // a moved or turned vertex is held in all three directions at its new place
    if (move->kind <= STATIC_ROTATE)
      hold(at->list, at->count, move->kind == STATIC_MOVE ? move->by : NULL, s);
    if (move->kind == STATIC_ROTATE)
      add_turn(request, move, at->list, at->count, s);
    if (move->kind >= STATIC_FOLLOW)
      THRUM_TRY(add_follower(request, move, at->list, at->count, s, error));
  }

  s->loading.forces = s->forces;
  s->loading.moves = request->move_count > s->loading.follower_count ? s->moves : NULL;
  s->loading.followers = s->followers;
  s->loading.turns = s->turns;
  s->loading.watch = s->loading.follower_count == 0;
  return THRUM_OK;
}

/* The body where --from has it: a field of displacements, or q. */
static thrum_status start_from(const static_request *request, const thrum_model *model, search *s,
                               thrum_error *error) {
  double *values = NULL;
  int64_t rows = 0, columns = 0;
  if (request->from == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_npy_read_f8(request->from, &values, &rows, &columns, error));

  // a field as it is, and q through the basis
  thrum_status status = THRUM_OK;
  if (rows == model->vertex_count && columns == 3)
    memcpy(s->field, values, (size_t)(3 * rows) * sizeof *values);
  else if (columns == 0 && rows == model->rank && model->basis != NULL)
    status = thrum_displacement(model, values, 0, model->vertex_count, s->field, error);
  else
    status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--from %.200s: it has %lld x %lld numbers; wanted are %lld x 3, the "
                             "displacements of all vertices, or q of %lld",
                             request->from, (long long)rows, (long long)columns,
                             (long long)model->vertex_count, (long long)model->rank);

  THRUM_THEN(status, thrum_full_displace(s->body, s->field, error));
  free(values);
  return status;
}

static thrum_status add_loads(const static_request *request, const thrum_model *model, search *s,
                              thrum_error *error) {
  for (int64_t n = 0; n < request->load_count; n++) {
    const load_spec *load = &request->loads[n];

    // gravity is integrated over the body, other loads are already fields
    if (load->gravity) {
      thrum_full_add_gravity(s->body, load->vector, s->forces);
      continue;
    }
    THRUM_TRY(config_error_in(error, load_spec_fill(model, load, s->forces, error),
                              "--load '%.100s'", load->text));
  }

  if (request->actuate_count > 0) {
    double levels[THRUM_ACTUATORS_MAX];
    THRUM_TRY(actuate_specs_check(model, request->actuates, request->actuate_count, error));
    actuate_specs_strength(model, request->actuates, request->actuate_count, request->def.factor,
                           levels);
    THRUM_TRY(thrum_full_set_actuation(s->body, levels, error));
  }

  // moves grow with the same factor as the loads
  for (int64_t c = 0; c < 3 * model->vertex_count; c++) {
    s->forces[c] *= request->def.factor;
    s->moves[c] *= request->def.factor;
  }
  return THRUM_OK;
}

/* Warns of loads that are allowed and yet hardly meant, as static_solve.c does. */
static void warn_idle(const static_request *request, const thrum_model *model, const search *s) {
  bool idle = request->move_count == 0 && request->actuate_count == 0;
  for (int64_t c = 0; c < 3 * model->vertex_count && idle; c++)
    idle = s->forces[c] == 0 || (model->fixed[c / 3] >> c % 3 & 1) != 0;
  if (idle)
    config_warn("%s: the load moves nothing: it is zero, or all that it acts on is held",
                request->model_path);
}

/* The mean displacement of a target where the body is. */
static thrum_status mean_at(const void *context, const load_target *target, double mean[3],
                            thrum_error *error) {
  const search *s = context;
  load_vertices at;
  THRUM_TRY(config_error_in(error, load_target_find(s->model, target, &at, error), "--at"));
  thrum_full_mean(s->body, at.list, at.count, mean);
  load_vertices_free(&at);
  return THRUM_OK;
}

/* A row of --path; its factor is of the loads as they are given. */
static void put_point(void *context, const thrum_full_point *point) {
  search *s = context;
  const double factor = s->path.request->def.factor * point->factor;
  const static_path_point row = {factor, point->energy, point->least, point->jumped};
  static_path_put(&s->path, &row, s);
}

/* Reads displacements off the body where it rests. */
static thrum_status look(static_answer *answer, const search *s, thrum_error *error) {
  const static_request *request = answer->request;

  // the mean displacement of each target
  for (int64_t n = 0; n < request->target_count; n++)
    THRUM_TRY(mean_at(s, &request->targets[n], answer->displaced[n], error));

  // and the largest of all vertices
  answer->peak = 0;
  answer->peak_vertex = -1;
  thrum_full_peak(s->body, &answer->peak, &answer->peak_vertex);
  return THRUM_OK;
}

static void fill_report(static_answer *answer, const thrum_full_equilibrium *found, search *s,
                        double *q) {
  thrum_equilibrium_report *report = &answer->report;

  // the search itself
  report->factor = answer->request->def.factor;
  report->residual = found->residual;
  report->energy = found->energy;
  report->load_energy = found->load_energy;

  // loads that turn leave stability as yes or no, and look for no critical loads
  report->least = found->stable || isfinite(found->least) ? found->least : -INFINITY;
  report->softest = found->softest;
  report->softest_factor = found->softest_factor * report->factor;
  report->instability = found->instability;
  report->critical = found->critical * report->factor;
  report->critical_linear = NAN;
  report->jumps = found->jumps;

  // how well the critical load is known
  answer->critical_from = found->critical_from * report->factor;
  answer->critical_to = found->critical_to * report->factor;
  answer->critical_share = found->critical_least / found->least_start;
  answer->least_start = found->least_start;

  // the tangent has not all of a gas, so that no branch can be followed by it
  answer->lost_at =
      found->lost && !actuate_specs_act(s->model, 0) ? found->lost_at * report->factor : NAN;

  // the report tells what the solution has cost
  report->load_steps = found->load_steps;
  report->cut_steps = found->cut_steps;
  report->iterations = found->iterations;
  report->factorisations = (int32_t)thrum_full_report_get(s->body).factorisations;
  answer->components = thrum_full_report_get(s->body).free_count;

  // the nearest reduced coordinates, for comparison with the model
  thrum_full_get(s->body, s->field, NULL);
  if (answer->model->basis != NULL)
    thrum_full_project(s->body, s->field, q);
}

/* The warnings that a look at the whole mesh gives: StVK gives way under compression, and no
 * material bears to be turned inside out. */
static void look_stretch(static_answer *answer, const search *s) {
  static_belief *belief = &answer->belief;
  belief->stretch = thrum_full_least_stretch(s->body, false);
  if (belief->stretch < 0)
    belief->warnings |= THRUM_WARNING_INVERTED;
  const double weak = thrum_full_least_stretch(s->body, true);
  if (belief->stretch < 0 || !(weak < thrum_default_monitor_def().stretch_least))
    return;
  belief->warnings |= THRUM_WARNING_COMPRESSED;
  belief->stretch = weak;
}

/* Is there a shape of less energy, so that the path led to a higher branch? The body is kicked
 * along its two lowest vibrations by a third of how far it is displaced. */
static thrum_status look_lower(static_answer *answer, const thrum_full_equilibrium *found,
                               search *s, thrum_error *error) {
  const thrum_model *model = answer->model;
  const int64_t all = 3 * model->vertex_count, rank = model->rank, count = rank < 2 ? rank : 2;
  double peak = 0, lower = INFINITY;
  int64_t vertex = 0;
  double *kicks = NULL;
  THRUM_TRY(thrum_reserve(&kicks, count * all, sizeof *kicks, "a search for less energy", error));
  thrum_full_peak(s->body, &peak, &vertex);
  for (int64_t k = 0; k < count; k++) {
    double largest = 0;
    for (int64_t c = 0; c < all; c++)
      largest = fmax(largest, fabs(model->basis[c * rank + k]));
    for (int64_t c = 0; c < all; c++)
      kicks[k * all + c] = KICK * peak / largest * model->basis[c * rank + k];
  }

  // energies that differ by rounding are those of the same shape
  const double energy = found->energy + found->load_energy;
  thrum_status status = thrum_full_lower(s->body, &s->loading, kicks, count, &lower, error);
  if (status >= 0 && lower < energy - 1e-6 * fabs(energy))
    answer->lower_energy = lower;
  free(kicks);
  return status;
}

/* What holds the body where it rests: s->field is where that is, s->moves is free to be used. */
static thrum_status look_forces(static_answer *answer, search *s, thrum_error *error) {
  const thrum_model *model = answer->model;
  full_followers followers = {0};
  THRUM_TRY(full_followers_make(&s->loading, model->vertices, &followers, error));
  if (s->loading.follower_count > 0)
    full_followers_add(&followers, s->field, 1, s->forces);
  full_followers_free(&followers);

  // what the model holds is held as well
  for (int64_t v = 0; v < model->vertex_count; v++)
    s->held[v] |= model->fixed[v];
  thrum_full_internal_forces(s->body, s->moves, s->forces);
  const thrum_fem_inversion inversion = thrum_full_inverted(s->body);
  answer->forces.inverted = inversion.count;
  answer->forces.inverted_tet = inversion.tet;
  const static_body body = {model, s->field, s->moves, s->forces, s->held};
  return static_forces_sum(answer->request, &body, &answer->forces, error);
}

static thrum_status find(static_answer *answer, search *s, double *q, thrum_error *error) {
  const static_request *request = answer->request;
  const thrum_model *model = answer->model;
  answer->belief = (static_belief){.stretch = NAN};
  thrum_full_equilibrium found;
  thrum_full_def def = thrum_default_full_def();
  def.tolerance = request->def.tolerance;
  def.solver = request->solver;
  def.shared = request->shared;
  def.quadrature = request->quadrature;
  def.law = law_of_run(request->law_given, request->law, model);

  // held vertices belong to the body, so they are known before it is made
  THRUM_TRY(allocate(model, request->move_count, s, error));
  THRUM_TRY(take_moves(request, model, s, error));
  THRUM_TRY(thrum_full_create(model, s->held, &def, &s->body, error));
  THRUM_TRY(add_loads(request, model, s, error));

  warn_idle(request, model, s);

  // displacements are read once before the search, so that a wrong target fails at once
  THRUM_TRY(look(answer, s, error));
  THRUM_TRY(start_from(request, model, s, error));
  THRUM_TRY(static_path_open(request, mean_at, &s->path, error));
  s->loading.visit = request->path != NULL ? put_point : NULL;
  s->loading.visit_context = s;
  const thrum_status rested = thrum_full_rest_under(s->body, &s->loading, &found, error);

  // the path to where the body loses its stability is one that was found
  if (rested >= 0 ||
      (rested == THRUM_NOT_CONVERGED && found.instability != THRUM_INSTABILITY_NONE)) {
    const thrum_status closed = static_path_close(&s->path, rested >= 0 ? error : NULL);
    THRUM_TRY(rested >= 0 ? closed : rested);
  }
  THRUM_TRY(rested);
  s->loading.visit = NULL;

  if (request->monitor && s->loading.moves != NULL && s->loading.follower_count == 0 &&
      found.stable && model->basis != NULL)
    THRUM_TRY(look_lower(answer, &found, s, error));

  if (request->monitor)
    look_stretch(answer, s);

  // the answer is read off the body at rest
  fill_report(answer, &found, s, q);
  THRUM_TRY(look_forces(answer, s, error));
  THRUM_TRY(look(answer, s, error));
  if (request->field != NULL)
    THRUM_TRY(thrum_npy_write_f8(request->field, s->field, model->vertex_count, 3, error));
  const thrum_model shown = model_of_law(model, def.law);
  THRUM_TRY(static_stress_look(&shown, s->field, &answer->stress, error));
  const vtu_stress stress = static_stress_frame(&answer->stress);
  return request->frame != NULL ? vtu_write_whole(request->frame, model, s->field, &stress, error)
                                : THRUM_OK;
}

thrum_status static_full_find(static_answer *answer, double *q, thrum_error *error) {
  search s = {.model = answer->model};
  thrum_threads_set(1);

  // only the search counts
  const double began = clock_seconds();
  const thrum_status status =
      answer->model->vertices != NULL
          ? find(answer, &s, q, error)
          : thrum_error_set(error, THRUM_MISSING, "--full: the model has no mesh to go back to");
  answer->seconds = clock_seconds() - began;

  static_path_abandon(&s.path);
  thrum_full_free(s.body);
  free(s.held);
  free(s.forces);
  for (int64_t n = 0; s.targets != NULL && n < answer->request->move_count; n++)
    load_vertices_free(&s.targets[n]);
  free(s.targets);
  free(s.followers);
  free(s.turns);
  return status;
}
