/* Tells what in a folder belongs to a run: one walk through the folder, its frames and its bodies,
 * for checking, moving and removing (run_entries.h). SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/run_entries.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/json.h"

#define PATH_SIZE 1536

/* The files of a run but its mark. Those that end in .gp are there while a plot is drawn. */
static const char *const run_files[] = {
    "energy.csv",       "q.npy",           "end.npy",    RUN_PLACEMENTS,     "energy.png",
    "energy.svg",       "frames.pvd",      "energy.gp",  "against_mesh.csv", "against_mesh.png",
    "against_mesh.svg", "against_mesh.gp", "probes.csv", "probes.png",       "probes.svg",
    "probes.gp"};
enum { RUN_FILE_COUNT = sizeof run_files / sizeof run_files[0] };

/* The files of the run of a scene, beside the folders of its bodies. */
static const char *const scene_files[] = {SCENE_PROBES, SCENE_ACCOUNT, SCENE_CONTACT, SCENE_LINKS,
                                          SCENE_JSON};
enum { SCENE_FILE_COUNT = sizeof scene_files / sizeof scene_files[0] };

typedef char path_text[PATH_SIZE];

/* The kind of folder that is walked through. */
typedef enum folder_kind { FOLDER_RUN, FOLDER_SCENE, FOLDER_FRAMES } folder_kind;

/* The kinds of entries in such a folder. */
typedef enum entry_kind {
  ENTRY_USERS,
  ENTRY_FILE,
  ENTRY_MARK,
  ENTRY_FRAMES,
  ENTRY_BODY
} entry_kind;

/* One move, to be undone. */
typedef struct move {
  char *from, *to;
} move;

/* A walk: what it does, and the moves that it has made. */
typedef struct walk {
  enum { WALK_CHECK, WALK_KEEP, WALK_REMOVE } act;
  move *moves;
  size_t count;
} walk;

static thrum_status join(path_text path, const char *folder, const char *name, thrum_error *error) {
  if (snprintf(path, PATH_SIZE, "%s/%s", folder, name) < PATH_SIZE)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_IO, "%.200s/...: the path is too long", folder);
}

static thrum_status fail(const char *path, const char *what, int number, thrum_error *error) {
  return thrum_error_set(error, THRUM_IO, "%.250s: %s (%s)", path, what, strerror(number));
}

static thrum_status no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory to look into the run's folder");
}

/* --- marks ------------------------------------------------------------------------------------ */

/* The object of the mark in a folder, for cJSON_Delete; NULL in *object: there is none. */
static thrum_status read_mark(const char *folder, const char *name, cJSON **object,
                              thrum_error *error) {
  path_text path;
  struct stat status;
  *object = NULL;
  THRUM_TRY(join(path, folder, name, error));
  return lstat(path, &status) == 0 ? json_file_read(path, object, error) : THRUM_OK;
}

/* The program and the command in the mark say that a run of ours is there. */
static bool is_ours(const cJSON *object) {
  const char *program = json_text_of(object, "program"), *command = json_text_of(object, "command");
  return program != NULL && strcmp(program, "thrum") == 0 && command != NULL &&
         strcmp(command, "simulate") == 0;
}

static const char *mark_of(run_kind kind) {
  return kind == RUN_OF_SCENE ? SCENE_JSON : RUN_JSON;
}

bool run_entries_of_scene(const char *name) {
  bool found = false;
  for (int n = 0; n < SCENE_FILE_COUNT && !found; n++)
    found = strcmp(name, scene_files[n]) == 0;
  return found;
}

bool run_entries_finished(const char *path, run_kind kind) {
  path_text file;
  struct stat status;
  return path[0] != 0 && join(file, path, mark_of(kind), NULL) >= 0 && stat(file, &status) == 0 &&
         S_ISREG(status.st_mode);
}

bool run_entries_marked(const char *path, run_kind kind) {
  cJSON *object = NULL;
  const bool marked = read_mark(path, mark_of(kind), &object, NULL) >= 0 && is_ours(object);
  cJSON_Delete(object);
  return marked;
}

/* Whether the folder is empty, into *none. */
static thrum_status find_none(const char *path, bool *none, thrum_error *error) {
  DIR *entries = opendir(path);
  if (entries == NULL)
    return fail(path, "cannot be read", errno, error);
  *none = true;
  errno = 0;
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries))
    if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
      *none = false;

  // readdir tells its end from a failure by errno alone
  const thrum_status status = errno != 0 ? fail(path, "cannot be read", errno, error) : THRUM_OK;
  closedir(entries);
  return status;
}

bool run_entries_none(const char *path) {
  bool none = false;
  return find_none(path, &none, NULL) >= 0 && none;
}

