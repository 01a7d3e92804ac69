/* Tests of commands that cannot write: the disk is full, the folder cannot be written to, a folder
 * stands in place of a file, or Ctrl-C comes at any moment. Each command names the file in one
 * line, and leaves what was there before or whole files, never half of one. A limit on the file
 * size stands for the full disk, as writes then fail in the same places.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <time.h>

#include "tests/support/program_support.h"

#define ARGUMENTS 20
#define LISTING 4096

static char folder[64], model[96], mesh[96], motion[96], scene[96];

/* One way to write: OUT in an argument stands for the folder of a case. */
typedef struct writer {
  const char *arguments[ARGUMENTS];
  int least; /* bytes of its largest file, at least */
} writer;

static const writer writers[] = {
    {{"precompute", "beam:4x2x2@1x0.3x0.3", "--order", "2", "--fix", "x<0.1", "-q", "-o",
      "OUT/m.npz"},
     9000},
    {{"precompute", "beam:4x2x2@1x0.3x0.3", "--order", "2", "--fix", "x<0.1", "-q", "-o",
      "OUT/m.npz", "--export-modes", "OUT/m.vtu"},
     9000},
    {{"convert", "MESH", "OUT/m.veg"}, 2000},
    {{"convert", "MESH", "OUT/m.msh", "--binary"}, 2000},
    {{"convert", "MESH", "OUT/m.node"}, 1300},
    {{"convert", "MESH", "OUT/m.mesh"}, 2000},
    {{"convert", "MESH", "OUT/m.vtk"}, 2000},
    {{"convert", "MESH", "OUT/m.vtu"}, 2000},
    {{"convert", "MESH", "OUT/m.inp"}, 2000},
    {{"export", "MODEL", "--vega-basis", "OUT/m.U", "--vega-cubic", "OUT/m.cub", "--matrices",
      "OUT/m"},
     6000},
    {{"export", "RUN", "--glb", "OUT/m.glb", "--pc2", "OUT/m.pc2", "--mdd", "OUT/m.mdd", "--obj",
      "OUT/m.obj"},
     2000},
    {{"static", "MODEL", "--load", "gravity:0,0,-1", "-q", "-o", "OUT/q.npy", "--vtu", "OUT/q.vtu",
      "--path", "OUT/q.csv"},
     2000},
    {{"simulate", "MODEL", "--time", "0.3", "-q", "-o", "OUT/run", "--start", "mode:1,0.01",
      "--frames", "every-50"},
     2000},
    {{"experiments", "--models", "MODEL", "--loads", "impulse", "--schemes", "newmark", "--time",
      "0.1", "-q", "-o", "OUT/made"},
     1500},
    {{"simulate", "SCENE", "-q", "-o", "OUT/scene"}, 2000},
    {{"bench", "step", "MODEL", "--no-machine", "--batches", "2", "--steps", "10", "-q", "-o",
      "OUT", "--json"},
     0},
};
enum { WRITERS = sizeof writers / sizeof writers[0] };

static const char scene_text[] =
    "{\"time\": 0.3, \"bodies\": [{\"name\": \"one\", \"model\": \"model.npz\", \"start\": "
    "\"mode:1,0.01\"}, {\"name\": \"two\", \"model\": \"model.npz\", \"scale\": 2}], \"probes\": "
    "[{\"body\": \"one\", \"at\": \"all\"}], \"outputs\": {\"frames\": \"every-50\"}}";

static int make_inputs(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return -1;
  snprintf(model, sizeof model, "%s/model.npz", folder);
  snprintf(mesh, sizeof mesh, "%s/mesh.veg", folder);

  // a model, a run of it, a mesh and a scene of the model are the inputs of the commands
  program_result run =
      thrum_run(folder, "precompute", "beam:4x2x2@1x0.3x0.3", "--order", "2", "--fix", "x<0.1",
                "--modes", "4", "--rank", "6", "-q", "-o", model, NULL);
  int code = run.exit_code;
  program_result_free(&run);

  snprintf(motion, sizeof motion, "%s/motion", folder);
  run = thrum_run(folder, "simulate", model, "-o", motion, "--time", "0.06", "--start",
                  "mode:1,0.01", "-q", NULL);
  code += run.exit_code;
  program_result_free(&run);

  run = thrum_run(folder, "convert", "beam:4x2x2@1x0.3x0.3", mesh, NULL);
  code += run.exit_code;
  program_result_free(&run);

  snprintf(scene, sizeof scene, "%s/scene.json", folder);
  return text_file_write(scene, scene_text) ? code : -1;
}

