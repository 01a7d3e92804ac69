/* Models with their titles, for an archive. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_VIEW_VIEW_ARCHIVE_LIST_H
#define THRUM_APP_VIEW_VIEW_ARCHIVE_LIST_H

#include "app/view/view_archive.h"

#define VIEW_TITLE_MAX 64

typedef struct view_archive_list {
  view_archive_model *items; /* owned, as the titles are; the models are not */
  char (*titles)[VIEW_TITLE_MAX];
  int64_t count;
} view_archive_list;

/* Room for so many models; view_archive_list_free frees, whatever came back. */
thrum_status view_archive_list_make(int64_t room, view_archive_list *list, thrum_error *error);
void view_archive_list_free(view_archive_list *list);

/* Adds a model, which is called by its file's name without the ending, or by one of our names with
 * a capital. `name` must outlive the list. */
view_archive_model *view_archive_list_add(view_archive_list *list, const char *name,
                                          const thrum_model *model);

#endif
