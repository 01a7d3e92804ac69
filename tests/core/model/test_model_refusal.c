/* Tests of refused model files, with one thing wrong at a time: each is refused with its status and
 * a message that names the array and the remedy. See docs/model_format.md.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "io/npz.h"
#include "tests/support/model_archive.h"

static _Alignas(64) unsigned char file_bytes[ARCHIVE_MAX];
static _Alignas(64) unsigned char memory[ARCHIVE_MAX];

// the three readers refuse alike, with `words` in the message, and leave their outputs as they were
static void check_bytes(size_t size, thrum_status status, const char *words) {
  // a view is refused with its message of one line
  thrum_error error = {.status = THRUM_OK};
  thrum_model view, before;
  memset(&view, 0x5A, sizeof view);
  memset(&before, 0x5A, sizeof before);
  thrum_status got = thrum_model_view(file_bytes, size, &view, &error);
  if (got != status || strstr(error.message, words) == NULL)
    fail_msg("wanted %d '%s', got %d '%s'", status, words, got, error.message);
  assert_int_equal(error.status, status);
  assert_null(strchr(error.message, '\n'));
  assert_memory_equal(&view, &before, sizeof view);

  // neither the size nor the memory for a copy is written
  size_t needed = 77;
  assert_int_equal(thrum_model_size(file_bytes, size, &needed, NULL), status);
  assert_int_equal(needed, 77);
  const thrum_model *model = NULL;
  memset(memory, 0, sizeof memory);
  assert_int_equal(thrum_model_init(memory, sizeof memory, file_bytes, size, &model, NULL), status);
  assert_null(model);
  for (size_t i = 0; i < sizeof memory; i++)
    assert_int_equal(memory[i], 0);
}

static void refused(const archive *a, thrum_status status, const char *words) {
  check_bytes(archive_build(a, file_bytes), status, words);
}

static void accepted(const archive *a) {
  thrum_error error = {.status = THRUM_OK};
  const thrum_model *model = NULL;
  thrum_model sample = sample_model();
  size_t size = archive_build(a, file_bytes);
  if (thrum_model_init(memory, sizeof memory, file_bytes, size, &model, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_true(models_bit_equal(model, &sample));
}

static void bytes_that_are_no_archive_are_refused_as_such(void **state) {
  (void)state;
  check_bytes(0, THRUM_BAD_FORMAT, "not a model file");
  memset(file_bytes, 'x', 100);
  check_bytes(100, THRUM_BAD_FORMAT, "not a model file");
  memcpy(file_bytes, "\x93NUMPY\1\0", 8);
  check_bytes(100, THRUM_BAD_FORMAT, "single .npy");
  archive a = archive_sample();
  size_t size = archive_build(&a, file_bytes);
  check_bytes(size - 1, THRUM_BAD_FORMAT, "cut short");
  a.count = 0;
  refused(&a, THRUM_MISSING, "no Thrum model: array 'format' is missing");
}

static void archives_of_other_kinds_are_refused(void **state) {
  (void)state;

  // a comment of the archive, also one that looks like an end record
  archive a = archive_sample();
  a.comment = "made by hand";
  refused(&a, THRUM_BAD_FORMAT, "zip comment");
  // a comment that ends like an end record is still found
  char comment[23] = "PK\5\6";
  memset(comment + 4, 1, 18);
  a.comment = comment;
  refused(&a, THRUM_BAD_FORMAT, "comment");

  // an archive over several disks
  a = archive_sample();
  a.disk = 1;
  refused(&a, THRUM_UNSUPPORTED, "more than one disk");

  // counts of members that the directory does not hold
  a = archive_sample();
  a.count_change = 1;
  refused(&a, THRUM_BAD_FORMAT, "directory is damaged at member 16");
  a.count_change = (unsigned)-1;
  refused(&a, THRUM_BAD_FORMAT, "belong to no member stand in the zip directory");
  a.count_change = 5000;
  refused(&a, THRUM_UNSUPPORTED, "more than the 4096");
  a.count_change = 0xFFFFu - 15u;
  refused(&a, THRUM_UNSUPPORTED, "zip64");

  // an end record that refers to zip64, or to another end of the directory
  a = archive_sample();
  size_t size = archive_build(&a, file_bytes);
  memset(file_bytes + size - 6, 0xFF, 4);
  check_bytes(size, THRUM_UNSUPPORTED, "zip64");
  archive_build(&a, file_bytes);
  file_bytes[size - 6]++;
  check_bytes(size, THRUM_BAD_FORMAT, "does not end where the end record begins");
}

static void compressed_and_piped_members_are_refused_with_the_reason(void **state) {
  (void)state;
  archive a = archive_sample();
  archive_find(&a, "c3")->method = 8;
  refused(&a, THRUM_UNSUPPORTED, "'c3.npy' is compressed: use numpy.savez");
  a = archive_sample();
  archive_find(&a, "c4")->flags = 8;
  refused(&a, THRUM_UNSUPPORTED, "'c4.npy' has its sizes behind its data");
  archive_find(&a, "c4")->flags = 1;
  refused(&a, THRUM_UNSUPPORTED, "'c4.npy' is encrypted");
  archive_find(&a, "c4")->flags = 0x800;
  refused(&a, THRUM_UNSUPPORTED, "'c4.npy' has zip flags 0x0800");
}

static void members_tile_the_file_without_gap_or_overlap(void **state) {
  (void)state;

  // a gap before a member, behind the first byte or before it
  archive a = archive_sample();
  archive_find(&a, "tets")->gap = 1;
  refused(&a, THRUM_BAD_FORMAT, "'tets.npy' is said to begin at byte");
  a = archive_sample();
  archive_find(&a, "format")->gap = 64;
  refused(&a, THRUM_BAD_FORMAT, "'format.npy' is said to begin at byte 64, where 0 is right");

  // a member whose offset points elsewhere
  a = archive_sample();
  archive_find(&a, "tets")->offset_change = (uint32_t)-1;
  refused(&a, THRUM_BAD_FORMAT, "'tets.npy' is said to begin at byte");

  // bytes before the directory and in it
  a = archive_sample();
  a.gap = 3;
  refused(&a, THRUM_BAD_FORMAT, "belong to no member stand before the zip directory");
  a = archive_sample();
  a.stray = 3;
  refused(&a, THRUM_BAD_FORMAT, "belong to no member stand in the zip directory");
}

static void local_and_central_records_must_agree(void **state) {
  (void)state;

  // each field of the local record is changed alone; the whole record is restored in between
  static const char words[] = "'basis.npy': its local record and the zip directory disagree";
  archive a = archive_sample();
  archive_part *basis = archive_find(&a, "basis"), good = *basis;

  // names
  basis->local_name = "basit.npy";
  refused(&a, THRUM_BAD_FORMAT, words);
  basis->local_name = "base.npy";
  refused(&a, THRUM_BAD_FORMAT, words);

  // checksum and size
  *basis = good;
  basis->local_crc_change = 1;
  refused(&a, THRUM_BAD_FORMAT, words);
  *basis = good;
  basis->local_size_change = 1;
  refused(&a, THRUM_BAD_FORMAT, words);

  // flags, method and the size of the stored data
  *basis = good;
  basis->local_flags = 0x800;
  refused(&a, THRUM_BAD_FORMAT, words);
  *basis = good;
  basis->local_method = 8;
  refused(&a, THRUM_BAD_FORMAT, words);
  *basis = good;
  basis->size_change = 1;
  refused(&a, THRUM_BAD_FORMAT, "'basis.npy' is stored, yet its two sizes differ");

  // sizes of 0xFFFFFFFF have a meaning only where the zip64 record behind the name holds them
  *basis = good;
  size_t size = archive_build(&a, file_bytes);
  memset(file_bytes + 18, 0xFF, 8);
  check_bytes(size, THRUM_BAD_FORMAT, "'format.npy': its local record");
}

static void extra_fields_are_padding_or_those_of_numpy(void **state) {
  (void)state;

  // the extra fields that NumPy writes, and padding
  archive a = archive_sample();
  const archive_extra good[] = {EXTRA_NONE, EXTRA_PADDING, EXTRA_ZIP64, EXTRA_ZIP64_ONLY};
  for (int i = 0; i < 4; i++) {
    archive_set_extra(&a, good[i]);
    accepted(&a);
  }

  // any other extra field of the local record
  const archive_extra bad[] = {EXTRA_ZIP64_WRONG, EXTRA_PADDING_ONES, EXTRA_PADDING_LONG,
                               EXTRA_UNKNOWN};
  for (int i = 0; i < 4; i++) {
    a = archive_sample();
    archive_find(&a, "omega2")->extra = bad[i];
    refused(&a, THRUM_BAD_FORMAT, "'omega2.npy' has an extra field");
  }

  // the central record has no extra field, no comment and no other disk
  a = archive_sample();
  archive_find(&a, "omega2")->central_extra = 4;
  refused(&a, THRUM_UNSUPPORTED, "'omega2.npy' has an extra field, a comment");
  a = archive_sample();
  archive_find(&a, "omega2")->central_comment = 1;
  refused(&a, THRUM_UNSUPPORTED, "'omega2.npy' has an extra field, a comment");
  a = archive_sample();
  archive_find(&a, "omega2")->disk = 1;
  refused(&a, THRUM_UNSUPPORTED, "'omega2.npy' has an extra field, a comment");
}

static void a_wrong_checksum_is_refused_of_unknown_members_too(void **state) {
  (void)state;
  archive a = archive_sample();
  archive_find(&a, "fixed")->crc_change = 0x80000000u;
  refused(&a, THRUM_BAD_CHECKSUM, "'fixed.npy' does not match its CRC-32");
  a = archive_sample();
  archive_part *extra = archive_add(&a, "my_notes.npy", "<c16", "(1, 1)", "0123456789abcdef", 16);
  accepted(&a);
  extra->crc_change = 1;
  refused(&a, THRUM_BAD_CHECKSUM, "'my_notes.npy' does not match its CRC-32");
}

static void names_are_plain_and_unique(void **state) {
  (void)state;

  // a name that comes twice, known or unknown
  archive a = archive_sample();
  archive_add(&a, "c3.npy", "<f8", "(4,)", sample_c3, sizeof sample_c3);
  refused(&a, THRUM_BAD_FORMAT, "'c3.npy' is there twice");
  a = archive_sample();
  archive_add(&a, "notes.npy", "<i4", "(1,)", "abcd", 4);
  archive_add(&a, "notes.npy", "<i4", "(1,)", "abcd", 4);
  refused(&a, THRUM_BAD_FORMAT, "'notes.npy' is there twice");

  // characters, suffixes and folders that a member's name cannot have
  static const char *const bad[] = {"C3.npy", "_c.npy",  "3c.npy",       ".npy",
                                    "c3",     "c3.npY",  "folder/c.npy", "../c.npy",
                                    "c-.npy", "c\n.npy", "c3.npy.npz",   "caf\xC3\xA9.npy",
                                    ""};
  for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
    a = archive_sample();
    archive_add(&a, bad[i], "<i4", "(1,)", "abcd", 4);
    refused(&a, THRUM_BAD_FORMAT, "names are lower-case letters");
  }

  // a long name of an unknown member is no error
  a = archive_sample();
  archive_add(&a, "a_name_that_is_longer_than_a_message_has_room_for_0123456789.npy", "<i4", "(1,)",
              "abcd", 4);
  accepted(&a);
}

static void required_arrays_and_their_companions_must_be_there(void **state) {
  (void)state;
  static const char *const required[] = {"format", "omega2", "c3", "c4"};
  static const char *const mesh[] = {"vertices", "tets", "tet_region", "material", "fixed"};
  static const char *const groups[] = {"group_names", "group_ends", "group_vertices"};

  // each array that the sample needs, removed alone
  char words[80];
  for (int i = 0; i < 12; i++) {
    archive a = archive_sample();
    const char *name = i < 4 ? required[i] : i < 9 ? mesh[i - 4] : groups[i - 9];
    archive_remove(&a, name);
    snprintf(words, sizeof words, "array '%s' is missing%s", name, i < 4 ? "" : ": ");
    refused(&a, THRUM_MISSING, words);
  }

  // arrays that need a mesh, without one
  archive a = archive_sample();
  for (int i = 0; i < 5; i++)
    archive_remove(&a, mesh[i]);
  refused(&a, THRUM_MISSING, "array 'vertices' is missing: 'basis' needs a mesh");
  archive_remove(&a, "basis");
  refused(&a, THRUM_MISSING, "array 'vertices' is missing: 'group_ends' needs a mesh");
}

static void another_version_of_the_format_speaks_first(void **state) {
  (void)state;

  // a file of another major version is refused for that, whatever else it lacks
  archive a = archive_sample();
  archive_set_i4(&a, "format", 0, 6);
  archive_remove(&a, "c4");
  archive_find(&a, "omega2")->type = "<f4";
  refused(&a, THRUM_UNSUPPORTED,
          "array 'format' says version 6.0, this program reads versions 1 to 5");

  // a negative minor version is not one of this format
  a = archive_sample();
  archive_set_i4(&a, "format", 1, -1);
  refused(&a, THRUM_BAD_VALUE, "array 'format'");

  // a minor version only adds arrays
  archive_set_i4(&a, "format", 1, 7);
  size_t size = archive_build(&a, file_bytes);
  thrum_model view;
  assert_int_equal(thrum_model_view(file_bytes, size, &view, NULL), THRUM_OK);
  assert_int_equal(view.format[1], 7);
}

static void middle_nodes_need_the_version_that_older_readers_refuse(void **state) {
  (void)state;
  static const int32_t midsides[12] = {0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1};
  static const int32_t wrong[12] = {0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 5, 1};
  thrum_model view;

  // a reader of version 1 would not know the array, and take the tetrahedra for linear ones
  archive a = archive_sample();
  archive_add(&a, "midsides.npy", "<i4", "(2, 6)", midsides, sizeof midsides);
  refused(&a, THRUM_BAD_VALUE, "a model with 'midsides' has version 2");
  archive_set_i4(&a, "format", 0, 2);
  assert_int_equal(thrum_model_view(file_bytes, archive_build(&a, file_bytes), &view, NULL),
                   THRUM_OK);
  assert_memory_equal(view.midsides, midsides, sizeof midsides);

  // its shape and its indices are checked as those of any array
  a = archive_sample();
  archive_set_i4(&a, "format", 0, 2);
  archive_add(&a, "midsides.npy", "<i4", "(2, 6)", wrong, sizeof wrong);
  refused(&a, THRUM_BAD_VALUE, "array 'midsides' holds the index 5 (entry 10)");
  a = archive_sample();
  archive_set_i4(&a, "format", 0, 2);
  archive_add(&a, "midsides.npy", "<i4", "(3, 4)", midsides, sizeof midsides);
  refused(&a, THRUM_BAD_SHAPE, "array 'midsides' has shape (3, 4)");
}

/* A sample of two tetrahedra that are solids. */
static archive solid_sample(const uint8_t form[2], const int32_t ends[2],
                            const int32_t tet_ends[2]) {
  static const int32_t nodes[8] = {0, 1, 2, 3, 1, 2, 3, 4};
  archive a = archive_sample();
  archive_set_i4(&a, "format", 0, THRUM_MODEL_FORMAT_MAJOR_SOLIDS);
  archive_add(&a, "solid_form.npy", "|u1", "(2,)", form, 2);
  archive_add(&a, "solid_ends.npy", "<i4", "(2,)", ends, 2 * sizeof *ends);
  archive_add(&a, "solid_nodes.npy", "<i4", "(8,)", nodes, sizeof nodes);
  archive_add(&a, "solid_tet_ends.npy", "<i4", "(2,)", tet_ends, 2 * sizeof *tet_ends);
  return a;
}

