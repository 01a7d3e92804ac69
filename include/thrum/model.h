/* The reduced model, which `thrum precompute` writes and the runtime steps.
 *
 * Memory: a model is a struct of sizes and const pointers. Its arrays lie in one block: the
 * caller's file buffer for thrum_model_view, the caller's memory for thrum_model_init, one heap
 * block for thrum_model_load, which alone allocates. A model may also be made by hand: fill the
 * struct and call thrum_model_check.
 *
 * Threads: a model is immutable and may be shared by any number of threads.
 *
 * The file format is docs/model_format.md. Symbols and equations: docs/design.md (design N).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MODEL_H
#define THRUM_MODEL_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/api.h"
#include "thrum/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define THRUM_MODEL_FORMAT_MAJOR 1 /* a reader refuses a major version that it does not know */
#define THRUM_MODEL_FORMAT_MINOR 2 /* a minor version only adds arrays */
/* Versions 2 are those of a model with `midsides`, which no reader may overlook; a model of linear
 * tetrahedra has version 1. */
#define THRUM_MODEL_FORMAT_MAJOR_QUADRATIC 2
#define THRUM_MODEL_FORMAT_MINOR_QUADRATIC 0
/* Versions 3 are those of a model with `point_law`, which no reader may overlook, with or without
 * `midsides`. */
#define THRUM_MODEL_FORMAT_MAJOR_LAW 3
#define THRUM_MODEL_FORMAT_MINOR_LAW 1
/* Versions 4 are those of a model with `region_law`, likewise. */
#define THRUM_MODEL_FORMAT_MAJOR_REGIONS 4
#define THRUM_MODEL_FORMAT_MINOR_REGIONS 1
/* Versions 5 are those of a model with solids, likewise. */
#define THRUM_MODEL_FORMAT_MAJOR_SOLIDS 5
#define THRUM_MODEL_FORMAT_MINOR_SOLIDS 0
/* added to the minor version by the array elastic */
#define THRUM_MODEL_FORMAT_MINOR_ELASTIC 1
/* and by the array about */
#define THRUM_MODEL_FORMAT_MINOR_ABOUT 2
/* Added to the minor version of another model with cubature points. */
#define THRUM_MODEL_FORMAT_MINOR_POINTS 2
/* Added to that of a model with parameters, `region_energy`. */
#define THRUM_MODEL_FORMAT_MINOR_PARAMETERS 1
/* Added to that of a model with actuators, `actuator_kind`. */
#define THRUM_MODEL_FORMAT_MINOR_ACTUATORS 4
/* Places [m] and velocities [m/s] beyond this are refused: squares and products of them are finite.
 */
#define THRUM_PLACE_MAX 1e30
/* Entries of a basis beyond this are refused [kg^-1/2]. */
#define THRUM_BASIS_MAX 1e50
#define THRUM_RANK_MAX 512 /* far above the 334 that a file below 4 GiB can hold */

/* The numbers of point_training: what the states were like by which cubature points were chosen. */
typedef enum thrum_training_number {
  THRUM_TRAINING_STRAIN, /* largest norm of Green's strain in these states, >= 0 */
  THRUM_TRAINING_YIELD, /* smallest strain beyond which they flowed, > 0; 0: the body was elastic */
  THRUM_TRAINING_PLASTIC, /* largest plastic strain in them (thrum_state_plastic_strain), >= 0 */
  THRUM_TRAINING_LEARNED, /* 1: the gradients were learned, and are of no place of the body; or 0 */
  THRUM_TRAINING_NUMBERS
} thrum_training_number;

/* What an actuator is (thrum/actuation.h). */
typedef enum thrum_actuator_kind {
  THRUM_ACTUATOR_PRESSURE, /* on a surface, with a volume; level: pressure [Pa] */
  THRUM_ACTUATOR_STRAIN,   /* of a region, that it would have if it were free; level: 1 of it */
  THRUM_ACTUATOR_TENDON,   /* through guides; level: tension [N] */
  THRUM_ACTUATOR_GAS       /* of a fixed amount; level: pressure above that outside at rest [Pa] */
} thrum_actuator_kind;
#define THRUM_ACTUATORS_MAX 256 /* of a model */
#define THRUM_GUIDES_MAX 64     /* of a tendon */