thrum_status run_entries_replaceable(const char *path, run_kind kind, thrum_error *error) {
  bool ours = false;
  cJSON *object = NULL;
  THRUM_TRY(find_none(path, &ours, error));
  if (ours)
    return THRUM_OK;

  // a mark that cannot be read is not the same as none
  THRUM_TRY(read_mark(path, mark_of(kind), &object, error));
  ours = is_ours(object);
  cJSON_Delete(object);
  const bool scene = kind == RUN_OF_SCENE;
  if (!ours && run_entries_marked(path, scene ? RUN_OF_BODY : RUN_OF_SCENE))
    return thrum_error_set(error, THRUM_IO, "%.300s: holds a run of %s; choose another -o", path,
                           scene ? "a model, not of a scene" : "a scene, not of a model");
  return ours ? THRUM_OK
              : thrum_error_set(error, THRUM_IO,
                                "%.300s: holds files that are no earlier run; choose another -o",
                                path);
}

/* --- entries ---------------------------------------------------------------------------------- */

/* A body of the scene; without a scene.json the run is in the making, and every folder is one. */
static bool is_body(const cJSON *scene, const char *name) {
  const cJSON *bodies = cJSON_GetObjectItemCaseSensitive(scene, "bodies"), *item;
  if (scene == NULL)
    return true;
  cJSON_ArrayForEach(item, bodies) {
    const char *body = json_text_of(item, "name");
    if (body != NULL && strcmp(body, name) == 0)
      return true;
  }
  return false;
}

static bool ends_with(const char *name, const char *end) {
  const size_t length = strlen(name), size = strlen(end);
  return length > size && strcmp(name + length - size, end) == 0;
}

/* A file of this name, or what a killed process left of writing it. */
static bool is_named(const char *name, const char *file) {
  const size_t length = strlen(file);
  return strncmp(name, file, length) == 0 &&
         (name[length] == 0 || (name[length] == '.' && ends_with(name, ".tmp")));
}

/* Returns what an entry with this name would be as a file; ENTRY_USERS: nothing of a run. */
static entry_kind file_kind(folder_kind folder, const char *name) {
  if (folder == FOLDER_FRAMES) {
    const bool frame = strncmp(name, "frame_", 6) == 0;
    return frame && (ends_with(name, ".vtu") || ends_with(name, ".tmp")) ? ENTRY_FILE : ENTRY_USERS;
  }

  // the record itself marks the folder as a run's; its copies of an unfinished write do not
  if (strcmp(name, folder == FOLDER_SCENE ? SCENE_JSON : RUN_JSON) == 0)
    return ENTRY_MARK;
  const char *const *files = folder == FOLDER_SCENE ? scene_files : run_files;
  const int count = folder == FOLDER_SCENE ? SCENE_FILE_COUNT : RUN_FILE_COUNT;
  for (int n = 0; n < count; n++)
    if (is_named(name, files[n]))
      return ENTRY_FILE;
  return folder == FOLDER_RUN && is_named(name, RUN_JSON) ? ENTRY_FILE : ENTRY_USERS;
}

static entry_kind kind_of(folder_kind folder, const cJSON *scene, const char *name,
                          bool is_folder) {
  if (!is_folder)
    return file_kind(folder, name);
  if (folder == FOLDER_RUN && strcmp(name, RUN_FRAMES) == 0)
    return ENTRY_FRAMES;
  return folder == FOLDER_SCENE && is_body(scene, name) ? ENTRY_BODY : ENTRY_USERS;
}

/* --- what a walk does with an entry ----------------------------------------------------------- */

/* An entry of the user's is in the way where the new run has, or may have, one of its name. */
static thrum_status check_users(folder_kind folder, const char *from, const char *to,
                                const char *name, thrum_error *error) {
  struct stat status;
  const bool taken = to != NULL ? lstat(to, &status) == 0
                                : file_kind(folder, name) != ENTRY_USERS ||
                                      (folder == FOLDER_RUN && strcmp(name, RUN_FRAMES) == 0);
  return taken
             ? thrum_error_set(error, THRUM_IO,
                               "%.250s: is no part of a run and has the name of one; move it away",
                               from)
             : THRUM_OK;
}

static void forget_moves(walk *walking) {
  for (size_t n = 0; n < walking->count; n++) {
    free(walking->moves[n].from);
    free(walking->moves[n].to);
  }
  free(walking->moves);
}

static void undo_moves(const walk *walking) {
  for (size_t n = walking->count; n > 0; n--)
    rename(walking->moves[n - 1].to, walking->moves[n - 1].from);
}

static thrum_status keep_users(walk *walking, const char *from, const char *folder, const char *to,
                               thrum_error *error) {
  struct stat status;
  if (mkdir(folder, 0777) != 0 && errno != EEXIST)
    return fail(folder, "cannot be created", errno, error);

  // rename would replace a file
  if (lstat(to, &status) == 0)
    return fail(to, "is there already", EEXIST, error);

  // the move is noted before it is made, so that it can be undone
  move *grown = realloc(walking->moves, (walking->count + 1) * sizeof *grown);
  if (grown == NULL)
    return no_memory(error);
  walking->moves = grown;
  const move next = {strdup(from), strdup(to)};
  const int reason = next.from == NULL || next.to == NULL ? ENOMEM
                     : rename(from, to) != 0              ? errno
                                                          : 0;
  if (reason == 0) {
    grown[walking->count++] = next;
    return THRUM_OK;
  }
  free(next.from);
  free(next.to);
  return fail(from, "cannot be moved", reason, error);
}