static void solids_have_the_nodes_of_their_form_and_tetrahedra_of_their_own(void **state) {
  (void)state;
  static const uint8_t form[2] = {0, 0}, wedge[2] = {0, 2}, unknown[2] = {0, 9};
  static const int32_t ends[2] = {4, 8}, tets[2] = {1, 2}, none[2] = {0, 2}, few[2] = {1, 1};
  static const int32_t midsides[12] = {0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1};
  thrum_model view;
  archive a = solid_sample(form, ends, tets);
  assert_int_equal(thrum_model_view(file_bytes, archive_build(&a, file_bytes), &view, NULL),
                   THRUM_OK);
  assert_int_equal(view.solid_count, 2);

  // older readers must refuse them, and they are whole or not there
  archive_set_i4(&a, "format", 0, 4);
  refused(&a, THRUM_BAD_VALUE, "a model with 'solid_form' has version 5");
  a = solid_sample(form, ends, tets);
  archive_remove(&a, "solid_ends");
  refused(&a, THRUM_MISSING, "array 'solid_ends' is missing");
  a = solid_sample(form, ends, tets);
  archive_add(&a, "midsides.npy", "<i4", "(2, 6)", midsides, sizeof midsides);
  refused(&a, THRUM_BAD_SHAPE, "array 'midsides' does not go with solid_form");

  // forms, runs of nodes and runs of tetrahedra
  a = solid_sample(unknown, ends, tets);
  refused(&a, THRUM_BAD_VALUE, "array 'solid_form' holds 9 (entry 1)");
  a = solid_sample(wedge, ends, tets);
  refused(&a, THRUM_BAD_VALUE, "array 'solid_ends' holds 8 (entry 1); 10 is needed");
  a = solid_sample(form, ends, none);
  refused(&a, THRUM_BAD_VALUE, "array 'solid_tet_ends' holds 0 (entry 0)");
  a = solid_sample(form, ends, few);
  refused(&a, THRUM_BAD_VALUE, "array 'solid_tet_ends' holds 1 (entry 1)");
}

