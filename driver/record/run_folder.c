/* The folder of a run: opened, put in place, or given up (run_folder.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/run_folder.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "config/message.h"
#include "io/file.h"
#include "platform/folder_swap.h"
#include "platform/interrupt.h"

/* These endings follow RUN in the names of the work folder, of an earlier run while there is no way
 * to exchange two folders in one step, and of a run that could not be put in place. */
#define WORK_END ".thrum-partial"
#define SPARE_END ".thrum-earlier"
#define NEW_END ".new-"

#define STREAM_BUFFER (1 << 18) /* of each series; a row then rarely costs a system call */
#define LOCK_TRIES 100
#define NEW_TRIES 1000

static void name_spare(const run_folder *folder, char spare[RUN_PATH_MAX]) {
  snprintf(spare, RUN_PATH_MAX, "%s" SPARE_END, folder->path);
}

/* --- opening ---------------------------------------------------------------------------------- */

static bool ends_in(const char *path, const char *end) {
  const size_t length = strlen(path), size = strlen(end);
  return length >= size && strcmp(path + length - size, end) == 0;
}

/* The path without slashes at its end, and without links where RUN is there. */
static thrum_status take_path(run_folder *folder, const char *path, thrum_error *error) {
  size_t length = strlen(path);
  while (length > 1 && path[length - 1] == '/')
    length--;
  if (length == 0)
    return thrum_error_set(error, THRUM_IO, "-o: the run's folder needs a name");
  if (length >= sizeof folder->path)
    return thrum_error_set(error, THRUM_IO, "-o: the run's folder needs a name below %zu bytes",
                           sizeof folder->path);
  memcpy(folder->path, path, length);
  folder->path[length] = 0;

  // those names are the program's own
  if (ends_in(folder->path, WORK_END) || ends_in(folder->path, SPARE_END))
    return thrum_error_set(error, THRUM_IO, "%.300s: such a name is for runs in the making",
                           folder->path);

  // a link and "." stay as they are, and what they lead to is exchanged
  struct stat status;
  if (stat(folder->path, &status) != 0) {
    const int reason = errno;
    if (reason != ENOENT || lstat(folder->path, &status) == 0)
      return thrum_error_set(error, THRUM_IO, "%.300s: cannot be used as the run's folder (%s)",
                             folder->path,
                             reason == ENOENT ? "a link to nothing" : strerror(reason));
    return THRUM_OK;
  }

  // the folder that is there is known by its real path from here on
  char *real = thrum_folder_real_path(folder->path);
  const bool fits = real != NULL && strlen(real) < sizeof folder->path;
  if (fits)
    strcpy(folder->path, real);
  free(real);
  return fits ? THRUM_OK
              : thrum_error_set(error, THRUM_IO, "%.300s: cannot be used as the run's folder (%s)",
                                folder->path, strerror(ENAMETOOLONG));
}

/* Makes and locks the work folder, or takes over that of a killed process. */
static thrum_status lock_work(run_folder *folder, thrum_error *error) {
  for (int attempt = 0; attempt < LOCK_TRIES; attempt++) {
    if (mkdir(folder->work, 0777) != 0 && errno != EEXIST) {
      const int reason = errno;
      return thrum_error_set(error, THRUM_IO, "%.200s: cannot be created (%s)%s", folder->path,
                             strerror(reason), thrum_file_hint(reason));
    }
    folder->lock = thrum_folder_lock(folder->work);
    if (folder->lock < 0 && errno == EWOULDBLOCK)
      return thrum_error_set(error, THRUM_IO,
                             "%.300s: another process is writing a run there; choose another -o",
                             folder->path);
    if (folder->lock < 0 && errno != ENOENT)
      return thrum_error_set(error, THRUM_IO,
                             "%.300s: cannot be locked (%s); remove it where no process uses it",
                             folder->work, strerror(errno));

    // the folder may have been removed between making and locking it
    struct stat locked, there;
    if (folder->lock >= 0 && fstat(folder->lock, &locked) == 0 && stat(folder->work, &there) == 0 &&
        locked.st_dev == there.st_dev && locked.st_ino == there.st_ino)
      return THRUM_OK;
    if (folder->lock >= 0)
      close(folder->lock);
  }
  return thrum_error_set(error, THRUM_IO, "%.300s: comes and goes; choose another -o",
                         folder->work);
}

/* Removes what a killed process left at `path`, after the user's entries went back to RUN. They are
 * there only where an earlier run was being removed, which has its mark to the last. */
static thrum_status clear_remains(const run_folder *folder, const char *path, thrum_error *error) {
  struct stat status;
  if (stat(path, &status) != 0 || run_entries_none(path))
    return THRUM_OK;
  const run_kind kind = run_entries_marked(path, RUN_OF_SCENE) ? RUN_OF_SCENE : RUN_OF_BODY;
  if (run_entries_marked(path, kind) && stat(folder->path, &status) == 0)
    THRUM_TRY(run_entries_keep(path, folder->path, kind, error));

  // a run in the making has no mark, so it may be of either kind
  THRUM_TRY(run_entries_remove(path, RUN_OF_BODY, error));
  if (stat(path, &status) == 0)
    THRUM_TRY(run_entries_remove(path, RUN_OF_SCENE, error));
  return stat(path, &status) != 0
             ? THRUM_OK
             : thrum_error_set(error, THRUM_IO,
                               "%.300s: holds files that are no run; move them away", path);
}

