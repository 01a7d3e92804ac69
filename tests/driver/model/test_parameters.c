/* Tests of bodies of other parameters: their energy is that of the mesh of these materials, their
 * modes have unit mass, the polynomial comes back, and derivatives of runs by moduli and densities
 * agree with differences of such bodies.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "driver/identify/region_body.h"
#include "thrum/gradient.h"
#include "thrum/parameters.h"
#include "thrum/polynomial.h"

enum { MODES = 2, RANK = 4, REGIONS = 3, COUNT = 3 * REGIONS, STEPS = 30, MOST = 20 };

typedef struct set_body {
  const thrum_model *model;
  void *memory;
  double *turn;
} set_body;

static thrum_precomputed made; /* with parameters, of three regions */
static body beam;

static int make_model(void **state) {
  (void)state;
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = MODES;
  options.rank = RANK;
  options.parameters = true;
  thrum_error error = {0};
  beam = body_beam1k();
  double length = 0;
  for (int64_t v = 0; v < beam.mesh.vertex_count; v++)
    length = fmax(length, beam.mesh.vertices[3 * v]);
  body_divide(&beam, length);
  for (int g = 0; g < REGIONS; g++)
    beam.mesh.materials[g].density *= 1 + 0.2 * g;
  if (thrum_precompute(&beam.mesh, beam.fixed, &options, &made, &error) == THRUM_OK)
    return 0;
  print_error("%s\n", error.message);
  return 1;
}

static int free_model(void **state) {
  (void)state;
  thrum_precomputed_free(&made);
  body_free(&beam);
  return 0;
}

static set_body set_of(const thrum_model *model, const double *values) {
  set_body set = {0};
  size_t size = 0, work_count = 0;
  thrum_error error = {0};
  assert_int_equal(thrum_model_parameters_size(model, &size, &work_count, &error), THRUM_OK);
  double *work = need(work_count, sizeof *work);
  set.memory = aligned_alloc(64, (size + 63) / 64 * 64);
  set.turn = need((size_t)(model->rank * model->rank), sizeof *set.turn);
  if (thrum_model_set_parameters(set.memory, size, model, values, set.turn, work, &set.model,
                                 &error) != THRUM_OK)
    fail_msg("%s", error.message);
  free(work);
  return set;
}

static void set_free(set_body *set) {
  free(set->memory);
  free(set->turn);
}

static void own_values_give_the_polynomial_back(void **state) {
  (void)state;
  const thrum_model *model = &made.model;
  double values[COUNT];
  assert_int_equal(thrum_model_parameter_count(model), COUNT);
  assert_true(model->rank > RANK && model->rank <= MOST);
  assert_int_equal(thrum_model_parameters_get(model, values, NULL), THRUM_OK);
  set_body set = set_of(model, values);
  assert_near(set.model->omega2, model->omega2, model->rank, 1e-12);
  assert_near(set.model->c3, model->c3, model->c3_count, 1e-11);
  assert_near(set.model->c4, model->c4, model->c4_count, 1e-11);
  assert_near(set.model->axis_mass, model->axis_mass, 3 * model->rank, 1e-11);
  assert_int_equal(thrum_model_check(set.model, NULL), THRUM_OK);
  set_free(&set);
}

