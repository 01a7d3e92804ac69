/* OpenCL found at run time, see opencl.h. SPDX-License-Identifier: Apache-2.0 */
#include "accelerator/opencl.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <string.h>

static const char *const names[] = {"libOpenCL.so.1", "libOpenCL.so", "libOpenCL.dylib",
                                    "/System/Library/Frameworks/OpenCL.framework/OpenCL"};

// one function, by its name; false where the library lacks it
static bool find(void *handle, const char *name, void *function, size_t size) {
  void *const symbol = dlsym(handle, name);
  memcpy(function, &symbol, size);
  return symbol != NULL;
}

thrum_status opencl_open(opencl_library *library, thrum_error *error) {
  void *handle = NULL;
  for (size_t i = 0; i < sizeof names / sizeof *names && !handle; i++)
    handle = dlopen(names[i], RTLD_NOW | RTLD_LOCAL);
  if (!handle)
    return thrum_error_set(error, THRUM_MISSING,
                           "there is no OpenCL on this machine: install the driver of its "
                           "accelerator, or PoCL for its processor (Debian: ocl-icd-libopencl1 and "
                           "pocl-opencl-icd)");

  // it stays open until the program ends, as drivers have threads of their own
  opencl_library found;
#define X(name, result, arguments)                                                                 \
  if (!find(handle, #name, &found.name, sizeof found.name))                                        \
    return thrum_error_set(error, THRUM_UNSUPPORTED,                                               \
                           "the OpenCL of this machine has no " #name ": 1.2 or later is needed");
  OPENCL_FUNCTIONS(X)
#undef X
  *library = found;
  return THRUM_OK;
}
