/* Messages about scenes name keys in place of options, and leave commands that are written out.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "driver/scene/scene_words.h"

static void options_become_keys_or_those_of_precompute(void **state) {
  (void)state;
  static const char *const cases[][2] = {
      {"give --young, --poisson and --density", "give \"young\", \"poisson\" and \"density\""},
      {"give --material for it too", "give \"regions\" for it too"},
      {"--load 'x' moves nothing", "\"loads\" 'x' moves nothing"},
      {"beside --largest-plastic-strain", "beside \"largest_plastic_strain\""},
      {"lock far less (--order 2)", "lock far less (thrum precompute --order 2)"},
      {"raise --rank-max", "raise thrum precompute --rank-max"},

      // a command goes on to the end of its clause
      {"train (precompute --yield X --train LOAD) or take more (--cubature-error)",
       "train (precompute --yield X --train LOAD) or take more (thrum precompute "
       "--cubature-error)"},
      {"see `thrum info --load`; or lower --dt", "see `thrum info --load`; or lower \"dt\""},

      // these are no options
      {"a--b, -- and 5--7", "a--b, -- and 5--7"},
      {"", ""},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char message[400];
    strcpy(message, cases[n][0]);
    scene_words(message, sizeof message);
    assert_string_equal(message, cases[n][1]);
  }
}

static void what_finds_no_room_is_cut_off(void **state) {
  (void)state;
  char message[24] = "give --young and --fix";
  scene_words(message, sizeof message);
  assert_string_equal(message, "give \"young\" and \"fix\"");
  strcpy(message, "raise --modes");
  scene_words(message, sizeof message);
  assert_string_equal(message, "raise thrum precompute ");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(options_become_keys_or_those_of_precompute),
      cmocka_unit_test(what_finds_no_room_is_cut_off),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