/* Sizes of a model. X(name, meaning). A size is bound by the first array that carries it. */
#define THRUM_MODEL_SIZES(X)                                                                       \
  X(rank, "number of reduced coordinates r")                                                       \
  X(c3_count, "cubic coefficients, rank (rank+1) (rank+2) / 6")                                    \
  X(c4_count, "quartic coefficients, rank (rank+1) (rank+2) (rank+3) / 24")                        \
  X(vertex_count, "mesh vertices, fixed ones included; 0 without a mesh")                          \
  X(tet_count, "tetrahedra; 0 without a mesh")                                                     \
  X(region_count, "materials; 0 without a mesh")                                                   \
  X(group_count, "named vertex groups")                                                            \
  X(group_name_bytes, "bytes of all group names, each ended by one 0")                             \
  X(group_vertex_count, "vertices of all groups together")                                         \
  X(meta_bytes, "bytes of the JSON text in meta")                                                  \
  X(slave_count, "coordinates that follow the first k = rank - slave_count; 0: none")              \
  X(slave_pairs, "products of two masters, k (k+1) / 2")                                           \
  X(condensed_c3_count, "cubic coefficients of the masters")                                       \
  X(condensed_c4_count, "quartic coefficients of the masters")                                     \
  X(point_count, "cubature points in place of the polynomial; 0: none")                            \
  X(law_bytes, "bytes of the name of the law at these points, ended by one 0")                     \
  X(law_count, "regions, where each has a law of its own; 0: all points have one")                 \
  X(energy_size, "numbers of an energy of parameters, rank^2 + c3_count + c4_count; 0: none")      \
  X(mass_size, "numbers of a mass of parameters, rank (rank + 3); 0: none")                        \
  X(solid_count, "elements whose shape alone the tetrahedra are; 0: these are the elements")       \
  X(solid_node_count, "nodes of all of them")                                                      \
  X(elastic_count, "layers of regions whose elasticity has directions; 0: all are isotropic")      \
  X(actuator_count, "actuators; 0: none")                                                          \
  X(actuator_bytes, "bytes of their texts, each ended by one 0")                                   \
  X(actuator_square, "rank^2; 0: no actuators")                                                    \
  X(chamber_count, "actuators of kinds 0 and 3, which have volumes")                               \
  X(actuator_cube, "rank^2 (rank+1) / 2; 0: no chambers")                                          \
  X(guide_count, "points through which tendons run")

/* The arrays, in file order. X(type, name, rows, columns, presence, meaning):
 * type f8 | i4 | u1; rows and columns are a size's name or a literal (columns 1: a plain vector);
 * presence REQUIRED or OPTIONAL (an absent array is a NULL pointer; all of the mesh arrays
 * vertices, tets, tet_region, material, fixed come together, basis, rigid and midsides only with
 * vertices, the three group arrays together; c3 and c4 together, or in their place slave_map,
 * condensed_c3 and condensed_c4: thrum/condensed_model.h; or the three arrays of cubature points,
 * from which V is summed: thrum/polynomial.h, and with which alone point_training and a point_law
 * go, or in the place of the law point_region and region_law; region_energy and region_mass
 * together, with c3 and a mesh: thrum/parameters.h). With midsides the tetrahedra have
 * ten nodes: those of a row of tets, its corners, then the middle nodes of the edges 01, 12, 20,
 * 03, 13, 23. The four arrays of solids come together, with vertices and without midsides, and
 * elastic and about only with them. The five
 * actuator arrays come together, actuator_cubic where some have volumes, and the three of guides
 * where some are tendons: thrum/actuation.h). */
