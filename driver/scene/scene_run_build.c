/* A scene file as a scene: its models loaded, its texts understood, its bodies placed.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_build.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/make/spin_warning.h"
#include "driver/scene/scene_run_couple.h"
#include "driver/scene/scene_run_crossed.h"
#include "driver/scene/scene_run_detail.h"
#include "driver/scene/scene_run_link.h"
#include "driver/scene/scene_run_refuse.h"
#include "driver/scene/scene_run_world.h"
#include "driver/scene/scene_words.h"
#include "driver/spec/shared_options.h"
#include "mesh/formats/mesh_read.h"
#include "platform/allocate.h"

/* --- loads ------------------------------------------------------------------------------------ */

/* A load on the engine: its vector is still in world axes. */
static thrum_status add_load(scene_run *run, int32_t n, const load_spec *load, thrum_error *error) {
  const scene_body_run *body = &run->bodies[n];
  thrum_scene_load_def given = thrum_default_scene_load_def();
  given.kind = load->gravity    ? THRUM_SCENE_ACCELERATION
               : load->traction ? THRUM_SCENE_FIELD
                                : THRUM_SCENE_FORCE;
  given.course = load->course;
  memcpy(given.vector, load->vector, sizeof given.vector);

  // a force acts on the vertices of its target, a traction as a field over the body
  load_vertices at = {0};
  double *field = NULL;
  thrum_status status = THRUM_OK;
  if (given.kind == THRUM_SCENE_FORCE) {
    status = load_target_find(body->model, &load->target, &at, error);
    given.vertices = at.list;
    given.count = at.count;
  } else if (given.kind == THRUM_SCENE_FIELD) {
    field = calloc(3 * (size_t)body->model->vertex_count + 1, sizeof *field);
    status = field != NULL ? load_spec_fill(body->model, load, field, error)
                           : scene_run_no_memory(error);
    // a traction acts on the area of the scaled body
    const double area = body->spec->scale * body->spec->scale;
    for (int64_t c = 0; status >= 0 && c < 3 * body->model->vertex_count; c++)
      field[c] *= area;
    given.field = field;
    given.field_count = body->model->vertex_count;
  }

  THRUM_THEN(status, thrum_scene_add_load(run->scene, n, &given, error));
  load_vertices_free(&at);
  free(field);
  return status;
}

/* The loads of a body: on the engine, and in the body's axes for what looks at them. */
static thrum_status add_loads(scene_run *run, int32_t n) {
  scene_body_run *body = &run->bodies[n];
  const config_texts *texts = &body->spec->loads;
  simulate_request *request = &body->request;
  for (int64_t l = 0; l < texts->count; l++) {
    // the engine takes world axes
    thrum_error detail = {0};
    load_spec *load = &request->loads[request->load_count];
    thrum_status status = load_spec_parse(texts->texts[l], load, &detail);
    THRUM_THEN(status, add_load(run, n, load, &detail));

    if (status < 0)
      return config_record_refuse_text(&run->spec.file, &body->spec->settings.at, "loads", texts, l,
                                       "%s", detail.message);

    // what looks at the body's own run takes its axes
    thrum_scene_to_body(body->spec->rotation, load->vector, load->vector, NULL);
    request->load_count++;
  }
  return THRUM_OK;
}

/* The levels of the actuators of a body. */
static thrum_status add_actuation(scene_run *run, int32_t n) {
  scene_body_run *body = &run->bodies[n];
  const config_texts *texts = &body->spec->actuate;
  simulate_request *request = &body->request;
  for (int64_t l = 0; l < texts->count; l++) {
    thrum_error detail = {0};
    int64_t index = 0;
    actuate_spec *spec = &request->actuates[request->actuate_count];
    thrum_status status = actuate_spec_parse(texts->texts[l], spec, &detail);
    THRUM_THEN(status, thrum_model_actuator(body->model, spec->name, &index, &detail));
    THRUM_THEN(status, thrum_scene_add_actuation(run->scene, n, index, spec->level, &spec->course,
                                                 &detail));
    if (status < 0)
      return config_record_refuse_text(&run->spec.file, &body->spec->settings.at, "actuate", texts,
                                       l, "%s", detail.message);
    request->actuate_count++;
  }
  actuate_specs_warn(body->model, request->actuates, request->actuate_count, request->time, false);
  return THRUM_OK;
}

