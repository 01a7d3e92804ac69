/* Fuzz target of the functions of a scene that fuzz_model_use does not call: solids, motions of the
 * ground, changes between steps, and all that a scene says. Each is called with bodies of every
 * kind of model, at numbers of bodies and of all else that exist and that do not. sources:
 * scene/*.c core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c contact/*.c SPDX-License-Identifier:
 * Apache-2.0 */
#include "tests/fuzz/fuzz_use.h"

#define STEPS 3

/* A number from -1 to a little beyond `count`. */
static int32_t draw_number(fuzz_draw *draw, int32_t count) {
  return (int32_t)draw_index(draw, count + 3) - 1;
}

/* One worker does all tasks in turn. */
static void run_in_turn(void *context, int32_t count,
                        void (*task)(void *of, int32_t index, int32_t worker), void *of) {
  (void)context;
  for (int32_t n = 0; n < count; n++)
    task(of, n, 0);
}

/* A body of the model, whose first vertices touch and whose first faces are its triangles. */
static void add_body(thrum_scene *scene, const thrum_model *model, fuzz_draw *draw) {
  thrum_error error = {0};
  int32_t touch[8], body = 0;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = model;
  def.state.integrator = (thrum_integrator)draw_index(draw, 10);
  def.free = draw_byte(draw) % 2 == 0 && model->rigid != NULL;
  def.coupled = draw_byte(draw) % 4 == 0 && def.free;
  def.touch = touch;
  while (def.touch_count < model->vertex_count && def.touch_count < 8) {
    touch[def.touch_count] = (int32_t)def.touch_count;
    def.touch_count++;
  }
  def.triangles = model->tets;
  def.triangle_count = model->tet_count;
  draw_vector(draw, 3, 1, def.position);
  draw_vector(draw, 3, 1, def.velocity);
  draw_vector(draw, 3, 1, def.spin);
  fuzz_check(thrum_scene_add_body(scene, &def, &body, &error), &error);
}

/* What stands around the bodies, and what moves under them. */
static void add_surroundings(thrum_scene *scene, fuzz_draw *draw) {
  static const double times[3] = {0, 0.01, 0.02};
  static double accelerations[9], velocities[9], positions[9];
  static const thrum_base_motion motion = {3, times, accelerations, velocities, positions};
  thrum_error error = {0};
  int32_t number = 0;
  thrum_scene_solid_def solid = thrum_default_scene_solid_def();
  solid.shape = (thrum_solid_shape)draw_index(draw, 6);
  solid.segments = 3 + (int32_t)draw_index(draw, 8);
  solid.radius = draw_above(draw, 1);
  solid.height = draw_above(draw, 1);
  draw_vector(draw, 3, 1, solid.position);
  draw_vector(draw, 3, 1, solid.velocity);
  fuzz_check(thrum_scene_add_solid(scene, &solid, &number, &error), &error);
  thrum_scene_solid found;
  fuzz_check(thrum_scene_solid_get(scene, draw_number(draw, thrum_scene_solid_count(scene)), &found,
                                   &error),
             &error);

  // the ground, by a record that is integrated and by a sine
  draw_vector(draw, 9, 1, accelerations);
  if (thrum_base_motion_check(&motion, &error) >= 0) {
    thrum_base_motion_integrate(3, times, accelerations, velocities, positions);
    fuzz_check(thrum_scene_add_base_motion_record(scene, &motion, &error), &error);
  }
  const thrum_load course = {.shape = (thrum_load_shape)draw_index(draw, 3),
                             .from = draw_about(draw, 0.01),
                             .until = draw_about(draw, 1),
                             .frequency = draw_above(draw, 50)};
  double amplitude[3];
  draw_vector(draw, 3, 1, amplitude);
  fuzz_check(thrum_scene_add_base_motion(scene, amplitude, &course, &error), &error);

  // an obstacle, which is then another one
  thrum_obstacle obstacle = thrum_default_obstacle();
  obstacle.centre[2] = draw_about(draw, 1);
  fuzz_check(thrum_scene_add_obstacle(scene, &obstacle, NULL, &error), &error);
  obstacle.shape = (thrum_obstacle_shape)draw_index(draw, 3);
  number = draw_number(draw, thrum_scene_obstacle_count(scene));
  fuzz_check(thrum_scene_set_obstacle(scene, number, &obstacle, &error), &error);
  fuzz_check(thrum_scene_obstacle_get(scene, number, &obstacle, &error), &error);
  const thrum_contact_pairs_def contact = thrum_default_contact_pairs_def();
  fuzz_check(thrum_scene_set_collisions(scene, &contact, &error), &error);
  fuzz_check(
      thrum_scene_set_workers(scene, (int32_t)draw_index(draw, 4), run_in_turn, NULL, &error),
      &error);
}

