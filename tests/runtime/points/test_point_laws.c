/* Tests of cubature points that answer by another law than Saint Venant-Kirchhoff's, or by that of
 * their region: closed forms of one point, derivatives of the energy, the same bits from every
 * kernel, and every integrator.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/points_support.h"

#include "runtime/points/kernel_points.h"
#include "tests/support/closed_forms.h"

static const char *const laws[] = {"corotational", "neo-hookean", "by region"};
static const uint8_t region_laws[] = {THRUM_LAW_STVK, THRUM_LAW_COROTATIONAL,
                                      THRUM_LAW_NEO_HOOKEAN};
enum { LAW_COUNT = 3, RANK = 9 };

/* A model whose gradients are so large that q of order 1 deforms by half of itself, or so. */
static void law_make(both *made, const char *law, uint64_t seed, int64_t rank, int64_t count) {
  points_make(made, seed, rank, count, 0.2);
  if (strcmp(law, "by region") == 0)
    points_obey_regions(made, region_laws);
  else
    points_obey(made, law);
  made->points.identity = thrum_model_identity(&made->points);
}

/* Something has flowed at each point; returns the memory, for the caller to free. */
static double *law_flow(both *made, uint64_t seed) {
  const int64_t count = 9 * made->points.point_count;
  const int64_t all = thrum_points_plastic_count(&made->points);
  double *plastic = random_alloc(all, sizeof *plastic);
  random_state random = {seed ^ 7};
  random_vector(&random, count, 0.1, plastic);
  memset(plastic + count, 0, (size_t)(all - count) * sizeof *plastic);
  made->points.point_plastic = plastic;
  return plastic;
}

/* P of one point whose coordinates are the nine components of its gradient. */
static void stress_at(const both *made, const double g[9], double stress[9]) {
  double force[9], *work = random_alloc((int64_t)thrum_work_count(&made->points), sizeof *work);
  const double lambda = made->moduli[0], mu = made->moduli[1];
  thrum_internal_force(&made->points, g, force, work);

  // what the points say beside the frequencies, and the stress of small strains that these stand
  // for
  for (int c = 0; c < 9; c++) {
    const double trace = c % 4 == 0 ? g[0] + g[4] + g[8] : 0;
    stress[c] = (force[c] - made->points.omega2[c] * g[c]) / made->weights[0] + lambda * trace +
                mu * (g[c] + g[3 * (c % 3) + c / 3]);
  }
  free(work);
}

static void tension_and_shear_of_a_point_are_the_closed_forms(void **context) {
  (void)context;
  for (int law = THRUM_LAW_COROTATIONAL; law <= THRUM_LAW_NEO_HOOKEAN; law++) {
    both made;
    points_make(&made, 3, RANK, 1, 1);
    points_obey(&made, thrum_law_name((thrum_law)law));
    for (int c = 0; c < 81; c++)
      made.gradients[c] = c % 10 == 0 ? 1 : 0;
    const double lambda = made.moduli[0], mu = made.moduli[1];
    double stress[9], t;

    // pulled and pressed along x, free across
    for (double s = 0.6; s < 1.5; s += 0.3) {
      const double along = tension_form((thrum_law)law, lambda, mu, s, &t);
      const double g[9] = {s - 1, 0, 0, 0, t - 1, 0, 0, 0, t - 1};
      stress_at(&made, g, stress);
      assert_true(fabs(stress[0] - along) <= 1e-10 * mu && fabs(stress[4]) <= 1e-10 * mu);
    }

    // x moves by k y
    for (double k = 0.2; k < 2; k += 0.6) {
      const double g[9] = {0, k};
      const shear_stress shear = shear_form((thrum_law)law, lambda, mu, k);
      stress_at(&made, g, stress);
      assert_true(fabs(stress[1] - shear.xy) <= 1e-10 * mu);
      assert_true(fabs(stress[3] - shear.yx) <= 1e-10 * mu);
    }
    both_free(&made);
  }
}

/* Fourth-order central differences: weights of +-h and +-2h. */
static const double weights[] = {1.0 / 12, -2.0 / 3, 0, 2.0 / 3, -1.0 / 12};

