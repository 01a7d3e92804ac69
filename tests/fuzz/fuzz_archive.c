/* Fuzz target of model and surface files, and of the heads of snapshots, that are drawn: arrays
 * with the shapes and values that belong together, of which some are spoiled, in an archive whose
 * checksums are right.
 *
 * sources: io/npz.c io/zip_write.c io/file.c io/text.c io/npy_file.c platform/*.c
 * core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c SPDX-License-Identifier: Apache-2.0 */
#include <stdbool.h>

#include "core/base/seal.h"
#include "io/npz.h"
#include "tests/fuzz/fuzz_draw.h"
#include "tests/fuzz/fuzz_file.h"
#include "thrum/thrum.h"

#define ARRAYS_MAX 36
#define ARRAY_BYTES 2048

typedef struct drawn_archive {
  thrum_npz_array arrays[ARRAYS_MAX];
  char names[ARRAYS_MAX][32];
  double data[ARRAYS_MAX][ARRAY_BYTES / sizeof(double)];
  int count;
} drawn_archive;

static bool spoils(fuzz_draw *draw) {
  return draw_byte(draw) >= 248;
}

static void set_number(void *data, const char *descr, size_t at, double value) {
  if (strcmp(descr, "<f8") == 0)
    ((double *)data)[at] = value;
  else if (strcmp(descr, "<f4") == 0)
    ((float *)data)[at] = (float)value;
  else if (strcmp(descr, "<i4") == 0)
    ((int32_t *)data)[at] = value > -2e9 && value < 2e9 ? (int32_t)value : INT32_MIN;
  else
    ((uint8_t *)data)[at] = value >= 0 && value < 256 ? (uint8_t)value : 255;
}

/* Adds an array of so many rows and columns (1: a plain vector), with the first `count` of these
 * values and zeros behind; any of that may be spoiled. */
static void add(drawn_archive *archive, fuzz_draw *draw, const char *name, const char *descr,
                int64_t rows, int64_t columns, const double *values, int64_t count) {
  static const char *const descrs[] = {"<f8", "<f4", "<i4", "|u1"};
  const bool bad = spoils(draw);
  const unsigned how = bad ? draw_byte(draw) % 6 : 6;
  if (archive->count == ARRAYS_MAX || how == 0)
    return;
  const int n = archive->count++;
  snprintf(archive->names[n], sizeof archive->names[n], "%s%s", name, how == 1 ? "x" : "");
  if (how == 2)
    rows = draw_index(draw, 9);
  if (how == 3)
    columns = draw_index(draw, 5);
  if (how == 4)
    descr = descrs[draw_byte(draw) % 4];
  const size_t item = descr[1] == 'u' ? 1 : (size_t)(descr[2] - '0');
  const int64_t entries = rows * (columns > 1 ? columns : 1);
  if ((size_t)entries * item > ARRAY_BYTES) {
    // what is spoiled may have no room here, what is right must
    if (!bad)
      abort();
    archive->count--;
    return;
  }

  memset(archive->data[n], 0, ARRAY_BYTES);
  for (int64_t k = 0; k < entries && count > 0; k++)
    set_number(archive->data[n], descr, (size_t)k, values[k % count]);
  if (how == 5 && entries > 0)
    set_number(archive->data[n], descr, (size_t)draw_index(draw, entries), draw_any(draw));
  archive->arrays[n] = (thrum_npz_array){.name = archive->names[n],
                                         .descr = descr,
                                         .rows = rows,
                                         .columns = columns == 1 ? 0 : columns,
                                         .data = archive->data[n],
                                         .size = (size_t)entries * item};
}

#define ADD(name, descr, rows, columns, ...)                                                       \
  add(archive, draw, name, descr, rows, columns, (const double[]){__VA_ARGS__},                    \
      sizeof((const double[]){__VA_ARGS__}) / sizeof(double))

/* Three cubature points: of the law that no file names, of one that is named, or, where `kinds` is
 * 3 in its lowest bits, of two regions with laws and yields of their own. */
static void draw_points(drawn_archive *archive, fuzz_draw *draw, unsigned kinds, int64_t rank) {
  ADD("point_weights", "<f8", 3, 1, 0.1, 0.2);
  ADD("point_moduli", "<f8", 2, 3, 1e6, 2e6, 3e6);
  ADD("point_gradients", "<f8", 27, rank, 0.1, -0.2, 0.3, 0.05);
  if (kinds & 32)
    ADD("point_training", "<f8", 4, 1, 0.3, 0.02, 0.1, 0);
  if ((kinds & 3) == 1)
    ADD("point_law", "|u1", 13, 1, 'c', 'o', 'r', 'o', 't', 'a', 't', 'i', 'o', 'n', 'a', 'l', 0);
  if ((kinds & 3) == 2)
    ADD("point_law", "|u1", 12, 1, 'n', 'e', 'o', '-', 'h', 'o', 'o', 'k', 'e', 'a', 'n', 0);
  if ((kinds & 3) != 3)
    return;

  // laws 0 to 3, of which the last is none, and yields, also of a law that has none
  ADD("point_region", "<i4", 3, 1, 0, 1, kinds >> 7);
  ADD("region_law", "|u1", 2, 1, kinds >> 2 & 3, kinds >> 4 & 3);
  if (kinds & 64)
    ADD("region_yield", "<f8", 2, 1, 0.02, 0);
}

