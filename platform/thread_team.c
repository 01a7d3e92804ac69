/* Threads that stay: each waits for the next piece of work, and takes indices until none is left.
 * SPDX-License-Identifier: Apache-2.0 */
#include "platform/thread_team.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

typedef struct team_thread {
  thrum_thread_team *team;
  pthread_t thread;
  int32_t worker;
} team_thread;

struct thrum_thread_team {
  pthread_mutex_t mutex; /* of all below */
  pthread_cond_t begins, ends;
  void (*task)(void *of, int32_t index, int32_t worker);
  void *of;
  int32_t count, next, running; /* tasks, the next one, those that run */
  bool over;
  int32_t threads;
  team_thread *list;
};

/* Takes tasks until none is left; the mutex is held, but for the time of a task. */
static void work(thrum_thread_team *team, int32_t worker) {
  while (team->next < team->count) {
    const int32_t index = team->next++;
    team->running++;
    pthread_mutex_unlock(&team->mutex);
    team->task(team->of, index, worker);
    pthread_mutex_lock(&team->mutex);
    team->running--;
  }
  if (team->running == 0)
    pthread_cond_signal(&team->ends);
}

static void *live(void *context) {
  const team_thread *own = context;
  thrum_thread_team *team = own->team;
  pthread_mutex_lock(&team->mutex);
  while (!team->over) {
    if (team->next < team->count)
      work(team, own->worker);
    else
      pthread_cond_wait(&team->begins, &team->mutex);
  }
  pthread_mutex_unlock(&team->mutex);
  return NULL;
}

thrum_status thrum_thread_team_make(int32_t workers, thrum_thread_team **made, thrum_error *error) {
  thrum_thread_team *team = calloc(1, sizeof *team);
  team_thread *list = calloc((size_t)(workers > 1 ? workers : 1), sizeof *list);
  if (team == NULL || list == NULL) {
    free(team);
    free(list);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %d threads", (int)workers);
  }
  pthread_mutex_init(&team->mutex, NULL);
  pthread_cond_init(&team->begins, NULL);
  pthread_cond_init(&team->ends, NULL);
  team->list = list;

  // the caller's thread works too, so a thread that cannot be had costs time and nothing else
  for (int32_t n = 1; n < workers && n < THRUM_TEAM_MAX; n++) {
    team_thread *own = list + team->threads;
    *own = (team_thread){.team = team, .worker = n};
    if (pthread_create(&own->thread, NULL, live, own) == 0)
      team->threads++;
  }
  *made = team;
  return THRUM_OK;
}

void thrum_thread_team_run(void *context, int32_t count,
                           void (*task)(void *of, int32_t index, int32_t worker), void *of) {
  thrum_thread_team *team = context;
  pthread_mutex_lock(&team->mutex);
  team->task = task;
  team->of = of;
  team->next = 0;
  team->count = count;
  pthread_cond_broadcast(&team->begins);
  work(team, 0);
  while (team->running > 0)
    pthread_cond_wait(&team->ends, &team->mutex);
  pthread_mutex_unlock(&team->mutex);
}

void thrum_thread_team_free(thrum_thread_team *team) {
  if (team == NULL)
    return;
  pthread_mutex_lock(&team->mutex);
  team->over = true;
  pthread_cond_broadcast(&team->begins);
  pthread_mutex_unlock(&team->mutex);
  for (int32_t n = 0; n < team->threads; n++)
    pthread_join(team->list[n].thread, NULL);
  pthread_cond_destroy(&team->begins);
  pthread_cond_destroy(&team->ends);
  pthread_mutex_destroy(&team->mutex);
  free(team->list);
  free(team);
}