#define THRUM_MODEL_ARRAYS(X)                                                                      \
  X(i4, format, 2, 1, REQUIRED, "version of the format: major, minor")                             \
  X(u1, meta, meta_bytes, 1, OPTIONAL, "UTF-8 JSON about the model; the runtime never reads it")   \
  X(f8, omega2, rank, 1, REQUIRED, "squared angular frequencies [1/s^2], ascending, >= 0")         \
  X(f8, c3, c3_count, 1, OPTIONAL, "cubic coefficients of V [J/(m kg^1/2)^3], block order")        \
  X(f8, c4, c4_count, 1, OPTIONAL, "quartic coefficients of V [J/(m kg^1/2)^4], block order")      \
  X(f8, axis_mass, 3, rank, OPTIONAL, "U^T M 1 for the axes x, y, z [kg^1/2]")                     \
  X(f8, vertices, vertex_count, 3, OPTIONAL, "rest positions, within 1e30 [m]")                    \
  X(i4, tets, tet_count, 4, OPTIONAL, "0-based vertices of a tetrahedron, positive volume")        \
  X(i4, tet_region, tet_count, 1, OPTIONAL, "0-based region of each tetrahedron")                  \
  X(f8, material, region_count, 3, OPTIONAL,                                                       \
    "Young's modulus [Pa], Poisson's ratio, density [kg/m^3]")                                     \
  X(u1, fixed, vertex_count, 1, OPTIONAL, "bit 0, 1, 2: x, y, z of the vertex is held")            \
  X(f8, basis, basis_rows, rank, OPTIONAL, "U, rows 3 v + axis [kg^-1/2]; zero rows where held")   \
  X(u1, group_names, group_name_bytes, 1, OPTIONAL, "names, each ended by one 0")                  \
  X(i4, group_ends, group_count, 1, OPTIONAL, "end of each group's run in group_vertices")         \
  X(i4, group_vertices, group_vertex_count, 1, OPTIONAL, "0-based vertices, ascending in a group") \
  X(f8, rigid, basis_rows, 6, OPTIONAL, "rigid modes Z of a free body, rows as basis [kg^-1/2]")   \
  X(f8, slave_map, slave_count, slave_pairs, OPTIONAL,                                             \
    "y_h over x_i x_j, i <= j, i outermost [1/(m kg^1/2)]: how slaves follow at rest")             \
  X(f8, condensed_c3, condensed_c3_count, 1, OPTIONAL, "as c3, of the masters, in place of c3")    \
  X(f8, condensed_c4, condensed_c4_count, 1, OPTIONAL, "as c4, of the masters, slaves following")  \
  X(i4, midsides, tet_count, 6, OPTIONAL, "0-based middle nodes of ten-node tetrahedra")           \
  X(f8, point_weights, point_count, 1, OPTIONAL, "volumes of the cubature points, > 0 [m^3]")      \
  X(f8, point_moduli, 2, point_count, OPTIONAL, "Lame's lambda and mu at each of them [Pa]")       \
  X(f8, point_gradients, point_rows, rank, OPTIONAL,                                               \
    "rows 9 p + 3 a + b: du_a/dX_b of each coordinate at point p [1/(m kg^1/2)]")                  \
  X(u1, point_law, law_bytes, 1, OPTIONAL,                                                         \
    "law of the material at the points, corotational or neo-hookean; absent: Saint "               \
    "Venant-Kirchhoff's, or those of the regions")                                                 \
  X(i4, point_region, point_count, 1, OPTIONAL, "0-based region of each point, of several laws")   \
  X(u1, region_law, law_count, 1, OPTIONAL,                                                        \
    "law of each region: 0 Saint Venant-Kirchhoff's, 1 corotational, 2 neo-hookean")               \
  X(f8, region_yield, law_count, 1, OPTIONAL,                                                      \
    "elastic strain beyond which a region flows, > 0; 0: it has none of its own")                  \
  X(f8, point_training, 4, 1, OPTIONAL,                                                            \
    "what the points were chosen by, thrum_training_number; absent: not known")                    \
  X(f8, springs, vertex_count, 3, OPTIONAL,                                                        \
    "stiffness to the ground along x, y, z, >= 0 [N/m], which omega2 has in it; absent: none")     \
  X(f8, region_energy, modulus_rows, energy_size, OPTIONAL,                                        \
    "of lambda, then of mu of each region: what 1 Pa adds to U^T K U, c3 and c4")                  \
  X(f8, region_mass, region_count, mass_size, OPTIONAL,                                            \
    "what 1 kg/m^3 of each region adds to U^T M U, then to axis_mass")                             \
  X(u1, solid_form, solid_count, 1, OPTIONAL,                                                      \
    "form of each element: 0, 1 tetrahedra of 4, 10 nodes, 2, 3 wedges of 6, 15, 4, 5 hexahedra "  \
    "of 8, 20, 6, 7 solid-shell wedges and hexahedra, 8 tetrahedra of 10 of mean dilatation")      \
  X(i4, solid_ends, solid_count, 1, OPTIONAL, "end of each element's run in solid_nodes")          \
  X(i4, solid_nodes, solid_node_count, 1, OPTIONAL, "0-based, in the order of Abaqus and VTK")     \
  X(i4, solid_tet_ends, solid_count, 1, OPTIONAL,                                                  \
    "end of each element's run among the tetrahedra")                                              \
  X(f8, elastic, elastic_count, 18, OPTIONAL,                                                      \
    "a row a layer: region, E 1, 2, 3, nu 12, 13, 23, G 12, 13, 23 [Pa], two directions, angle "   \
    "[rad], thickness")                                                                            \
  X(f8, about, vertex_count, 3, OPTIONAL,                                                          \
    "from the shape without stress to `vertices`, of a body about a state [m]")                    \
  X(u1, actuator_texts, actuator_bytes, 1, OPTIONAL,                                               \
    "NAME=SPEC of each actuator, as precompute --actuator has it, ended by one 0")                 \
  X(i4, actuator_kind, actuator_count, 1, OPTIONAL, "0 pressure, 1 eigenstrain, 2 tendon, 3 gas")  \
  X(f8, actuator_rest, actuator_count, 3, OPTIONAL,                                                \
    "volume [m^3] or length [m] at rest, of a gas the pressure outside [Pa], and the share of "    \
    "its static answer that the basis holds")                                                      \
  X(f8, actuator_linear, actuator_count, rank, OPTIONAL,                                           \
    "force at rest of level 1 on each coordinate; of tendons 0")                                   \
  X(f8, actuator_quadratic, actuator_count, actuator_square, OPTIONAL,                             \
    "what q adds to that force, rank x rank, symmetric; of tendons 0")                             \
  X(f8, actuator_cubic, chamber_count, actuator_cube, OPTIONAL,                                    \
    "of each chamber: row (i, j), i <= j, i outermost, has what q_i q_j adds to it (rank)")        \
  X(i4, guide_ends, actuator_count, 1, OPTIONAL, "end of each actuator's run of guides")           \
  X(f8, guide_places, guide_count, 3, OPTIONAL, "guides of the tendons at rest [m]")               \
  X(f8, guide_rows, guide_axes, rank, OPTIONAL, "rows 3 g + axis: how they move [kg^-1/2]")