/* V(q) is that of the mesh of the other materials, and U has unit mass there. */
static void another_body_is_the_mesh_of_its_materials(void **state) {
  (void)state;
  double values[COUNT], back[COUNT];
  const int64_t r = made.model.rank, rows = 3 * made.model.vertex_count;
  thrum_model_parameters_get(&made.model, values, NULL);
  for (int n = 0; n < COUNT; n++)
    values[n] *= 1 + 0.1 * ((n * 5) % 7 - 3);
  set_body first = set_of(&made.model, values);

  // and again from there, with one value more
  values[4] *= 1.3;
  set_body set = set_of(first.model, values);
  thrum_model_parameters_get(set.model, back, NULL);
  assert_near(back, values, COUNT, 1e-12);
  for (int g = 0; g < REGIONS; g++) {
    beam.mesh.materials[g].young = set.model->material[3 * g];
    beam.mesh.materials[g].poisson = set.model->material[3 * g + 1];
    beam.mesh.materials[g].density = set.model->material[3 * g + 2];
  }
  thrum_fem fem = body_fem(&beam);
  double *q = random_vector(r, 0.02), *u = need((size_t)rows, sizeof *u);
  double *work = need(thrum_work_count(set.model), sizeof *work);
  for (int64_t c = 0; c < rows; c++)
    for (int64_t i = 0; i < r; i++)
      u[c] += set.model->basis[c * r + i] * q[i];
  assert_close(thrum_strain_energy(set.model, q, work), thrum_fem_energy(&fem, u, NULL), 1e-9);

  // U^T M U = 1
  thrum_sparse pattern = {0}, mass = {0};
  assert_int_equal(thrum_fem_pattern(&fem, &pattern, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &pattern, &mass, NULL), THRUM_OK);
  double *column = need((size_t)fem.free_count, sizeof *column), *product = need((size_t)rows, 8);
  for (int64_t i = 0; i < r; i++) {
    for (int64_t f = 0; f < fem.free_count; f++)
      column[f] = set.model->basis[fem.component[f] * r + i];
    thrum_sparse_product(&mass, column, 1, product);
    for (int64_t j = 0; j < r; j++) {
      double sum = 0;
      for (int64_t f = 0; f < fem.free_count; f++)
        sum += set.model->basis[fem.component[f] * r + j] * product[f];
      assert_true(fabs(sum - (i == j)) < 1e-10);
    }
  }
  free(column);
  free(product);
  thrum_sparse_free(&pattern);
  thrum_sparse_free(&mass);
  free(q);
  free(u);
  free(work);
  thrum_fem_free(&fem);
  set_free(&first);
  set_free(&set);
}

