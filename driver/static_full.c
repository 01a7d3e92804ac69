/* The equilibrium of the whole mesh, under loads and with groups moved. The search is that of
 * full/. SPDX-License-Identifier: Apache-2.0 */
#include "driver/static_full.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/vtu.h"
#include "platform/clock.h"
#include "platform/threads.h"

/* Memory of one search; fields are 3 vertex_count. */
typedef struct search {
  thrum_full *body;
  uint8_t *held; /* vertex_count */
  double *forces, *moves, *field;
} search;

static thrum_status allocate(const thrum_model *model, search *s, thrum_error *error) {
  const size_t vertices = (size_t)model->vertex_count;
  s->held = calloc(vertices + 1, 1);
  s->forces = calloc(9 * vertices + 1, sizeof *s->forces);
  if (s->held == NULL || s->forces == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the full order");
  s->moves = s->forces + 3 * vertices;
  s->field = s->moves + 3 * vertices;
  return THRUM_OK;
}

static thrum_status take_moves(const static_request *request, const thrum_model *model, search *s,
                               thrum_error *error) {
  for (int64_t n = 0; n < request->move_count; n++) {
    const static_move *move = &request->moves[n];
    const int32_t *vertices = NULL;
    int64_t count = 0;
    int32_t one = 0;

    thrum_error detail = {0};
    const thrum_status status =
        load_target_find(model, &move->target, &vertices, &count, &one, &detail);
    if (status < 0)
      return thrum_error_set(error, status, "--move '%.100s': %s", move->text, detail.message);

    // a moved vertex is held in all three directions at its new place
    for (int64_t k = 0; k < count; k++) {
      const int64_t v = vertices != NULL ? vertices[k] : k;
      s->held[v] = 7;
      memcpy(s->moves + 3 * v, move->by, sizeof move->by);
    }
  }
  return THRUM_OK;
}

static thrum_status add_loads(const static_request *request, const thrum_model *model, search *s,
                              thrum_error *error) {
  for (int64_t n = 0; n < request->load_count; n++) {
    const load_spec *load = &request->loads[n];

    // gravity is integrated over the body, other loads are already fields
    thrum_error detail = {0};
    if (load->gravity) {
      thrum_full_add_gravity(s->body, load->vector, s->forces);
      continue;
    }
    const thrum_status status = load_spec_fill(model, load, s->forces, &detail);
    if (status < 0)
      return thrum_error_set(error, status, "--load '%.100s': %s", load->text, detail.message);
  }

  // moves grow with the same factor as the loads
  for (int64_t c = 0; c < 3 * model->vertex_count; c++) {
    s->forces[c] *= request->def.factor;
    s->moves[c] *= request->def.factor;
  }
  return THRUM_OK;
}

/* Reads displacements off the body where it rests. */
static thrum_status look(static_answer *answer, const search *s, thrum_error *error) {
  const static_request *request = answer->request;

  // the mean displacement of each target
  for (int64_t n = 0; n < request->target_count; n++) {
    const int32_t *vertices = NULL;
    int64_t count = 0;
    int32_t one = 0;
    thrum_error detail = {0};
    const thrum_status status =
        load_target_find(answer->model, &request->targets[n], &vertices, &count, &one, &detail);
    if (status < 0)
      return thrum_error_set(error, status, "--at: %s", detail.message);
    thrum_full_mean(s->body, vertices, count, answer->displaced[n]);
  }

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

  // the full order knows stability only as yes or no, and finds no critical loads
  report->least = found->stable ? NAN : -INFINITY;
  report->softest = report->softest_factor = NAN;
  report->critical = report->critical_linear = NAN;

  // its cost
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

static thrum_status find(static_answer *answer, search *s, double *q, thrum_error *error) {
  const static_request *request = answer->request;
  const thrum_model *model = answer->model;
  thrum_full_equilibrium found;
  thrum_full_def def = thrum_default_full_def();
  def.tolerance = request->def.tolerance;
  def.solver = request->solver;

  // held vertices belong to the body, so they are known before it is made
  THRUM_TRY(allocate(model, s, error));
  THRUM_TRY(take_moves(request, model, s, error));
  THRUM_TRY(thrum_full_create(model, s->held, &def, &s->body, error));
  THRUM_TRY(add_loads(request, model, s, error));

  // displacements are read once before the search, so that a wrong target fails at once
  THRUM_TRY(look(answer, s, error));
  THRUM_TRY(thrum_full_rest(s->body, s->forces, request->move_count > 0 ? s->moves : NULL, &found,
                            error));

  // the answer is read off the body at rest
  fill_report(answer, &found, s, q);
  THRUM_TRY(look(answer, s, error));
  return request->frame != NULL ? vtu_write_whole(request->frame, model, s->field, error)
                                : THRUM_OK;
}

thrum_status static_full_find(static_answer *answer, double *q, thrum_error *error) {
  search s = {0};
  thrum_threads_set(1);
  const double began = clock_seconds();
  const thrum_status status =
      answer->model->vertices != NULL
          ? find(answer, &s, q, error)
          : thrum_error_set(error, THRUM_MISSING, "--full: the model has no mesh to go back to");
  answer->seconds = clock_seconds() - began;
  thrum_full_free(s.body);
  free(s.held);
  free(s.forces);
  return status;
}