/* basis_rows is 3 * vertex_count, point_rows 9 * point_count, modulus_rows 2 * region_count,
 * guide_axes 3 * guide_count */

typedef double thrum_f8;
typedef int32_t thrum_i4;
typedef uint8_t thrum_u1;

typedef struct thrum_model {
#define X(name, meaning) int64_t name;
  THRUM_MODEL_SIZES(X)
#undef X
#define X(type, name, rows, columns, presence, meaning) const thrum_##type *name;
  THRUM_MODEL_ARRAYS(X)
#undef X
  /* c3 and c4, or point_gradients, in the orders of the passes over them: see thrum_model_pack in
   * thrum/polynomial.h; NULL: none */
  const double *packed;
  const float *packed_single;
  int64_t packed_count; /* numbers in each of the first two orders, one after the other */
  /* the arrays packed; a copy with others is not packed */
  const double *packed_c3, *packed_c4, *packed_gradients;
  /* what thrum_model_identity found when the model was made; a state steps with models of the
   * identity of its own alone. 0: a model made by hand that was given none */
  uint64_t identity;
  /* Set by thrum_model_condense alone, NULL otherwise: the model that shows this one, and its
   * slave_map for the masters of this one; follow_scale (1; g of a scaled model) times that is how
   * slaves follow in the units of this one. */
  const struct thrum_model *shape;
  const double *follow, *follow_by_pair; /* the second has a row for each pair of masters */
  double follow_scale;
  /* Rows F_p^-1 - 1, row-major, of the cubature points of a law that may flow, and behind
   * them what (18.7) adds to V; NULL: it is elastic. Files hold none. A state that may flow steps
   * with a copy of the model that has the state's own here. */
  const double *point_plastic;
  /* The levels of the actuators, and behind them what each state keeps of them; NULL: all passive.
   * Files hold none. A state steps with a copy of the model that has its own here. */
  const double *levels;
  /* 9 + 9 rank (rank + 1) numbers of thrum_inertia_numbers, from which thrum_inertia_create makes
   * the inertia of a free body's shape in place of a mesh; NULL: of the mesh. Files hold none, and
   * a locked, scaled or condensed model has none. */
  const double *inertia;
  /* Damping that each coordinate has beside that of a state's def, D = alpha + beta omega^2 + this
   * (rank) [1/s], finite and >= 0: 2 zeta omega for a damping ratio zeta of a linear mode. The
   * others follow modes at their frequency: the rate of a mode is right for them, a ratio is many
   * times too much. The caller's; NULL: none.
   * Files hold none, and a locked, scaled or condensed model has none: set it of a copy of the
   * struct, and step with that. What follows in a condensed model is not damped by it. */
  const double *damping;
  /* thrum_model_unit_energy [J] of a model without its tetrahedra, by which thrum_model_condense
   * tells what stretches the body; 0: not known. Files hold none. */
  double unit_energy;
} thrum_model;

