/* The names of the models that come with Thrum. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/model_names.h"

#include <string.h>
#include <sys/stat.h>

const char *const model_names[MODEL_NAME_COUNT] = {
#define X(name, text) #name,
    MODEL_NAME_LIST(X)
#undef X
};

bool is_model_name_or_spec(const char *text) {
  static const char *const kinds[] = {"beam:", "mode:", "static:", "sine:"};
  for (int n = 0; n < MODEL_NAME_COUNT; n++)
    if (strcmp(text, model_names[n]) == 0)
      return true;
  for (size_t n = 0; n < sizeof kinds / sizeof kinds[0]; n++)
    if (strncmp(text, kinds[n], strlen(kinds[n])) == 0)
      return true;
  return false;
}

bool is_scene_name(const char *path) {
  struct stat status;
  const size_t length = strlen(path);
  if (length < 6 || strcmp(path + length - 5, ".json") != 0)
    return false;
  return stat(path, &status) != 0 || !S_ISDIR(status.st_mode);
}
