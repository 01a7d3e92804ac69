/* The scene of a pack. SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"
#include "cli/pack.h"

#define COLOUR "#4a86c5"

cJSON *cli_pack_scene_of_models(const cli_pack_model *models) {
  static const double none[4] = {0}, unturned[4] = {0, 0, 0, 1};
  const thrum_state_def def = thrum_default_state_def();
  cJSON *scene = cJSON_CreateObject(), *body = cJSON_CreateObject();
  cli_json_number(scene, "dt", def.dt);
  cJSON_AddStringToObject(scene, "integrator", "imexv");
  cli_json_numbers(scene, "gravity", none, 3);
  cli_json_number(scene, "damping", 0);
  cJSON_AddArrayToObject(scene, "obstacles");
  cli_json_string(body, "name", models[0].name);
  cli_json_number(body, "model", 0);
  cli_json_numbers(body, "position", none, 3);
  cli_json_numbers(body, "rotation", unturned, 4);
  cli_json_number(body, "scale", 1);
  cli_json_number(body, "stiffness", 1);
  cli_json_number(body, "density", 1);
  cli_json_number(body, "rank", (double)models[0].model->rank);
  cJSON_AddStringToObject(body, "colour", COLOUR);
  cJSON_AddBoolToObject(body, "free", false);
  cJSON_AddItemToArray(cJSON_AddArrayToObject(scene, "bodies"), body);
  return scene;
}
