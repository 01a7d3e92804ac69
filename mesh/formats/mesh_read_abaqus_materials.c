/* Materials and sections of Abaqus decks, and the keywords that are passed over.
 *
 * Steps, loads, supports, contact and output are not the mesh's, and go without a word. A keyword
 * that would place, make or remove nodes or elements in a way that is not read is refused. One that
 * says something else of the body (a tie, a shell, a point mass), or that is not known, is told of
 * in a line. A law beside *ELASTIC is told of with the material that has it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "mesh/formats/mesh_read_abaqus.h"
#include "mesh/mesh_groups.h"

/* --- materials ---------------------------------------------------------------------------------
 */

static const inp_material *find_material(const inp_reader *r, thrum_word name) {
  for (int64_t i = 0; i < r->material_count; i++)
    if (inp_same(r->materials[i].name, name))
      return &r->materials[i];
  return NULL;
}

thrum_status inp_read_material(inp_reader *r, const inp_keyword *keyword) {
  const inp_material material = {.name = inp_parameter_of(keyword, "NAME")};

  // sections name materials, so their names must be unique
  if (find_material(r, material.name))
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT, "this material comes twice");
  return thrum_mesh_append_few(inp_text(r), "materials", &r->materials, &r->material_count,
                               &material, sizeof material);
}

/* Refuses a property that changes with temperature or a field: there is one stiffness of a body. */
static thrum_status refuse_dependent(inp_reader *r, const inp_keyword *keyword) {
  return thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                         "*%s changes with temperature or a field; leave the one line that is to "
                         "hold",
                         thrum_text_excerpt(keyword->name).text);
}

/* Refuses an *ELASTIC of another kind: its constants say what the solver does not know. */
static thrum_status find_elastic(inp_reader *r, const inp_keyword *keyword, bool *constants,
                                 bool *moduli) {
  const thrum_word type = inp_parameter_of(keyword, "TYPE");
  *constants = inp_is(type, "ENGINEERING CONSTANTS");
  *moduli = inp_is(type, "ORTHO") || inp_is(type, "ORTHOTROPIC");
  if (type.length == 0 || inp_is(type, "ISOTROPIC") || inp_is(type, "ISO") || *constants || *moduli)
    return THRUM_OK;
  return thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                         "*ELASTIC of type %s is not supported, only ISOTROPIC, ORTHO and "
                         "ENGINEERING CONSTANTS",
                         thrum_text_excerpt(type).text);
}

/* Nine numbers, eight on the first line. */
static thrum_status read_nine(inp_reader *r, double numbers[9]) {
  for (int n = 0; n < 9; n++) {
    if (n == 8 && !inp_data_line(r))
      return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                             "a material with directions has nine constants, eight of them on the "
                             "first line");
    THRUM_TRY(inp_number(r, "a constant of the material", &numbers[n]));
  }
  return THRUM_OK;
}

/* Constants with directions, of either kind, into the row of the material. */
static thrum_status read_directed(inp_reader *r, bool moduli, inp_material *material) {
  double n[9], *row = material->row;
  thrum_elastic_matrix root;
  THRUM_TRY(read_nine(r, n));
  material->directed = true;
  if (moduli) {
    // D1111, D1122, D2222, D1133, D2233, D3333, D1212, D1313, D2323
    thrum_elastic_matrix c = {{n[0], n[1], n[3], 0, 0, 0}, {n[1], n[2], n[4], 0, 0, 0},
                              {n[3], n[4], n[5], 0, 0, 0}, {0, 0, 0, n[8], 0, 0},
                              {0, 0, 0, 0, n[7], 0},       {0, 0, 0, 0, 0, n[6]}};
    if (thrum_elastic_constants(c, row))
      return THRUM_OK;
  } else {
    // E1, E2, E3, nu12, nu13, nu23, G12, G13, G23
    memcpy(row + THRUM_ELASTIC_YOUNG, n, sizeof n);
    if (thrum_elastic_root(row, root))
      return THRUM_OK;
  }
  return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                         "the constants of this material have no positive energy");
}