/* Force and tangent against differences of energy and force. */
static void assert_derivatives(const thrum_model *model, double *q, const outcome *o) {
  const double h = 1e-3;
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof *work);
  for (int64_t i = 0; i < model->rank; i++) {
    const double middle = q[i];
    double slope = 0, row[MOST] = {0}, force[MOST];

    // differences of fourth order along coordinate i
    for (int k = -2; k <= 2; k++) {
      q[i] = middle + k * h;
      slope += weights[k + 2] / h * thrum_internal_force(model, q, force, work);
      for (int64_t j = 0; j < model->rank; j++)
        row[j] += weights[k + 2] / h * force[j];
    }
    q[i] = middle;

    assert_true(fabs(slope - o->force[i]) <= 1e-8);
    assert_true(largest_difference(row, o->tangent + i * model->rank, model->rank) <= 1e-7);
  }
  free(work);
}

static void force_and_tangent_are_derivatives_and_all_passes_agree(void **context) {
  (void)context;
  outcome *o = random_alloc(1, sizeof *o), *held = random_alloc(1, sizeof *held);
  for (int n = 0; n < 2 * LAW_COUNT; n++) {
    both made;
    law_make(&made, laws[n % LAW_COUNT], (uint64_t)n, RANK, 3 + 8 * (n / LAW_COUNT));
    double *plastic = n >= LAW_COUNT ? law_flow(&made, (uint64_t)n) : NULL;
    const int32_t split = 2 + n;

    // where it moves, and how
    random_state random = {(uint64_t)n};
    double q[MOST], v[MOST], product[MOST] = {0};
    random_vector(&random, RANK, 1, q);
    random_vector(&random, RANK, 1, v);
    evaluate(&thrum_kernel_reference, &made.points, split, q, v, o);
    assert_derivatives(&made.points, q, o);

    // the other passes say the same
    for (int i = 0; i < RANK; i++)
      for (int j = 0; j < RANK; j++)
        product[i] += o->tangent[i * RANK + j] * v[j];
    assert_near(o->product, product, RANK);
    assert_near(&o->with_force, &o->energy, 1);
    assert_near(o->tangent_force, o->force, RANK);
    assert_near(o->forces[1], o->force, RANK);
    assert_near(o->force_part, o->force, split);

    // the first coordinates are held, and the others lie at the first entries of v
    memcpy(q + split, v, sizeof(double) * (size_t)(RANK - split));
    evaluate(&thrum_kernel_reference, &made.points, split, q, v, held);
    assert_near(o->gradient, held->force + split, RANK - split);
    free(plastic);
    both_free(&made);
  }
  free(o);
  free(held);
}

static void every_kernel_gives_the_same_bits(void **context) {
  (void)context;
  static const int64_t ranks[] = {1, 8, 9, 17, MOST};
  outcome *found = random_alloc(1, sizeof *found), *expected = random_alloc(1, sizeof *expected);
  for (int n = 0; n < 5 * LAW_COUNT; n++) {
    both made;
    const int64_t rank = ranks[n / LAW_COUNT];
    law_make(&made, laws[n % LAW_COUNT], (uint64_t)n, rank, 1 + 5 * n);
    double *plastic = n % (2 * LAW_COUNT) >= LAW_COUNT ? law_flow(&made, (uint64_t)n) : NULL;
    const int32_t split = (int32_t)(rank / 2);

    // what plain C says is what all others must say
    random_state random = {(uint64_t)n};
    double q[MOST], v[MOST];
    random_vector(&random, rank, 1, q);
    random_vector(&random, rank, 1, v);
    evaluate(&thrum_kernel_reference, &made.points, split, q, v, expected);

    // also of gradients that are packed
    thrum_model packed = made.points;
    void *memory = pack(&packed);
    for (int id = THRUM_KERNEL_REFERENCE; thrum_kernel_name((thrum_kernel_id)id); id++) {
      if (!thrum_kernel_usable((thrum_kernel_id)id))
        continue;
      evaluate(thrum_kernel_get(id), &made.points, split, q, v, found);
      assert_memory_equal(found, expected, sizeof *found);
      evaluate(thrum_kernel_get(id), &packed, split, q, v, found);
      assert_memory_equal(found, expected, sizeof *found);
    }
    free(memory);
    free(plastic);
    both_free(&made);
  }
  free(found);
  free(expected);
}

