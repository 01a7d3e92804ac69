/* How much memory there is to be had. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_MEMORY_LIMIT_H
#define THRUM_PLATFORM_MEMORY_LIMIT_H

/* Bytes that this process may still take before the machine (MemAvailable), its control group or
 * its own address space (RLIMIT_AS) is exhausted, whichever comes first; *what, which may be NULL,
 * gets the name of that one, static storage. INFINITY where nothing can be learned. */
double thrum_memory_available(const char **what);

/* Bytes that this process holds now: resident. */
double thrum_memory_resident(void);

#endif