/* After a process was killed in any place, RUN is the earlier run or the new one again. */
static thrum_status recover(const run_folder *folder, thrum_error *error) {
  char spare[RUN_PATH_MAX];
  struct stat status;
  name_spare(folder, spare);
  if (stat(spare, &status) == 0 && stat(folder->path, &status) != 0 &&
      rename(spare, folder->path) != 0)
    return thrum_error_set(error, THRUM_IO, "%.300s: is an earlier run that cannot be moved (%s)",
                           spare, strerror(errno));
  THRUM_TRY(clear_remains(folder, spare, error));
  return clear_remains(folder, folder->work, error);
}

/* The folder that RUN is in. */
static void parent_of(const run_folder *folder, char parent[RUN_PATH_MAX]) {
  const char *slash = strrchr(folder->path, '/');
  const int length = slash == NULL ? 0 : (int)(slash - folder->path) + 1;
  snprintf(parent, RUN_PATH_MAX, "%.*s.", length, folder->path);
}

/* A folder cannot be exchanged where it is a file system of its own or where we stand. */
static thrum_status check_place(const run_folder *folder, const struct stat *status,
                                thrum_error *error) {
  char parent[RUN_PATH_MAX];
  struct stat above, here;
  parent_of(folder, parent);
  if (stat(parent, &above) == 0 && above.st_dev != status->st_dev)
    return thrum_error_set(error, THRUM_IO,
                           "%.300s: is a file system of its own and cannot be replaced; name a "
                           "folder in it",
                           folder->path);
  if (stat(".", &here) == 0 && here.st_dev == status->st_dev && here.st_ino == status->st_ino)
    return thrum_error_set(error, THRUM_IO,
                           "%.300s: is the folder that the program runs in and cannot be replaced; "
                           "run it elsewhere",
                           folder->path);
  return THRUM_OK;
}

/* Refuses a path where files of another origin stand; sets folder->existed. */
static thrum_status look_at(run_folder *folder, thrum_error *error) {
  struct stat status;
  const char *path = folder->path;
  folder->existed = stat(path, &status) == 0;
  if (!folder->existed)
    return THRUM_OK;

  // only an empty folder or an earlier run may be replaced
  if (!S_ISDIR(status.st_mode))
    return thrum_error_set(
        error, THRUM_IO, "%.300s: is a file; -o names the folder that the run is written to", path);
  THRUM_TRY(run_entries_replaceable(path, folder->kind, error));
  THRUM_TRY(check_place(folder, &status, error));
  return run_entries_check(path, NULL, folder->kind, error);
}

static void unlock(run_folder *folder) {
  if (!folder->inside && folder->lock >= 0)
    close(folder->lock);
  folder->lock = -1;
}

thrum_status run_folder_open(const char *path, run_kind kind, run_folder *folder,
                             thrum_error *error) {
  run_folder opened = {.kind = kind, .lock = -1};
  THRUM_TRY(take_path(&opened, path, error));
  snprintf(opened.work, sizeof opened.work, "%s" WORK_END, opened.path);

  // the lock comes first, so that no other process changes RUN while it is looked at
  THRUM_TRY(lock_work(&opened, error));
  struct stat status;
  thrum_status done = recover(&opened, error);
  if (done >= 0 && stat(opened.work, &status) != 0) {
    // what a killed process had left was the work folder itself
    unlock(&opened);
    THRUM_TRY(lock_work(&opened, error));
  }

  if (done >= 0)
    done = look_at(&opened, error);
  if (done < 0) {
    rmdir(opened.work);
    unlock(&opened);
    return done;
  }
  *folder = opened;
  return THRUM_OK;
}

thrum_status run_folder_open_inside(const char *path, run_folder *folder, thrum_error *error) {
  run_folder opened = {.kind = RUN_OF_BODY, .inside = true, .lock = -1};
  if (snprintf(opened.path, sizeof opened.path, "%s", path) >= (int)sizeof opened.path)
    return thrum_error_set(error, THRUM_IO, "-o: the run's folder needs a name below %zu bytes",
                           sizeof opened.path);
  strcpy(opened.work, opened.path);
  if (mkdir(opened.work, 0777) != 0) {
    const int reason = errno;
    return thrum_error_set(error, THRUM_IO, "%.200s: cannot be created (%s)%s", opened.path,
                           strerror(reason), thrum_file_hint(reason));
  }
  *folder = opened;
  return THRUM_OK;
}

thrum_status run_folder_check(const char *path, run_kind kind, thrum_error *error) {
  run_folder folder = {.lock = -1};
  // a signal that ends the program in between would leave the folder
  thrum_interrupt_hold();
  const thrum_status status = run_folder_open(path, kind, &folder, error);
  run_folder_abandon(&folder);
  thrum_interrupt_let();
  return status;
}

/* --- files ------------------------------------------------------------------------------------ */