thrum_status inp_read_property(inp_reader *r, const inp_keyword *keyword) {
  const bool elastic = inp_is(keyword->name, "ELASTIC");
  bool constants = false, moduli = false;
  if (r->material_count == 0)
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT, "a property comes before any *MATERIAL");
  if (elastic)
    THRUM_TRY(find_elastic(r, keyword, &constants, &moduli));

  // the values belong to the last *MATERIAL
  inp_material *material = &r->materials[r->material_count - 1];
  if (!inp_data_line(r))
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                           "the file ends, or goes on, before the values of the material");

  // a temperature may stand behind the constants; with one line it changes nothing
  if (elastic) {
    material->directed = false;
    if (constants || moduli) {
      THRUM_TRY(read_directed(r, moduli, material));
    } else {
      THRUM_TRY(inp_number(r, "Young's modulus", &material->values.young));
      THRUM_TRY(inp_number(r, "Poisson's ratio", &material->values.poisson));
    }
    material->has_elastic = true;
  } else {
    THRUM_TRY(inp_number(r, "the density", &material->values.density));
    material->has_density = true;
  }
  return inp_data_line(r) ? refuse_dependent(r, keyword) : THRUM_OK;
}

thrum_status inp_read_orientation(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word system = inp_parameter_of(keyword, "SYSTEM");
  inp_orientation made = {.name = inp_parameter_of(keyword, "NAME")};
  const bool plain = (system.length == 0 || inp_is(system, "RECTANGULAR") || inp_is(system, "R")) &&
                     !inp_has_parameter(keyword, "DEFINITION") &&
                     !inp_has_parameter(keyword, "LOCAL DIRECTIONS");
  static const double origin[3] = {0, 0, 0};

  // another system, or one with an origin, matters only where a material has directions
  if (plain && inp_data_line(r)) {
    for (int c = 0; c < 6; c++)
      THRUM_TRY(inp_number(r, "a direction", c < 3 ? &made.first[c] : &made.second[c - 3]));
    if (inp_more(r))
      made.first[0] = made.first[1] = made.first[2] = 0;
  }

  // a further line turns both about one of the axes that they make
  double axes[3][3], row[THRUM_ELASTIC_NUMBERS] = {0}, axis = 0, degrees = 0;
  memcpy(row + THRUM_ELASTIC_FIRST, made.first, sizeof made.first);
  memcpy(row + THRUM_ELASTIC_SECOND, made.second, sizeof made.second);
  if (plain && inp_data_line(r)) {
    THRUM_TRY(inp_number(r, "an axis", &axis));
    THRUM_TRY(inp_number(r, "an angle", &degrees));
    if (!(axis >= 1 && axis <= 3) || !thrum_elastic_axes(row, NULL, axes))
      return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                             "an *ORIENTATION turns about axis 1, 2 or 3 of two directions");
    memcpy(made.first, axes[0], sizeof made.first);
    memcpy(made.second, axes[1], sizeof made.second);
    inp_turn(origin, axes[(int)axis - 1], degrees, made.first);
    inp_turn(origin, axes[(int)axis - 1], degrees, made.second);
  }
  return thrum_mesh_append_few(inp_text(r), "orientations", &r->orientations, &r->orientation_count,
                               &made, sizeof made);
}

thrum_status inp_read_section(inp_reader *r, const inp_keyword *keyword) {
  const inp_section section = {
      inp_parameter_of(keyword, "ELSET"), inp_parameter_of(keyword, "MATERIAL"),
      inp_parameter_of(keyword, "ORIENTATION"), thrum_included_line(&r->files)};
  if (inp_has_parameter(keyword, "COMPOSITE"))
    return thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                           "*SOLID SECTION, COMPOSITE is not read: mesh each layer, with a section "
                           "of its own");
  if (section.set.length == 0 || section.material.length == 0)
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                           "*SOLID SECTION needs ELSET=SET and MATERIAL=NAME");

  // the names are resolved at the end, since sets and materials may follow
  return thrum_mesh_append_few(inp_text(r), "sections", &r->sections, &r->section_count, &section,
                               sizeof section);
}

/* Tells what is left out of a material that a region is made of. */
static void note_law(const inp_section *section, const inp_material *material, thrum_mesh *mesh) {
  const thrum_excerpt name = thrum_text_excerpt(material->name);
  const thrum_excerpt law = thrum_text_excerpt(material->law);
  if (material->law.length > 0 && material->has_elastic)
    thrum_mesh_add_note(mesh,
                        "material '%s' has *%s on line %lld, which is not read: it is taken as "
                        "linear elastic, by its *ELASTIC",
                        name.text, law.text, (long long)material->law_line);
  else if (material->law.length > 0)
    thrum_mesh_add_note(mesh,
                        "material '%s' is *%s on line %lld, which is not read: say what it is made "
                        "of by --material %s:E,NU,RHO, a law behind it",
                        name.text, law.text, (long long)material->law_line,
                        thrum_text_excerpt(section->set).text);
}

