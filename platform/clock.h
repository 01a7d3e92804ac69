/* Time and memory of this process. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_CLOCK_H
#define THRUM_PLATFORM_CLOCK_H

/* Wall clock [s] from a monotonic clock. */
double clock_seconds(void);
/* The time that the processor has given this process, and this thread [s]: what other programs do
 * on a busy machine does not count. */
double clock_process_seconds(void);
double clock_thread_seconds(void);

/* Peak resident memory [2^20 bytes]. */
double clock_peak_mb(void);

#endif
