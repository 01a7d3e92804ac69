/* Files that a mesh takes in by name, see included_files.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/included_files.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "platform/folder_swap.h"

thrum_text *thrum_included_text(thrum_included_files *included) {
  return &included->files[included->current].text;
}

int64_t thrum_included_line(thrum_included_files *included) {
  return included->current == 0 ? thrum_included_text(included)->line : 0;
}

/* Notes which file the text just opened is, so that files cannot take in each other. */
static void note_file(thrum_included_files *included, const char *path, int parent) {
  thrum_included_file *file = &included->files[included->count];
  file->path = path;
  file->parent = parent;
  struct stat about;
  if (stat(path, &about) == 0) {
    file->device = about.st_dev;
    file->inode = about.st_ino;
  }
  included->current = included->count++;
}

thrum_status thrum_included_begin(thrum_included_files *included, const thrum_mesh_source *first,
                                  char comment, char separator, thrum_error *error) {
  *included = (thrum_included_files){.paths = thrum_scope_begin("the mesh", error),
                                     .size = (int64_t)first->size,
                                     .comment = comment,
                                     .separator = separator};
  THRUM_TRY(thrum_text_view(first->name, first->data, first->size, comment, separator,
                            &included->files[0].text, error));
  note_file(included, first->name, -1);
  return THRUM_OK;
}

void thrum_included_end(thrum_included_files *included) {
  for (int i = 0; i < included->count; i++)
    thrum_text_close(&included->files[i].text);
  thrum_scope_free(&included->paths);
}

static thrum_status check_cycle(thrum_included_files *included, const char *keyword,
                                const char *path) {
  const thrum_text *text = thrum_included_text(included);
  struct stat about;
  if (stat(path, &about) != 0)
    return thrum_text_fail(text, THRUM_IO, "cannot find the included file '%.150s'", path);

  // a file may be taken in several times, but not by itself through others
  int depth = 1;
  for (int i = included->current; i >= 0; i = included->files[i].parent, depth++)
    if (included->files[i].device == about.st_dev && included->files[i].inode == about.st_ino)
      return thrum_text_fail(text, THRUM_BAD_FORMAT,
                             "%s goes in a circle: a file takes in itself, here or through others",
                             keyword);

  // the files stay open until the end, so their number is limited
  if (depth > THRUM_INCLUDED_DEPTH_MAX || included->count == THRUM_INCLUDED_FILES_MAX)
    return thrum_text_fail(text, THRUM_UNSUPPORTED,
                           "%s goes deeper than %d files, or there are more than %d", keyword,
                           THRUM_INCLUDED_DEPTH_MAX, THRUM_INCLUDED_FILES_MAX);
  return THRUM_OK;
}

/* Is the name absolute, or has it a part ".."? */
static bool leaves_folder(thrum_word name) {
  size_t begin = 0;
  for (size_t i = 0; i <= name.length; i++)
    if (i == name.length || name.text[i] == '/') {
      if (i == 0 || (i - begin == 2 && name.text[begin] == '.' && name.text[begin + 1] == '.'))
        return true;
      begin = i + 1;
    }
  return false;
}

/* Whether a file is a folder or lies below it, both without links; NULL: one is not there. */
static bool is_below(const char *folder, const char *file) {
  const size_t length = folder ? strlen(folder) : 0;
  return length > 0 && file && strncmp(file, folder, length) == 0 &&
         (file[length] == '/' || file[length] == '\0' || folder[length - 1] == '/');
}

/* Whether a file lies below the folder that the user has named for files from elsewhere. */
static bool is_allowed(const char *path) {
  const char *named = getenv("THRUM_INCLUDES");
  char *folder = named && *named ? thrum_folder_real_path(named) : NULL;
  char *file = folder ? thrum_folder_real_path(path) : NULL;
  const bool below = is_below(folder, file);
  free(folder);
  free(file);
  return below;
}

/* Whether a file lies below the folder of the first file, or where that one is a link, below the
 * folder that it leads to. A file that is not there does: the reason is said where it is opened. */
static bool stays_in_folder(const thrum_included_files *included, const char *path) {
  const char *start = included->files[0].path, *slash = strrchr(start, '/');
  char *named = slash ? strndup(start, (size_t)(slash - start) + 1) : strdup(".");
  char *folder = named ? thrum_folder_real_path(named) : NULL;
  char *first = thrum_folder_real_path(start), *file = thrum_folder_real_path(path);
  char *end = first ? strrchr(first, '/') : NULL;
  if (end)
    end[1] = '\0';

  // an access that fails says why where the file is opened
  const bool stays =
      file ? is_below(folder, file) || is_below(first, file) : access(path, F_OK) != 0;
  free(named);
  free(folder);
  free(first);
  free(file);
  return stays;
}

/* The path of a file: beside the file of that index, or absolute; NULL: no memory. */
static char *included_path(thrum_included_files *included, int beside, thrum_word name) {
  const char *from = included->files[beside].path, *slash = strrchr(from, '/');
  const size_t folder = slash && name.text[0] != '/' ? (size_t)(slash - from) + 1 : 0;
  char *path = thrum_scope_allocate(&included->paths, (int64_t)(folder + name.length + 1), 1);
  if (path) {
    memcpy(path, from, folder);
    memcpy(path + folder, name.text, name.length);
  }
  return path;
}

/* Refuses a name of two files. Other programs look for it beside the first file, wherever it
 * stands. */
static thrum_status check_one_file(thrum_included_files *included, const char *keyword,
                                   thrum_word name, const char *path) {
  const char *other = included_path(included, 0, name);
  THRUM_TRY(included->paths.status);
  struct stat here, there;
  if (strcmp(path, other) == 0 || stat(path, &here) != 0 || stat(other, &there) != 0 ||
      (here.st_dev == there.st_dev && here.st_ino == there.st_ino))
    return THRUM_OK;
  return thrum_text_fail(thrum_included_text(included), THRUM_UNSUPPORTED,
                         "%s may mean '%.80s' or '%.80s'; give one of them another name", keyword,
                         path, other);
}

thrum_status thrum_included_open(thrum_included_files *included, const char *keyword,
                                 thrum_word name) {
  const thrum_text *text = thrum_included_text(included);
  if (name.length == 0)
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "%s names no file", keyword);
  if (memchr(name.text, 0, name.length))
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "%s names no proper file", keyword);
  const char *path = included_path(included, included->current, name);
  THRUM_TRY(included->paths.status);

  // a mesh from elsewhere must not have any file of the machine read, and its lines shown
  if ((leaves_folder(name) || !stays_in_folder(included, path)) && !is_allowed(path))
    return thrum_text_fail(text, THRUM_UNSUPPORTED,
                           "%s leads out of the folder of this file: put the included file beside "
                           "it, or set THRUM_INCLUDES to the folder that it may come from",
                           keyword);
  THRUM_TRY(check_cycle(included, keyword, path));
  THRUM_TRY(check_one_file(included, keyword, name, path));

  // it is read before the next line of the file that names it
  thrum_text *next = &included->files[included->count].text;
  THRUM_TRY(thrum_text_open(path, included->comment, included->separator, next, text->error));
  included->size += next->stop - next->next;
  note_file(included, path, included->current);
  return THRUM_OK;
}

bool thrum_included_next_line(thrum_included_files *included) {
  while (!thrum_text_next_line(thrum_included_text(included))) {
    // behind the end of a file the one that took it in continues
    if (included->files[included->current].parent < 0)
      return false;
    included->current = included->files[included->current].parent;
  }
  return true;
}