/* Finds the material of a region's section, which names the region. */
static thrum_status section_material(inp_reader *r, int64_t region, thrum_mesh *mesh,
                                     const inp_section **section, const inp_material **material) {
  const int64_t key = r->builder.region_keys[region];
  if (key < 0)
    return thrum_error_set(r->error, THRUM_MISSING,
                           "%.150s: some tets are in no *SOLID SECTION, so they have no material",
                           r->files.files[0].path);
  *section = &r->sections[key];
  *material = find_material(r, (*section)->material);
  if (!*material)
    return thrum_error_set(r->error, THRUM_MISSING, "%.150s:%lld: there is no material '%s'",
                           r->files.files[0].path, (long long)(*section)->line,
                           thrum_text_excerpt((*section)->material).text);
  return thrum_mesh_name_region(mesh, region, (*section)->set.text, (*section)->set.length,
                                r->error);
}

/* Calls the regions by their sets, where no section says what they are. */
static thrum_status name_by_sets(inp_reader *r, thrum_mesh *mesh) {
  for (int64_t i = 0; i < mesh->region_count && r->region_sets; i++) {
    const int64_t key = r->builder.region_keys[i];
    if (key >= 0)
      THRUM_TRY(thrum_mesh_name_region(mesh, i, r->sets[key].name.text, r->sets[key].name.length,
                                       r->error));
  }
  return THRUM_OK;
}

/* Gives a region a material with directions: those of its section, or x and y. */
static thrum_status give_directions(const inp_reader *r, const inp_section *section,
                                    const inp_material *material, int64_t region,
                                    thrum_mesh *mesh) {
  static const double origin[3] = {0, 0, 0}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
  double row[THRUM_ELASTIC_NUMBERS], *first = row + THRUM_ELASTIC_FIRST, axis[3];
  double *second = row + THRUM_ELASTIC_SECOND;
  memcpy(row, material->row, sizeof row);
  memcpy(first, x, sizeof x);
  memcpy(second, y, sizeof y);
  int64_t n = 0;
  while (n < r->orientation_count && !inp_same(r->orientations[n].name, section->orientation))
    n++;
  if (section->orientation.length > 0) {
    if (n == r->orientation_count)
      return thrum_error_set(r->error, THRUM_MISSING, "%.150s:%lld: there is no orientation '%s'",
                             r->files.files[0].path, (long long)section->line,
                             thrum_text_excerpt(section->orientation).text);
    memcpy(first, r->orientations[n].first, sizeof x);
    memcpy(second, r->orientations[n].second, sizeof y);
  }

  // an instance that turns takes them with it
  for (int c = 0; c < 3; c++)
    axis[c] = r->instance.axis[1][c] - r->instance.axis[0][c];
  inp_turn(origin, axis, r->instance.degrees, first);
  inp_turn(origin, axis, r->instance.degrees, second);
  double axes[3][3];
  if (!thrum_elastic_axes(row, NULL, axes))
    return thrum_error_set(r->error, THRUM_UNSUPPORTED,
                           "%.150s:%lld: a material with directions needs an *ORIENTATION of two "
                           "directions that are not parallel, SYSTEM=RECTANGULAR",
                           r->files.files[0].path, (long long)section->line);
  return thrum_mesh_set_elastic(mesh, region, row, 1, r->error);
}

/* Sets the material of each region. Files for statics often have no density: if no section has a
 * complete material, the mesh has none, and the user must give it. */
