/* A program that is stopped while it makes a file leaves neither a partial file nor a temporary
 * one. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <time.h>

#include "io/file.h"
#include "platform/interrupt.h"
#include "tests/support/test_folder.h"

static int count_files(void) {
  DIR *entries = opendir(folder);
  assert_non_null(entries);
  int count = 0;
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries))
    count += entry->d_name[0] != '.';
  closedir(entries);
  return count;
}

/* Runs in a child process, which stops itself by the signal `number` while it writes a file. */
static void stop_while_writing(const char *path, int number) {
  const int silent = open("/dev/null", O_WRONLY);
  dup2(silent, STDERR_FILENO);
  thrum_interrupt_clean("stopped\n");
  thrum_file_writer writer = {NULL, NULL, NULL};
  if (thrum_file_writer_open(path, &writer, NULL) != THRUM_OK ||
      thrum_file_writer_put(&writer, "half", 4, NULL) != THRUM_OK || count_files() != 2)
    _exit(1);
  raise(number);
  _exit(2);
}

static void a_signal_while_a_file_is_written_leaves_the_old_one_alone(void **state) {
  (void)state;
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};

  // a complete file from earlier
  char path[160];
  snprintf(path, sizeof path, "%s/kept.npz", folder);
  assert_true(text_file_write(path, "earlier"));

  // each signal ends the child, which leaves no temporary file
  for (int n = 0; n < 3; n++) {
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0)
      stop_while_writing(path, numbers[n]);
    int status = 0;
    assert_true(waitpid(child, &status, 0) == child);
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), numbers[n]);
    assert_int_equal(count_files(), 1);
  }

  // the earlier file is unchanged
  char *text = text_file_read(path);
  assert_string_equal(text, "earlier");

  free(text);
  unlink(path);
}

/* Starts a precompute of some seconds with up to four more options, and stops it by SIGINT once it
 * reports `stage`; it says `line`. */
static void stop_in_stage(const char *mesh, const char *stage, const char *line,
                          const char *const options[4]) {
  // the child's output is collected outside of the folder whose files are counted
  char model[160], said[160];
  snprintf(model, sizeof model, "%s/made.npz", folder);
  snprintf(said, sizeof said, "/tmp/thrum-said-%ld", (long)getpid());
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    const int file = open(said, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (file < 0 || dup2(file, STDERR_FILENO) < 0 || dup2(file, STDOUT_FILENO) < 0)
      _exit(126);
    execl(THRUM_PROGRAM, THRUM_PROGRAM, "precompute", mesh, "--fix", "left", "-o", model,
          options[0], options[1], options[2], options[3], (char *)NULL);
    _exit(127);
  }

  // the signal comes as soon as the stage is reported
  const struct timespec pause = {0, 5000000};
  bool there = false;
  for (int n = 0; n < 12000 && !there; n++) {
    char *text = text_file_read(said);
    there = text != NULL && strstr(text, stage) != NULL;
    free(text);
    nanosleep(&pause, NULL);
  }
  assert_true(there);
  kill(child, SIGINT);

  // the signal ends it, and it says what it has written
  int status = 0;
  assert_true(waitpid(child, &status, 0) == child);
  assert_true(WIFSIGNALED(status));
  assert_int_equal(WTERMSIG(status), SIGINT);
  assert_int_equal(count_files(), 0);
  char *text = text_file_read(said);
  assert_non_null(text);
  assert_non_null(strstr(text, line));

  free(text);
  unlink(said);
}

static void a_signal_in_a_stage_leaves_no_file(void **state) {
  (void)state;
  static const char large[] = "beam:60x16x16@1x0.2x0.2", nothing[] = "stopped; nothing was written";
  static const char *const none[4] = {NULL};
  stop_in_stage(large, "stiffness and mass", nothing, none);
  // one long call of a library
  stop_in_stage(large, "stiffness solver", nothing, none);

  // a training goes on with the runs that it has kept, here in the folder itself
  const char *const kept[4] = {"--train=gravity:0,0,-1", "--train-time=1000", "--keep-runs",
                               folder};
  stop_in_stage("beam:8x2x2@1x0.2x0.2", "training ", "goes on with the runs that are kept", kept);
}

int main(void) {
  signals_as_in_a_terminal();
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_signal_while_a_file_is_written_leaves_the_old_one_alone),
      cmocka_unit_test(a_signal_in_a_stage_leaves_no_file),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
