/* The folder of a test program, made and removed with the group of its tests.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_TEST_FOLDER_H
#define THRUM_TESTS_SUPPORT_TEST_FOLDER_H

#include "tests/support/program_support.h"

static char folder[64];

/* The path of a file in the folder, which holds until the eighth call after this one. */
static inline const char *in_folder(const char *name) {
  static char paths[8][200];
  static int next;
  char *path = paths[next++ % 8];
  snprintf(path, sizeof paths[0], "%s/%s", folder, name);
  return path;
}

static inline int make_folder(void **state) {
  (void)state;
  return test_folder_make(folder) != NULL ? 0 : -1;
}

static inline int remove_folder(void **state) {
  (void)state;
  test_folder_remove(folder);
  return 0;
}

/* Makes beam.npz in the folder: the model of a beam such as "8x2x2@1x0.1x0.1" (thrum help
 * precompute), held at x = 0, of
 * linear tetrahedra that are the same in every cell. */
static inline bool precompute_beam(const char *beam, const char *modes, const char *rank) {
  char name[64];
  snprintf(name, sizeof name, "beam:%s,split=6", beam);
  program_result run = thrum_run(folder, "precompute", name, "--order", "1", "-o", "beam.npz",
                                 "--fix", "x<0.001", "--modes", modes, "--rank", rank, "-q", NULL);
  const bool made = run.exit_code == 0;
  if (!made)
    fprintf(stderr, "%s", run.err);
  program_result_free(&run);
  return made;
}

#endif
