/* Compares the suffix of a file name; capitals do not matter.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_FILE_SUFFIX_H
#define THRUM_MESH_FORMATS_FILE_SUFFIX_H

#include <stdbool.h>
#include <string.h>

#include "io/text.h"

/* Tells whether a name ends in `suffix`, given in lower case, and has characters in front of it. */
static inline bool thrum_file_has_suffix(const char *name, const char *suffix) {
  const size_t length = strlen(name), ending = strlen(suffix);
  return length > ending && thrum_text_equals(thrum_word_of(name + length - ending), suffix);
}

#endif
