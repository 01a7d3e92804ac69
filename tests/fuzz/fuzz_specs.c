/* Fuzz target of the specifications of --load, --start, --base-motion and --at.
 * sources: driver/spec/load_spec.c mesh/vertex_places.c driver/spec/start_spec.c
 * driver/spec/base_motion_spec.c config/parse.c config/message.c config/message_error.c
 * core/loads/load_mean.c core/base/status.c io/npz.c io/zip_write.c io/file.c platform/interrupt.c
 * io/npy_file.c io/text.c SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/base_motion_spec.h"
#include "driver/spec/start_spec.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size == 0)
    return 0;

  // the first byte chooses the specification
  char *text = fuzz_text(data + 1, size - 1);
  thrum_error error = {0};
  thrum_status status = THRUM_OK;
  load_spec load = {0};
  start_spec start = {0};
  base_motion_spec base_motion = {0};
  load_target target = {0};

  // a course in time must not end before it begins
  switch (data[0] % 4) {
  case 0:
    status = load_spec_parse(text, &load, &error);
    if (status >= 0 && !(load.course.from >= 0 && load.course.until > load.course.from))
      abort();
    break;
  case 1:
    status = start_spec_parse(text, &start, &error);
    break;
  case 2:
    status = base_motion_parse(text, &base_motion, &error);
    break;
  default:
    status = load_target_parse(text, "--at", &target, &error);
  }

  fuzz_check(status, &error);

  free(text);
  return 0;
}
