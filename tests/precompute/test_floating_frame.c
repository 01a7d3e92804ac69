/* Free bodies whose rotation and shape act on each other (design 20): what is conserved, what the
 * full order does, tops that deform.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "core/base/vec3.h"
#include "precompute/full/full.h"
#include "tests/support/sanitized.h"
#include "thrum/floating_frame.h"
#include "thrum/polynomial.h"

/* A body with its model, state and frame. */
typedef struct flyer {
  body b;
  thrum_precomputed result;
  const thrum_model *model;
  thrum_inertia *inertia;
  thrum_state *state;
  thrum_rigid_frame frame;
  double *work, *q, *p;
} flyer;

static void must(thrum_status status, const thrum_error *error) {
  if (status < 0)
    fail_msg("%s", error->message);
}

/* A flyer of a mesh at rest in its shape. */
static void flyer_make(body b, int64_t modes, int64_t rank, const thrum_state_def *def, flyer *f) {
  thrum_error error = {0};
  *f = (flyer){.b = b, .result = body_precompute(&b, modes, rank)};
  f->model = &f->result.model;
  must(thrum_inertia_create(f->model, 0, NULL, &f->inertia, &error), &error);
  must(thrum_state_create(f->model, def, &f->state, &error), &error);
  must(thrum_rigid_frame_of(f->model, &f->frame, &error), &error);
  f->work = need(thrum_floating_frame_work_count(f->inertia), sizeof *f->work);
  f->q = need((size_t)f->model->rank, sizeof *f->q);
  f->p = need((size_t)f->model->rank, sizeof *f->p);
}

static void flyer_free(flyer *f) {
  thrum_state_destroy(f->state);
  thrum_inertia_destroy(f->inertia);
  thrum_precomputed_free(&f->result);
  body_free(&f->b);
  free(f->work);
  free(f->q);
  free(f->p);
}

/* Puts f->q and f->p into the state, and the frame into a spin about the axes of the world. */
static void flyer_start(flyer *f, const double spin[3]) {
  thrum_error error = {0};
  must(thrum_state_set(f->model, f->state, f->q, f->p, &error), &error);
  must(thrum_floating_frame_settle(f->inertia, f->q, f->p, &f->frame, f->work, &error), &error);
  thrum_floating_frame_spin(NULL, spin, &f->frame);
}

static void flyer_step(flyer *f) {
  static const double none[3] = {0};
  thrum_error error = {0};
  const thrum_status status = thrum_floating_frame_step(f->model, f->state, f->inertia, NULL,
                                                        &f->frame, none, NULL, f->work, &error);
  must(status, &error);
  assert_int_equal(status, THRUM_OK);
}

static double flyer_energy(const flyer *f) {
  thrum_energies energies;
  assert_int_equal(thrum_state_energies(f->model, f->state, &energies, NULL), THRUM_OK);
  return energies.kinetic + energies.potential + thrum_rigid_frame_energy(&f->frame, NULL);
}

/* The momentum in the world of the deformed body with its spin, I w + G v. */
static void flyer_momentum(flyer *f, double momentum[3]) {
  thrum_rigid_frame now = f->frame;
  double spin[3];
  thrum_rigid_frame_velocity(&f->frame, NULL, spin);
  assert_int_equal(thrum_state_get(f->model, f->state, f->q, f->p, NULL), THRUM_OK);
  assert_int_equal(thrum_floating_frame_settle(f->inertia, f->q, f->p, &now, f->work, NULL),
                   THRUM_OK);
  thrum_floating_frame_spin(NULL, spin, &now);
  memcpy(momentum, now.momentum, sizeof now.momentum);
}

/* --- the inertia ------------------------------------------------------------------------------ */

