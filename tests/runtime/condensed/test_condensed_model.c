/* Tests of condensed models: the slaves minimise the energy, velocities and loads are derivatives
 * of how they follow, and what needs a basis refuses a model that is stepped without its slaves.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"

#include "core/base/vec3.h"
#include "thrum/displacement.h"
#include "thrum/external_load.h"
#include "thrum/kernel_pass.h"
#include "thrum/polynomial.h"
#include "thrum/surface.h"

enum { RANK = 9, MASTERS = 4 };

/* V of a model, with work of its own. */
static double energy_of(const thrum_model *model, const double *q) {
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  const double v = thrum_strain_energy(model, q, work);
  free(work);
  return v;
}

/* The terms of V that condensing keeps: those without a slave, one slave times two masters, and the
 * slaves' own stiffness; summed over all monomials. */
static double kept_terms(const thrum_model *model, int64_t masters, const double *q) {
  double sum = 0;
  for (int64_t i = 0; i < model->rank; i++)
    sum += 0.5 * model->omega2[i] * q[i] * q[i];
  for (int64_t i = 0; i < masters; i++)
    for (int64_t j = i; j < masters; j++)
      for (int64_t k = j; k < model->rank; k++) {
        sum += model->c3[thrum_c3_index(model->rank, i, j, k)] * q[i] * q[j] * q[k];
        for (int64_t l = k; l < masters; l++)
          sum += model->c4[thrum_c4_index(model->rank, i, j, k, l)] * q[i] * q[j] * q[k] * q[l];
      }
  return sum;
}

static void the_condensed_energy_is_the_least_over_all_slaves(void **context) {
  (void)context;
  random_model m;
  random_model_make_wild(&m, 11, RANK);
  for (int64_t masters = 1; masters < RANK; masters++) {
    const thrum_model *stepped = NULL;
    void *memory = condense(&m.model, masters, &stepped);
    random_state random = {(uint64_t)masters};
    for (int n = 0; n < 5; n++) {
      // at the slaves' rest both energies agree
      double x[RANK], q[RANK], away[RANK];
      random_vector(&random, masters, 1, x);
      thrum_condensed_shape(stepped, x, NULL, q);
      const double least = kept_terms(&m.model, masters, q);
      assert_true(fabs(energy_of(stepped, x) - least) <= 1e-12 * (1 + fabs(least)));

      // anywhere else there is more of it, by the slaves' stiffness
      memcpy(away, q, sizeof q);
      double more = 0;
      for (int64_t h = masters; h < RANK; h++) {
        const double by = random_uniform(&random);
        away[h] += by;
        more += 0.5 * m.omega2[h] * by * by;
      }
      assert_true(fabs(kept_terms(&m.model, masters, away) - least - more) <=
                  1e-11 * (1 + fabs(least)));
    }
    free(memory);
  }
  random_model_free(&m);
}

static void a_load_on_the_slaves_moves_where_they_rest(void **context) {
  (void)context;
  random_model m;
  random_model_make_wild(&m, 12, RANK);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, MASTERS, &stepped);
  random_state random = {3};
  double x[MASTERS], f[RANK], free_q[RANK], loaded[RANK];
  random_vector(&random, MASTERS, 1, x);
  random_vector(&random, RANK, 1, f);

  // each slave moves by its share of the load over its stiffness, the masters stay
  thrum_condensed_shape(stepped, x, NULL, free_q);
  thrum_condensed_shape(stepped, x, f, loaded);
  for (int64_t i = 0; i < RANK; i++) {
    const double moved = i < MASTERS ? 0 : f[i] / m.omega2[i];
    assert_true(fabs(loaded[i] - free_q[i] - moved) <= 1e-14);
  }
  free(memory);
  random_model_free(&m);
}

