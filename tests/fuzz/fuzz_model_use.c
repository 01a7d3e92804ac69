/* Fuzz target of everything that a program does with a model: an input is a model file behind
 * PLAN_BYTES bytes that choose what is done. Whatever the file says, a call that succeeds leaves
 * finite numbers, and one that fails says why. Inputs get valid checksums.
 * sources: scene/*.c core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c contact/*.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_use.h"
#include "tests/support/scene_wind_def.h"

#define STEPS 6

/* Levels of actuators, set and read; any of them may be refused. */
static void use_actuators(const thrum_model *model, thrum_state *state, fuzz_draw *draw) {
  double levels[THRUM_ACTUATORS_MAX], numbers[THRUM_ACTUATORS_MAX];
  const int64_t count = thrum_model_actuators(model);
  thrum_error error = {0};
  int64_t index = 0;
  draw_vector(draw, count, 1e3, levels);
  fuzz_check(thrum_state_set_actuation(model, state, draw_byte(draw) % 8 ? levels : NULL, &error),
             &error);
  if (thrum_state_actuation(model, state, levels, &error) >= 0)
    must_be_finite(levels, count);
  fuzz_check(thrum_state_actuation_work(model, state, numbers, &error), &error);
  fuzz_check(thrum_state_actuation_measures(model, state, numbers, &error), &error);
  const char *text = thrum_model_actuator_text(model, draw_index(draw, count + 1));
  fuzz_check(thrum_model_actuator(model, text ? text : "none", &index, &error), &error);

  // the same levels for what has no state
  thrum_model acting;
  double *memory = block((size_t)thrum_model_actuation_count(model) * sizeof *memory);
  double q[RANK_MOST], force[RANK_MOST];
  draw_vector(draw, model->rank, 0.1, q);
  thrum_status status = thrum_model_actuate(model, levels, memory, &acting, &error);
  fuzz_check(status, &error);
  index = draw_index(draw, count + 1);
  if (status >= 0)
    status = thrum_model_actuation_force(&acting, index, q, force, numbers, &error);
  if (status >= 0) {
    must_be_finite(force, model->rank);
    must_be_finite(numbers, 1);
  }
  free(memory);
}

/* A state is stepped, kept, put back, and batched. */
static void use_state(const thrum_model *model, fuzz_draw *draw) {
  const thrum_state_def def = draw_def(draw, model->rank);
  thrum_state *state = NULL;
  thrum_error error = {0};
  fuzz_check(thrum_state_create(model, &def, &state, &error), &error);
  if (state == NULL)
    return;

  double q[RANK_MOST], p[RANK_MOST], force[RANK_MOST];
  thrum_energies energies;
  draw_vector(draw, model->rank, 0.1, q);
  draw_vector(draw, model->rank, 1, p);
  draw_vector(draw, model->rank, 10, force);
  fuzz_check(thrum_state_set(model, state, q, p, &error), &error);
  fuzz_check(thrum_state_set_force(model, state, force, &error), &error);

  // a snapshot between steps is put back after them
  const size_t size = thrum_state_snapshot_size(state);
  void *snapshot = block(size);
  for (int step = 0; step < STEPS; step++) {
    fuzz_check(thrum_step(model, state, &error), &error);
    if (thrum_state_get(model, state, q, p, &error) >= 0) {
      must_be_finite(q, model->rank);
      must_be_finite(p, model->rank);
    }
    fuzz_check(thrum_state_energies(model, state, &energies, &error), &error);
    if (step == STEPS / 2 && thrum_state_snapshot(state, snapshot, size, &error) < 0)
      abort();
    if (step % 2 == 1)
      use_actuators(model, state, draw);
    if (step == STEPS / 2 && draw_byte(draw) % 2 == 0)
      fuzz_check(thrum_state_set_dt(model, state, draw_above(draw, 0.01), &error), &error);
  }
  if (thrum_state_restore(model, state, snapshot, size, &error) < 0)
    abort();

  // a batch of the state and a copy
  thrum_state *copy = block(thrum_state_bytes(state));
  memcpy(copy, state, thrum_state_bytes(state));
  if (thrum_batch_size(model, &(size_t){0}, &error) >= 0) {
    size_t work;
    thrum_batch_size(model, &work, NULL);
    void *workspace = block(work);
    thrum_state *both[] = {state, copy};
    fuzz_check(thrum_batch_step(model, both, 2, NULL, workspace, work, &error), &error);
    free(workspace);

    // what goes in and out of both
    static double rows[2 * RANK_MOST];
    thrum_energies found[2];
    fuzz_check(thrum_batch_get(model, both, 2, rows, NULL, model->rank, &error), &error);
    fuzz_check(thrum_batch_set(model, both, 2, NULL, rows, p, 0, &error), &error);
    fuzz_check(thrum_batch_set_forces(model, both, 2, force, 0, &error), &error);
    fuzz_check(thrum_batch_set_actuation(model, both, 2, NULL, 0, &error), &error);
    fuzz_check(thrum_batch_energies(model, both, 2, found, &error), &error);
  }

  static thrum_stepped_mode modes[RANK_MOST];
  fuzz_check(thrum_state_stepped_modes(model, state, modes, &error), &error);
  free(copy);
  free(snapshot);
  thrum_state_destroy(state);
}

