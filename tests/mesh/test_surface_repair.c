/* Surfaces of daily life are mended where nothing is lost, each repair is counted, and what is
 * really open stays so. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>

#include "mesh/formats/surface_read.h"
#include "mesh/surface_check.h"
#include "mesh/surface_join.h"
#include "mesh/surface_repair.h"

/* A unit cube; its corners are numbered by their bits, 1 + 4 x + 2 y + z in the file. */
#define CORNERS "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n"
#define SIDES "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\n"
#define LID "f 2 6 8 4\n"

/* Reads a surface, mends it, and checks it. */
static thrum_surface_repairs mend(const char *text, double volume) {
  thrum_surface_mesh surface = {0};
  thrum_surface_repairs repairs = {0};
  thrum_surface_checked checked = {0};
  thrum_error error = {0};
  int64_t joined = 0;
  if (thrum_surface_parse_obj("s.obj", text, strlen(text), &surface, &error) < 0 ||
      thrum_surface_join(&surface, &joined, &error) < 0 ||
      thrum_surface_repair(&surface, &repairs, &error) < 0 ||
      thrum_surface_check(&surface, &checked, &error) < 0)
    fail_msg("%s", error.message);

  // a volume says that a body can be meshed in it
  const thrum_status status = thrum_surface_meshable(&surface, &checked, "s.obj", &error);
  if ((status >= 0) != (volume > 0))
    fail_msg("%s", error.message);
  if (volume > 0 && !(fabs(checked.volume - volume) < 1e-6))
    fail_msg("volume %g, not %g", checked.volume, volume);
  assert_true(volume <= 0 || checked.turned.count == 0);
  thrum_surface_mesh_free(&surface);
  return repairs;
}

static void expect(thrum_surface_repairs r, int joined, int flat, int split, int twice, int walls) {
  if (r.joined != joined || r.flat != flat || r.split != split || r.twice != twice ||
      r.walls != walls)
    fail_msg("joined %d, flat %d, split %d, twice %d, walls %d", (int)r.joined, (int)r.flat,
             (int)r.split, (int)r.twice, (int)r.walls);
}

static void a_sound_surface_stays_as_it_is(void **state) {
  (void)state;
  expect(mend(CORNERS SIDES LID, 1), 0, 0, 0, 0, 0);

  // a hole stays a hole, however small the faults beside it are
  expect(mend(CORNERS SIDES, 0), 0, 0, 0, 0, 0);
  expect(mend(CORNERS SIDES "f 1 1 5\n", 0), 0, 1, 0, 0, 0);
}

static void a_triangle_without_area_splits_its_neighbour(void **state) {
  (void)state;

  // 9 lies on the edge from 1 to 5: two triangles meet it on one side, and none on the other
  expect(mend(CORNERS "v .5 0 0\nf 1 2 4 3\nf 5 7 8 6\nf 1 9 6\nf 9 5 6\nf 1 6 2\nf 3 4 8 7\n"
                      "f 1 3 7 5\nf 1 5 9\n" LID,
              1),
         0, 1, 1, 0, 0);

  // three in a row, each on the long side of the next one
  expect(mend(CORNERS "v .25 0 0\nv .5 0 0\nv .75 0 0\nf 1 2 4 3\nf 5 7 8 6\nf 1 9 6\nf 9 10 6\n"
                      "f 10 11 6\nf 11 5 6\nf 1 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 1 5 11\nf 1 11 10\n"
                      "f 1 10 9\n" LID,
              1),
         0, 3, 3, 0, 0);

  // one with a corner twice has nothing to split
  expect(mend(CORNERS SIDES LID "f 1 1 5\nf 2 2 2\n", 1), 0, 2, 0, 0, 0);
}

static void triangles_on_each_other_are_left_once_or_not_at_all(void **state) {
  (void)state;
  expect(mend(CORNERS SIDES LID "f 2 6 8\nf 6 8 2\nf 8 2 6\n", 1), 0, 0, 0, 3, 0);
  expect(mend(CORNERS SIDES LID "f 1 2 8\nf 2 1 8\n", 1), 0, 0, 0, 0, 1);

  // two cubes that share a side, each with a wall of its own there
  expect(mend(CORNERS SIDES LID "v 2 0 0\nv 2 0 1\nv 2 1 0\nv 2 1 1\nf 5 6 8 7\nf 9 11 12 10\n"
                                "f 5 9 10 6\nf 7 8 12 11\nf 5 7 11 9\nf 6 10 12 8\n",
              2),
         0, 0, 0, 0, 2);
}

static void cracks_without_width_are_closed(void **state) {
  (void)state;

  // an edge that one side has in three parts
  expect(mend(CORNERS "v .25 0 0\nv .5 0 0\nf 1 2 4 3\nf 5 7 8 6\nf 1 9 6\nf 9 10 6\nf 10 5 6\n"
                      "f 1 6 2\nf 3 4 8 7\nf 1 3 7 5\n" LID,
              1),
         0, 0, 2, 0, 0);

  // corners that every triangle writes in another last digit
  char text[4000];
  static const int faces[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5},
                                   {0, 4, 5}, {0, 5, 1}, {2, 3, 7}, {2, 7, 6},
                                   {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  int used = 0;
  for (int t = 0; t < 12; t++)
    for (int c = 0; c < 3; c++) {
      const int v = faces[t][c], n = 3 * t + c;
      used += sprintf(text + used, "v %.9f %.9f %.9f\n", (v >> 2) + 3e-7 * (n % 3),
                      (v >> 1 & 1) - 3e-7 * (n % 4), (v & 1) + 2e-7 * (n % 5));
    }
  for (int t = 0; t < 12; t++)
    used += sprintf(text + used, "f %d %d %d\n", 3 * t + 1, 3 * t + 2, 3 * t + 3);
  const thrum_surface_repairs r = mend(text, 1);
  assert_true(r.joined > 20 && r.joined <= 28);
  assert_int_equal(r.flat + r.split + r.twice + r.walls, 0);

  // an edge that one side has in many parts, and the same closed by as many triangles without area
  enum { PARTS = 200 };
  for (int flat = 0; flat < 2; flat++) {
    static char fan[40000];
    used = sprintf(fan, "%s", CORNERS "f 1 2 4 3\nf 5 7 8 6\nf 1 6 2\nf 3 4 8 7\nf 1 3 7 5\n" LID);
    for (int n = 1; n < PARTS; n++)
      used += sprintf(fan + used, "v %.9f 0 0\n", (double)n / PARTS);
    for (int n = 0; n < PARTS; n++) {
      const int from = n == 0 ? 1 : 8 + n, to = n + 1 == PARTS ? 5 : 9 + n;
      used += sprintf(fan + used, "f %d %d 6\n", from, to);
      if (flat > 0 && n > 0)
        used += sprintf(fan + used, "f 1 %d %d\n", to, from);
    }
    expect(mend(fan, 1), 0, flat * (PARTS - 1), PARTS - 1, 0, 0);
  }

  // a gap that can be seen is none of these
  assert_int_equal(mend(CORNERS "v 0 0 1.001\n" SIDES "f 9 6 8\nf 9 8 4\n", 0).joined, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_sound_surface_stays_as_it_is),
      cmocka_unit_test(a_triangle_without_area_splits_its_neighbour),
      cmocka_unit_test(triangles_on_each_other_are_left_once_or_not_at_all),
      cmocka_unit_test(cracks_without_width_are_closed),
  };

  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