static void velocities_are_the_derivative_of_the_shape_and_loads_their_transpose(void **context) {
  (void)context;
  random_model m;
  random_model_make_wild(&m, 13, RANK);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, MASTERS, &stepped);
  random_state random = {5};
  double x[MASTERS], v[MASTERS], f[RANK], p[RANK], reduced[MASTERS];
  random_vector(&random, MASTERS, 1, x);
  random_vector(&random, MASTERS, 1, v);
  random_vector(&random, RANK, 1, f);

  // the shape is quadratic, so its central difference is exact
  double ahead[MASTERS], behind[MASTERS], q_ahead[RANK], q_behind[RANK];
  for (int i = 0; i < MASTERS; i++) {
    ahead[i] = x[i] + 0.5 * v[i];
    behind[i] = x[i] - 0.5 * v[i];
  }
  thrum_condensed_shape(stepped, ahead, NULL, q_ahead);
  thrum_condensed_shape(stepped, behind, NULL, q_behind);
  thrum_condensed_velocity(stepped, x, v, p);
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(p[i] - (q_ahead[i] - q_behind[i])) <= 1e-13);

  // power of the load on all coordinates is that of the reduced one on the masters
  double power = 0, of_masters = 0;
  thrum_condensed_load(stepped, x, f, reduced);
  for (int i = 0; i < RANK; i++)
    power += f[i] * p[i];
  for (int i = 0; i < MASTERS; i++)
    of_masters += reduced[i] * v[i];
  assert_true(fabs(power - of_masters) <= 1e-12);

  // and the share of the inertia is that of these velocities
  double whole = 0, left_out = 0;
  for (int i = 0; i < RANK; i++) {
    whole += p[i] * p[i];
    left_out += i < MASTERS ? 0 : p[i] * p[i];
  }
  assert_true(fabs(thrum_condensed_inertia_share(stepped, x, v) - left_out / whole) <= 1e-14);
  const double still[MASTERS] = {0};
  assert_true(thrum_condensed_inertia_share(stepped, x, still) == 0);
  free(memory);
  random_model_free(&m);
}

/* The force of a load, steps on, and after a snapshot, as the state extrapolates its masters. */
static void a_state_takes_a_load_in_the_middle_of_the_step_to_come(void **context) {
  (void)context;
  random_model m;
  random_model_make_wild(&m, 13, RANK);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, MASTERS, &stepped);
  thrum_state_def def = thrum_default_state_def();
  def.dt = 0.01;
  thrum_state *state = NULL, *twin = NULL;
  assert_int_equal(thrum_state_create(stepped, &def, &state, NULL), THRUM_OK);
  assert_int_equal(thrum_state_create(stepped, &def, &twin, NULL), THRUM_OK);
  random_state random = {5};
  double x[MASTERS], before[MASTERS], middle[MASTERS], load[RANK], reduced[MASTERS], found[MASTERS];
  random_vector(&random, MASTERS, 0.1, x);
  random_vector(&random, RANK, 1, load);
  assert_int_equal(thrum_state_set(stepped, state, x, NULL, NULL), THRUM_OK);
  memcpy(before, x, sizeof before);

  for (int k = 0; k < 5; k++) {
    // no step before the first one says where it goes
    for (int i = 0; i < MASTERS; i++)
      middle[i] = 1.5 * x[i] - 0.5 * before[i];
    thrum_condensed_load(stepped, k > 0 ? middle : x, load, reduced);
    assert_int_equal(thrum_state_reduce_load(stepped, state, load, found, NULL), THRUM_OK);
    assert_memory_equal(found, reduced, sizeof reduced);

    // what is set is that, and a snapshot has it
    assert_true(thrum_state_set_load(stepped, state, load, NULL) >= 0);
    memcpy(before, x, sizeof before);
    assert_true(thrum_step(stepped, state, NULL) >= 0);
    assert_int_equal(thrum_state_get(stepped, state, x, NULL, NULL), THRUM_OK);
    unsigned char kept[1 << 16];
    const size_t size = thrum_state_snapshot_size(state);
    assert_true(size <= sizeof kept);
    assert_int_equal(thrum_state_snapshot(state, kept, size, NULL), THRUM_OK);
    assert_int_equal(thrum_state_restore(stepped, twin, kept, size, NULL), THRUM_OK);
    assert_int_equal(thrum_state_reduce_load(stepped, twin, load, reduced, NULL), THRUM_OK);
    assert_int_equal(thrum_state_reduce_load(stepped, state, load, found, NULL), THRUM_OK);
    assert_memory_equal(found, reduced, sizeof reduced);
  }

  // what is refused leaves the output as it was
  load[RANK - 1] = NAN;
  assert_int_equal(thrum_state_set_load(stepped, state, load, NULL), THRUM_BAD_VALUE);
  assert_int_equal(thrum_state_reduce_load(stepped, state, NULL, found, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_memory_equal(found, reduced, sizeof reduced);
  thrum_state_destroy(state);
  thrum_state_destroy(twin);
  free(memory);
  random_model_free(&m);
}

/* A model as a file of `precompute --condense` gives it: the arrays of `stepped` and its shape. */
static thrum_model as_precomputed(const random_model *m, const thrum_model *stepped) {
  thrum_model model = m->model;
  model.c3 = model.c4 = NULL;
  model.c3_count = model.c4_count = 0;
  model.slave_map = stepped->follow;
  model.condensed_c3 = stepped->c3;
  model.condensed_c4 = stepped->c4;
  model.slave_count = m->model.rank - stepped->rank;
  model.slave_pairs = stepped->rank * (stepped->rank + 1) / 2;
  model.condensed_c3_count = stepped->c3_count;
  model.condensed_c4_count = stepped->c4_count;
  return model;
}

/* A model and a file that was condensed from it make the same models of fewer coordinates: quartic
 * terms agree to rounding, the rest to the bit. */
static void assert_condense_alike(const thrum_model *whole, const thrum_model *file,
                                  int64_t masters) {
  const thrum_model *one = NULL, *other = NULL;
  void *own = condense(whole, masters, &one), *again = condense(file, masters, &other);
  assert_true(largest_difference(one->c3, other->c3, one->c3_count) == 0);
  assert_true(largest_difference(one->c4, other->c4, one->c4_count) <= 1e-12);
  assert_true(largest_difference(one->follow, other->follow,
                                 (RANK - masters) * masters * (masters + 1) / 2) == 0);
  free(own);
  free(again);
}

static void a_model_that_was_precomputed_condensed_gives_the_same_models(void **context) {
  (void)context;
  random_model m;
  random_model_make_wild(&m, 14, RANK);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, 6, &stepped);
  const thrum_model file = as_precomputed(&m, stepped);
  assert_int_equal(thrum_model_check(&file, NULL), THRUM_OK);
  assert_int_equal(thrum_model_masters(&file), 6);
  assert_int_equal(thrum_model_masters(&m.model), 0);

  // all of its masters, or fewer
  for (int64_t masters = 1; masters <= 6; masters++)
    assert_condense_alike(&m.model, &file, masters);

  // coordinates that are slaves in the file cannot be stepped, and neither can the file itself
  size_t size;
  thrum_error error;
  assert_int_equal(thrum_model_condense_size(&file, 7, &size, &error), THRUM_INVALID_ARGUMENT);
  thrum_state_def def = thrum_default_state_def();
  assert_int_equal(thrum_state_size(&file, &def, &size, &error), THRUM_MISSING);
  assert_non_null(strstr(error.message, "thrum_model_condense"));
  assert_int_equal(thrum_model_lock_size(&file, 3, &size, &error), THRUM_INVALID_ARGUMENT);

  free(memory);
  random_model_free(&m);
}

