/* Meshes are read by the reader that the suffix of the file names, and then cleaned.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "mesh/divide_shells.h"
#include "mesh/formats/file_suffix.h"
#include "mesh/mesh_beam.h"
#include "mesh/mesh_clean.h"
#include "mesh/mesh_elements.h"
#include "mesh/mesh_shells.h"
#include "mesh/mesh_units.h"
#include "mesh/midsides.h"
#include "mesh/solids.h"

static const struct {
  const char *suffix;
  thrum_mesh_parser *parse;
} PARSERS[] = {{".veg", thrum_mesh_parse_veg},    {".msh", thrum_mesh_parse_msh},
               {".mesh", thrum_mesh_parse_medit}, {".vtk", thrum_mesh_parse_vtk},
               {".vtu", thrum_mesh_parse_vtu},    {".inp", thrum_mesh_parse_abaqus}};

static thrum_mesh_parser *find_parser(const char *name) {
  for (size_t i = 0; i < sizeof PARSERS / sizeof *PARSERS; i++)
    if (thrum_file_has_suffix(name, PARSERS[i].suffix))
      return PARSERS[i].parse;
  return NULL;
}

/* Do hexahedra and wedges stay? Ten nodes are those of tetrahedra. */
static bool keeps_solids(const thrum_mesh_read_options *options) {
  return options->element != THRUM_ELEMENT_TET && options->order != 2;
}

static thrum_status read_file(const char *path, const thrum_mesh_read_options *options,
                              thrum_mesh_parser *parse, thrum_mesh *mesh, thrum_error *error) {
  void *data = NULL;
  size_t size = 0;
  thrum_status status = thrum_file_read(path, &data, &size, error);
  const bool solids = keeps_solids(options);
  const thrum_mesh_source source = {path,  data, size, options->regions, options->order == 1,
                                    solids};
  THRUM_THEN(status, thrum_file_name_memory(path, parse(&source, mesh, error), error));
  free(data);
  return status;
}

char *thrum_tetgen_name(const char *path, const char *suffix, thrum_scope *scope) {
  const size_t stem = strlen(path) - (thrum_file_has_suffix(path, ".ele") ? 4 : 5);
  char *name = thrum_scope_allocate(scope, (int64_t)(stem + strlen(suffix) + 1), 1);
  if (name) {
    memcpy(name, path, stem);
    strcpy(name + stem, suffix);
  }
  return name;
}

/* TetGen's meshes are pairs of files; the path of either one names both. */
static thrum_status read_tetgen(const char *path, bool corners, thrum_mesh *mesh,
                                thrum_error *error) {
  static const char *const suffixes[2] = {".node", ".ele"};
  thrum_scope scope = thrum_scope_begin("the mesh", error);
  const char *const names[2] = {thrum_tetgen_name(path, ".node", &scope),
                                thrum_tetgen_name(path, ".ele", &scope)};
  void *data[2] = {NULL, NULL};
  size_t size[2] = {0, 0};

  // the one that was given keeps its capitals
  thrum_status status = scope.status;
  for (int i = 0; i < 2 && status >= 0; i++)
    status = thrum_file_read(thrum_file_has_suffix(path, suffixes[i]) ? path : names[i], &data[i],
                             &size[i], error);

  // the parser needs both texts at once, since tets name nodes
  const thrum_mesh_source nodes = {names[0], data[0], size[0], NULL, corners, false};
  const thrum_mesh_source elements = {names[1], data[1], size[1], NULL, corners, false};
  THRUM_THEN(status, thrum_file_name_memory(
                         path, thrum_mesh_parse_tetgen(&nodes, &elements, mesh, error), error));

  free(data[0]);
  free(data[1]);
  thrum_scope_free(&scope);
  return status;
}

