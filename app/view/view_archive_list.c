/* Models with their titles, for an archive. SPDX-License-Identifier: Apache-2.0 */
#include "app/view/view_archive_list.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/make/named_model.h"
#include "io/paths.h"
#include "platform/allocate.h"

/* A file's name without its ending, or one of our names with a capital. */
static void make_title(const char *name, char title[VIEW_TITLE_MAX]) {
  const char *base = path_basename(name), *dot = strrchr(base, '.');
  const size_t length = dot != NULL && dot > base ? (size_t)(dot - base) : strlen(base);
  snprintf(title, VIEW_TITLE_MAX, "%.*s",
           (int)(length < VIEW_TITLE_MAX ? length : VIEW_TITLE_MAX - 1), base);
  for (int n = 0; n < MODEL_NAME_COUNT; n++)
    if (strcmp(name, model_names[n]) == 0)
      title[0] = (char)toupper(title[0]);
}

thrum_status view_archive_list_make(int64_t room, view_archive_list *list, thrum_error *error) {
  THRUM_TRY(thrum_reserve(&list->items, room, sizeof *list->items, "the models", error));
  return thrum_reserve(&list->titles, room, sizeof *list->titles, "the models", error);
}

void view_archive_list_free(view_archive_list *list) {
  free(list->items);
  free(list->titles);
}

view_archive_model *view_archive_list_add(view_archive_list *list, const char *name,
                                          const thrum_model *model) {
  view_archive_model *item = &list->items[list->count];
  make_title(name, list->titles[list->count]);
  *item = (view_archive_model){
      .name = path_basename(name), .title = list->titles[list->count++], .model = model};
  return item;
}