/* A file that was precomputed condensed has no V of all its coordinates: what has no status says
 * so by NaN, and the passes by theirs. */
static void a_file_without_a_polynomial_evaluates_to_nan(void **context) {
  (void)context;
  random_model m;
  random_model_make_wild(&m, 17, RANK);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, 6, &stepped);
  const thrum_model file = as_precomputed(&m, stepped);
  double q[RANK] = {0}, force[RANK] = {0}, product[RANK] = {0}, tangent[RANK * RANK] = {0};
  double *work = random_alloc((int64_t)thrum_work_count(&file), sizeof(double));

  // nothing but NaN comes out, also at rest
  assert_true(isnan(thrum_strain_energy(&file, q, work)));
  assert_true(isnan(thrum_internal_force(&file, q, force, work)));
  thrum_tangent_product(&file, q, q, product, work);
  thrum_tangent_stiffness(&file, q, tangent, work);
  for (int i = 0; i < RANK; i++)
    assert_true(isnan(force[i]) && isnan(product[i]));
  for (int i = 0; i < RANK * RANK; i++)
    assert_true(isnan(tangent[i]));

  // each pass has a status
  double *result = random_alloc((int64_t)thrum_pass_result_count(&file), sizeof(double));
  thrum_error error;
  for (int pass = 0; pass < THRUM_PASS_COUNT; pass++) {
    assert_int_equal(
        thrum_pass_run(&file, THRUM_KERNEL_BEST, (thrum_pass)pass, 2, q, q, result, work, &error),
        THRUM_MISSING);
    assert_non_null(strstr(error.message, "thrum_model_condense"));
  }
  free(result);
  free(work);
  free(memory);
  random_model_free(&m);
}

