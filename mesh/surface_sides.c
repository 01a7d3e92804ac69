/* See surface_sides.h. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/surface_sides.h"

#include <stdlib.h>

static int compare_sides(const void *a, const void *b) {
  const thrum_surface_side *x = a, *y = b;
  if (x->low != y->low)
    return x->low < y->low ? -1 : 1;
  if (x->high != y->high)
    return x->high < y->high ? -1 : 1;
  if (x->third != y->third)
    return x->third < y->third ? -1 : 1;
  return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

void thrum_surface_sides_sort(thrum_surface_side *sides, int64_t count) {
  qsort(sides, (size_t)count, sizeof *sides, compare_sides);
}

int32_t thrum_surface_root(int32_t *parent, int32_t i) {
  // every second link is shortened on the way
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}