static void types_and_orders_are_those_of_the_list(void **state) {
  (void)state;

  // other types and other orders of a matrix
  archive a = archive_sample();
  archive_part *vertices = archive_find(&a, "vertices"), good = *vertices;
  vertices->type = ">f8";
  refused(&a, THRUM_BAD_SHAPE, "array 'vertices' has type '>f8', '<f8' is needed");
  vertices->type = "<f4";
  refused(&a, THRUM_BAD_SHAPE, "array 'vertices' has type '<f4', '<f8' is needed");
  vertices->type = "|O";
  refused(&a, THRUM_BAD_SHAPE, "array 'vertices' has type '|O'");
  *vertices = good;
  vertices->order = "True";
  refused(&a, THRUM_BAD_SHAPE, "array 'vertices' is in Fortran order");

  // a vector has the same layout in both orders
  a = archive_sample();
  archive_find(&a, "c3")->order = "True";
  accepted(&a);

  // the integer arrays, and a later version of the header
  a = archive_sample();
  archive_find(&a, "tets")->type = "<i8";
  refused(&a, THRUM_BAD_SHAPE, "array 'tets' has type '<i8', '<i4' is needed");
  archive_find(&a, "tets")->version = 2;
  refused(&a, THRUM_UNSUPPORTED, "array 'tets': .npy format 2.0");
}

