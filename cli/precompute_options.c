/* Options of `thrum precompute`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/precompute_request.h"

#define COUNT_MAX 1000000 /* no mesh needs more modes; keeps products of counts in range */
#define THREADS_MAX 1024

enum {
  YOUNG = 256,
  POISSON,
  DENSITY,
  SCALE,
  MODES,
  RANK,
  MASS,
  THREADS,
  FIX,
  JSON,
  REPRODUCIBLE,
  CHECK,
  DRY_RUN,
  MEMORY,
  IMPORT_BASIS,
  IMPORT_CUBIC,
  EXPORT_MODES,
  HANDLES
};

static const struct option options[] = {
    {"output", required_argument, NULL, 'o'},
    {"young", required_argument, NULL, YOUNG},
    {"poisson", required_argument, NULL, POISSON},
    {"density", required_argument, NULL, DENSITY},
    {"scale", required_argument, NULL, SCALE},
    {"modes", required_argument, NULL, MODES},
    {"rank", required_argument, NULL, RANK},
    {"mass", required_argument, NULL, MASS},
    {"threads", required_argument, NULL, THREADS},
    {"fix", required_argument, NULL, FIX},
    {"dry-run", no_argument, NULL, DRY_RUN},
    {"memory", required_argument, NULL, MEMORY},
    {"check", required_argument, NULL, CHECK},
    {"handles", required_argument, NULL, HANDLES},
    {"import-basis", required_argument, NULL, IMPORT_BASIS},
    {"import-cubic", required_argument, NULL, IMPORT_CUBIC},
    {"export-modes", required_argument, NULL, EXPORT_MODES},
    {"reproducible", no_argument, NULL, REPRODUCIBLE},
    {"json", no_argument, NULL, JSON},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

void precompute_help(void) {
  fputs(
      "usage: thrum precompute MESH -o NAME.npz [--fix SPEC] [OPTIONS]\n\n"
      "Makes a reduced model of a tetrahedral mesh: linear modes, modal derivatives, basis, and\n"
      "the exact polynomial of its strain energy.\n\n"
      "MESH is a Vega .veg file, a Gmsh .msh file (2.2 or 4.1, ASCII), or a generated beam,\n"
      "beam:NXxNYxNZ@LXxLYxLZ: cells, then metres (before --scale); or the name of a model that\n"
      "comes with Thrum (beam, basket, bridge, horse, tower, heart), whose material, fixed set,\n"
      "modes and rank are then the defaults.\n\n"
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

static int number_option(const char *name, const char *text, double *value) {
  if (cli_parse_number(text, value))
    return CLI_DONE;
  return cli_usage("precompute", "--%s wants a number, not '%s'", name, text);
}

static int count_option(const char *name, const char *text, int64_t most, int64_t *value) {
  int64_t parsed = 0;
  if (!cli_parse_integer(text, &parsed) || parsed < 1 || parsed > most) {
    return cli_usage("precompute", "--%s wants a whole number from 1 to %lld, not '%s'", name,
                     (long long)most, text);
  }
  *value = parsed;
  return CLI_DONE;
}

static int mass_option(const char *text, thrum_mass *mass) {
  if (strcmp(text, "consistent") == 0) {
    *mass = THRUM_MASS_CONSISTENT;
  } else if (strcmp(text, "lumped") == 0) {
    *mass = THRUM_MASS_LUMPED;
  } else {
    return cli_usage("precompute", "--mass is consistent or lumped, not '%s'", text);
  }
  return CLI_DONE;
}

static int memory_option(const char *text, double *bytes) {
  int64_t megabytes = 0;
  const int code = count_option("memory", text, (int64_t)1 << 40, &megabytes);
  if (code == CLI_DONE)
    *bytes = 1048576 * (double)megabytes;
  return code;
}

static int check_option(const char *text, thrum_check *check) {
  static const char *const names[] = {"auto", "search", "inertia"};
  for (int n = 0; n < 3; n++)
    if (strcmp(text, names[n]) == 0) {
      *check = (thrum_check)n;
      return CLI_DONE;
    }
  return cli_usage("precompute", "--check is auto, search or inertia, not '%s'", text);
}

static int threads_option(const char *text, int *threads) {
  int64_t count = 0;
  const int code = count_option("threads", text, THREADS_MAX, &count);
  if (code == CLI_DONE)
    *threads = (int)count;
  return code;
}

/* One option that getopt_long recognised. */
static int apply_option(int option, precompute_request *request) {
  switch (option) {
  case 'o':
    request->output = optarg;
    return CLI_DONE;
  case YOUNG:
    return number_option("young", optarg, &request->material.young);
  case POISSON:
    return number_option("poisson", optarg, &request->material.poisson);
  case DENSITY:
    return number_option("density", optarg, &request->material.density);
  case SCALE:
    return number_option("scale", optarg, &request->scale);
  case MODES:
    request->modes_given = true;
    return count_option("modes", optarg, COUNT_MAX, &request->options.modes);
  case RANK:
    request->rank_given = true;
    return count_option("rank", optarg, COUNT_MAX, &request->options.rank);
  case MASS:
    return mass_option(optarg, &request->options.mass);
  case THREADS:
    return threads_option(optarg, &request->options.threads);
  case FIX:
    request->fixes[request->fix_count++] = optarg;
    return CLI_DONE;
  case DRY_RUN:
    request->dry_run = true;
    return CLI_DONE;
  case MEMORY:
    return memory_option(optarg, &request->options.memory_limit);
  case CHECK:
    return check_option(optarg, &request->options.check);
  case HANDLES:
    request->handles[request->handle_count++] = optarg;
    return CLI_DONE;
  case IMPORT_BASIS:
    request->import_basis = optarg;
    return CLI_DONE;
  case IMPORT_CUBIC:
    request->import_cubic = optarg;
    return CLI_DONE;
  case EXPORT_MODES:
    request->export_modes = optarg;
    return CLI_DONE;
  case REPRODUCIBLE:
    request->reproducible = true;
    return CLI_DONE;
  case JSON:
    request->json = true;
    return CLI_DONE;
  case 'q':
    request->quiet = true;
    return CLI_DONE;
  default:
    request->help = true;
    return CLI_DONE;
  }
}

int precompute_options_read(int argc, char **argv, precompute_request *request) {
  request->scale = 1;
  request->material = (thrum_material){NAN, NAN, NAN};
  request->options = thrum_default_precompute_options();
  opterr = 0;
  int option = 0;
  while ((option = getopt_long(argc, argv, ":o:qh", options, NULL)) != -1) {
    if (option == '?' || option == ':')
      return cli_usage_option("precompute", argv, options);
    const int code = apply_option(option, request);
    if (code != CLI_DONE || request->help)
      return code;
  }
  if (optind >= argc)
    return cli_usage("precompute", "no mesh given");
  if (optind + 1 < argc) {
    return cli_usage("precompute", "one mesh at a time, but '%s' follows '%s'", argv[optind + 1],
                     argv[optind]);
  }
  request->mesh_name = argv[optind];
  if (request->output == NULL && !request->dry_run) {
    return cli_usage("precompute", "no output given: say -o NAME.npz");
  }
  if (request->import_cubic && !request->import_basis)
    return cli_usage("precompute", "--import-cubic goes with --import-basis");
  if (request->import_basis &&
      (request->modes_given || request->rank_given || request->export_modes || request->dry_run ||
       request->handle_count > 0))
    return cli_usage("precompute", "--import-basis goes without --modes, --rank, --handles, "
                                   "--export-modes and --dry-run");
  return CLI_DONE;
}
