/* Springs to the ground, see mesh_springs.h. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_springs.h"

#include <math.h>
#include <string.h>

#include "io/text.h"
#include "mesh/mesh_fix.h"
#include "platform/allocate.h"

#define STIFFNESS_MAX 1e30 /* beyond it products leave the range of doubles */

/* k, or kx,ky,kz, of the text behind the last colon. */
static thrum_status read_stiffness(const char *spec, const char *text, double stiffness[3],
                                   thrum_error *error) {
  const char *end = text + strlen(text), *at = text;
  int count = 0;
  bool good = *text != 0;
  for (; good && at < end && count < 3; count++) {
    const size_t used = thrum_text_scan_number(at, end, &stiffness[count]);
    good = used > 0 && stiffness[count] >= 0 && stiffness[count] <= STIFFNESS_MAX;
    at += used;
    if (good && count < 2 && at < end && *at == ',' && at + 1 < end)
      at++;
  }
  if (!good || at != end || count == 2)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.100s': after the last colon stands a stiffness in N/m of 0 or more, "
                           "or three along x, y and z, such as mid:37 or mid:0,0,37",
                           spec);
  if (count == 1)
    stiffness[1] = stiffness[2] = stiffness[0];
  return THRUM_OK;
}

thrum_status thrum_mesh_add_springs(thrum_mesh *mesh, const char *spec, thrum_error *error) {
  const char *colon = strrchr(spec, ':');
  double stiffness[3] = {0, 0, 0};
  int64_t count = 0;
  if (colon == NULL || colon == spec)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "'%.100s': a spring is WHERE:k or WHERE:kx,ky,kz in N/m, such as mid:37",
                           spec);
  THRUM_TRY(read_stiffness(spec, colon + 1, stiffness, error));

  // the vertices, by the words of --fix
  thrum_scope scope = thrum_scope_begin("the springs", error);
  char *where = thrum_scope_allocate(&scope, colon - spec + 1, 1);
  uint8_t *marks = thrum_scope_allocate(&scope, mesh->vertex_count, 1);
  double *springs = mesh->springs;
  thrum_status status = scope.status;
  if (status >= 0) {
    memcpy(where, spec, (size_t)(colon - spec));
    memset(marks, 0, (size_t)mesh->vertex_count);
    status = thrum_mesh_fix(mesh, where, marks, &count, error);
  }

  // nothing pulls where all are 0, and a free body stays one
  const bool pulls = stiffness[0] > 0 || stiffness[1] > 0 || stiffness[2] > 0;
  if (status >= 0 && springs == NULL && pulls)
    status = thrum_reserve(&springs, mesh->vertex_count, 3 * sizeof *springs, "the springs", error);

  // each takes its share
  if (status >= 0 && pulls) {
    mesh->springs = springs;
    count = 0;
    for (int64_t v = 0; v < mesh->vertex_count; v++)
      count += marks[v] != 0;
    for (int64_t c = 0; c < 3 * mesh->vertex_count; c++)
      if (marks[c / 3] >> (c % 3) & 1)
        springs[c] += stiffness[c % 3] / (double)count;
  }
  thrum_scope_free(&scope);
  return status;
}