static void shapes_are_those_of_the_list(void **state) {
  (void)state;

  // each case replaces the shape and the size of one array
  static const struct {
    const char *array, *shape;
    size_t size;
    thrum_status status;
    const char *words;
  } cases[] = {
      {"format", "(1,)", 4, THRUM_BAD_SHAPE, "'format' has shape (1,), (2,) is needed"},
      {"format", "(1, 2)", 8, THRUM_BAD_SHAPE, "'format' has shape (1, 2), (2,) is needed"},
      {"omega2", "()", 8, THRUM_BAD_SHAPE, "'omega2' has shape (), (rank,) is needed"},
      {"omega2", "(0,)", 0, THRUM_BAD_SHAPE, "is needed with rank = 0"},
      {"omega2", "(1,)", 8, THRUM_BAD_SHAPE,
       "'axis_mass' has shape (3, 2), (3, rank) is needed with rank = 1"},
      {"c3", "(3,)", 24, THRUM_BAD_SHAPE, "'c3' has 3 entries; rank 2 has 4"},
      {"c4", "(6,)", 48, THRUM_BAD_SHAPE, "'c4' has 6 entries; rank 2 has 5"},
      {"c4", "(5, 1)", 40, THRUM_BAD_SHAPE, "'c4' has shape (5, 1), (c4_count,) is needed"},
      {"axis_mass", "(2, 3)", 48, THRUM_BAD_SHAPE, "'axis_mass' has shape (2, 3), (3, rank)"},
      {"vertices", "(3, 5)", 120, THRUM_BAD_SHAPE,
       "'vertices' has shape (3, 5), (vertex_count, 3)"},
      {"vertices", "(0, 3)", 0, THRUM_BAD_SHAPE, "'fixed' has shape (5,), (vertex_count,)"},
      {"tets", "(1, 2, 4)", 32, THRUM_BAD_SHAPE, "'tets' has shape (1, 2, 4), (tet_count, 4)"},
      {"tet_region", "(1,)", 4, THRUM_BAD_SHAPE,
       "'tet_region' has shape (1,), (tet_count,) is needed with tet_count = 2"},
      {"material", "(0, 3)", 0, THRUM_BAD_SHAPE, "'material' has 0 rows"},
      {"fixed", "(4,)", 4, THRUM_BAD_SHAPE, "'fixed' has shape (4,), (vertex_count,) is needed"},
      {"basis", "(5, 6)", 240, THRUM_BAD_SHAPE,
       "(basis_rows, rank) is needed with basis_rows = 15"},
      {"c3", "(4,)", 31, THRUM_BAD_FORMAT, "'c3' has shape (4,) of '<f8', which its 31 bytes"},
      {"c3", "(4,)", 33, THRUM_BAD_FORMAT, "'c3' has shape (4,) of '<f8', which its 33 bytes"},
      {"c3", "(2305843009213693956,)", 32, THRUM_BAD_FORMAT, "'c3' has shape (23058430092136939"},
      {"c3", "(4294967297, 4294967296, 4)", 32, THRUM_BAD_FORMAT, "'c3' has shape (4294967297"},
      {"c3", "(99999999999999999999,)", 32, THRUM_BAD_FORMAT, "array 'c3': its .npy header"},
      {"c3", "(1, 1, 1, 1, 1, 1, 1, 1, 4)", 32, THRUM_BAD_FORMAT, "array 'c3': its .npy header"},
      {"c3", "(-4,)", 32, THRUM_BAD_FORMAT, "array 'c3': its .npy header"},
      {"c3", "(4)", 32, THRUM_BAD_FORMAT, "array 'c3': its .npy header"},
      {"c3", "4", 32, THRUM_BAD_FORMAT, "array 'c3': its .npy header"},
  };

  // the sample has one array replaced at a time
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    archive a = archive_sample();
    archive_part *part = archive_find(&a, cases[i].array);
    part->shape = cases[i].shape;
    part->size = cases[i].size;
    refused(&a, cases[i].status, cases[i].words);
  }
}