/* What may be changed between two steps, of one body. */
static void change(thrum_scene *scene, int32_t body, fuzz_draw *draw) {
  thrum_error error = {0};
  switch (draw_byte(draw) % 8) {
  case 0:
    fuzz_check(
        thrum_scene_set_damping(scene, body, draw_above(draw, 1), draw_above(draw, 1e-3), &error),
        &error);
    break;
  case 1:
    fuzz_check(thrum_scene_set_stiffness(scene, body, draw_above(draw, 64), &error), &error);
    break;
  case 2:
    fuzz_check(
        thrum_scene_set_integrator(scene, body, (thrum_integrator)draw_index(draw, 12), &error),
        &error);
    break;
  case 3:
    fuzz_check(thrum_scene_set_condensed(scene, body, draw_index(draw, RANK_MOST), &error), &error);
    break;
  case 4:
    fuzz_check(thrum_scene_set_dt(scene, draw_above(draw, 0.01), &error), &error);
    break;
  case 5: {
    const thrum_scene_detail detail = {1, draw_above(draw, 1), draw_above(draw, 1),
                                       draw_above(draw, 1)};
    fuzz_check(thrum_scene_set_detail(scene, body, &detail, &error), &error);
    break;
  }
  case 6:
    fuzz_check(
        thrum_scene_link_release(scene, draw_number(draw, thrum_scene_link_count(scene)), &error),
        &error);
    break;
  default:
    fuzz_check(thrum_scene_set_rank(scene, body, draw_index(draw, RANK_MOST), &error), &error);
  }
}

/* What a scene says of a body. */
static void look_at(thrum_scene *scene, int32_t body, const thrum_model *model, fuzz_draw *draw) {
  thrum_error error = {0};
  double q[RANK_MOST], matrix[16], position[3], velocity[3];
  thrum_scene_body_info info;
  thrum_scene_load_def load;
  thrum_scene_detail_report detail;
  static thrum_stepped_mode modes[RANK_MOST];
  if (thrum_scene_body(scene, body, &info, &error) >= 0) {
    const double said[] = {
        info.scale,        info.work_load,      info.work_base,    info.dissipated, info.mass,
        info.plastic_work, info.plastic_strain, info.contact.lost, info.stiffness,  info.density};
    must_be_finite(said, sizeof said / sizeof said[0]);
    if (thrum_scene_find_body(scene, info.name) < 0)
      abort();
  }
  fuzz_check(thrum_scene_body_stepped_modes(scene, body, modes, &error), &error);
  fuzz_check(thrum_scene_body_detail(scene, body, &detail, &error), &error);
  fuzz_check(thrum_scene_body_contact_load(scene, body, q, &error), &error);
  const int64_t index = draw_index(draw, thrum_scene_load_count(scene, body) + 2) - 1;
  thrum_scene_load_def_init(&load, sizeof load);
  fuzz_check(thrum_scene_load_get(scene, body, index, &load, &error), &error);
  if (thrum_scene_body_vertex(scene, body, draw_index(draw, model->vertex_count + 1), position,
                              velocity, &error) >= 0)
    must_be_finite(position, 3);
  thrum_scene_body_matrix(scene, body, matrix);
  must_be_finite(matrix, 16);
  if (thrum_scene_body_get(scene, body, q, NULL, &error) >= 0)
    must_be_finite(q, info.shown);

  // shown by a surface of the model
  const thrum_surface_def def = {0};
  const thrum_surface *surface = NULL;
  size_t size = 0;
  if (thrum_surface_size(model, &def, &size, &error) < 0)
    return;
  void *memory = block(size);
  float *out = block(3 * (size_t)model->vertex_count * sizeof *out);
  if (thrum_surface_init(memory, size, model, &def, &surface, &error) >= 0)
    fuzz_check(thrum_scene_body_positions(scene, body, surface, out, 3, &error), &error);
  free(out);
  free(memory);
}

