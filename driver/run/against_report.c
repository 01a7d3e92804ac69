/* How the error that a mesh beside a run has found is told. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/against_report.h"

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

const report_line against_mesh_lines[] = {
    REPORT_LINE("mesh",
                "{against_mesh.velocity_share=null?nothing has moved|"
                "{against_mesh.displacement_share:.3g%|-} of the displacement and "
                "{against_mesh.velocity_share:.3g%} of the velocity are wrong}"
                "{against_mesh.whole?, over the whole run|, to {against_mesh.simulated_s:.3g} of "
                "{options.time:.3g} s: {against_mesh.ended}}",
                .when = "against_mesh"),
    {0}};

bool against_mesh_is_large(const against_mesh *against, const basis_asked *asked) {
  return against->asked && asked->accepted < 1 && against->displacement > asked->accepted;
}