static void the_rank_is_1_to_512(void **state) {
  (void)state;
  archive a = archive_sample();
  // the arrays of the polynomial alone, which come first
  a.count = 5;
  archive_find(&a, "omega2")->shape = "(0,)";
  archive_find(&a, "omega2")->size = 0;
  refused(&a, THRUM_BAD_SHAPE, "array 'omega2' has 0 entries; a rank is 1 to 512");
  archive_find(&a, "omega2")->shape = "(1,)";
  archive_find(&a, "omega2")->size = 8;
  refused(&a, THRUM_BAD_SHAPE, "array 'c3' has 4 entries; rank 1 has 1");
}

static void headers_are_plain_dictionaries(void **state) {
  (void)state;

  // keys in any order and spacing
  static const char *const good[] = {
      "{'shape': (4,), 'fortran_order': False, 'descr': '<f8'}",
      "{ \"descr\" :\t\"<f8\" ,\n'fortran_order':False,'shape':( 4 , ) }",
  };

  // dictionaries that are incomplete, malformed or hold more
  static const char *const bad[] = {
      "",
      "{}",
      "{'descr': '<f8', 'fortran_order': False, 'shape': (4,)",
      "{'descr': '<f8', 'fortran_order': False, 'shape': (4,)} x",
      "{'descr': '<f8', 'fortran_order': False}",
      "{'descr': '<f8', 'fortran_order': False, 'shape': (4,), 'shape': (4,)}",
      "{'descr': '<f8', 'fortran_order': False, 'shape': (4,), 'more': 1}",
      "{'descr': '<f8' 'fortran_order': False, 'shape': (4,)}",
      "{'descr': '<f8', 'fortran_order': 0, 'shape': (4,)}",
      "{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (4,)}",
      "{'descr': '<f8', 'fortran_order': False, 'shape': (4,,)}",
      "{'descr': '<f8', 'fortran_order': False, 'shape': [4]}",
      "{'descr': '\\x3cf8', 'fortran_order': False, 'shape': (4,)}",
      "{'descr: '<f8', 'fortran_order': False, 'shape': (4,)}",
      "{'a_key_that_is_far_too_long': '<f8', 'fortran_order': False, 'shape': (4,)}",
  };

  // good headers are accepted, bad ones are refused with the name of the array
  for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
    archive a = archive_sample();
    archive_find(&a, "c3")->header = good[i];
    accepted(&a);
  }
  for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
    archive a = archive_sample();
    archive_find(&a, "c3")->header = bad[i];
    refused(&a, THRUM_BAD_FORMAT, "array 'c3': its .npy header is not that of a plain array");
  }
}