/* Kinetic energy and angular momentum about the centre of the moving mesh, by its mass matrix. */
static double mesh_motion(const flyer *f, const double spin[3], double momentum[3]) {
  const thrum_model *model = f->model;
  const int64_t n = 3 * model->vertex_count;
  thrum_fem fem = body_fem(&f->b);
  thrum_sparse k = {0}, m = {0};
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);

  // places and velocities of the vertices, w x (x - c) + U p
  double *x = need((size_t)n, sizeof *x), *v = need((size_t)n, sizeof *v);
  double *image = need((size_t)n, sizeof *image);
  for (int64_t c = 0; c < n; c++)
    x[c] = model->vertices[c] - f->frame.centre[c % 3] +
           dot_of(model->basis + c * model->rank, f->q, model->rank);
  for (int64_t node = 0; node < model->vertex_count; node++) {
    thrum_cross3(spin, x + 3 * node, v + 3 * node);
    for (int axis = 0; axis < 3; axis++)
      v[3 * node + axis] +=
          dot_of(model->basis + (3 * node + axis) * model->rank, f->p, model->rank);
  }

  thrum_sparse_product(&m, v, 1, image);
  memset(momentum, 0, 3 * sizeof *momentum);
  for (int64_t node = 0; node < model->vertex_count; node++) {
    double part[3];
    thrum_cross3(x + 3 * node, image + 3 * node, part);
    for (int axis = 0; axis < 3; axis++)
      momentum[axis] += part[axis];
  }
  const double energy = 0.5 * dot_of(v, image, n);
  free(x);
  free(v);
  free(image);
  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  thrum_fem_free(&fem);
  return energy;
}

static void frame_and_shape_have_the_energy_and_momentum_of_the_mesh(void **state) {
  (void)state;
  const double spin[3] = {3, -2, 5};
  const thrum_state_def def = thrum_default_state_def();
  for (int quadratic = 0; quadratic < 2; quadratic++) {
    body b = quadratic ? body_quadratic("beam:3x2x1@0.9x0.5x0.3", NULL, 0.02, 0.01)
                       : body_make("beam:5x2x2@1x0.3x0.2", NULL);
    flyer f;
    flyer_make(b, 6, 10, &def, &f);
    for (int64_t i = 0; i < f.model->rank; i++) {
      f.q[i] = 0.3 * random_number();
      f.p[i] = 2 * random_number();
    }
    flyer_start(&f, spin);

    // the kinetic energy is that of the frame and 1/2 |p|^2
    double momentum[3];
    const double energy = mesh_motion(&f, spin, momentum);
    const double of_shape = 0.5 * dot_of(f.p, f.p, f.model->rank);
    assert_close(thrum_rigid_frame_energy(&f.frame, NULL) + of_shape, energy, 1e-11);
    assert_near(f.frame.momentum, momentum, 3, 1e-10);

    // the spin is the one that was asked for
    double now[3], tensor[9], product[9];
    thrum_rigid_frame_velocity(&f.frame, NULL, now);
    assert_near(now, spin, 3, 1e-12);
    thrum_inertia_tensor(f.inertia, f.q, tensor, f.work);
    thrum_multiply3(tensor, f.frame.inverse, product);
    for (int n = 0; n < 9; n++)
      assert_true(fabs(product[n] - (n % 4 == 0)) <= 1e-12);
    flyer_free(&f);
  }
}

/* A basis of the lumped mass has the inertia of points at the vertices. */
static void a_lumped_body_has_the_inertia_of_its_vertices(void **state) {
  (void)state;
  thrum_error error = {0};
  body b = body_make("beam:4x2x2@1x0.3x0.2", NULL);
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 4;
  options.rank = 6;
  options.mass = THRUM_MASS_LUMPED;
  thrum_precomputed result = {0};
  must(thrum_precompute(&b.mesh, b.fixed, &options, &result, &error), &error);
  const thrum_model *model = &result.model;
  thrum_inertia *inertia = NULL;
  must(thrum_inertia_create(model, 0, NULL, &inertia, &error), &error);

  // a deformed shape, by its vertices and by the inertia
  thrum_fem fem = body_fem(&b);
  double *mass = need((size_t)model->vertex_count, sizeof *mass), *q = random_vector(6, 1);
  double *work = need(thrum_floating_frame_work_count(inertia), sizeof *work);
  double tensor[9], expected[9] = {0};
  thrum_fem_vertex_mass(&fem, THRUM_MASS_LUMPED, mass);
  thrum_rigid_frame frame;
  must(thrum_rigid_frame_of(model, &frame, &error), &error);
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double x[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = model->vertices[3 * v + axis] - frame.centre[axis] +
                dot_of(model->basis + (3 * v + axis) * 6, q, 6);
    for (int n = 0; n < 9; n++)
      expected[n] += mass[v] * ((n % 4 == 0 ? thrum_dot3(x, x) : 0) - x[n / 3] * x[n % 3]);
  }
  thrum_inertia_tensor(inertia, q, tensor, work);
  assert_near(tensor, expected, 9, 1e-10);

  free(mass);
  free(q);
  free(work);
  thrum_inertia_destroy(inertia);
  thrum_fem_free(&fem);
  thrum_precomputed_free(&result);
  body_free(&b);
}

