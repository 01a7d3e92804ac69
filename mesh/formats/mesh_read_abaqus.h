/* What the files of the Abaqus reader share: lines and fields of a deck, its nodes, elements, sets,
 * sections and materials, and what is said of keywords that are passed over.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_MESH_READ_ABAQUS_H
#define THRUM_MESH_FORMATS_MESH_READ_ABAQUS_H

#include "mesh/elastic.h"
#include "mesh/formats/included_files.h"
#include "mesh/mesh_builder.h"
#include "mesh/number_map.h"

enum {
  INP_PARAMETERS_MAX = 16,
  INP_GENERATED_MAX = 1 << 22, /* nodes, elements that keywords may make: no deck's own many */
  INP_REMARKS_MAX = 24         /* different keywords that are passed over with a word */
};

typedef struct inp_parameter {
  thrum_word key, value;
} inp_parameter;

/* A keyword line, which decides how the data lines behind it are read. */
typedef struct inp_keyword {
  thrum_word name;
  int64_t line;
  int count;
  inp_parameter parameters[INP_PARAMETERS_MAX];
} inp_keyword;

/* A solid by the beginning of its type; letters behind it, as in C3D8R, are kinds of integration.
 */
typedef struct inp_solid {
  const char *type;
  int nodes;
  thrum_solid solid;
  bool quadratic;
} inp_solid;

typedef struct inp_element {
  int64_t number;
  int64_t line;
  const inp_solid *solid; /* NULL: of another kind, whose nodes define groups alone */
  int64_t first, count;   /* its nodes, in `nodes` */
  int64_t region;         /* index of its section or set; -1: none */
  int64_t seen;           /* the stamp of the set that counted it last */
} inp_element;

/* An element set holds elements by number. Its vertices become a group at the end. */
typedef struct inp_set {
  thrum_word name;  /* of its group */
  thrum_word base;  /* in the file: a part and the assembly may each have a set of that name */
  bool of_assembly; /* beside the instance */
  bool declared;    /* by *ELSET, not only among the parameters of another keyword */
  int64_t count;
  int64_t *elements;
} inp_set;

/* What a list of the builder stands for, as of an element set. */
typedef struct inp_list {
  thrum_word base;
  bool of_assembly;
} inp_list;

typedef struct inp_material {
  thrum_word name;
  thrum_material values;
  bool has_elastic, has_density, directed;
  double row[THRUM_ELASTIC_NUMBERS]; /* the constants of one that is directed, elastic.h */
  thrum_word law; /* the first keyword of it that is no linear elasticity; empty: there is none */
  int64_t law_line;
} inp_material;

typedef struct inp_section {
  thrum_word set, material, orientation;
  int64_t line;
} inp_section;

/* Directions 1 and 2 of a section; of a system that is not read both are 0. */
typedef struct inp_orientation {
  thrum_word name;
  double first[3], second[3];
} inp_orientation;

/* A keyword that is passed over though it says something of the body. */
typedef struct inp_remark {
  thrum_word name;
  int64_t line, count;
  const char *effect; /* what follows; NULL: the keyword is not known */
} inp_remark;

/* Where an instance of a part is put: moved first, then turned about an axis through two points. */
typedef struct inp_instance {
  thrum_word name;
  double move[3];
  double axis[2][3];
  double degrees;
} inp_instance;

/* The system of *SYSTEM, in which nodes are given: x = origin + sum of x'_i axes[i]. */
typedef struct inp_system {
  bool active;
  double origin[3], axes[3][3];
} inp_system;

typedef struct inp_reader {
  thrum_included_files files;
  bool again;          /* the present line is a keyword still to be read */
  thrum_status broken; /* a failure within a step to the next line, kept in `failure` */
  thrum_error failure;
  thrum_error *error;

  thrum_mesh_builder builder;
  thrum_number_map node_map;
  int64_t nodes_mapped, node_most; /* how many are in the map; the largest number of all */
  int64_t repeated_nodes, repeated_node;
  int64_t generated; /* nodes and elements that keywords have made */
  inp_system system;

  int64_t part_count, instance_count;
  bool in_assembly, in_instance, in_step, in_material;
  bool beside_body; /* the present keyword is of the assembly and of no instance */
  inp_instance instance;

  int64_t element_count, solid_count;
  inp_element *elements;
  thrum_number_map element_map;
  int64_t elements_mapped;
  int64_t node_count; /* of all elements */
  int64_t *nodes;
  int64_t modified_tets; /* elements of type C3D10M */

  int64_t set_count;
  inp_set *sets;
  int64_t list_count; /* as many as the builder has, in its order */
  inp_list *lists;
  int64_t member_count;   /* of all sets, of nodes too */
  int64_t stamp;          /* of the set that is counted */
  int64_t unsorted_count; /* lists of the builder that keep the order in which they are given */
  int64_t *unsorted;
  bool region_sets; /* sets, and not sections, are the regions */
  int64_t material_count;
  inp_material *materials;
  int64_t section_count;
  inp_section *sections;
  int64_t orientation_count;
  inp_orientation *orientations;
  int remark_count;
  inp_remark remarks[INP_REMARKS_MAX];
  int64_t more_remarks; /* beyond the room for them */
} inp_reader;

/* --- lines and fields: mesh_read_abaqus_lines.c ------------------------------------------------
 */