static void numbers_must_be_finite(void **state) {
  (void)state;
  static const char *const arrays[] = {"omega2",   "c3",       "c4",   "axis_mass",
                                       "vertices", "material", "basis"};
  static const double bad[] = {NAN, -NAN, INFINITY, -INFINITY};
  char words[80];
  for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
    for (int b = 0; b < 4; b++) {
      archive a = archive_sample();
      archive_set_f8(&a, arrays[i], 1, bad[b]);
      snprintf(words, sizeof words, "array '%s' holds a value that is not finite (entry 1)",
               arrays[i]);
      refused(&a, THRUM_BAD_VALUE, words);
    }
}

static void frequencies_ascend_from_zero(void **state) {
  (void)state;
  archive a = archive_sample();
  archive_set_f8(&a, "omega2", 1, 39.0);
  refused(&a, THRUM_BAD_VALUE, "array 'omega2' is not in ascending order (entry 1)");
  archive_set_f8(&a, "omega2", 0, -1e-300);
  refused(&a, THRUM_BAD_VALUE, "array 'omega2' holds a negative value");
}

static void indices_stay_in_range(void **state) {
  (void)state;

  // each case replaces one entry of one array
  static const struct {
    const char *array;
    int entry;
    int32_t value;
    const char *words;
  } cases[] = {
      {"tets", 0, -1, "array 'tets' holds the index -1 (entry 0); 0 to 4 are allowed"},
      {"tets", 7, 5, "array 'tets' holds the index 5 (entry 7)"},
      {"tet_region", 1, 2, "array 'tet_region' holds the index 2 (entry 1); 0 to 1"},
      {"tet_region", 0, INT32_MIN, "array 'tet_region' holds the index -2147483648"},
      {"group_vertices", 4, 5, "array 'group_vertices' holds the index 5 (entry 4)"},
      {"group_vertices", 0, -7, "array 'group_vertices' holds the index -7"},
      {"group_vertices", 1, 0, "array 'group_vertices' is not ascending within a group (entry 1)"},
      {"group_ends", 0, 0, "array 'group_ends' entry 0 is 0"},
      {"group_ends", 0, 5, "array 'group_vertices' is not ascending within a group (entry 2)"},
      {"group_ends", 1, 6, "array 'group_ends' entry 1 is 6"},
      {"group_ends", 1, 4, "array 'group_ends' ends at 4, 'group_vertices' has 5"},
      {"group_ends", 0, INT32_MIN, "array 'group_ends' entry 0 is -2147483648"},
  };

  // the index and its entry are in the message
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    archive a = archive_sample();
    archive_set_i4(&a, cases[i].array, cases[i].entry, cases[i].value);
    refused(&a, THRUM_BAD_VALUE, cases[i].words);
  }
}

