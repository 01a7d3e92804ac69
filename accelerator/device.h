/* A device and its queue, for those who step on it; private to the accelerator library.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACCELERATOR_DEVICE_H
#define THRUM_ACCELERATOR_DEVICE_H

#include <stdbool.h>

#include "accelerator/opencl.h"
#include "thrum/accelerator.h"

struct thrum_accelerator {
  opencl_library cl;
  opencl_device device;
  opencl_context context;
  opencl_queue queue; /* in order: what is put in starts when all before it has ended */
  thrum_accelerator_info info;
  int lanes; /* bodies of a work-item: of a processor what its vectors hold, of others one */
  int wide;  /* of the product with coefficients, which are 4 at least */
};

/* An argument of a kernel. */
typedef struct device_argument {
  size_t size;
  const void *value;
} device_argument;

#define DEVICE_ARGUMENT(x)                                                                         \
  { sizeof(x), &(x) }

/* Bytes of a number of the accelerator's own precision. */
static inline size_t device_real(const thrum_accelerator *accelerator) {
  return accelerator->info.single ? sizeof(float) : sizeof(double);
}

/* What OpenCL said, as a status with a line: what was being done, and for what. */
thrum_status device_failure(int32_t code, const char *what, thrum_error *error);

/* Compiles `source` with these macros set; the caller releases *program. */
thrum_status device_program(const thrum_accelerator *accelerator, const char *source, size_t size,
                            const char *options, opencl_program *program, thrum_error *error);

/* A buffer of the device with `size` bytes, copied from `from` where it is not NULL; the caller
 * releases it. THRUM_OUT_OF_MEMORY with what is needed. */
thrum_status device_buffer(const thrum_accelerator *accelerator, size_t size, const void *from,
                           opencl_buffer *buffer, thrum_error *error);
void device_release(const thrum_accelerator *accelerator, opencl_buffer *buffer);

/* Copies, and waits until it is done. */
thrum_status device_write(const thrum_accelerator *accelerator, opencl_buffer buffer,
                          const void *from, size_t size, thrum_error *error);
thrum_status device_read(const thrum_accelerator *accelerator, opencl_buffer buffer, void *to,
                         size_t size, thrum_error *error);

/* Waits until all in the queue has ended. */
thrum_status device_wait(const thrum_accelerator *accelerator, thrum_error *error);

/* Puts a kernel into the queue over `global` items, in groups of `group` (NULL: any). */
thrum_status device_run(const thrum_accelerator *accelerator, opencl_kernel kernel,
                        const device_argument *arguments, uint32_t count, const size_t global[2],
                        const size_t *group, thrum_error *error);

#endif
