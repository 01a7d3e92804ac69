/* Options of `thrum precompute`. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "config/message.h"
#include "config/options.h"
#include "driver/precompute_request.h"

#define COUNT_MAX 1000000 /* no mesh needs more modes; keeps products of counts in range */
#define MEGABYTES_MAX 1099511627776.0

static int take_modes(const config_given *given, void *request) {
  precompute_request *r = request;
  r->modes_given = true;
  return config_given_count(given, &r->options.modes);
}

static int take_rank(const config_given *given, void *request) {
  precompute_request *r = request;
  r->rank_given = true;
  return config_given_count(given, &r->options.rank);
}

static int take_threads(const config_given *given, void *request) {
  int64_t count = 0;
  const int code = config_given_count(given, &count);
  if (code == COMMAND_DONE)
    ((precompute_request *)request)->options.threads = (int)count;
  return code;
}

static int take_memory(const config_given *given, void *request) {
  int64_t megabytes = 0;
  const int code = config_given_count(given, &megabytes);
  if (code == COMMAND_DONE)
    ((precompute_request *)request)->options.memory_limit = 1048576 * (double)megabytes;
  return code;
}

/* Where the n-th of a list stands, for messages once the mesh is there. The command line takes the
 * place of a whole list, so that a list is of one or the other. */
static void keep_line(const config_given *given, precompute_request *request, int64_t *lines,
                      int64_t n) {
  if (given->file == NULL || n >= CONFIG_FILE_ITEMS_MAX)
    return;
  request->lines_file = given->file;
  lines[n] = given->line;
}

static int take_fix(const config_given *given, void *request) {
  precompute_request *r = request;
  keep_line(given, r, r->fix_lines, r->fix_count);
  r->fixes[r->fix_count++] = given->text;
  return COMMAND_DONE;
}

static int take_handle(const config_given *given, void *request) {
  precompute_request *r = request;
  keep_line(given, r, r->handle_lines, r->handle_count);
  r->handles[r->handle_count++] = given->text;
  return COMMAND_DONE;
}

static void choose_mass(void *request, int index) {
  ((precompute_request *)request)->options.mass = (thrum_mass)index;
}

static void choose_check(void *request, int index) {
  ((precompute_request *)request)->options.check = (thrum_check)index;
}

static void choose_precision(void *request, int index) {
  ((precompute_request *)request)->options.single = index == 1;
}

/* In the order of their enums. */
static const char *const masses[] = {"consistent", "lumped", NULL};
static const char *const precisions[] = {"double", "single", NULL};
static const char *const checks[] = {"auto", "search", "inertia", NULL};

#define FIELD(member) .field = offsetof(precompute_request, member)

static void print_help(void) {
  fputs(
      "usage: thrum precompute MESH -o NAME.npz [--fix SPEC] [OPTIONS]\n\n"
      "Makes a reduced model of a tetrahedral mesh: linear modes, modal derivatives, basis, and\n"
      "the exact polynomial of its strain energy.\n\n"
      "MESH is a file of Vega (.veg), Gmsh (.msh), TetGen (.node and .ele), Medit (.mesh), VTK\n"
      "(.vtk, .vtu) or Abaqus (.inp), or a generated beam, beam:NXxNYxNZ@LXxLYxLZ: cells, then\n"
      "metres (before --scale); or the name of a model that comes with Thrum (beam, basket,\n"
      "bridge, horse, tower, heart), whose material, fixed set, modes and rank are then the\n"
      "defaults.\n\n"
      "  -o, --output FILE     the model file to write\n"
      "      --fix SPEC        hold vertices; repeatable. SPEC is a predicate in metres such as\n"
      "                        'x<0.01&z>0', or a file of 1-based vertices (2, 3:7, # comment),\n"
      "                        or a group of the mesh; a suffix such as :z or :xy picks the axes\n"
      "                        (without any: a free body, its six rigid modes kept apart)\n"
      "      --young PA        Young's modulus [Pa]        (default: the mesh's own material)\n"
      "      --poisson NU      Poisson's ratio, in (-1, 1/2)\n"
      "      --density RHO     density [kg/m^3]\n"
      "      --scale S         lengths of the mesh times S are metres, such as 1e-3 (default 1)\n"
      "      --modes K         linear modes (default 10)\n"
      "      --rank R          reduced coordinates, at most K (K + 3) / 2 (default 2 K)\n"
      "      --mass KIND       consistent (default) or lumped\n"
      "      --precision P     of the cubic and quartic coefficients: double (default), or "
      "single,\n"
      "                        which large models step faster with; says what error that costs\n"
      "      --check HOW       that no mode was missed: search, or inertia (an exact count by "
      "MUMPS,\n"
      "                        where it is built in); default auto, inertia for small meshes\n"
      "      --handles SPEC    a group or vertex=N that will be pulled; repeatable. Its static\n"
      "                        responses to forces along x, y, z are represented exactly\n"
      "      --import-basis FILE.U    take VegaFEM's basis in place of modes and derivatives; it "
      "is\n"
      "                        turned until it is mass-orthonormal and diagonalises the stiffness\n"
      "      --import-cubic FILE.cub  and VegaFEM's polynomial of that basis with it\n"
      "      --export-modes FILE.vtu  write the linear modes for ParaView as well\n"
      "      --threads N       threads of the linear algebra (default 1)\n"
      "      --dry-run         say what memory and about what time it would take, and stop; exit "
      "3\n"
      "                        when it would not fit\n"
      "      --memory MB       refuse what would take more (default: what the machine has left)\n"
      "      --reproducible    store no times in the file: two runs then give the same bytes\n"
      "      --options FILE.json  read options from a file (docs/options.md); those given here "
      "come first\n"
      "      --json            print one JSON object instead of the table\n"
      "  -q, --quiet           no progress\n"
      "  -h, --help            this text\n\n"
      "examples:\n"
      "  thrum precompute beam:20x3x3@1x0.15x0.15 --fix 'x<0.001' -o beam.npz\n"
      "  thrum precompute part.msh --scale 1e-3 --young 2e6 --poisson 0.45 --density 1100 \\\n"
      "      --fix clamp --fix 'z<0.002:z' --modes 12 --rank 30 -o part.npz\n"
      "  thrum precompute part.msh --fix clamp --modes 20 --rank 30 --dry-run\n"
      "  thrum precompute beam:20x3x3@1x0.15x0.15 --fix 'x<0.001' --handles tip -o pull.npz\n"
      "  thrum precompute horse --young 1e6 -o soft-horse.npz\n"
      "  thrum precompute beam.veg --fix beam.bou --import-basis beam.U --import-cubic beam.cub "
      "\\\n"
      "      -o beam.npz\n"
      "  thrum precompute bridge.veg --fix bridge.bou --threads 2 --json -o bridge.npz\n",
      stdout);
}