/* Gravity as a load, first of all, for the figures of a body's run. */
static void note_gravity(const scene_run *run, scene_body_run *body) {
  const double *g = run->spec.gravity;
  if (g[0] == 0 && g[1] == 0 && g[2] == 0)
    return;
  snprintf(body->gravity, sizeof body->gravity, "gravity:%.17g,%.17g,%.17g", g[0], g[1], g[2]);
  load_spec *load = &body->request.loads[body->request.load_count++];
  *load = (load_spec){.text = body->gravity,
                      .gravity = true,
                      .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
  thrum_scene_to_body(body->spec->rotation, g, load->vector, NULL);
}

/* --- starts ----------------------------------------------------------------------------------- */

/* The whole model as the body has it: scaled, with its mesh and basis; *memory is the caller's. */
static thrum_status scale_whole(const scene_body_run *body, void **memory,
                                const thrum_model **scaled, thrum_error *error) {
  const thrum_model_scaling by = {body->spec->scale, body->spec->stiffness, body->spec->density};
  *scaled = body->model;
  if (by.length == 1 && by.stiffness == 1 && by.density == 1)
    return THRUM_OK;

  // factors of one leave the model as it is, others take a copy
  size_t size = 0;
  THRUM_TRY(thrum_model_scale_size(body->model, &size, error));
  *memory = thrum_allocate_aligned(size, "a scaled model", error);
  return *memory != NULL ? thrum_model_scale(*memory, size, body->model, &by, scaled, error)
                         : THRUM_OUT_OF_MEMORY;
}

/* q and p of the start, both of the rank and zero before. */
static thrum_status make_start(scene_run *run, scene_body_run *body, double *q, double *p) {
  const config_texts *texts = &body->spec->start;
  simulate_request *request = &body->request;
  if (body->given != NULL)
    memcpy(q, body->given, 2 * (size_t)body->model->rank * sizeof *q);
  if (body->given != NULL || texts->count == 0)
    return THRUM_OK;

  // displacements are those of the scaled body
  thrum_error detail = {0};
  void *memory = NULL;
  const thrum_model *scaled = NULL;
  thrum_status status = scale_whole(body, &memory, &scaled, &detail);

  // a load given in world axes is turned into the body's
  for (int64_t n = 0; n < texts->count && status >= 0; n++) {
    start_spec *start = &request->starts[request->start_count++];
    status = start_spec_parse(texts->texts[n], start, &detail);
    if (status >= 0 && start->kind == START_STATIC)
      thrum_scene_to_body(body->spec->rotation, start->load.vector, start->load.vector, NULL);
  }

  char place[SCENE_PLACE_MAX];
  config_warn_under(scene_body_place(&run->spec, body->spec, place), scene_words);
  THRUM_THEN(status,
             start_specs_make(scaled, request->starts, request->start_count, q, p, &detail));
  config_warn_under(NULL, scene_words);
  free(memory);
  return scene_run_pass(run, &body->spec->settings.at, "start", status, &detail);
}

/* Coordinates that a body is stepped with while the others follow, by "rank" or "condense"; 0: all.
 */
static int64_t stepped_of(const scene_body_run *body) {
  const scene_body_spec *spec = body->spec;
  return spec->rank > 0 && spec->rank < body->model->rank ? spec->rank : spec->condense;
}

/* --- bodies ----------------------------------------------------------------------------------- */

static thrum_status make_request(scene_run *run, scene_body_run *body, thrum_error *error) {
  const scene_spec *spec = &run->spec;
  simulate_request *request = &body->request;

  // what is made of a mesh is named by its file, which others can open
  const scene_loaded *loaded = scene_model_of(&run->models, body - run->bodies);
  const char *path = thrum_mesh_is_named(body->spec->model) ? loaded->file.path : body->spec->model;

  // the run of a body is written as if it were simulated alone
  *request = (simulate_request){
      .model_path = path,
      .run_path = body->folder,
      .def = body->spec->settings.def,
      .time = spec->time,
      .steps = run->steps,
      .rank = body->spec->rank,
      .condense = stepped_of(body),
      .record_every = spec->outputs.record_every,
      .frames_rate = spec->outputs.frames_rate,
      .frames_every = spec->outputs.frames_every,
      .base_motions = run->base_motions,
      .base_motion_count = run->base_motion_count,
      .stress = spec->outputs.stress,
      .monitor = spec->outputs.monitor,
      .basis = spec->outputs.basis,
      .loads = calloc((size_t)body->spec->loads.count + 1, sizeof *request->loads),
      .starts = calloc((size_t)body->spec->start.count + 1, sizeof *request->starts),
      .actuates = calloc((size_t)body->spec->actuate.count + 1, sizeof *request->actuates),
      .quiet = true,
  };

  // all bodies share the time step of the scene, and each has its own material
  request->def.dt = run->dt;
  request->def.plastic = body->spec->material.plastic;
  const bool room = request->loads != NULL && request->starts != NULL && request->actuates != NULL;
  return room ? THRUM_OK : scene_run_no_memory(error);
}

/* The group that a body names in "touch": also where nothing is there to be touched. */
static thrum_status find_touch(const scene_run *run, scene_body_run *body,
                               thrum_scene_body_def *def) {
  load_target target;
  thrum_error detail = {0};
  thrum_status status = load_target_parse(body->spec->touch, "touch", &target, &detail);
  THRUM_THEN(status,
             load_target_list(body->model, &target, &body->touched, &def->touch_count, &detail));
  def->touch = body->touched;
  return scene_run_pass(run, &body->spec->settings.at, "touch", status, &detail);
}

/* The surface where there is wind, and what may touch where there are obstacles. */
static thrum_status name_surface(scene_run *run, int32_t n, thrum_scene_body_def *def) {
  scene_body_run *body = &run->bodies[n];
  const char *touch = body->spec->touch;
  const bool none = strcmp(touch, "none") == 0, surface = strcmp(touch, "surface") == 0;
  const bool touches = run->spec.obstacles.count > 0 && !none;
  const scene_loaded *skinned = NULL;

  thrum_error detail = {0};
  if (!none && !surface)
    THRUM_TRY(find_touch(run, body, def));

  // contact and wind both need the surface of the mesh
  const bool collides = scene_run_body_meets(run, body) && body->model->basis;
  def->collide = run->spec.collide && body->spec->collide;
  if (!touches)
    def->touch_count = 0;
  if (!touches && !collides && run->spec.wind.at.node == NULL)
    return THRUM_OK;

  const thrum_status status = scene_models_skin(&run->models, n, &skinned, &detail);
  THRUM_TRY(scene_run_pass(run, &body->spec->settings.at, "model", status, &detail));

  // by default all vertices of the surface may touch
  def->triangles = skinned->corners;
  def->triangle_count = skinned->skin.triangle_count;
  if (touches && surface) {
    def->touch = skinned->skin.vertices;
    def->touch_count = skinned->skin.vertex_count;
  }
  return THRUM_OK;
}

/* Opens the check that tells how far a condensed body can be believed. */
static thrum_status open_check(scene_run *run, int32_t n, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  thrum_scene_body_info info;
  thrum_scene_body(run->scene, n, &info, NULL);
  if (!info.condensed || !body->request.monitor)
    return THRUM_OK;
  THRUM_TRY(condensed_check_open(info.stepped, &body->check, error));

  // its frequencies are those of the scaled model, its coordinates those of the file
  const thrum_state_def *def = &body->request.def;
  const bool scaled =
      body->spec->scale != 1 || body->spec->stiffness != 1 || body->spec->density != 1;
  body->pace = sqrt(body->spec->stiffness / body->spec->density) / body->spec->scale;
  condensed_check_damp(&body->check, def, body->pace);
  condensed_check_start(&body->check, &body->request, body->start,
                        scaled ? NULL : body->start + body->model->rank);
  return THRUM_OK;
}

/* Passes the status of adding a body on; what flows is a key of its material. */
static thrum_status pass_body(const scene_run *run, const scene_body_spec *spec,
                              thrum_status status, const thrum_error *detail) {
  const bool flows = detail->field != NULL && strncmp(detail->field, "plastic.", 8) == 0;
  return scene_run_pass(run, flows ? &spec->material.at : &spec->settings.at, NULL, status, detail);
}

static thrum_status add_body(scene_run *run, int32_t n, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  const scene_body_spec *spec = body->spec;
  const size_t rank = (size_t)body->model->rank;
  thrum_error detail = {0};
  THRUM_TRY(thrum_reserve(&body->start, 2 * rank, sizeof *body->start, "the scene", error));

  // the file's values, with angles in radians
  thrum_scene_body_def *def = &body->def;
  *def = thrum_default_scene_body_def();
  def->name = spec->name;
  def->model = body->model;
  THRUM_BODY_FIELDS(SCENE_COPY)
  def->rank = 0;
  def->condense = body->request.condense;
  def->state = body->request.def;
  def->q = body->start;
  def->p = body->start + rank;
  for (int axis = 0; axis < 3; axis++)
    def->spin[axis] = SCENE_DEGREE * spec->spin[axis];

  // spin and shape act on each other where that is asked for or matters
  def->coupled = scene_run_couples(run, body);

  // its state at the start and the part of it that others can touch
  THRUM_TRY(make_start(run, body, body->start, body->start + rank));
  THRUM_TRY(name_surface(run, n, def));
  thrum_status status = thrum_scene_add_body(run->scene, def, NULL, &detail);

  // a model whose basis is none of free modes has no inertia of the deformed shape
  if (status < 0 && body->coupled_by_default) {
    body->coupled_by_default = false;
    def->coupled = 0;
    detail = (thrum_error){0};
    status = thrum_scene_add_body(run->scene, def, NULL, &detail);
  }
  return pass_body(run, spec, status, &detail);
}

static thrum_status make_bodies(scene_run *run, thrum_error *error) {
  const scene_spec *spec = &run->spec;
  for (int32_t n = 0; n < spec->bodies.count; n++) {
    scene_body_run *body = &run->bodies[n];
    const scene_loaded *loaded = scene_model_of(&run->models, n);

    // the record of the body, which names its folder
    body->spec = &scene_bodies(spec)[n];
    body->model = loaded->model;
    run->run.bodies[n].name = body->spec->name;
    run->run.bodies[n].moves = body->spec->free;
    run->run.bodies[n].figures = (simulate_figures){
        .request = &body->request, .model = body->model, .model_hash = loaded->hash};
    snprintf(body->folder, sizeof body->folder, "%.*s/%s", RUN_PATH_MAX, run->request->output,
             body->spec->name);

    // the model file says now whether one of its regions flows
    if (plastic_option_without_yield(&body->spec->material.plastic, body->model) != NULL)
      return config_record_refuse(&spec->file, &body->spec->material.at, "yield", THRUM_MISSING,
                                  "is needed: beyond it the material flows");

    // gravity is noted first, so that it leads the list of loads
    THRUM_TRY(make_request(run, body, error));
    note_gravity(run, body);
    THRUM_TRY(add_body(run, n, error));
    THRUM_TRY(add_loads(run, n));
    THRUM_TRY(add_actuation(run, n));
  }
  return THRUM_OK;
}

/* Warns of coupled bodies that cannot show what their own spin does to them. */
static void warn_of_spins(const scene_run *run) {
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = &run->bodies[n];
    const thrum_model_scaling by = {body->spec->scale, body->spec->stiffness, body->spec->density};
    double spin[3];
    char place[SCENE_PLACE_MAX];
    if (!body->def.coupled)
      continue;

    // the centrifugal force is that in the body's axes
    thrum_scene_to_body(body->spec->rotation, body->def.spin, spin, NULL);
    config_warn_under(scene_body_place(&run->spec, body->spec, place), scene_words);
    spin_warning_print(body->spec->model, body->model, &by, spin);
    config_warn_under(NULL, scene_words);
  }
}

