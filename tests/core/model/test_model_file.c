/* Tests of the model file: what is written is read back bit for bit by three readers that agree, no
 * damaged file is accepted, and no half-written file appears. See docs/model_format.md.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/crc32.h"
#include "io/file.h"
#include "io/npy_file.h"
#include "io/npz.h"
#include "tests/support/model_archive.h"

static char folder[] = "/tmp/thrum-model-XXXXXX";
static _Alignas(64) unsigned char file_bytes[ARCHIVE_MAX];
static _Alignas(64) unsigned char changed_bytes[ARCHIVE_MAX];
static _Alignas(64) unsigned char memory[ARCHIVE_MAX];

static int make_folder(void **state) {
  (void)state;
  return mkdtemp(folder) == NULL;
}

// removes the files that tests left, then the folder
static int remove_folder(void **state) {
  (void)state;
  DIR *entries = opendir(folder);
  for (struct dirent *e = readdir(entries); e != NULL; e = readdir(entries)) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
    if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0)
      remove(path);
  }
  closedir(entries);
  return rmdir(folder);
}

static const char *in_folder(const char *name) {
  static char path[512];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return path;
}

static int files_in(const char *path) {
  int count = 0;
  DIR *entries = opendir(path);
  assert_non_null(entries);
  for (struct dirent *e = readdir(entries); e != NULL; e = readdir(entries))
    count += e->d_name[0] != '.';
  closedir(entries);
  return count;
}

// saves a model and returns the size of its file, whose bytes go to `bytes`
static size_t save_bytes(const thrum_model *model, unsigned char *bytes) {
  thrum_error error = {.status = THRUM_OK};
  const char *path = in_folder("saved.npz");
  if (thrum_model_save(path, model, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *data = NULL;
  size_t size = 0;
  assert_int_equal(thrum_file_read(path, &data, &size, &error), THRUM_OK);
  assert_true(size <= ARCHIVE_MAX);
  memcpy(bytes, data, size);
  free(data);
  remove(path);
  return size;
}

static void crc32_gives_the_published_check_value(void **state) {
  (void)state;
  thrum_crc32_table table;
  thrum_crc32_prepare(&table);
  assert_int_equal(thrum_crc32(&table, 0, "123456789", 9), 0xCBF43926u);

  // any split and any start give the checksum of the definition
  unsigned char data[100];
  for (int i = 0; i < 100; i++)
    data[i] = (unsigned char)(37 * i * i + 11);
  for (size_t start = 0; start < 9; start++)
    for (size_t cut = start; cut <= 100; cut++) {
      uint32_t crc = thrum_crc32(&table, 0, data + start, cut - start);
      crc = thrum_crc32(&table, crc, data + cut, 100 - cut);
      assert_int_equal(crc, archive_crc(data + start, 100 - start));
    }
}

static void check_round_trip(const thrum_model *model) {
  size_t size = save_bytes(model, file_bytes);
  thrum_error error = {.status = THRUM_OK};
  thrum_model view;
  if (thrum_model_view(file_bytes, size, &view, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_true(models_bit_equal(model, &view));
  assert_int_equal(thrum_model_check(&view, &error), THRUM_OK);

  // the same model gives the same file
  assert_int_equal(save_bytes(&view, changed_bytes), size);
  assert_memory_equal(file_bytes, changed_bytes, size);
}

static void a_saved_model_is_read_back_bit_for_bit(void **state) {
  (void)state;
  thrum_model model = sample_model();
  check_round_trip(&model);
}

static void a_polynomial_without_mesh_and_basis_is_a_model(void **state) {
  (void)state;
  thrum_model model = sample_polynomial();
  check_round_trip(&model);

  // the smallest rank
  double numbers[3] = {4, -1, 0.5};
  model.rank = model.c3_count = model.c4_count = 1;
  model.omega2 = numbers;
  model.c3 = numbers + 1;
  model.c4 = numbers + 2;
  check_round_trip(&model);
}

static void empty_groups_and_empty_meta_survive(void **state) {
  (void)state;
  thrum_model model = sample_model();
  model.group_count = model.group_name_bytes = model.group_vertex_count = model.meta_bytes = 0;
  check_round_trip(&model);
  thrum_error error = {.status = THRUM_OK};
  const int32_t *vertices = NULL;
  int64_t count = 0;
  assert_null(thrum_model_group_name(&model, 0));
  assert_int_equal(thrum_model_group(&model, "left", &vertices, &count, &error), THRUM_MISSING);
}

static void the_file_is_that_of_an_independent_maker(void **state) {
  (void)state;
  thrum_model model = sample_model();
  size_t size = save_bytes(&model, file_bytes);
  archive a = archive_sample();
  assert_int_equal(archive_build(&a, changed_bytes), size);
  assert_memory_equal(file_bytes, changed_bytes, size);
}

static void every_array_of_a_saved_model_is_aligned_to_64_bytes(void **state) {
  (void)state;
  thrum_model model = sample_model(), view;
  size_t size = save_bytes(&model, file_bytes);
  assert_int_equal(thrum_model_view(file_bytes, size, &view, NULL), THRUM_OK);
#define X(type, name, rows, columns, presence, meaning)                                            \
  assert_int_equal((uintptr_t)view.name % 64, 0);
  THRUM_MODEL_ARRAYS(X)
#undef X
}

// reads the file into memory of exactly the planned size; *model points into that memory
static void init_exactly(const unsigned char *file, size_t size, const thrum_model **model) {
  thrum_error error = {.status = THRUM_OK};
  size_t needed = 0;
  if (thrum_model_size(file, size, &needed, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_true(needed <= sizeof memory - 64);

  // memory that is too small or misaligned is refused, and nothing is written to it
  const thrum_model *untouched = (const thrum_model *)(const void *)folder;
  *model = untouched;
  memset(memory, 0xA5, sizeof memory);
  assert_int_equal(thrum_model_init(memory, needed - 1, file, size, model, &error),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_model_init(memory + 8, needed, file, size, model, &error),
                   THRUM_MISALIGNED);
  for (size_t i = 0; i < sizeof memory; i++)
    assert_int_equal(memory[i], 0xA5);
  assert_ptr_equal(*model, untouched);

  // the planned size suffices, and nothing is written behind it
  if (thrum_model_init(memory, needed, file, size, model, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  for (size_t i = needed; i < sizeof memory; i++)
    assert_int_equal(memory[i], 0xA5);
}

static void view_init_and_load_agree(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model model = sample_model(), view;
  size_t size = save_bytes(&model, file_bytes);
  assert_int_equal(thrum_model_view(file_bytes, size, &view, &error), THRUM_OK);

  // the view, the copy in given memory and the loaded model are equal
  const thrum_model *laid = NULL, *loaded = NULL;
  init_exactly(file_bytes, size, &laid);
  assert_true(models_bit_equal(&view, laid));
  const char *path = in_folder("agree.npz");
  assert_int_equal(thrum_file_write_atomic(path, file_bytes, size, &error), THRUM_OK);
  assert_int_equal(thrum_model_load(path, &loaded, &error), THRUM_OK);
  assert_true(models_bit_equal(&view, loaded));

  // both copies have every array aligned to 64 bytes
#define X(type, name, rows, columns, presence, meaning)                                            \
  assert_int_equal((uintptr_t)laid->name % 64, 0);                                                 \
  assert_int_equal((uintptr_t)loaded->name % 64, 0);
  THRUM_MODEL_ARRAYS(X)
#undef X

  thrum_model_destroy(loaded);
  thrum_model_destroy(NULL);
}

static void a_laid_out_model_outlives_its_file(void **state) {
  (void)state;
  thrum_model model = sample_model();
  size_t size = save_bytes(&model, file_bytes);
  const thrum_model *laid = NULL;
  init_exactly(file_bytes, size, &laid);
  memset(file_bytes, 0xFF, sizeof file_bytes);
  assert_true(models_bit_equal(&model, laid));
}

// reads a file as numpy.savez makes it: extra fields of 20 bytes, and no array aligned
static void check_savez_form(archive_extra extra) {
  thrum_error error = {.status = THRUM_OK};
  archive a = archive_sample();
  archive_set_extra(&a, extra);
  size_t size = archive_build(&a, file_bytes);

  // a view needs alignment: it is refused with a hint, and the output stays as it was
  thrum_model model = sample_model(), view, zeros;
  memset(&view, 0, sizeof view);
  memset(&zeros, 0, sizeof zeros);
  assert_int_equal(thrum_model_view(file_bytes, size, &view, &error), THRUM_MISALIGNED);
  assert_non_null(strstr(error.message, "array 'format'"));
  assert_non_null(strstr(error.message, "thrum_model_init"));
  assert_memory_equal(&view, &zeros, sizeof view);

  // a copy works at any alignment of the buffer
  for (size_t shift = 0; shift < 9; shift++) {
    memcpy(changed_bytes + shift, file_bytes, size);
    const thrum_model *laid = NULL;
    init_exactly(changed_bytes + shift, size, &laid);
    assert_true(models_bit_equal(&model, laid));
  }

  // loading from disk gives the same model
  const char *path = in_folder("savez.npz");
  const thrum_model *loaded = NULL;
  assert_int_equal(thrum_file_write_atomic(path, file_bytes, size, &error), THRUM_OK);
  assert_int_equal(thrum_model_load(path, &loaded, &error), THRUM_OK);
  assert_true(models_bit_equal(&model, loaded));
  thrum_model_destroy(loaded);
}

static void files_of_numpy_savez_are_copied_and_loaded_but_not_viewed(void **state) {
  (void)state;
  check_savez_form(EXTRA_ZIP64);
  check_savez_form(EXTRA_ZIP64_ONLY);
  check_savez_form(EXTRA_NONE);
}

static void a_buffer_that_is_not_aligned_is_not_viewed(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model model = sample_model(), view;
  size_t size = save_bytes(&model, file_bytes);
  for (size_t shift = 1; shift < 64; shift++) {
    memmove(changed_bytes + shift, file_bytes, size);
    assert_int_equal(thrum_model_view(changed_bytes + shift, size, &view, &error),
                     THRUM_MISALIGNED);
  }
  assert_non_null(strstr(error.message, "64"));
}

static void every_truncation_is_refused(void **state) {
  (void)state;
  thrum_model model = sample_model(), view;
  size_t size = save_bytes(&model, file_bytes), needed = 0;

  // bytes are taken from an exact heap block, so that a read past the end is caught by a sanitizer
  for (size_t cut = 0; cut < size; cut++) {
    unsigned char *piece = aligned_alloc(64, (cut + 63) / 64 * 64 + 64);
    unsigned char *end_first = malloc(cut + 1);
    assert_true(piece != NULL && end_first != NULL);
    memcpy(piece, file_bytes, cut);
    memcpy(end_first, file_bytes + size - cut, cut);

    // neither the first nor the last bytes of a file are a model
    thrum_error error = {.status = THRUM_OK};
    assert_true(thrum_model_view(piece, cut, &view, &error) < 0);
    assert_true(error.status < 0 && error.message[0] != '\0');
    assert_true(thrum_model_size(end_first, cut, &needed, &error) < 0);
    free(piece);
    free(end_first);
  }

  // bytes behind the end are refused as well
  memcpy(changed_bytes, file_bytes, size);
  for (size_t more = 1; more < 70; more++)
    assert_true(thrum_model_view(changed_bytes, size + more, &view, NULL) < 0);
}

// tries `count` values of every byte; returns how many files were still accepted
static int change_every_byte(const unsigned char *bytes, size_t size, int count) {
  const thrum_model *first = NULL, *now = NULL;
  static _Alignas(64) unsigned char original[ARCHIVE_MAX];
  int accepted = 0;

  // an accepted file must hold the same model as the original
  assert_int_equal(thrum_model_init(original, sizeof original, bytes, size, &first, NULL),
                   THRUM_OK);
  memcpy(changed_bytes, bytes, size);
  for (size_t at = 0; at < size; at++) {
    for (int v = 1; v <= count; v++) {
      // all 255 other values, or the eight single bits and a few more
      unsigned change = count == 255 ? (unsigned)v : v <= 8 ? 1u << (v - 1) : 0xFFu - (unsigned)v;
      changed_bytes[at] = (unsigned char)(bytes[at] ^ change);
      if (thrum_model_init(memory, sizeof memory, changed_bytes, size, &now, NULL) != THRUM_OK)
        continue;
      accepted++;
      if (!models_bit_equal(first, now))
        fail_msg("byte %zu changed by %#x gives another model", at, change);
    }
    changed_bytes[at] = bytes[at];
  }
  return accepted;
}

static void every_one_byte_change_is_refused_or_harmless(void **state) {
  (void)state;
  // the smallest model, with every value of every byte
  double numbers[3] = {4, -1, 0.5};
  thrum_model model = sample_polynomial();
  model.rank = model.c3_count = model.c4_count = 1;
  model.omega2 = numbers;
  model.c3 = numbers + 1;
  model.c4 = numbers + 2;
  size_t size = save_bytes(&model, file_bytes);
  int accepted = change_every_byte(file_bytes, size, 255);

  // no reader uses these bytes: versions and times in both records, attributes in the central ones
  assert_int_equal(accepted, 4 * 255 * ((2 + 4) + (4 + 4 + 6)));
}

static void a_change_of_a_full_model_or_of_a_savez_file_is_refused_or_harmless(void **state) {
  (void)state;
  archive a = archive_sample();
  size_t size = archive_build(&a, file_bytes);
  change_every_byte(file_bytes, size, 10);
  archive_set_extra(&a, EXTRA_ZIP64);
  size = archive_build(&a, file_bytes);
  change_every_byte(file_bytes, size, 10);
  archive_set_extra(&a, EXTRA_ZIP64_ONLY);
  size = archive_build(&a, file_bytes);
  change_every_byte(file_bytes, size, 10);
}

// the checksum hides this damage: an accepted file must hold a model that can be saved again
static void damage_under_a_right_checksum_is_refused_or_a_valid_model(void **state) {
  (void)state;
  uint64_t s = 1;
  int accepted = 0, refused = 0;
  for (int round = 0; round < 4000; round++) {
    // the generator chooses the array, the place and the kind of damage
    archive a = archive_sample();
    char header[160];
    s = s * 6364136223846793005u + 1442695040888963407u;
    archive_part *part = &a.parts[(s >> 33) % (unsigned)a.count];
    unsigned at = (unsigned)(s >> 20 & 0xFFu), change = (unsigned)(s >> 55) + 1;

    // half of the damage is in the data of an array, the other half in its header
    if (round % 2 == 0) {
      part->data[at % part->size] ^= (unsigned char)change;
    } else {
      snprintf(header, sizeof header, "{'descr': '%s', 'fortran_order': False, 'shape': %s, }",
               part->type, part->shape);
      header[at % strlen(header)] = (char)(change % 95 + 32);
      part->header = header;
    }

    // the reader accepts a valid model or refuses with a message of one line
    size_t size = archive_build(&a, file_bytes);
    thrum_error error = {.status = THRUM_OK};
    const thrum_model *model = NULL;
    if (thrum_model_init(memory, sizeof memory, file_bytes, size, &model, &error) == THRUM_OK) {
      assert_int_equal(thrum_model_check(model, NULL), THRUM_OK);
      accepted++;
    } else {
      assert_true(error.message[0] != '\0' && strchr(error.message, '\n') == NULL);
      refused++;
    }
  }

  // the damage was of both kinds
  assert_true(accepted > 100 && refused > 100);
}

static void groups_are_found_by_name(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model model = sample_model();
  const int32_t *vertices = NULL;
  int64_t count = 0;

  // each group has its own range of the vertices
  assert_int_equal(thrum_model_group(&model, "left", &vertices, &count, &error), THRUM_OK);
  assert_int_equal(count, 2);
  assert_ptr_equal(vertices, sample_group_vertices);
  assert_int_equal(thrum_model_group(&model, "right side", &vertices, &count, &error), THRUM_OK);
  assert_int_equal(count, 3);
  assert_ptr_equal(vertices, sample_group_vertices + 2);

  // a part of a name is no name, and leaves the outputs as they were
  assert_int_equal(thrum_model_group(&model, "lef", &vertices, &count, &error), THRUM_MISSING);
  assert_non_null(strstr(error.message, "'lef'"));
  assert_int_equal(count, 3);

  // names are found by index, and only within the count
  assert_string_equal(thrum_model_group_name(&model, 0), "left");
  assert_string_equal(thrum_model_group_name(&model, 1), "right side");
  assert_null(thrum_model_group_name(&model, 2));
  assert_null(thrum_model_group_name(&model, -1));
}

static void a_file_that_cannot_be_loaded_is_named(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  const thrum_model *model = NULL;

  // paths without a file behind them
  assert_int_equal(thrum_model_load(in_folder("none.npz"), &model, &error), THRUM_IO);
  assert_non_null(strstr(error.message, "none.npz: No such file"));
  assert_int_equal(thrum_model_load("", &model, &error), THRUM_IO);
  assert_string_equal(error.message, "the name of the model file is empty");
  assert_int_equal(thrum_model_load(folder, &model, &error), THRUM_IO);
  assert_non_null(strstr(error.message, "Is a directory"));

  // files that hold no model
  assert_int_equal(thrum_file_write_atomic(in_folder("empty.npz"), "", 0, NULL), THRUM_OK);
  assert_int_equal(thrum_model_load(in_folder("empty.npz"), &model, &error), THRUM_BAD_FORMAT);
  assert_non_null(strstr(error.message, "empty.npz: the file is empty"));
  assert_int_equal(thrum_file_write_atomic(in_folder("text.npz"), "hello\n", 6, NULL), THRUM_OK);
  assert_int_equal(thrum_model_load(in_folder("text.npz"), &model, &error), THRUM_BAD_FORMAT);
  assert_non_null(strstr(error.message, "text.npz: not a model file"));
  assert_int_equal(thrum_model_load("/dev/zero", &model, &error), THRUM_IO);
  assert_null(model);

  // a path of any length still leaves the reason in the message
  char path[3000];
  memset(path, 'a', sizeof path);
  path[sizeof path - 1] = '\0';
  assert_int_equal(thrum_model_load(path, &model, &error), THRUM_IO);
  assert_non_null(strstr(error.message, "aaa: File name too long"));
}

static void a_missing_argument_is_refused(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model view, model = sample_model();
  const thrum_model *loaded = NULL;
  size_t size = save_bytes(&model, file_bytes), needed = 0;

  // the readers
  assert_int_equal(thrum_model_view(NULL, size, &view, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_view(file_bytes, size, NULL, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_size(NULL, size, &needed, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_size(file_bytes, size, NULL, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_init(NULL, 0, file_bytes, size, &loaded, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_load(NULL, &loaded, &error), THRUM_INVALID_ARGUMENT);

  // the check and the writer
  assert_int_equal(thrum_model_check(NULL, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_save(NULL, &model, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_save("", &model, &error), THRUM_INVALID_ARGUMENT);
}

// a file of one line is at `path`; after any failure it must be there unchanged, and nothing else
static void expect_old_file(const char *path) {
  void *data = NULL;
  size_t size = 0;
  assert_int_equal(thrum_file_read(path, &data, &size, NULL), THRUM_OK);
  assert_int_equal(size, 4);
  assert_memory_equal(data, "old\n", 4);
  free(data);
}

static void a_full_disk_leaves_the_old_file_and_nothing_else(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model model = sample_model();
  size_t size = save_bytes(&model, file_bytes);

  // an old file that the failed writes must not touch
  const char *path = in_folder("disk.npz");
  assert_int_equal(thrum_file_write_atomic(path, "old\n", 4, NULL), THRUM_OK);
  int files = files_in(folder);

  // a limit of the file size stands for a full disk
  struct rlimit before, small;
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
  signal(SIGXFSZ, SIG_IGN);
  for (size_t limit = 0; limit < size; limit += 97) {
    small = before;
    small.rlim_cur = limit;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    thrum_status status = thrum_model_save(path, &model, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(status, THRUM_IO);
    assert_non_null(strstr(error.message, "disk.npz: cannot be written: File too large"));
    assert_int_equal(files_in(folder), files);
    expect_old_file(path);
  }
  signal(SIGXFSZ, SIG_DFL);

  // with room again the new file takes the place of the old one
  assert_int_equal(thrum_model_save(path, &model, &error), THRUM_OK);
  assert_int_equal(files_in(folder), files);
}

static void a_read_only_folder_is_left_as_it_was(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model model = sample_model();
  char closed[512], path[600];

  // a folder that can be read only, with an old file in it
  snprintf(closed, sizeof closed, "%s", in_folder("closed"));
  snprintf(path, sizeof path, "%s/m.npz", closed);
  assert_int_equal(mkdir(closed, 0755), 0);
  assert_int_equal(thrum_file_write_atomic(path, "old\n", 4, NULL), THRUM_OK);

  // the superuser may write anywhere, so the test becomes an ordinary user for the call
  int root = geteuid() == 0;
  assert_int_equal(chmod(folder, 0755), 0);
  assert_int_equal(chmod(closed, 0555), 0);
  if (root)
    assert_int_equal(seteuid(65534), 0);

  // the call runs between two changes of the rights and reports the reason
  thrum_status status = thrum_model_save(path, &model, &error);
  if (root)
    assert_int_equal(seteuid(0), 0);
  assert_int_equal(chmod(closed, 0755), 0);
  assert_int_equal(status, THRUM_IO);
  assert_non_null(strstr(error.message, "m.npz: cannot be created: Permission denied"));

  // the old file is all that the folder holds
  assert_int_equal(files_in(closed), 1);
  expect_old_file(path);
  remove(path);
  rmdir(closed);
}

static void targets_that_are_no_files_are_refused(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  thrum_model model = sample_model();
  int files = files_in(folder);

  // a folder, a folder that does not exist, and a pipe are no targets
  assert_int_equal(thrum_model_save(folder, &model, &error), THRUM_IO);
  assert_non_null(strstr(error.message, "is a folder"));
  assert_int_equal(thrum_model_save(in_folder("no/such/m.npz"), &model, &error), THRUM_IO);
  assert_non_null(strstr(error.message, "m.npz: cannot be created: No such file"));
  assert_int_equal(mkfifo(in_folder("pipe"), 0600), 0);
  assert_int_equal(thrum_model_save(in_folder("pipe"), &model, &error), THRUM_IO);
  assert_non_null(strstr(error.message, "pipe: not a regular file"));

  // neither are they files to read
  void *data = NULL;
  size_t size = 0;
  assert_int_equal(thrum_file_read(in_folder("pipe"), &data, &size, &error), THRUM_IO);
  assert_int_equal(thrum_file_read(folder, &data, &size, &error), THRUM_IO);
  assert_null(data);

  remove(in_folder("pipe"));
  assert_int_equal(files_in(folder), files);
}

static void an_abandoned_file_never_appears(void **state) {
  (void)state;
  const char *path = in_folder("given-up.txt");
  int files = files_in(folder);
  thrum_file_writer writer = {NULL, NULL, NULL};
  assert_int_equal(thrum_file_writer_open(path, &writer, NULL), THRUM_OK);
  assert_int_equal(thrum_file_writer_put(&writer, "half", 4, NULL), THRUM_OK);
  assert_int_equal(files_in(folder), files + 1);
  assert_int_equal(access(path, F_OK), -1);
  thrum_file_writer_abandon(&writer);
  thrum_file_writer_abandon(&writer);
  assert_int_equal(files_in(folder), files);
  assert_int_equal(thrum_file_writer_put(&writer, "x", 1, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_file_writer_commit(&writer, NULL), THRUM_INVALID_ARGUMENT);
}

static void new_files_follow_the_umask(void **state) {
  (void)state;
  struct stat info;
  const char *path = in_folder("mask.txt");
  mode_t old = umask(027);
  assert_int_equal(thrum_file_write_atomic(path, "x", 1, NULL), THRUM_OK);
  umask(old);
  assert_int_equal(stat(path, &info), 0);
  assert_int_equal(info.st_mode & 0777, 0640);
}

static void npy_vectors_and_matrices_are_read_back(void **state) {
  (void)state;
  thrum_error error = {.status = THRUM_OK};
  unsigned char file[192 + sizeof sample_basis];
  const char *path = in_folder("q.npy");

  // a vector has no columns in its header
  for (int64_t columns = 0; columns <= 2; columns += 2) {
    int64_t rows = columns == 0 ? 30 : 15, r = -1, c = -1;
    size_t header = thrum_npy_header_f8(file, rows, columns);
    assert_int_equal(header % 64, 0);
    memcpy(file + header, sample_basis, sizeof sample_basis);
    size_t size = header + sizeof sample_basis;

    // what is read back has the shape and the bits that were written
    double *values = NULL;
    assert_int_equal(thrum_file_write_atomic(path, file, size, &error), THRUM_OK);
    assert_int_equal(thrum_npy_read_f8(path, &values, &r, &c, &error), THRUM_OK);
    assert_int_equal(r, rows);
    assert_int_equal(c, columns);
    assert_memory_equal(values, sample_basis, sizeof sample_basis);
    free(values);

    // every truncation is refused with the name of the file
    values = NULL;
    for (size_t cut = 0; cut < size; cut++) {
      assert_int_equal(thrum_file_write_atomic(path, file, cut, &error), THRUM_OK);
      assert_true(thrum_npy_read_f8(path, &values, &r, &c, &error) < 0);
      assert_non_null(strstr(error.message, "q.npy"));
      assert_null(values);
    }
  }

  // the largest numbers still fit into the header
  assert_true(thrum_npy_header_f8(file, INT64_MAX, INT64_MAX) <= 192);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(crc32_gives_the_published_check_value),
      cmocka_unit_test(a_saved_model_is_read_back_bit_for_bit),
      cmocka_unit_test(a_polynomial_without_mesh_and_basis_is_a_model),
      cmocka_unit_test(empty_groups_and_empty_meta_survive),
      cmocka_unit_test(the_file_is_that_of_an_independent_maker),
      cmocka_unit_test(every_array_of_a_saved_model_is_aligned_to_64_bytes),
      cmocka_unit_test(view_init_and_load_agree),
      cmocka_unit_test(a_laid_out_model_outlives_its_file),

      // buffers that were not made by Thrum
      cmocka_unit_test(files_of_numpy_savez_are_copied_and_loaded_but_not_viewed),
      cmocka_unit_test(a_buffer_that_is_not_aligned_is_not_viewed),

      // damage
      cmocka_unit_test(every_truncation_is_refused),
      cmocka_unit_test(every_one_byte_change_is_refused_or_harmless),
      cmocka_unit_test(a_change_of_a_full_model_or_of_a_savez_file_is_refused_or_harmless),
      cmocka_unit_test(damage_under_a_right_checksum_is_refused_or_a_valid_model),

      // names, and files that cannot be read or written
      cmocka_unit_test(groups_are_found_by_name),
      cmocka_unit_test(a_file_that_cannot_be_loaded_is_named),
      cmocka_unit_test(a_missing_argument_is_refused),
      cmocka_unit_test(a_full_disk_leaves_the_old_file_and_nothing_else),
      cmocka_unit_test(a_read_only_folder_is_left_as_it_was),
      cmocka_unit_test(targets_that_are_no_files_are_refused),
      cmocka_unit_test(an_abandoned_file_never_appears),
      cmocka_unit_test(new_files_follow_the_umask),
      cmocka_unit_test(npy_vectors_and_matrices_are_read_back),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
