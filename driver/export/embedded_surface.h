/* Surfaces embedded in a model's mesh, as commands take them.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_EXPORT_EMBEDDED_SURFACE_H
#define THRUM_DRIVER_EXPORT_EMBEDDED_SURFACE_H

#include "precompute/embed.h"

/* Reads the surface file (.obj, .stl) and embeds it in the model; `model_name` is for meta. A bar
 * appears where it takes long, unless quiet. */
thrum_status embedded_surface_make(const thrum_model *model, const char *model_name,
                                   const char *path, double scale, bool quiet, thrum_embed *embed,
                                   thrum_error *error);

/* Warns of what lies outside the mesh; true when it is so far that scale or place are in doubt. */
bool embedded_surface_warn(const thrum_embed_report *report, const char *path);

#endif
