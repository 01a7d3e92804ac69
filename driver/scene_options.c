/* Options of `thrum simulate SCENE.json`: few, since the file says the rest.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene_options.h"

#include <math.h>
#include <string.h>

#include "config/message.h"
#include "driver/scene_run.h"

static const config_option table[] = {
    {.name = "scene",
     .kind = CONFIG_TEXT,
     .argument = true,
     .field = offsetof(scene_request, path)},
    {.name = "output",
     .letter = 'o',
     .kind = CONFIG_TEXT,
     .field = offsetof(scene_request, output)},
    {.name = "time",
     .kind = CONFIG_NUMBER,
     .field = offsetof(scene_request, time),
     .most = INFINITY,
     .above = true,
     .wants = "a time above 0 s"},
    {.name = "dt",
     .kind = CONFIG_NUMBER,
     .field = offsetof(scene_request, dt),
     .most = INFINITY,
     .above = true,
     .wants = "a time step above 0 s"},
    CONFIG_OPTION_JSON(scene_request),
    CONFIG_OPTION_QUIET(scene_request),
    {.name = NULL},
};

/* An option that belongs into the file; NULL: none. */
static const char *of_one_body(int argc, char **argv) {
  for (int n = 1; n < argc && strcmp(argv[n], "--") != 0; n++) {
    if (strncmp(argv[n], "--", 2) != 0)
      continue;
    const size_t length = strcspn(argv[n] + 2, "=");
    bool known = false;
    for (const config_option *option = table; option->name != NULL && !known; option++)
      known = strncmp(argv[n] + 2, option->name, length) == 0;
    if (!known)
      return argv[n];
  }
  return NULL;
}

int scene_run_command(int argc, char **argv) {
  scene_request request = {0};
  const char *other = of_one_body(argc, argv);
  if (other != NULL)
    return config_usage("simulate", "'%s' is of a run of one model: write it into the scene file",
                        other);
  int code = config_options_read("simulate", table, argc, argv, &request);
  if (code == COMMAND_DONE)
    code = config_one_argument("simulate", "scene", argc, argv, &request.path);
  return code == COMMAND_DONE ? scene_run_request(&request) : code;
}
