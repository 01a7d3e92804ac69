/* Hand-made models for tests of `thrum simulate`, and readers of the files that a run writes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_SIMULATE_SUPPORT_H
#define THRUM_TESTS_SUPPORT_SIMULATE_SUPPORT_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/npy_file.h"
#include "io/npz.h"
#include "tests/support/program_support.h"
#include "thrum/thrum.h"

/* One tetrahedron, r = 2, no strain energy but 1/2 omega^2 q^2. Every displacement is U q, every
 * force U^T f, so that with omega = 0 the momentum is the time integral of the load exactly. */
#define PARTICLE_RANK 2
static const double particle_basis[12 * PARTICLE_RANK] = {
    0,   0,    0,    0,   0,   0,    /* vertex 1 is held */
    0.5, 0,    0,    0,   0.1, 0.3,  /* vertex 2 */
    0,   0.25, 0,    0.5, 0.2, -0.4, /* vertex 3 */
    0,   0,    0.75, 0,   0.7, 0.9,  /* vertex 4 */
};
static const double particle_axis_mass[3 * PARTICLE_RANK] = {1.5, 0, 0, 2.5, 0.7, -0.3};

/* Writes such a model with these two squared frequencies and the groups "tip" = {4},
 * "a, b" = {1, 2, 4} and "held" = {1}. */
static inline bool save_particle(const char *path, double omega2_first, double omega2_second) {
  // one tetrahedron; vertex 1 is held
  static const double zeros[5] = {0};
  static const double vertices[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  static const double material[3] = {1e6, 0.3, 1000};
  static const int32_t tets[4] = {0, 1, 2, 3}, region[1] = {0}, format[2] = {1, 0};
  static const uint8_t fixed[4] = {7, 0, 0, 0};

  // the groups, one of them with a comma and a blank in its name
  static const char names[] = "tip\0a, b\0held";
  static const int32_t ends[3] = {1, 4, 5}, members[5] = {3, 0, 1, 3, 0};
  const double omega2[PARTICLE_RANK] = {omega2_first, omega2_second};

  // no strain energy beyond the frequencies
  const thrum_model model = {
      .rank = PARTICLE_RANK,
      .c3_count = 4,
      .c4_count = 5,
      .vertex_count = 4,
      .tet_count = 1,
      .region_count = 1,
      .group_count = 3,
      .group_name_bytes = sizeof names,
      .group_vertex_count = 5,
      .format = format,
      .omega2 = omega2,
      .c3 = zeros,
      .c4 = zeros,
      .axis_mass = particle_axis_mass,
      .vertices = vertices,
      .tets = tets,
      .tet_region = region,
      .material = material,
      .fixed = fixed,
      .basis = particle_basis,
      .group_names = (const uint8_t *)names,
      .group_ends = ends,
      .group_vertices = members,
  };

  return thrum_model_save(path, &model, NULL) == THRUM_OK;
}

/* A polynomial alone, of rank 1: an oscillator with a quartic term, no mesh and no basis. */
static inline bool save_oscillator(const char *path, double omega2, double quartic) {
  static const int32_t format[2] = {1, 0};
  static const double zero = 0;
  const thrum_model model = {
      .rank = 1,
      .c3_count = 1,
      .c4_count = 1,
      .format = format,
      .omega2 = &omega2,
      .c3 = &zero,
      .c4 = &quartic,
  };
  return thrum_model_save(path, &model, NULL) == THRUM_OK;
}

static inline bool save_npy(const char *path, const double *values, int64_t rows, int64_t columns) {
  unsigned char header[192];
  const size_t size = thrum_npy_header_f8(header, rows, columns);
  const size_t count = (size_t)(rows * (columns > 0 ? columns : 1));
  FILE *file = fopen(path, "wb");
  if (file == NULL)
    return false;
  const bool done =
      fwrite(header, 1, size, file) == size && fwrite(values, sizeof *values, count, file) == count;
  return fclose(file) == 0 && done;
}

/* One row of energy.csv. */
typedef struct energy_row {
  double step, time, kinetic, potential, total, high;
} energy_row;

/* Reads energy.csv; the caller frees the rows. NULL unless every line is valid. */
static inline energy_row *read_energies(const char *path, int64_t *count) {
  static const char header[] = "step,time_s,kinetic_j,potential_j,total_j,high_j\n";
  char *text = text_file_read(path);

  // the header, to the letter
  if (text == NULL || strncmp(text, header, sizeof header - 1) != 0) {
    free(text);
    return NULL;
  }

  // no more rows than lines
  int64_t lines = 0;
  for (const char *at = text; *at != 0; at++)
    lines += *at == '\n';
  energy_row *rows = calloc((size_t)lines, sizeof *rows);
  *count = 0;

  // six numbers in each line, without a blank
  for (const char *at = text + sizeof header - 1; rows != NULL && *at != 0;) {
    energy_row *row = &rows[*count];
    double *values[6] = {&row->step,      &row->time,  &row->kinetic,
                         &row->potential, &row->total, &row->high};
    for (int n = 0; n < 6; n++) {
      char *end = NULL;
      *values[n] = strtod(at, &end);
      if (end == at || *end != (n < 5 ? ',' : '\n')) {
        free(rows);
        free(text);
        return NULL;
      }
      at = end + 1;
    }
    ++*count;
  }

  free(text);
  return rows;
}

#endif