static void derivatives_at_rest_are_those_of_the_force(void **context) {
  (void)context;
  for (int n = 0; n < LAW_COUNT; n++) {
    both made;
    law_make(&made, laws[n], 5, RANK, 11);
    double *work = random_alloc((int64_t)thrum_work_count(&made.points), sizeof *work);

    for (int j = 0; j < RANK; j++) {
      // even parts of force and energy along one coordinate
      const double h = 1e-2;
      double c3[RANK], c4, q[RANK] = {0}, force[2][RANK], energy = 0;
      thrum_points_along(&made.points, j, c3, &c4);
      for (int k = 0; k < 2; k++) {
        q[j] = k == 0 ? h : -h;
        energy += thrum_internal_force(&made.points, q, force[k], work);
      }

      // beyond the quadratic term the energy has the quartic one, and the force the cubic one
      const double quartic = (energy - made.points.omega2[j] * h * h) / (2 * h * h * h * h);
      assert_true(fabs(c4 - quartic) <= 1e-3 * fabs(quartic));
      for (int s = 0; s < RANK; s++)
        assert_true(fabs(c3[s] - (force[0][s] + force[1][s]) / (2 * h * h)) <= 1e-3);
    }
    free(work);
    both_free(&made);
  }
}

/* The end of a run of 1 s from `start`. */
static void run(const both *made, const thrum_state_def *def, const double *start, double *q) {
  double zero[RANK] = {0}, p[RANK];
  thrum_state *state = state_make(&made->points, def);
  state_put(&made->points, state, start, zero);
  state_steps(&made->points, state, (int64_t)lround(1 / def->dt));
  state_read(&made->points, state, q, p);
  state_free(state);
}

static void every_integrator_steps_the_same_motion(void **context) {
  (void)context;
  for (int n = 0; n < LAW_COUNT; n++) {
    both made;
    law_make(&made, laws[n], 5, RANK, 20);
    random_state random = {8};
    double start[RANK], q[2][RANK];
    random_vector(&random, RANK, 1, start);

    // as many steps as Runge and Kutta need to be exact
    thrum_state_def def = thrum_default_state_def();
    def.integrator = THRUM_INTEGRATOR_RK4;
    def.dt = 0.01;
    run(&made, &def, start, q[0]);
    for (int k = 0; k < INTEGRATOR_COUNT; k++) {
      def.integrator = every_integrator[k];
      const bool first_order = strstr(thrum_integrator_name(every_integrator[k]), "euler") != NULL;
      def.dt = 0.005;
      run(&made, &def, start, q[1]);
      assert_true(largest_difference(q[0], q[1], RANK) <= (first_order ? 3e-2 : 3e-4));
    }
    both_free(&made);
  }
}

static void the_energy_integrator_keeps_the_energy_to_rounding(void **context) {
  (void)context;
  enum { STEPS = 6000 };
  for (int n = 0; n < LAW_COUNT; n++) {
    both made;
    law_make(&made, laws[n], 6, RANK, 12);

    // a swing that strains by about a third
    random_state random = {9};
    double start[RANK], zero[RANK] = {0};
    random_vector(&random, RANK, 1, start);
    thrum_state_def def = thrum_default_state_def();
    def.integrator = THRUM_INTEGRATOR_ENERGY;
    def.dt = 0.3;
    thrum_state *state = state_make(&made.points, &def);
    state_put(&made.points, state, start, zero);
    const double before = state_energy(&made.points, state).total;
    for (int k = 0; k < 20; k++) {
      state_steps(&made.points, state, STEPS / 20);
      assert_true(fabs(state_energy(&made.points, state).total / before - 1) < 1e-13);
    }
    state_free(state);
    both_free(&made);
  }
}