const config_option precompute_options_table[] = {
    {.name = "mesh",
     .kind = CONFIG_TEXT,
     .argument = true,
     .path = CONFIG_PATH_NAMED,
     FIELD(mesh_name)},
    CONFIG_OPTION_FILE(precompute_request),
    {.name = "output",
     .letter = 'o',
     .kind = CONFIG_TEXT,
     .path = CONFIG_PATH_ALWAYS,
     FIELD(output)},
    {.name = "fix",
     .kind = CONFIG_TEXT,
     .path = CONFIG_PATH_IF_THERE,
     .repeats = true,
     .take = take_fix},
    CONFIG_OPTIONS_MATERIAL(precompute_request, material),
    {.name = "scale",
     .kind = CONFIG_NUMBER,
     FIELD(scale),
     .most = INFINITY,
     .above = true,
     .wants = "a number above 0"},
    {.name = "modes", .kind = CONFIG_COUNT, .take = take_modes, .least = 1, .most = COUNT_MAX},
    {.name = "rank", .kind = CONFIG_COUNT, .take = take_rank, .least = 1, .most = COUNT_MAX},
    {.name = "mass", .kind = CONFIG_CHOICE, .names = masses, .choose = choose_mass},
    {.name = "precision", .kind = CONFIG_CHOICE, .names = precisions, .choose = choose_precision},
    {.name = "check", .kind = CONFIG_CHOICE, .names = checks, .choose = choose_check},
    {.name = "handles", .kind = CONFIG_TEXT, .repeats = true, .take = take_handle},
    {.name = "import-basis", .kind = CONFIG_TEXT, .path = CONFIG_PATH_ALWAYS, FIELD(import_basis)},
    {.name = "import-cubic", .kind = CONFIG_TEXT, .path = CONFIG_PATH_ALWAYS, FIELD(import_cubic)},
    {.name = "export-modes", .kind = CONFIG_TEXT, .path = CONFIG_PATH_ALWAYS, FIELD(export_modes)},
    {.name = "threads",
     .kind = CONFIG_COUNT,
     .take = take_threads,
     .least = 1,
     .most = CONFIG_THREADS_MAX},
    {.name = "dry-run", .kind = CONFIG_FLAG, FIELD(dry_run)},
    {.name = "memory",
     .kind = CONFIG_COUNT,
     .take = take_memory,
     .least = 1,
     .most = MEGABYTES_MAX},
    {.name = "reproducible", .kind = CONFIG_FLAG, FIELD(reproducible)},
    CONFIG_OPTION_JSON(precompute_request),
    CONFIG_OPTION_QUIET(precompute_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

int precompute_options_read(int argc, char **argv, precompute_request *request) {
  request->scale = 1;
  request->material = (thrum_material){NAN, NAN, NAN};
  request->options = thrum_default_precompute_options();
  int code = config_options_read("precompute", precompute_options_table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  code = config_one_argument("precompute", "mesh", argc, argv, &request->mesh_name);
  if (code != COMMAND_DONE)
    return code;
  if (request->output == NULL && !request->dry_run) {
    return config_usage("precompute", "no output given: say -o NAME.npz");
  }
  if (request->import_cubic && !request->import_basis)
    return config_usage("precompute", "--import-cubic goes with --import-basis");
  if (request->import_basis && (request->modes_given || request->rank_given ||
                                request->export_modes || request->handle_count > 0))
    return config_usage("precompute", "--import-basis goes without --modes, --rank, --handles "
                                      "and --export-modes");
  return COMMAND_DONE;
}