FILE *run_folder_create(const run_folder *folder, const char *name) {
  char path[RUN_PATH_MAX + 80];
  snprintf(path, sizeof path, "%s/%.70s", folder->work, name);
  FILE *file = fopen(path, "wb");
  if (file != NULL)
    setvbuf(file, NULL, _IOFBF, STREAM_BUFFER);
  return file;
}

bool run_folder_close_file(FILE **file) {
  FILE *closing = *file;
  *file = NULL;
  if (closing == NULL)
    return true;
  const bool flushed = fflush(closing) == 0 && ferror(closing) == 0 && fsync(fileno(closing)) == 0;
  return fclose(closing) == 0 && flushed;
}

thrum_status run_folder_write_failed(const run_folder *folder, const char *name,
                                     thrum_error *error) {
  const int reason = errno != 0 ? errno : EIO;
  return thrum_error_set(error, THRUM_IO, "%.200s: %s could not be written (%s)%s", folder->path,
                         name, strerror(reason), thrum_file_hint(reason));
}

/* --- putting in place ------------------------------------------------------------------------- */

/* Exchanges RUN and the work folder, and moves what is the user's; both or nothing. */
static thrum_status exchange(run_folder *folder, thrum_error *error) {
  char spare[RUN_PATH_MAX];
  struct stat status;
  name_spare(folder, spare);
  THRUM_TRY(run_entries_check(folder->path, folder->work, folder->kind, error));
  if (stat(folder->path, &status) == 0)
    chmod(folder->work, status.st_mode & 07777);
  const int number = thrum_folder_swap(folder->path, folder->work, spare);
  if (number != 0)
    return thrum_error_set(error, THRUM_IO, "%.300s: cannot be replaced (%s)", folder->path,
                           strerror(number));

  // the earlier run is now at the work folder's name
  const thrum_status kept = run_entries_keep(folder->work, folder->path, folder->kind, error);
  if (kept < 0)
    thrum_folder_swap(folder->path, folder->work, spare);
  return kept;
}

/* Replaces an earlier run, which is locked until it is gone: a process that starts meanwhile would
 * take its folder for what a killed one left. */
static thrum_status replace(run_folder *folder, thrum_error *error) {
  const int earlier = thrum_folder_lock(folder->path);
  if (earlier < 0)
    return thrum_error_set(error, THRUM_IO, "%.300s: cannot be replaced (%s)", folder->path,
                           strerror(errno));
  const thrum_status status = exchange(folder, error);

  // the new run stands; what cannot be removed of the earlier one is no failure of it
  if (status >= 0) {
    thrum_error detail = {0};
    unlock(folder);
    if (run_entries_remove(folder->work, folder->kind, &detail) < 0)
      config_warn("the earlier run could not be removed: %s", detail.message);
  }
  close(earlier);
  return status;
}

/* A run that could not be put in place stays beside it. */
static void keep_new(run_folder *folder, thrum_error *error) {
  char name[RUN_PATH_MAX + 32];
  struct stat status;
  for (int n = 1; n < NEW_TRIES; n++) {
    snprintf(name, sizeof name, "%s" NEW_END "%d", folder->path, n);
    if (lstat(name, &status) == 0 || rename(folder->work, name) != 0)
      continue;
    const thrum_error reason = *error;
    thrum_error_set(error, reason.status, "%.240s; the new run is kept in %.120s", reason.message,
                    name);
    unlock(folder);
    folder->work[0] = 0;
    return;
  }
}

thrum_status run_folder_commit(run_folder *folder, thrum_error *error) {
  char parent[RUN_PATH_MAX];
  thrum_error detail = {0};
  thrum_status status = THRUM_OK;
  int number = thrum_folder_sync(folder->work);
  if (number != 0)
    status = thrum_error_set(&detail, THRUM_IO, "%.300s: the run could not be written (%s)",
                             folder->path, strerror(number));
  if (folder->inside) {
    folder->work[0] = 0;
    return status < 0 ? thrum_error_set(error, status, "%s", detail.message) : THRUM_OK;
  }

  // a new RUN takes its name, an earlier one is exchanged
  if (status >= 0 && folder->existed)
    status = replace(folder, &detail);
  else if (status >= 0 && rename(folder->work, folder->path) != 0)
    status = thrum_error_set(&detail, THRUM_IO, "%.300s: the run could not be put there (%s)",
                             folder->path, strerror(errno));
  if (status < 0) {
    keep_new(folder, &detail);
    return thrum_error_set(error, status, "%s", detail.message);
  }

  parent_of(folder, parent);
  number = thrum_folder_sync(parent);
  unlock(folder);
  folder->work[0] = 0;
  return number == 0 ? THRUM_OK
                     : thrum_error_set(error, THRUM_IO,
                                       "%.300s: the run is there, but may be lost when the power "
                                       "fails (%s)",
                                       folder->path, strerror(number));
}

void run_folder_abandon(run_folder *folder) {
  if (folder->work[0] == 0)
    return;
  run_entries_remove(folder->work, folder->kind, NULL);
  unlock(folder);
  folder->work[0] = 0;
}