thrum_status inp_region_materials(inp_reader *r, thrum_mesh *mesh) {
  int64_t whole = 0;
  const inp_section *partial = NULL, *section = NULL;
  const inp_material *material = NULL;
  THRUM_TRY(name_by_sets(r, mesh));
  for (int64_t i = 0; i < mesh->region_count && r->section_count > 0; i++) {
    THRUM_TRY(section_material(r, i, mesh, &section, &material));
    note_law(section, material, mesh);

    // incomplete materials are an error only beside complete ones
    mesh->materials[i] = material->values;
    if (material->directed)
      THRUM_TRY(give_directions(r, section, material, i, mesh));
    if (material->has_elastic && material->has_density)
      whole++;
    else
      partial = section;
  }

  // a mixture of complete and incomplete materials is a mistake in the file
  if (whole > 0 && partial)
    return thrum_error_set(r->error, THRUM_MISSING,
                           "%.150s:%lld: material '%s' needs both *ELASTIC and *DENSITY",
                           r->files.files[0].path, (long long)partial->line,
                           thrum_text_excerpt(partial->material).text);

  // without any complete material the mesh has none, so half-read values are cleared
  mesh->has_material = whole > 0;
  for (int64_t i = 0; i < mesh->region_count && !mesh->has_material; i++)
    mesh->materials[i] = (thrum_material){0};
  return THRUM_OK;
}

/* --- keywords that are passed over -------------------------------------------------------------
 */

static const char NO_STIFFNESS[] = "its elements have no stiffness and no mass here";
static const char NO_MASS[] = "these points or elements have no mass here";
static const char FREE[] = "what it ties or constrains is free here";

/* What keywords mean that no reader takes: by `refuse` the way out for one that would change the
 * mesh, by `effect` what follows from leaving one out, by neither nothing. */
