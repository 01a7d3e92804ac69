/* Finds the viewer's page and puts an archive into it. SPDX-License-Identifier: Apache-2.0 */
#include "app/view/viewer_page.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "io/base64.h"
#include "io/file.h"
#include "io/paths.h"
#include "thrum/thrum.h"

#define PATH_MAX_BYTES 1024
#define PAGE "viewer.html"
#define SLOT_BEGIN "<script type=\"application/octet-stream\" id=\"thrum-pack\""
#define SLOT_END "</script>"

static bool is_file(const char *path) {
  struct stat status;
  return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

/* The page's path; NULL where there is none. */
static const char *find_page(char path[PATH_MAX_BYTES]) {
  const char *given = getenv("THRUM_VIEWER");
  if (given != NULL && given[0] != 0)
    return given;
  if (path_share(PAGE, path, PATH_MAX_BYTES) && is_file(path))
    return path;
#ifdef THRUM_BUILT_VIEWER
  if (is_file(THRUM_BUILT_VIEWER))
    return THRUM_BUILT_VIEWER;
#endif
  return NULL;
}

void viewer_page_free(viewer_page *page) {
  free(page->html);
  *page = (viewer_page){0};
}

thrum_status viewer_page_read(viewer_page *page, thrum_error *error) {
  char own[PATH_MAX_BYTES];
  const char *path = find_page(own);
  void *html = NULL;
  viewer_page read = {0};
  if (path == NULL)
    return thrum_error_set(
        error, THRUM_MISSING,
        "the viewer was not built: ./run viewer does it, or install clang lld wasi-libc "
        "libclang-rt-14-dev-wasm32 nodejs npm and build the target viewer; THRUM_VIEWER may name a "
        "viewer.html from elsewhere");

  THRUM_TRY(thrum_file_read(path, &html, &read.size, error));
  read.html = html;

  // the element that takes the archive
  read.slot = strstr(read.html, SLOT_BEGIN);
  read.slot_end = read.slot != NULL ? strstr(read.slot, SLOT_END) : NULL;
  if (read.slot_end == NULL) {
    viewer_page_free(&read);
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%.300s: not the page of the viewer, for it has no place for an archive",
                           path);
  }
  read.slot_end += sizeof SLOT_END - 1;
  *page = read;
  return THRUM_OK;
}

thrum_status viewer_page_write(const char *path, const viewer_page *page,
                               const view_archive *archive, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  FILE *stream = writer.stream;
  fwrite(page->html, 1, (size_t)(page->slot - page->html), stream);
  fputs(SLOT_BEGIN ">", stream);
  thrum_base64 text = {.stream = stream};
  thrum_base64_put(&text, archive->bytes, archive->size);
  thrum_base64_end(&text);
  fputs(SLOT_END, stream);
  fwrite(page->slot_end, 1, (size_t)(page->html + page->size - page->slot_end), stream);
  return thrum_file_writer_commit(&writer, error);
}