static void use_equilibrium(const thrum_model *model, fuzz_draw *draw) {
  double load[RANK_MOST], q[RANK_MOST] = {0}, mode[RANK_MOST];
  thrum_equilibrium_def def = thrum_default_equilibrium_def();
  thrum_equilibrium_report report;
  thrum_error error = {0};
  size_t size = 0;

  // few steps, because an input has only so much time
  draw_vector(draw, model->rank, 10, load);
  def.mode = mode;
  def.steps_max = 20;
  def.iterations_max = 20;
  if (thrum_equilibrium_size(model, &size, &error) < 0)
    return;

  void *workspace = block(size);
  const thrum_status status =
      thrum_equilibrium(model, &def, load, q, workspace, size, &report, &error);
  fuzz_check(status, &error);
  if (status >= 0)
    must_be_finite(q, model->rank);
  free(workspace);
}

/* Reads what is shown of a body, and what warns: positions, stress, the monitor. */
static void use_readouts(const thrum_model *model, fuzz_draw *draw) {
  double q[RANK_MOST];
  thrum_error error = {0};
  size_t size = 0;
  draw_vector(draw, model->rank, 0.1, q);

  const thrum_surface_def surface_def = {.triangles = model->tets,
                                         .triangle_count = model->tet_count};
  const thrum_surface *surface = NULL;
  if (thrum_surface_size(model, &surface_def, &size, &error) >= 0) {
    void *memory = block(size);
    float *out = block((size_t)model->vertex_count * 6 * sizeof *out);
    fuzz_check(thrum_surface_init(memory, size, model, &surface_def, &surface, &error), &error);
    if (surface != NULL && thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0,
                                                   model->vertex_count, out, 6, &error) >= 0)
      fuzz_check(thrum_surface_normals(surface, out, 6, out + 3, 6, &error), &error);
    free(out);
    free(memory);
  }

  const thrum_stress_points_def points_def = {0};
  const thrum_stress_points *points = NULL;
  if (thrum_stress_points_size(model, &points_def, &size, &error) >= 0) {
    void *memory = block(size);
    fuzz_check(thrum_stress_points_init(memory, size, model, &points_def, &points, &error), &error);
    if (points != NULL) {
      const int64_t count = thrum_stress_points_count(points);
      double *work = block((size_t)thrum_stress_points_work_count(points) * sizeof *work);
      double *values = block((size_t)count * 20 * sizeof *values);
      const thrum_stress_points_output output = {.strain = values,
                                                 .second_piola = values + 6 * count,
                                                 .cauchy = values + 12 * count,
                                                 .von_mises = values + 18 * count,
                                                 .stretch = values + 19 * count};
      fuzz_check(thrum_stress_points_read(points, q, work, &output, &error), &error);
      free(values);
      free(work);
    }
    free(memory);
  }

  thrum_monitor_def monitor_def = thrum_default_monitor_def();
  const thrum_monitor *monitor = NULL;
  if (thrum_monitor_size(model, &monitor_def, &size, &error) >= 0) {
    thrum_monitor_record record;
    void *memory = block(size);
    fuzz_check(thrum_monitor_init(memory, size, model, &monitor_def, &monitor, &error), &error);
    thrum_monitor_clear(&record);
    if (monitor != NULL)
      fuzz_check(thrum_monitor_look(monitor, q, &record, &error), &error);
    free(memory);
  }

  // displacements, of all vertices and of the modes
  double mean[3], length = 0, extents[RANK_MOST];
  int64_t vertex = 0;
  fuzz_check(thrum_displacement_mean(model, NULL, 0, q, mean, &error), &error);
  fuzz_check(thrum_mode_add(model, draw_index(draw, model->rank), 0.1, q, &error), &error);
  if (thrum_basis_extents(model, extents, &error) >= 0)
    fuzz_check(thrum_displacement_peak(model, extents, q, &length, &vertex, &error), &error);
}