/* A chamber, a strain, a tendon and a gas, whose products have one coefficient each. */
static void draw_actuators(drawn_archive *archive, fuzz_draw *draw, int64_t rank) {
  ADD("actuator_texts", "|u1", 16, 1, 'a', '=', 'c', 0, 'b', '=', 's', 0, 'c', '=', 't', 0, 'd',
      '=', 'g', 0);
  ADD("actuator_kind", "<i4", 4, 1, 0, 1, 2, 3);
  ADD("actuator_rest", "<f8", 4, 3, 0.5, 0, 1, 0, 0, 1, 1, 0, 1, 0.5, 1e5, 1);
  ADD("actuator_linear", "<f8", 4, rank, 0.1);
  ADD("actuator_quadratic", "<f8", 4, rank * rank, 0.2);
  ADD("actuator_cubic", "<f8", 2, rank * rank * (rank + 1) / 2, 0);
  ADD("guide_ends", "<i4", 4, 1, 0, 0, 2, 2);
  ADD("guide_places", "<f8", 2, 3, 0, 0, 0, 1, 0, 0);
  ADD("guide_rows", "<f8", 6, rank, 0.1, -0.2, 0.3);
}

/* One tetrahedron, of four nodes or of ten, held or free, of a polynomial, whole or condensed, or
 * of cubature points. */
static void draw_model(drawn_archive *archive, fuzz_draw *draw) {
  const unsigned bits = draw_byte(draw), kinds = bits & 128 ? draw_byte(draw) : 0;
  const bool mesh = !(bits & 1), points = bits & 128, condensed = bits & 2 && !points,
             is_free = bits & 4, ten = bits & 8;
  const int64_t rank = 2 + (bits >> 6 & 1), vertices = ten ? 10 : 4, masters = rank - 1;
  const bool regions = points && (kinds & 3) == 3, law = points && !regions && kinds & 3;

  // the arrays that every model has
  const int major = regions ? 4 : law ? 3 : ten && mesh ? 2 : 1;
  ADD("format", "<i4", 2, 1, major, (major == 1 ? 2 : 0) + (points && major < 3));
  if (bits & 16)
    ADD("meta", "|u1", 2, 1, '{', '}');
  ADD("omega2", "<f8", rank, 1, 1, 4, 9);
  if (points)
    draw_points(archive, draw, kinds, rank);
  if (!condensed && !points) {
    ADD("c3", "<f8", thrum_c3_count(rank), 1, 0.1, -0.2);
    ADD("c4", "<f8", thrum_c4_count(rank), 1, 0.5, 0.1, 0.5);
  }

  // the mesh, its supports and the groups
  if (mesh) {
    ADD("axis_mass", "<f8", 3, rank, 0.1, 0.2);
    ADD("vertices", "<f8", vertices, 3, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, 0, 0, 0.5, 0.5, 0,
        0, 0.5, 0, 0, 0, 0.5, 0.5, 0, 0.5, 0, 0.5, 0.5);
    ADD("tets", "<i4", 1, 4, 0, 1, 2, 3);
    ADD("tet_region", "<i4", 1, 1, 0);
    ADD("material", "<f8", regions ? 2 : 1, 3, 1e6, 0.3, 1000);
    ADD("fixed", "|u1", vertices, 1, is_free ? 0 : 7, 0, 0, 0, 0, 0, 0, 0, 0, 0);
    ADD("basis", "<f8", 3 * vertices, rank, 0);
    if (bits & 32) {
      ADD("group_names", "|u1", 6, 1, 't', 'i', 'p', 0, 'a', 0);
      ADD("group_ends", "<i4", 2, 1, 2, 3);
      ADD("group_vertices", "<i4", 3, 1, 1, 2, 0);
    }
    if (is_free)
      ADD("rigid", "<f8", 3 * vertices, 6, 0.1);
  }

  // condensed, and of ten nodes
  if (condensed) {
    ADD("slave_map", "<f8", 1, masters * (masters + 1) / 2, 0.1);
    ADD("condensed_c3", "<f8", thrum_c3_count(masters), 1, 0.1);
    ADD("condensed_c4", "<f8", thrum_c4_count(masters), 1, 0.5);
  }
  if (mesh && ten)
    ADD("midsides", "<i4", 1, 6, 4, 5, 6, 7, 8, 9);
  if (mesh && !is_free && !points && bits & 16)
    ADD("springs", "<f8", vertices, 3, 0, 100, 0.5);

  // what its material adds
  if (mesh && !condensed && !points && draw_byte(draw) % 2) {
    ADD("region_energy", "<f8", 2, rank * rank + thrum_c3_count(rank) + thrum_c4_count(rank), 1e-6);
    ADD("region_mass", "<f8", 1, rank * (rank + 3), 1e-3);
  }
  if (!condensed && draw_byte(draw) % 2)
    draw_actuators(archive, draw, rank);
}

