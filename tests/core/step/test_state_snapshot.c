/* Tests of snapshots that leave the program: the same steps from them, and every changed bit
 * refused or harmless. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/seal.h"
#include "core/state/state_layout.h"
#include "tests/support/sanitized.h"
#include "tests/support/state_support.h"

enum { RANK = 3, STEPS = 40 };

static const double start_q[RANK] = {0.3, -0.1, 0.15}, start_p[RANK] = {-0.2, 0.4, 0.1};
static const double push[RANK] = {0.5, -0.4, 0.3};

/* The head of snapshots of states, as state_snapshot.c writes it. */
static const thrum_seal_kind kind = {{'t', 'h', 'r', 'u', 'm', 's', 't', 'a'}, THRUM_STATE_VERSION};

static thrum_state_def make_def(thrum_integrator integrator) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.dt = 0.05;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = 1;
  def.damping_alpha = 0.1;
  return def;
}

/* A model, a state in the middle of a run, and its snapshot. */
typedef struct fixture {
  random_model m;
  thrum_state *state;
  unsigned char *snapshot;
  size_t size;
} fixture;

static void open_run(fixture *f, const thrum_state_def *def) {
  thrum_error error;
  random_model_make(&f->m, 21, RANK, 1.0, 12.0, 0.5);
  f->state = state_make(&f->m.model, def);
  state_put(&f->m.model, f->state, start_q, start_p);
  state_push(&f->m.model, f->state, push);
  state_steps(&f->m.model, f->state, STEPS);

  // one byte more, so that a snapshot can lie at an odd address
  f->size = thrum_state_snapshot_size(f->state);
  f->snapshot = malloc(f->size + 1);
  assert_non_null(f->snapshot);
  assert_int_equal(thrum_state_snapshot(f->state, f->snapshot, f->size, &error), THRUM_OK);
}

static void close_run(fixture *f) {
  free(f->snapshot);
  state_free(f->state);
  random_model_free(&f->m);
}

static thrum_status restore(fixture *f, thrum_error *error) {
  return thrum_state_restore(&f->m.model, f->state, f->snapshot, f->size, error);
}

/* Restoring is refused with this status and this word, and the state stays as it was. */
static void expect_refused(fixture *f, thrum_status expected, const char *named) {
  thrum_error error = {.status = THRUM_OK};
  void *before = state_snapshot(f->state);
  const thrum_status status = restore(f, &error);
  if (status != expected || !strstr(error.message, named))
    fail_msg("status %d: '%s' is not '%s' with status %d", (int)status, error.message, named,
             (int)expected);
  assert_memory_equal(f->state, before, thrum_state_bytes(f->state));
  free(before);
}

static void a_snapshot_in_another_state_steps_to_the_same_bits(void **context) {
  (void)context;
  for (int integrator = 0; integrator < THRUM_INTEGRATOR_MANIFOLD; integrator++) {
    fixture f;
    const thrum_state_def def = make_def((thrum_integrator)integrator);
    open_run(&f, &def);
    state_steps(&f.m.model, f.state, STEPS);

    // the snapshot at an odd address, and a state that has not stepped
    memmove(f.snapshot + 1, f.snapshot, f.size);
    thrum_state *other = state_make(&f.m.model, &def);
    assert_int_equal(thrum_state_restore(&f.m.model, other, f.snapshot + 1, f.size, NULL),
                     THRUM_OK);
    state_steps(&f.m.model, other, STEPS);
    assert_memory_equal(other, f.state, thrum_state_kept_bytes(other));
    state_free(other);
    close_run(&f);
  }
}

static void every_changed_bit_is_refused(void **context) {
  (void)context;
  fixture f;
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
  open_run(&f, &def);
  void *before = state_snapshot(f.state);

  for (size_t bit = 0; bit < 8 * f.size; bit++) {
    f.snapshot[bit / 8] ^= (unsigned char)(1u << bit % 8);
    if (restore(&f, NULL) >= 0)
      fail_msg("bit %zu of %zu is not noticed", bit, 8 * f.size);
    f.snapshot[bit / 8] ^= (unsigned char)(1u << bit % 8);
  }

  // none of the refusals has touched the state, and the snapshot itself is fine
  assert_memory_equal(f.state, before, thrum_state_bytes(f.state));
  assert_int_equal(restore(&f, NULL), THRUM_OK);
  free(before);
  close_run(&f);
}

/* Steps and reads; whatever comes of it, no number that is read is NaN or Inf. */
static void expect_harmless(fixture *f) {
  double q[RANK] = {0}, p[RANK] = {0};
  thrum_energies energies = {0, 0, 0, 0};
  for (int k = 0; k < 3; k++)
    if (thrum_step(&f->m.model, f->state, NULL) < 0)
      break;
  if (thrum_state_get(&f->m.model, f->state, q, p, NULL) >= 0)
    for (int i = 0; i < RANK; i++)
      assert_true(isfinite(q[i]) && isfinite(p[i]));
  if (thrum_state_energies(&f->m.model, f->state, &energies, NULL) >= 0)
    assert_true(isfinite(energies.total));
  assert_non_null(thrum_scheme_name(thrum_state_report_get(f->state).scheme));
}

