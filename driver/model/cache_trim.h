/* A folder of files that can be made again is kept from growing without end.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_CACHE_TRIM_H
#define THRUM_DRIVER_MODEL_CACHE_TRIM_H

#include <stdint.h>

/* Removes files of the folder whose names begin with `prefix`, the longest unchanged first, until
 * the others have `bytes_most` together at most. Files changed in the last `seconds` stay, since
 * another program may be about to read them. What cannot be read or removed is left alone: a cache
 * that is too large harms no run. */
void cache_trim(const char *folder, const char *prefix, int64_t bytes_most, int64_t seconds);

#endif
