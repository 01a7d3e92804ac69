/* Checks of a model: which arrays come together, how sizes agree, in which ranges values lie.
 * Shared by files of any alignment and by models made by hand, hence arrays as bytes.
 * Cost: one pass over every array.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/base/model_law.h"
#include "core/model/model_layout.h"

#define HAS(layout, name) ((layout)->data[THRUM_ARRAY_##name] != NULL)
#define SIZE(layout, name) ((layout)->size[THRUM_SIZE_##name])

static double get_f8(const unsigned char *data, int64_t i) {
  double value;
  memcpy(&value, data + 8 * i, 8);
  return value;
}

static int32_t get_i4(const unsigned char *data, int64_t i) {
  int32_t value;
  memcpy(&value, data + 4 * i, 4);
  return value;
}

// refuses arrays of a set that is neither whole nor absent
static thrum_status check_together(const thrum_layout *layout, const int *arrays, int count,
                                   const char *rule, thrum_error *error) {
  int present = 0, absent = -1;
  for (int i = 0; i < count; i++) {
    if (layout->data[arrays[i]] != NULL)
      present++;
    else
      absent = arrays[i];
  }
  if (present == 0 || present == count)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING, "array '%s' is missing: %s",
                         thrum_array_table[absent].name, rule);
}

static thrum_status check_version(const thrum_layout *layout, thrum_error *error) {
  int32_t major = get_i4(layout->data[THRUM_ARRAY_format], 0);
  int32_t minor = get_i4(layout->data[THRUM_ARRAY_format], 1);
  if (major < THRUM_MODEL_FORMAT_MAJOR || major > THRUM_MODEL_FORMAT_MAJOR_SOLIDS)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "array 'format' says version %" PRId32 ".%" PRId32
                           ", this program reads versions %d to %d",
                           major, minor, THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MAJOR_SOLIDS);
  if (minor < 0)
    return thrum_error_set(error, THRUM_BAD_VALUE, "array 'format' holds a negative version");

  // a reader of version 1 alone would take ten-node tetrahedra for linear ones
  if (HAS(layout, midsides) && major == THRUM_MODEL_FORMAT_MAJOR)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'format' says version %" PRId32 ".%" PRId32
                           "; a model with 'midsides' has version %d",
                           major, minor, THRUM_MODEL_FORMAT_MAJOR_QUADRATIC);

  // a reader of an older format must not overlook a law
  if (HAS(layout, point_law) && major < THRUM_MODEL_FORMAT_MAJOR_LAW)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'format' says version %" PRId32 ".%" PRId32
                           "; a model with 'point_law' has version %d",
                           major, minor, THRUM_MODEL_FORMAT_MAJOR_LAW);
  if (HAS(layout, region_law) && major < THRUM_MODEL_FORMAT_MAJOR_REGIONS)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'format' says version %" PRId32 ".%" PRId32
                           "; a model with 'region_law' has version %d",
                           major, minor, THRUM_MODEL_FORMAT_MAJOR_REGIONS);
  if (HAS(layout, solid_form) && major < THRUM_MODEL_FORMAT_MAJOR_SOLIDS)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'format' says version %" PRId32 ".%" PRId32
                           "; a model with 'solid_form' has version %d",
                           major, minor, THRUM_MODEL_FORMAT_MAJOR_SOLIDS);
  return THRUM_OK;
}

// the laws of the regions, and the region of each point
static thrum_status check_regions(const thrum_layout *layout, thrum_error *error) {
  static const int regions[] = {THRUM_ARRAY_region_law, THRUM_ARRAY_point_region};
  THRUM_TRY(check_together(layout, regions, 2, "point_region and region_law come together", error));
  if (HAS(layout, region_yield) && !HAS(layout, region_law))
    return thrum_error_set(error, THRUM_MISSING,
                           "array 'region_law' is missing: 'region_yield' is that of regions with "
                           "laws of their own");

  // one law or several, and those of points
  if (HAS(layout, region_law) && HAS(layout, point_law))
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'point_law' does not go with region_law: a model has one law, or "
                           "one for each region");
  if (HAS(layout, region_law) && !HAS(layout, point_weights))
    return thrum_error_set(error, THRUM_MISSING,
                           "array 'point_weights' is missing: 'region_law' has the laws of "
                           "cubature points, as a polynomial cannot hold them");
  return THRUM_OK;
}

// the shares of moduli and densities, of the polynomial of a mesh
static thrum_status check_parameters(const thrum_layout *layout, thrum_error *error) {
  static const int both[] = {THRUM_ARRAY_region_energy, THRUM_ARRAY_region_mass};
  THRUM_TRY(check_together(layout, both, 2, "region_energy and region_mass come together", error));
  if (HAS(layout, region_energy) && (!HAS(layout, c3) || !HAS(layout, material)))
    return thrum_error_set(error, THRUM_MISSING,
                           "array '%s' is missing: 'region_energy' has the shares of the materials "
                           "of a mesh in c3 and c4",
                           HAS(layout, c3) ? "material" : "c3");
  return THRUM_OK;
}

// the actuators, the volumes of some and the guides of others
static thrum_status check_actuators(const thrum_layout *layout, thrum_error *error) {
  static const int all[] = {THRUM_ARRAY_actuator_texts, THRUM_ARRAY_actuator_kind,
                            THRUM_ARRAY_actuator_rest, THRUM_ARRAY_actuator_linear,
                            THRUM_ARRAY_actuator_quadratic};
  static const int guides[] = {THRUM_ARRAY_guide_ends, THRUM_ARRAY_guide_places,
                               THRUM_ARRAY_guide_rows};
  THRUM_TRY(check_together(layout, all, 5,
                           "actuator_texts, actuator_kind, actuator_rest, actuator_linear and "
                           "actuator_quadratic come together",
                           error));
  THRUM_TRY(check_together(layout, guides, 3,
                           "guide_ends, guide_places and guide_rows come together", error));
  if (!HAS(layout, actuator_kind) && (HAS(layout, actuator_cubic) || HAS(layout, guide_ends)))
    return thrum_error_set(error, THRUM_MISSING,
                           "array 'actuator_kind' is missing: '%s' is that of actuators",
                           HAS(layout, guide_ends) ? "guide_ends" : "actuator_cubic");
  if (HAS(layout, actuator_kind) && HAS(layout, slave_map))
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'actuator_kind' does not go with slave_map: actuators act on "
                           "coordinates that are all stepped");
  return THRUM_OK;
}

// the polynomial of all coordinates, the condensed one of the first of them, or points in its place
static thrum_status check_polynomial(const thrum_layout *layout, thrum_error *error) {
  static const int condensed[] = {THRUM_ARRAY_slave_map, THRUM_ARRAY_condensed_c3,
                                  THRUM_ARRAY_condensed_c4};
  static const int whole[] = {THRUM_ARRAY_c3, THRUM_ARRAY_c4};
  static const int points[] = {THRUM_ARRAY_point_weights, THRUM_ARRAY_point_moduli,
                               THRUM_ARRAY_point_gradients};

  // arrays that are of no use without each other
  THRUM_TRY(check_together(layout, condensed, 3,
                           "slave_map, condensed_c3 and condensed_c4 come together", error));
  THRUM_TRY(check_together(layout, points, 3,
                           "point_weights, point_moduli and point_gradients come together", error));

  // a law is that of points, and points have no slaves
  if (HAS(layout, point_law) && !HAS(layout, point_weights))
    return thrum_error_set(error, THRUM_MISSING,
                           "array 'point_weights' is missing: 'point_law' is that of cubature "
                           "points, as a polynomial cannot hold it");
  if (HAS(layout, point_training) && !HAS(layout, point_weights))
    return thrum_error_set(error, THRUM_MISSING,
                           "array 'point_weights' is missing: 'point_training' is that of cubature "
                           "points");
  THRUM_TRY(check_regions(layout, error));
  if (HAS(layout, slave_map) && HAS(layout, point_weights))
    return thrum_error_set(
        error, THRUM_BAD_SHAPE,
        "array 'point_weights' does not go with slave_map: a condensed model has "
        "a polynomial of its masters");

  // either both of the one or all of another
  for (int i = 0; i < 2; i++) {
    const bool present = layout->data[whole[i]] != NULL;
    if (HAS(layout, point_weights) && present)
      return thrum_error_set(error, THRUM_BAD_SHAPE,
                             "array '%s' does not go with point_weights: a model has a polynomial "
                             "or points, not both",
                             thrum_array_table[whole[i]].name);
    if (HAS(layout, point_weights))
      continue;
    if (!HAS(layout, slave_map) && !present)
      return thrum_error_set(error, THRUM_MISSING, "array '%s' is missing",
                             thrum_array_table[whole[i]].name);
    if (HAS(layout, slave_map) && present)
      return thrum_error_set(error, THRUM_BAD_SHAPE,
                             "array '%s' does not go with slave_map: a condensed model has no "
                             "polynomial of all coordinates",
                             thrum_array_table[whole[i]].name);
  }
  return THRUM_OK;
}

thrum_status thrum_layout_check_presence(const thrum_layout *layout, thrum_error *error) {
  static const int mesh[] = {THRUM_ARRAY_vertices, THRUM_ARRAY_tets, THRUM_ARRAY_tet_region,
                             THRUM_ARRAY_material, THRUM_ARRAY_fixed};
  static const int groups[] = {THRUM_ARRAY_group_names, THRUM_ARRAY_group_ends,
                               THRUM_ARRAY_group_vertices};
  static const int solids[] = {THRUM_ARRAY_solid_form, THRUM_ARRAY_solid_ends,
                               THRUM_ARRAY_solid_nodes, THRUM_ARRAY_solid_tet_ends};

  // another version may well lack what this one requires, so the version speaks first
  if (HAS(layout, format)) {
    thrum_status status = check_version(layout, error);
    if (status != THRUM_OK)
      return status;
  }

  // every model has a format, whatever else it lacks
  if (!HAS(layout, format))
    return thrum_error_set(error, THRUM_MISSING,
                           "the file is no Thrum model: array 'format' is missing");

  // required arrays, and those that make sense only together
  for (int a = 0; a < THRUM_ARRAY_COUNT; a++)
    if (thrum_array_table[a].required && layout->data[a] == NULL)
      return thrum_error_set(error, THRUM_MISSING, "array '%s' is missing",
                             thrum_array_table[a].name);

  THRUM_TRY(check_polynomial(layout, error));
  THRUM_TRY(check_parameters(layout, error));
  THRUM_TRY(check_actuators(layout, error));
  THRUM_TRY(check_together(layout, mesh, 5,
                           "vertices, tets, tet_region, material and fixed come together", error));
  THRUM_TRY(check_together(layout, groups, 3,
                           "group_names, group_ends and group_vertices come together", error));
  THRUM_TRY(check_together(layout, solids, 4,
                           "solid_form, solid_ends, solid_nodes and solid_tet_ends come together",
                           error));
  if (HAS(layout, solid_form) && HAS(layout, midsides))
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'midsides' does not go with solid_form: its tetrahedra are the "
                           "shape of other elements");

  // arrays whose rows are vertices
  static const int on_mesh[] = {THRUM_ARRAY_basis,   THRUM_ARRAY_group_ends,
                                THRUM_ARRAY_rigid,   THRUM_ARRAY_midsides,
                                THRUM_ARRAY_springs, THRUM_ARRAY_solid_form};
  if ((HAS(layout, elastic) || HAS(layout, about)) && !HAS(layout, solid_form))
    return thrum_error_set(error, THRUM_MISSING,
                           "array 'solid_form' is missing: '%s' is that of elements which it lists",
                           HAS(layout, elastic) ? "elastic" : "about");
  for (int i = 0; i < 6; i++)
    if (layout->data[on_mesh[i]] != NULL && !HAS(layout, vertices))
      return thrum_error_set(error, THRUM_MISSING, "array 'vertices' is missing: '%s' needs a mesh",
                             thrum_array_table[on_mesh[i]].name);
  return THRUM_OK;
}

// the product rows * columns * item must be a size of memory
static int fits_memory(const thrum_layout *layout, int array) {
  const thrum_array_info *info = &thrum_array_table[array];
  uint64_t most = PTRDIFF_MAX / info->item;
  uint64_t rows = (uint64_t)thrum_archive_extent(&thrum_model_list, layout->size, info->rows);
  uint64_t columns = (uint64_t)thrum_archive_extent(&thrum_model_list, layout->size, info->columns);
  return columns == 0 || rows <= most / columns;
}

// refuses an array unless it has as many coefficients, or columns, as the masters have monomials
static thrum_status check_count(const thrum_layout *layout, int array, int64_t count,
                                int64_t expected, thrum_error *error) {
  if (count == expected)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_SHAPE,
                         "array '%s' has %" PRId64 " monomials; %" PRId64 " masters have %" PRId64,
                         thrum_array_table[array].name, count,
                         SIZE(layout, rank) - SIZE(layout, slave_count), expected);
}

// coefficients: one for every monomial of the rank
static thrum_status check_rank(const thrum_layout *layout, thrum_error *error) {
  int64_t rank = SIZE(layout, rank);
  if (rank < 1 || rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'omega2' has %" PRId64 " entries; a rank is 1 to %d", rank,
                           THRUM_RANK_MAX);

  // a condensed model has coefficients of its masters alone
  const int64_t slaves = SIZE(layout, slave_count), masters = rank - slaves;
  if (!HAS(layout, slave_map) && slaves != 0)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'slave_map' is absent, yet slave_count is not 0");

  // its arrays are counted by the monomials of the masters
  if (HAS(layout, slave_map)) {
    if (slaves < 1 || masters < 1)
      return thrum_error_set(error, THRUM_BAD_SHAPE,
                             "array 'slave_map' has %" PRId64 " rows; rank %" PRId64
                             " has 1 to %" PRId64 " slaves",
                             slaves, rank, rank - 1);
    THRUM_TRY(check_count(layout, THRUM_ARRAY_slave_map, SIZE(layout, slave_pairs),
                          masters * (masters + 1) / 2, error));
    THRUM_TRY(check_count(layout, THRUM_ARRAY_condensed_c3, SIZE(layout, condensed_c3_count),
                          thrum_c3_count(masters), error));
    return check_count(layout, THRUM_ARRAY_condensed_c4, SIZE(layout, condensed_c4_count),
                       thrum_c4_count(masters), error);
  }

  // points have no coefficients
  const int64_t points = SIZE(layout, point_count);
  if (HAS(layout, point_weights) ? points < 1 || points > INT32_MAX / 9 : points != 0)
    return thrum_error_set(
        error, THRUM_BAD_SHAPE,
        "array 'point_weights' %s %" PRId64 " entries; there are 1 to %d points, "
        "or the array is absent",
        HAS(layout, point_weights) ? "has" : "is absent, yet has", points, INT32_MAX / 9);
  if (HAS(layout, point_weights)) {
    if (SIZE(layout, c3_count) != 0 || SIZE(layout, c4_count) != 0)
      return thrum_error_set(error, THRUM_BAD_SHAPE,
                             "arrays 'c3' and 'c4' are absent, yet their counts are not 0");
    return THRUM_OK;
  }

  // a whole one has them of all coordinates
  if (SIZE(layout, c3_count) != thrum_c3_count(rank))
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'c3' has %" PRId64 " entries; rank %" PRId64 " has %" PRId64,
                           SIZE(layout, c3_count), rank, thrum_c3_count(rank));
  if (SIZE(layout, c4_count) != thrum_c4_count(rank))
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'c4' has %" PRId64 " entries; rank %" PRId64 " has %" PRId64,
                           SIZE(layout, c4_count), rank, thrum_c4_count(rank));
  return THRUM_OK;
}

// as many numbers as the rank asks for, and none of what is absent
static thrum_status check_actuator_sizes(const thrum_layout *layout, thrum_error *error) {
  const int64_t rank = SIZE(layout, rank), count = SIZE(layout, actuator_count);
  const int64_t chambers = SIZE(layout, chamber_count), guides = SIZE(layout, guide_count);
  const bool acts = HAS(layout, actuator_kind), holds = HAS(layout, actuator_cubic);
  if (acts ? count < 1 || count > THRUM_ACTUATORS_MAX : count != 0)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'actuator_kind' %s %" PRId64
                           " entries; there are 1 to %d actuators, or the array is absent",
                           acts ? "has" : "is absent, yet has", count, THRUM_ACTUATORS_MAX);
  if (chambers > count || (chambers > 0) != holds || (guides > 0) != HAS(layout, guide_ends) ||
      guides > THRUM_ACTUATORS_MAX * THRUM_GUIDES_MAX)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "arrays 'actuator_cubic' and 'guide_places' are of %" PRId64
                           " chambers and %" PRId64 " guides, of %" PRId64 " actuators",
                           chambers, guides, count);
  const int64_t square = acts ? rank * rank : 0, cube = holds ? rank * rank * (rank + 1) / 2 : 0;
  if (SIZE(layout, actuator_square) != square || SIZE(layout, actuator_cube) != cube ||
      (SIZE(layout, actuator_bytes) != 0) != acts)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "arrays 'actuator_quadratic' and 'actuator_cubic' have rows of %" PRId64
                           " and %" PRId64 " numbers, not %" PRId64 " and %" PRId64,
                           SIZE(layout, actuator_square), SIZE(layout, actuator_cube), square,
                           cube);
  return THRUM_OK;
}

// what is absent has size 0, what is there has entries; indices are int32
static thrum_status check_mesh_sizes(const thrum_layout *layout, thrum_error *error) {
  static const int sizes[] = {THRUM_SIZE_vertex_count, THRUM_SIZE_tet_count,
                              THRUM_SIZE_region_count};
  static const char *const arrays[] = {"vertices", "tets", "material"};

  // mesh sizes are zero without a mesh and fit an int32 index with one
  for (int i = 0; i < 3; i++) {
    int64_t size = layout->size[sizes[i]];
    if (!HAS(layout, vertices) ? size != 0 : size < 1 || size > INT32_MAX / 3)
      return thrum_error_set(
          error, THRUM_BAD_SHAPE, "array '%s' %s %" PRId64 " rows; a mesh has 1 to %d, no mesh 0",
          arrays[i], HAS(layout, vertices) ? "has" : "is absent, yet has", size, INT32_MAX / 3);
  }

  // the same of groups and meta
  int64_t groups = SIZE(layout, group_count), members = SIZE(layout, group_vertex_count);
  int64_t text = SIZE(layout, group_name_bytes);
  if (!HAS(layout, group_ends) && (groups != 0 || members != 0 || text != 0))
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'group_ends' is absent, yet the group sizes are not 0");
  if (groups > INT32_MAX || members > INT32_MAX)
    return thrum_error_set(error, THRUM_BAD_SHAPE, "array 'group_vertices' is too long");
  if (!HAS(layout, meta) && SIZE(layout, meta_bytes) != 0)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'meta' is absent, yet meta_bytes is not 0");
  if (!HAS(layout, point_law) && SIZE(layout, law_bytes) != 0)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'point_law' is absent, yet law_bytes is not 0");

  // what parameters add has the numbers of what they add to
  const int64_t rank = SIZE(layout, rank);
  const bool parameters = HAS(layout, region_energy);
  const int64_t energy =
      parameters ? rank * rank + SIZE(layout, c3_count) + SIZE(layout, c4_count) : 0;
  const int64_t mass = parameters ? rank * (rank + 3) : 0;
  if (SIZE(layout, energy_size) != energy || SIZE(layout, mass_size) != mass)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "arrays 'region_energy' and 'region_mass' have rows of %" PRId64
                           " and %" PRId64 " numbers, not %" PRId64 " and %" PRId64,
                           SIZE(layout, energy_size), SIZE(layout, mass_size), energy, mass);

  THRUM_TRY(check_actuator_sizes(layout, error));

  // with a mesh the regions are those of its materials
  const int64_t laws = SIZE(layout, law_count), regions = SIZE(layout, region_count);
  if (HAS(layout, region_law) ? laws < 1 || laws > INT32_MAX : laws != 0)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'region_law' %s %" PRId64 " laws; there is one for each region",
                           HAS(layout, region_law) ? "has" : "is absent, yet there are", laws);
  if (HAS(layout, region_law) && HAS(layout, material) && laws != regions)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "array 'region_law' has %" PRId64 " laws, and 'material' %" PRId64
                           " regions",
                           laws, regions);
  return THRUM_OK;
}

thrum_status thrum_layout_check_sizes(const thrum_layout *layout, thrum_error *error) {
  for (int s = 0; s < THRUM_SIZE_COUNT; s++)
    if (layout->size[s] < 0)
      return thrum_error_set(error, THRUM_BAD_SHAPE, "%s is negative", thrum_size_names[s]);
  THRUM_TRY(check_rank(layout, error));
  THRUM_TRY(check_mesh_sizes(layout, error));
  for (int a = 0; a < THRUM_ARRAY_COUNT; a++)
    if (layout->data[a] != NULL && !fits_memory(layout, a))
      return thrum_error_set(error, THRUM_BAD_SHAPE, "array '%s' is larger than any memory",
                             thrum_array_table[a].name);
  return THRUM_OK;
}

static thrum_status check_finite(const thrum_layout *layout, int array, thrum_error *error) {
  const uint64_t exponent = UINT64_C(0x7FF0000000000000);
  const unsigned char *data = layout->data[array];
  int64_t count = (int64_t)(thrum_layout_bytes(layout, array) / 8);
  for (int64_t i = 0; i < count; i++) {
    uint64_t bits;
    memcpy(&bits, data + 8 * i, 8);
    if ((bits & exponent) == exponent)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array '%s' holds a value that is not finite (entry %" PRId64 ")",
                             thrum_array_table[array].name, i);
  }
  return THRUM_OK;
}

/* Numbers of which squares and products are taken. */
static thrum_status check_within(const thrum_layout *layout, int array, double most,
                                 thrum_error *error) {
  const unsigned char *data = layout->data[array];
  const int64_t count = data != NULL ? (int64_t)(thrum_layout_bytes(layout, array) / 8) : 0;
  for (int64_t i = 0; i < count; i++)
    if (!(fabs(get_f8(data, i)) <= most))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array '%s' holds %g (entry %" PRId64 "), which is beyond %g",
                             thrum_array_table[array].name, get_f8(data, i), i, most);
  return THRUM_OK;
}