/* --- conservation ----------------------------------------------------------------------------- */

static void a_soft_body_keeps_energy_and_momentum_over_many_steps(void **state) {
  (void)state;
  thrum_state_def def = thrum_default_state_def();
  def.dt = 2e-3;
  flyer f;
  flyer_make(body_make("beam:4x2x1@1x0.4x0.2", NULL), 4, 6, &def, &f);

  // a wild start: a soft body that spins at a third of its lowest frequency and swings
  const double lowest = sqrt(f.model->omega2[0]);
  for (int64_t i = 0; i < f.model->rank; i++)
    f.p[i] = 0.5 * random_number() * sqrt(f.result.mass);
  const double spin[3] = {0.1 * lowest, 0.3 * lowest, -0.1 * lowest};
  def.dt = 0.2 / lowest;
  assert_int_equal(thrum_state_set_dt(f.model, f.state, def.dt, NULL), THRUM_OK);
  flyer_start(&f, spin);

  double worst = 0, turned = 0, momentum[3];
  const double energy = flyer_energy(&f);
  const int steps = LENGTH_OF_RUN(100000, 2000);
  for (int n = 0; n < steps; n++) {
    flyer_step(&f);
    if (n % 100 != 99)
      continue;
    worst = fmax(worst, fabs(flyer_energy(&f) / energy - 1));
    flyer_momentum(&f, momentum);
    for (int axis = 0; axis < 3; axis++)
      turned = fmax(turned, fabs(momentum[axis] - f.frame.momentum[axis]));
  }
  const thrum_state_report report = thrum_state_report_get(f.state);
  print_message("%d steps: energy to %.1e, momentum to %.1e, %.1f iterations a step\n", steps,
                worst, turned / norm_of(f.frame.momentum, 3), (double)report.iterations / steps);
  assert_true(worst <= 1e-9 && turned <= 1e-9 * norm_of(f.frame.momentum, 3));
  flyer_free(&f);
}

/* The same bits, whatever evaluates the model. */
static void all_kernels_step_to_the_same_bits(void **state) {
  (void)state;
  double reference = 0;
  for (int kernel = THRUM_KERNEL_BEST; kernel <= THRUM_KERNEL_REFERENCE; kernel++) {
    thrum_state_def def = thrum_default_state_def();
    def.kernel = (thrum_kernel_id)kernel;
    flyer f;
    flyer_make(body_make("beam:4x2x1@1x0.4x0.2", NULL), 4, 9, &def, &f);
    const double spin[3] = {3, -20, 5};
    f.p[0] = 1;
    flyer_start(&f, spin);
    for (int n = 0; n < 50; n++)
      flyer_step(&f);

    // the energy has all that moves in it
    if (kernel == THRUM_KERNEL_BEST)
      reference = flyer_energy(&f) + f.frame.attitude[1];
    assert_true(flyer_energy(&f) + f.frame.attitude[1] == reference);
    flyer_free(&f);
  }
}

/* --- motions that are known ------------------------------------------------------------------- */

/* Where the vertices are, the centre of mass at rest. */
static void flyer_places(flyer *f, double *places) {
  const thrum_model *model = f->model;
  const thrum_placement now = thrum_placement_now(NULL, &f->frame, NULL);
  assert_int_equal(thrum_state_get(model, f->state, f->q, f->p, NULL), THRUM_OK);
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double x[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = model->vertices[3 * v + axis] +
                dot_of(model->basis + (3 * v + axis) * model->rank, f->q, model->rank);
    thrum_apply3(now.axes, x, places + 3 * v);
    for (int axis = 0; axis < 3; axis++)
      places[3 * v + axis] += now.origin[axis];
  }
}

