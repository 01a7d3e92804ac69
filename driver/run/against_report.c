/* How the error that a mesh beside a run has found is told. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/against_report.h"

#include <math.h>
#include <stdio.h>

#include "io/json.h"

void against_mesh_json(const against_mesh *against, cJSON *object) {
  cJSON *made = json_section(object, "against_mesh", against->asked);
  if (made == NULL)
    return;
  json_number(made, "displacement_share", against->displacement);
  json_number(made, "velocity_share", against->velocity);
  json_number(made, "steps", (double)against->steps);
  json_number(made, "simulated_s", against->time);
  cJSON_AddBoolToObject(made, "whole", against->whole);
  json_string(made, "ended", against->ended);
  json_string(made, "stepped_by", against->stepped_by);
  json_number(made, "seconds", against->seconds);
}

void against_mesh_print(const against_mesh *against, const simulate_request *request) {
  if (!against->asked)
    return;
  if (isnan(against->displacement) || isnan(against->velocity))
    printf("mesh         nothing has moved");
  else
    printf("mesh         %.3g %% of the displacement and %.3g %% of the velocity are wrong",
           100 * against->displacement, 100 * against->velocity);
  if (against->whole)
    puts(", over the whole run");
  else
    printf(", to %.3g of %.3g s: %s\n", against->time, request->time, against->ended);
}

bool against_mesh_is_large(const against_mesh *against, const basis_asked *asked) {
  return against->asked && asked->accepted < 1 && against->displacement > asked->accepted;
}