static void the_average_vector_field_keeps_it_at_standstills_too(void **context) {
  (void)context;
  for (int n = 0; n < LAW_COUNT; n++) {
    both made;
    law_make(&made, laws[n], 11, 1, 3);

    // the tangent form of damping takes this mean force; of so little nothing is lost
    thrum_state_def def = thrum_default_state_def();
    def.integrator = THRUM_INTEGRATOR_ENERGY;
    def.damping_form = THRUM_DAMPING_TANGENT;
    def.damping_beta = 1e-30;
    def.dt = 0.8;
    for (int k = 0; k < 20; k++) {
      // one coordinate turns back again and again, each time elsewhere in a step
      const double start = 4 + 0.1 * k, zero = 0;
      thrum_state *state = state_make(&made.points, &def);
      state_put(&made.points, state, &start, &zero);
      const double before = state_energy(&made.points, state).total;
      for (int step = 0; step < 200; step++) {
        state_steps(&made.points, state, 1);
        const double now = state_energy(&made.points, state).total;
        if (!(fabs(now / before - 1) < 1e-11))
          fail_msg("%s, start %g, step %d: %g", laws[n], start, step, now / before - 1);
      }
      state_free(state);
    }
    both_free(&made);
  }
}

static void check_lower_and_scaled(const char *law) {
  enum { LOWER = 5 };
  both made;
  law_make(&made, law, 7, RANK, 11);
  random_state random = {3};
  double q[RANK], force[2][RANK],
      *work = random_alloc((int64_t)thrum_work_count(&made.points), sizeof *work);
  random_vector(&random, RANK, 1, q);
  for (int i = LOWER; i < RANK; i++)
    q[i] = 0;
  const double whole = thrum_internal_force(&made.points, q, force[0], work);

  // the others are held at zero
  size_t size = 0;
  const thrum_model *found = NULL;
  assert_int_equal(thrum_model_lock_size(&made.points, LOWER, &size, NULL), THRUM_OK);
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_int_equal(thrum_model_lock(memory, size, &made.points, LOWER, &found, NULL), THRUM_OK);
  const double lower = thrum_internal_force(found, q, force[1], work);
  assert_near(&lower, &whole, 1);
  assert_near(force[1], force[0], LOWER);
  free(memory);

  // V'(q') = e s^3 V(q) with q' = q s^5/2 d^1/2
  const thrum_model_scaling by = {4, 3, 0.25};
  assert_int_equal(thrum_model_scale_size(&made.points, &size, NULL), THRUM_OK);
  memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_int_equal(thrum_model_scale(memory, size, &made.points, &by, &found, NULL), THRUM_OK);
  for (int i = 0; i < RANK; i++)
    q[i] *= 32 * 0.5;
  const double scaled = thrum_strain_energy(found, q, work), expected = 3 * 64 * whole;
  assert_near(&scaled, &expected, 1);
  free(memory);
  free(work);

  // a model that differs in its law alone is another one
  const uint64_t identity = thrum_model_identity(&made.points);
  const uint8_t others[] = {THRUM_LAW_STVK, THRUM_LAW_NEO_HOOKEAN, THRUM_LAW_NEO_HOOKEAN};
  points_obey_regions(&made, others);
  assert_true(thrum_model_identity(&made.points) != identity);
  both_free(&made);
}

static void lower_ranks_and_scales_keep_the_law(void **context) {
  (void)context;
  for (int n = 0; n < LAW_COUNT; n++)
    check_lower_and_scaled(laws[n]);
}

static void regions_of_one_law_have_the_bits_of_a_body_of_that_law(void **context) {
  (void)context;
  outcome *found = random_alloc(1, sizeof *found), *expected = random_alloc(1, sizeof *expected);
  for (uint8_t law = THRUM_LAW_STVK; law < THRUM_LAW_BY_REGION; law++) {
    both made;
    const uint8_t same[] = {law, law, law};
    law_make(&made, thrum_law_name((thrum_law)law), law, RANK, 35);
    random_state random = {law};
    double q[RANK], v[RANK];
    random_vector(&random, RANK, 1, q);
    random_vector(&random, RANK, 1, v);

    // the law of the whole body first, then the same as that of each region
    evaluate(&thrum_kernel_reference, &made.points, 4, q, v, expected);
    points_obey_regions(&made, same);
    evaluate(&thrum_kernel_reference, &made.points, 4, q, v, found);
    assert_memory_equal(found, expected, sizeof *found);
    both_free(&made);
  }
  free(found);
  free(expected);
}