/* Number of cubic and of quartic monomials in `rank` coordinates. Any thread. */
static inline int64_t thrum_c3_count(int64_t rank) {
  return rank * (rank + 1) * (rank + 2) / 6;
}
static inline int64_t thrum_c4_count(int64_t rank) {
  return rank * (rank + 1) / 2 * (rank + 2) / 3 * (rank + 3) / 4;
}

/* Uses `file`, the bytes of a model file aligned to 64, in place: on success *model points into it,
 * and it must outlive the model. The whole file is checked: THRUM_BAD_FORMAT, THRUM_BAD_CHECKSUM,
 * THRUM_UNSUPPORTED, THRUM_MISSING, THRUM_BAD_SHAPE or THRUM_BAD_VALUE with the array;
 * THRUM_MISALIGNED where the buffer or an array in it is not aligned to 64. Allocates nothing. */
THRUM_API thrum_status thrum_model_view(const void *file, size_t file_size, thrum_model *model,
                                        thrum_error *error);

/* Bytes that thrum_model_init needs for this file, into *size. Checks the whole file and fails as
 * thrum_model_view. */
THRUM_API thrum_status thrum_model_size(const void *file, size_t file_size, size_t *size,
                                        thrum_error *error);

/* Copies the model out of `file` (any alignment) into `memory`, aligned to 64 and of at least
 * thrum_model_size bytes. The caller owns the memory and frees it when done; *model points into it,
 * and the file may go. THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, or as thrum_model_view. Allocates
 * nothing. */
THRUM_API thrum_status thrum_model_init(void *memory, size_t memory_size, const void *file,
                                        size_t file_size, const thrum_model **model,
                                        thrum_error *error);

/* Reads the file at `path` into one heap block, which the caller owns and returns with
 * thrum_model_destroy. THRUM_IO, THRUM_OUT_OF_MEMORY, or as thrum_model_view. */
THRUM_API thrum_status thrum_model_load(const char *path, const thrum_model **model,
                                        thrum_error *error);
THRUM_API void thrum_model_destroy(
    const thrum_model *model); /* made by thrum_model_load alone; NULL does nothing */

/* Checks a model made by hand: sizes agree, values are finite, omega2 ascends, indices are in
 * range. THRUM_INVALID_ARGUMENT for NULL, THRUM_MISSING, THRUM_BAD_SHAPE or THRUM_BAD_VALUE with
 * the array. */
THRUM_API thrum_status thrum_model_check(const thrum_model *model, thrum_error *error);

/* A number that tells omega2, c3 and c4 of this model from those of others, never 0. Models from
 * files have it as their `identity`; set the `identity` of a model made by hand to it where its
 * states are to refuse other models. Returns 0 for NULL and where a coefficient's array is missing.
 * Reads every coefficient once. Any thread. */
