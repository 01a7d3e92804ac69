/* Tests of scenes with obstacles, pulls, wind and free bodies: contact has the bits of the
 * library's own steps, free flight is exact, drag follows its closed form, and snapshots hold all
 * of it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "tests/support/outer_triangles.h"
#include "tests/support/scene_call.h"
#include "tests/support/scene_wind_def.h"
#include "thrum/displacement.h"
#include "thrum/external_load.h"

static const double down[3] = {0, 0, -9.81};

/* A block that is free or held at its left side, with the triangles of its surface. */
typedef struct fixture {
  body block;
  thrum_precomputed made;
  thrum_scene *scene;
  int32_t *triangles, *touch;
  int64_t triangle_count;
} fixture;

static int make(void **context, const char *fix) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->block = body_make("beam:4x3x2@0.4x0.3x0.2,split=6", fix);
  f->made = body_precompute(&f->block, 4, 8);
  const thrum_model *m = &f->made.model;
  f->triangles = outer_triangles(&f->block.mesh, &f->triangle_count);
  f->touch = need((size_t)m->vertex_count, sizeof *f->touch);
  for (int64_t v = 0; v < m->vertex_count; v++)
    f->touch[v] = (int32_t)v;
  *context = f;
  return thrum_scene_create(0.002, &f->scene, &failure) < 0;
}

static int make_free(void **context) {
  return make(context, NULL);
}
static int make_held(void **context) {
  return make(context, "x<0.001");
}

static int teardown(void **context) {
  fixture *f = *context;
  thrum_scene_destroy(f->scene);
  thrum_precomputed_free(&f->made);
  body_free(&f->block);
  free(f->triangles);
  free(f->touch);
  free(f);
  return 0;
}

static thrum_scene_body_def def_of(const fixture *f) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->made.model;
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  def.touch = f->touch;
  def.touch_count = f->made.model.vertex_count;
  return def;
}

static void steps(thrum_scene *scene, int count) {
  for (int k = 0; k < count; k++)
    MUST(thrum_scene_step(scene, &failure));
}

static void a_free_body_falls_as_a_stone(void **context) {
  fixture *f = *context;

  // a free body, larger and denser than its model, with a velocity and under gravity
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.scale = 2;
  def.density = 3;
  def.velocity[0] = 2;
  def.position[2] = 5;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));

  // the mass follows density and volume
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  const double density = f->made.model.material[2];
  assert_close(info.mass, 3 * density * 8 * 0.4 * 0.3 * 0.2, 1e-10);

  // a vertex and the energies, before and after half a second
  double before[3], x[3], v[3];
  MUST(thrum_scene_body_vertex(f->scene, 0, 7, before, NULL, &failure));
  thrum_scene_energies first, last;
  MUST(thrum_scene_body_energies(f->scene, 0, &first, &failure));
  steps(f->scene, 250);
  MUST(thrum_scene_body_vertex(f->scene, 0, 7, x, v, &failure));
  MUST(thrum_scene_body_energies(f->scene, 0, &last, &failure));

  // every vertex moves on the parabola of a point mass
  const double t = 0.5;
  assert_close(x[0] - before[0], 2 * t, 1e-9);
  assert_close(x[2] - before[2], -0.5 * 9.81 * t * t, 1e-9);
  assert_close(v[2], -9.81 * t, 1e-9);

  // without forces other than gravity the total energy is constant
  assert_true(fabs(last.total - first.total) < 1e-9 * last.kinetic);
}

/* A constant force acts for a short time on one end of a free bar, which lies rotated in the world:
 * momentum and angular momentum about the centre at rest are the integrals of force and torque. */
