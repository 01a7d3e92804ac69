/* See temp_folder.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/temp_folder.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "platform/program.h"

/* Holds back the signals that would end this program; one that is ignored (nohup) stays ignored. */
static void hold_signals(temp_folder *temp) {
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
  sigemptyset(&temp->held);
  for (size_t n = 0; n < sizeof signals / sizeof *signals; n++) {
    struct sigaction now;
    if (sigaction(signals[n], NULL, &now) == 0 && now.sa_handler != SIG_IGN)
      sigaddset(&temp->held, signals[n]);
  }
  sigprocmask(SIG_BLOCK, &temp->held, &temp->before);
}

thrum_status temp_folder_open(temp_folder *temp, thrum_error *error) {
  const char *parent = getenv("TMPDIR");
  if (parent == NULL || parent[0] != '/' || strlen(parent) > TEMP_FOLDER_PATH_MAX - 128)
    parent = "/tmp";

  *temp = (temp_folder){.stopped = 0};
  snprintf(temp->folder, sizeof temp->folder, "%s/thrum-XXXXXX", parent);
  hold_signals(temp);

  // the signals go back to what they were when there is no folder to remove
  if (mkdtemp(temp->folder) != NULL)
    return THRUM_OK;
  const int number = errno;
  sigprocmask(SIG_SETMASK, &temp->before, NULL);
  return thrum_error_set(error, THRUM_IO, "%.200s: no temporary folder can be made there: %s",
                         parent, strerror(number));
}

void temp_folder_path(const temp_folder *temp, const char *name, char path[TEMP_FOLDER_PATH_MAX]) {
  snprintf(path, TEMP_FOLDER_PATH_MAX, "%.900s/%.100s", temp->folder, name);
}

thrum_status temp_folder_run(temp_folder *temp, char *const *argv, const char *log,
                             temp_folder_end *end, thrum_error *error) {
  static const struct timespec while_waiting = {0, 20000000};
  char path[TEMP_FOLDER_PATH_MAX];
  pid_t child = 0, ended = 0;
  int state = 0;
  temp_folder_path(temp, log, path);

  // a process group of its own, so that all that it starts can be ended, and the signals as they
  // were before the folder was opened
  const program_place place = {.log = path, .own_group = true, .signals = &temp->before};
  const int number = program_start(argv, &place, &child);
  if (number != 0)
    return thrum_error_set(error, THRUM_IO, "%.200s cannot be started: %s", argv[0],
                           strerror(number));

  // between looks at the program, wait for a signal: one that comes ends the whole group
  while ((ended = waitpid(child, &state, WNOHANG)) == 0 || (ended < 0 && errno == EINTR)) {
    const int came = sigtimedwait(&temp->held, NULL, &while_waiting);
    if (came <= 0)
      continue;
    temp->stopped = came;
    kill(-child, SIGKILL);
    while (waitpid(child, &state, 0) < 0 && errno == EINTR)
      continue;
    return thrum_error_set(error, THRUM_IO, "%.200s was stopped", argv[0]);
  }

  if (ended < 0)
    return thrum_error_set(error, THRUM_IO, "%.200s: %s", argv[0], strerror(errno));
  end->code = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
  end->signal = WIFSIGNALED(state) ? WTERMSIG(state) : 0;
  return THRUM_OK;
}

void temp_folder_close(temp_folder *temp) {
  DIR *folder = opendir(temp->folder);
  const struct dirent *entry;
  while (folder != NULL && (entry = readdir(folder)) != NULL) {
    char path[TEMP_FOLDER_PATH_MAX];
    temp_folder_path(temp, entry->d_name, path);
    if (entry->d_name[0] != '.')
      unlink(path);
  }

  if (folder != NULL)
    closedir(folder);
  rmdir(temp->folder);

  // with the folder gone, the signal may end this program as it would have
  if (temp->stopped != 0) {
    fputs("\nthrum: stopped; nothing was written\n", stderr);
    signal(temp->stopped, SIG_DFL);
    raise(temp->stopped);
  }
  sigprocmask(SIG_SETMASK, &temp->before, NULL);
}