/* A link of a body with another or with the world, whose end goes somewhere; a weld with the world
 * where nothing is left to draw. */
static void add_link(thrum_scene *scene, int32_t body, int32_t other, fuzz_draw *draw) {
  static const double times[] = {0, 0.006};
  double places[6];
  thrum_error error = {0};
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = (thrum_link_kind)(THRUM_LINK_WELD - draw_byte(draw) % 4);
  def.body = body;
  def.other = draw_byte(draw) % 2 == 0 ? -1 : other;
  def.stiffness = draw_byte(draw) % 8 == 0 ? draw_any(draw) : draw_above(draw, 1e6);
  def.damping = draw_above(draw, 100);
  def.length = draw_about(draw, 1);
  def.until = draw_byte(draw) % 2 == 0 ? INFINITY : draw_about(draw, 0.01);
  draw_vector(draw, 2, 1, def.axis);
  draw_vector(draw, 6, 1, places);
  if (draw_byte(draw) % 2 == 0)
    draw_vector(draw, 3, 1, def.place);

  // its end in the world moves
  def.path_times = times;
  def.path_places = places;
  def.path_count = def.other < 0 ? 2 : 0;
  int32_t number = 0;
  const thrum_status status = thrum_scene_add_link(scene, &def, &number, &error);
  fuzz_check(status, &error);

  // once more, of the sides that were made
  if (status < 0 || draw_byte(draw) % 4 != 1)
    return;
  fuzz_check(thrum_scene_link_made(scene, number, &def, &error), &error);
  fuzz_check(thrum_scene_add_link(scene, &def, NULL, &error), &error);
}

/* A second body that the first may touch, with numbers of contact that are drawn, most of them
 * right, and a level of detail for the first. */
static void add_another(thrum_scene *scene, const thrum_scene_body_def *first, int32_t body,
                        fuzz_draw *draw) {
  thrum_error error = {0};
  int32_t other = 0;
  thrum_scene_body_def def = *first;
  def.state.integrator = (thrum_integrator)draw_index(draw, 10);
  def.condense = 0;
  def.rank = 0;
  draw_vector(draw, 3, 1, def.position);
  draw_vector(draw, 3, 10, def.velocity);
  fuzz_check(thrum_scene_add_body(scene, &def, &other, &error), &error);

  thrum_contact_pairs_def contact = thrum_default_contact_pairs_def();
  contact.thickness = draw_byte(draw) % 4 == 0 ? draw_any(draw) : draw_above(draw, 0.1);
  contact.friction = draw_byte(draw) % 8 == 0 ? draw_any(draw) : draw_above(draw, 1);
  contact.restitution = draw_above(draw, 1);
  contact.touch_max = 1 + draw_byte(draw);
  contact.sweeps_max = 1 + draw_byte(draw) % 20;
  fuzz_check(thrum_scene_set_collisions(scene, &contact, &error), &error);

  if (draw_byte(draw) % 2 == 0)
    add_link(scene, other, body, draw);
  const thrum_scene_detail detail = {.masters = draw_index(draw, first->model->rank + 1),
                                     .beyond = draw_above(draw, 2),
                                     .still = draw_above(draw, 1),
                                     .jump = draw_above(draw, 1)};
  const double eye[3] = {draw_about(draw, 3), 0, 0};
  fuzz_check(thrum_scene_set_eye(scene, eye, &error), &error);
  fuzz_check(thrum_scene_set_detail(scene, body, &detail, &error), &error);
}

/* The queries of a scene about all its bodies together. */
static void look_at_all(thrum_scene *scene) {
  thrum_error error = {0};
  thrum_scene_overlap deepest;
  thrum_scene_account account;
  fuzz_check(thrum_scene_find_overlap(scene, &deepest, &error), &error);
  if (thrum_scene_account_get(scene, &account, &error) >= 0)
    must_be_finite(account.momentum, 3);
  thrum_scene_link link;
  for (int32_t n = 0; n < thrum_scene_link_count(scene); n++)
    fuzz_check(thrum_scene_link_get(scene, n, &link, &error), &error);
  fuzz_check(thrum_scene_update_detail(scene, &error), &error);
}

