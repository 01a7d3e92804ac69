/* The rate of a device, see peak.h. SPDX-License-Identifier: Apache-2.0 */
#include "accelerator/peak.h"

#include <stdio.h>

#include "accelerator/device.h"

#define CHAINS 8
#define ROUNDS 4096
#define ITEMS 1024 /* of a compute unit: enough for all that it has at once */

static const char source[] = {
#include "peak_program.inc"
};

thrum_status accelerator_peak_run(const thrum_accelerator *a, double *operations,
                                  thrum_error *error) {
  opencl_program program;
  opencl_kernel kernel;
  opencl_buffer out;
  char options[64];
  int32_t code;
  const size_t items[2] = {(size_t)a->info.units * ITEMS, 1};
  snprintf(options, sizeof options, "-cl-std=CL1.2 -DCHAINS=%d -DWIDE=%d", CHAINS, a->wide);
  THRUM_TRY(device_program(a, source, sizeof source, options, &program, error));
  kernel = a->cl.clCreateKernel(program, "peak", &code);
  thrum_status status =
      kernel ? device_buffer(a, items[0] * (size_t)a->wide * sizeof(float), NULL, &out, error)
             : device_failure(code, "the pass peak is made", error);
  if (status == THRUM_OK) {
    const int32_t rounds = ROUNDS;
    const device_argument arguments[] = {DEVICE_ARGUMENT(out), DEVICE_ARGUMENT(rounds)};
    status = device_run(a, kernel, arguments, 2, items, error);
    if (status == THRUM_OK)
      status = device_wait(a, error);
    device_release(a, &out);
  }
  if (status == THRUM_OK)
    *operations = 2.0 * CHAINS * ROUNDS * (double)items[0] * a->wide;
  if (kernel)
    a->cl.clReleaseKernel(kernel);
  a->cl.clReleaseProgram(program);
  return status;
}

double crowd_step_operations(int64_t rank, const thrum_crowd_def *def) {
  const double pairs = 0.5 * (double)rank * (double)(rank + 1);
  const double evaluations = def->state.integrator == THRUM_INTEGRATOR_VERLET ? 1
                             : def->state.integrator == THRUM_INTEGRATOR_MIDPOINT
                                 ? def->iterations
                                 : def->iterations + 1;
  return 2 * pairs * ((double)rank + pairs) * evaluations;
}