static void flip_under_a_right_checksum(const thrum_state_def *def) {
  fixture f;
  open_run(&f, def);
  void *before = state_snapshot(f.state);
  int taken = 0, refused = 0;
  for (size_t bit = 8 * THRUM_SEAL_BYTES; bit < 8 * f.size; bit += LENGTH_OF_RUN(1, 5)) {
    f.snapshot[bit / 8] ^= (unsigned char)(1u << bit % 8);
    thrum_seal_put(f.snapshot, f.size, kind);
    if (restore(&f, NULL) >= 0) {
      taken++;
      expect_harmless(&f);
      memcpy(f.state, before, thrum_state_bytes(f.state));
    } else {
      refused++;
    }
    f.snapshot[bit / 8] ^= (unsigned char)(1u << bit % 8);
  }

  // both happen: a bit of a coordinate is as good as another, one of a size is not
  assert_true(taken > 0 && refused > 0);
  free(before);
  close_run(&f);
}

static void every_changed_bit_under_a_right_checksum_is_refused_or_harmless(void **context) {
  (void)context;
  for (int integrator = 0; integrator < THRUM_INTEGRATOR_MANIFOLD; integrator++) {
    const thrum_state_def def = make_def((thrum_integrator)integrator);
    flip_under_a_right_checksum(&def);
  }

  // scratch for the tangent is there only with tangent damping or the energy integrator
  thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
  def.adaptive = def.fallback = 0;
  flip_under_a_right_checksum(&def);
  def.split_form = THRUM_FORM_QUADRATIC;
  flip_under_a_right_checksum(&def);
  def.damping_form = THRUM_DAMPING_TANGENT;
  def.damping_beta = 0.005;
  def.split_form = THRUM_FORM_THESIS;
  flip_under_a_right_checksum(&def);
}

/* --- refusals by name ------------------------------------------------------------------------- */

static void other_versions_and_byte_orders_are_refused_by_name(void **context) {
  (void)context;
  fixture f;
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
  open_run(&f, &def);
  unsigned char *kept = malloc(f.size);
  assert_non_null(kept);
  memcpy(kept, f.snapshot, f.size);

  // a later version of the same library
  thrum_seal_kind later = kind;
  later.version++;
  thrum_seal_put(f.snapshot, f.size, later);
  expect_refused(&f, THRUM_UNSUPPORTED, "version");

  // the mark of the byte order follows the letters
  memcpy(f.snapshot, kept, f.size);
  for (int k = 0; k < 4; k++)
    f.snapshot[8 + k] = kept[11 - k];
  expect_refused(&f, THRUM_UNSUPPORTED, "byte order");

  // a whole snapshot of another model, in memory larger and smaller than this one's
  random_model larger;
  random_model_make(&larger, 21, RANK + 3, 1.0, 12.0, 0.5);
  thrum_state *other = state_make(&larger.model, &def);
  const size_t size = thrum_state_snapshot_size(other);
  unsigned char *foreign = malloc(size);
  assert_non_null(foreign);
  assert_int_equal(thrum_state_snapshot(other, foreign, size, NULL), THRUM_OK);
  thrum_error error = {.status = THRUM_OK};
  assert_int_equal(thrum_state_restore(&f.m.model, f.state, foreign, size, &error),
                   THRUM_MODEL_MISMATCH);
  assert_non_null(strstr(error.message, "of another model"));
  assert_int_equal(thrum_state_restore(&larger.model, other, kept, f.size, &error),
                   THRUM_MODEL_MISMATCH);
  free(foreign);
  state_free(other);
  random_model_free(&larger);

  // something else altogether
  memset(f.snapshot, 0x5a, f.size);
  expect_refused(&f, THRUM_BAD_FORMAT, "no snapshot");

  memcpy(f.snapshot, kept, f.size);
  f.size--;
  expect_refused(&f, THRUM_BUFFER_TOO_SMALL, "cut short");
  f.size++;
  free(kept);
  close_run(&f);
}

static void a_snapshot_of_another_def_or_rank_is_refused(void **context) {
  (void)context;
  fixture f, other;
  thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
  open_run(&f, &def);
  def.integrator = THRUM_INTEGRATOR_VERLET;
  open_run(&other, &def);

  // the snapshot of the one into the state of the other
  thrum_error error;
  assert_int_equal(thrum_state_restore(&other.m.model, other.state, f.snapshot, f.size, &error),
                   THRUM_MODEL_MISMATCH);
  close_run(&other);

  random_model_make(&other.m, 21, RANK + 1, 1.0, 12.0, 0.5);
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  other.state = state_make(&other.m.model, &def);
  assert_true(thrum_state_restore(&other.m.model, other.state, f.snapshot, f.size, &error) < 0);
  state_free(other.state);
  random_model_free(&other.m);
  close_run(&f);
}

