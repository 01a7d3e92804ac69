/* A folder of models for tests of models by name: a short bar as beam.msh, and its recipe.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_MODEL_FOLDER_H
#define THRUM_TESTS_SUPPORT_MODEL_FOLDER_H

#include <stdio.h>

#include "tests/support/program_support.h"

#define BAR_CELLS 5

/* The number, from 1, of the bar's vertex at cell corner (i, j, k). */
static inline int bar_vertex(int i, int j, int k) {
  return 1 + (i * 2 + j) * 2 + k;
}

/* The six tetrahedra of cell `i`, each from corner 000 to corner 111 along three edges. */
static inline void bar_cell(FILE *file, int i, int *number) {
  static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int t = 0; t < 6; t++) {
    int corner[3] = {0, 0, 0}, vertices[4] = {bar_vertex(i, 0, 0)};
    for (int n = 0; n < 3; n++) {
      corner[orders[t][n]] = 1;
      vertices[n + 1] = bar_vertex(i + corner[0], corner[1], corner[2]);
    }
    // odd permutations have the opposite orientation
    const bool odd = t == 1 || t == 2 || t == 5;
    fprintf(file, "%d 4 2 1 1 %d %d %d %d\n", ++*number, vertices[0], vertices[1],
            vertices[odd ? 3 : 2], vertices[odd ? 2 : 3]);
  }
}

/* A bar of 1 m x 0.2 m x 0.2 m along x; the end x = 1 is the group "load". */
static inline bool write_bar(const char *path) {
  FILE *file = fopen(path, "w");
  if (file == NULL)
    return false;

  // the vertices of all cross-sections
  int number = 2;
  fprintf(file,
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 2 \"load\"\n"
          "3 1 \"body\"\n$EndPhysicalNames\n$Nodes\n%d\n",
          4 * (BAR_CELLS + 1));
  for (int i = 0; i <= BAR_CELLS; i++) {
    for (int n = 0; n < 4; n++)
      fprintf(file, "%d %.17g %g %g\n", bar_vertex(i, n / 2, n % 2), (double)i / BAR_CELLS,
              0.2 * (n / 2), 0.2 * (n % 2));
  }

  // the end face in two triangles, and the body in six tetrahedra per cell
  const int end[4] = {bar_vertex(BAR_CELLS, 0, 0), bar_vertex(BAR_CELLS, 0, 1),
                      bar_vertex(BAR_CELLS, 1, 0), bar_vertex(BAR_CELLS, 1, 1)};
  fprintf(file, "$EndNodes\n$Elements\n%d\n1 2 2 2 1 %d %d %d\n2 2 2 2 1 %d %d %d\n",
          2 + 6 * BAR_CELLS, end[0], end[1], end[3], end[0], end[3], end[2]);
  for (int i = 0; i < BAR_CELLS; i++)
    bar_cell(file, i, &number);
  fputs("$EndElements\n", file);
  return fclose(file) == 0;
}

/* NAME.json beside the mesh, with this Young's modulus. */
static inline bool write_bar_recipe(const char *path, const char *young) {
  char text[512];
  snprintf(text, sizeof text,
           "{\"order\": 1, \"material\": {\"young\": %s, \"poisson\": 0.3, \"density\": 1000},\n"
           " \"fix\": [\"x<0.001\"], \"modes\": 3, \"rank\": 5}\n",
           young);
  return text_file_write(path, text);
}

#endif
