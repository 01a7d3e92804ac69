/* The names of the models that come with Thrum. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model_names.h"

#include <string.h>

const char *const cli_model_names[CLI_MODEL_COUNT] = {
#define X(name, text) #name,
    CLI_MODEL_LIST(X)
#undef X
};

bool is_model_name_or_spec(const char *text) {
  static const char *const kinds[] = {"beam:", "mode:", "static:", "sine:"};
  for (int n = 0; n < CLI_MODEL_COUNT; n++)
    if (strcmp(text, cli_model_names[n]) == 0)
      return true;
  for (size_t n = 0; n < sizeof kinds / sizeof kinds[0]; n++)
    if (strncmp(text, kinds[n], strlen(kinds[n])) == 0)
      return true;
  return false;
}