/* The full order's places after `steps` of `dt` from the start of the flyer. */
static void full_places(flyer *f, const double spin[3], double dt, int steps, double *places) {
  const thrum_model *model = f->model;
  const int64_t n = 3 * model->vertex_count;
  thrum_error error = {0};
  thrum_full_def def = thrum_default_full_def();
  def.dt = dt;

  thrum_full *full = NULL;
  must(thrum_full_create(model, NULL, &def, &full, &error), &error);

  // it starts as the mesh of the flyer does
  double *u = need((size_t)n, sizeof *u), *v = need((size_t)n, sizeof *v);
  for (int64_t c = 0; c < n; c++)
    u[c] = dot_of(model->basis + c * model->rank, f->q, model->rank);
  for (int64_t node = 0; node < model->vertex_count; node++) {
    double arm[3];
    for (int axis = 0; axis < 3; axis++)
      arm[axis] = model->vertices[3 * node + axis] + u[3 * node + axis] - f->frame.centre[axis];
    thrum_cross3(spin, arm, v + 3 * node);
    for (int axis = 0; axis < 3; axis++)
      v[3 * node + axis] +=
          dot_of(model->basis + (3 * node + axis) * model->rank, f->p, model->rank);
  }
  must(thrum_full_set(full, u, v, &error), &error);
  for (int step = 0; step < steps; step++)
    must(thrum_full_step(full, &error), &error);

  thrum_full_get(full, u, v);
  for (int64_t c = 0; c < n; c++)
    places[c] = model->vertices[c] + u[c];
  thrum_full_free(full);
  free(u);
  free(v);
}

/* With as many coordinates as the mesh has beyond its rigid motion, the floating frame leaves
 * nothing out. */
static void with_all_shapes_it_moves_as_the_full_order(void **state) {
  (void)state;
  double apart[2];
  for (int n = 0; n < 2; n++) {
    thrum_state_def def = thrum_default_state_def();
    const int steps = 100 << n;
    def.dt = 0.6 / steps;
    def.frequency_matched = 0;
    body b = body_make("beam:2x1x1@1x0.4x0.3", NULL);
    b.mesh.materials[0].young = 1e5;
    flyer f;
    flyer_make(b, 8, 30, &def, &f);

    // a start that bends, stretches and turns, by 5 radians in the run
    const double spin[3] = {3, 6, 5};
    for (int64_t i = 0; i < 6; i++)
      f.p[i] = (i % 2 ? -1 : 1) * 0.4 * sqrt(f.result.mass);
    const int64_t count = 3 * f.model->vertex_count;
    double *full = need((size_t)count, sizeof *full), *places = need((size_t)count, sizeof *places);
    full_places(&f, spin, def.dt, steps, full);
    flyer_start(&f, spin);
    for (int step = 0; step < steps; step++)
      flyer_step(&f);
    flyer_places(&f, places);

    apart[n] = 0;
    for (int64_t c = 0; c < count; c++)
      apart[n] = fmax(apart[n], fabs(full[c] - places[c]));
    print_message("%d steps: %.2e m apart\n", steps, apart[n]);
    free(full);
    free(places);
    flyer_free(&f);
  }
  assert_true(apart[1] <= 2e-4 && apart[0] > 3.5 * apart[1]);
}

/* A body that turns about its middle axis tips over and back, also while the spin stretches it. */
static void a_soft_top_flips_about_its_middle_axis(void **state) {
  (void)state;
  thrum_state_def def = thrum_default_state_def();
  body b = body_make("beam:4x2x1@1x0.6x0.2", NULL);
  b.mesh.materials[0] = (thrum_material){1e5, 0.3, 1000};
  def.dt = 5e-3;
  flyer f;
  flyer_make(b, 4, 6, &def, &f);
  const double spin[3] = {0.2, 8, 0.2};
  flyer_start(&f, spin);
  const double energy = flyer_energy(&f);
  double least = 1, most = -1, strain = 0, worst = 0;

  // the middle component of the momentum in the body, over its length
  for (int n = 0; n < LENGTH_OF_RUN(2000, 1000); n++) {
    thrum_energies energies;
    double angular[3];
    flyer_step(&f);
    thrum_apply3_transposed(f.frame.attitude, f.frame.momentum, angular);
    least = fmin(least, angular[1] / norm_of(angular, 3));
    most = fmax(most, angular[1] / norm_of(angular, 3));
    assert_int_equal(thrum_state_energies(f.model, f.state, &energies, NULL), THRUM_OK);
    strain = fmax(strain, energies.potential / energy);
    worst = fmax(worst, fabs(flyer_energy(&f) / energy - 1));
  }
  print_message("from %.3f to %.3f, up to %.1f %% of the energy in the shape, energy to %.1e\n",
                most, least, 100 * strain, worst);
  assert_true(least < -0.98 && most > 0.98 && strain > 0.01 && worst <= 1e-12);
  flyer_free(&f);
}

/* --- loads, damping and what is refused ------------------------------------------------------- */