static void materials_marks_and_names_make_sense(void **state) {
  (void)state;

  // Young's modulus, Poisson's ratio and density outside their ranges
  static const double bad[] = {0, -5e6, 0.5, -1, 0, -1000};
  for (int i = 0; i < 6; i++) {
    archive a = archive_sample();
    archive_set_f8(&a, "material", i / 2, bad[i]);
    refused(&a, THRUM_BAD_VALUE, "array 'material' row 0");
  }

  // marks of held axes are three bits
  archive a = archive_sample();
  archive_find(&a, "fixed")->data[3] = 8;
  refused(&a, THRUM_BAD_VALUE, "array 'fixed' holds 8 (entry 3)");

  // the sample is held at vertex 0, and rigid modes are for free bodies only
  static const double rigid[5 * 3 * 6];
  a = archive_sample();
  archive_add(&a, "rigid.npy", "<f8", "(15, 6)", rigid, sizeof rigid);
  refused(&a, THRUM_BAD_VALUE, "array 'fixed' holds 7 (entry 0); only 0 goes with 'rigid'");

  // names of groups: as many as there are groups, not empty, printable
  a = archive_sample();
  archive_find(&a, "group_names")->data[15] = 'x';
  refused(&a, THRUM_BAD_VALUE, "array 'group_names' holds 1 names");
  a = archive_sample();
  archive_find(&a, "group_names")->data[10] = 0;
  refused(&a, THRUM_BAD_VALUE, "array 'group_names' holds 3 names");
  a = archive_sample();
  archive_find(&a, "group_names")->data[0] = 0;
  refused(&a, THRUM_BAD_VALUE, "array 'group_names' holds an empty name");
  a = archive_sample();
  archive_find(&a, "group_names")->data[1] = '\n';
  refused(&a, THRUM_BAD_VALUE, "array 'group_names' holds a control character");
}

// a model made by hand is refused by the check and by the writer, which writes nothing
static void refused_by_hand(const thrum_model *model, thrum_status status, const char *words) {
  thrum_error error = {.status = THRUM_OK};
  thrum_status got = thrum_model_check(model, &error);
  if (got != status || strstr(error.message, words) == NULL)
    fail_msg("wanted %d '%s', got %d '%s'", status, words, got, error.message);
  // the folder does not exist: an attempt to write would fail with THRUM_IO instead
  assert_int_equal(thrum_model_save("/no-such-folder/m.npz", model, &error), status);
}