static void a_shove_moves_and_turns_a_free_body(void **context) {
  fixture *f = *context;

  // a stiff bar, so that it moves nearly as a rigid body
  const double force[3] = {0, 0, 0.02};
  const int32_t corner = (int32_t)(f->made.model.vertex_count - 1);
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.scale = 2;
  def.stiffness = 1e4;
  def.position[0] = 3;
  def.rotation[0] = 0.8;
  def.rotation[3] = 0.6;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));

  // a force at one corner for the first 0.1 s
  const thrum_scene_load_def load = {.cookie = sizeof load,
                                     .kind = THRUM_SCENE_FORCE,
                                     .vector = {force[0], force[1], force[2]},
                                     .vertices = &corner,
                                     .count = 1,
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = 0.1}};
  MUST(thrum_scene_add_load(f->scene, 0, &load, &failure));

  // the arm of the force is measured from the mean of the vertices
  double before[3], after[3], v[3], centre[3], middle[3];
  MUST(thrum_scene_body_vertex(f->scene, 0, corner, before, NULL, &failure));
  MUST(thrum_scene_add_probe(f->scene, "all", 0, NULL, 0, &failure));
  MUST(thrum_scene_probe_get(f->scene, 0, centre, NULL, &failure));

  // the momentum is force times time
  steps(f->scene, 50);
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  MUST(thrum_scene_body_vertex(f->scene, 0, corner, after, v, &failure));
  MUST(thrum_scene_probe_get(f->scene, 0, middle, v, &failure));
  // mesh and bar are symmetric: the mean of the vertices is the centre of mass
  assert_close(v[2], 0.02 * 0.1 / info.mass, 1e-3);

  // the kinetic energy of the rotation follows from the angular momentum about each axis
  thrum_scene_energies e;
  MUST(thrum_scene_body_energies(f->scene, 0, &e, &failure));
  const double arm[3] = {before[0] - centre[0], before[1] - centre[1], 0};
  // a bar of sides 0.8, 0.6, 0.4 is rotated about z; its own x and y axes carry the torque
  const double turn = 2 * acos(0.8), c = cos(turn), n = sin(turn);
  const double x = c * arm[0] + n * arm[1], y = -n * arm[0] + c * arm[1];
  const double lx = y * 0.002, ly = -x * 0.002;
  const double jx = info.mass * (0.36 + 0.16) / 12, jy = info.mass * (0.64 + 0.16) / 12;
  const double whole = 0.5 * info.mass * v[2] * v[2] + 0.5 * lx * lx / jx + 0.5 * ly * ly / jy;
  assert_close(e.kinetic + e.potential, whole, 2e-2);

  // without forces the rotation goes on with its energy
  const double kept = e.total;
  steps(f->scene, 2000);
  MUST(thrum_scene_body_energies(f->scene, 0, &e, &failure));
  assert_close(e.total, kept, 1e-6);
}

static void a_surface_that_is_not_there_is_refused(void **context) {
  fixture *f = *context;
  for (int n = 0; n < 2; n++) {
    thrum_scene_body_def def = def_of(f);
    def.triangles = NULL;
    def.triangle_count = n == 0;
    def.touch = NULL;
    def.touch_count = n == 1;
    assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(failure.message, "is NULL"));
  }
}

static void a_body_beyond_all_numbers_is_refused_with_the_reason(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f);
  def.free = 1;

  // the message names the scale and not the spin, which is 0 and right
  def.scale = 1e30;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_BAD_VALUE);
  assert_non_null(strstr(failure.message, "scale"));
  def.scale = 1;
  def.spin[2] = 1e308;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_BAD_VALUE);
  assert_non_null(strstr(failure.message, "angular momentum"));
}

static void a_spin_is_that_of_the_def_and_stays(void **context) {
  fixture *f = *context;

  // a free body with a placement, factors of length and density, and an angular velocity
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.scale = 0.5;
  def.density = 2;
  def.rotation[0] = 0.6;
  def.rotation[1] = 0.8;
  def.spin[0] = 1.5;
  def.spin[1] = 0.2;
  def.spin[2] = -0.7;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  MUST(thrum_scene_add_probe(f->scene, "all", 0, NULL, 0, &failure));

  // the initial velocity of a vertex is spin times arm
  double x[3], v[3], centre[3];
  MUST(thrum_scene_probe_get(f->scene, 0, centre, NULL, &failure));
  MUST(thrum_scene_body_vertex(f->scene, 0, 3, x, v, &failure));
  const double arm[3] = {x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]};
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    assert_true(fabs(v[axis] - (def.spin[next] * arm[last] - def.spin[last] * arm[next])) < 1e-10);
  }

  // the energy of the free rotation is constant
  thrum_scene_energies first, last;
  MUST(thrum_scene_body_energies(f->scene, 0, &first, &failure));
  steps(f->scene, 3000);
  MUST(thrum_scene_body_energies(f->scene, 0, &last, &failure));
  assert_close(last.total, first.total, 1e-9);

  // a reset puts the vertices back bit for bit
  MUST(thrum_scene_reset(f->scene, &failure));
  double again[3];
  MUST(thrum_scene_body_vertex(f->scene, 0, 3, again, NULL, &failure));
  assert_memory_equal(x, again, sizeof x);
}