/* The body in a scene: loaded, on a floor, pulled, in wind, free where it can be. */
static void use_scene(const thrum_model *model, fuzz_draw *draw) {
  thrum_scene *scene = NULL;
  thrum_error error = {0};
  if (thrum_scene_create(0.003, &scene, &error) < 0)
    abort();

  int32_t touch[256], body = 0, pull = -1;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = model;
  def.state = draw_def(draw, model->rank);
  def.free = draw_byte(draw) % 2 == 0 && model->rigid != NULL;
  def.scale = draw_above(draw, 64);
  def.rank = draw_index(draw, model->rank + 1);
  def.touch = touch;
  while (def.touch_count < model->vertex_count && def.touch_count < 256) {
    touch[def.touch_count] = (int32_t)def.touch_count;
    def.touch_count++;
  }
  if (draw_byte(draw) % 4 == 0)
    def.condense = draw_index(draw, model->rank + 1);
  if (def.condense > 0)
    def.rank = 0;
  def.triangles = model->tets;
  def.triangle_count = model->tet_count;
  draw_vector(draw, 3, 1, def.velocity);

  // each addition may be refused, and the scene goes on without it
  thrum_status status = thrum_scene_add_body(scene, &def, &body, &error);
  fuzz_check(status, &error);
  if (status >= 0) {
    const double gravity[3] = {0, 0, draw_about(draw, 10)}, wind[3] = {draw_about(draw, 10), 0, 0};
    double target[3] = {1, 0, 0};
    thrum_obstacle floor = thrum_default_obstacle();
    floor.shape = (thrum_obstacle_shape)draw_index(draw, 3);
    floor.centre[2] = draw_about(draw, 1);
    const thrum_scene_load_def load = {
        .cookie = sizeof load,
        .kind = THRUM_SCENE_FORCE,
        .vector = {0, 0, draw_about(draw, 10)},
        .course = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 2}};
    fuzz_check(thrum_scene_set_gravity(scene, gravity, &error), &error);
    fuzz_check(
        thrum_scene_set_wind(scene, (thrum_scene_wind_def[1]){wind_of(wind, 1.2, 1)}, &error),
        &error);
    fuzz_check(thrum_scene_add_obstacle(scene, &floor, NULL, &error), &error);
    fuzz_check(thrum_scene_add_load(scene, body, &load, &error), &error);
    fuzz_check(thrum_scene_add_actuation(scene, body, draw_index(draw, 3), draw_about(draw, 1e3),
                                         &load.course, &error),
               &error);
    fuzz_check(thrum_scene_add_probe(scene, NULL, body, NULL, 0, &error), &error);
    fuzz_check(thrum_scene_pull_start(scene, body, draw_index(draw, model->vertex_count + 1),
                                      target, 100, -1, &pull, &error),
               &error);

    if (draw_byte(draw) % 2 == 0)
      add_another(scene, &def, body, draw);

    double q[RANK_MOST], place[6], velocity[3];
    thrum_scene_energies energies;
    for (int step = 0; step < STEPS; step++) {
      fuzz_check(thrum_scene_step(scene, &error), &error);
      if (thrum_scene_body_shape(scene, body, q, &error) >= 0)
        must_be_finite(q, model->rank);
      fuzz_check(thrum_scene_body_energies(scene, body, &energies, &error), &error);
      fuzz_check(thrum_scene_probe_get(scene, 0, place, velocity, &error), &error);
      look_at_all(scene);
    }
    fuzz_check(thrum_scene_set_rank(scene, body, draw_index(draw, model->rank + 1), &error),
               &error);
    fuzz_check(thrum_scene_reset(scene, &error), &error);
    fuzz_check(thrum_scene_step(scene, &error), &error);
  }
  thrum_scene_destroy(scene);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < PLAN_BYTES)
    return 0;
  fuzz_draw draw = {data, PLAN_BYTES};
  fuzz_opened opened = fuzz_open(data, size, &draw);
  const thrum_model *model = opened.model;
  if (model != NULL)
    switch (draw_byte(&draw) % 4) {
    case 0:
      use_state(model, &draw);
      break;
    case 1:
      use_equilibrium(model, &draw);
      break;
    case 2:
      use_readouts(model, &draw);
      break;
    default:
      use_scene(model, &draw);
    }
  fuzz_close(&opened);
  return 0;
}
