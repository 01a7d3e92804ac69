/* Tests of a free beam that falls on its edge: it tips over and comes to rest on its side; without
 * friction and with restitution 1 it keeps moving, and its loss of energy falls with the time step.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"
#include "tests/support/sanitized.h"

#include "thrum/thrum.h"

#define GRAVITY 9.81

/* Places the body tilted about y, with its lowest point 0.3 m above the floor z = 0. */
typedef struct fall {
  body mesh;
  thrum_precomputed made;
  thrum_model model;
  void *packed;
  thrum_state *state;
  thrum_contact *contact;
  thrum_placement placement;
  thrum_translation translation;
  thrum_rigid_frame rigid_frame;
  thrum_obstacle floor;
  thrum_contact_environment environment;
} fall;

static void *lay(size_t size) {
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_non_null(memory);
  return memory;
}

static void place(fall *f, double tilt) {
  const double c = cos(tilt), s = sin(tilt);
  double lowest = INFINITY;
  for (int64_t v = 0; v < f->model.vertex_count; v++)
    lowest = fmin(lowest, c * f->model.vertices[3 * v + 2] - s * f->model.vertices[3 * v]);
  f->placement = (thrum_placement){{c, 0, s, 0, 1, 0, -s, 0, c}, {0, 0, 0.3 - lowest}};
  assert_int_equal(thrum_rigid_frame_of(&f->model, &f->rigid_frame, NULL), THRUM_OK);
  f->translation = (thrum_translation){.mass = f->made.mass};
  f->environment = (thrum_contact_environment){.placement = &f->placement,
                                               .translation = &f->translation,
                                               .rigid_frame = &f->rigid_frame,
                                               .obstacles = &f->floor,
                                               .obstacle_count = 1,
                                               .force = {0, 0, -GRAVITY * f->made.mass}};
}

static void fall_make(fall *f, const thrum_state_def *def) {
  // a free beam, with packed coefficients
  memset(f, 0, sizeof *f);
  f->mesh = body_make("beam:8x3x3@1x0.3x0.3", NULL);
  f->made = body_precompute(&f->mesh, 8, 20);
  f->model = f->made.model;
  f->packed = lay(thrum_model_pack_size(&f->model));
  assert_int_equal(thrum_model_pack(&f->model, f->packed, thrum_model_pack_size(&f->model), NULL),
                   THRUM_OK);

  // the state and the contact of all its vertices
  size_t size = 0;
  assert_int_equal(thrum_state_size(&f->model, def, &size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_init(lay(size), size, &f->model, def, &f->state, NULL), THRUM_OK);
  const thrum_contact_def touching = thrum_default_contact_def();
  assert_int_equal(thrum_contact_size(&f->model, f->state, &touching, &size, NULL), THRUM_OK);
  assert_int_equal(
      thrum_contact_init(lay(size), size, &f->model, f->state, &touching, &f->contact, NULL),
      THRUM_OK);

  // the floor, and the beam in its initial place above it
  f->floor = thrum_default_obstacle();
  place(f, 0.3);
}

static void fall_free(fall *f) {
  free(f->state);
  free(f->contact);
  free(f->packed);
  thrum_precomputed_free(&f->made);
  body_free(&f->mesh);
}

static double energy_of(fall *f) {
  thrum_energies energies;
  assert_int_equal(thrum_state_energies(&f->model, f->state, &energies, NULL), THRUM_OK);
  const double *v = f->translation.velocity;
  return energies.total + thrum_rigid_frame_energy(&f->rigid_frame, &f->placement) +
         f->made.mass * (0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) +
                         GRAVITY * (f->translation.position[2] + 1));
}

/* Steps and returns the largest relative error of the balance of energy, contact included. */
static double run(fall *f, int64_t steps, double *gain) {
  const double first = energy_of(f);
  double off = 0;
  thrum_error error = {0};
  for (int64_t n = 0; n < steps; n++) {
    if (thrum_contact_step(&f->model, f->state, f->contact, &f->environment, &error) < 0)
      fail_msg("%s", error.message);
    const thrum_contact_report report = thrum_contact_report_get(f->contact);
    const double energy = energy_of(f);
    *gain = fmax(*gain, energy / first - 1);
    off = fmax(off, fabs((energy + report.stored + report.lost) / first - 1));
  }
  return off;
}

static void a_beam_tips_over_and_rests_on_its_side(void **state) {
  (void)state;
  static const double steps[] = {0.01, 0.003, 0.001};

  for (int n = 0; n < LENGTH_OF_RUN(3, 2); n++) {
    // a damped beam falls for long enough to come to rest
    thrum_state_def def = thrum_default_state_def();
    def.dt = steps[n];
    def.damping_alpha = 2;
    fall f;
    fall_make(&f, &def);
    double gain = 0;
    run(&f, (int64_t)(6 / def.dt), &gain);

    // its orientation and the force on the floor at the end
    const thrum_contact_report report = thrum_contact_report_get(f.contact);
    const thrum_placement now =
        thrum_placement_now(&f.placement, &f.rigid_frame, f.translation.position);
    const double weight = GRAVITY * f.made.mass;

    print_message(
        "h = %g: %d points bear %.6f of the weight, %.1e m deep, the axis %.1e off level, "
        "gain %.1e\n",
        def.dt, (int)report.touching, report.normal / weight, report.depth, now.axes[6], gain);

    // the energy never grew; the beam lies level on a long side of 9 x 4 vertices, which carry its
    // weight and do not sink in
    assert_true(gain <= 1e-9);
    assert_in_range(report.touching, 3, 36);
    assert_true(report.depth <= 1e-5);
    assert_true(fabs(report.normal / weight - 1) <= 1e-3);
    assert_true(fabs(now.axes[6]) <= 1e-4);
    fall_free(&f);
  }
}

static void a_smooth_elastic_fall_keeps_its_energy(void **state) {
  (void)state;

  for (int n = 0; n < 2; n++) {
    // an integrator that conserves energy, with two time steps
    thrum_state_def def = thrum_default_state_def();
    def.integrator = THRUM_INTEGRATOR_ENERGY;
    def.dt = n == 0 ? 0.001 : 0.00025;
    fall f;
    fall_make(&f, &def);
    f.floor.friction = 0;
    f.floor.restitution = 1;

    // the balance of energy is exact throughout
    double gain = 0;
    const double first = energy_of(&f);
    assert_true(run(&f, (int64_t)(3 / def.dt), &gain) <= 1e-9);
    assert_true(gain <= 1e-9);

    // what steps miss goes back, so nothing is lost at any time step
    const thrum_contact_report report = thrum_contact_report_get(f.contact);
    print_message("h = %g: %.2g of the energy lost in 3 s, %.2g in springs\n", def.dt,
                  report.lost / first, report.stored / first);
    assert_true(fabs(report.lost / first) <= 1e-9);
    fall_free(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_beam_tips_over_and_rests_on_its_side),
      cmocka_unit_test(a_smooth_elastic_fall_keeps_its_energy),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