static void the_energy_of_regions_is_the_sum_of_theirs(void **context) {
  (void)context;
  both made;
  law_make(&made, "by region", 12, RANK, 41);
  const thrum_model mixed = made.points;
  double q[RANK], quadratic = 0, *work = random_alloc((int64_t)thrum_work_count(&mixed), 8);
  random_state random = {12};
  random_vector(&random, RANK, 1, q);
  for (int i = 0; i < RANK; i++)
    quadratic += 0.5 * mixed.omega2[i] * q[i] * q[i];

  // a body of one law that has the points of one region alone
  double sum = quadratic, all = thrum_strain_energy(&mixed, q, work);
  for (int region = 0; region < 3; region++) {
    double volumes[41], moduli[82], *gradients = random_alloc(9 * 41 * RANK, sizeof *gradients);
    int64_t count = 0;
    for (int64_t p = 0; p < 41; p++)
      count += mixed.point_region[p] == region;
    for (int64_t p = 0, n = 0; p < 41; p++) {
      if (mixed.point_region[p] != region)
        continue;
      volumes[n] = mixed.point_weights[p];
      moduli[n] = mixed.point_moduli[p];
      moduli[count + n] = mixed.point_moduli[41 + p];
      memcpy(gradients + 9 * n * RANK, mixed.point_gradients + 9 * p * RANK,
             9 * RANK * sizeof *gradients);
      n++;
    }
    both part = made;
    part.points.point_region = NULL;
    part.points.region_law = NULL;
    part.points.law_count = 0;
    part.points.point_count = count;
    part.points.point_weights = volumes;
    part.points.point_moduli = moduli;
    part.points.point_gradients = gradients;
    points_obey(&part, thrum_law_name((thrum_law)region_laws[region]));
    sum += thrum_strain_energy(&part.points, q, work) - quadratic;
    free(gradients);
  }
  assert_true(fabs(sum - all) <= 1e-12 * all);
  free(work);
  both_free(&made);
}

/* Refused with this status and these words. */
static void assert_refused(const thrum_model *model, thrum_status status, const char *words) {
  thrum_error error;
  assert_int_equal(thrum_model_check(model, &error), status);
  if (!strstr(error.message, words))
    fail_msg("%s", error.message);
}

static void a_law_that_is_unknown_or_has_no_points_is_refused(void **context) {
  (void)context;
  both made;
  law_make(&made, "neo-hookean", 4, 3, 5);
  thrum_model bad = made.points;
  bad.point_law = (const uint8_t *)"rubber";
  bad.law_bytes = 7;
  assert_refused(&bad, THRUM_BAD_VALUE, "holds none of the names stvk, corotational");
  bad.point_law = made.points.point_law;
  bad.law_bytes = 11;
  assert_refused(&bad, THRUM_BAD_VALUE, "ended by one 0");
  bad.point_law = NULL;
  assert_refused(&bad, THRUM_BAD_SHAPE, "law_bytes is not 0");

  // a polynomial cannot hold it, and no reader may overlook it
  bad = made.m.model;
  bad.format = made.points.format;
  bad.point_law = made.points.point_law;
  bad.law_bytes = made.points.law_bytes;
  assert_refused(&bad, THRUM_MISSING, "a polynomial cannot hold it");
  static const int32_t format[2] = {1, 3};
  bad = made.points;
  bad.format = format;
  assert_refused(&bad, THRUM_BAD_VALUE, "a model with 'point_law' has version 3");
  both_free(&made);
}

static void a_training_that_cannot_be_is_refused(void **context) {
  (void)context;
  both made;
  law_make(&made, "neo-hookean", 4, 3, 5);
  static const double negative[] = {0.3, -1, 0, 0}, neither[] = {0.3, 0, 0, 0.5};
  thrum_model bad = made.points;
  bad.point_training = negative;
  assert_refused(&bad, THRUM_BAD_VALUE,
                 "array 'point_training' holds -1 (entry 1); strains are >= 0");
  bad.point_training = neither;
  assert_refused(&bad, THRUM_BAD_VALUE, "0 or 1 is allowed there");

  // it is that of points
  bad = made.m.model;
  bad.point_training = negative;
  assert_refused(&bad, THRUM_MISSING, "'point_training' is that of cubature points");
  both_free(&made);
}