static thrum_status check_omega2(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *omega2 = layout->data[THRUM_ARRAY_omega2];
  if (get_f8(omega2, 0) < 0.0)
    return thrum_error_set(error, THRUM_BAD_VALUE, "array 'omega2' holds a negative value");

  // what is stepped, and what follows it, each by itself
  const int64_t slaves = HAS(layout, slave_map) ? SIZE(layout, slave_count) : 0;
  for (int64_t i = 1; i < SIZE(layout, rank); i++) {
    const bool first = i == SIZE(layout, rank) - slaves;
    if (first && get_f8(omega2, i) < 0.0)
      return thrum_error_set(error, THRUM_BAD_VALUE, "array 'omega2' holds a negative value");
    if (!first && get_f8(omega2, i) < get_f8(omega2, i - 1))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'omega2' is not in ascending order (entry %" PRId64 ")", i);
  }
  return THRUM_OK;
}

// every entry of an int32 array from 0 to limit - 1
static thrum_status check_indices(const thrum_layout *layout, int array, int64_t limit,
                                  thrum_error *error) {
  int64_t count = (int64_t)(thrum_layout_bytes(layout, array) / 4);
  for (int64_t i = 0; i < count; i++) {
    int32_t value = get_i4(layout->data[array], i);
    if (value < 0 || value >= limit)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array '%s' holds the index %" PRId32 " (entry %" PRId64
                             "); 0 to %" PRId64 " are allowed",
                             thrum_array_table[array].name, value, i, limit - 1);
  }
  return THRUM_OK;
}

