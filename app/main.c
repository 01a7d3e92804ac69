/* The `thrum` program: finds the subcommand and switches to the energy integrator.
 * SPDX-License-Identifier: Apache-2.0 */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/address_space.h"
#include "app/cmd.h"
#include "config/message.h"
#include "thrum/thrum.h"

typedef struct command {
  const char *name;
  int (*run)(int argc, char **argv);
  const char *summary;
} command;

static const command commands[] = {
    {"precompute", cmd_precompute, "from a tetrahedral mesh to a reduced model file"},
    {"mesh", cmd_mesh, "fill a closed surface with tetrahedra, by Gmsh or TetGen"},
    {"check", cmd_check, "say what a mesh is like, and what may be wrong with it"},
    {"convert", cmd_convert, "from one mesh format to another"},
    {"simulate", cmd_simulate, "step a model and write what happened"},
    {"view", cmd_view, "show models or a scene in the browser, to be pulled at"},
    {"static", cmd_static, "find where a body comes to rest under a load"},
    {"experiments", cmd_experiments, "run the experiments of the thesis and report them"},
    {"tradeoff", cmd_tradeoff, "say what speed costs in accuracy, and pick a setting"},
    {"info", cmd_info, "say what a model file holds"},
    {"embed", cmd_embed, "bind a fine surface to a model, to be shown in its place"},
    {"export", cmd_export, "write a model in the formats of other programs"},
    {"bench", cmd_bench, "measure the runtime on this machine"},
    {"schema", cmd_schema, "print the JSON schema of a command's options files"},
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static int print_help(FILE *stream) {
  fprintf(stream,
          "thrum %s: real-time deformable bodies that keep their energy\n\n"
          "usage: thrum COMMAND [ARGUMENTS]\n\n",
          thrum_version());
  for (int n = 0; n < COMMAND_COUNT; n++) {
    fprintf(stream, "  %-12s %s\n", commands[n].name, commands[n].summary);
  }
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

static const command *find_command(const char *name) {
  for (int n = 0; n < COMMAND_COUNT; n++) {
    if (strcmp(commands[n].name, name) == 0)
      return &commands[n];
  }
  return NULL;
}

static int unknown_command(const char *name) {
  const char *names[COMMAND_COUNT];
  for (int n = 0; n < COMMAND_COUNT; n++)
    names[n] = commands[n].name;
  const char *nearest = config_nearest(name, names, COMMAND_COUNT);
  if (nearest != NULL) {
    return config_usage("", "unknown command '%s'; did you mean '%s'?", name, nearest);
  }
  return config_usage("", "unknown command '%s'", name);
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

static int run(const command *found, int argc, char **argv) {
  const int code = found->run(argc, argv);
  return code == COMMAND_HELPED ? COMMAND_DONE : code;
}

static int dispatch(int argc, char **argv) {
  const int taken = take_models_folder(&argc, &argv);
  if (taken != COMMAND_DONE)
    return taken;
  if (argc < 2) {
    print_help(stderr);
    return COMMAND_USAGE;
  }

  const char *name = argv[1];
  if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0)
    return print_help(stdout);
  if (strcmp(name, "--version") == 0 || strcmp(name, "-V") == 0) {
    printf("thrum %s\n", thrum_version());
    return COMMAND_DONE;
  }
  // `thrum help X` is `thrum X --help`
  if (strcmp(name, "help") == 0) {
    if (argc < 3)
      return print_help(stdout);
    const command *about = find_command(argv[2]);
    if (about == NULL)
      return unknown_command(argv[2]);
    char help[] = "--help";
    char *arguments[] = {argv[2], help, NULL};
    return run(about, 2, arguments);
  }
  if (name[0] == '-')
    return config_usage("", "unknown option '%s'", name);
  const command *found = find_command(name);
  return found != NULL ? run(found, argc - 1, argv + 1) : unknown_command(name);
}

int main(int argc, char **argv) {
  address_space_begin(argv);
#ifdef SIGXFSZ
  // a file beyond the size limit is to be an error of writing and not the end of the program
  signal(SIGXFSZ, SIG_IGN);
#endif
  const int code = dispatch(argc, argv);
  // a full disk or a closed pipe must not pass for success
  if (fflush(stdout) != 0 || ferror(stdout)) {
    fputs("thrum: standard output could not be written\n", stderr);
    return code == COMMAND_DONE ? COMMAND_REFUSED : code;
  }
  return code;
}