static void a_drop_ends_on_the_floor(void **context) {
  fixture *f = *context;

  // a damped free body above a floor
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.position[2] = 0.3;
  def.state.damping_alpha = 5;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  const thrum_obstacle floor = thrum_default_obstacle();
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  MUST(thrum_scene_add_probe(f->scene, "all", 0, NULL, 0, &failure));

  // long enough to fall, bounce and come to rest
  steps(f->scene, 2000);
  thrum_scene_body_info info;
  double x[3], v[3];
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  MUST(thrum_scene_probe_get(f->scene, 0, x, v, &failure));

  // the lowest vertices of the mesh lie at its z = 0
  const double *first = f->made.model.vertices;
  double height = 0, least = 1;
  for (int64_t n = 0; n < f->made.model.vertex_count; n++) {
    height += first[3 * n + 2] / (double)f->made.model.vertex_count;
    least = fmin(least, first[3 * n + 2]);
  }

  // the body rests on the floor with its lowest vertices
  assert_true(fabs(x[2] - (height - least)) < 5e-3);
  assert_true(fabs(v[2]) < 1e-3);
  assert_true(info.contact.touching > 0);

  // the floor carries the body's weight
  assert_close(info.contact.normal, info.mass * 9.81, 0.02);
}

/* The scene's steps are compared with those of thrum_contact_step over the whole model. */
static void contact_has_the_bits_of_the_library_alone(void **context) {
  fixture *f = *context;

  // without triangles the contact has no areas, like that of the library below
  const thrum_model *m = &f->made.model;
  thrum_scene_body_def def = def_of(f);
  def.triangles = NULL;
  def.triangle_count = 0;

  // the library is given the vertices that can move
  int32_t *moving = need((size_t)m->vertex_count, sizeof *moving);
  int64_t moving_count = 0;
  for (int32_t v = 0; v < m->vertex_count; v++)
    if (m->fixed[v] != 7)
      moving[moving_count++] = v;

  // the scene's run: a body that starts in its first mode, close above a floor
  def.start_mode = 1;
  def.start_amplitude = 0.05;
  thrum_obstacle floor = thrum_default_obstacle();
  floor.centre[2] = m->vertices[2] - 0.11;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  steps(f->scene, 150);

  // the library's state, from the same initial shape and under the same gravity
  thrum_state_def alone = thrum_default_state_def();
  alone.dt = 0.002;
  size_t size = 0;
  MUST(thrum_state_size(m, &alone, &size, &failure));
  thrum_state *state = NULL;
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  MUST(thrum_state_init(memory, size, m, &alone, &state, &failure));
  double *q = need((size_t)m->rank, sizeof *q), *load = need((size_t)m->rank, sizeof *load);
  MUST(thrum_mode_add(m, 0, 0.05, q, &failure));
  MUST(thrum_state_set(m, state, q, NULL, &failure));
  MUST(thrum_load_add_gravity(m, down, load, &failure));

  // the library's contact over the same vertices
  thrum_contact_def contact_def = thrum_default_contact_def();
  contact_def.vertices = moving;
  contact_def.vertex_count = moving_count;
  thrum_contact *contact = NULL;
  MUST(thrum_contact_size(m, state, &contact_def, &size, &failure));
  void *block = aligned_alloc(64, (size + 63) / 64 * 64);
  MUST(thrum_contact_init(block, size, m, state, &contact_def, &contact, &failure));

  // the same steps against the same floor end in the same bits
  const thrum_contact_environment environment = {
      .obstacles = &floor, .obstacle_count = 1, .load = load};
  for (int k = 0; k < 150; k++)
    MUST(thrum_contact_step(m, state, contact, &environment, &failure));
  MUST(thrum_state_get(m, state, q, NULL, &failure));
  MUST(thrum_scene_body_get(f->scene, 0, load, NULL, &failure));
  assert_memory_equal(q, load, (size_t)m->rank * sizeof *q);

  free(moving);
  free(q);
  free(load);
  free(memory);
  free(block);
}

static void a_pull_holds_its_point_and_lets_go(void **context) {
  fixture *f = *context;

  // a damped body, pulled at its last vertex to a place above rest
  thrum_scene_body_def def = def_of(f);
  def.state.damping_alpha = 20;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  const int64_t tip = f->made.model.vertex_count - 1;
  double rest[3], target[3], point[3], force[3];
  MUST(thrum_scene_body_vertex(f->scene, 0, tip, rest, NULL, &failure));
  memcpy(target, rest, sizeof target);
  target[2] += 0.01;
  int32_t pull = -1;
  MUST(thrum_scene_pull_start(f->scene, 0, tip, rest, 1e9, -1, &pull, &failure));
  MUST(thrum_scene_pull_move(f->scene, pull, target, &failure));

  steps(f->scene, 2000);
  MUST(thrum_scene_pull_get(f->scene, pull, point, force, &failure));
  // a spring far stiffer than the body brings the point to its target
  assert_true(fabs(point[2] - target[2]) < 1e-4);
  assert_true(force[2] > 0);

  // a pull ends once, and the released body returns to rest
  MUST(thrum_scene_pull_end(f->scene, pull, &failure));
  assert_true(thrum_scene_pull_end(f->scene, pull, &failure) < 0);
  steps(f->scene, 4000);
  MUST(thrum_scene_body_vertex(f->scene, 0, tip, point, NULL, &failure));
  assert_true(fabs(point[2] - rest[2]) < 1e-6);

  // the number of pulls is limited, and pulls outlast a change of the rank
  for (int n = 0; n < THRUM_SCENE_PULLS; n++)
    MUST(thrum_scene_pull_start(f->scene, 0, n, rest, 1, 0, NULL, &failure));
  assert_true(thrum_scene_pull_start(f->scene, 0, 1, rest, 1, 0, NULL, &failure) < 0);
  MUST(thrum_scene_set_rank(f->scene, 0, 4, &failure));
  steps(f->scene, 5);
}

