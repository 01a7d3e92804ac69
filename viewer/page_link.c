/* Links between bodies of a page, of sides that `thrum view` made of the whole meshes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#include <string.h>

/* numbers: place 3, other place 3, stiffness, damping, length, until, then what both sides are at
 * rest, 12 each. other: -1 for the world, whose side has no rows. rows: 12 x rank. The path has
 * times and places (x 3). Returns the link's number, or a status below 0. */
int32_t EXPORT(bridge_add_link)(int32_t kind, int32_t body, int32_t other, int32_t rank,
                                const double *rows, int32_t other_rank, const double *other_rows,
                                int32_t path_count, const double *times, const double *places) {
  const double *n = bridge_number;
  thrum_scene_link_side sides[2] = {{.rows = rows, .rank = rank},
                                    {.rows = other_rows, .rank = other_rank}};
  memcpy(sides[0].rest, n + 10, sizeof sides[0].rest);
  memcpy(sides[1].rest, n + 22, sizeof sides[1].rest);

  // what it ties, how, and for how long
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = (thrum_link_kind)kind;
  def.body = body;
  def.other = other;
  def.sides = sides;
  memcpy(def.place, n, sizeof def.place);
  memcpy(def.other_place, n + 3, sizeof def.other_place);
  def.stiffness = n[6];
  def.damping = n[7];
  def.length = n[8];
  def.until = n[9];
  def.path_times = times;
  def.path_places = places;
  def.path_count = path_count;
  int32_t number;
  const thrum_status status = thrum_scene_add_link(bridge_scene, &def, &number, &bridge_error);
  return status == THRUM_OK ? number : (int32_t)status;
}

/* numbers: whether it holds, where its two ends are 3 each, mean force of the last step on the
 * first 3 [N], how far a joint is open and was at most [m], energy in its spring [J]. */
int32_t EXPORT(bridge_link)(int32_t number) {
  thrum_scene_link link;
  THRUM_TRY(thrum_scene_link_get(bridge_scene, number, &link, &bridge_error));
  double *n = bridge_number;
  n[0] = link.holds;
  memcpy(n + 1, link.places, sizeof link.places);
  memcpy(n + 7, link.report.force, sizeof link.report.force);
  n[10] = link.report.drift;
  n[11] = link.report.largest_drift;
  n[12] = link.report.stored;
  return THRUM_OK;
}