/* A surface of one triangle. */
static void draw_embedding(drawn_archive *archive, fuzz_draw *draw) {
  ADD("surface_format", "<i4", 2, 1, 1, 0);
  if (draw_byte(draw) % 2)
    ADD("meta", "|u1", 2, 1, '{', '}');
  ADD("omega2", "<f8", 2, 1, 1, 4);
  ADD("positions", "<f8", 3, 3, 0, 0, 0, 1, 0, 0, 0, 1, 0);
  ADD("triangles", "<i4", 1, 3, 0, 1, 2);
  ADD("basis", "<f4", 9, 2, 0.1, 0.2);
  ADD("tet", "<i4", 3, 1, 0);
  ADD("weights", "<f8", 3, 4, 1, 0, 0, 0);
}

// --- what is read
// ---------------------------------------------------------------------------------

/* The whole file, aligned for a view unless the input says otherwise. */
static void *read_whole(const char *path, size_t *size, size_t shift, void **memory) {
  FILE *file = fopen(path, "rb");
  if (file == NULL || fseek(file, 0, SEEK_END) != 0)
    abort();
  *size = (size_t)ftell(file);
  rewind(file);
  if (posix_memalign(memory, 64, *size + 64) != 0)
    abort();
  void *bytes = (char *)*memory + shift;
  if (fread(bytes, 1, *size, file) != *size)
    abort();
  fclose(file);
  return bytes;
}

static void read_model(const char *path, size_t shift) {
  const thrum_model *model = NULL;
  thrum_model viewed;
  thrum_error error = {0};
  void *memory = NULL;
  size_t size, needed;
  const void *bytes = read_whole(path, &size, shift, &memory);
  const thrum_status loaded = thrum_model_load(path, &model, &error);
  fuzz_check(loaded, &error);
  const thrum_status seen = thrum_model_view(bytes, size, &viewed, &error);
  fuzz_check(seen, &error);
  fuzz_check(thrum_model_size(bytes, size, &needed, &error), &error);

  // what one takes the other takes, but for the alignment
  if (shift == 0 && (loaded < 0) != (seen < 0))
    abort();
  if (loaded >= 0 && thrum_model_check(model, &error) < 0)
    abort();
  if (loaded >= 0)
    thrum_model_destroy(model);
  free(memory);
}

static void read_embedding(const char *path, size_t shift) {
  const thrum_embedding *embedding = NULL;
  thrum_embedding viewed;
  thrum_error error = {0};
  void *memory = NULL;
  size_t size;
  const void *bytes = read_whole(path, &size, shift, &memory);

  // from the file and from memory: what one takes the other takes, but for the alignment
  const thrum_status loaded = thrum_embedding_load(path, &embedding, &error);
  fuzz_check(loaded, &error);
  const thrum_status seen = thrum_embedding_view(bytes, size, &viewed, &error);
  fuzz_check(seen, &error);
  if (shift == 0 && (loaded < 0) != (seen < 0))
    abort();
  if (loaded >= 0)
    thrum_embedding_destroy(embedding);
  free(memory);
}

/* A sealed snapshot whose head is spoiled, or that is cut short. */
static void read_seal(fuzz_draw *draw) {
  static const thrum_seal_kind kind = {{'t', 'h', 'r', 'u', 'm', 's', 't', 'a'}, 3};
  unsigned char bytes[THRUM_SEAL_BYTES + 16] = {0};
  thrum_error error = {0};
  thrum_seal_put(bytes, sizeof bytes, kind);
  for (unsigned n = draw_byte(draw) % 3; n > 0; n--)
    bytes[draw_index(draw, sizeof bytes)] = (unsigned char)draw_byte(draw);
  const unsigned way = draw_byte(draw) % 8;
  const size_t size = way == 1 ? draw_byte(draw) % sizeof bytes : sizeof bytes;
  const size_t expected = way == 2 ? sizeof bytes + 8 : way == 3 ? 40 : sizeof bytes;
  fuzz_check(thrum_seal_check(way == 4 ? NULL : bytes, size, kind, expected, &error), &error);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static drawn_archive archive;
  fuzz_draw draw = {data, size};
  const unsigned byte = draw_byte(&draw);
  archive.count = 0;
  if (byte % 8 == 7) {
    read_seal(&draw);
    return 0;
  }
  const bool embeds = byte % 4 == 1;
  if (embeds)
    draw_embedding(&archive, &draw);
  else
    draw_model(&archive, &draw);

  // a file of that name, in the folder of fuzz_file
  const char *path = fuzz_file(data, 0);
  thrum_error error = {0};
  if (path == NULL || thrum_npz_write(path, archive.arrays, archive.count, &error) < 0)
    return 0;
  const size_t shift = byte >= 240 ? 4 : 0;
  if (embeds)
    read_embedding(path, shift);
  else
    read_model(path, shift);
  return 0;
}
