/* The `thrum-mpi` program: `thrum precompute`, and `thrum static` and `thrum simulate` with --full,
 * by several processes, started by mpirun. SPDX-License-Identifier: Apache-2.0 */
#include <slepceps.h>
#include <stdio.h>
#include <string.h>

#include "app/cmd.h"
#include "app/program_guard.h"
#include "config/message.h"
#include "mpi/shared_precompute.h"
#include "mpi/shared_system.h"
#include "platform/memory_return.h"
#include "thrum/thrum.h"

static int print_help(FILE *stream) {
  fprintf(
      stream,
      "thrum-mpi %s: thrum precompute, static --full and simulate --full by several processes\n\n"
      "usage: mpirun -n N thrum-mpi precompute MESH -o FILE [OPTIONS]\n"
      "       mpirun -n N thrum-mpi static MODEL|MESH --full [OPTIONS]\n"
      "       mpirun -n N thrum-mpi simulate MODEL|MESH --full [OPTIONS]\n\n"
      "Takes the options of these commands and writes the same files. Process 0 reads and writes\n"
      "them, so they are needed on its machine alone.\n\n",
      thrum_version());

  // three commands that work as they stand
  fputs(
      "examples:\n"
      "  mpirun -n 2 thrum-mpi precompute horse -o horse.npz\n"
      "  mpirun -n 2 thrum-mpi static horse.npz --full --load constant:0,0,-20@load\n"
      "  mpirun -n 2 thrum-mpi simulate horse.npz --full --load impulse:0,0,-9@load --time 0.1 \\\n"
      "    -o run\n\n"
      "exit codes: 0 done, 1 refused, 2 usage, 3 ran but flagged\n",
      stream);
  return COMMAND_DONE;
}

/* The command of process 0. */
static int lead_command(int argc, char **argv) {
  if (argc >= 2 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0))
    return print_help(stdout);
  if (argc < 2) {
    print_help(stderr);
    return COMMAND_USAGE;
  }

  // a command that runs here calls the others when it needs them
  shared_lead lead;
  shared_systems systems;
  shared_lead_begin(PETSC_COMM_WORLD, &lead);
  shared_systems_begin(PETSC_COMM_WORLD, shared_serve_system, &systems);
  if (strcmp(argv[1], "static") == 0)
    return cmd_static_shared(argc - 1, argv + 1, &systems.shared, &lead.shared);
  if (strcmp(argv[1], "simulate") == 0)
    return cmd_simulate_shared(argc - 1, argv + 1, &systems.shared, &lead.shared);
  if (strcmp(argv[1], "precompute") != 0)
    return config_usage(
        "", "thrum-mpi has the commands precompute, static and simulate, and not '%s'", argv[1]);
  return cmd_precompute_shared(argc - 1, argv + 1, &lead.shared);
}

/* Process 0 leads, the others serve it until it has its exit code. */
static int run(int argc, char **argv) {
  int rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank > 0) {
    shared_serve(PETSC_COMM_WORLD);
    return COMMAND_DONE;
  }
  const int code = lead_command(argc, argv);
  shared_serve_end(PETSC_COMM_WORLD);
  return code == COMMAND_HELPED ? COMMAND_DONE : code;
}

int main(int argc, char **argv) {
  if (!program_guard_begin(argv))
    return COMMAND_REFUSED;

  // PETSc takes no options from our command line; those of PETSC_OPTIONS it does
  if (SlepcInitialize(NULL, NULL, NULL, NULL) != 0) {
    fputs("thrum-mpi: PETSc and SLEPc could not be started\n", stderr);
    return program_guard_end(COMMAND_REFUSED);
  }
  PetscPushErrorHandler(PetscIgnoreErrorHandler, NULL);
  PetscPopSignalHandler();
  memory_return_begin();
  const int code = run(argc, argv);
  SlepcFinalize();
  return program_guard_end(code);
}
