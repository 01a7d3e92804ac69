/* Support for tests of mesh readers: texts become files in a folder of the test's own, and the
 * result of reading them is checked. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_MESH_SUPPORT_H
#define THRUM_TESTS_SUPPORT_MESH_SUPPORT_H

// clang-format off
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"

/* The folder, made by mesh_setup and removed with its files by mesh_teardown. */
static char mesh_folder[64];
static char mesh_files[32][128];
static int mesh_file_count;

static inline int mesh_setup(void **state) {
  (void)state;
  strcpy(mesh_folder, "/tmp/thrum-mesh-XXXXXX");
  return mkdtemp(mesh_folder) ? 0 : -1;
}

static inline int mesh_teardown(void **state) {
  (void)state;
  for (int i = 0; i < mesh_file_count; i++)
    unlink(mesh_files[i]);
  mesh_file_count = 0;
  return rmdir(mesh_folder);
}

/* Writes `size` bytes as a file called `name`; returns its path. */
static inline const char *mesh_write(const char *name, const char *data, size_t size) {
  char path[128];
  snprintf(path, sizeof path, "%s/%s", mesh_folder, name);

  // some file systems wait for the disk where a file is cut to nothing and written again
  unlink(path);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(data, 1, size, file), size);
  assert_int_equal(fclose(file), 0);

  // each name is listed once, for its removal at the end
  int i = 0;
  while (i < mesh_file_count && strcmp(mesh_files[i], path) != 0)
    i++;
  if (i == mesh_file_count) {
    assert_true(mesh_file_count < 32);
    strcpy(mesh_files[mesh_file_count++], path);
  }
  return mesh_files[i];
}

static inline const char *mesh_write_text(const char *name, const char *text) {
  return mesh_write(name, text, strlen(text));
}

/* Reads a text that must be a good mesh. Free the result. */
static inline thrum_mesh mesh_good(const char *name, const char *text) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  if (thrum_mesh_read(mesh_write_text(name, text), 1, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  return mesh;
}

/* The message is one line and contains these words. */
static inline void mesh_check_message(const thrum_error *error, const char *words) {
  if (!strstr(error->message, words))
    fail_msg("expected '%s' in: %s", words, error->message);
  if (strchr(error->message, '\n') || strlen(error->message) > 350)
    fail_msg("not one clear line: %s", error->message);
}

/* Reads bytes that must be refused with a line that holds `words`; the mesh stays as it was. */
static inline void mesh_bad_bytes(const char *name, const char *data, size_t size,
                                  const char *words) {
  thrum_mesh mesh, before;
  memset(&mesh, 0x5a, sizeof mesh);
  before = mesh;
  thrum_error error = {0};
  thrum_status status = thrum_mesh_read(mesh_write(name, data, size), 1, &mesh, &error);
  if (status >= 0)
    fail_msg("not refused; expected '%s'", words);
  assert_int_equal(error.status, status);
  mesh_check_message(&error, words);
  assert_memory_equal(&mesh, &before, sizeof mesh);
}

static inline void mesh_bad(const char *name, const char *text, const char *words) {
  mesh_bad_bytes(name, text, strlen(text), words);
}

#endif
