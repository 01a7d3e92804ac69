/* Tests of the equilibria of reduced models: against closed forms of polynomials made by hand,
 * against the linear solution, and against Euler's column.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "precompute/precompute.h"
#include "thrum/external_load.h"
#include "thrum/polynomial.h"

/* The result of a solution and the memory that it took. */
typedef struct answer {
  thrum_status status;
  thrum_equilibrium_report report;
  thrum_error error;
  double mode[RANK_MAX * 2];
} answer;

typedef struct seen {
  double factor[4000], least[4000];
  int32_t count, jumps;
} seen;

static void see(void *context, const thrum_equilibrium_point *point) {
  seen *all = context;
  assert_true(all->count < 4000);
  all->factor[all->count] = point->factor;
  all->least[all->count++] = point->least;
  all->jumps += point->jumped;
}

static answer solve_seen(const thrum_model *model, const thrum_equilibrium_def *def,
                         const double *load, double *q, seen *all) {
  answer found = {.status = THRUM_OK};
  size_t size = 0;
  assert_int_equal(thrum_equilibrium_size(model, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, size);
  assert_non_null(workspace);
  memset(workspace, 0xff, size);
  thrum_equilibrium_def asked = *def;
  asked.mode = found.mode;
  asked.visit = all ? see : NULL;
  asked.context = all;
  found.status =
      thrum_equilibrium(model, &asked, load, q, workspace, size, &found.report, &found.error);
  free(workspace);
  return found;
}

static answer solve(const thrum_model *model, double factor, const double *load, double *q) {
  thrum_equilibrium_def def = thrum_default_equilibrium_def();
  def.factor = factor;
  return solve_seen(model, &def, load, q, NULL);
}

/* A column with x along it and y across it: V = 1/2 wy y^2 + 1/2 wx x^2 - a x y^2 + b y^4. */
typedef struct column {
  double omega2[2], c3[4], c4[5];
  thrum_model model;
} column;

static void column_make(column *c, double across, double along, double a, double b) {
  memset(c, 0, sizeof *c);
  c->omega2[0] = across;
  c->omega2[1] = along;
  c->c3[thrum_c3_index(2, 0, 0, 1)] = -a;
  c->c4[thrum_c4_index(2, 0, 0, 0, 0)] = b;
  c->model = (thrum_model){
      .rank = 2, .c3_count = 4, .c4_count = 5, .omega2 = c->omega2, .c3 = c->c3, .c4 = c->c4};
}

/* A spring of one coordinate: V = 1/2 q^2 + c3 q^3 + c4 q^4. */
typedef struct spring {
  double omega2, c3, c4;
  thrum_model model;
} spring;

static void spring_make(spring *s, double omega2, double c3, double c4) {
  s->omega2 = omega2;
  s->c3 = c3;
  s->c4 = c4;
  s->model = (thrum_model){
      .rank = 1, .c3_count = 1, .c4_count = 1, .omega2 = &s->omega2, .c3 = &s->c3, .c4 = &s->c4};
}

static void a_small_load_gives_the_linear_answer(void **state) {
  (void)state;
  random_model random;
  random_model_make(&random, 41, 9, 1, 20, 1);
  const thrum_model *model = &random.model;
  double load[RANK_MAX], q[RANK_MAX] = {0};
  for (int64_t i = 0; i < 9; i++)
    load[i] = 1e-9 * cos((double)i);
  const answer found = solve(model, 1, load, q);
  assert_int_equal(found.status, THRUM_OK);
  for (int64_t i = 0; i < 9; i++)
    assert_true(fabs(q[i] - load[i] / model->omega2[i]) <= 1e-7 * 1e-9 / model->omega2[0]);
  random_model_free(&random);
}

/* The residual is evaluated by the public polynomial; the total energy is a local minimum. */
static void the_forces_balance_and_the_energy_is_least(void **state) {
  (void)state;

  // a random model under a load on every coordinate, at twice its size
  random_model random;
  random_model_make(&random, 42, 9, 1, 20, 1);
  const thrum_model *model = &random.model;
  double load[RANK_MAX], q[RANK_MAX] = {0}, force[RANK_MAX], beside[RANK_MAX];
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  for (int64_t i = 0; i < 9; i++)
    load[i] = 0.5 * model->omega2[i] * sin((double)(i + 1));
  const answer found = solve(model, 2, load, q);
  assert_int_equal(found.status, THRUM_OK);
  assert_true(found.report.residual <= 1e-10);

  // the internal force balances the load; the report holds the same energies
  const double energy = thrum_internal_force(model, q, force, work);
  double least = energy;
  for (int64_t i = 0; i < 9; i++) {
    assert_true(fabs(force[i] - 2 * load[i]) <= 1e-8 * fabs(load[8]));
    least -= 2 * load[i] * q[i];
  }
  assert_true(fabs(found.report.energy - energy) <= 1e-12 * energy);
  assert_true(fabs(found.report.energy + found.report.load_energy - least) <= 1e-9 * energy);
  assert_true(found.report.least > 0);

  // the total energy grows in both directions of every coordinate
  for (int64_t i = 0; i < 18; i++) {
    memcpy(beside, q, sizeof q);
    beside[i / 2] += i % 2 ? 1e-3 : -1e-3;
    double there = thrum_strain_energy(model, beside, work);
    for (int64_t j = 0; j < 9; j++)
      there -= 2 * load[j] * beside[j];
    assert_true(there > least);
  }

  free(work);
  random_model_free(&random);
}

static void a_hardening_spring_gives_duffings_root(void **state) {
  (void)state;
  spring s;
  spring_make(&s, 4, 0, 0.25);
  // 4 q + q^3 = f at q = 3, and from the other side
  for (int sign = -1; sign <= 1; sign += 2) {
    double load = sign * 39.0, q = 0;
    const answer found = solve(&s.model, 1, &load, &q);
    assert_int_equal(found.status, THRUM_OK);
    assert_true(fabs(q - sign * 3.0) <= 1e-9);
    assert_true(fabs(found.report.least - (4 + 3 * 9)) <= 1e-6);
    assert_int_equal(found.report.instability, THRUM_INSTABILITY_NONE);
    assert_true(isnan(found.report.critical));
  }
}

static void an_enormous_load_is_reached_from_rest(void **state) {
  (void)state;
  spring s;
  spring_make(&s, 1, 0, 0.25);
  double load = 1e18, q = 0;
  const answer found = solve(&s.model, 1, &load, &q);
  assert_int_equal(found.status, THRUM_OK);
  assert_true(fabs(q - 1e6) <= 1e-3);
  assert_int_equal(found.report.instability, THRUM_INSTABILITY_NONE);
}

/* The shape is the same after one step, after many, and by way of a part of the load. */
static void a_stable_answer_does_not_depend_on_the_way(void **state) {
  (void)state;
  column c;
  column_make(&c, 1, 100, 5, 3);
  const double load[2] = {0.8, -12};
  double one[2] = {0}, many[2] = {0}, part[2] = {0};
  thrum_equilibrium_def def = thrum_default_equilibrium_def();
  def.first_step = 1;
  assert_int_equal(solve_seen(&c.model, &def, load, one, NULL).status, THRUM_OK);
  def.first_step = 1e-3;
  assert_int_equal(solve_seen(&c.model, &def, load, many, NULL).status, THRUM_OK);
  assert_int_equal(solve(&c.model, 0.37, load, part).status, THRUM_OK);
  assert_int_equal(solve(&c.model, 1, load, part).status, THRUM_OK);
  assert_true(largest_difference(one, many, 2) <= 1e-9);
  assert_true(largest_difference(one, part, 2) <= 1e-9);
}

/* Loaded along x, the column is straight until 1 - 10 x = 0: at x = 0.1, half of the load 20.
 * Beyond, y grows by 4 b y^2 = 2 a x - 1 with 100 x = f + a y^2. */
/* Residual of q under a load, in the norm of the report and relative to the load. */
static double residual_at(const thrum_model *model, const double *load, const double *q) {
  double force[RANK_MAX], sum = 0, of_load = 0;
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  thrum_internal_force(model, q, force, work);
  free(work);
  for (int64_t i = 0; i < model->rank; i++) {
    sum += (force[i] - load[i]) * (force[i] - load[i]) / model->omega2[i];
    of_load += load[i] * load[i] / model->omega2[i];
  }
  return sqrt(sum / of_load);
}

/* What a search takes for rounding is of where it ends, not of where it began. */
static void a_start_far_away_ends_in_balance_or_is_refused(void **state) {
  (void)state;
  random_model random;
  random_model_make(&random, 47, 9, 1, 20, 1);
  int balanced = 0;
  for (int decade = 0; decade <= 150; decade += 6) {
    double load[RANK_MAX], q[RANK_MAX], start[RANK_MAX];
    for (int64_t i = 0; i < 9; i++) {
      load[i] = 0.01 * cos((double)i);
      start[i] = q[i] = pow(10, decade) * sin((double)(i + 1));
    }
    const answer found = solve(&random.model, 1, load, q);
    if (found.status < 0) {
      assert_memory_equal(q, start, 9 * sizeof *q);
      continue;
    }
    balanced++;
    const double residual = residual_at(&random.model, load, q);
    if (!(residual < 1e-7))
      fail_msg("from 1e%d the residual is %g, and %g is reported", decade, residual,
               found.report.residual);
  }
  assert_true(balanced >= 8);
  random_model_free(&random);
}

static void a_column_buckles_where_its_stiffness_ends(void **state) {
  (void)state;

  // the load goes to twice the critical one
  column c;
  column_make(&c, 1, 100, 5, 1);
  const double load[2] = {0, 20};
  double q[2] = {0};
  seen all = {.count = 0};
  thrum_equilibrium_def def = thrum_default_equilibrium_def();
  const answer found = solve_seen(&c.model, &def, load, q, &all);

  // the bifurcation lies at half of the load, in the mode across
  assert_int_equal(found.status, THRUM_OK);
  assert_int_equal(found.report.instability, THRUM_INSTABILITY_BIFURCATION);
  assert_true(fabs(found.report.critical - 0.5) <= 1e-8);
  assert_true(fabs(found.report.critical_linear - 0.5) <= 1e-8);
  assert_true(fabs(found.mode[0] - 1) <= 1e-6 && fabs(found.mode[1]) <= 1e-6);

  // the path left the straight branch once and ends on the stable, buckled one
  assert_int_equal(found.report.jumps, 1);
  assert_int_equal(all.jumps, 1);
  assert_true(found.report.least > 0);

  // the buckled shape is that of the closed form
  const double across = (10 * 0.2 - 1) / (4 - 10 * 0.05);
  assert_true(fabs(q[0] * q[0] - across) <= 1e-8);
  assert_true(fabs(q[1] - (20 + 5 * across) / 100) <= 1e-8);

  // the reported path ends at the whole load, and every point of it is stable
  assert_true(all.factor[all.count - 1] == 1.0);
  for (int32_t k = 0; k < all.count; k++)
    assert_true(all.least[k] > 0);
}

static void a_column_that_is_to_stay_stays_straight(void **state) {
  (void)state;
  column c;
  column_make(&c, 1, 100, 5, 1);
  const double load[2] = {0, 20};
  double q[2] = {0};
  thrum_equilibrium_def def = thrum_default_equilibrium_def();
  def.stay = 1;
  const answer found = solve_seen(&c.model, &def, load, q, NULL);
  assert_int_equal(found.status, THRUM_OK);
  assert_true(q[0] == 0 && fabs(q[1] - 0.2) <= 1e-12);
  assert_true(fabs(found.report.least + 1) <= 1e-9);
  assert_true(fabs(found.report.critical - 0.5) <= 1e-8);
  assert_int_equal(found.report.jumps, 0);
}

/* A spring with V' = q - 1.2 q^2 + 0.4 q^3 has its limit point where V'' = 0. */
static void an_arch_snaps_through_at_its_limit_point(void **state) {
  (void)state;
  spring s;
  spring_make(&s, 1, -0.4, 0.1);

  // the limit point is the smaller root of V'' = 0
  const double turn = (2.4 - sqrt(2.4 * 2.4 - 4.8)) / 2.4;
  const double critical = turn - 1.2 * turn * turn + 0.4 * turn * turn * turn;

  // beyond its limit point the arch jumps to the far branch
  double load = 1, q = 0;
  answer found = solve(&s.model, 1, &load, &q);
  assert_int_equal(found.status, THRUM_OK);
  assert_int_equal(found.report.instability, THRUM_INSTABILITY_LIMIT);
  assert_true(fabs(found.report.critical - critical) <= 2e-6 * critical);
  assert_int_equal(found.report.jumps, 1);
  assert_true(fabs(q - 1.2 * q * q + 0.4 * q * q * q - 1) <= 1e-9 && q > 2);

  // without jumps there is no equilibrium under this load, and the coordinate keeps its value
  thrum_equilibrium_def def = thrum_default_equilibrium_def();
  def.stay = 1;
  double kept = 0;
  found = solve_seen(&s.model, &def, &load, &kept, NULL);
  assert_int_equal(found.status, THRUM_NOT_CONVERGED);
  assert_true(kept == 0);
  assert_non_null(strstr(found.error.message, "0.2544"));
}

/* No spring that snaps is followed past its limit point unseen, however long the first step: one
 * that Newton carries over to the far branch is cut. V' = q - 1.2 q^2 + b q^3, and V'' = 0 at the
 * limit point. */
static void no_step_passes_a_limit_point_unseen(void **state) {
  (void)state;
  for (int n = 0; n < 90; n++) {
    const double b = 0.48 * (0.99 - 0.03 * (n % 15)), first_step = n < 45 ? 1 : 0.125;
    const double turn = (2.4 - sqrt(2.4 * 2.4 - 12 * b)) / (6 * b);
    const double critical = turn - 1.2 * turn * turn + b * turn * turn * turn;
    spring s;
    spring_make(&s, 1, -0.4, b / 4);

    // the load is 1.05, 1.5 or 3 times that of the limit point
    const double beyond[3] = {1.05, 1.5, 3};
    double load = beyond[n / 15 % 3] * critical, q = 0;
    thrum_equilibrium_def def = thrum_default_equilibrium_def();
    def.first_step = first_step;
    const answer found = solve_seen(&s.model, &def, &load, &q, NULL);
    assert_int_equal(found.status, THRUM_OK);
    assert_int_equal(found.report.instability, THRUM_INSTABILITY_LIMIT);
    assert_true(fabs(found.report.critical * load - critical) <= 1e-5 * critical);
  }
}

/* A load across the column softens nothing; a second body bends long before it could buckle. */
static void a_load_across_has_no_linear_estimate(void **state) {
  (void)state;
  column c;
  column_make(&c, 1, 100, 5, 3);
  const double load[2] = {1, 0};
  double q[2] = {0};
  const answer found = solve(&c.model, 1, load, q);
  assert_int_equal(found.status, THRUM_OK);
  assert_int_equal(found.report.instability, THRUM_INSTABILITY_NONE);
  assert_true(isnan(found.report.critical_linear));
}

static void wrong_arguments_of_an_equilibrium_are_refused(void **state) {
  (void)state;

  // a spring with a stable equilibrium, and memory that can be misaligned
  spring s;
  spring_make(&s, 1, 0, 0.25);
  thrum_equilibrium_def def = thrum_default_equilibrium_def();
  double load = 1, q = 0.25;
  size_t size = 0;
  thrum_equilibrium_report report;
  assert_int_equal(thrum_equilibrium_size(&s.model, &size, NULL), THRUM_OK);
  char *memory = aligned_alloc(64, size + 64);
  assert_non_null(memory);

  // a definition that was not initialised, and arguments with one thing wrong
#define TRY(def_, load_, q_, memory_, size_)                                                       \
  thrum_equilibrium(&s.model, def_, load_, q_, memory_, size_, &report, NULL)
  def.cookie = 0;
  assert_int_equal(TRY(&def, &load, &q, memory, size), THRUM_UNINITIALISED_DEF);
  def = thrum_default_equilibrium_def();
  assert_int_equal(TRY(&def, NULL, &q, memory, size), THRUM_INVALID_ARGUMENT);
  assert_int_equal(TRY(&def, &load, &q, memory + 8, size), THRUM_MISALIGNED);
  assert_int_equal(TRY(&def, &load, &q, memory, size - 8), THRUM_BUFFER_TOO_SMALL);

  assert_int_equal(TRY(NULL, &load, &q, memory, size), THRUM_UNINITIALISED_DEF);
  assert_int_equal(TRY(&def, &load, NULL, memory, size), THRUM_INVALID_ARGUMENT);
  assert_int_equal(TRY(&def, &load, &q, NULL, size), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_equilibrium(&s.model, &def, &load, &q, memory, size, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_equilibrium_size(&s.model, NULL, NULL), THRUM_INVALID_ARGUMENT);

  // each number of the definition outside its range, and at its end
  const struct {
    double *field, bad[3];
  } numbers[] = {{&def.factor, {0, INFINITY, NAN}},
                 {&def.first_step, {0, 1.01, NAN}},
                 {&def.tolerance, {0, 1.01e-2, NAN}}};
  for (int n = 0; n < 3; n++)
    for (int k = 0; k < 3; k++) {
      const double kept = *numbers[n].field;
      *numbers[n].field = numbers[n].bad[k];
      assert_int_equal(TRY(&def, &load, &q, memory, size), THRUM_INVALID_ARGUMENT);
      *numbers[n].field = kept;
    }
  def.first_step = 1;
  def.tolerance = 1e-2;
  assert_true(TRY(&def, &load, &q, memory, size) >= 0);
  q = 0.25;
  for (int n = 0; n < 4; n++) {
    def = thrum_default_equilibrium_def();
    if (n == 0)
      def.steps_max = 0;
    else if (n == 1)
      def.iterations_max = 0;
    else
      def.stay = n == 2 ? 2 : -1;
    assert_int_equal(TRY(&def, &load, &q, memory, size), THRUM_INVALID_ARGUMENT);
  }
  def = thrum_default_equilibrium_def();

  // numbers that are not finite, a load factor of zero, and too few steps
  q = NAN;
  assert_int_equal(TRY(&def, &load, &q, memory, size), THRUM_BAD_VALUE);
  q = 0.25;
  load = NAN;
  assert_int_equal(TRY(&def, &load, &q, memory, size), THRUM_BAD_VALUE);
  load = 1;
  def.factor = 0;
  assert_int_equal(TRY(&def, &load, &q, memory, size), THRUM_INVALID_ARGUMENT);
  def = thrum_default_equilibrium_def();
  def.steps_max = 1;
  assert_int_equal(TRY(&def, &load, &q, memory, size), THRUM_NOT_CONVERGED);

  // a refusal leaves the coordinate as it was
  assert_true(q == 0.25);
  free(memory);
}

/* Returns the buckling load of a clamped-free column of square section over P = pi^2 E I / (4 L^2).
 * Linear tetrahedra are too stiff in bending; the same factor is in the square of the first
 * frequency, which for a beam is 1.87510^4 E I / (rho A L^4), and divides out. */
static double euler_ratio(int cells_along, int cells_across, double *stiffness) {
  // a beam with its left end clamped
  char spec[80];
  const double young = 2e9, length = 1, side = 0.05, density = 1000;
  snprintf(spec, sizeof spec, "beam:%dx%dx%d@%gx%gx%g", cells_along, cells_across, cells_across,
           length, side, side);
  thrum_mesh mesh;
  thrum_error error;
  if (thrum_mesh_read(spec, 1, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  mesh.materials[0] = (thrum_material){young, 0, density};
  mesh.has_material = true;
  uint8_t *fixed = calloc((size_t)mesh.vertex_count, 1);
  for (int64_t v = 0; v < mesh.vertex_count; v++)
    fixed[v] = mesh.vertices[3 * v] < 1e-9 ? 7 : 0;

  // a reduced model with the bending modes and what they couple to
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 6;
  options.rank = 16;
  thrum_precomputed made;
  if (thrum_precompute(&mesh, fixed, &options, &made, &error) < 0)
    fail_msg("%s", error.message);

  // compressed at its free end far enough to pass the critical load
  double load[2 * RANK_MAX] = {0}, q[2 * RANK_MAX] = {0};
  const double force[3] = {-1000, 0, 0};
  const int32_t *tip = NULL;
  int64_t count = 0;
  assert_int_equal(thrum_model_group(&made.model, "tip", &tip, &count, NULL), THRUM_OK);
  assert_int_equal(thrum_load_add_shared(&made.model, tip, count, force, load, NULL), THRUM_OK);
  const answer found = solve(&made.model, 12, load, q);
  assert_int_equal(found.status, THRUM_OK);

  // both numbers are relative to the beam of Euler and Bernoulli
  const double inertia = pow(side, 4) / 12;
  *stiffness = made.model.omega2[0] * density * side * side * pow(length, 4) /
               (pow(1.87510407, 4) * young * inertia);

  thrum_precomputed_free(&made);
  thrum_mesh_free(&mesh);
  free(fixed);
  return 1000 * found.report.critical / (pi * pi * young * inertia / (4 * length * length));
}

static void a_column_of_tets_buckles_at_eulers_load(void **state) {
  (void)state;
  double coarse_stiffness = 0, fine_stiffness = 0;
  const double coarse = euler_ratio(20, 2, &coarse_stiffness);
  const double fine = euler_ratio(40, 4, &fine_stiffness);
  print_message("P/P_Euler %.4f and %.4f; of the stiffness %.4f and %.4f\n", coarse, fine,
                coarse / coarse_stiffness, fine / fine_stiffness);
  assert_true(fabs(coarse / coarse_stiffness - 1) <= 0.02);
  assert_true(fabs(fine / fine_stiffness - 1) <= 0.02);
  // the error of the locking falls by nearly four when the cells are halved
  assert_true(fine > 1 && (coarse - 1) / (fine - 1) > 3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_small_load_gives_the_linear_answer),
      cmocka_unit_test(the_forces_balance_and_the_energy_is_least),
      cmocka_unit_test(a_hardening_spring_gives_duffings_root),
      cmocka_unit_test(an_enormous_load_is_reached_from_rest),
      cmocka_unit_test(a_stable_answer_does_not_depend_on_the_way),
      cmocka_unit_test(a_start_far_away_ends_in_balance_or_is_refused),

      // buckling and limit points
      cmocka_unit_test(a_column_buckles_where_its_stiffness_ends),
      cmocka_unit_test(a_column_that_is_to_stay_stays_straight),
      cmocka_unit_test(an_arch_snaps_through_at_its_limit_point),
      cmocka_unit_test(no_step_passes_a_limit_point_unseen),
      cmocka_unit_test(a_load_across_has_no_linear_estimate),

      // arguments
      cmocka_unit_test(wrong_arguments_of_an_equilibrium_are_refused),

      // a mesh against Euler's column
      cmocka_unit_test(a_column_of_tets_buckles_at_eulers_load),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
