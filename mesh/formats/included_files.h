/* The files that a mesh takes in by name: a text and, while it is read, the texts that stand in the
 * place of one of its lines. Formats with *INCLUDE or INPUT= share it.
 *
 * A mesh from elsewhere must not have any file of the machine read, and its lines shown in
 * messages. So a file lies in the folder of the first one or below, or below the folder that the
 * environment variable THRUM_INCLUDES names. No file takes in itself, through others or not, and
 * their depth and number are bounded. Cost: linear in the files.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_INCLUDED_FILES_H
#define THRUM_MESH_FORMATS_INCLUDED_FILES_H

#include <sys/stat.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "platform/allocate.h"

enum { THRUM_INCLUDED_DEPTH_MAX = 8, THRUM_INCLUDED_FILES_MAX = 100 };

/* A text being read, or read already: words of it are good until the end. */
typedef struct thrum_included_file {
  const char *path;
  thrum_text text;
  dev_t device;
  ino_t inode;
  int parent; /* index of the file that takes it in, -1 for the first */
} thrum_included_file;

typedef struct thrum_included_files {
  thrum_scope paths;
  thrum_included_file files[THRUM_INCLUDED_FILES_MAX];
  int count;
  int current;             /* index of the file being read */
  int64_t size;            /* of all texts [B] */
  char comment, separator; /* as of thrum_text */
} thrum_included_files;

/* Begins with the first file, whose bytes are in memory. End it also after a failure. */
thrum_status thrum_included_begin(thrum_included_files *included, const thrum_mesh_source *first,
                                  char comment, char separator, thrum_error *error);
void thrum_included_end(thrum_included_files *included);

/* The text that is being read. */
thrum_text *thrum_included_text(thrum_included_files *included);
/* The number of the present line; 0 in a file that another one takes in, so that no message names a
 * line of the first file that it does not mean. */
int64_t thrum_included_line(thrum_included_files *included);

/* Goes on with the file of that name, which is relative to the present one, before the next line of
 * the present one. Messages are about the present line, which names the file by `keyword`. */
thrum_status thrum_included_open(thrum_included_files *included, const char *keyword,
                                 thrum_word name);
/* Moves to the next line that is not blank; false at the end of the first file. */
bool thrum_included_next_line(thrum_included_files *included);

#endif