static const struct {
  const char *name, *refuse, *effect;
} PASSED[] = {
    {"NMAP", "write the deck with its nodes where they are", NULL},
    {"IMPERFECTION", "write the deck with its nodes where they are", NULL},
    {"PARAMETER SHAPE VARIATION", "write the deck with its nodes where they are", NULL},
    {"SYMMETRIC MODEL GENERATION", "write the deck with all of its elements", NULL},
    {"IMPORT", "write the deck with its nodes and elements", NULL},
    {"RESTART READ", "write the deck with its nodes and elements", NULL},
    {"PARAMETER", "write the deck with numbers in the place of its parameters", NULL},
    {"UEL PROPERTY", "mesh the body with C3D4, C3D10, C3D8 and the like", NULL},
    {"EULERIAN SECTION", "mesh the body with C3D4, C3D10, C3D8 and the like", NULL},

    {"SHELL SECTION", NULL, NO_STIFFNESS},
    {"SHELL GENERAL SECTION", NULL, NO_STIFFNESS},
    {"MEMBRANE SECTION", NULL, NO_STIFFNESS},
    {"BEAM SECTION", NULL, NO_STIFFNESS},
    {"BEAM GENERAL SECTION", NULL, NO_STIFFNESS},
    {"FRAME SECTION", NULL, NO_STIFFNESS},
    {"SURFACE SECTION", NULL, NO_STIFFNESS},
    {"COHESIVE SECTION", NULL, NO_STIFFNESS},
    {"GASKET SECTION", NULL, NO_STIFFNESS},
    {"CONNECTOR SECTION", NULL, NO_STIFFNESS},
    {"FLUID SECTION", NULL, NO_STIFFNESS},
    {"USER ELEMENT", NULL, NO_STIFFNESS},
    {"SPRING", NULL, NO_STIFFNESS},
    {"DASHPOT", NULL, NO_STIFFNESS},
    {"GAP", NULL, NO_STIFFNESS},
    {"REBAR LAYER", NULL, NO_STIFFNESS},
    {"REBAR", NULL, NO_STIFFNESS},
    {"MASS", NULL, NO_MASS},
    {"ROTARY INERTIA", NULL, NO_MASS},
    {"NONSTRUCTURAL MASS", NULL, NO_MASS},
    {"TIE", NULL, FREE},
    {"EQUATION", NULL, FREE},
    {"MPC", NULL, FREE},
    {"RIGID BODY", NULL, FREE},
    {"COUPLING", NULL, FREE},
    {"DISTRIBUTING COUPLING", NULL, FREE},
    {"KINEMATIC COUPLING", NULL, FREE},
    {"EMBEDDED ELEMENT", NULL, FREE},
    {"FASTENER", NULL, FREE},
    {"CYCLIC SYMMETRY MODEL", NULL, FREE},
    {"PRE-TENSION SECTION", NULL, FREE},
    {"MODEL CHANGE", NULL, "the elements that it removes stay"},

    {"ACOUSTIC MEDIUM", NULL, NULL},
    {"AMPLITUDE", NULL, NULL},
    {"ASSEMBLY", NULL, NULL},
    {"BASE MOTION", NULL, NULL},
    {"BOUNDARY", NULL, NULL},
    {"CFLUX", NULL, NULL},
    {"CHANGE FRICTION", NULL, NULL},
    {"CLEARANCE", NULL, NULL},
    {"CLOAD", NULL, NULL},
    {"CONDUCTIVITY", NULL, NULL},
    {"CONNECTOR BEHAVIOR", NULL, NULL},
    {"CONSTRAINT CONTROLS", NULL, NULL},
    {"CONTROLS", NULL, NULL},
    {"COORDINATE SYSTEM", NULL, NULL},
    {"COUPLED TEMPERATURE-DISPLACEMENT", NULL, NULL},
    {"CREEP STRAIN RATE CONTROL", NULL, NULL},
    {"DEPVAR", NULL, NULL},
    {"DESIGN VARIABLES", NULL, NULL},
    {"DESIGNVARIABLES", NULL, NULL},
    {"DFLUX", NULL, NULL},
    {"DISTRIBUTING", NULL, NULL},
    {"DISTRIBUTION", NULL, NULL},
    {"DISTRIBUTION TABLE", NULL, NULL},
    {"DLOAD", NULL, NULL},
    {"DSLOAD", NULL, NULL},
    {"DYNAMIC", NULL, NULL},
    {"ELECTRICAL CONDUCTIVITY", NULL, NULL},
    {"ELEMENT OUTPUT", NULL, NULL},
    {"END ASSEMBLY", NULL, NULL},
    {"END INSTANCE", NULL, NULL},
    {"END PART", NULL, NULL},
    {"FILM", NULL, NULL},
    {"FILM PROPERTY", NULL, NULL},
    {"FLUID CONSTANTS", NULL, NULL},
    {"FREQUENCY", NULL, NULL},
    {"FRICTION", NULL, NULL},
    {"GAP CONDUCTANCE", NULL, NULL},
    {"GAP HEAT GENERATION", NULL, NULL},
    {"HEADING", NULL, NULL},
    {"HEAT TRANSFER", NULL, NULL},
    {"HOURGLASS STIFFNESS", NULL, NULL},
    {"INITIAL CONDITIONS", NULL, NULL},
    {"INSTANCE", NULL, NULL},
    {"KINEMATIC", NULL, NULL},
    {"LATENT HEAT", NULL, NULL},
    {"MAGNETIC PERMEABILITY", NULL, NULL},
    {"NODAL THICKNESS", NULL, NULL},
    {"NODE OUTPUT", NULL, NULL},
    {"NORMAL", NULL, NULL},
    {"OBJECTIVE", NULL, NULL},
    {"OUTPUT", NULL, NULL},
    {"PART", NULL, NULL},
    {"PHYSICAL CONSTANTS", NULL, NULL},
    {"PREPRINT", NULL, NULL},
    {"RADIATE", NULL, NULL},
    {"RESTART", NULL, NULL},
    {"SECTION CONTROLS", NULL, NULL},
    {"SPECIFIC GAS CONSTANT", NULL, NULL},
    {"SPECIFIC HEAT", NULL, NULL},
    {"STATIC", NULL, NULL},
    {"STEP", NULL, NULL},
    {"SUBMODEL", NULL, NULL},
    {"TEMPERATURE", NULL, NULL},
    {"TIME POINTS", NULL, NULL},
    {"TRANSFORM", NULL, NULL},
    {"TRANSVERSE SHEAR STIFFNESS", NULL, NULL},
    {"USER OUTPUT VARIABLES", NULL, NULL},
    {"VALUES AT INFINITY", NULL, NULL},
    {"VIEWFACTOR", NULL, NULL},
};

/* Beginnings of keywords of contact, surfaces and output, which the mesh has no use for. */
static const char *const FAMILIES[] = {"CONTACT",   "SURFACE",    "NODE ",      "NODEFILE",
                                       "NODEPRINT", "NODEOUTPUT", "EL ",        "ELFILE",
                                       "ELPRINT",   "ELOUTPUT",   "CONNECTOR ", "SECTION "};

/* Keywords within a *MATERIAL that only say more of a law, or nothing of stiffness. */
static const char *const HARMLESS_PROPERTIES[] = {"CONDUCTIVITY",
                                                  "SPECIFIC HEAT",
                                                  "DEPVAR",
                                                  "LATENT HEAT",
                                                  "FLUID CONSTANTS",
                                                  "SPECIFIC GAS CONSTANT",
                                                  "ELECTRICAL CONDUCTIVITY",
                                                  "MAGNETIC PERMEABILITY",
                                                  "USER OUTPUT VARIABLES",
                                                  "FAIL STRESS",
                                                  "FAIL STRAIN"};

