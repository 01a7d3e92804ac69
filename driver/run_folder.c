/* The RUN folder: complete or not there at all, and never in place of the user's other files.
 *
 * A run is written into a work folder of its own and moved at the end. An earlier run is known by
 * its run.json, which says that it is one. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run_folder.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/file.h"
#include "platform/interrupt.h"

#define WORK_MARK "partial-"
#define WORK_TRIES 1000

/* The files of a run but run.json, which says that the others are complete. */
static const char *const run_files[] = {"energy.csv", "q.npy",      "end.npy",   RUN_PLACEMENTS,
                                        "energy.png", "energy.svg", "frames.pvd"};
enum { RUN_FILE_COUNT = sizeof run_files / sizeof run_files[0] };

typedef char path_text[RUN_PATH_MAX + 300];

static void join(path_text path, const char *folder, const char *name) {
  snprintf(path, sizeof(path_text), "%s/%s", folder, name);
}

static bool is_frame(const char *name) {
  const size_t length = strlen(name);
  return strncmp(name, "frame_", 6) == 0 && length > 10 && strcmp(name + length - 4, ".vtu") == 0;
}

bool run_folder_holds(const char *path, const char *mark) {
  path_text file;
  void *text = NULL;
  size_t size = 0;
  join(file, path, mark);
  if (thrum_file_read(file, &text, &size, NULL) < 0)
    return false;

  // the program and the command in the file mark it as a run
  cJSON *object = cJSON_ParseWithLength(text, size);
  const cJSON *program = cJSON_GetObjectItemCaseSensitive(object, "program");
  const cJSON *command = cJSON_GetObjectItemCaseSensitive(object, "command");
  const bool ours = cJSON_IsString(program) && strcmp(program->valuestring, "thrum") == 0 &&
                    cJSON_IsString(command) && strcmp(command->valuestring, "simulate") == 0;

  cJSON_Delete(object);
  free(text);
  return ours;
}

/* Whether a folder is empty, but for what a killed run left. */
static bool is_empty(const char *path) {
  DIR *entries = opendir(path);
  if (entries == NULL)
    return false;
  bool empty = true;
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
    const char *name = entry->d_name;
    if (strcmp(name, ".") != 0 && strcmp(name, "..") != 0 &&
        strncmp(name, "." WORK_MARK, sizeof "." WORK_MARK - 1) != 0)
      empty = false;
  }
  closedir(entries);
  return empty;
}

/* Refuses a path where files of another origin stand; sets folder->existed. */
static thrum_status look_at(run_folder *folder, const char *mark, thrum_error *error) {
  struct stat status;
  const char *path = folder->path;
  folder->existed = stat(path, &status) == 0;

  // a link to nothing cannot become a folder
  if (!folder->existed) {
    if (errno != ENOENT || lstat(path, &status) == 0) {
      return thrum_error_set(error, THRUM_IO, "%.300s: cannot be used as the run's folder (%s)",
                             path, errno == ENOENT ? "a link to nothing" : strerror(errno));
    }
    return THRUM_OK;
  }

  // only an empty folder or an earlier run may be replaced
  if (!S_ISDIR(status.st_mode)) {
    return thrum_error_set(
        error, THRUM_IO, "%.300s: is a file; -o names the folder that the run is written to", path);
  }
  if (!is_empty(path) && !run_folder_holds(path, mark)) {
    return thrum_error_set(error, THRUM_IO,
                           "%.300s: holds files that are no earlier run; choose another -o", path);
  }
  return THRUM_OK;
}

