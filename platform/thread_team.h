/* Threads that stay, for work that comes in small parts. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_THREAD_TEAM_H
#define THRUM_PLATFORM_THREAD_TEAM_H

#include <stdint.h>

#include "thrum/status.h"

#define THRUM_TEAM_MAX 256

typedef struct thrum_thread_team thrum_thread_team;

/* A team of `workers` (1 to THRUM_TEAM_MAX), the calling thread among them; threads that cannot be
 * had are missing from it. The caller passes it to thrum_thread_team_free. */
thrum_status thrum_thread_team_make(int32_t workers, thrum_thread_team **team, thrum_error *error);

/* Does `task` once for each index from 0 below `count` and returns when all are done. `worker` is 0
 * or more and below the team's workers; no two tasks that run at the same time have the same. Of
 * the type of thrum_scene_run, with a team as its context. */
void thrum_thread_team_run(void *team, int32_t count,
                           void (*task)(void *of, int32_t index, int32_t worker), void *of);

/* Ends the threads; NULL does nothing. */
void thrum_thread_team_free(thrum_thread_team *team);

#endif