/* Refuses a suffix that no reader knows, and says which kinds of file there are. */
static thrum_status refuse_kind(const char *name, thrum_error *error) {
  if (thrum_file_has_suffix(name, ".stl") || thrum_file_has_suffix(name, ".obj"))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: unknown kind of mesh; it is a surface: fill it with "
                           "tetrahedra by thrum mesh",
                           name);
  if (thrum_file_has_suffix(name, ".unv") || thrum_file_has_suffix(name, ".bdf") ||
      thrum_file_has_suffix(name, ".nas"))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: unknown kind of mesh; Gmsh reads it: gmsh FILE -save -format "
                           "msh41 -o NEW.msh",
                           name);
  if (thrum_file_has_suffix(name, ".step") || thrum_file_has_suffix(name, ".stp"))
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "%.200s: is a geometry, not a mesh; thrum mesh FILE -o NEW.msh meshes it", name);
  if (thrum_file_has_suffix(name, ".geo"))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: is a geometry, not a mesh; Gmsh meshes it: gmsh FILE -3 "
                           "-format msh41 -o NEW.msh",
                           name);
  if (thrum_file_has_suffix(name, ".meshb"))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: is a Medit mesh in binary; save it in ASCII, as .mesh", name);
  if (thrum_file_has_suffix(name, ".npz"))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: unknown kind of mesh; thrum info says what a model file holds",
                           name);
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "%.200s: unknown kind of mesh; give a .veg, .msh, .node, .ele, .mesh, "
                         ".vtk, .vtu or .inp file, or a generator such as "
                         "beam:20x3x3@1x0.15x0.15",
                         name);
}

bool thrum_mesh_is_named(const char *name) {
  return strncmp(name, "beam:", 5) == 0 || find_parser(name) ||
         thrum_file_has_suffix(name, ".node") || thrum_file_has_suffix(name, ".ele");
}

thrum_status thrum_mesh_read(const char *name, double scale, thrum_mesh *mesh, thrum_error *error) {
  return thrum_mesh_read_order(name, scale, 0, mesh, error);
}

thrum_status thrum_mesh_read_order(const char *name, double scale, int order, thrum_mesh *mesh,
                                   thrum_error *error) {
  const thrum_mesh_read_options options = {
      .scale = scale, .order = order, .element = THRUM_ELEMENT_TET};
  return thrum_mesh_read_with(name, &options, mesh, error);
}

/* A name means a generator, a single file or one of a pair of files. */
static thrum_status read_named(const char *name, const thrum_mesh_read_options *options,
                               thrum_mesh *mesh, thrum_error *error) {
  thrum_mesh_parser *parse = find_parser(name);
  if (name[0] == '\0')
    return thrum_error_set(error, THRUM_IO, "the name of the mesh is empty");
  if (strncmp(name, "beam:", 5) == 0)
    return thrum_mesh_beam(name, mesh, error);

  // only VTK's cell data has names
  if (options->regions && parse != thrum_mesh_parse_vtk && parse != thrum_mesh_parse_vtu)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: regions by name are cell data of .vtk and .vtu files", name);
  if (parse)
    return read_file(name, options, parse, mesh, error);
  if (thrum_file_has_suffix(name, ".node") || thrum_file_has_suffix(name, ".ele"))
    return read_tetgen(name, options->order == 1, mesh, error);
  return refuse_kind(name, error);
}

/* Reads the unit; without one lengths and materials are those of SI. */
static thrum_status read_unit(const char *name, const char *text, thrum_mesh_unit *unit,
                              thrum_error *error) {
  *unit = (thrum_mesh_unit){1, 1, 1};
  if (!text)
    return THRUM_OK;
  if (strncmp(name, "beam:", 5) == 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "'%.100s' is in metres; a unit is that of a file", name);
  return thrum_mesh_unit_read(text, unit, error);
}

/* Wedges of six nodes bend too stiffly, thick ones as linear tetrahedra do and thin ones by how
 * their diagonals lie: they stay where they are asked for alone. */
static thrum_status choose_wedges(const thrum_mesh_read_options *options, thrum_mesh *mesh,
                                  bool *divided, thrum_error *error) {
  int64_t counts[THRUM_FORMS];
  thrum_mesh_count_forms(mesh, counts);
  const long long thin = counts[THRUM_FORM_SHELL6], thick = counts[THRUM_FORM_WEDGE6];
  if (thin + thick == 0 || options->element == THRUM_ELEMENT_FILE)
    return THRUM_OK;
  if (options->element != THRUM_ELEMENT_AUTO) {
    thrum_mesh_add_note(mesh,
                        "%lld elements are wedges of six nodes, which bend too stiffly: compare "
                        "with --element tet, or with twice as many",
                        thin + thick);
    return THRUM_OK;
  }

  // solid-shell hexahedra do not lock, and a wedge is three of them
  if (thick == 0)
    THRUM_TRY(thrum_mesh_divide_shells(mesh, divided, error));
  if (*divided) {
    thrum_mesh_add_note(mesh,
                        "%lld thin wedges are taken as three solid-shell hexahedra each "
                        "(--element shell: as they are, --element tet: tetrahedra)",
                        thin);
    return THRUM_OK;
  }
  thrum_mesh_add_note(mesh,
                      "all elements were cut into tetrahedra, as %lld are wedges of six nodes, "
                      "which bend too stiffly (--element solid: they stay)",
                      thin + thick);
  thrum_mesh_drop_solids(mesh);
  return THRUM_OK;
}

