/* Stress and monitors of a run, asked for, kept and shown. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/simulate_measures.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "config/message.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "platform/allocate.h"
#include "runtime/material/material_law.h"
#include "thrum/thrum.h"

#define LOAD_SHARE_MOST 0.9995 /* of a point force a good basis may leave 0.99 unfelt */

/* All tetrahedra. */
static const thrum_stress_points_def every_tet = {NULL, 0};

static thrum_status open_stress_points(const thrum_model *model, simulate_measures *m,
                                       thrum_error *error) {
  size_t size = 0;

  // solids have stresses at nodes alone
  if (model->solid_count > 0)
    return THRUM_OK;
  THRUM_TRY(config_error_of(error, thrum_stress_points_size(model, &every_tet, &size, error),
                            "--stress"));

  if (thrum_law_has_yield(model))
    return thrum_error_set_field(error, "--stress", THRUM_UNSUPPORTED,
                                 " is of a material that does not flow, and a region of this model "
                                 "does");

  // one point in each tetrahedron
  THRUM_TRY(thrum_reserve_aligned(&m->stress_points_memory, size, "stresses", error));
  THRUM_TRY(thrum_stress_points_init(m->stress_points_memory, size, model, &every_tet,
                                     &m->stress_points, error));

  // the scratch memory and the stresses share one allocation
  const int64_t work = thrum_stress_points_work_count(m->stress_points);
  THRUM_TRY(thrum_reserve(&m->work, work + model->tet_count, sizeof *m->work, "stresses", error));
  m->von_mises = m->work + work;
  return THRUM_OK;
}

/* The full order: its stress is that of a model with the displacement as its only coordinate. */
static thrum_status open_field(const simulate_request *request, const thrum_model *model,
                               simulate_measures *m, thrum_error *error) {
  if (request->shared)
    return thrum_error_set_field(error, "--stress", THRUM_UNSUPPORTED,
                                 " is of a body in one process: leave it out with several");
  THRUM_TRY(thrum_reserve(&m->field, 3 * model->vertex_count, sizeof *m->field, "stresses", error));
  m->field_model = model_of_law(model, law_of_run(request->law_given, request->law, model));
  m->field_model.rank = 1;
  m->field_model.basis = m->field;
  return open_stress_points(&m->field_model, m, error);
}

/* The stresses at q, or at the field. */
static thrum_status read_stresses(simulate_measures *m, const double *q, thrum_error *error) {
  static const double one = 1;
  const thrum_stress_points_output output = {.von_mises = m->von_mises};
  if (!m->stress_points)
    return THRUM_OK;
  if (m->field) {
    size_t size;
    THRUM_TRY(thrum_stress_points_size(&m->field_model, &every_tet, &size, error));
    THRUM_TRY(thrum_stress_points_init(m->stress_points_memory, size, &m->field_model, &every_tet,
                                       &m->stress_points, error));
  }
  return thrum_stress_points_read(m->stress_points, m->field ? &one : q, m->work, &output, error);
}

static thrum_status open_monitor(const thrum_model *model, simulate_measures *m,
                                 thrum_error *error) {
  thrum_monitor_def def = thrum_default_monitor_def();
  def.load_share_most = LOAD_SHARE_MOST;

  // how far a body moves does not tell right from wrong: its basis is judged by the mesh
  def.reach_most = INFINITY;
  size_t size = 0;
  THRUM_TRY(thrum_monitor_size(model, &def, &size, error));
  THRUM_TRY(thrum_reserve_aligned(&m->monitor_memory, size, "the monitor", error));

  // a law that does not give way is warned of where it is inverted
  m->warns_below = thrum_law_gives_way(model, thrum_law_of_model(model)) ? def.stretch_least : 0;
  return thrum_monitor_init(m->monitor_memory, size, model, &def, &m->monitor, error);
}

/* The largest share of the loads outside the basis. Gravity is left out: it takes the assembled
 * mass, which `thrum info --load` makes. */
