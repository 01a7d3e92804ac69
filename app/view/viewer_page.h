/* The viewer's page, viewer.html. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_VIEW_VIEWER_PAGE_H
#define THRUM_APP_VIEW_VIEWER_PAGE_H

#include <stddef.h>

#include "app/view/view_archive.h"

typedef struct viewer_page {
  char *html; /* malloc, size bytes and a 0; viewer_page_free frees */
  size_t size;
  const char *slot; /* where in html the element of an archive begins and ends */
  const char *slot_end;
} viewer_page;

/* Reads the page that THRUM_VIEWER names, else the installed one, else the one of this build.
 * THRUM_MISSING, with how to come by one, where there is none. */
thrum_status viewer_page_read(viewer_page *page, thrum_error *error);
void viewer_page_free(viewer_page *page);

/* Writes one file that shows the archive when it is opened from the disk: the page with the archive
 * in base64 (RFC 4648) in its element. */
thrum_status viewer_page_write(const char *path, const viewer_page *page,
                               const view_archive *archive, thrum_error *error);

#endif