/* The threads that the command line asks for. */
static thrum_status take_threads(scene_run *run, thrum_error *error) {
  const int32_t threads = (int32_t)run->request->threads;
  if (threads < 2)
    return THRUM_OK;
  THRUM_TRY(thrum_thread_team_make(threads, &run->team, error));
  return thrum_scene_set_workers(run->scene, threads, thrum_thread_team_run, run->team, error);
}

thrum_status scene_run_make(scene_run *run, thrum_error *error) {
  const scene_spec *spec = &run->spec;
  thrum_error detail = {0};
  THRUM_TRY(driver_run_open(&run->run, (int32_t)spec->bodies.count, error));
  THRUM_TRY(thrum_scene_create(run->dt, &run->scene, error));

  // what acts on all bodies comes before the bodies
  THRUM_TRY(scene_run_base_motions(run, error));
  const thrum_status status = thrum_scene_set_gravity(run->scene, spec->gravity, &detail);
  THRUM_TRY(scene_run_pass(run, &spec->settings.at, "gravity", status, &detail));

  // wind, obstacles and probes refer to the bodies
  THRUM_TRY(make_bodies(run, error));
  THRUM_TRY(scene_run_collisions(run));
  THRUM_TRY(scene_run_wind(run, run->scene));
  THRUM_TRY(scene_run_obstacles(run, run->scene));
  THRUM_TRY(scene_run_probes(run));
  return scene_run_links(run, error);
}