static thrum_status look_at_loads(const simulate_request *request, const thrum_model *model,
                                  simulate_measures *m, thrum_error *error) {
  const size_t components = 3 * (size_t)model->vertex_count;
  double *forces = malloc(components * sizeof *forces);
  thrum_status status = THRUM_OK;
  if (forces == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the loads");

  // a load at its full strength, one at a time
  for (int64_t n = 0; n < request->load_count && status >= 0; n++) {
    const load_spec *load = &request->loads[n];
    if (load->gravity)
      continue;

    for (size_t c = 0; c < components; c++)
      forces[c] = 0;

    status = load_spec_fill(model, load, forces, error);
    THRUM_THEN(status, thrum_monitor_look_at_load(m->monitor, model, forces, &m->record, error));
    if (status >= 0)
      m->load_share = fmax(m->load_share, m->record.load_share); // of NaN: the other
  }

  free(forces);
  return status;
}

/* The model whose mesh and law the stress is of. */
static const thrum_model *mesh_of(const simulate_measures *m) {
  return m->field ? &m->field_model : m->model;
}

thrum_status simulate_measures_open(const simulate_request *request, const thrum_model *model,
                                    simulate_measures *measures, thrum_error *error) {
  simulate_measures m = {.peak_stress = NAN, .peak_tet = -1, .load_share = NAN};
  thrum_monitor_clear(&m.record);

  // stress needs the material in the model, and refuses a model without it
  thrum_status status = THRUM_OK;
  if (request->stress)
    status = request->full ? open_field(request, model, &m, error)
                           : open_stress_points(model, &m, error);

  // the monitor is on by default, so it passes over a model that it cannot look at
  if (status >= 0 && request->monitor && model->tets != NULL && model->basis != NULL) {
    status = open_monitor(model, &m, error);
    THRUM_THEN(status, look_at_loads(request, model, &m, error));
  }

  // a model that cannot be judged is told so
  m.basis_asked = request->monitor && !request->full;
  if (m.basis_asked)
    THRUM_THEN(status, basis_record_open(request, model, &m.basis, error));

  // the nodes refer to the model of the measures, which has its place now
  m.model = model;
  *measures = m;
  if (request->stress)
    THRUM_THEN(status, node_stress_open(mesh_of(measures), &measures->nodes, error));
  if (status < 0)
    simulate_measures_close(measures);
  return status;
}

bool simulate_measures_are_open(const simulate_measures *measures) {
  return measures->monitor != NULL || node_stress_is_open(&measures->nodes);
}

/* Notes when warnings were first raised and when the least stretch was. */
static thrum_status look_monitor(simulate_measures *m, const double *q, double time,
                                 thrum_error *error) {
  const thrum_monitor_record before = m->record;
  THRUM_TRY(thrum_monitor_look(m->monitor, q, &m->record, error));
  if (m->record.stretch_least < before.stretch_least)
    m->stretch_time = time;
  for (int bit = 0; bit < 32; bit++)
    if ((m->record.warnings & ~before.warnings) >> bit & 1)
      m->warned_at[bit] = time;
  return THRUM_OK;
}

thrum_status simulate_measures_look(simulate_measures *m, const double *q, double time,
                                    thrum_error *error) {
  thrum_status status = THRUM_OK;
  if (m->monitor != NULL)
    status = look_monitor(m, q, time, error);
  if (status < 0 || !node_stress_is_open(&m->nodes))
    return status;

  // the peak over time and over all tetrahedra
  status = read_stresses(m, q, error);
  for (int64_t n = 0; status >= 0 && n < thrum_stress_points_count(m->stress_points); n++) {
    // a comparison that is true of the first stress, and never of one that is no number
    if (m->von_mises[n] > m->peak_stress || (m->peak_tet < 0 && m->von_mises[n] >= 0)) {
      m->peak_stress = m->von_mises[n];
      m->peak_tet = n;
      m->peak_time = time;
    }
  }

  // and the same at the nodes, from displacements
  const double *u = m->field ? m->field : m->nodes.u;
  if (!m->field)
    THRUM_THEN(status,
               thrum_displacement(m->model, q, 0, m->model->vertex_count, m->nodes.u, error));
  THRUM_THEN(status, node_stress_look(mesh_of(m), u, time, &m->nodes, error));
  return status;
}

#define X(name, bit, text) bit,
static const uint32_t warnings[] = {THRUM_WARNING_LIST(X)};
#undef X
enum { WARNING_COUNT = sizeof warnings / sizeof warnings[0] };
static const char *const warning_keys[WARNING_COUNT] = {"compressed", "inverted", "reach", "load"};

/* The place of a bit in warned_at. */
static int place_of(uint32_t bit) {
  int place = 0;
  while (bit >> (place + 1))
    place++;
  return place;
}

void simulate_measures_json(const simulate_measures *m, double end, cJSON *object) {
  // null says that it was not asked for
  cJSON *stress = json_section(object, "stress", node_stress_is_open(&m->nodes));
  if (stress != NULL) {
    node_stress_json(&m->nodes, stress);
    json_number(stress, "peak_time_s", m->nodes.peak_node >= 0 ? m->nodes.peak_time : NAN);
    json_number(stress, "centre_peak_von_mises_pa", m->peak_stress);
    json_number(stress, "centre_peak_tet", m->peak_tet >= 0 ? (double)m->peak_tet + 1 : NAN);
    json_number(stress, "centre_peak_time_s", m->peak_tet >= 0 ? m->peak_time : NAN);
  }

  // null says that it was not asked for
  if (m->basis_asked)
    basis_estimate_json(&m->basis.estimate, end, object);
  else
    cJSON_AddNullToObject(object, "error_estimate");

  cJSON *monitor = json_section(object, "monitor", m->monitor != NULL);
  if (monitor == NULL)
    return;

  // the names of the warnings raised
  cJSON *raised = cJSON_AddArrayToObject(monitor, "warnings");
  for (int n = 0; n < WARNING_COUNT; n++)
    if (m->record.warnings & warnings[n])
      json_add_string(raised, warning_keys[n]);

  // extremes exist once tetrahedra have been looked at
  const bool looked = m->record.stretch_tet >= 0;
  json_number(monitor, "sampled_tets", (double)thrum_monitor_sampled_tets(m->monitor, NULL));
  json_number(monitor, "least_stretch", looked ? m->record.stretch_least : NAN);
  json_number(monitor, "tet", looked ? (double)m->record.stretch_tet + 1 : NAN);
  json_number(monitor, "time_s", looked ? m->stretch_time : NAN);
  json_number(monitor, "load_share_outside", m->load_share);
}

void simulate_measures_warn(const simulate_measures *m, const char *who) {
  const thrum_monitor_record *record = &m->record;

  // an inverted element was compressed first, so one message is enough
  if (record->warnings & THRUM_WARNING_INVERTED) {
    config_warn(
        "%stetrahedron %d was turned inside out; the first time by %g s. The material allows it "
        "and no real one does: lower the load",
        who, (int)record->stretch_tet + 1, m->warned_at[place_of(THRUM_WARNING_INVERTED)]);
  } else if (record->warnings & THRUM_WARNING_COMPRESSED) {
    config_warn(
        "%stetrahedron %d was compressed to %.3f of its length; below 0.577, first passed by "
        "%g s, StVK gives way: do not trust what follows",
        who, (int)record->stretch_tet + 1, record->stretch_least,
        m->warned_at[place_of(THRUM_WARNING_COMPRESSED)]);
  }

  // what the basis cannot show
  if (m->basis_asked && !m->basis_found)
    basis_estimate_warn(&m->basis.estimate, &m->basis.request->basis, who, "motion");
  if (record->warnings & THRUM_WARNING_LOAD)
    config_warn("%s%.4g %% of a load is not felt by the basis: see `thrum info --load`, and "
                "`thrum precompute --handles`",
                who, 100 * m->load_share);
}

void simulate_measures_close(simulate_measures *m) {
  node_stress_close(&m->nodes);
  free(m->stress_points_memory);
  free(m->monitor_memory);
  free(m->work);
  free(m->field);
  basis_record_close(&m->basis);
  *m = (simulate_measures){0};
}