static void arrays_of_a_condensed_model_that_do_not_fit_are_refused(void **context) {
  (void)context;
  random_model m;
  random_model_make_wild(&m, 15, RANK);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, 6, &stepped);
  thrum_error error;

  // each case breaks one rule of the arrays
  thrum_model bad = as_precomputed(&m, stepped);
  bad.condensed_c4 = NULL;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_MISSING);
  bad = as_precomputed(&m, stepped);
  bad.c3 = m.c3;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_BAD_SHAPE);
  bad = as_precomputed(&m, stepped);
  bad.slave_pairs--;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_BAD_SHAPE);
  assert_non_null(strstr(error.message, "slave_map"));
  bad = as_precomputed(&m, stepped);
  double omega2[RANK];
  memcpy(omega2, m.model.omega2, sizeof omega2);
  omega2[6] = -1; // what follows ascends by itself
  bad.omega2 = omega2;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "negative"));
  bad = as_precomputed(&m, stepped);
  bad.slave_count = RANK;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_BAD_SHAPE);

  // masters as many as coordinates, with all else that fits: nothing would follow
  bad = as_precomputed(&m, stepped);
  bad.slave_count = 0;
  bad.slave_pairs = RANK * (RANK + 1) / 2;
  bad.condensed_c3 = m.model.c3;
  bad.condensed_c4 = m.model.c4;
  bad.condensed_c3_count = m.model.c3_count;
  bad.condensed_c4_count = m.model.c4_count;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_BAD_SHAPE);
  assert_non_null(strstr(error.message, "'slave_map' has 0 rows"));

  bad = m.model;
  bad.slave_count = 2;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_BAD_SHAPE);
  bad = m.model;
  bad.c4 = NULL;
  assert_int_equal(thrum_model_check(&bad, &error), THRUM_MISSING);

  free(memory);
  random_model_free(&m);
}

static void what_needs_a_basis_refuses_the_stepped_model(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 16, RANK, 5, 200, 1.0);
  random_model_add_mesh(&m, 5, 7);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, MASTERS, &stepped);
  assert_ptr_equal(thrum_condensed_shape_model(stepped), &m.model);
  assert_ptr_equal(thrum_condensed_shape_model(&m.model), &m.model);

  // displacements and loads of the stepped model would lack the slaves
  thrum_error error;
  double q[RANK] = {0}, u[3];
  const double down[3] = {0, 0, -9.81};
  assert_int_equal(thrum_displacement(stepped, q, 0, 1, u, &error), THRUM_MISSING);
  assert_int_equal(thrum_load_add_gravity(stepped, down, q, &error), THRUM_MISSING);
  const double positions[3] = {0};
  const float rows[3 * RANK] = {0};
  const thrum_surface_def def = {
      .vertex_count = 1, .positions = positions, .rows = rows, .row_rank = RANK};
  size_t size;
  assert_int_equal(thrum_surface_size(stepped, &def, &size, &error), THRUM_MISSING);

  // nor is a lower rank of it one, whose slaves would not fit
  assert_int_equal(thrum_model_lock_size(stepped, MASTERS - 1, &size, &error),
                   THRUM_INVALID_ARGUMENT);

  // what is condensed already has no slaves left to give
  assert_int_equal(thrum_model_condense_size(stepped, 2, &size, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_condense_size(&m.model, RANK, &size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_condense_size(&m.model, 0, &size, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_condense_size(NULL, 2, &size, &error), THRUM_INVALID_ARGUMENT);

  // memory that does not fit
  const thrum_model *made = NULL;
  assert_int_equal(thrum_model_condense_size(&m.model, 2, &size, &error), THRUM_OK);
  unsigned char *own = aligned_alloc(64, size + 64);
  assert_non_null(own);
  assert_int_equal(thrum_model_condense(own, size - 1, &m.model, 2, &made, &error),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_model_condense(own + 8, size, &m.model, 2, &made, &error),
                   THRUM_MISALIGNED);
  assert_null(made);
  free(own);
  free(memory);
  random_model_free(&m);
}

static void the_energy_scheme_keeps_the_energy_of_a_condensed_model(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 17, 12, 5, 200, 1.0);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, 3, &stepped);
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = 0.01;

  // 2000 steps from a start that moves all masters
  thrum_state *state = state_make(stepped, &def);
  static const double q[3] = {0.3, -0.2, 0.1}, p[3] = {1, 0.5, -0.5};
  thrum_energies before, after;
  state_put(stepped, state, q, p);
  assert_int_equal(thrum_state_energies(stepped, state, &before, NULL), THRUM_OK);
  state_steps(stepped, state, 2000);
  assert_int_equal(thrum_state_energies(stepped, state, &after, NULL), THRUM_OK);
  assert_true(fabs(after.total - before.total) <= 1e-9 * before.total);
  state_free(state);
  free(memory);
  random_model_free(&m);
}

