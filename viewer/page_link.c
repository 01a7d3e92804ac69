/* Links of a page: of sides that `thrum view` made of the whole meshes, and sides to be made of
 * those. SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#include <stdint.h>
#include <string.h>

/* js_scene_add_link with both sides ready. numbers: what they are at rest, 12 each; rows: 12 x
 * rank, NULL for the world. */
int32_t EXPORT(page_add_link)(thrum_scene *scene, int32_t body, int32_t other, int32_t rank,
                              const double *rows, int32_t other_rank, const double *other_rows) {
  thrum_scene_link_side sides[2] = {{.rows = rows, .rank = rank},
                                    {.rows = other_rows, .rank = other_rank}};
  memcpy(sides[0].rest, js_number, sizeof sides[0].rest);
  memcpy(sides[1].rest, js_number + 12, sizeof sides[1].rest);
  ((thrum_scene_link_def *)js_def_made())->sides = sides;
  return js_scene_add_link(scene, body, other);
}

/* Fills the numbers with a link as it was made: place 3, other place 3, length, both sides at rest,
 * 12 each, and the addresses of their rows, which are 0 for the world. */
int32_t EXPORT(page_link_made)(const thrum_scene *scene, int32_t number) {
  thrum_scene_link_def made;
  THRUM_TRY(thrum_scene_link_made(scene, number, &made, &js_failure));
  double *n = js_number;
  memcpy(n, made.place, sizeof made.place);
  memcpy(n + 3, made.other_place, sizeof made.other_place);
  n[6] = made.length;
  memcpy(n + 7, made.sides[0].rest, sizeof made.sides[0].rest);
  memcpy(n + 19, made.sides[1].rest, sizeof made.sides[1].rest);
  for (int side = 0; side < 2; side++)
    n[31 + side] = (double)(uintptr_t)made.sides[side].rows;
  return THRUM_OK;
}