thrum_status run_folder_open(const char *path, const char *mark, run_folder *folder,
                             thrum_error *error) {
  run_folder opened = {0};

  // slashes at the end are no part of the name
  size_t length = strlen(path);
  while (length > 1 && path[length - 1] == '/')
    length--;

  if (length == 0)
    return thrum_error_set(error, THRUM_IO, "-o: the run's folder needs a name");
  if (length >= sizeof opened.path)
    return thrum_error_set(error, THRUM_IO, "-o: the run's folder needs a name below %zu bytes",
                           sizeof opened.path);

  memcpy(opened.path, path, length);
  THRUM_TRY(look_at(&opened, mark, error));

  // a killed run may have left its work folder under the same process number: count on
  int made = -1;
  for (int count = 0; made != 0 && count < WORK_TRIES; count++) {
    snprintf(opened.work, sizeof opened.work, "%s%s" WORK_MARK "%ld-%d", opened.path,
             opened.existed ? "/." : ".", (long)getpid(), count);
    made = mkdir(opened.work, 0777);
    if (made != 0 && errno != EEXIST)
      break;
  }

  if (made != 0) {
    const int reason = errno;
    return thrum_error_set(error, THRUM_IO, "%.200s: cannot be created (%s)%s", opened.path,
                           strerror(reason), thrum_file_hint(reason));
  }

  *folder = opened;
  return THRUM_OK;
}

/* The frames of a run in `from`: removed when `to` is NULL, else moved there. */
static bool sweep_frames(const char *from, const char *to) {
  path_text source, target, file, moved;
  join(source, from, RUN_FRAMES);
  DIR *entries = opendir(source);
  if (entries == NULL)
    return errno == ENOENT || errno == ENOTDIR;

  // the target's own frames folder may be there already
  bool done = true;
  if (to != NULL) {
    join(target, to, RUN_FRAMES);
    done = mkdir(target, 0777) == 0 || errno == EEXIST;
  }

  // only names of frames are touched, so files of the user's stay
  for (const struct dirent *entry = readdir(entries); done && entry != NULL;
       entry = readdir(entries)) {
    if (!is_frame(entry->d_name))
      continue;
    snprintf(file, sizeof file, "%.*s/%.255s", RUN_PATH_MAX + 20, source, entry->d_name);
    if (to != NULL)
      snprintf(moved, sizeof moved, "%.*s/%.255s", RUN_PATH_MAX + 20, target, entry->d_name);
    done = to != NULL ? rename(file, moved) == 0 : unlink(file) == 0;
  }

  // a folder that holds anything else is not removed
  closedir(entries);
  rmdir(source);
  return done;
}

/* All files of a run but run.json, the same way. */
static bool sweep(const char *from, const char *to) {
  path_text file, moved;
  bool done = sweep_frames(from, to);

  // files that a run did not write are no failure
  for (int n = 0; n < RUN_FILE_COUNT; n++) {
    join(file, from, run_files[n]);
    if (to != NULL)
      join(moved, to, run_files[n]);
    if ((to != NULL ? rename(file, moved) : unlink(file)) != 0 && errno != ENOENT)
      done = false;
  }
  return done;
}

bool run_folder_sweep(const char *from, const char *to) {
  path_text old_json, new_json;
  join(old_json, from, RUN_JSON);
  if (to == NULL) {
    const bool gone = unlink(old_json) == 0 || errno == ENOENT;
    return sweep(from, NULL) && gone;
  }
  join(new_json, to, RUN_JSON);
  return sweep(from, to) && rename(old_json, new_json) == 0;
}

thrum_status run_folder_commit(run_folder *folder, thrum_error *error) {
  bool done = true;

  // an earlier run is removed just before the new one takes its place
  if (folder->existed) {
    done = run_folder_sweep(folder->path, NULL) && run_folder_sweep(folder->work, folder->path) &&
           rmdir(folder->work) == 0;
  } else {
    done = rename(folder->work, folder->path) == 0;
  }

  if (!done) {
    return thrum_error_set(error, THRUM_IO, "%.300s: the run could not be put there (%s)",
                           folder->path, strerror(errno));
  }
  folder->work[0] = 0;
  return THRUM_OK;
}

void run_folder_abandon(run_folder *folder) {
  if (folder->work[0] == 0)
    return;
  run_folder_sweep(folder->work, NULL);
  rmdir(folder->work);
  folder->work[0] = 0;
}

thrum_status run_folder_check(const char *path, const char *mark, thrum_error *error) {
  run_folder folder = {0};
  // a signal that ends the program in between would leave the folder
  thrum_interrupt_hold();
  const thrum_status status = run_folder_open(path, mark, &folder, error);
  run_folder_abandon(&folder);
  thrum_interrupt_let();
  return status;
}