static void laws_of_regions_that_cannot_be_are_refused(void **context) {
  (void)context;
  both made;
  law_make(&made, "by region", 4, 3, 5);
  static const uint8_t unknown[] = {0, 1, 3};
  static const double yields[] = {0, 0.02, 0}, negative[] = {0, -1, 0}, stiff[] = {0.02, 0, 0};
  static const int32_t outside[] = {0, 1, 2, 3, 0}, below[] = {0, 1, 2, 0, -1};
  thrum_model bad = made.points;
  bad.region_law = unknown;
  assert_refused(&bad, THRUM_BAD_VALUE,
                 "array 'region_law' holds 3 (entry 2); 0, 1 and 2 are laws");
  bad = made.points;
  bad.point_region = outside;
  assert_refused(&bad, THRUM_BAD_VALUE, "array 'point_region' holds the index 3");
  bad.point_region = below;
  assert_refused(&bad, THRUM_BAD_VALUE, "array 'point_region' holds the index -1");
  bad.point_region = NULL;
  assert_refused(&bad, THRUM_MISSING, "point_region and region_law come together");

  // yields are those of laws that flow
  bad = made.points;
  bad.region_yield = yields;
  assert_int_equal(thrum_model_check(&bad, NULL), THRUM_OK);
  bad.region_yield = negative;
  assert_refused(&bad, THRUM_BAD_VALUE, "array 'region_yield' holds -1 (entry 1)");
  bad.region_yield = stiff;
  assert_refused(&bad, THRUM_BAD_VALUE, "for a region of the law 0, stvk, which does not flow");
  bad.region_law = NULL;
  bad.point_region = NULL;
  assert_refused(&bad, THRUM_MISSING, "array 'region_law' is missing");

  // one law or several, of points, in a version whose readers know of it
  bad = made.points;
  bad.point_law = (const uint8_t *)"stvk";
  bad.law_bytes = 5;
  assert_refused(&bad, THRUM_BAD_SHAPE, "'point_law' does not go with region_law");
  bad = made.points;
  bad.law_count = 0;
  assert_refused(&bad, THRUM_BAD_SHAPE, "array 'region_law' has 0 laws");
  bad.region_law = NULL;
  bad.point_region = NULL;
  bad.law_count = 3;
  assert_refused(&bad, THRUM_BAD_SHAPE, "'region_law' is absent, yet there are 3 laws");
  bad = made.m.model;
  bad.format = made.points.format;
  bad.point_region = made.points.point_region;
  bad.region_law = made.points.region_law;
  bad.law_count = 3;
  assert_refused(&bad, THRUM_MISSING, "a polynomial cannot hold them");
  static const int32_t format[2] = {3, 0};
  bad = made.points;
  bad.format = format;
  assert_refused(&bad, THRUM_BAD_VALUE, "a model with 'region_law' has version 4");
  both_free(&made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tension_and_shear_of_a_point_are_the_closed_forms),
      cmocka_unit_test(force_and_tangent_are_derivatives_and_all_passes_agree),
      cmocka_unit_test(every_kernel_gives_the_same_bits),
      cmocka_unit_test(derivatives_at_rest_are_those_of_the_force),

      // steps, at any rank and scale
      cmocka_unit_test(every_integrator_steps_the_same_motion),
      cmocka_unit_test(the_energy_integrator_keeps_the_energy_to_rounding),
      cmocka_unit_test(the_average_vector_field_keeps_it_at_standstills_too),
      cmocka_unit_test(lower_ranks_and_scales_keep_the_law),

      // a law for each region
      cmocka_unit_test(regions_of_one_law_have_the_bits_of_a_body_of_that_law),
      cmocka_unit_test(the_energy_of_regions_is_the_sum_of_theirs),

      // refusals
      cmocka_unit_test(a_law_that_is_unknown_or_has_no_points_is_refused),
      cmocka_unit_test(laws_of_regions_that_cannot_be_are_refused),
      cmocka_unit_test(a_training_that_cannot_be_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