static int remove_inputs(void **state) {
  (void)state;
  test_folder_remove(folder);
  return 0;
}

/* Puts the paths into the arguments of a writer; the texts last until the next call. */
static void fill_arguments(const writer *w, const char *out, char *argv[ARGUMENTS + 2]) {
  static char texts[ARGUMENTS][160];
  static char program[] = THRUM_PROGRAM;
  argv[0] = program;
  int n = 0;
  for (; n < ARGUMENTS && w->arguments[n] != NULL; n++) {
    const char *text = w->arguments[n];

    // OUT is the beginning of a path, the other names are whole arguments
    if (strncmp(text, "OUT", 3) == 0)
      snprintf(texts[n], sizeof texts[n], "%s%s", out, text + 3);
    else
      snprintf(texts[n], sizeof texts[n], "%s",
               strcmp(text, "MODEL") == 0   ? model
               : strcmp(text, "MESH") == 0  ? mesh
               : strcmp(text, "RUN") == 0   ? motion
               : strcmp(text, "SCENE") == 0 ? scene
                                            : text);
    argv[n + 1] = texts[n];
  }

  argv[n + 1] = NULL;
}

/* Lists the names of everything in a folder that is unfinished: temporary files and folders. */
static void list_remains(const char *path, char *listing) {
  DIR *entries = opendir(path);
  if (entries == NULL)
    return;
  for (struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
    char child[700];
    if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
      continue;
    snprintf(child, sizeof child, "%s/%s", path, entry->d_name);

    // both kinds of unfinished output have their mark in the name
    if (strstr(entry->d_name, ".tmp") != NULL || strstr(entry->d_name, "partial") != NULL)
      snprintf(listing + strlen(listing), LISTING - strlen(listing), "%.300s ", child);
    list_remains(child, listing);
  }
  closedir(entries);
}

static void expect_no_remains(const char *path, const char *when) {
  char listing[LISTING] = "";
  list_remains(path, listing);
  if (listing[0] != 0)
    fail_msg("%s left %s", when, listing);
}

/* Returns whether there are files anywhere in the folder. */
static bool holds_files(const char *path) {
  DIR *entries = opendir(path);
  bool found = false;
  for (struct dirent *entry = entries != NULL ? readdir(entries) : NULL; entry != NULL && !found;
       entry = readdir(entries)) {
    char child[700];
    struct stat status;
    snprintf(child, sizeof child, "%s/%s", path, entry->d_name);
    if (entry->d_name[0] != '.' && lstat(child, &status) == 0)
      found = S_ISDIR(status.st_mode) ? holds_files(child) : true;
  }
  if (entries != NULL)
    closedir(entries);
  return found;
}

static void join_arguments(char *const *argv, char text[512]) {
  text[0] = 0;
  for (int n = 1; argv[n] != NULL; n++)
    snprintf(text + strlen(text), 512 - strlen(text), "%.80s ", argv[n]);
}

/* Runs the program with files of at most `bytes`, as on a disk that has no more room. */
static program_result run_limited(char *const *argv, rlim_t bytes) {
  struct rlimit before;
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
  const struct rlimit limit = {bytes, before.rlim_max};
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
  program_result run = program_execute(folder, argv);
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
  return run;
}

/* What is said behind the warnings of a coarse mesh. */
static const char *behind_warnings(const char *said) {
  static const char warning[] = "thrum: warning: ";
  while (strncmp(said, warning, sizeof warning - 1) == 0 && strchr(said, '\n') != NULL)
    said = strchr(said, '\n') + 1;
  return said;
}