THRUM_API uint64_t thrum_model_identity(const thrum_model *model);

/* Makes the checks of thrum_model_check that read no value but the format's version: that required
 * arrays are there and that their sizes agree. */
THRUM_API thrum_status thrum_model_check_shapes(const thrum_model *model, thrum_error *error);

/* Bytes that thrum_model_lock needs for this model at this lower rank, into *size.
 * THRUM_INVALID_ARGUMENT for NULL or a rank out of 1 to the model's. */
THRUM_API thrum_status thrum_model_lock_size(const thrum_model *model, int64_t rank, size_t *size,
                                             thrum_error *error);

/* The model whose coordinates beyond the lowest `rank` (1 to the model's rank) are held at zero:
 * V(q_1..q_rank, 0..0), in `memory` (the caller's, aligned to 64, thrum_model_lock_size bytes).
 * It is not the body with fewer coordinates: what is held is mostly how the body stretches as it
 * bends, so it becomes too stiff in any motion that is not small (design 3). To step fewer
 * coordinates take thrum_model_condense, or a model that was precomputed at that rank.
 * Mesh, groups and meta stay where `model` has them, so it must outlive *locked. The coordinates of
 * the locked model are the first ones of the model. THRUM_INVALID_ARGUMENT, THRUM_MISALIGNED or
 * THRUM_BUFFER_TOO_SMALL. Allocates nothing. */
THRUM_API thrum_status thrum_model_lock(void *memory, size_t memory_size, const thrum_model *model,
                                        int64_t rank, const thrum_model **locked,
                                        thrum_error *error);

/* Factors by which a model is scaled; each is finite and > 0, and 1 changes nothing. There are no
 * defaults: set all three. */
typedef struct thrum_model_scaling {
  double length;    /* s, of all lengths [1]; larger: a larger body, which vibrates more slowly */
  double stiffness; /* e, of Young's modulus, and of springs to the ground, which are e s times as
                       stiff [1]; larger: the body vibrates faster */
  double density;   /* d, of the density [1]; larger: a heavier body, which vibrates more slowly */
} thrum_model_scaling;

/* Bytes that thrum_model_scale needs for this model, into *size. THRUM_INVALID_ARGUMENT for NULL.
 */
THRUM_API thrum_status thrum_model_scale_size(const thrum_model *model, size_t *size,
                                              thrum_error *error);

/* The same body s times as large, of e times the stiffness and d times the density, without another
 * precompute: V'(q') = e s^3 V(q) with q = q' s^-5/2 d^-1/2, U' = U s^-3/2 d^-1/2, exactly what the
 * scaled mesh would give. In `memory` (the caller's, aligned to 64, thrum_model_scale_size bytes).
 * Tetrahedra, held vertices, groups and meta stay where `model` has them, so it must outlive
 * *scaled. THRUM_BAD_VALUE where the scaled model leaves the range of numbers,
 * THRUM_INVALID_ARGUMENT, THRUM_MISALIGNED or THRUM_BUFFER_TOO_SMALL. Allocates nothing. Source:
 * Langhaar 1951, Dimensional analysis and theory of models. */
THRUM_API thrum_status thrum_model_scale(void *memory, size_t memory_size, const thrum_model *model,
                                         const thrum_model_scaling *by, const thrum_model **scaled,
                                         thrum_error *error);

/* Vertices of the group called `name`: *vertices points to *count > 0 of them (0-based) inside the
 * model. THRUM_MISSING when there is no such group, THRUM_INVALID_ARGUMENT for NULL. */
THRUM_API thrum_status thrum_model_group(const thrum_model *model, const char *name,
                                         const int32_t **vertices, int64_t *count,
                                         thrum_error *error);

/* Name of group `index` (0-based), which lies inside the model; NULL when out of range. */
THRUM_API const char *thrum_model_group_name(const thrum_model *model, int64_t index);

/* Number of masters of a model whose file holds a condensed polynomial (`precompute --condense`),
 * which thrum_model_condense of condensed_model.h must make steppable; 0 for every other model. */
THRUM_API int64_t thrum_model_masters(const thrum_model *model);

#ifdef __cplusplus
}
#endif
#endif
