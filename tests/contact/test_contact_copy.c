/* Bytes that are to become a contact: each number of them that no contact can have is refused, and
 * so are those of another contact. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"

#include "contact/contact_point.h"
#include "contact/contact_step.h"

typedef struct fixture {
  rig r;
  unsigned char *copy;
  size_t size;
} fixture;

/* A flexible body in the middle of an impact, and a copy of its contact. */
static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;

  rig_def def = rig_default();
  def.points = 5;
  def.shape = 0.2;
  rig_make(&f->r, &def);

  // it falls until it touches
  f->r.translation.position[2] = 0.01;
  for (int k = 0; k < 1000 && f->r.contact->touch_count == 0; k++)
    rig_steps(&f->r, 1);

  f->size = thrum_contact_bytes(f->r.contact);
  f->copy = malloc(f->size);
  *context = f;
  if (f->copy == NULL)
    return -1;
  memcpy(f->copy, f->r.contact, f->size);
  return 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  rig_free(&f->r);
  free(f->copy);
  free(f);
  return 0;
}

/* The copy with other bytes at an offset is refused with that status, and then mended. */
static void refuse(fixture *f, size_t offset, const void *bytes, size_t size,
                   thrum_status expected) {
  unsigned char kept[16];
  memcpy(kept, f->copy + offset, size);
  memcpy(f->copy + offset, bytes, size);
  const thrum_status status = thrum_contact_copy_check(f->r.contact, f->copy, NULL);
  if (status != expected)
    fail_msg("bytes at %zu: %s", offset, thrum_status_text(status));
  memcpy(f->copy + offset, kept, size);
}

static void refuse_count(fixture *f, size_t offset, int64_t value) {
  refuse(f, offset, &value, sizeof value, THRUM_BAD_VALUE);
}

static void refuse_small(fixture *f, size_t offset, int32_t value) {
  refuse(f, offset, &value, sizeof value, THRUM_BAD_VALUE);
}

/* `count` numbers that are not finite, each in turn. */
static void refuse_numbers(fixture *f, size_t offset, int count) {
  const double bad[2] = {NAN, INFINITY};
  for (int n = 0; n < count; n++)
    refuse(f, offset + (size_t)n * sizeof(double), &bad[n % 2], sizeof(double), THRUM_BAD_VALUE);
}