static void a_full_disk_leaves_nothing_and_names_the_file(void **state) {
  (void)state;

  // the standard output and error go into files too, so they must fit
  static const int limits[] = {1000, 1600, 8000};
  for (int n = 0; n < WRITERS; n++) {
    int failures = 0;
    for (size_t k = 0; k < sizeof limits / sizeof limits[0]; k++) {
      char out[128], command[512], *argv[ARGUMENTS + 2];
      snprintf(out, sizeof out, "%s/full-%d-%d", folder, n, (int)k);
      assert_int_equal(mkdir(out, 0777), 0);
      fill_arguments(&writers[n], out, argv);
      join_arguments(argv, command);

      program_result run = run_limited(argv, (rlim_t)limits[k]);
      expect_no_remains(out, command);

      // one file is there, or none: nothing of a pair that is half there
      if (strcmp(writers[n].arguments[0], "convert") == 0)

        assert_int_equal(holds_files(out), run.exit_code == 0);

      // a failure names the file and the reason, and where the limit comes from
      if (run.exit_code != 0 && run.exit_code != 3) {
        failures++;
        if (run.exit_code != 1 || strstr(run.err, out) == NULL ||
            strstr(run.err, "File too large") == NULL || strstr(run.err, "ulimit -f") == NULL)
          fail_msg("%s: exit %d, '%s'", command, run.exit_code, run.err);
        if (!line_count_is(behind_warnings(run.err), 1))
          fail_msg("%s: %s", command, run.err);
      }

      // a limit below the largest file must fail
      if (limits[k] < writers[n].least && run.exit_code != 1)
        fail_msg("%s: exit %d with files of at most %d bytes", command, run.exit_code, limits[k]);
      program_result_free(&run);
    }

    assert_true(failures > 0 || writers[n].least < limits[0]);
  }
}

/* Each command writes twice into the same place, the second time on a full disk. */
static void a_file_of_an_earlier_run_stays_whole(void **state) {
  (void)state;
  static const char *const files[] = {"m.npz", "run/q.npy", "m.veg"};
  static const int which[] = {0, 12, 2};
  for (int n = 0; n < 3; n++) {
    char out[128], path[200], *argv[ARGUMENTS + 2];
    snprintf(out, sizeof out, "%s/twice-%d", folder, n);
    assert_int_equal(mkdir(out, 0777), 0);

    snprintf(path, sizeof path, "%s/%s", out, files[n]);
    fill_arguments(&writers[which[n]], out, argv);

    // the first run writes its files
    program_result run = program_execute(folder, argv);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);

    // the second one fails, and the file is still the same one
    struct stat first, second;
    assert_int_equal(stat(path, &first), 0);
    run = run_limited(argv, 1000);
    assert_int_equal(run.exit_code, 1);
    program_result_free(&run);
    assert_int_equal(stat(path, &second), 0);
    assert_true(first.st_ino == second.st_ino && first.st_size == second.st_size);
  }
}

static void a_folder_that_cannot_be_written_to_is_named(void **state) {
  (void)state;
  char locked[128];
  snprintf(locked, sizeof locked, "%s/locked", folder);
  assert_int_equal(mkdir(locked, 0555), 0);

  // permissions do not stop root, so root is given a file system of the kernel
  const char *out = access(locked, W_OK) != 0 ? locked : "/sys";
  for (int n = 0; n < WRITERS; n++) {
    char command[512], *argv[ARGUMENTS + 2];
    fill_arguments(&writers[n], out, argv);
    join_arguments(argv, command);
    program_result run = program_execute(folder, argv);
    if (run.exit_code != 1 || strstr(run.err, out) == NULL || !line_count_is(run.err, 1))
      fail_msg("%s: exit %d, '%s'", command, run.exit_code, run.err);
    program_result_free(&run);
  }

  assert_false(holds_files(locked));
}

/* The outputs OUT/m.npz and the like are folders already, and OUT/run is a file. */
static void a_folder_in_place_of_a_file_is_refused(void **state) {
  (void)state;
  static const char *const names[] = {"m.npz", "m.vtu", "m.veg", "m.msh", "m.node", "m.mesh",
                                      "m.vtk", "m.inp", "m.U",   "q.npy", "m.glb"};
  char out[128], path[200];
  snprintf(out, sizeof out, "%s/folders", folder);
  assert_int_equal(mkdir(out, 0777), 0);

  // folders in the places of files
  for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
    snprintf(path, sizeof path, "%s/%s", out, names[n]);
    assert_int_equal(mkdir(path, 0777), 0);
  }

  // files in the places of folders
  for (int n = 0; n < 3; n++) {
    snprintf(path, sizeof path, "%s/%s", out, n == 0 ? "run" : n == 1 ? "made" : "scene");
    assert_true(text_file_write(path, "mine"));
  }

  // every writer but bench, whose OUT is a folder, is refused and leaves nothing unfinished
  for (int n = 0; n < WRITERS - 1; n++) {
    char command[512], *argv[ARGUMENTS + 2];
    fill_arguments(&writers[n], out, argv);
    join_arguments(argv, command);
    program_result run = program_execute(folder, argv);
    if (run.exit_code != 1 || strstr(run.err, out) == NULL || !line_count_is(run.err, 1))
      fail_msg("%s: exit %d, '%s'", command, run.exit_code, run.err);
    program_result_free(&run);
    expect_no_remains(out, command);
  }

  // the file is as it was
  char *text = text_file_read(path);
  assert_string_equal(text, "mine");
  free(text);
}