static thrum_status remove_file(const char *path, thrum_error *error) {
  if (unlink(path) == 0 || errno == ENOENT)
    return THRUM_OK;
  return fail(path, "cannot be removed", errno, error);
}

static thrum_status walk_folder(walk *walking, folder_kind folder, const char *from, const char *to,
                                thrum_error *error);

static thrum_status visit(walk *walking, folder_kind folder, const cJSON *scene, const char *from,
                          const char *to, const char *name, thrum_error *error) {
  path_text path, target = "";
  struct stat status;
  THRUM_TRY(join(path, from, name, error));
  if (to != NULL)
    THRUM_TRY(join(target, to, name, error));
  if (lstat(path, &status) != 0)
    return errno == ENOENT ? THRUM_OK : fail(path, "cannot be read", errno, error);
  const entry_kind kind = kind_of(folder, scene, name, S_ISDIR(status.st_mode));

  // folders of the run first
  if (kind == ENTRY_FRAMES || kind == ENTRY_BODY)
    return walk_folder(walking, kind == ENTRY_FRAMES ? FOLDER_FRAMES : FOLDER_RUN, path,
                       to != NULL ? target : NULL, error);
  if (kind == ENTRY_USERS && walking->act == WALK_CHECK)
    return check_users(folder, path, to != NULL ? target : NULL, name, error);
  if (kind == ENTRY_USERS && walking->act == WALK_KEEP)
    return keep_users(walking, path, to, target, error);
  return kind == ENTRY_FILE && walking->act == WALK_REMOVE ? remove_file(path, error) : THRUM_OK;
}

/* All entries of a folder; the mark is removed last, so that a walk that ends midway can be done
 * again. */
static thrum_status walk_entries(walk *walking, folder_kind folder, const cJSON *scene,
                                 const char *from, const char *to, thrum_error *error) {
  DIR *entries = opendir(from);
  if (entries == NULL)
    return fail(from, "cannot be read", errno, error);
  thrum_status status = THRUM_OK;

  // one entry after the other
  for (;;) {
    errno = 0;
    const struct dirent *entry = readdir(entries);
    if (entry == NULL) {
      if (errno != 0)
        status = fail(from, "cannot be read", errno, error);
      break;
    }

    // the folder itself and the one above are no entries
    if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
      continue;
    status = visit(walking, folder, scene, from, to, entry->d_name, error);
    if (status < 0)
      break;
  }

  closedir(entries);
  return status;
}

static thrum_status walk_folder(walk *walking, folder_kind folder, const char *from, const char *to,
                                thrum_error *error) {
  path_text mark;
  cJSON *scene = NULL;
  if (walking->act == WALK_CHECK && access(from, R_OK | W_OK | X_OK) != 0)
    return fail(from, "cannot be replaced", errno, error);

  // the bodies of a scene are those that its mark lists
  if (folder == FOLDER_SCENE) {
    THRUM_TRY(read_mark(from, SCENE_JSON, &scene, error));
    THRUM_TRY(join(mark, from, SCENE_JSON, error));
    if (scene == NULL && access(mark, F_OK) == 0)
      return thrum_error_set(error, THRUM_IO, "%.250s: is no object of JSON", mark);
  }

  thrum_status status = walk_entries(walking, folder, scene, from, to, error);
  cJSON_Delete(scene);
  if (status < 0 || walking->act != WALK_REMOVE)
    return status;

  if (folder != FOLDER_FRAMES) {
    THRUM_TRY(join(mark, from, folder == FOLDER_SCENE ? SCENE_JSON : RUN_JSON, error));
    THRUM_TRY(remove_file(mark, error));
  }
  if (rmdir(from) == 0 || errno == ENOTEMPTY || errno == EEXIST)
    return THRUM_OK;
  return fail(from, "cannot be removed", errno, error);
}

static folder_kind folder_of(run_kind kind) {
  return kind == RUN_OF_SCENE ? FOLDER_SCENE : FOLDER_RUN;
}

thrum_status run_entries_check(const char *from, const char *to, run_kind kind,
                               thrum_error *error) {
  walk walking = {.act = WALK_CHECK};
  return walk_folder(&walking, folder_of(kind), from, to, error);
}

thrum_status run_entries_keep(const char *from, const char *to, run_kind kind, thrum_error *error) {
  walk walking = {.act = WALK_KEEP};
  const thrum_status status = walk_folder(&walking, folder_of(kind), from, to, error);
  if (status < 0)
    undo_moves(&walking);
  forget_moves(&walking);
  return status;
}

thrum_status run_entries_remove(const char *path, run_kind kind, thrum_error *error) {
  walk walking = {.act = WALK_REMOVE};
  return walk_folder(&walking, folder_of(kind), path, NULL, error);
}
