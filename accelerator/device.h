/* A device and its queue, for those who step on it; private to the accelerator library.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACCELERATOR_DEVICE_H
#define THRUM_ACCELERATOR_DEVICE_H

#include <stdbool.h>
#include <string.h>

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

/* The largest magnitude that such a number may have. */
static inline double device_real_most(const thrum_accelerator *accelerator) {
  return accelerator->info.single ? 1e30 : 1e300;
}

/* Number `at` of an array of them: set, and read. */
static inline void device_real_put(const thrum_accelerator *accelerator, void *array, int64_t at,
                                   double value) {
  const float narrow = (float)value;
  const size_t size = device_real(accelerator);
  memcpy((char *)array + (size_t)at * size,
         accelerator->info.single ? (const void *)&narrow : (const void *)&value, size);
}

static inline double device_real_get(const thrum_accelerator *accelerator, const void *array,
                                     int64_t at) {
  float narrow;
  double wide;
  if (!accelerator->info.single) {
    memcpy(&wide, (const char *)array + (size_t)at * sizeof wide, sizeof wide);
    return wide;
  }
  memcpy(&narrow, (const char *)array + (size_t)at * sizeof narrow, sizeof narrow);
  return (double)narrow;
}

/* One of them as an argument of a kernel, for which the caller keeps it. */
typedef struct device_number {
  double bytes;
} device_number;

static inline device_argument device_number_of(const thrum_accelerator *accelerator,
                                               device_number *kept, double value) {
  device_real_put(accelerator, &kept->bytes, 0, value);
  return (device_argument){device_real(accelerator), &kept->bytes};
}

/* Turns an error of OpenCL into a status with a line that says what was being done. */
thrum_status device_failure(int32_t code, const char *what, thrum_error *error);

/* Compiles `source` with these macros set; the caller releases *program. */
thrum_status device_program(const thrum_accelerator *accelerator, const char *source, size_t size,
                            const char *options, opencl_program *program, thrum_error *error);

/* A buffer of the device with `size` bytes, copied from `from` where it is not NULL; the caller
 * releases it. THRUM_OUT_OF_MEMORY with what is needed. */
thrum_status device_buffer(const thrum_accelerator *accelerator, size_t size, const void *from,
                           opencl_buffer *buffer, thrum_error *error);

/* The same of these `count` numbers, in the device's precision. */
thrum_status device_reals(const thrum_accelerator *accelerator, const double *from, int64_t count,
                          opencl_buffer *buffer, thrum_error *error);
void device_release(const thrum_accelerator *accelerator, opencl_buffer *buffer);

/* Copies, and waits until it is done. */
thrum_status device_write(const thrum_accelerator *accelerator, opencl_buffer buffer,
                          const void *from, size_t size, thrum_error *error);
thrum_status device_read(const thrum_accelerator *accelerator, opencl_buffer buffer, void *to,
                         size_t size, thrum_error *error);

/* Waits until all in the queue has ended. */
thrum_status device_wait(const thrum_accelerator *accelerator, thrum_error *error);

/* Puts a kernel into the queue over `items`. */
thrum_status device_run(const thrum_accelerator *accelerator, opencl_kernel kernel,
                        const device_argument *arguments, uint32_t count, const size_t items[2],
                        thrum_error *error);

#endif
