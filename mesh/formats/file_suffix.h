/* The suffix of a file name, capitals or not.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_FILE_SUFFIX_H
#define THRUM_MESH_FORMATS_FILE_SUFFIX_H

#include <stdbool.h>
#include <string.h>

#include "io/text.h"

/* The name ends in `suffix` (lower case) and has something before it. */
static inline bool thrum_file_has_suffix(const char *name, const char *suffix) {
  const size_t length = strlen(name), ending = strlen(suffix);
  return length > ending && thrum_text_equals(name + length - ending, ending, suffix);
}

#endif
