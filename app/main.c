/* The `thrum` program: finds the subcommand and hands over to it.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/commands.h"
#include "app/program_guard.h"
#include "app/reference.h"
#include "config/message.h"
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
        "  thrum simulate beam.npz -o swing --time 3 --start mode:1,0.02\n\n"
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

int main(int argc, char **argv) {
  return program_guard_begin(argv) ? program_guard_end(dispatch(argc, argv)) : COMMAND_REFUSED;
}