static void energy_changes_by_work_less_damping(void **state) {
  (void)state;
  thrum_state_def def = thrum_default_state_def();
  def.damping_alpha = 1;
  def.damping_beta = 1e-4;
  body b = body_make("beam:4x2x1@1x0.4x0.2", NULL);
  b.mesh.materials[0] = (thrum_material){1e6, 0.3, 1000};
  flyer f;
  flyer_make(b, 4, 8, &def, &f);
  const int64_t r = f.model->rank;
  const double spin[3] = {5, -3, 4};
  double *load = random_vector(r, 100), *before = need((size_t)r, sizeof *before);
  flyer_start(&f, spin);
  assert_int_equal(thrum_state_set_force(f.model, f.state, load, NULL), THRUM_OK);

  for (int n = 0; n < 500; n++) {
    thrum_error error = {0};
    double angle[3], torque[3] = {20, 30 - 0.1 * n, -10}, momentum[3];
    const double energy = flyer_energy(&f);
    const double taken = thrum_state_report_get(f.state).dissipated;
    memcpy(momentum, f.frame.momentum, sizeof momentum);
    assert_int_equal(thrum_state_get(f.model, f.state, before, NULL, NULL), THRUM_OK);
    must(thrum_floating_frame_step(f.model, f.state, f.inertia, NULL, &f.frame, torque, angle,
                                   f.work, &error),
         &error);

    // the work of torque and load, and what the damping took
    assert_int_equal(thrum_state_get(f.model, f.state, f.q, NULL, NULL), THRUM_OK);
    const double work = dot_of(torque, angle, 3) + dot_of(load, f.q, r) - dot_of(load, before, r);
    const double lost = thrum_state_report_get(f.state).dissipated - taken;
    assert_true(fabs(flyer_energy(&f) - energy - work + lost) <= 1e-12 * energy);
    for (int axis = 0; axis < 3; axis++)
      assert_close(f.frame.momentum[axis], momentum[axis] + def.dt * torque[axis], 1e-12);
  }
  free(load);
  free(before);
  flyer_free(&f);
}

/* A body that turns by several radians in a step is stepped in parts, and its balance holds. */
static void a_step_that_is_too_long_is_made_in_parts(void **state) {
  (void)state;
  thrum_state_def def = thrum_default_state_def();
  def.dt = 0.05;
  body b = body_make("beam:4x2x1@1x0.4x0.2", NULL);
  b.mesh.materials[0] = (thrum_material){5e6, 0.3, 1000};
  flyer f;
  flyer_make(b, 4, 8, &def, &f);
  const double spin[3] = {30, 100, -20}, none[3] = {0};
  flyer_start(&f, spin);
  const double energy = flyer_energy(&f);
  int parts = 0;

  // the status says so
  for (int n = 0; n < 50; n++) {
    thrum_error error = {0};
    const thrum_status status = thrum_floating_frame_step(f.model, f.state, f.inertia, NULL,
                                                          &f.frame, none, NULL, f.work, &error);
    must(status, &error);
    parts += status == THRUM_FELL_BACK;
    assert_true(fabs(flyer_energy(&f) / energy - 1) <= 1e-11);
  }
  assert_true(parts > 0 && thrum_state_report_get(f.state).substep_steps == parts);

  // without a fallback chain it fails, and leaves all as it was
  const thrum_rigid_frame before = f.frame;
  def.fallback = 0;
  def.iterations_max = 1;
  thrum_state *alone = NULL;
  thrum_error error = {0};
  must(thrum_state_create(f.model, &def, &alone, &error), &error);
  assert_int_equal(thrum_state_get(f.model, f.state, f.q, f.p, NULL), THRUM_OK);
  assert_int_equal(thrum_state_set(f.model, alone, f.q, f.p, NULL), THRUM_OK);
  assert_int_equal(thrum_floating_frame_step(f.model, alone, f.inertia, NULL, &f.frame, none, NULL,
                                             f.work, &error),
                   THRUM_NOT_CONVERGED);
  assert_memory_equal(&before, &f.frame, sizeof before);
  thrum_state_destroy(alone);
  flyer_free(&f);
}

