/* OpenCL, as far as it is used here: its handles, numbers and functions by the names, values and
 * types of the OpenCL 1.2 specification (Khronos, revision 19). The library is opened when a
 * program asks for a device, so nothing of it is needed to build or to start.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACCELERATOR_OPENCL_H
#define THRUM_ACCELERATOR_OPENCL_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

typedef struct opencl_platform *opencl_platform;
typedef struct opencl_device *opencl_device;
typedef struct opencl_context *opencl_context;
typedef struct opencl_queue *opencl_queue;
typedef struct opencl_program *opencl_program;
typedef struct opencl_kernel *opencl_kernel;
typedef struct opencl_buffer *opencl_buffer;
typedef struct opencl_event *opencl_event;

#define OPENCL_SUCCESS 0
#define OPENCL_MEM_ALLOCATION_FAILURE (-4)
#define OPENCL_OUT_OF_RESOURCES (-5)
#define OPENCL_OUT_OF_HOST_MEMORY (-6)
#define OPENCL_INVALID_BUFFER_SIZE (-61)
#define OPENCL_DEVICE_TYPE_ALL UINT64_C(0xffffffff)
#define OPENCL_PLATFORM_NAME 0x0902
#define OPENCL_DEVICE_MAX_COMPUTE_UNITS 0x1002
#define OPENCL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT 0x103a
#define OPENCL_DEVICE_MAX_MEM_ALLOC_SIZE 0x1010
#define OPENCL_DEVICE_GLOBAL_MEM_SIZE 0x101f
#define OPENCL_DEVICE_NAME 0x102b
#define OPENCL_DEVICE_EXTENSIONS 0x1030
#define OPENCL_MEM_READ_WRITE UINT64_C(1)
#define OPENCL_PROGRAM_BUILD_LOG 0x1183

/* X(name, result, arguments) */
#define OPENCL_FUNCTIONS(X)                                                                        \
  X(clGetPlatformIDs, int32_t, (uint32_t, opencl_platform *, uint32_t *))                          \
  X(clGetPlatformInfo, int32_t, (opencl_platform, uint32_t, size_t, void *, size_t *))             \
  X(clGetDeviceIDs, int32_t, (opencl_platform, uint64_t, uint32_t, opencl_device *, uint32_t *))   \
  X(clGetDeviceInfo, int32_t, (opencl_device, uint32_t, size_t, void *, size_t *))                 \
  X(clCreateContext, opencl_context,                                                               \
    (const intptr_t *, uint32_t, const opencl_device *,                                            \
     void (*)(const char *, const void *, size_t, void *), void *, int32_t *))                     \
  X(clReleaseContext, int32_t, (opencl_context))                                                   \
  X(clCreateCommandQueue, opencl_queue, (opencl_context, opencl_device, uint64_t, int32_t *))      \
  X(clReleaseCommandQueue, int32_t, (opencl_queue))                                                \
  X(clCreateProgramWithSource, opencl_program,                                                     \
    (opencl_context, uint32_t, const char **, const size_t *, int32_t *))                          \
  X(clBuildProgram, int32_t,                                                                       \
    (opencl_program, uint32_t, const opencl_device *, const char *,                                \
     void (*)(opencl_program, void *), void *))                                                    \
  X(clGetProgramBuildInfo, int32_t,                                                                \
    (opencl_program, opencl_device, uint32_t, size_t, void *, size_t *))                           \
  X(clReleaseProgram, int32_t, (opencl_program))                                                   \
  X(clCreateKernel, opencl_kernel, (opencl_program, const char *, int32_t *))                      \
  X(clSetKernelArg, int32_t, (opencl_kernel, uint32_t, size_t, const void *))                      \
  X(clReleaseKernel, int32_t, (opencl_kernel))                                                     \
  X(clCreateBuffer, opencl_buffer, (opencl_context, uint64_t, size_t, void *, int32_t *))          \
  X(clReleaseMemObject, int32_t, (opencl_buffer))                                                  \
  X(clEnqueueWriteBuffer, int32_t,                                                                 \
    (opencl_queue, opencl_buffer, uint32_t, size_t, size_t, const void *, uint32_t,                \
     const opencl_event *, opencl_event *))                                                        \
  X(clEnqueueReadBuffer, int32_t,                                                                  \
    (opencl_queue, opencl_buffer, uint32_t, size_t, size_t, void *, uint32_t,                      \
     const opencl_event *, opencl_event *))                                                        \
  X(clEnqueueNDRangeKernel, int32_t,                                                               \
    (opencl_queue, opencl_kernel, uint32_t, const size_t *, const size_t *, const size_t *,        \
     uint32_t, const opencl_event *, opencl_event *))                                              \
  X(clFinish, int32_t, (opencl_queue))

typedef struct opencl_library {
#define X(name, result, arguments) result(*name) arguments;
  OPENCL_FUNCTIONS(X)
#undef X
} opencl_library;

/* Finds OpenCL on this machine. THRUM_MISSING with what to install where there is none. */
thrum_status opencl_open(opencl_library *library, thrum_error *error);

#endif