static thrum_status check_material(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *material = layout->data[THRUM_ARRAY_material];
  for (int64_t i = 0; i < SIZE(layout, region_count); i++) {
    double young = get_f8(material, 3 * i), poisson = get_f8(material, 3 * i + 1);
    double density = get_f8(material, 3 * i + 2);
    if (!(young > 0.0 && poisson > -1.0 && poisson < 0.5 && density > 0.0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'material' row %" PRId64 " (E %g, nu %g, density %g): E > 0, "
                             "-1 < nu < 0.5 and density > 0 are needed",
                             i, young, poisson, density);
  }
  return THRUM_OK;
}

// the name of a law that is known
static thrum_status check_law(const thrum_layout *layout, thrum_error *error) {
  const char *name = (const char *)layout->data[THRUM_ARRAY_point_law];
  const size_t bytes = (size_t)SIZE(layout, law_bytes);
  thrum_law law;
  if (bytes > 0 && name[bytes - 1] == 0 && thrum_law_find(name, bytes - 1, &law))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "array 'point_law' holds none of the names stvk, corotational and "
                         "neo-hookean, ended by one 0");
}

// laws that are known, of regions that there are, and yields where there is flow
static thrum_status check_region_laws(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *laws = layout->data[THRUM_ARRAY_region_law];
  const int64_t count = SIZE(layout, law_count);
  for (int64_t i = 0; i < count; i++)
    if (laws[i] >= THRUM_LAW_BY_REGION)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'region_law' holds %u (entry %" PRId64 "); 0, 1 and 2 are laws",
                             (unsigned)laws[i], i);

  // a yield is a strain
  for (int64_t i = 0; HAS(layout, region_yield) && i < count; i++) {
    const double yield = get_f8(layout->data[THRUM_ARRAY_region_yield], i);
    if (!(yield >= 0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'region_yield' holds %g (entry %" PRId64
                             "); yields are above 0, or 0 for none",
                             yield, i);
    if (yield > 0 && laws[i] == THRUM_LAW_STVK)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'region_yield' holds %g (entry %" PRId64
                             ") for a region of the law 0, stvk, which does not flow",
                             yield, i);
  }
  return check_indices(layout, THRUM_ARRAY_point_region, count, error);
}

// volumes that points stand for, and moduli of a material that resists every strain
static thrum_status check_points(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *moduli = layout->data[THRUM_ARRAY_point_moduli];
  const int64_t count = SIZE(layout, point_count);
  for (int64_t p = 0; p < count; p++) {
    const double weight = get_f8(layout->data[THRUM_ARRAY_point_weights], p);
    if (!(weight > 0.0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'point_weights' holds %g (entry %" PRId64
                             "); weights are volumes and > 0",
                             weight, p);

    // 3 lambda + 2 mu is three times the bulk modulus
    const double lambda = get_f8(moduli, p), mu = get_f8(moduli, count + p);
    if (!(mu > 0.0 && 3.0 * lambda + 2.0 * mu > 0.0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'point_moduli' holds lambda %g and mu %g (point %" PRId64
                             "); mu > 0 and 3 lambda + 2 mu > 0 are needed",
                             lambda, mu, p);
  }
  return THRUM_OK;
}

// strains, and a number that says yes or no
static thrum_status check_training(const thrum_layout *layout, thrum_error *error) {
  for (int n = 0; n < THRUM_TRAINING_NUMBERS; n++) {
    const double number = get_f8(layout->data[THRUM_ARRAY_point_training], n);
    const bool learned = n == THRUM_TRAINING_LEARNED;
    if (number < 0.0 || (learned && number != 0.0 && number != 1.0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'point_training' holds %g (entry %d); %s", number, n,
                             learned ? "0 or 1 is allowed there" : "strains are >= 0");
  }
  return THRUM_OK;
}

// springs that pull back, of a body that has no rigid modes and no points
static thrum_status check_springs(const thrum_layout *layout, thrum_error *error) {
  for (int64_t i = 0; i < 3 * SIZE(layout, vertex_count); i++) {
    const double stiffness = get_f8(layout->data[THRUM_ARRAY_springs], i);
    if (!(stiffness >= 0.0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'springs' holds %g (entry %" PRId64 "); stiffnesses are >= 0",
                             stiffness, i);
  }
  if (HAS(layout, rigid) || HAS(layout, point_weights))
    return thrum_error_set(error, THRUM_BAD_SHAPE, "array 'springs' does not go with '%s'",
                           HAS(layout, rigid) ? "rigid" : "point_weights");
  return THRUM_OK;
}

// runs of nodes as long as the forms have, and of tetrahedra, that fill both
static thrum_status check_solids(const thrum_layout *layout, thrum_error *error) {
  static const int nodes[] = {4, 10, 6, 15, 8, 20, 6, 8, 10};
  const unsigned char *forms = layout->data[THRUM_ARRAY_solid_form];
  const unsigned char *ends = layout->data[THRUM_ARRAY_solid_ends];
  const unsigned char *tet_ends = layout->data[THRUM_ARRAY_solid_tet_ends];
  const int64_t count = SIZE(layout, solid_count);
  int64_t end = 0, tet_end = 0;
  for (int64_t s = 0; s < count; s++) {
    if (forms[s] >= sizeof nodes / sizeof *nodes)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'solid_form' holds %u (entry %" PRId64 "); 0 to 8 are forms",
                             (unsigned)forms[s], s);
    if (get_i4(ends, s) != end + nodes[forms[s]])
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'solid_ends' holds %" PRId32 " (entry %" PRId64 "); %" PRId64
                             " is needed",
                             get_i4(ends, s), s, end + nodes[forms[s]]);
    end += nodes[forms[s]];
    if (get_i4(tet_ends, s) <= tet_end)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'solid_tet_ends' holds %" PRId32 " (entry %" PRId64
                             "); above %" PRId64 " is needed",
                             get_i4(tet_ends, s), s, tet_end);
    tet_end = get_i4(tet_ends, s);
  }
  if (end != SIZE(layout, solid_node_count) || tet_end != SIZE(layout, tet_count))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "arrays 'solid_ends' and 'solid_tet_ends' end at %" PRId64
                           " and %" PRId64 "; there are %" PRId64 " nodes and %" PRId64
                           " tetrahedra",
                           end, tet_end, SIZE(layout, solid_node_count), SIZE(layout, tet_count));
  return check_indices(layout, THRUM_ARRAY_solid_nodes, SIZE(layout, vertex_count), error);
}

// a row a layer: its region, ascending; moduli that are positive; a thickness that is not negative
static thrum_status check_elastic(const thrum_layout *layout, thrum_error *error) {
  enum { NUMBERS = 18, YOUNG = 1, SHEAR = 7, THICKNESS = 17 };
  const unsigned char *rows = layout->data[THRUM_ARRAY_elastic];
  double before = 0;
  for (int64_t n = 0; n < SIZE(layout, elastic_count); n++) {
    const double region = get_f8(rows, NUMBERS * n);
    if (!(region >= before && region < (double)SIZE(layout, region_count)) ||
        region != floor(region))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'elastic' holds %g (row %" PRId64
                             "); its first numbers are regions, ascending",
                             region, n);
    before = region;
    for (int k = 0; k < 3; k++)
      if (!(get_f8(rows, NUMBERS * n + YOUNG + k) > 0) ||
          !(get_f8(rows, NUMBERS * n + SHEAR + k) > 0))
        return thrum_error_set(
            error, THRUM_BAD_VALUE,
            "array 'elastic' holds a modulus that is not above 0 (row %" PRId64 ")", n);
    if (!(get_f8(rows, NUMBERS * n + THICKNESS) >= 0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'elastic' holds a negative thickness (row %" PRId64 ")", n);
  }
  return THRUM_OK;
}

// one coefficient for each product of two coordinates, whatever their order
static thrum_status check_symmetric(int array, int64_t entry, double one, double other,
                                    thrum_error *error) {
  if (one == other)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "array '%s' holds %g (entry %" PRId64 ") and %g for the same product",
                         thrum_array_table[array].name, one, entry, other);
}

static thrum_status check_quadratic(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *data = layout->data[THRUM_ARRAY_actuator_quadratic];
  const int64_t r = SIZE(layout, rank);
  for (int64_t n = 0; n < SIZE(layout, actuator_count); n++)
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = 0; j < i; j++) {
        const int64_t at = (n * r + i) * r + j;
        THRUM_TRY(check_symmetric(THRUM_ARRAY_actuator_quadratic, at, get_f8(data, at),
                                  get_f8(data, (n * r + j) * r + i), error));
      }
  return THRUM_OK;
}

// the row of q_i q_j, i <= j, among those of a chamber
static int64_t pair_row(int64_t rank, int64_t i, int64_t j) {
  return i * rank - i * (i - 1) / 2 + (j - i);
}

static thrum_status check_cubic(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *data = layout->data[THRUM_ARRAY_actuator_cubic];
  const int64_t r = SIZE(layout, rank);
  for (int64_t n = 0; n < SIZE(layout, chamber_count); n++)
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = i; j < r; j++)
        for (int64_t k = 0; k < j; k++) {
          // q_i q_j q_k, which is in the force of its highest coordinate j as well
          const int64_t low = k < i ? k : i, high = k < i ? i : k;
          const int64_t first = n * SIZE(layout, actuator_cube);
          const int64_t at = first + pair_row(r, i, j) * r + k;
          const double here = get_f8(data, at) / (k == i ? 2 : 1);
          const double there =
              get_f8(data, first + pair_row(r, low, high) * r + j) / (i == j ? 2 : 1);
          THRUM_TRY(check_symmetric(THRUM_ARRAY_actuator_cubic, at, here, there, error));
        }
  return THRUM_OK;
}

// kinds that are known, as many volumes as chambers, and guides of tendons alone
static thrum_status check_actuator_kinds(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *kinds = layout->data[THRUM_ARRAY_actuator_kind];
  int64_t chambers = 0, end = 0;
  for (int64_t n = 0; n < SIZE(layout, actuator_count); n++) {
    const int32_t kind = get_i4(kinds, n);
    const int64_t begin = end;
    end = HAS(layout, guide_ends) ? get_i4(layout->data[THRUM_ARRAY_guide_ends], n) : 0;
    if (kind < 0 || kind > THRUM_ACTUATOR_GAS)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'actuator_kind' holds %" PRId32 " (entry %" PRId64
                             "); 0 to %d are kinds",
                             kind, n, THRUM_ACTUATOR_GAS);
    const bool volume = kind == THRUM_ACTUATOR_PRESSURE || kind == THRUM_ACTUATOR_GAS;
    const int64_t guides = end - begin;
    chambers += volume;
    if (kind == THRUM_ACTUATOR_TENDON ? guides < 2 || guides > THRUM_GUIDES_MAX : guides != 0)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'guide_ends' gives actuator %" PRId64 " %" PRId64
                             " guides; a tendon has 2 to %d, others none",
                             n + 1, guides, THRUM_GUIDES_MAX);

    // a gas has a volume, and a pressure outside
    const unsigned char *rest = layout->data[THRUM_ARRAY_actuator_rest];
    if (kind == THRUM_ACTUATOR_GAS && !(get_f8(rest, 3 * n) > 0 && get_f8(rest, 3 * n + 1) >= 0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'actuator_rest' gives a gas the volume %g and the pressure %g; "
                             "above 0, and 0 or more are needed",
                             get_f8(rest, 3 * n), get_f8(rest, 3 * n + 1));
  }
  if (chambers != SIZE(layout, chamber_count) || end != SIZE(layout, guide_count))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'actuator_kind' has %" PRId64 " chambers and %" PRId64
                           " guides; there are %" PRId64 " and %" PRId64,
                           chambers, end, SIZE(layout, chamber_count), SIZE(layout, guide_count));
  return THRUM_OK;
}

// texts NAME=SPEC, as many as actuators
static thrum_status check_actuator_texts(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *text = layout->data[THRUM_ARRAY_actuator_texts];
  const int64_t bytes = SIZE(layout, actuator_bytes);
  int64_t count = 0, start = 0, equals = -1;
  bool good = true;
  for (int64_t i = 0; i < bytes && good; i++) {
    if (text[i] == '=' && equals < 0)
      equals = i;
    good = text[i] == 0 ? equals > start && equals + 1 < i : text[i] >= 0x20 && text[i] != 0x7F;
    if (text[i] == 0) {
      count++;
      start = i + 1;
      equals = -1;
    }
  }
  if (good && start == bytes && count == SIZE(layout, actuator_count))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "array 'actuator_texts' does not hold %" PRId64
                         " texts NAME=SPEC without control characters, each ended by one 0",
                         SIZE(layout, actuator_count));
}

static thrum_status check_actuator_values(const thrum_layout *layout, thrum_error *error) {
  THRUM_TRY(check_actuator_texts(layout, error));
  THRUM_TRY(check_actuator_kinds(layout, error));
  THRUM_TRY(check_quadratic(layout, error));
  return HAS(layout, actuator_cubic) ? check_cubic(layout, error) : THRUM_OK;
}

static thrum_status check_mesh(const thrum_layout *layout, thrum_error *error) {
  THRUM_TRY(check_indices(layout, THRUM_ARRAY_tets, SIZE(layout, vertex_count), error));
  THRUM_TRY(check_indices(layout, THRUM_ARRAY_tet_region, SIZE(layout, region_count), error));
  if (HAS(layout, midsides))
    THRUM_TRY(check_indices(layout, THRUM_ARRAY_midsides, SIZE(layout, vertex_count), error));
  if (HAS(layout, solid_form))
    THRUM_TRY(check_solids(layout, error));
  if (HAS(layout, elastic))
    THRUM_TRY(check_elastic(layout, error));
  THRUM_TRY(check_material(layout, error));
  if (HAS(layout, springs))
    THRUM_TRY(check_springs(layout, error));

  // rigid modes are those of a body that nothing holds; who reads both would count other unknowns
  const unsigned char *fixed = layout->data[THRUM_ARRAY_fixed];
  for (int64_t i = 0; i < SIZE(layout, vertex_count); i++) {
    if (fixed[i] > 7)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'fixed' holds %u (entry %" PRId64 "); 0 to 7 are allowed",
                             (unsigned)fixed[i], i);
    if (fixed[i] != 0 && HAS(layout, rigid))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'fixed' holds %u (entry %" PRId64
                             "); only 0 goes with 'rigid', the modes of a free body",
                             (unsigned)fixed[i], i);
  }
  return THRUM_OK;
}

