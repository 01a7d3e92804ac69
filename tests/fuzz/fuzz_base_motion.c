/* Fuzz target of the table of accelerations that --base-motion reads.
 * sources: driver/spec/base_motion_spec.c driver/spec/load_spec.c mesh/vertex_places.c
 * config/parse.c config/message.c config/message_error.c core/loads/load_mean.c
 * core/loads/base_motion.c core/base/finite.c core/base/status.c io/file.c platform/interrupt.c
 * platform/allocate.c mesh/mesh_grow.c io/text.c
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "driver/spec/base_motion_spec.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size);
  base_motion_spec base_motion = {.text = path};
  thrum_error error = {0};

  if (path == NULL)
    return 0;

  // a table that was read has a mean, which is NaN only where infinities cancel
  const thrum_status status = base_motion_read(&base_motion, &error);
  fuzz_check(status, &error);
  if (status >= 0) {
    double mean[3];
    base_motions_mean(&base_motion, 1, 3, 0.01, mean);
    if (isnan(mean[0] + mean[1] + mean[2]) && !isinf(mean[0]) && !isinf(mean[1]) && !isinf(mean[2]))
      abort();
  }

  base_motion_close(&base_motion);
  return 0;
}
