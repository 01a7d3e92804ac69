/* A small model with every array, and a maker of model files with one thing wrong, for tests.
 * Header only. The maker shares no code with the writer under test.
 *
 *   archive a = archive_sample();
 *   archive_find(&a, "c3")->type = "<f4";
 *   size_t size = archive_build(&a, buffer);
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_MODEL_ARCHIVE_H
#define THRUM_TESTS_SUPPORT_MODEL_ARCHIVE_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/model.h"

enum { ARCHIVE_PARTS = 20, ARCHIVE_DATA = 768, ARCHIVE_MAX = 16384 };

typedef enum archive_extra {
  EXTRA_NONE,
  EXTRA_PADDING,      /* as the writer pads: a record of zeros up to a multiple of 64 */
  EXTRA_ZIP64,        /* as numpy.savez before Python 3.11.4: the sizes are stored twice */
  EXTRA_ZIP64_ONLY,   /* as numpy.savez since then: the sizes are in the record alone */
  EXTRA_ZIP64_WRONG,  /* a size that differs from the directory's */
  EXTRA_PADDING_ONES, /* padding that is not zero */
  EXTRA_PADDING_LONG, /* padding whose length exceeds the field */
  EXTRA_UNKNOWN       /* a time stamp, as zip(1) writes it */
} archive_extra;

/* One member of the archive. `version` is the version of its .npy format, 1 for 1.0. */
typedef struct archive_part {
  const char *name;       /* the member's, with .npy */
  const char *local_name; /* NULL: the same as name */
  const char *type, *order, *shape;
  const char *header; /* NULL: made from type, order and shape */
  int version;
  unsigned char data[ARCHIVE_DATA];
  size_t size;
  archive_extra extra;
  unsigned flags, local_flags, method, local_method;
  unsigned central_extra, central_comment, disk;
  uint32_t crc_change, local_crc_change, size_change, local_size_change, offset_change;
  size_t gap; /* stray bytes before the local record */
} archive_part;

typedef struct archive {
  archive_part parts[ARCHIVE_PARTS];
  int count;
  const char *comment; /* NULL: none */
  size_t gap;          /* stray bytes between the members and the directory */
  size_t stray;        /* stray bytes behind the directory, counted in its size */
  unsigned count_change, disk;
} archive;

