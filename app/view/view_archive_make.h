/* The archive of models or of a scene that `thrum view` shows. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_APP_VIEW_VIEW_ARCHIVE_MAKE_H
#define THRUM_APP_VIEW_VIEW_ARCHIVE_MAKE_H

#include <stdbool.h>

#include "app/view/view_archive.h"

#define VIEW_MODELS_MAX 64

/* Loads models, by their files or names (precomputing those that are not cached), and puts them in
 * a scene of the first; or reads the one scene file that is named, with the models it names. It
 * warns about anything in a scene that the viewer leaves out. `surface`: shown in place of the own
 * surface of the one model that is named (driver/export/render_mesh.h); NULL: none. */
thrum_status view_archive_of_names(const char *const *names, int64_t count, const char *surface,
                                   bool quiet, view_archive *archive, thrum_error *error);

#endif