thrum_status scene_run_build(scene_run *run, thrum_error *error) {
  const scene_spec *spec = &run->spec;
  THRUM_TRY(
      thrum_reserve(&run->bodies, spec->bodies.count, sizeof *run->bodies, "the scene", error));

  // models are loaded once for all bodies that share them
  run->run.name = run->request->path;
  THRUM_TRY(scene_models_load(spec, run->request->quiet, &run->models, error));
  THRUM_TRY(scene_run_make(run, error));
  THRUM_TRY(scene_run_check_start(run, error));

  // how many coordinates are stepped depends on all that acts on a body
  THRUM_TRY(scene_run_find_detail(run, error));
  scene_run_warn_of_passing(run);
  THRUM_TRY(scene_run_look_for_crossings(run, error));
  warn_of_spins(run);
  THRUM_TRY(take_threads(run, error));
  for (int32_t n = 0; n < spec->bodies.count; n++)
    THRUM_TRY(open_check(run, n, error));
  return THRUM_OK;
}

void scene_run_unmake(scene_run *run) {
  for (int64_t n = 0; run->bodies != NULL && n < run->spec.bodies.count; n++) {
    free(run->bodies[n].request.loads);
    free(run->bodies[n].request.actuates);
    free(run->bodies[n].request.starts);
    free(run->bodies[n].start);
    free(run->bodies[n].touched);
    free(run->bodies[n].material);
    free(run->bodies[n].vertices);
    free(run->bodies[n].sphere_at);
    free(run->bodies[n].middle_at);
    free(run->bodies[n].surface);
    condensed_check_close(&run->bodies[n].check);
  }

  driver_run_close(&run->run);
  thrum_scene_destroy(run->scene);
  thrum_thread_team_free(run->team);
  for (int64_t n = 0; n < run->base_motion_count; n++)
    base_motion_close(&run->base_motions[n]);
  free(run->base_motions);
  free(run->bodies);
}
