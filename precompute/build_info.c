/* See build_info.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/build_info.h"

#include <cblas.h>

const char *thrum_build_compiler(void) {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "gcc " __VERSION__;
#else
  return "unknown";
#endif
}

const char *thrum_build_blas_core(void) {
  const char *core = openblas_get_corename();
  return core != 0 ? core : "unknown";
}