/* A model with one thing wrong is not condensed, and outputs stay. */
/* A model with a mesh on which coordinates 4 and 5 stretch, having no quartic energy of their own,
 * and no other does. */
static void stretching_model_make(random_model *m, uint64_t seed) {
  random_model_make_wild(m, seed, RANK);
  random_model_add_mesh(m, 5, 7);
  m->material[0] = 1e12;
  for (int64_t i = 0; i < RANK; i++)
    m->c4[thrum_c4_index(RANK, i, i, i, i)] = i == 4 || i == 5 ? 0 : 1;
}

static void stretching_masters_at_rest_have_the_energy_of_condensing_them(void **context) {
  (void)context;
  random_model m;
  stretching_model_make(&m, 21);
  const thrum_model *bends = NULL, *both = NULL;
  void *few = condense(&m.model, 4, &bends), *more = condense(&m.model, 6, &both);
  random_state random = {21};

  for (int n = 0; n < 20; n++) {
    // coordinates 4 and 5 where they would follow, with the same ones following behind
    double x[6], q[RANK], q_both[RANK];
    random_vector(&random, 4, 1, x);
    thrum_condensed_shape(bends, x, NULL, q);
    x[4] = q[4];
    x[5] = q[5];
    thrum_condensed_shape(both, x, NULL, q_both);
    assert_true(largest_difference(q, q_both, RANK) <= 1e-13);
    const double v = energy_of(bends, x), v_both = energy_of(both, x);
    assert_true(fabs(v - v_both) <= 1e-12 * (1 + fabs(v)));

    // and that is the least over both, which V_c is bounded by
    x[4] += 0.1;
    const double away = energy_of(both, x) - v;
    assert_true(fabs(away - 0.005 * m.omega2[4]) <= 1e-9 * (1 + fabs(v)));
  }
  free(few);
  free(more);

  // a model without a mesh does not say what stretches: all of its masters are of one order
  m.model.tets = NULL;
  more = condense(&m.model, 6, &both);
  assert_true(both->follow[19] != 0); /* coordinates 4 and 5 */
  free(more);
  random_model_free(&m);
}

static void a_master_stretches_from_a_share_of_the_energy_of_strains_of_one(void **context) {
  (void)context;
  random_model m;
  stretching_model_make(&m, 23);

  // half of Young's modulus times the volume of all tetrahedra but the last, which is not counted
  double whole = 0, edge[3][3];
  m.model.tet_count--;
  for (int64_t t = 0; t < m.model.tet_count; t++) {
    for (int e = 0; e < 3; e++)
      thrum_subtract3(m.vertices + 3 * m.tets[4 * t + e + 1], m.vertices + 3 * m.tets[4 * t],
                      edge[e]);
    whole += 0.5 * m.material[0] * fabs(thrum_triple3(edge[0], edge[1], edge[2])) / 6;
  }

  // coordinate 4 has as much quartic energy as quadratic at w^4 / (4 c4): 0.05 of the whole
  const double limit = m.omega2[4] * m.omega2[4] / (4 * 0.05 * whole);
  m.c4[thrum_c4_index(RANK, 5, 5, 5, 5)] = 1;
  for (int side = -1; side <= 1; side += 2) {
    m.c4[thrum_c4_index(RANK, 4, 4, 4, 4)] = limit * (1 + side * 1e-9);
    const thrum_model *stepped = NULL;
    void *memory = condense(&m.model, 6, &stepped);

    // what follows a master that stretches and another is left out
    assert_true((stepped->follow[19] == 0) == (side < 0)); /* coordinates 4 and 5 */
    free(memory);
  }
  random_model_free(&m);
}

static void a_file_of_stretching_masters_gives_the_same_models(void **context) {
  (void)context;
  random_model m;
  stretching_model_make(&m, 22);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, 6, &stepped);
  const thrum_model file = as_precomputed(&m, stepped);

  for (int64_t masters = 3; masters <= 6; masters++)
    assert_condense_alike(&m.model, &file, masters);
  free(memory);
  random_model_free(&m);
}

