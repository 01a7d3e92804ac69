/* The viewer's page, viewer.html. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_VIEW_VIEWER_PAGE_H
#define THRUM_APP_VIEW_VIEWER_PAGE_H

#include <stddef.h>

#include "app/view/view_archive.h"

typedef struct cli_page {
  char *html; /* malloc, size bytes and a 0; cli_page_free frees */
  size_t size;
  const char *slot; /* where in html the element of a pack begins and ends */
  const char *slot_end;
} cli_page;

/* Reads the page that THRUM_VIEWER names, else the installed one, else the one of this build.
 * THRUM_MISSING, with how to come by one, where there is none. */
thrum_status cli_page_read(cli_page *page, thrum_error *error);
void cli_page_free(cli_page *page);

/* Writes one file that shows the pack when it is opened from the disk: the page with the pack in
 * base64 (RFC 4648) in its element. */
thrum_status cli_page_write(const char *path, const cli_page *page, const cli_pack *pack,
                            thrum_error *error);

#endif