/* Adds to the remarks on a keyword, or begins them. */
static void remark(inp_reader *r, const inp_keyword *keyword, const char *effect) {
  for (int i = 0; i < r->remark_count; i++)
    if (inp_same(r->remarks[i].name, keyword->name)) {
      r->remarks[i].count++;
      return;
    }
  if (r->remark_count == INP_REMARKS_MAX)
    r->more_remarks++;
  else
    r->remarks[r->remark_count++] = (inp_remark){keyword->name, keyword->line, 1, effect};
}

/* Takes a keyword as one of the present material; false: it is none. */
static bool is_property(inp_reader *r, const inp_keyword *keyword) {
  if (!r->in_material)
    return false;
  for (size_t i = 0; i < sizeof HARMLESS_PROPERTIES / sizeof *HARMLESS_PROPERTIES; i++)
    if (inp_is(keyword->name, HARMLESS_PROPERTIES[i]))
      return true;
  for (size_t i = 0; i < sizeof PASSED / sizeof *PASSED; i++)
    if (inp_is(keyword->name, PASSED[i].name))
      return false;
  for (size_t i = 0; i < sizeof FAMILIES / sizeof *FAMILIES; i++)
    if (keyword->name.length > strlen(FAMILIES[i]) &&
        thrum_text_equals((thrum_word){keyword->name.text, strlen(FAMILIES[i])}, FAMILIES[i]))
      return false;

  // the first law names the material; others say more of it
  inp_material *material = &r->materials[r->material_count - 1];
  if (material->law.length == 0) {
    material->law = keyword->name;
    material->law_line = keyword->line;
  }
  return true;
}

thrum_status inp_pass_over(inp_reader *r, const inp_keyword *keyword) {
  if (is_property(r, keyword))
    return THRUM_OK;
  r->in_material = false;
  for (size_t i = 0; i < sizeof PASSED / sizeof *PASSED; i++) {
    if (!inp_is(keyword->name, PASSED[i].name))
      continue;
    if (PASSED[i].refuse)
      return thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED, "*%s is not read; %s", PASSED[i].name,
                             PASSED[i].refuse);
    if (PASSED[i].effect)
      remark(r, keyword, PASSED[i].effect);
    return THRUM_OK;
  }

  // what stands in a step is an analysis and not the body
  bool known = r->in_step;
  for (size_t i = 0; i < sizeof FAMILIES / sizeof *FAMILIES; i++)
    known = known ||
            (keyword->name.length >= strlen(FAMILIES[i]) &&
             thrum_text_equals((thrum_word){keyword->name.text, strlen(FAMILIES[i])}, FAMILIES[i]));
  if (!known)
    remark(r, keyword, NULL);
  return THRUM_OK;
}

void inp_note_remarks(const inp_reader *r, thrum_mesh *mesh) {
  for (int i = 0; i < r->remark_count; i++) {
    const inp_remark *remark = &r->remarks[i];
    char times[48] = "";
    if (remark->count == 2)
      snprintf(times, sizeof times, " and once more");
    if (remark->count > 2)
      snprintf(times, sizeof times, " and %lld times more", (long long)remark->count - 1);
    thrum_mesh_add_note(mesh, "*%s on line %lld%s is not read: %s",
                        thrum_text_excerpt(remark->name).text, (long long)remark->line, times,
                        remark->effect ? remark->effect : "the keyword is not known here");
  }
  if (r->more_remarks > 0)
    thrum_mesh_add_note(mesh, "%lld more keywords are not read", (long long)r->more_remarks);

  // what is read in another way than it was written
  if (r->repeated_nodes > 0)
    thrum_mesh_add_note(mesh,
                        "%lld nodes are given again in another place, node %lld first; the last "
                        "place holds",
                        (long long)r->repeated_nodes, (long long)r->repeated_node);
  if (r->modified_tets > 0)
    thrum_mesh_add_note(mesh,
                        "%lld elements C3D10M were read as C3D10: their modified formulation "
                        "is Abaqus' own",
                        (long long)r->modified_tets);
}
