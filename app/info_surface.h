/* `thrum info` of an embedded surface. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_INFO_SURFACE_H
#define THRUM_APP_INFO_SURFACE_H

#include <stdbool.h>

/* Says what the surface file at `path` holds; false, and nothing is said, when it is none. */
bool info_surface(const char *path, bool json);

#endif