/* Which of the elements that stay are solid-shells. */
static thrum_status choose_solids(const thrum_mesh_read_options *options, thrum_mesh *mesh,
                                  thrum_error *error) {
  const bool automatic = options->element == THRUM_ELEMENT_AUTO;
  const long long all = mesh->solid_count;
  const long long thin =
      thrum_mesh_choose_shells(mesh, automatic                                 ? THRUM_SHELL_THIN
                                     : options->element == THRUM_ELEMENT_SHELL ? INFINITY
                                                                               : 0);
  bool divided = false;
  THRUM_TRY(choose_wedges(options, mesh, &divided, error));
  if (thin > 0 && automatic && !divided && mesh->solid_count > 0)
    thrum_mesh_add_note(mesh,
                        "%lld of %lld elements are thin, and are taken as solid-shells "
                        "(--element solid: none is, --element tet: tetrahedra)",
                        thin, all);
  return THRUM_OK;
}

/* Says that hexahedra of a beam were cut, as the reader does of a file's, and for what. */
static void note_cut(const char *why, thrum_mesh *mesh) {
  if (mesh->solid_count > 0) {
    mesh->cut_note = thrum_mesh_add_note(mesh, "%lld hexahedra were cut into %lld tetrahedra",
                                         (long long)mesh->solid_count, (long long)mesh->tet_count);
    mesh->cut_elements = mesh->solid_count;
  }
  if (mesh->cut_note == 0 || !why)
    return;
  char *text = mesh->notes[mesh->cut_note - 1].text;
  const size_t length = strlen(text);
  snprintf(text + length, sizeof mesh->notes->text - length, "; %s tetrahedra alone", why);
}

thrum_status thrum_mesh_check_kept(const char *name, const thrum_mesh_read_options *options,
                                   const thrum_mesh *mesh, thrum_error *error) {
  if (options->element <= THRUM_ELEMENT_TET || mesh->solid_count > 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "%.200s: --element says which hexahedra and wedges stay, and %s: leave it "
                         "out",
                         name,
                         mesh->cut_elements > 0
                             ? "its elements cannot, as it has pyramids, elements of several "
                               "orders, or some with a node twice"
                             : "it has tetrahedra alone");
}

thrum_status thrum_mesh_read_with(const char *name, const thrum_mesh_read_options *asked,
                                  thrum_mesh *mesh, thrum_error *error) {
  thrum_mesh_read_options made = *asked, *options = &made;
  const char *why = NULL;
  if (asked->element == THRUM_ELEMENT_AUTO && (asked->tets_for || asked->order == 2)) {
    made.element = THRUM_ELEMENT_TET;
    why = asked->tets_for ? asked->tets_for : "--order 2 takes";
  }
  thrum_mesh read = {0};
  thrum_mesh_unit unit;
  thrum_status status = read_unit(name, options->unit, &unit, error);
  THRUM_THEN(status, read_named(name, options, &read, error));

  // the nodes of elements that stay are those of the file
  if (status >= 0 && options->order == 2 &&
      (options->element == THRUM_ELEMENT_SOLID || options->element == THRUM_ELEMENT_SHELL))
    status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "%.200s: --order 2 cuts elements into tetrahedra, and --element says "
                             "that they stay: leave one out",
                             name);

  // a beam has its hexahedra where a file has them
  if (status >= 0 && !keeps_solids(options)) {
    note_cut(why, &read);
    thrum_mesh_drop_solids(&read);
  }

  // every source may repeat vertices or leave some unused
  if (status >= 0 && options->order == 1)
    thrum_midsides_drop(&read);
  THRUM_THEN(status, thrum_mesh_clean(&read, name, options->scale * unit.length, error));
  if (status >= 0 && read.solid_count > 0)
    status = choose_solids(options, &read, error);
  if (options->order == 2 && !read.midsides)
    THRUM_THEN(status, thrum_midsides_add(&read, error));
  if (status >= 0)
    thrum_mesh_unit_materials(&unit, &read);

  return thrum_mesh_deliver(status, &read, mesh);
}