// exactly group_count names, none empty, each ended by one 0, no control characters
static thrum_status check_group_names(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *text = layout->data[THRUM_ARRAY_group_names];
  int64_t bytes = SIZE(layout, group_name_bytes), names = 0, start = 0;

  // each 0 ends a name; a reader would print other control characters
  for (int64_t i = 0; i < bytes; i++) {
    if (text[i] == 0 && i == start)
      return thrum_error_set(error, THRUM_BAD_VALUE, "array 'group_names' holds an empty name");
    if (text[i] == 0) {
      names++;
      start = i + 1;
    } else if (text[i] < 0x20 || text[i] == 0x7F) {
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'group_names' holds a control character");
    }
  }

  // text behind the last 0 would be a name without an end
  if (start != bytes || names != SIZE(layout, group_count))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'group_names' holds %" PRId64 " names ended by 0, 'group_ends' "
                           "asks for %" PRId64,
                           names, SIZE(layout, group_count));
  return THRUM_OK;
}

// runs that are not empty and fill group_vertices, vertices ascending in each
static thrum_status check_groups(const thrum_layout *layout, thrum_error *error) {
  const unsigned char *ends = layout->data[THRUM_ARRAY_group_ends];
  const unsigned char *vertices = layout->data[THRUM_ARRAY_group_vertices];
  int64_t begin = 0, total = SIZE(layout, group_vertex_count);

  // ends ascend, so that each group is a run of its own
  for (int64_t g = 0; g < SIZE(layout, group_count); g++) {
    int64_t end = get_i4(ends, g);
    if (end <= begin || end > total)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "array 'group_ends' entry %" PRId64 " is %" PRId64 "; above %" PRId64
                             " and at most %" PRId64 " is needed",
                             g, end, begin, total);

    // ascending vertices make a search in a group possible and repeats impossible
    for (int64_t i = begin + 1; i < end; i++)
      if (get_i4(vertices, i) <= get_i4(vertices, i - 1))
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "array 'group_vertices' is not ascending within a group "
                               "(entry %" PRId64 ")",
                               i);

    begin = end;
  }

  // vertices behind the last end would belong to no group
  if (begin != total)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'group_ends' ends at %" PRId64 ", 'group_vertices' has %" PRId64,
                           begin, total);

  thrum_status status =
      check_indices(layout, THRUM_ARRAY_group_vertices, SIZE(layout, vertex_count), error);
  return status == THRUM_OK ? check_group_names(layout, error) : status;
}

