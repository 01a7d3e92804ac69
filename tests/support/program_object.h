/* The JSON object of a run of the program that ends as it should, for tests of commands; cmocka.h
 * comes before. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_PROGRAM_OBJECT_H
#define THRUM_TESTS_SUPPORT_PROGRAM_OBJECT_H

#include "tests/support/program_support.h"

/* Fails where the run ended with another code or printed no object; frees the run. */
static inline cJSON *program_object(program_result run, int code) {
  if (run.exit_code != code)
    fail_msg("exit code %d: %s%s", run.exit_code, run.out, run.err);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

#endif
