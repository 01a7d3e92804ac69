/* Time and memory of this process. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_CLOCK_H
#define THRUM_PLATFORM_CLOCK_H

/* Wall clock [s] from a monotonic clock, and the peak resident memory [2^20 bytes]. */
double clock_seconds(void);
double clock_peak_mb(void);

#endif