/* Without spin a small swing of one mode is that of the energy integrator, which is exact. */
static void without_spin_a_mode_swings_at_its_frequency(void **state) {
  (void)state;
  const thrum_state_def def = thrum_default_state_def();
  const double none[3] = {0};
  body b = body_make("beam:4x2x1@1x0.4x0.2", NULL);
  b.mesh.materials[0] = (thrum_material){1e5, 0.3, 1000};
  flyer f;
  flyer_make(b, 4, 8, &def, &f);
  f.q[0] = 1e-6;
  flyer_start(&f, none);

  // five periods and more
  for (int n = 1; n <= 300; n++) {
    flyer_step(&f);
    assert_int_equal(thrum_state_get(f.model, f.state, f.q, NULL, NULL), THRUM_OK);
    assert_true(fabs(1e6 * f.q[0] - cos(sqrt(f.model->omega2[0]) * def.dt * n)) <= 1e-5);
  }
  flyer_free(&f);
}

static void what_cannot_be_coupled_is_refused(void **state) {
  (void)state;
  thrum_error error = {0};
  thrum_inertia *inertia = NULL;

  // a body that is held, a basis that is not orthonormal
  body held = body_make("beam:4x2x1@1x0.4x0.2", "x<0.001");
  thrum_precomputed result = body_precompute(&held, 4, 4);
  assert_int_equal(thrum_inertia_create(&result.model, 0, NULL, &inertia, &error), THRUM_MISSING);
  thrum_precomputed_free(&result);
  body_free(&held);
  thrum_state_def def = thrum_default_state_def();
  flyer f;
  flyer_make(body_make("beam:4x2x1@1x0.4x0.2", NULL), 4, 4, &def, &f);
  double *basis = need((size_t)(12 * f.model->vertex_count), sizeof *basis);
  for (int64_t n = 0; n < 12 * f.model->vertex_count; n++)
    basis[n] = 2 * f.model->basis[n];
  thrum_model other = *f.model;
  other.basis = basis;
  assert_int_equal(thrum_inertia_create(&other, 0, NULL, &inertia, &error), THRUM_UNSUPPORTED);
  assert_null(inertia);
  free(basis);

  // points of another law, whose energy is no quartic
  static const uint8_t law[] = "corotational";
  other = *f.model;
  other.point_law = law;
  other.law_bytes = sizeof law;
  assert_int_equal(thrum_inertia_create(&other, 0, NULL, &inertia, &error), THRUM_UNSUPPORTED);

  // one that says by name what holds without a name
  static const uint8_t usual[] = "stvk";
  other.point_law = usual;
  other.law_bytes = sizeof usual;
  must(thrum_inertia_create(&other, 0, NULL, &inertia, &error), &error);
  thrum_inertia_destroy(inertia);

  // another integrator, other coordinates
  const double none[3] = {0};
  thrum_state *explicit = NULL;
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  must(thrum_state_create(f.model, &def, &explicit, &error), &error);
  assert_int_equal(thrum_floating_frame_step(f.model, explicit, f.inertia, NULL, &f.frame, none,
                                             NULL, f.work, &error),
                   THRUM_UNSUPPORTED);
  must(thrum_inertia_create(f.model, 3, NULL, &inertia, &error), &error);
  assert_int_equal(thrum_inertia_rank(inertia), 3);
  assert_int_equal(thrum_floating_frame_step(f.model, f.state, inertia, NULL, &f.frame, none, NULL,
                                             f.work, &error),
                   THRUM_MODEL_MISMATCH);

  // a torque beyond the numbers leaves state and frame as they were
  const double beyond[3] = {1e308, 0, 0};
  const thrum_rigid_frame before = f.frame;
  assert_true(thrum_floating_frame_step(f.model, f.state, f.inertia, NULL, &f.frame, beyond, NULL,
                                        f.work, &error) < 0);
  assert_memory_equal(&before, &f.frame, sizeof before);
  assert_int_equal(thrum_state_report_get(f.state).steps, 0);
  thrum_state_destroy(explicit);
  thrum_inertia_destroy(inertia);
  flyer_free(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frame_and_shape_have_the_energy_and_momentum_of_the_mesh),
      cmocka_unit_test(a_lumped_body_has_the_inertia_of_its_vertices),
      cmocka_unit_test(a_soft_body_keeps_energy_and_momentum_over_many_steps),
      cmocka_unit_test(all_kernels_step_to_the_same_bits),
      cmocka_unit_test(with_all_shapes_it_moves_as_the_full_order),
      cmocka_unit_test(a_soft_top_flips_about_its_middle_axis),
      cmocka_unit_test(energy_changes_by_work_less_damping),
      cmocka_unit_test(a_step_that_is_too_long_is_made_in_parts),
      cmocka_unit_test(without_spin_a_mode_swings_at_its_frequency),
      cmocka_unit_test(what_cannot_be_coupled_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
