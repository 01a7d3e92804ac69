/* The devices of this machine (thrum/accelerator.h). SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accelerator/device.h"
#include "core/base/def.h"

#define PLATFORMS_MOST 16
#define DEVICES_MOST 64
#define EXTENSIONS_MOST 16384

/* --- which there are -------------------------------------------------------------------------- */

// device `number` of all platforms, or NULL; *count of them
static opencl_device find_device(const opencl_library *cl, int32_t number,
                                 opencl_platform *platform, int32_t *count) {
  opencl_platform platforms[PLATFORMS_MOST];
  opencl_device found = NULL;
  uint32_t platform_count = 0;
  *count = 0;

  // without a driver there is no platform, which the loader calls a failure
  if (cl->clGetPlatformIDs(PLATFORMS_MOST, platforms, &platform_count) != OPENCL_SUCCESS)
    return NULL;
  for (uint32_t i = 0; i < platform_count && i < PLATFORMS_MOST; i++) {
    opencl_device devices[DEVICES_MOST];
    uint32_t here = 0;
    if (cl->clGetDeviceIDs(platforms[i], OPENCL_DEVICE_TYPE_ALL, DEVICES_MOST, devices, &here) !=
        OPENCL_SUCCESS)
      continue;
    here = here < DEVICES_MOST ? here : DEVICES_MOST;
    if (number >= *count && number < *count + (int32_t)here) {
      found = devices[number - *count];
      *platform = platforms[i];
    }
    *count += (int32_t)here;
  }
  return found;
}

thrum_status thrum_accelerator_count(int32_t *count, thrum_error *error) {
  if (!count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "count is NULL");
  opencl_library cl;
  opencl_platform platform;
  THRUM_TRY(opencl_open(&cl, error));
  find_device(&cl, -1, &platform, count);
  return THRUM_OK;
}

/* --- one of them ------------------------------------------------------------------------------ */

void thrum_accelerator_def_init(thrum_accelerator_def *def, size_t size) {
  const thrum_accelerator_def defaults = {.cookie = sizeof(thrum_accelerator_def)};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

static void describe(thrum_accelerator *a, opencl_platform platform) {
  thrum_accelerator_info *info = &a->info;
  uint64_t memory = 0, most = 0;
  uint32_t units = 0, width = 1;
  char *const extensions = calloc(EXTENSIONS_MOST, 1);
  a->cl.clGetDeviceInfo(a->device, OPENCL_DEVICE_NAME, sizeof info->name - 1, info->name, NULL);
  a->cl.clGetPlatformInfo(platform, OPENCL_PLATFORM_NAME, sizeof info->platform - 1, info->platform,
                          NULL);
  a->cl.clGetDeviceInfo(a->device, OPENCL_DEVICE_GLOBAL_MEM_SIZE, sizeof memory, &memory, NULL);
  a->cl.clGetDeviceInfo(a->device, OPENCL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof most, &most, NULL);
  a->cl.clGetDeviceInfo(a->device, OPENCL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
  a->cl.clGetDeviceInfo(a->device, OPENCL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT, sizeof width, &width,
                        NULL);
  a->lanes = width >= 16 ? 16 : width >= 8 ? 8 : width >= 4 ? 4 : 1;
  a->wide = a->lanes > 4 ? a->lanes : 4;
  if (extensions) {
    a->cl.clGetDeviceInfo(a->device, OPENCL_DEVICE_EXTENSIONS, EXTENSIONS_MOST - 1, extensions,
                          NULL);
    info->has_double = strstr(extensions, "cl_khr_fp64") != NULL;
  }
  free(extensions);
  info->memory = (int64_t)memory;
  info->buffer_most = (int64_t)most;
  info->units = (int32_t)units;
}

static thrum_status check_def(const thrum_accelerator_def *def, thrum_error *error) {
  if (!def || !thrum_def_fits(def->cookie, sizeof *def))
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def was not made by thrum_accelerator_def_init");
  if (def->device < 0)
    return thrum_error_set_field(error, "device", THRUM_INVALID_ARGUMENT, " is below 0");
  if ((def->single != 0 && def->single != 1) || def->reserved != 0)
    return thrum_error_set_field(error, "single", THRUM_INVALID_ARGUMENT,
                                 " is not 0 or 1, or reserved is not 0");
  return THRUM_OK;
}

static thrum_status take_device(const thrum_accelerator_def *def, thrum_accelerator *a,
                                thrum_error *error) {
  int32_t count;
  opencl_platform platform;
  THRUM_TRY(opencl_open(&a->cl, error));
  a->device = find_device(&a->cl, def->device, &platform, &count);
  if (count == 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "OpenCL is here, but no device: install the driver of the accelerator, "
                           "or PoCL for the processor (Debian: pocl-opencl-icd)");
  if (!a->device)
    return thrum_error_set_field(error, "device", THRUM_INVALID_ARGUMENT,
                                 ": there is no device %d: this machine has %d", (int)def->device,
                                 (int)count);
  describe(a, platform);
  a->info.single = def->single;
  if (!a->info.has_double && !def->single)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.100s has no double precision: set `single`, and q and p have 7 "
                           "digits",
                           a->info.name);

  int32_t code;
  a->context = a->cl.clCreateContext(NULL, 1, &a->device, NULL, NULL, &code);
  if (!a->context)
    return device_failure(code, "the device is taken", error);
  a->queue = a->cl.clCreateCommandQueue(a->context, a->device, 0, &code);
  return a->queue ? THRUM_OK : device_failure(code, "its queue is made", error);
}

thrum_status thrum_accelerator_create(const thrum_accelerator_def *def,
                                      thrum_accelerator **accelerator, thrum_error *error) {
  if (!accelerator)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "accelerator is NULL");
  THRUM_TRY(check_def(def, error));
  thrum_accelerator_def defaults = thrum_default_accelerator_def();
  def = thrum_def_whole(def, &defaults, sizeof defaults);

  thrum_accelerator *const made = calloc(1, sizeof *made);
  if (!made)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for an accelerator");
  const thrum_status status = take_device(def, made, error);
  if (status != THRUM_OK) {
    thrum_accelerator_destroy(made);
    return status;
  }
  *accelerator = made;
  return THRUM_OK;
}

void thrum_accelerator_destroy(thrum_accelerator *accelerator) {
  if (!accelerator)
    return;
  if (accelerator->queue)
    accelerator->cl.clReleaseCommandQueue(accelerator->queue);
  if (accelerator->context)
    accelerator->cl.clReleaseContext(accelerator->context);
  free(accelerator);
}

thrum_status thrum_accelerator_get_info(const thrum_accelerator *accelerator,
                                        thrum_accelerator_info *info, thrum_error *error) {
  if (!accelerator || !info)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the accelerator or info is NULL");
  *info = accelerator->info;
  return THRUM_OK;
}