static void models_made_by_hand_are_checked_alike(void **state) {
  (void)state;

  // the version and the rank
  thrum_model m = sample_model();
  assert_int_equal(thrum_model_check(&m, NULL), THRUM_OK);
  m.format = NULL;
  refused_by_hand(&m, THRUM_MISSING, "array 'format' is missing");
  m = sample_model();
  m.rank = 0;
  refused_by_hand(&m, THRUM_BAD_SHAPE, "'omega2'");
  m.rank = THRUM_RANK_MAX + 1;
  refused_by_hand(&m, THRUM_BAD_SHAPE, "a rank is 1 to 512");

  // counts that are negative or too large
  m = sample_model();
  m.tet_count = -1;
  refused_by_hand(&m, THRUM_BAD_SHAPE, "tet_count is negative");
  m = sample_model();
  m.vertex_count = INT64_MAX / 2;
  refused_by_hand(&m, THRUM_BAD_SHAPE, "array 'vertices' has 4611686018427387903 rows");

  // counts without their arrays
  m = sample_polynomial();
  m.vertex_count = 1;
  refused_by_hand(&m, THRUM_BAD_SHAPE, "array 'vertices' is absent");
  m = sample_polynomial();
  m.group_count = 1;
  refused_by_hand(&m, THRUM_BAD_SHAPE, "array 'group_ends' is absent");
  m = sample_polynomial();
  m.meta_bytes = 1;
  refused_by_hand(&m, THRUM_BAD_SHAPE, "array 'meta' is absent");

  // values and arrays that depend on each other
  double falling[2] = {2, 1};
  m = sample_model();
  m.omega2 = falling;
  refused_by_hand(&m, THRUM_BAD_VALUE, "array 'omega2'");
  m = sample_model();
  m.group_vertices = NULL;
  refused_by_hand(&m, THRUM_MISSING, "array 'group_vertices' is missing");
}

static void four_gib_are_refused_before_anything_is_read_or_written(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model m = sample_polynomial();

  // the array is far shorter than that: reading it would be caught
  m.meta = (const uint8_t *)SAMPLE_META;
  m.meta_bytes = INT64_C(0xFFFFFFFF) - 1000;
  assert_int_equal(thrum_model_save("/no-such-folder/m.npz", &m, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "4 GiB"));

  // the coefficients of the largest rank
  m = sample_polynomial();
  m.rank = THRUM_RANK_MAX;
  m.c3_count = thrum_c3_count(m.rank);
  m.c4_count = thrum_c4_count(m.rank);
  assert_int_equal(thrum_model_save("/no-such-folder/m.npz", &m, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "4 GiB with 'c4.npy'"));

  // a size whose sum with the others would overflow
  m = sample_polynomial();
  m.meta = (const uint8_t *)SAMPLE_META;
  m.meta_bytes = INT64_MAX;
  assert_true(thrum_model_save("/no-such-folder/m.npz", &m, &error) < THRUM_OK);
  assert_int_not_equal(error.status, THRUM_IO);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bytes_that_are_no_archive_are_refused_as_such),
      cmocka_unit_test(archives_of_other_kinds_are_refused),
      cmocka_unit_test(compressed_and_piped_members_are_refused_with_the_reason),
      cmocka_unit_test(members_tile_the_file_without_gap_or_overlap),
      cmocka_unit_test(local_and_central_records_must_agree),
      cmocka_unit_test(extra_fields_are_padding_or_those_of_numpy),
      cmocka_unit_test(a_wrong_checksum_is_refused_of_unknown_members_too),
      cmocka_unit_test(names_are_plain_and_unique),

      // the arrays
      cmocka_unit_test(required_arrays_and_their_companions_must_be_there),
      cmocka_unit_test(another_version_of_the_format_speaks_first),
      cmocka_unit_test(middle_nodes_need_the_version_that_older_readers_refuse),
      cmocka_unit_test(solids_have_the_nodes_of_their_form_and_tetrahedra_of_their_own),
      cmocka_unit_test(types_and_orders_are_those_of_the_list),
      cmocka_unit_test(shapes_are_those_of_the_list),
      cmocka_unit_test(the_rank_is_1_to_512),
      cmocka_unit_test(headers_are_plain_dictionaries),

      // their content
      cmocka_unit_test(numbers_must_be_finite),
      cmocka_unit_test(frequencies_ascend_from_zero),
      cmocka_unit_test(indices_stay_in_range),
      cmocka_unit_test(materials_marks_and_names_make_sense),
      cmocka_unit_test(models_made_by_hand_are_checked_alike),
      cmocka_unit_test(four_gib_are_refused_before_anything_is_read_or_written),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
