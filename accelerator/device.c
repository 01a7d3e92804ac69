/* Buffers, programs and runs of a device, see device.h. SPDX-License-Identifier: Apache-2.0 */
#include "accelerator/device.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LOG_MOST 4096

thrum_status device_failure(int32_t code, const char *what, thrum_error *error) {
  switch (code) {
  case OPENCL_MEM_ALLOCATION_FAILURE:
  case OPENCL_OUT_OF_RESOURCES:
  case OPENCL_OUT_OF_HOST_MEMORY:
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "the device has no memory left while %s: take fewer bodies", what);
  default:
    return thrum_error_set(error, THRUM_UNSUPPORTED, "OpenCL fails with error %d while %s",
                           (int)code, what);
  }
}

// the first line of a compiler's messages that is not empty, into `line`
static void first_line(const char *log, char *line, size_t size) {
  log += strspn(log, " \t\r\n");
  snprintf(line, size, "%.*s", (int)strcspn(log, "\r\n"), log);
}

thrum_status device_program(const thrum_accelerator *a, const char *source, size_t size,
                            const char *options, opencl_program *program, thrum_error *error) {
  int32_t code;
  opencl_program made = a->cl.clCreateProgramWithSource(a->context, 1, &source, &size, &code);
  if (!made)
    return device_failure(code, "its program is read", error);
  if (a->cl.clBuildProgram(made, 1, &a->device, options, NULL, NULL) != OPENCL_SUCCESS) {
    char log[LOG_MOST] = {0}, line[160];
    a->cl.clGetProgramBuildInfo(made, a->device, OPENCL_PROGRAM_BUILD_LOG, sizeof log - 1, log,
                                NULL);
    first_line(log, line, sizeof line);
    a->cl.clReleaseProgram(made);
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the compiler of %.80s refuses the program of a step: %s", a->info.name,
                           line);
  }
  *program = made;
  return THRUM_OK;
}

thrum_status device_buffer(const thrum_accelerator *a, size_t size, const void *from,
                           opencl_buffer *buffer, thrum_error *error) {
  int32_t code = OPENCL_INVALID_BUFFER_SIZE;
  opencl_buffer made = NULL;
  if (size <= (uint64_t)a->info.buffer_most)
    made = a->cl.clCreateBuffer(a->context, OPENCL_MEM_READ_WRITE, size, NULL, &code);
  if (!made)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "the device has no room for %.0f MB more: %.80s has %.0f MB, and %.0f "
                           "MB at once; take fewer bodies or a lower rank",
                           (double)size / 1048576, a->info.name, (double)a->info.memory / 1048576,
                           (double)a->info.buffer_most / 1048576);
  if (from) {
    const thrum_status status = device_write(a, made, from, size, error);
    if (status != THRUM_OK) {
      a->cl.clReleaseMemObject(made);
      return status;
    }
  }
  *buffer = made;
  return THRUM_OK;
}

thrum_status device_reals(const thrum_accelerator *a, const double *from, int64_t count,
                          opencl_buffer *buffer, thrum_error *error) {
  const size_t size = (size_t)count * device_real(a);
  void *const numbers = malloc(size);
  if (!numbers)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %lld numbers of the device",
                           (long long)count);
  for (int64_t i = 0; i < count; i++)
    device_real_put(a, numbers, i, from[i]);
  const thrum_status status = device_buffer(a, size, numbers, buffer, error);
  free(numbers);
  return status;
}

void device_release(const thrum_accelerator *a, opencl_buffer *buffer) {
  if (*buffer)
    a->cl.clReleaseMemObject(*buffer);
  *buffer = NULL;
}

thrum_status device_write(const thrum_accelerator *a, opencl_buffer buffer, const void *from,
                          size_t size, thrum_error *error) {
  const int32_t code =
      a->cl.clEnqueueWriteBuffer(a->queue, buffer, 1, 0, size, from, 0, NULL, NULL);
  return code == OPENCL_SUCCESS ? THRUM_OK : device_failure(code, "numbers go to it", error);
}

thrum_status device_read(const thrum_accelerator *a, opencl_buffer buffer, void *to, size_t size,
                         thrum_error *error) {
  const int32_t code = a->cl.clEnqueueReadBuffer(a->queue, buffer, 1, 0, size, to, 0, NULL, NULL);
  return code == OPENCL_SUCCESS ? THRUM_OK : device_failure(code, "numbers come from it", error);
}

thrum_status device_wait(const thrum_accelerator *a, thrum_error *error) {
  const int32_t code = a->cl.clFinish(a->queue);
  return code == OPENCL_SUCCESS ? THRUM_OK : device_failure(code, "it steps", error);
}

thrum_status device_run(const thrum_accelerator *a, opencl_kernel kernel,
                        const device_argument *arguments, uint32_t count, const size_t items[2],
                        thrum_error *error) {
  for (uint32_t i = 0; i < count; i++) {
    const int32_t code = a->cl.clSetKernelArg(kernel, i, arguments[i].size, arguments[i].value);
    if (code != OPENCL_SUCCESS)
      return device_failure(code, "a pass is given its arrays", error);
  }
  const int32_t code =
      a->cl.clEnqueueNDRangeKernel(a->queue, kernel, 2, NULL, items, NULL, 0, NULL, NULL);
  return code == OPENCL_SUCCESS ? THRUM_OK : device_failure(code, "a pass starts", error);
}