/* Starts the program and sends SIGINT after a while; returns its wait status. */
static int interrupt_after(char *const *argv, long microseconds) {
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    const int silent = open("/dev/null", O_WRONLY);
    if (silent < 0 || dup2(silent, STDERR_FILENO) < 0 || dup2(silent, STDOUT_FILENO) < 0)
      _exit(126);
    execv(argv[0], argv);
    _exit(127);
  }

  // the moment decides how far the command has come
  const struct timespec pause = {0, 1000 * microseconds};
  nanosleep(&pause, NULL);
  kill(child, SIGINT);

  int status = 0;
  assert_true(waitpid(child, &status, 0) == child);
  return status;
}

static void ctrl_c_at_any_moment_leaves_whole_files_or_none(void **state) {
  (void)state;
  static const long moments[] = {500, 2000, 4000, 8000, 16000, 40000};
  for (int n = 0; n < WRITERS; n++) {
    for (size_t k = 0; k < sizeof moments / sizeof moments[0]; k++) {
      char out[128], command[512], *argv[ARGUMENTS + 2];
      snprintf(out, sizeof out, "%s/stop-%d-%d", folder, n, (int)k);
      assert_int_equal(mkdir(out, 0777), 0);
      fill_arguments(&writers[n], out, argv);
      join_arguments(argv, command);

      const int status = interrupt_after(argv, moments[k]);
      expect_no_remains(out, command);

      // it was stopped, or was done before, or (simulate) ended with what it had
      const bool stopped = WIFSIGNALED(status) && WTERMSIG(status) == SIGINT;
      const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      if (!stopped && code != 0 && code != 3)
        fail_msg("%s: status %d", command, status);
    }
  }
}

/* The time before a run has anything to clean up is short, so the moments lie close together: the
 * folder is tried before a model is made or read. */
static void ctrl_c_while_a_run_begins_leaves_nothing(void **state) {
  (void)state;
  for (int n = 0; n < WRITERS; n++) {
    for (int k = 0; k < 60 && strcmp(writers[n].arguments[0], "simulate") == 0; k++) {
      // moments 0.15 ms apart, for the writers that are runs
      char out[128], command[512], *argv[ARGUMENTS + 2];
      snprintf(out, sizeof out, "%s/begin-%d-%d", folder, n, k);
      assert_int_equal(mkdir(out, 0777), 0);
      fill_arguments(&writers[n], out, argv);
      join_arguments(argv, command);
      interrupt_after(argv, 1000 + 150 * k);
      expect_no_remains(out, command);
    }
  }
}

static void standard_output_on_a_full_disk_is_a_failure(void **state) {
  (void)state;
  char command[300];
  snprintf(command, sizeof command, THRUM_PROGRAM " info %s > /dev/full 2> %s/said", model, folder);
  const int status = system(command);
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 1);
  snprintf(command, sizeof command, "%s/said", folder);
  char *said = text_file_read(command);
  assert_non_null(strstr(said, "standard output could not be written"));
  free(said);
}

int main(void) {
  signals_as_in_a_terminal();
  signal(SIGXFSZ, SIG_IGN);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_full_disk_leaves_nothing_and_names_the_file),
      cmocka_unit_test(a_file_of_an_earlier_run_stays_whole),
      cmocka_unit_test(a_folder_that_cannot_be_written_to_is_named),
      cmocka_unit_test(a_folder_in_place_of_a_file_is_refused),
      cmocka_unit_test(ctrl_c_at_any_moment_leaves_whole_files_or_none),
      cmocka_unit_test(ctrl_c_while_a_run_begins_leaves_nothing),
      cmocka_unit_test(standard_output_on_a_full_disk_is_a_failure),
  };
  return cmocka_run_group_tests(tests, make_inputs, remove_inputs);
}