thrum_text *inp_text(inp_reader *r);
/* Do two words agree, whatever their capitals and blanks? */
bool inp_same(thrum_word a, thrum_word b);
bool inp_is(thrum_word word, const char *name);

/* Goes to the next line that is no comment, through *INCLUDE; false at the end or after a failure,
 * which is kept in `broken`. */
bool inp_next_line(inp_reader *r);
/* Goes to the next line of data; false at the end or at a keyword, which is read next. */
bool inp_data_line(inp_reader *r);
/* Reads the keyword line that is the present one. */
void inp_read_keyword(inp_reader *r, inp_keyword *keyword);
/* Opens the file of its INPUT parameter, if it has one, whose lines then come first. */
thrum_status inp_open_input(inp_reader *r, const inp_keyword *keyword);

/* Returns the value of a parameter, whose text is NULL when the parameter is not there. */
thrum_word inp_parameter_of(const inp_keyword *keyword, const char *key);
bool inp_has_parameter(const inp_keyword *keyword, const char *key);

/* Is there another field on the line? Fields are parted by commas, or blanks. */
bool inp_more(inp_reader *r);
/* Reads the next field as a number, in Fortran's forms too; a blank one, or none, is 0. */
thrum_status inp_number(inp_reader *r, const char *what, double *value);
/* Reads the next field, which must be there, as a whole number of at least `low`. */
thrum_status inp_integer(inp_reader *r, const char *what, int64_t low, int64_t *value);
/* The same; a blank field, or none, leaves *value. */
thrum_status inp_integer_or(inp_reader *r, const char *what, int64_t low, int64_t *value);
/* Takes a field as a name. */
thrum_word inp_word(inp_reader *r);
/* Refuses anything left on the line after `what`. */
thrum_status inp_finish(inp_reader *r, const char *what);

/* --- nodes: mesh_read_abaqus_nodes.c -----------------------------------------------------------
 */

typedef thrum_status inp_read(inp_reader *r, const inp_keyword *keyword);

inp_read inp_read_nodes, inp_read_system, inp_read_instance;
/* Generation: *NGEN, *NFILL and *NCOPY, in mesh_read_abaqus_generate.c. */
inp_read inp_generate_nodes, inp_fill_nodes, inp_copy_nodes;

/* Adds a node in global coordinates, or moves the one of that number there. */
thrum_status inp_put_node(inp_reader *r, int64_t number, const double position[3], int64_t line);
/* Finds a node; *vertex is its place in the builder, -1 where there is none. */
thrum_status inp_find_node(inp_reader *r, int64_t number, int64_t *vertex);
/* Counts nodes and elements that a keyword is about to make. */
thrum_status inp_check_generated(inp_reader *r, int64_t more);
/* From coordinates of the system of *SYSTEM to global ones. */
void inp_leave_system(const inp_reader *r, double position[3]);
/* Turns a point about the axis through two others by an angle in degrees; false: these are one, so
 * that there is no axis. */
bool inp_turn(const double from[3], const double to[3], double degrees, double point[3]);
/* Puts the vertices where the instance is. */
thrum_status inp_place_instance(inp_reader *r);

/* --- elements: mesh_read_abaqus_elements.c -----------------------------------------------------
 */

inp_read inp_read_elements, inp_generate_elements, inp_copy_elements;
/* Hands all solids over to the builder; their regions are known. */
thrum_status inp_build_elements(inp_reader *r);

/* --- sets and regions: mesh_read_abaqus_sets.c -------------------------------------------------
 */

/* Finds an element; *index is -1 where there is none. Refuses one that comes twice. */
thrum_status inp_find_element(inp_reader *r, int64_t number, int64_t *index);
inp_read inp_read_node_set, inp_read_element_set;
/* Finds the list of the builder that stands for a node set, or the index of an element set; new
 * ones are added. */
thrum_status inp_node_list(inp_reader *r, thrum_word name, int64_t *list);
thrum_status inp_find_set(inp_reader *r, thrum_word name, int64_t *index);
/* The index of an element set, or set_count; of the list of a node set, or -1: the one of the part
 * or the assembly, whichever the present keyword is of, or else the other's. */
int64_t inp_set_index(const inp_reader *r, thrum_word name);
int64_t inp_list_index(const inp_reader *r, thrum_word name);
thrum_status inp_add_node(inp_reader *r, int64_t list, int64_t node);
thrum_status inp_add_element(inp_reader *r, int64_t set, int64_t element);
/* The nodes of a node set, in its order; free *nodes. */
thrum_status inp_set_nodes(inp_reader *r, thrum_word name, int64_t **nodes, int64_t *count);
/* Gives each solid the section or the set that is its region. */
thrum_status inp_find_regions(inp_reader *r, thrum_mesh *mesh);
/* Makes a group of the nodes of each element set. */
thrum_status inp_set_groups(inp_reader *r, thrum_mesh *mesh);

/* --- materials and what is passed over: mesh_read_abaqus_materials.c ---------------------------
 */

inp_read inp_read_material, inp_read_property, inp_read_section, inp_read_orientation;
/* Names and materials of the regions, once the mesh is made. */
thrum_status inp_region_materials(inp_reader *r, thrum_mesh *mesh);
/* Takes note of a keyword that no reader takes: refuses it, or says at the end what it means. */
thrum_status inp_pass_over(inp_reader *r, const inp_keyword *keyword);
void inp_note_remarks(const inp_reader *r, thrum_mesh *mesh);

#endif