/* A box in a wind along x has the drag 1/2 rho C_d |w|^2 times its side, on any mesh. */
static void wind_on_a_box_is_its_frontal_drag(void **context) {
  fixture *f = *context;

  // a free box with twice the model's lengths
  const double wind[3] = {12, 0, 0};
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.scale = 2;
  MUST(
      thrum_scene_set_wind(f->scene, (thrum_scene_wind_def[1]){wind_of(wind, 1.2, 1.1)}, &failure));
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));

  // the acceleration of the first step is the drag at rest over the mass
  thrum_scene_body_info info;
  double x[3], v[3];
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  MUST(thrum_scene_add_probe(f->scene, NULL, 0, NULL, 0, &failure));
  steps(f->scene, 1);
  MUST(thrum_scene_probe_get(f->scene, 0, x, v, &failure));
  const double force = 0.5 * 1.2 * 1.1 * 144 * 4 * 0.3 * 0.2;
  // the mean over the vertices differs from the centre of mass by the strain of the first step
  assert_close(v[0], force * 0.002 / info.mass, 0.2);

  // after many steps the velocity has approached the wind as in the closed form
  steps(f->scene, 20000);
  MUST(thrum_scene_probe_get(f->scene, 0, x, v, &failure));
  // v' = c (w - v)^2 has the solution w - v = w / (1 + c w t)
  const double c = 0.5 * 1.2 * 1.1 * 4 * 0.3 * 0.2 / info.mass, t = 20001 * 0.002;
  assert_close(v[0], 12 - 12 / (1 + c * 12 * t), 1e-3);

  // time steps in which the drag would stop the body many times over stay stable
  MUST(thrum_scene_set_dt(f->scene, 0.05, &failure));
  MUST(
      thrum_scene_set_wind(f->scene, (thrum_scene_wind_def[1]){wind_of(wind, 1e6, 1.1)}, &failure));
  steps(f->scene, 200);
  MUST(thrum_scene_probe_get(f->scene, 0, x, v, &failure));
  assert_close(v[0], 12, 0.01);
}

static void an_energy_beyond_numbers_is_refused(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.velocity[0] = 1e30;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  MUST(thrum_scene_step(f->scene, &failure));
  MUST(thrum_scene_set_gravity(f->scene, (const double[3]){1e300, 0, 0}, &failure));
  thrum_scene_energies e = {.total = 3};
  assert_int_equal(thrum_scene_body_energies(f->scene, 0, &e, &failure), THRUM_NOT_FINITE);
  assert_true(e.total == 3);
}

/* A body that leaves the finite numbers as a whole fails, and stays where it was. */
static void a_place_beyond_numbers_is_refused(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.velocity[0] = 1e31;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_BAD_VALUE);
  def.velocity[0] = 1e30;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  def.touch = NULL;
  def.touch_count = 0;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  MUST(thrum_scene_set_dt(f->scene, 1e80, &failure));

  // with touches and without
  assert_int_equal(thrum_scene_step(f->scene, &failure), THRUM_NOT_FINITE);
  for (int32_t n = 0; n < 2; n++) {
    thrum_scene_body_info info;
    double x[3];
    MUST(thrum_scene_body(f->scene, n, &info, &failure));
    assert_int_equal(info.status, THRUM_NOT_FINITE);
    MUST(thrum_scene_body_vertex(f->scene, n, 0, x, NULL, &failure));
    assert_true(isfinite(x[0] + x[1] + x[2]));
  }
}

