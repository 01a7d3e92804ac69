/* Version of the library. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VERSION_H
#define THRUM_VERSION_H

#define THRUM_VERSION_MAJOR 0
#define THRUM_VERSION_MINOR 2
#define THRUM_VERSION_PATCH 0
#define THRUM_VERSION_STRING "0.2.0"

#include "thrum/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Version of the linked library as "major.minor.patch"; static storage. Any thread. */
THRUM_API const char *thrum_version(void);

#ifdef __cplusplus
}
#endif
#endif
