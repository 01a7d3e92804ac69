/* Fuzz target of the table of accelerations that --shake reads.
 * sources: cli/shake_spec.c cli/load_spec.c cli/parse.c cli/message.c runtime/load.c
 * sources: runtime/motion.c runtime/status.c precompute/file.c precompute/interrupt.c
 * sources: precompute/text.c
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "cli/shake_spec.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size);
  cli_shake shake = {.text = path};
  thrum_error error = {0};
  if (path == NULL)
    return 0;
  const thrum_status status = cli_shake_read(&shake, &error);
  fuzz_check(status, &error);
  if (status >= 0) {
    double mean[3];
    cli_shakes_mean(&shake, 1, 3, 0.01, mean);
    if (isnan(mean[0] + mean[1] + mean[2]) && !isinf(mean[0]) && !isinf(mean[1]) && !isinf(mean[2]))
      abort();
  }
  cli_shake_close(&shake);
  return 0;
}