/* Shares of the file are those that the mesh is reduced to. */
static void shares_are_the_energies_of_the_regions(void **state) {
  (void)state;
  region_shares by_shares = {0}, by_mesh = {0};
  thrum_error error = {0};
  thrum_model plain = made.model;
  plain.region_energy = plain.region_mass = NULL;
  if (region_shares_open(&made.model, false, &by_shares, &error) < 0 ||
      region_shares_open(&plain, false, &by_mesh, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(by_shares.count, REGIONS);
  assert_near(by_shares.model.region_energy, by_mesh.model.region_energy,
              2 * REGIONS * made.model.energy_size, 1e-12);
  assert_near(by_shares.model.region_mass, by_mesh.model.region_mass,
              REGIONS * made.model.mass_size, 1e-12);
  region_shares_close(&by_shares);
  region_shares_close(&by_mesh);
}

static void what_is_no_material_is_refused(void **state) {
  (void)state;
  size_t size = 0, work_count = 0;
  thrum_error error = {0};
  const thrum_model *set = NULL;
  assert_int_equal(thrum_model_parameters_size(&made.model, &size, &work_count, NULL), THRUM_OK);
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  double *work = need(work_count, sizeof *work), own[COUNT];
  thrum_model_parameters_get(&made.model, own, NULL);
  const double bad[][2] = {{1, 0}, {2, -1}, {0, -1e12}, {4, NAN}};
  for (int n = 0; n < 4; n++) {
    double values[COUNT];
    memcpy(values, own, sizeof values);
    values[(int)bad[n][0]] = bad[n][1];
    assert_int_equal(
        thrum_model_set_parameters(memory, size, &made.model, values, NULL, work, &set, &error),
        THRUM_BAD_VALUE);
    assert_non_null(strstr(error.message, "region"));
  }
  assert_int_equal(
      thrum_model_set_parameters(memory, size - 1, &made.model, own, NULL, work, &set, &error),
      THRUM_BUFFER_TOO_SMALL);
  thrum_model plain = made.model;
  plain.region_energy = plain.region_mass = NULL;
  assert_int_equal(thrum_model_parameters_get(&plain, own, &error), THRUM_UNSUPPORTED);
  assert_int_equal(thrum_model_parameter_count(&plain), 0);
  free(memory);
  free(work);
}

/* --- derivatives of runs ---------------------------------------------------------------------- */

typedef struct run {
  thrum_integrator integrator;
  double dt, q[MOST], p[MOST], force[STEPS * MOST];
  double q_bar[(STEPS + 1) * MOST], p_bar[(STEPS + 1) * MOST];
} run;

static thrum_tape *record(const run *r, const thrum_model *model, const double *q, const double *p,
                          const double *force, thrum_state **state) {
  thrum_state_def def = thrum_default_state_def();
  thrum_tape *tape = NULL;
  thrum_tape_def tape_def = thrum_default_tape_def();
  tape_def.steps = STEPS;
  thrum_error error = {0};
  def.integrator = r->integrator;
  def.dt = r->dt;
  def.tolerance = 1e-14;
  def.damping_alpha = 0.5;
  def.damping_beta = 1e-4;
  if (thrum_state_create(model, &def, state, &error) != THRUM_OK ||
      thrum_tape_create(model, &tape_def, &tape, &error) != THRUM_OK ||
      thrum_tape_start(model, tape, *state, q, p, &error) != THRUM_OK ||
      thrum_tape_run(model, tape, *state, force, STEPS, NULL, &error) < 0)
    fail_msg("%s", error.message);
  return tape;
}

/* to = turn v or turn^T v */
static void turned(const double *turn, bool transposed, int64_t n, const double *v, double *to) {
  for (int64_t i = 0; i < n; i++) {
    to[i] = 0;
    for (int64_t j = 0; j < n; j++)
      to[i] += turn[transposed ? j * n + i : i * n + j] * v[j];
  }
}

/* The loss of the run of a body of these values, all fields as those of the model's coordinates. */
static double loss_of(const run *r, const double *values) {
  const int64_t n = made.model.rank;
  set_body set = set_of(&made.model, values);
  double q[MOST], p[MOST], mass[MOST * MOST] = {0}, moved[MOST], force[STEPS * MOST], loss = 0;

  // q = S q', so that q' = S^T M q
  for (int64_t g = 0; g < REGIONS; g++)
    for (int64_t i = 0; i < n * n; i++)
      mass[i] += values[3 * g + 2] * made.model.region_mass[g * made.model.mass_size + i];
  turned(mass, false, n, r->q, moved);
  turned(set.turn, true, n, moved, q);
  turned(mass, false, n, r->p, moved);
  turned(set.turn, true, n, moved, p);
  for (int k = 0; k < STEPS; k++)
    turned(set.turn, true, n, r->force + k * n, force + k * n);
  thrum_state *state = NULL;
  thrum_tape *tape = record(r, set.model, q, p, force, &state);
  for (int k = 0; k <= STEPS; k++) {
    turned(set.turn, false, n, thrum_tape_q(tape) + k * n, moved);
    loss += dot_of(moved, r->q_bar + k * n, n);
    turned(set.turn, false, n, thrum_tape_p(tape) + k * n, moved);
    loss += dot_of(moved, r->p_bar + k * n, n);
  }
  thrum_tape_destroy(tape);
  thrum_state_destroy(state);
  set_free(&set);
  return loss;
}

static void fill(double *to, int64_t count, double size) {
  for (int64_t n = 0; n < count; n++)
    to[n] = size * random_number();
}

static void check_run(run *r) {
  const int64_t n = made.model.rank;
  const double omega = sqrt(made.model.omega2[0]);
  double values[COUNT], by[COUNT], along[COUNT];
  static double q[(STEPS + 1) * MOST], p[(STEPS + 1) * MOST];
  for (int64_t i = 0; i < n; i++) {
    fill(r->q + i, 1, 0.05 * made.model.omega2[0] / made.model.omega2[i]);
    fill(r->p + i, 1, 0.05 * made.model.omega2[0] / sqrt(made.model.omega2[i]));
  }
  fill(r->force, STEPS * n, 0.2 * omega * omega);
  fill(r->q_bar, (STEPS + 1) * n, 1);
  fill(r->p_bar, (STEPS + 1) * n, 1 / omega);
  thrum_model_parameters_get(&made.model, values, NULL);

  thrum_error error = {0};
  thrum_state *state = NULL;
  thrum_parameter_parts *parts = NULL;
  assert_int_equal(thrum_parameter_parts_create(&made.model, &parts, &error), THRUM_OK);
  assert_int_equal(thrum_parameter_parts_count(parts), COUNT);
  thrum_tape *tape = record(r, &made.model, r->q, r->p, r->force, &state);
  thrum_tape_gradient gradient = {
      .parts = thrum_parameter_parts_list(parts), .part = by, .part_count = COUNT};
  if (thrum_tape_pull_back(&made.model, tape, r->q_bar, r->p_bar, &gradient, &error) != THRUM_OK)
    fail_msg("%s", error.message);

  // each parameter against differences of order 4, by its own size
  for (int c = 0; c < COUNT; c++) {
    double found[4];
    const double step = 3e-4 * values[c];
    static const double at[4] = {-2, -1, 1, 2};
    for (int k = 0; k < 4; k++) {
      double other[COUNT];
      memcpy(other, values, sizeof other);
      other[c] += at[k] * step;
      found[k] = loss_of(r, other);
    }
    const double slope = (found[0] - 8 * found[1] + 8 * found[2] - found[3]) / (12 * step);
    if (!(fabs(by[c] - slope) * values[c] < 1e-7 * (1 + fabs(slope) * values[c])))
      fail_msg("%s, parameter %d: %.12g, by differences %.12g",
               thrum_integrator_name(r->integrator), c, by[c] * values[c], slope * values[c]);
  }

  // forward is the transpose
  for (int c = 0; c < COUNT; c++)
    along[c] = values[c] * random_number();
  gradient = (thrum_tape_gradient){
      .parts = thrum_parameter_parts_list(parts), .part = along, .part_count = COUNT};
  assert_int_equal(thrum_tape_push_forward(&made.model, tape, &gradient, q, p, &error), THRUM_OK);
  const double forward =
      dot_of(q, r->q_bar, (STEPS + 1) * n) + dot_of(p, r->p_bar, (STEPS + 1) * n);
  if (!(fabs(dot_of(by, along, COUNT) - forward) <
        1e-11 * norm_of(by, COUNT) * norm_of(along, COUNT)))
    fail_msg("%s: %.15g forward, %.15g backward", thrum_integrator_name(r->integrator), forward,
             dot_of(by, along, COUNT));
  thrum_tape_destroy(tape);
  thrum_state_destroy(state);
  thrum_parameter_parts_destroy(parts);
}

static void derivatives_of_runs_are_those_of_the_bodies(void **state) {
  (void)state;
  const double fastest = sqrt(made.model.omega2[made.model.rank - 1]);
  const double slowest = sqrt(made.model.omega2[0]);
  static const thrum_integrator all[] = {THRUM_INTEGRATOR_ENERGY, THRUM_INTEGRATOR_MIDPOINT,
                                         THRUM_INTEGRATOR_NEWMARK, THRUM_INTEGRATOR_VERLET};
  for (int n = 0; n < 4; n++) {
    static run r;
    r = (run){.integrator = all[n],
              .dt = all[n] == THRUM_INTEGRATOR_VERLET ? 0.5 / fastest : 0.04 / slowest};
    check_run(&r);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(own_values_give_the_polynomial_back),
      cmocka_unit_test(derivatives_of_runs_are_those_of_the_bodies),
      cmocka_unit_test(shares_are_the_energies_of_the_regions),
      cmocka_unit_test(what_is_no_material_is_refused),
      cmocka_unit_test(another_body_is_the_mesh_of_its_materials),
  };
  return cmocka_run_group_tests(tests, make_model, free_model);
}