/* What it says of the whole. */
static void look_around(thrum_scene *scene, fuzz_draw *draw) {
  thrum_error error = {0};
  double place[3], inside[3], axes[9], rotation[4];
  const double numbers[] = {thrum_scene_time(scene), thrum_scene_dt(scene)};
  must_be_finite(numbers, 2);
  thrum_scene_gravity(scene, place);
  thrum_scene_ground(scene, place);
  must_be_finite(place, 3);
  draw_vector(draw, 4, 1, rotation);
  fuzz_check(thrum_scene_axes(rotation, axes, &error), &error);
  fuzz_check(thrum_scene_to_body(rotation, place, inside, &error), &error);

  // touches and probes
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  const double said[] = {report.depth, report.normal, report.stored, report.lost, report.driven};
  must_be_finite(said, sizeof said / sizeof said[0]);
  thrum_pair_touch touch;
  fuzz_check(thrum_scene_collision_get(scene, draw_index(draw, 4), &touch, &error), &error);
  double force[3];
  const thrum_scene_thing from = {(thrum_scene_kind)draw_index(draw, 5),
                                  (int32_t)draw_number(draw, thrum_scene_body_count(scene))};
  fuzz_check(thrum_scene_contact_force(scene, draw_number(draw, thrum_scene_body_count(scene)),
                                       from, force, &error),
             &error);
  const int32_t probe = draw_number(draw, thrum_scene_probe_count(scene));
  if ((thrum_scene_probe_name(scene, probe) == NULL) != (thrum_scene_probe_body(scene, probe) < 0))
    abort();
  if (thrum_scene_steps(scene) < 0)
    abort();
}

/* A pull that moves, and a snapshot to which the scene goes back. */
static void pull_and_go_back(thrum_scene *scene, const thrum_model *model, fuzz_draw *draw) {
  thrum_error error = {0};
  int32_t pull = 0;
  double target[3], point[3], force[3];
  draw_vector(draw, 3, 1, target);
  fuzz_check(thrum_scene_pull_start(scene, draw_number(draw, 2),
                                    draw_index(draw, model->vertex_count + 1), target,
                                    draw_above(draw, 1000), -1, &pull, &error),
             &error);
  const int32_t number = draw_byte(draw) % 4 == 0 ? draw_number(draw, 2) : pull;
  const size_t size = thrum_scene_snapshot_size(scene);
  void *snapshot = block(size);
  const thrum_status kept = thrum_scene_snapshot(scene, snapshot, size, &error);
  fuzz_check(kept, &error);
  draw_vector(draw, 3, 1, target);
  fuzz_check(thrum_scene_pull_move(scene, number, target, &error), &error);
  fuzz_check(thrum_scene_step(scene, &error), &error);
  if (thrum_scene_pull_get(scene, number, point, force, &error) >= 0)
    must_be_finite(force, 3);

  // a snapshot that was just taken is of this scene
  if (kept >= 0 && thrum_scene_restore(scene, snapshot, size, &error) < 0)
    abort();
  fuzz_check(thrum_scene_pull_end(scene, number, &error), &error);
  free(snapshot);
}

/* The rows of each record lie within its def, which is the one that its function gives. */
static void read_records(int32_t number) {
  for (int record = -1; record < 8; record++) {
    int64_t count = 0;
    const size_t size = thrum_scene_record_size((thrum_scene_record)record);
    const thrum_field *rows = thrum_scene_fields((thrum_scene_record)record, &count);
    void *def = block(size);
    if (size > 0)
      thrum_scene_record_default((thrum_scene_record)record, def);
    for (int64_t n = 0; n < count; n++)
      if (rows[n].name == NULL || rows[n].offset >= size)
        abort();
    free(def);
  }
  const thrum_scene_wind_def wind = thrum_default_scene_wind_def();
  must_be_finite(wind.velocity, 3);
  if ((unsigned)thrum_scene_thing_of(number).kind > THRUM_SCENE_OBSTACLE)
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < PLAN_BYTES)
    return 0;
  fuzz_draw draw = {data, PLAN_BYTES};
  fuzz_opened opened = fuzz_open(data, size, &draw);
  const thrum_model *model = opened.model;
  thrum_scene *scene = NULL;
  thrum_error error = {0};
  if (model != NULL && thrum_scene_create(draw_above(&draw, 0.01), &scene, &error) >= 0) {
    if (draw_byte(&draw) % 2)
      add_surroundings(scene, &draw);
    add_body(scene, model, &draw);
    add_body(scene, model, &draw);
    const int32_t bodies = thrum_scene_body_count(scene);
    fuzz_check(thrum_scene_add_probe(scene, "probe", draw_number(&draw, bodies), NULL, 0, &error),
               &error);

    // steps, between which things change
    for (int step = 0; step < STEPS; step++) {
      fuzz_check(thrum_scene_step(scene, &error), &error);
      change(scene, draw_number(&draw, bodies), &draw);
      look_at(scene, draw_number(&draw, bodies), model, &draw);
      look_around(scene, &draw);
    }
    pull_and_go_back(scene, model, &draw);
    read_records((int32_t)draw_byte(&draw) - 2);
  }
  thrum_scene_destroy(scene);
  fuzz_close(&opened);
  return 0;
}