static void no_wind_is_too_strong_for_dt(void **context) {
  fixture *f = *context;

  // a soft body in a wind far beyond what explicit drag would bear
  const double wind[3] = {0, 300, 100};
  thrum_scene_body_def def = def_of(f);
  def.stiffness = 1e3;
  MUST(thrum_scene_set_wind(f->scene, (thrum_scene_wind_def[1]){wind_of(wind, 1000, 2)}, &failure));
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  for (int k = 0; k < 2000; k++)
    if (thrum_scene_step(f->scene, &failure) < 0)
      fail_msg("%s", failure.message);

  // the kinetic energy stays bounded over as many steps again
  thrum_scene_energies e;
  MUST(thrum_scene_body_energies(f->scene, 0, &e, &failure));
  thrum_scene_energies later;
  steps(f->scene, 2000);
  MUST(thrum_scene_body_energies(f->scene, 0, &later, &failure));
  assert_true(isfinite(later.total) && later.kinetic < 10 * (e.kinetic + e.potential));
}

static void a_snapshot_holds_contact_and_ways(void **context) {
  fixture *f = *context;

  // a free body that falls on a rising floor
  thrum_scene_body_def def = def_of(f);
  def.free = 1;
  def.position[2] = 0.05;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  thrum_obstacle floor = thrum_default_obstacle();
  floor.velocity[2] = 0.1;
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  steps(f->scene, 80);

  // a snapshot in the middle, and the state at the end of the same run
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *kept = malloc(size), *end = malloc(size), *again = malloc(size);
  assert_true(kept && end && again);
  MUST(thrum_scene_snapshot(f->scene, kept, size, &failure));
  steps(f->scene, 80);
  MUST(thrum_scene_snapshot(f->scene, end, size, &failure));

  // from the restored snapshot, contact and obstacle end in the same bits
  MUST(thrum_scene_restore(f->scene, kept, size, &failure));
  steps(f->scene, 80);
  MUST(thrum_scene_snapshot(f->scene, again, size, &failure));
  assert_memory_equal(end, again, size);

  // the floor has moved with its velocity for the steps that count
  MUST(thrum_scene_obstacle_get(f->scene, 0, &floor, &failure));
  assert_true(fabs(floor.centre[2] - 160 * 0.002 * 0.1) < 1e-12);

  // a reset brings back the floor and starts the count of contact steps again
  MUST(thrum_scene_reset(f->scene, &failure));
  MUST(thrum_scene_obstacle_get(f->scene, 0, &floor, &failure));
  assert_true(floor.centre[2] == 0);
  steps(f->scene, 160);
  MUST(thrum_scene_snapshot(f->scene, again, size, &failure));
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_true(info.contact.steps == 160);

  free(kept);
  free(end);
  free(again);
}

static void what_does_not_touch_has_no_rows(void **context) {
  fixture *f = *context;

  // without an obstacle a body needs no memory for contact
  thrum_scene_body_def def = def_of(f);
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  const size_t bare = info.bytes;

  // with a floor it holds the basis rows of the vertices that may touch it
  const thrum_obstacle floor = thrum_default_obstacle();
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  // one layer of vertices in five is held, and some vertices lie inside
  const size_t rows = (size_t)(3 * f->made.model.vertex_count * f->made.model.rank);
  assert_true(info.bytes > bare + rows * sizeof(double) / 4);

  // a free body must be able to touch; a held body without contact vertices holds no rows
  def.touch_count = 0;
  def.free = 1;
  assert_true(thrum_scene_add_body(f->scene, &def, NULL, &failure) < 0);
  def.free = 0;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  MUST(thrum_scene_body(f->scene, 1, &info, &failure));
  assert_true(info.bytes <= bare);
}

#define FREE(name) cmocka_unit_test_setup_teardown(name, make_free, teardown)
#define HELD(name) cmocka_unit_test_setup_teardown(name, make_held, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      // loads and spins, drops, pulls and wind, snapshots
      FREE(a_shove_moves_and_turns_a_free_body),
      FREE(a_body_beyond_all_numbers_is_refused_with_the_reason),
      FREE(a_surface_that_is_not_there_is_refused),
      FREE(a_spin_is_that_of_the_def_and_stays),
      FREE(a_free_body_falls_as_a_stone),
      FREE(a_drop_ends_on_the_floor),
      HELD(contact_has_the_bits_of_the_library_alone),
      HELD(a_pull_holds_its_point_and_lets_go),
      FREE(wind_on_a_box_is_its_frontal_drag),
      FREE(an_energy_beyond_numbers_is_refused),
      FREE(a_place_beyond_numbers_is_refused),
      HELD(no_wind_is_too_strong_for_dt),
      FREE(a_snapshot_holds_contact_and_ways),
      HELD(what_does_not_touch_has_no_rows),
  };

  return cmocka_run_group_tests(tests, NULL, NULL);
}
