/* Options of `thrum simulate SCENE.json`: few, since the file says the rest.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_options.h"

#include <string.h>

#include "config/message.h"
#include "driver/scene/scene_run.h"
#include "driver/spec/shared_options.h"

#define AT(member) CONFIG_AT(scene_request, member)

static const config_option options[] = {
    OPTION_TEXT("scene", "SCENE.json", NULL, "the scene file", .argument = true, AT(path)),
    OPTION_TEXT("output", "RUN", NULL, "the folder", .letter = 'o', AT(output)),
    OPTION_TIME(scene_request, time, NULL),
    OPTION_DT(scene_request, dt),
    OPTION_COUNT("threads", "1", "of the steps; the results are the same", AT(threads),
                 CONFIG_RANGE(1, THRUM_SCENE_WORKERS_MAX)),
    OPTION_JSON(scene_request),
    OPTION_QUIET(scene_request),
    OPTION_END,
};

/* Its help is that of a run of one model, which names both. */
static const config_command command = {.name = "simulate", .options = options};

/* An option that belongs into the file; NULL: none. */
static const char *of_one_body(int argc, char **argv) {
  for (int n = 1; n < argc && strcmp(argv[n], "--") != 0; n++) {
    if (strncmp(argv[n], "--", 2) != 0)
      continue;
    const size_t length = strcspn(argv[n] + 2, "=");
    bool known = false;
    for (const config_option *option = options; option->about != NULL && !known; option++)
      known = strncmp(argv[n] + 2, option->name, length) == 0;
    if (!known)
      return argv[n];
  }
  return NULL;
}

int scene_run_command(int argc, char **argv) {
  scene_request request = {.threads = 1};
  const char *other = of_one_body(argc, argv);
  if (other != NULL)
    return config_usage("simulate",
                        "'%s' is of a run of one model: write it into the scene file, whose keys "
                        "`thrum schema scene` lists",
                        other);
  CONFIG_TRY(config_options_read_one(&command, "scene", argc, argv, &request, &request.path));
  return scene_run_request(&request);
}