static void what_cannot_be_condensed_is_refused(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 31, RANK, 5, 200, 1);
  size_t size = 7;
  const thrum_model *condensed = NULL;
  const struct {
    int64_t masters;
    thrum_status expected;
  } counts[] = {{0, THRUM_INVALID_ARGUMENT},
                {-1, THRUM_INVALID_ARGUMENT},
                {RANK, THRUM_INVALID_ARGUMENT},
                {RANK - 1, THRUM_OK},
                {1, THRUM_OK}};
  for (size_t n = 0; n < sizeof counts / sizeof counts[0]; n++) {
    size = 7;
    assert_int_equal(thrum_model_condense_size(&m.model, counts[n].masters, &size, NULL),
                     counts[n].expected);
    assert_true((size == 7) == (counts[n].expected != THRUM_OK));
  }

  // a model that lacks something, and arguments that are NULL
  thrum_model wrong = m.model;
  wrong.omega2 = NULL;
  assert_int_equal(thrum_model_condense_size(&wrong, 2, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_condense_size(NULL, 2, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_condense_size(&m.model, 2, NULL, NULL), THRUM_INVALID_ARGUMENT);
  for (int n = 0; n < 4; n++) {
    wrong = m.model;
    if (n == 0)
      wrong.c3 = NULL;
    else if (n == 1)
      wrong.c4 = NULL;
    else
      wrong.rank = n == 2 ? 0 : THRUM_RANK_MAX + 1;
    assert_int_equal(thrum_model_condense_size(&wrong, 2, &size, NULL),
                     n < 2 ? THRUM_MISSING : THRUM_INVALID_ARGUMENT);
  }

  // coordinates that follow at rest need a stiffness, those that are stepped do not
  for (int i = 0; i < RANK; i++) {
    double omega2[RANK];
    memcpy(omega2, m.model.omega2, sizeof omega2);
    omega2[i] = 0;
    wrong = m.model;
    wrong.omega2 = omega2;
    assert_int_equal(thrum_model_condense_size(&wrong, MASTERS, &size, NULL),
                     i < MASTERS ? THRUM_OK : THRUM_BAD_VALUE);
  }

  // memory that does not do, and a model that is condensed already
  assert_int_equal(thrum_model_condense_size(&m.model, MASTERS, &size, NULL), THRUM_OK);
  unsigned char *memory = aligned_alloc(64, (size + 127) / 64 * 64);
  assert_non_null(memory);
  assert_int_equal(thrum_model_condense(memory, size - 1, &m.model, MASTERS, &condensed, NULL),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_model_condense(memory + 8, size, &m.model, MASTERS, &condensed, NULL),
                   THRUM_MISALIGNED);
  assert_int_equal(thrum_model_condense(NULL, size, &m.model, MASTERS, &condensed, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_condense(memory, size, &m.model, MASTERS, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_null(condensed);
  assert_int_equal(thrum_model_condense(memory, size, &m.model, MASTERS, &condensed, NULL),
                   THRUM_OK);
  size = 7;
  assert_int_equal(thrum_model_condense_size(condensed, 2, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_lock_size(condensed, 2, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(size, 7);
  free(memory);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_condensed_energy_is_the_least_over_all_slaves),
      cmocka_unit_test(a_load_on_the_slaves_moves_where_they_rest),
      cmocka_unit_test(velocities_are_the_derivative_of_the_shape_and_loads_their_transpose),
      cmocka_unit_test(a_state_takes_a_load_in_the_middle_of_the_step_to_come),
      cmocka_unit_test(a_model_that_was_precomputed_condensed_gives_the_same_models),
      cmocka_unit_test(stretching_masters_at_rest_have_the_energy_of_condensing_them),
      cmocka_unit_test(a_master_stretches_from_a_share_of_the_energy_of_strains_of_one),
      cmocka_unit_test(a_file_of_stretching_masters_gives_the_same_models),
      cmocka_unit_test(what_cannot_be_condensed_is_refused),
      cmocka_unit_test(a_file_without_a_polynomial_evaluates_to_nan),
      cmocka_unit_test(arrays_of_a_condensed_model_that_do_not_fit_are_refused),
      cmocka_unit_test(what_needs_a_basis_refuses_the_stepped_model),
      cmocka_unit_test(the_energy_scheme_keeps_the_energy_of_a_condensed_model),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
