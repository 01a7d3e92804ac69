/* Going on as `thrum-mpi`, see mpi_program.h. A program that takes the place of this one gives back
 * all of its memory, keeps its process, and `thrum` links no MPI.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/mpi_program.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "config/message.h"
#include "io/paths.h"
#include "platform/allocate.h"

#define PROGRAM "thrum-mpi"
#define PATH_LENGTH 4096

extern char **environ;

/* Finds the path of thrum-mpi, as THRUM_MPI gives it or beside this program. False where there is
 * none, or where it is too long. */
static bool find_path(char path[PATH_LENGTH]) {
  const char *given = getenv("THRUM_MPI");
  if (given == NULL || given[0] == 0)
    return path_beside(PROGRAM, path, PATH_LENGTH);
  if (strlen(given) >= PATH_LENGTH)
    return false;
  memcpy(path, given, strlen(given) + 1);
  return true;
}

static bool is_program(const char *path) {
  struct stat status;
  return stat(path, &status) == 0 && S_ISREG(status.st_mode) && access(path, X_OK) == 0;
}

int mpi_program_wants_full(const char *command) {
  return config_usage(command, PROGRAM " is for the whole mesh: add --full");
}

bool mpi_program_exists(void) {
  char path[PATH_LENGTH];
  return find_path(path) && is_program(path);
}

/* The first variable by which mpirun or srun tells a process its place among others; NULL: none. */
static const char *find_place(void) {
  static const char *const launchers[] = {"OMPI_", "PMIX_", "PMI_"};
  for (char **variable = environ; *variable != NULL; variable++)
    for (size_t n = 0; n < sizeof launchers / sizeof launchers[0]; n++)
      if (strncmp(*variable, launchers[n], strlen(launchers[n])) == 0)
        return *variable;
  return NULL;
}

/* Forgets that mpirun or srun started this process, for jobs of a sweep each make their own model:
 * MPI would wait for the others. */
static void leave_launcher(void) {
  char name[256];
  for (const char *place = find_place(); place != NULL; place = find_place()) {
    const size_t length = strcspn(place, "=");
    if (length >= sizeof name)
      return;
    memcpy(name, place, length);
    name[length] = 0;
    unsetenv(name);
  }
}

thrum_status mpi_program_become(char *const *argv, thrum_error *error) {
  char path[PATH_LENGTH];
  if (!find_path(path))
    return thrum_error_set(error, THRUM_UNSUPPORTED, "where " PROGRAM " would lie is not known");
  if (!is_program(path))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "conjugate gradients are those of " PROGRAM
                           ", and %.300s is no program: "
                           "build it by ./run mpi, name it by THRUM_MPI, or leave --solver cg out",
                           path);

  // the program, the command and its arguments, and the NULL behind them
  int64_t count = 0;
  char **arguments = NULL;
  while (argv[count] != NULL)
    count++;
  THRUM_TRY(thrum_reserve(&arguments, count + 2, sizeof *arguments, "the arguments", error));
  arguments[0] = path;
  memcpy(arguments + 1, argv, (size_t)(count + 1) * sizeof *argv);

  leave_launcher();
  execv(path, arguments);
  const int number = errno;
  free(arguments);
  return thrum_error_set(error, THRUM_IO, "%.300s: %s", path, strerror(number));
}