static void what_no_step_changes_must_be_the_same(void **context) {
  fixture *f = *context;
  assert_int_equal(thrum_contact_copy_check(f->r.contact, f->copy, NULL), THRUM_OK);
  assert_int_equal(thrum_contact_copy_check(NULL, f->copy, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_copy_check(f->r.contact, NULL, NULL), THRUM_INVALID_ARGUMENT);

  // sizes and the definition: one bit of each byte
  static const size_t fields[][2] = {
#define FIELD(name) {offsetof(thrum_contact, name), sizeof(((thrum_contact *)0)->name)}
      FIELD(magic),    FIELD(bytes),     FIELD(state_bytes), FIELD(point_count), FIELD(touch_max),
      FIELD(pull_max), FIELD(tolerance), FIELD(stiffness),   FIELD(middle),      FIELD(radius),
      FIELD(diagonal), FIELD(rank),      FIELD(sweeps_max),  FIELD(springy),
#undef FIELD
  };
  for (size_t n = 0; n < sizeof fields / sizeof fields[0]; n++)
    for (size_t byte = fields[n][0]; byte < fields[n][0] + fields[n][1]; byte++) {
      const unsigned char other = f->copy[byte] ^ (unsigned char)(1U << (byte % 8));
      refuse(f, byte, &other, 1, THRUM_MODEL_MISMATCH);
    }

  // the points that may touch, and their areas
  const thrum_contact_view view = thrum_contact_view_of(f->r.contact);
  const size_t from = (sizeof(thrum_contact) + 63) / 64 * 64;
  const size_t until =
      (size_t)((const unsigned char *)view.touches - (const unsigned char *)f->r.contact);
  assert_true(until > from);
  for (size_t byte = from; byte < until; byte++) {
    const unsigned char other = f->copy[byte] ^ 1U;
    refuse(f, byte, &other, 1, THRUM_MODEL_MISMATCH);
  }
}

static void counts_beyond_their_range_are_refused(void **context) {
  fixture *f = *context;
  const int64_t touch_max = f->r.contact->touch_max, pull_max = f->r.contact->pull_max;
  const int64_t most = INT64_C(1) << 62;
  const struct {
    size_t offset;
    int64_t most;
  } counts[] = {
      {offsetof(thrum_contact, touch_count), touch_max},
      {offsetof(thrum_contact, row_count), touch_max},
      {offsetof(thrum_contact, pull_count), pull_max},
      {offsetof(thrum_contact, steps), most},
      {offsetof(thrum_contact, redone), most},
      {offsetof(thrum_contact, declined), most},
      {offsetof(thrum_contact, dropped), most},
      {offsetof(thrum_contact, sweeps), most},
      {offsetof(thrum_contact, impacts), most},
      {offsetof(thrum_contact, struck), touch_max - f->r.contact->touch_count},
  };

  // below zero and one beyond the most
  for (size_t n = 0; n < sizeof counts / sizeof counts[0]; n++) {
    refuse_count(f, counts[n].offset, -1);
    refuse_count(f, counts[n].offset, counts[n].most + 1);
  }

  // flags are 0 or 1, and a copy is never between begin and end
  refuse_small(f, offsetof(thrum_contact, fresh), 2);
  refuse_small(f, offsetof(thrum_contact, fresh), -1);
  refuse_small(f, offsetof(thrum_contact, begun), 1);
}

static void numbers_that_are_not_finite_are_refused(void **context) {
  fixture *f = *context;
  refuse_numbers(f, offsetof(thrum_contact, flow), 8);
  refuse_numbers(f, offsetof(thrum_contact, moved), 3);
  refuse_numbers(f, offsetof(thrum_contact, force), 3);
  refuse_numbers(f, offsetof(thrum_contact, turned), 3);
  refuse_numbers(f, offsetof(thrum_contact, torque), 3);
  refuse_numbers(f, offsetof(thrum_contact, pressed), 3);
  refuse_numbers(f, offsetof(thrum_contact, whirled), 3);

  // each touch, and the forces of the pulls
  const thrum_contact_view view = thrum_contact_view_of(f->r.contact);
  const unsigned char *own = (const unsigned char *)f->r.contact;
  assert_true(f->r.contact->touch_count > 0);
  for (int64_t n = 0; n < f->r.contact->touch_count; n++) {
    const size_t at = (size_t)((const unsigned char *)(view.touches + n) - own);
    refuse_small(f, at + offsetof(thrum_touching, point), -1);
    refuse_small(f, at + offsetof(thrum_touching, point), (int32_t)f->r.contact->point_count);
    refuse_small(f, at + offsetof(thrum_touching, obstacle), -1);
    refuse_small(f, at + offsetof(thrum_touching, face), -1);
    refuse_small(f, at + offsetof(thrum_touching, towards), 2);
    refuse_numbers(f, at + offsetof(thrum_touching, normal), 10);
  }
  refuse_numbers(f, (size_t)((const unsigned char *)view.pull_forces - own),
                 (int)(3 * f->r.contact->pull_max));
  refuse_numbers(f, (size_t)((const unsigned char *)view.pressing - own), RIG_RANK);
}

/* As one body of a scene flies apart, the forces of a solve may leave the finite numbers for a
 * while: a held body has no way and no angle then either, or its copy would be refused. */
static void a_held_body_does_not_turn_under_any_force(void **context) {
  fixture *f = *context;
  const thrum_contact_environment held = {.obstacles = NULL};
  thrum_contact_run run;
  assert_int_equal(thrum_contact_open(&f->r.m.model, f->r.state, f->r.contact, &held, &run, NULL),
                   THRUM_OK);

  // their torque is infinite less infinite
  const double lever[3] = {1e200, 1e200, 1e200}, force[3] = {1e200, -1e200, INFINITY};
  thrum_point_push(&run, thrum_point_rows(&run, 0), lever, force);
  for (int axis = 0; axis < 3; axis++)
    assert_true(run.turned[axis] == 0.0 && run.moved[axis] == 0.0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(what_no_step_changes_must_be_the_same),
      TEST(counts_beyond_their_range_are_refused),
      TEST(numbers_that_are_not_finite_are_refused),
      TEST(a_held_body_does_not_turn_under_any_force),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
