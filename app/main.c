/* The `thrum` program: finds the subcommand and hands over to it.
 * SPDX-License-Identifier: Apache-2.0 */
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/address_space.h"
#include "app/commands.h"
#include "app/reference.h"
#include "config/message.h"
#include "io/json.h"
#include "platform/interrupt.h"
#include "thrum/thrum.h"

static int print_help(FILE *stream) {
  fprintf(stream,
          "thrum %s: real-time deformable bodies that keep their energy\n\n"
          "usage: thrum COMMAND [ARGUMENTS]\n\n",
          thrum_version());
  app_commands_print(stream, app_commands);

  // what every command takes, and three commands that work as they stand
  fputs("\n"
        "  thrum COMMAND --help   options and examples of a command\n"
        "  thrum --version        the version\n"
        "  thrum --models-dir DIR COMMAND   where beam, basket, bridge, horse, tower and heart "
        "lie\n\n"
        "examples:\n"
        "  thrum precompute beam:20x3x3@1x0.15x0.15 --fix 'x<0.001' -o beam.npz\n"
        "  thrum info beam.npz\n"
        "  thrum simulate beam.npz -o run --time 3 --start mode:1,0.02\n\n"
        "exit codes: 0 done, 1 refused, 2 usage, 3 ran but flagged\n",
        stream);
  return COMMAND_DONE;
}

/* `thrum --models-dir DIR COMMAND ...` is THRUM_MODELS=DIR for the one command. */
static int take_models_folder(int *argc, char ***argv) {
  static const char option[] = "--models-dir";
  const size_t length = sizeof option - 1;
  if (*argc < 2 || strncmp((*argv)[1], option, length) != 0)
    return COMMAND_DONE;

  // --models-dir=DIR, or --models-dir DIR
  const char *text = (*argv)[1] + length;
  if (*text != '=' && (*text != 0 || *argc < 3))
    return config_usage("", "--models-dir names a folder and comes before the command");
  const int taken = *text == '=' ? 1 : 2;
  if (setenv("THRUM_MODELS", taken == 1 ? text + 1 : (*argv)[2], 1) != 0) {
    fputs("thrum: out of memory\n", stderr);
    return COMMAND_REFUSED;
  }

  // the command then sees its own arguments alone
  (*argv)[taken] = (*argv)[0];
  *argc -= taken;
  *argv += taken;
  return COMMAND_DONE;
}

static int run(const char *name, int argc, char **argv) {
  const app_command *found = app_command_find(app_commands, "", "command", name);
  const int code = found != NULL ? found->run(argc, argv) : COMMAND_USAGE;
  return code == COMMAND_HELPED ? COMMAND_DONE : code;
}

/* `thrum help X` is `thrum X --help`; with an option it prints what is generated of all commands.
 */
static int help(int argc, char **argv) {
  char option[] = "--help";
  if (argc < 3)
    return print_help(stdout);
  if (argv[2][0] == '-')
    return reference_print(argv[2]);
  char *arguments[] = {argv[2], option, NULL};
  return run(argv[2], 2, arguments);
}

static int dispatch(int argc, char **argv) {
  const int taken = take_models_folder(&argc, &argv);
  if (taken != COMMAND_DONE)
    return taken;
  if (argc < 2) {
    print_help(stderr);
    return COMMAND_USAGE;
  }

  // options of the program itself stand in the place of a command
  const char *name = argv[1];
  if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0)
    return print_help(stdout);
  if (strcmp(name, "--version") == 0 || strcmp(name, "-V") == 0) {
    printf("thrum %s\n", thrum_version());
    return COMMAND_DONE;
  }
  if (strcmp(name, "help") == 0)
    return help(argc, argv);
  if (name[0] == '-')
    return config_usage("", "unknown option '%s'", name);
  return run(name, argc - 1, argv + 1);
}

/* Whether main has come to its end. */
static bool ended;

/* A library that ends the program, as MUMPS does where it finds no memory, may do so with exit code
 * 0: that must not pass for success. */
static void note_exit(void) {
  if (ended)
    return;
  thrum_interrupt_remove();
  fputs("thrum: a library ended the program: out of memory?\n", stderr);
  fflush(stderr);
  _exit(COMMAND_REFUSED);
}

static bool is_closed(int number) {
  return fcntl(number, F_GETFD) == -1;
}

/* A closed standard stream would lend its number to the first file that is opened, and what is
 * printed would go into that file: a place that cannot be written to keeps the number. Without
 * standard output nothing is begun, for what is printed could not be, and a failure is to leave
 * everything as it was. */
static bool fill_standard_streams(void) {
  const bool silent = is_closed(STDOUT_FILENO);
  for (int number = STDIN_FILENO; number <= STDERR_FILENO; number++)
    if (is_closed(number) && open("/dev/null", O_RDONLY) != number)
      return false;

  if (silent)
    fputs("thrum: standard output is closed: send it to /dev/null if it is not wanted\n", stderr);
  return !silent;
}

int main(int argc, char **argv) {
  if (!fill_standard_streams())
    return COMMAND_REFUSED;
  address_space_begin(argv);
  json_watch_memory();
  if (atexit(note_exit) != 0) {
    fputs("thrum: out of memory\n", stderr);
    return COMMAND_REFUSED;
  }
#ifdef SIGXFSZ
  // a file beyond the size limit is to be an error of writing and not the end of the program
  signal(SIGXFSZ, SIG_IGN);
#endif
  int code = dispatch(argc, argv);
  ended = true;

  // a report that lacks parts must not pass for a whole one
  if (json_memory_failed() && (code == COMMAND_DONE || code == COMMAND_FLAGGED)) {
    fputs("thrum: out of memory: the results are not complete\n", stderr);
    code = COMMAND_REFUSED;
  }

  // a full disk or a closed pipe must not pass for success
  if (fflush(stdout) != 0 || ferror(stdout)) {
    fputs("thrum: standard output could not be written\n", stderr);
    return code == COMMAND_DONE || code == COMMAND_FLAGGED ? COMMAND_REFUSED : code;
  }
  return code;
}
