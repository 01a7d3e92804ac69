/* Tests of the stability monitor: each warning is raised exactly at its threshold, records are
 * independent, sampled tetrahedra find the worst of the whole body, and the share of a load outside
 * the basis is that of the closed form.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/linear_fields.h"
#include "thrum/displacement.h"

static const thrum_monitor *monitor_make(const thrum_model *model, const thrum_monitor_def *def) {
  size_t size = 0;
  thrum_error error = {0};
  if (thrum_monitor_size(model, def, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  const thrum_monitor *monitor = NULL;
  if (thrum_monitor_init(memory, size, model, def, &monitor, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return monitor;
}

static void monitor_free(const thrum_monitor *monitor) {
  free((void *)(uintptr_t)monitor);
}

static thrum_monitor_record look(const thrum_monitor *monitor, const double *q) {
  thrum_monitor_record record;
  thrum_monitor_clear(&record);
  assert_int_equal(thrum_monitor_look(monitor, q, &record, NULL), THRUM_OK);
  return record;
}

static void compression_warns_exactly_below_its_threshold(void **state) {
  (void)state;
  linear_fields fields;
  // with powers of two the stretch is exact
  linear_fields_make(&fields, "beam:2x1x1@1x0.5x0.5", 1e6, 0.3);

  // only the stretch may warn
  thrum_monitor_def def = thrum_default_monitor_def();
  assert_within(def.stretch_least, 0.5773502691896258, 1e-15);
  def.stretch_least = 0.5;
  def.reach_most = INFINITY;
  const thrum_monitor *monitor = monitor_make(&fields.model, &def);

  // the stretch is at the threshold, just below it, and of a tetrahedron inside out
  const double at[FIELDS] = {-0.5}, below[FIELDS] = {-0.5 - 0x1p-50}, inverted[FIELDS] = {-1.5};
  assert_true(look(monitor, at).stretch == 0.5);
  assert_int_equal(look(monitor, at).warnings, 0);
  assert_int_equal(look(monitor, below).warnings, THRUM_WARNING_COMPRESSED);
  assert_int_equal(look(monitor, inverted).warnings,
                   THRUM_WARNING_COMPRESSED | THRUM_WARNING_INVERTED);
  assert_true(look(monitor, inverted).stretch_least == -0.5);

  monitor_free(monitor);
  linear_fields_free(&fields);
}

static void reach_warns_exactly_above_its_threshold(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@3x4x12", 1e6, 0.3);

  // the threshold is two tenths of the body's diagonal
  thrum_monitor_def def = thrum_default_monitor_def();
  def.reach_most = 2;
  const thrum_monitor *monitor = monitor_make(&fields.model, &def);

  // u_x = q z with z up to 6 m; the diagonal is 13 m, so a reach of 2 is 2.6 m
  double q[FIELDS] = {0, 0, 2.6 / 6};
  const double reach = look(monitor, q).reach;
  assert_within(reach, 2, 1e-15 * 4);

  // just below and just above the threshold
  q[2] = 2.6 / 6 * (1 - 1e-14);
  assert_int_equal(look(monitor, q).warnings, 0);
  q[2] = 2.6 / 6 * (1 + 1e-14);
  assert_int_equal(look(monitor, q).warnings, THRUM_WARNING_REACH);

  monitor_free(monitor);
  linear_fields_free(&fields);
}

static void another_law_does_not_give_way(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x1x1", 1e6, 0.3);
  fields.model.point_law = (const uint8_t *)"neo-hookean";
  fields.model.law_bytes = 12;
  const thrum_monitor_def def = thrum_default_monitor_def();
  const thrum_monitor *monitor = monitor_make(&fields.model, &def);

  // squeezed to a third there is nothing to say, and turned inside out there is
  const double squeezed[FIELDS] = {-0.67}, inverted[FIELDS] = {-1.1};
  assert_false(look(monitor, squeezed).warnings & THRUM_WARNING_COMPRESSED);
  assert_true(look(monitor, inverted).warnings & THRUM_WARNING_INVERTED);
  monitor_free(monitor);
  linear_fields_free(&fields);
}

static void of_several_laws_the_regions_that_give_way_are_looked_at(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x1x1", 1e6, 0.3);
  int32_t regions[48] = {0};
  assert_true(fields.model.tet_count <= 48);
  const uint8_t laws[2][2] = {{THRUM_LAW_NEO_HOOKEAN, THRUM_LAW_STVK},
                              {THRUM_LAW_NEO_HOOKEAN, THRUM_LAW_COROTATIONAL}};
  const double squeezed[FIELDS] = {-0.67}, inverted[FIELDS] = {-1.1};
  fields.model.tet_region = regions;
  fields.model.law_count = 2;

  // no tetrahedron of Saint Venant-Kirchhoff material, one, and a region of it that is not there
  for (int n = 0; n < 3; n++) {
    const thrum_monitor_def def = thrum_default_monitor_def();
    fields.model.region_law = laws[n == 2];
    regions[3] = n == 1;
    static const double material[] = {1e6, 0.3, 1000, 1e6, 0.3, 1000};
    fields.model.material = material;
    fields.model.region_count = 2;
    const thrum_monitor *monitor = monitor_make(&fields.model, &def);
    const bool warned = look(monitor, squeezed).warnings & THRUM_WARNING_COMPRESSED;
    assert_true(warned == (n == 1));
    assert_true(look(monitor, inverted).warnings & THRUM_WARNING_INVERTED);
    monitor_free(monitor);
  }
  linear_fields_free(&fields);
}

static void a_record_keeps_what_was_and_says_what_is(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x1x1", 1e6, 0.3);

  // the record of a compressed body, with a copy of it, and then of the body at rest
  const thrum_monitor_def def = thrum_default_monitor_def();
  const thrum_monitor *monitor = monitor_make(&fields.model, &def);
  const double squeezed[FIELDS] = {-0.6}, rest[FIELDS] = {0};
  thrum_monitor_record first, second;
  thrum_monitor_clear(&first);
  assert_int_equal(first.stretch_tet, -1);
  assert_int_equal(thrum_monitor_look(monitor, squeezed, &first, NULL), THRUM_OK);
  second = first; // a record is its own snapshot
  assert_int_equal(thrum_monitor_look(monitor, rest, &first, NULL), THRUM_OK);

  // the record keeps past warnings and extremes beside the present values
  assert_int_equal(first.warnings, THRUM_WARNING_COMPRESSED | THRUM_WARNING_REACH);
  assert_int_equal(first.warnings_now, 0);
  assert_int_equal(first.looks, 2);
  assert_true(first.stretch == 1 && first.reach == 0);
  assert_within(first.stretch_least, 0.4, 1e-15);
  assert_true(first.stretch_tet >= 0);

  // the copy is as it was after the first look
  assert_int_equal(second.looks, 1);
  assert_int_equal(second.warnings_now, second.warnings);

  // warnings have texts, other numbers have none
  assert_string_equal(thrum_warning_text(THRUM_WARNING_INVERTED),
                      "a tetrahedron is turned inside out");
  assert_null(thrum_warning_text((thrum_warning)3));
  monitor_free(monitor);
  linear_fields_free(&fields);
}

static void given_sampled_tets_are_the_ones_monitored(void **state) {
  (void)state;

  // a random basis, so that every tetrahedron has its own strain
  static const int32_t given[3] = {40, 2, 7};
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x1x1", 1e6, 0.3);
  for (int64_t n = 0; n < 3 * fields.model.vertex_count * FIELDS; n++)
    fields.basis[n] = random_number();

  // the monitor keeps the given tetrahedra
  thrum_monitor_def def = thrum_default_monitor_def();
  def.sampled_tets = given;
  def.sampled_tet_count = 3;
  const thrum_monitor *monitor = monitor_make(&fields.model, &def);
  const int32_t *tets = NULL;
  assert_int_equal(thrum_monitor_sampled_tets(monitor, &tets), 3);
  assert_memory_equal(tets, given, sizeof given);

  // the stretches at the same tetrahedra, evaluated on their own
  const thrum_stress_points *stress_points = stress_points_make(&fields.model, given, 3);
  double q[FIELDS], stretch[3];
  const thrum_stress_points_output output = {.stretch = stretch};
  for (int trial = 0; trial < 50; trial++) {
    for (int i = 0; i < FIELDS; i++)
      q[i] = 0.1 * random_number();
    assert_int_equal(thrum_stress_points_read(stress_points, q, NULL, &output, NULL), THRUM_OK);
    // the result is the same through the bound that avoids eigenvalues
    const thrum_monitor_record record = look(monitor, q);
    const double least = fmin(stretch[0], fmin(stretch[1], stretch[2]));
    assert_true(record.stretch == least);

    // the tetrahedron of the least stretch is reported by its index in the mesh
    const int place = stretch[0] == least ? 0 : stretch[1] == least ? 1 : 2;
    assert_int_equal(record.stretch_tet, given[place]);
  }

  stress_points_free(stress_points);
  monitor_free(monitor);
  linear_fields_free(&fields);
}

static void chosen_sampled_tets_see_the_worst_of_a_bent_beam(void **state) {
  (void)state;

  // a beam of about a thousand tetrahedra and its first modes
  body b = body_beam1k();
  thrum_precomputed made = body_precompute(&b, 5, 10);
  const thrum_model *model = &made.model;

  // a monitor that samples by its own choice, and stress points on every tetrahedron
  const thrum_monitor_def def = thrum_default_monitor_def();
  const thrum_monitor *monitor = monitor_make(model, &def);
  const thrum_stress_points *stress_points = stress_points_make(model, NULL, 0);
  const int64_t count = thrum_stress_points_count(stress_points);

  // the sample is large enough and has no tetrahedron twice
  const int32_t *sampled_tets = NULL;
  const int64_t sampled = thrum_monitor_sampled_tets(monitor, &sampled_tets);
  assert_true(sampled > 50 && sampled <= 64);
  for (int64_t n = 0; n < sampled; n++)
    for (int64_t m = 0; m < n; m++)
      assert_int_not_equal(sampled_tets[n], sampled_tets[m]);

  double *stretch = need((size_t)count, sizeof *stretch);
  double *work = need((size_t)thrum_stress_points_work_count(stress_points), sizeof *work);
  const thrum_stress_points_output output = {.stretch = stretch};

  // in each bending mode the sample finds nearly the worst compression of the whole body
  for (int mode = 0; mode < 3; mode++) {
    double q[10] = {0}, least = 1;
    assert_int_equal(thrum_mode_add(model, mode, 0.05, q, NULL), THRUM_OK);
    assert_int_equal(thrum_stress_points_read(stress_points, q, work, &output, NULL), THRUM_OK);
    for (int64_t n = 0; n < count; n++)
      least = fmin(least, stretch[n]);
    const double seen = look(monitor, q).stretch;
    assert_true(seen >= least);
    assert_true(1 - seen > 0.9 * (1 - least));
  }

  free(work);
  free(stretch);
  stress_points_free(stress_points);
  monitor_free(monitor);
  thrum_precomputed_free(&made);
  body_free(&b);
}

static void the_share_of_a_load_outside_the_basis_is_that_of_the_closed_form(void **state) {
  (void)state;

  // the lumped mass of each vertex
  linear_fields fields;
  linear_fields_make(&fields, "beam:2x2x2@1x1x1", 1e6, 0.3);
  thrum_model *model = &fields.model;
  const int64_t vertices = model->vertex_count;
  double *mass = need((size_t)vertices, sizeof *mass), total = 0;
  for (int64_t t = 0; t < model->tet_count; t++)
    for (int a = 0; a < 4; a++) // 48 equal tets
      mass[model->tets[4 * t + a]] += fields.material[2] / 48 / 4;
  for (int64_t v = 0; v < vertices; v++)
    total += mass[v];

  // the basis has one coordinate: a shift along x, of unit mass
  model->rank = 1;
  for (int64_t c = 0; c < 3 * vertices; c++)
    fields.basis[c] = c % 3 == 0 ? 1 / sqrt(total) : 0;

  // the threshold lies between the shares of the cases
  thrum_monitor_def def = thrum_default_monitor_def();
  def.load_share_most = 0.79;
  const thrum_monitor *monitor = monitor_make(model, &def);

  // a uniform acceleration: only its part along x lies within the basis
  double *forces = need((size_t)(3 * vertices), sizeof *forces);
  thrum_monitor_record record;
  thrum_monitor_clear(&record);
  const struct {
    double x, y, share;
    uint32_t warning;
  } cases[] = {{1, 0, 0, 0},
               {0, 2, 1, THRUM_WARNING_LOAD},
               {4, 3, 0.6, 0},
               {3, 4, 0.8, THRUM_WARNING_LOAD},
               {0, 0, 0, 0}};

  // the load of a case is its acceleration times the mass of each vertex
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    for (int64_t v = 0; v < vertices; v++) {
      forces[3 * v] = cases[n].x * mass[v];
      forces[3 * v + 1] = cases[n].y * mass[v];
    }
    assert_int_equal(thrum_monitor_look_at_load(monitor, model, forces, &record, NULL), THRUM_OK);
    assert_within(record.load_share, cases[n].share, 1e-7);
    assert_int_equal(record.warnings_now, cases[n].warning);
  }

  // loads on held components do not count
  for (int64_t v = 0; v < vertices; v++) {
    fields.body.fixed[v] = 2;
    forces[3 * v] = mass[v];
    forces[3 * v + 1] = 1e3;
  }
  assert_int_equal(thrum_monitor_look_at_load(monitor, model, forces, &record, NULL), THRUM_OK);
  assert_within(record.load_share, 0, 1e-7);
  assert_int_equal(record.warnings, THRUM_WARNING_LOAD);

  free(forces);
  monitor_free(monitor);
  free(mass);
  linear_fields_free(&fields);
}

static void the_stretch_of_a_solid_shell_is_not_that_of_the_tetrahedra_that_show_it(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", 1e6, 0.3);
  const thrum_monitor_def def = thrum_default_monitor_def();
  const double squeezed[FIELDS] = {-0.6};
  for (uint8_t form = 4; form <= 7; form += 3) {
    const bool shell = form == 7;
    fields.model.solid_count = 1;
    fields.model.solid_form = &form;
    const thrum_monitor *monitor = monitor_make(&fields.model, &def);

    // a thick element is near, a thin one is not looked at; how far both moved is
    thrum_monitor_record record;
    thrum_monitor_clear(&record);
    assert_int_equal(thrum_monitor_look(monitor, squeezed, &record, NULL), THRUM_OK);
    assert_int_equal(thrum_monitor_sampled_tets(monitor, NULL) > 0, !shell);
    assert_int_equal(record.warnings, THRUM_WARNING_REACH | (shell ? 0 : THRUM_WARNING_COMPRESSED));
    assert_int_equal(record.stretch_tet < 0, shell);
    monitor_free(monitor);

    // nor are tetrahedra that the caller chooses
    static const int32_t first = 0;
    thrum_monitor_def chosen = def;
    size_t size = 0;
    chosen.sampled_tets = &first;
    chosen.sampled_tet_count = 1;
    assert_int_equal(thrum_monitor_size(&fields.model, &chosen, &size, NULL),
                     shell ? THRUM_UNSUPPORTED : THRUM_OK);
  }
  linear_fields_free(&fields);
}

static void impossible_monitors_are_refused(void **state) {
  (void)state;

  // a good monitor, to compare with
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", 1e6, 0.3);
  const thrum_monitor_def good = thrum_default_monitor_def();
  const thrum_monitor *monitor = monitor_make(&fields.model, &good), *untouched = monitor;
  thrum_monitor_record record;
  thrum_monitor_clear(&record);

  // definitions with a field out of range
  size_t size = 0;
  thrum_error error;
  const thrum_monitor_def empty = {0};
  assert_int_equal(thrum_monitor_size(&fields.model, &empty, &size, &error),
                   THRUM_UNINITIALISED_DEF);
  thrum_monitor_def def = good;
  def.sampled_tet_count = 257;
  assert_int_equal(thrum_monitor_size(&fields.model, &def, &size, &error), THRUM_INVALID_ARGUMENT);
  def = good;
  def.stretch_least = NAN;
  assert_int_equal(thrum_monitor_size(&fields.model, &def, &size, &error), THRUM_INVALID_ARGUMENT);
  def = good;
  def.load_share_most = 1.5;
  assert_int_equal(thrum_monitor_size(&fields.model, &def, &size, &error), THRUM_INVALID_ARGUMENT);

  // a model without a mesh, and memory that is too small
  thrum_model bare = fields.model;
  bare.tets = NULL;
  assert_int_equal(thrum_monitor_size(&bare, &good, &size, &error), THRUM_MISSING);
  assert_int_equal(thrum_monitor_size(&fields.model, &good, &size, &error), THRUM_OK);
  void *memory = aligned_alloc(64, size);
  assert_int_equal(thrum_monitor_init(memory, size - 1, &fields.model, &good, &untouched, &error),
                   THRUM_BUFFER_TOO_SMALL);
  assert_ptr_equal(untouched, monitor);
  free(memory);

  // a look that fails leaves the record as it was
  const double bad[FIELDS] = {INFINITY};
  const thrum_monitor_record before = record;
  assert_int_equal(thrum_monitor_look(monitor, bad, &record, &error), THRUM_BAD_VALUE);
  assert_memory_equal(&record, &before, sizeof before);

  // displacements whose strain overflows count as the worst
  const double huge[FIELDS] = {1e200};
  assert_int_equal(thrum_monitor_look(monitor, huge, &record, &error), THRUM_OK);
  assert_true(record.warnings & THRUM_WARNING_COMPRESSED);

  monitor_free(monitor);
  linear_fields_free(&fields);
}

/* Reads with one argument missing or of another body; the record stays as it was. */
static void missing_arguments_of_a_monitor_are_refused(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", 1e6, 0.3);
  const thrum_monitor_def good = thrum_default_monitor_def();
  const thrum_monitor *monitor = monitor_make(&fields.model, &good);
  size_t size = 77;

  // a def without its parts
  assert_int_equal(thrum_monitor_size(NULL, &good, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_monitor_size(&fields.model, NULL, &size, NULL), THRUM_UNINITIALISED_DEF);
  assert_int_equal(thrum_monitor_size(&fields.model, &good, NULL, NULL), THRUM_INVALID_ARGUMENT);
  thrum_monitor_def none = good;
  none.sampled_tet_count = 0;
  assert_int_equal(thrum_monitor_size(&fields.model, &none, &size, NULL), THRUM_INVALID_ARGUMENT);
  thrum_model bare = fields.model;
  bare.basis = NULL;
  assert_int_equal(thrum_monitor_size(&bare, &good, &size, NULL), THRUM_MISSING);
  assert_int_equal(size, 77);

  // looks without a monitor, coordinates or a record
  const double q[FIELDS] = {0};
  thrum_monitor_record record;
  thrum_monitor_clear(&record);
  const thrum_monitor_record before = record;
  thrum_monitor *torn = aligned_alloc(64, 4096);
  assert_non_null(torn);
  memset(torn, 0, 4096);
  assert_int_equal(thrum_monitor_look(NULL, q, &record, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_monitor_look(torn, q, &record, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_monitor_look(monitor, NULL, &record, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_monitor_look(monitor, q, NULL, NULL), THRUM_INVALID_ARGUMENT);
  free(torn);

  // a load of another body, without numbers or with one that is none
  double forces[3 * 8] = {0};
  thrum_model other = fields.model;
  const thrum_model *model = &fields.model;
  assert_int_equal(thrum_monitor_look_at_load(monitor, NULL, forces, &record, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_monitor_look_at_load(monitor, model, NULL, &record, NULL),
                   THRUM_INVALID_ARGUMENT);
  other.rank--;
  assert_int_equal(thrum_monitor_look_at_load(monitor, &other, forces, &record, NULL),
                   THRUM_INVALID_ARGUMENT);
  other = fields.model;
  other.vertex_count--;
  assert_int_equal(thrum_monitor_look_at_load(monitor, &other, forces, &record, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_monitor_look_at_load(monitor, &bare, forces, &record, NULL),
                   THRUM_INVALID_ARGUMENT);
  forces[5] = NAN;
  assert_int_equal(thrum_monitor_look_at_load(monitor, model, forces, &record, NULL),
                   THRUM_BAD_VALUE);
  assert_memory_equal(&record, &before, sizeof before);

  // no monitor samples nothing
  const int32_t *tets = NULL;
  assert_int_equal(thrum_monitor_sampled_tets(NULL, &tets), 0);
  assert_null(tets);
  assert_true(thrum_monitor_sampled_tets(monitor, NULL) > 0);

  monitor_free(monitor);
  linear_fields_free(&fields);
}

static void tets_are_chosen_for_a_body_with_a_mesh(void **state) {
  (void)state;
  linear_fields fields;
  linear_fields_make(&fields, "beam:1x1x1@1x1x1", 1e6, 0.3);
  int32_t tets[THRUM_SAMPLED_TETS_MAX];
  int64_t chosen = -7;
  const thrum_model *model = &fields.model;
  const int64_t most = THRUM_SAMPLED_TETS_MAX;

  // one thing missing, or a count out of range
  assert_int_equal(thrum_sampled_tets_choose(NULL, 1, tets, &chosen, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_sampled_tets_choose(model, 1, NULL, &chosen, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_sampled_tets_choose(model, 1, tets, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_sampled_tets_choose(model, 0, tets, &chosen, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_sampled_tets_choose(model, most + 1, tets, &chosen, NULL),
                   THRUM_INVALID_ARGUMENT);

  // a model without a basis, without a mesh, and one whose tet has no volume
  thrum_model bare = *model;
  bare.basis = NULL;
  assert_int_equal(thrum_sampled_tets_choose(&bare, 1, tets, &chosen, NULL), THRUM_MISSING);
  bare = *model;
  bare.tets = NULL;
  assert_int_equal(thrum_sampled_tets_choose(&bare, 1, tets, &chosen, NULL), THRUM_MISSING);
  double flat[3 * 8] = {0};
  bare = *model;
  bare.vertices = flat;
  assert_int_equal(thrum_sampled_tets_choose(&bare, 1, tets, &chosen, NULL), THRUM_BAD_VALUE);
  assert_int_equal(chosen, -7);

  // as many as are asked for, each once
  assert_int_equal(thrum_sampled_tets_choose(model, 4, tets, &chosen, NULL), THRUM_OK);
  assert_int_equal(chosen, 4);
  for (int n = 0; n < 4; n++)
    for (int m = 0; m < n; m++)
      assert_true(tets[n] != tets[m]);
  linear_fields_free(&fields);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(compression_warns_exactly_below_its_threshold),
      cmocka_unit_test(reach_warns_exactly_above_its_threshold),
      cmocka_unit_test(another_law_does_not_give_way),
      cmocka_unit_test(of_several_laws_the_regions_that_give_way_are_looked_at),
      cmocka_unit_test(a_record_keeps_what_was_and_says_what_is),
      cmocka_unit_test(given_sampled_tets_are_the_ones_monitored),
      cmocka_unit_test(chosen_sampled_tets_see_the_worst_of_a_bent_beam),
      cmocka_unit_test(the_share_of_a_load_outside_the_basis_is_that_of_the_closed_form),
      cmocka_unit_test(the_stretch_of_a_solid_shell_is_not_that_of_the_tetrahedra_that_show_it),
      cmocka_unit_test(impossible_monitors_are_refused),
      cmocka_unit_test(missing_arguments_of_a_monitor_are_refused),
      cmocka_unit_test(tets_are_chosen_for_a_body_with_a_mesh),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
