/* Tests of the rows of thrum/fields.h: they are the members, defaults and ranges of the defs, and
 * what is refused is named by its field. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "tests/support/scene_call.h"

static const char *const names[] = {"body", "obstacle", "solid", "link", "pairs", "wind", "load"};

typedef union any_def {
  thrum_scene_body_def body;
  thrum_obstacle obstacle;
  thrum_scene_solid_def solid;
  thrum_scene_link_def link;
  thrum_contact_pairs_def pairs;
  thrum_scene_wind_def wind;
  thrum_scene_load_def load;
  char bytes[1];
} any_def;

/* Sets number n of a member. */
static void put_number(const thrum_field *field, any_def *def, int32_t n, double value) {
  char *at = def->bytes + field->offset;
  if (field->kind == THRUM_FIELD_DOUBLE)
    ((double *)(void *)at)[n] = value;
  else if (field->kind == THRUM_FIELD_FLOAT)
    ((float *)(void *)at)[n] = (float)value;
  else if (field->kind == THRUM_FIELD_INT64)
    *(int64_t *)(void *)at = (int64_t)value;
  else
    *(int32_t *)(void *)at = (int32_t)value;
}

static void each_field_has_a_name_of_its_own_and_lies_in_its_def(void **state) {
  (void)state;
  for (int record = 0; record < 7; record++) {
    int64_t count;
    const thrum_field *fields = thrum_scene_fields((thrum_scene_record)record, &count);
    const size_t size = thrum_scene_record_size((thrum_scene_record)record);
    assert_true(count >= 3);
    for (int64_t n = 0; n < count; n++) {
      assert_true(fields[n].offset >= sizeof(uint32_t) && fields[n].offset < size);
      assert_true(fields[n].count_offset < size);
      assert_true(strlen(fields[n].about) > 3);
      for (int64_t k = 0; k < n; k++)
        assert_string_not_equal(fields[n].name, fields[k].name);
    }
  }
  int64_t none;
  assert_null(thrum_scene_fields((thrum_scene_record)7, &none));
  assert_int_equal(none, 0);
}

/* Adds what a def says to a scene. */
static thrum_status add(thrum_scene *scene, int record, const any_def *def, thrum_error *error) {
  switch (record) {
  case THRUM_SCENE_RECORD_BODY:
    return thrum_scene_add_body(scene, &def->body, NULL, error);
  case THRUM_SCENE_RECORD_OBSTACLE:
    return thrum_scene_add_obstacle(scene, &def->obstacle, NULL, error);
  case THRUM_SCENE_RECORD_SOLID:
    return thrum_scene_add_solid(scene, &def->solid, NULL, error);
  case THRUM_SCENE_RECORD_LINK:
    return thrum_scene_add_link(scene, &def->link, NULL, error);
  case THRUM_SCENE_RECORD_WIND:
    return thrum_scene_set_wind(scene, &def->wind, error);
  case THRUM_SCENE_RECORD_LOAD:
    return thrum_scene_add_load(scene, 0, &def->load, error);
  default:
    return thrum_scene_set_collisions(scene, &def->pairs, error);
  }
}

static void numbers_beyond_a_range_are_refused_by_the_name_of_their_field(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 11, 4, 3, 100, 1);
  random_model_add_mesh(&m, 12, 9);
  random_model_pack(&m);
  thrum_scene *scene = NULL;
  assert_int_equal(thrum_scene_create(0.003, &scene, &failure), THRUM_OK);
  thrum_scene_body_def first = thrum_default_scene_body_def();
  first.model = &m.model;
  assert_int_equal(thrum_scene_add_body(scene, &first, NULL, &failure), THRUM_OK);

  // what no row allows, and what lies below the least
  int64_t tried = 0;
  for (int record = 0; record < 7; record++) {
    int64_t count;
    const thrum_field *fields = thrum_scene_fields((thrum_scene_record)record, &count);
    for (const thrum_field *field = fields; field < fields + count; field++)
      for (int32_t n = 0; field->kind < THRUM_FIELD_FLAG && n < field->width; n++) {
        const bool whole = field->kind >= THRUM_FIELD_INT64;
        const double wrong = whole ? -1 - (double)(field->least > 0) : INFINITY;
        any_def def;
        thrum_scene_record_default((thrum_scene_record)record, &def);
        if (record == THRUM_SCENE_RECORD_BODY)
          def.body.model = &m.model;
        put_number(field, &def, n, wrong);

        // until has no end by default
        if (strcmp(field->name, "until") == 0)
          put_number(field, &def, n, -1);
        failure = (thrum_error){0};
        const thrum_status status = add(scene, record, &def, &failure);
        if (status != THRUM_BAD_VALUE || failure.field == NULL ||
            strcmp(failure.field, field->name) != 0 ||
            strncmp(failure.message, field->name, strlen(field->name)) != 0)
          fail_msg("%s.%s = %g: %d '%s'", names[record], field->name, wrong, (int)status,
                   failure.message);
        assert_ptr_equal(thrum_error_reason(&failure), failure.message + strlen(field->name) + 1);
        tried++;
      }
  }
  assert_true(tried > 70);
  thrum_scene_destroy(scene);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_field_has_a_name_of_its_own_and_lies_in_its_def),
      cmocka_unit_test(numbers_beyond_a_range_are_refused_by_the_name_of_their_field),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