static void numbers_that_no_state_has_are_refused(void **context) {
  (void)context;
  fixture f;
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
  open_run(&f, &def);
  thrum_state *inside = malloc(thrum_state_kept_bytes(f.state));
  assert_non_null(inside);

#define REFUSE(field, value, named)                                                                \
  do {                                                                                             \
    memcpy(inside, f.state, thrum_state_kept_bytes(f.state));                                      \
    inside->field = (value);                                                                       \
    memcpy(f.snapshot + THRUM_SEAL_BYTES, inside, thrum_state_kept_bytes(f.state));                \
    thrum_seal_put(f.snapshot, f.size, kind);                                                      \
    expect_refused(&f, THRUM_BAD_VALUE, named);                                                    \
  } while (0)

  // sizes, the scheme and places
  REFUSE(kept_count, inside->kept_count + 1, "size of an array");
  REFUSE(tangent_count, inside->tangent_count - 1, "size of an array");
  REFUSE(scheme, THRUM_SCHEME_NEWMARK, "scheme");
  REFUSE(scheme, 99, "scheme");
  REFUSE(split, RANK + 1, "split");
  REFUSE(split, -1, "split");
  REFUSE(high_first, RANK + 1, "split");
  REFUSE(inverse_place, THRUM_INVERSES, "place");
  REFUSE(past_count, THRUM_PAST_SOLVES + 1, "place");
  REFUSE(jacobian_kept, 2, "switch");
  REFUSE(target.status, 3, "switch");

  // counters that could overflow, and numbers that are none
  REFUSE(report.steps, INT64_MAX, "counter");
  REFUSE(report.steps, -1, "counter");
  REFUSE(report.scheme_switches, -1, "counter");
  REFUSE(report.split_changes, INT64_MIN / 4, "counter");
  REFUSE(monitor.window_end, INT64_MIN, "counter");
  REFUSE(report.time, NAN, "finite");
  REFUSE(monitor.reference, INFINITY, "finite");
#undef REFUSE

  // the last number of the last array
  memcpy(f.snapshot + THRUM_SEAL_BYTES, f.state, thrum_state_kept_bytes(f.state));
  const double none = NAN;
  memcpy(f.snapshot + f.size - sizeof none, &none, sizeof none);
  thrum_seal_put(f.snapshot, f.size, kind);
  expect_refused(&f, THRUM_BAD_VALUE, "finite");
  free(inside);
  close_run(&f);
}

/* Whatever fields a state has or gets: no eight bytes of its header take a NaN of either sign. As
 * an integer the one is beyond any counter, and the other ends in a negative choice. The scheme and
 * the numbers of modes in the report are filled in when it is asked for. */
static void no_place_of_the_header_takes_the_bits_of_a_nan(void **context) {
  (void)context;
  fixture f;
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
  open_run(&f, &def);
  const uint64_t nan_bits[] = {UINT64_C(0x7ff8000000000001), UINT64_C(0xfff8000000000001)};
  const size_t size = thrum_state_kept_bytes(f.state);
  unsigned char *inside = malloc(size);
  assert_non_null(inside);

  // a place that takes both would take a NaN
  for (size_t at = 0; at < sizeof(thrum_state); at += sizeof nan_bits[0]) {
    bool taken = at < offsetof(thrum_state, report.scheme) ||
                 at >= offsetof(thrum_state, report.residual_last);
    for (int sign = 0; sign < 2; sign++) {
      memcpy(inside, f.state, size);
      memcpy(inside + at, &nan_bits[sign], sizeof nan_bits[sign]);
      taken = taken && thrum_state_copy_check(&f.m.model, f.state, inside, NULL) >= 0;
    }
    if (taken)
      fail_msg("the bytes of the header from %zu on take a NaN", at);
  }
  free(inside);
  close_run(&f);
}

static void null_and_small_memory_are_refused(void **context) {
  (void)context;
  fixture f;
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
  open_run(&f, &def);
  const thrum_model *model = &f.m.model;

  // the snapshot, then the way back
  assert_int_equal(thrum_state_snapshot_size(NULL), 0);
  assert_int_equal(thrum_state_snapshot(NULL, f.snapshot, f.size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_snapshot(f.state, NULL, f.size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_snapshot(f.state, f.snapshot, f.size - 1, NULL),
                   THRUM_BUFFER_TOO_SMALL);

  assert_int_equal(thrum_state_restore(model, NULL, f.snapshot, f.size, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_restore(model, f.state, NULL, f.size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_copy_check(model, f.state, NULL, NULL), THRUM_INVALID_ARGUMENT);
  close_run(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_snapshot_in_another_state_steps_to_the_same_bits),
      cmocka_unit_test(every_changed_bit_is_refused),
      cmocka_unit_test(every_changed_bit_under_a_right_checksum_is_refused_or_harmless),
      cmocka_unit_test(other_versions_and_byte_orders_are_refused_by_name),
      cmocka_unit_test(a_snapshot_of_another_def_or_rank_is_refused),
      cmocka_unit_test(numbers_that_no_state_has_are_refused),
      cmocka_unit_test(no_place_of_the_header_takes_the_bits_of_a_nan),
      cmocka_unit_test(null_and_small_memory_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