thrum_status thrum_layout_check_values(const thrum_layout *layout, thrum_error *error) {
  // no number is missing or without bound
  for (int a = 0; a < THRUM_ARRAY_COUNT; a++) {
    if (layout->data[a] == NULL || thrum_array_table[a].descr[1] != 'f')
      continue;
    thrum_status status = check_finite(layout, a, error);
    if (status != THRUM_OK)
      return status;
  }

  // places, and what moves them, of which squares are taken
  THRUM_TRY(check_within(layout, THRUM_ARRAY_vertices, THRUM_PLACE_MAX, error));
  THRUM_TRY(check_within(layout, THRUM_ARRAY_basis, THRUM_BASIS_MAX, error));
  THRUM_TRY(check_within(layout, THRUM_ARRAY_rigid, THRUM_BASIS_MAX, error));

  // then what each array means
  thrum_status status = check_omega2(layout, error);
  if (status == THRUM_OK && HAS(layout, point_weights))
    status = check_points(layout, error);
  if (status == THRUM_OK && HAS(layout, point_training))
    status = check_training(layout, error);
  if (status == THRUM_OK && HAS(layout, point_law))
    status = check_law(layout, error);
  if (status == THRUM_OK && HAS(layout, region_law))
    status = check_region_laws(layout, error);
  if (status == THRUM_OK && HAS(layout, vertices))
    status = check_mesh(layout, error);
  if (status == THRUM_OK && HAS(layout, group_ends))
    status = check_groups(layout, error);
  if (status == THRUM_OK && HAS(layout, actuator_kind))
    status = check_actuator_values(layout, error);
  return status;
}
