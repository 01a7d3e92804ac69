/* See program.h. SPDX-License-Identifier: Apache-2.0 */
#define _GNU_SOURCE // posix_spawn_file_actions_addchdir_np
#include "platform/program.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define PATH_MAX_HERE 1024

extern char **environ;

/* Input, outputs and folder of the program. */
static int set_files(const program_place *place, posix_spawn_file_actions_t *files) {
  const char *log = place->log != NULL ? place->log : "/dev/null";
  int number = posix_spawn_file_actions_addopen(files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (number == 0 && place->messages)
    number = posix_spawn_file_actions_adddup2(files, STDERR_FILENO, STDOUT_FILENO);
  else if (number == 0)
    number = posix_spawn_file_actions_addopen(files, STDOUT_FILENO, log,
                                              O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (number == 0 && !place->messages)
    number = posix_spawn_file_actions_adddup2(files, STDOUT_FILENO, STDERR_FILENO);
  if (number == 0 && place->folder != NULL)
    number = posix_spawn_file_actions_addchdir_np(files, place->folder);
  return number;
}

/* Signal mask and process group of the program. */
static int set_attributes(const program_place *place, posix_spawnattr_t *attributes) {
  const int flags = (place->signals != NULL ? POSIX_SPAWN_SETSIGMASK : 0) |
                    (place->own_group ? POSIX_SPAWN_SETPGROUP : 0);
  int number = posix_spawnattr_setflags(attributes, (short)flags);
  if (number == 0 && place->signals != NULL)
    number = posix_spawnattr_setsigmask(attributes, place->signals);
  return number;
}

int program_start(char *const *argv, const program_place *place, pid_t *child) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  int number = posix_spawn_file_actions_init(&files);
  if (number != 0)
    return number;

  // the attributes exist only where their making succeeded
  number = posix_spawnattr_init(&attributes);
  if (number == 0) {
    number = set_files(place, &files);
    if (number == 0)
      number = set_attributes(place, &attributes);
    if (number == 0)
      number = posix_spawnp(child, argv[0], &files, &attributes, argv, environ);
    posix_spawnattr_destroy(&attributes);
  }
  posix_spawn_file_actions_destroy(&files);
  return number;
}

bool program_run(char *const *argv, const program_place *place) {
  pid_t child;
  if (program_start(argv, place, &child) != 0)
    return false;

  // a signal to this program alone must not lose track of the child
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR)
      return false;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool program_exists(const char *name) {
  const char *at = getenv("PATH");
  while (at != NULL && *at != 0) {
    char path[PATH_MAX_HERE];
    const size_t length = strcspn(at, ":");
    if (length > 0 && length < sizeof path - 64) {
      snprintf(path, sizeof path, "%.*s/%.60s", (int)length, at, name);
      if (access(path, X_OK) == 0)
        return true;
    }
    at += length + (at[length] == ':');
  }
  return false;
}