/* The model has rank 2, five vertices, two tetrahedra in two regions, and two groups. */
#define SAMPLE_META "{\"note\": \"\xC3\xA9\"}"
#define SAMPLE_NAMES "left\0right side"
static const int32_t sample_format[2] = {1, 0};
static const double sample_omega2[2] = {39.47841760435743, 157.91367041742973};
static const double sample_c3[4] = {1.5, -2.25, 1e-300, 3.0e10};
static const double sample_c4[5] = {0.1, 0.2, -0.0, 4.9e-324, 1.7976931348623157e308};
static const double sample_axis_mass[6] = {0.5, 0.25, -1, 2, 0.125, 1.0 / 3.0};
static const double sample_vertices[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
static const int32_t sample_tets[8] = {0, 1, 2, 3, 1, 2, 3, 4};
static const int32_t sample_tet_region[2] = {0, 1};
static const double sample_material[6] = {5e6, 0.4, 1000, 1e9, -0.5, 7800};
static const uint8_t sample_fixed[5] = {7, 0, 5, 0, 0};
static const double sample_basis[30] = {0, 0, 0, 0,  0,  0,  1,  2,  3,  4, 5, 6, 0, 0, 7,
                                        8, 0, 0, .1, .2, .3, .4, .5, .6, 9, 8, 7, 6, 5, 4};
static const int32_t sample_group_ends[2] = {2, 5};
static const int32_t sample_group_vertices[5] = {0, 2, 1, 3, 4};

static inline thrum_model sample_model(void) {
  // sizes
  thrum_model m = {0};
  m.rank = 2;
  m.c3_count = 4;
  m.c4_count = 5;
  m.vertex_count = 5;
  m.tet_count = 2;
  m.region_count = 2;
  m.group_count = 2;
  m.group_name_bytes = sizeof SAMPLE_NAMES;
  m.group_vertex_count = 5;
  m.meta_bytes = sizeof SAMPLE_META - 1;

  // arrays
  m.format = sample_format;
  m.meta = (const uint8_t *)SAMPLE_META;
  m.omega2 = sample_omega2;
  m.c3 = sample_c3;
  m.c4 = sample_c4;
  m.axis_mass = sample_axis_mass;
  m.vertices = sample_vertices;
  m.tets = sample_tets;
  m.tet_region = sample_tet_region;
  m.material = sample_material;
  m.fixed = sample_fixed;
  m.basis = sample_basis;
  m.group_names = (const uint8_t *)SAMPLE_NAMES;
  m.group_ends = sample_group_ends;
  m.group_vertices = sample_group_vertices;
  return m;
}

/* A polynomial alone, the smallest model. */
static inline thrum_model sample_polynomial(void) {
  thrum_model all = sample_model(), m = {0};
  m.rank = all.rank;
  m.c3_count = all.c3_count;
  m.c4_count = all.c4_count;
  m.format = all.format;
  m.omega2 = all.omega2;
  m.c3 = all.c3;
  m.c4 = all.c4;
  return m;
}

static inline archive_part *archive_add(archive *a, const char *name, const char *type,
                                        const char *shape, const void *data, size_t size) {
  if (a->count == ARCHIVE_PARTS || size > ARCHIVE_DATA)
    abort();
  archive_part *part = &a->parts[a->count++];
  memset(part, 0, sizeof *part);
  part->name = name;
  part->type = type;
  part->order = "False";
  part->shape = shape;
  part->version = 1;
  part->size = size;
  part->extra = EXTRA_PADDING;
  memcpy(part->data, data, size);
  return part;
}

/* The sample model as a valid file. */
static inline archive archive_sample(void) {
  archive a = {.count = 0};

  // format and description
  archive_add(&a, "format.npy", "<i4", "(2,)", sample_format, sizeof sample_format);
  archive_add(&a, "meta.npy", "|u1", "(14,)", SAMPLE_META, sizeof SAMPLE_META - 1);

  // the polynomial
  archive_add(&a, "omega2.npy", "<f8", "(2,)", sample_omega2, sizeof sample_omega2);
  archive_add(&a, "c3.npy", "<f8", "(4,)", sample_c3, sizeof sample_c3);
  archive_add(&a, "c4.npy", "<f8", "(5,)", sample_c4, sizeof sample_c4);
  archive_add(&a, "axis_mass.npy", "<f8", "(3, 2)", sample_axis_mass, sizeof sample_axis_mass);

  // the mesh
  archive_add(&a, "vertices.npy", "<f8", "(5, 3)", sample_vertices, sizeof sample_vertices);
  archive_add(&a, "tets.npy", "<i4", "(2, 4)", sample_tets, sizeof sample_tets);
  archive_add(&a, "tet_region.npy", "<i4", "(2,)", sample_tet_region, sizeof sample_tet_region);
  archive_add(&a, "material.npy", "<f8", "(2, 3)", sample_material, sizeof sample_material);
  archive_add(&a, "fixed.npy", "|u1", "(5,)", sample_fixed, sizeof sample_fixed);
  archive_add(&a, "basis.npy", "<f8", "(15, 2)", sample_basis, sizeof sample_basis);

  // the groups
  archive_add(&a, "group_names.npy", "|u1", "(16,)", SAMPLE_NAMES, sizeof SAMPLE_NAMES);
  archive_add(&a, "group_ends.npy", "<i4", "(2,)", sample_group_ends, sizeof sample_group_ends);
  archive_add(&a, "group_vertices.npy", "<i4", "(5,)", sample_group_vertices,
              sizeof sample_group_vertices);
  return a;
}

static inline archive_part *archive_find(archive *a, const char *array) {
  char name[64];
  snprintf(name, sizeof name, "%s.npy", array);
  for (int i = 0; i < a->count; i++)
    if (strcmp(a->parts[i].name, name) == 0)
      return &a->parts[i];
  abort();
}

static inline void archive_remove(archive *a, const char *array) {
  archive_part *part = archive_find(a, array);
  int index = (int)(part - a->parts);
  memmove(part, part + 1, (size_t)(a->count - index - 1) * sizeof *part);
  a->count--;
}

static inline void archive_set_f8(archive *a, const char *array, int entry, double value) {
  memcpy(archive_find(a, array)->data + 8 * entry, &value, 8);
}

static inline void archive_set_i4(archive *a, const char *array, int entry, int32_t value) {
  memcpy(archive_find(a, array)->data + 4 * entry, &value, 4);
}

static inline void archive_set_extra(archive *a, archive_extra extra) {
  for (int i = 0; i < a->count; i++)
    a->parts[i].extra = extra;
}

/* CRC-32 bit by bit, straight from its definition. */
static inline uint32_t archive_crc(const unsigned char *data, size_t size) {
  uint32_t r = 0xFFFFFFFFu;
  for (size_t i = 0; i < size; i++) {
    r ^= data[i];
    for (int bit = 0; bit < 8; bit++)
      r = (r >> 1) ^ ((r & 1u) != 0 ? 0xEDB88320u : 0u);
  }
  return ~r;
}

static inline void archive_put(unsigned char *p, int bytes, uint64_t value) {
  for (int i = 0; i < bytes; i++)
    p[i] = (unsigned char)(value >> (8 * i) & 0xFFu);
}

/* Writes the .npy bytes of a part and returns their number. */
static inline size_t archive_npy(const archive_part *part, unsigned char *out) {
  // the header as given, or made from the part's type, order and shape
  char text[192];
  int n = part->header != NULL
              ? snprintf(text, sizeof text, "%s", part->header)
              : snprintf(text, sizeof text, "{'descr': '%s', 'fortran_order': %s, 'shape': %s, }",
                         part->type, part->order, part->shape);

  // magic, version and length; blanks pad the header to a multiple of 64 and a line feed ends it
  size_t total = (10 + (size_t)n + 1 + 63) / 64 * 64;
  memset(out, ' ', total);
  memcpy(out, "\x93NUMPY", 6);
  out[6] = (unsigned char)part->version;
  out[7] = 0;
  archive_put(out + 8, 2, total - 10);
  memcpy(out + 10, text, (size_t)n);
  out[total - 1] = '\n';

  memcpy(out + total, part->data, part->size);
  return total + part->size;
}

/* The local extra field that would begin at offset `at`; returns its length. */
static inline size_t archive_extra_field(archive_extra extra, size_t at, uint32_t size,
                                         unsigned char *out) {
  size_t padding = (64 - at % 64) % 64;
  padding += padding < 4 ? 64 : 0;
  memset(out, 0, 80);

  // what other programs write is 0xD935 for padding, 1 for sizes beyond 32 bits
  switch (extra) {
  case EXTRA_NONE:
    return 0;
  case EXTRA_PADDING:
  case EXTRA_PADDING_ONES:
  case EXTRA_PADDING_LONG:
    if (extra == EXTRA_PADDING_ONES && padding == 4)
      padding += 64;
    archive_put(out, 2, 0xD935);
    archive_put(out + 2, 2, padding - 4 + (extra == EXTRA_PADDING_LONG));
    if (extra == EXTRA_PADDING_ONES)
      out[padding - 1] = 1;
    return padding;
  case EXTRA_ZIP64:
  case EXTRA_ZIP64_ONLY:
  case EXTRA_ZIP64_WRONG:
    archive_put(out, 2, 1);
    archive_put(out + 2, 2, 16);
    archive_put(out + 4, 8, size);
    archive_put(out + 12, 8, size + (extra == EXTRA_ZIP64_WRONG));
    return 20;
  case EXTRA_UNKNOWN:
    archive_put(out, 2, 0x5455);
    archive_put(out + 2, 2, 5);
    return 9;
  }
  return 0;
}

/* Writes one local record and its data at `at`, and the central record; returns the end. */
static inline size_t archive_member(const archive_part *part, unsigned char *file, size_t at,
                                    unsigned char *central, size_t *central_size) {
  unsigned char npy[ARCHIVE_DATA + 256], extra[80];
  at += part->gap;
  const char *local_name = part->local_name != NULL ? part->local_name : part->name;
  size_t local_size = strlen(local_name), name_size = strlen(part->name);
  uint32_t size = (uint32_t)archive_npy(part, npy), crc = archive_crc(npy, size);
  size_t extra_size = archive_extra_field(part->extra, at + 30 + local_size, size, extra);

  // the local record, with what the case has wrong
  unsigned char *local = file + at;
  memset(local, 0, 30);
  memcpy(local, "PK\3\4\24", 5);
  archive_put(local + 6, 2, part->flags ^ part->local_flags);
  archive_put(local + 8, 2, part->method ^ part->local_method);
  archive_put(local + 12, 2, 0x21);
  archive_put(local + 14, 4, crc ^ part->crc_change ^ part->local_crc_change);
  uint32_t said = part->extra == EXTRA_ZIP64_ONLY ? 0xFFFFFFFFu : size + part->local_size_change;
  archive_put(local + 18, 4, said);
  archive_put(local + 22, 4, said);
  archive_put(local + 26, 2, local_size);
  archive_put(local + 28, 2, extra_size);

  // the name, the padding and the data follow the header
  memcpy(local + 30, local_name, local_size);
  memcpy(local + 30 + local_size, extra, extra_size);
  memcpy(local + 30 + local_size + extra_size, npy, size);

  // the central record says the same but for what the case has wrong
  memset(central, 0, 46);
  memcpy(central, "PK\1\2\24\0\24", 7);
  archive_put(central + 8, 2, part->flags);
  archive_put(central + 10, 2, part->method);
  archive_put(central + 14, 2, 0x21);
  archive_put(central + 16, 4, crc ^ part->crc_change);
  archive_put(central + 20, 4, size);
  archive_put(central + 24, 4, size + part->size_change);
  archive_put(central + 28, 2, name_size);
  archive_put(central + 30, 2, part->central_extra);
  archive_put(central + 32, 2, part->central_comment);
  archive_put(central + 34, 2, part->disk);
  archive_put(central + 42, 4, at + part->offset_change);
  memcpy(central + 46, part->name, name_size);
  memset(central + 46 + name_size, 0, part->central_extra + part->central_comment);
  *central_size = 46 + name_size + part->central_extra + part->central_comment;
  return at + 30 + local_size + extra_size + size;
}

/* Writes the archive to `file`, ARCHIVE_MAX bytes; returns its size. */
static inline size_t archive_build(const archive *a, unsigned char *file) {
  unsigned char directory[4096];

  // the members, and their directory entries in a buffer
  size_t at = 0, used = 0;
  memset(file, 0, ARCHIVE_MAX);
  for (int i = 0; i < a->count; i++) {
    size_t central_size = 0;
    at = archive_member(&a->parts[i], file, at, directory + used, &central_size);
    used += central_size;
  }

  // the directory behind them, with stray bytes where the test wants them
  at += a->gap;
  memcpy(file + at, directory, used);
  used += a->stray;

  // the end record, whose numbers the test may falsify
  unsigned char *end = file + at + used;
  memcpy(end, "PK\5\6", 4);
  archive_put(end + 4, 2, a->disk);
  archive_put(end + 8, 2, (uint64_t)a->count + a->count_change);
  archive_put(end + 10, 2, (uint64_t)a->count + a->count_change);
  archive_put(end + 12, 4, used);
  archive_put(end + 16, 4, at);
  size_t comment = a->comment != NULL ? strlen(a->comment) : 0;
  archive_put(end + 20, 2, comment);
  if (comment > 0)
    memcpy(end + 22, a->comment, comment);

  return at + used + 22 + comment;
}

/* Whether two models hold the same bits, array by array. */
static inline int models_bit_equal(const thrum_model *a, const thrum_model *b) {
  // the sizes are local names too, since the table of the arrays refers to them
  const int64_t basis_rows = 3 * a->vertex_count;
  const int64_t point_rows = 9 * a->point_count, modulus_rows = 2 * a->region_count;
  const int64_t guide_axes = 3 * a->guide_count;
#define X(name, meaning)                                                                           \
  const int64_t name = a->name;                                                                    \
  if (name != b->name)                                                                             \
    return 0;
  THRUM_MODEL_SIZES(X)
#undef X

#define X(type, name, rows, columns, presence, meaning)                                            \
  if ((a->name == NULL) != (b->name == NULL))                                                      \
    return 0;                                                                                      \
  if (a->name != NULL &&                                                                           \
      memcmp(a->name, b->name, (size_t)(rows) * (size_t)(columns) * sizeof *a->name) != 0)         \
    return 0;
  THRUM_MODEL_ARRAYS(X)
#undef X

  return 1;
}

#endif
