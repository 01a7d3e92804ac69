/* Says what of an examined mesh is probably a mistake, and what to do about it. Every threshold is
 * a judgement, written down here and in docs/meshes.md.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_flags.h"

#include <math.h>
#include <stdio.h>

/* Bodies outside are likely in other units than metres: a part of 3 cm drawn in millimetres comes
 * as 30 m, one of 1 m drawn in kilometres as 1 mm. */
static const double EXTENT_LARGE = 20, EXTENT_SMALL = 0.001;
/* No solid is lighter or heavier [kg/m^3]; steel in tonnes and millimetres is 7.85e-9. */
static const double DENSITY_LIGHT = 0.5, DENSITY_HEAVY = 30000;
/* No solid is softer than a gel of 10 Pa, or stiffer than diamond with 1.2e12 Pa; and none that is
 * heavier than concrete is softer than 0.5 MPa: steel in MPa is 2.1e5, aluminium 7e4. */
static const double YOUNG_SOFT = 10, YOUNG_STIFF = 2e12, YOUNG_HEAVY = 5e5, DENSITY_STONE = 2500;
/* Distance from the origin in extents: beyond, positions have lost five of sixteen digits. */
static const double DISTANCE_FAR = 1e5;
/* Linear tets lock towards incompressibility; nearly all of them touching the surface with all
 * their corners leaves none to bend. */
static const double POISSON_LOCKS = 0.45, SHALLOW_SHARE = 0.9;
static const double GRAVITY = 9.81; /* [m/s^2] */
/* A tet as flat as this spoils the stiffness and the critical time step. */
static const double RATIO_SLIVER = 0.05;

static double distance(const thrum_mesh_examined *e) {
  double far = 0;
  for (int c = 0; c < 3; c++)
    far = fmax(far, fmax(fabs(e->box_min[c]), fabs(e->box_max[c])));
  return far;
}

static bool is_odd(double density) {
  return !(density >= DENSITY_LIGHT && density <= DENSITY_HEAVY);
}

int64_t thrum_mesh_odd_density(const thrum_mesh *mesh) {
  for (int64_t i = 0; i < mesh->region_count && mesh->has_material; i++)
    if (is_odd(mesh->materials[i].density))
      return i;
  return -1;
}

static bool is_odd_modulus(const thrum_material *m) {
  return !(m->young >= YOUNG_SOFT && m->young <= YOUNG_STIFF) ||
         (m->density > DENSITY_STONE && m->density <= DENSITY_HEAVY && m->young < YOUNG_HEAVY);
}

int64_t thrum_mesh_odd_modulus(const thrum_mesh *mesh) {
  for (int64_t i = 0; i < mesh->region_count && mesh->has_material; i++)
    if (is_odd_modulus(&mesh->materials[i]))
      return i;
  return -1;
}

double thrum_mesh_weight_strain(const thrum_mesh *mesh, double longest) {
  double most = 0;
  for (int64_t i = 0; i < mesh->region_count && mesh->has_material; i++)
    most = fmax(most, mesh->materials[i].density * GRAVITY * longest / mesh->materials[i].young);
  return most;
}

/* Advises on a length: materials in millimetres, tonnes and seconds come with it, or lengths are
 * alone. */
static const char *length_advice(const thrum_mesh *mesh, double extent) {
  const int64_t density = thrum_mesh_odd_density(mesh);
  if (extent <= 1)
    return "is its file in kilometres? --scale 1000";
  if (extent >= 1e3 * EXTENT_LARGE)
    return "is its file in micrometres? --scale 1e-6";
  return (density >= 0 && !is_odd(1e12 * mesh->materials[density].density)) ||
                 thrum_mesh_odd_modulus(mesh) >= 0
             ? "is its file in millimetres, tonnes and seconds? --unit mm-t-s"
             : "is its file in millimetres? --scale 0.001, or --unit mm-t-s with materials of it";
}

/* Advises on a density: decks in millimetres often have tonnes by cubic millimetre. */
static const char *density_advice(double density) {
  return is_odd(1e12 * density) ? "materials are in Pa and kg/m^3 unless --unit says otherwise"
                                : "a file in millimetres, tonnes and seconds needs --unit mm-t-s";
}

unsigned thrum_mesh_flags(const thrum_mesh *mesh, const thrum_mesh_examined *e) {
  unsigned flags = 0;
  flags |= e->pieces > 1 ? THRUM_EXAMINE_PIECES : 0U;
  flags |= e->coincident_vertices > 0 ? THRUM_EXAMINE_COINCIDENT : 0U;
  flags |= e->hinges > 0 ? THRUM_EXAMINE_HINGES : 0U;
  flags |= e->extent >= EXTENT_LARGE || e->extent <= EXTENT_SMALL ? THRUM_EXAMINE_UNITS : 0U;
  flags |= thrum_mesh_odd_density(mesh) >= 0 ? THRUM_EXAMINE_DENSITY : 0U;
  flags |= thrum_mesh_odd_modulus(mesh) >= 0 ? THRUM_EXAMINE_MODULUS : 0U;
  flags |= distance(e) > DISTANCE_FAR * e->extent ? THRUM_EXAMINE_FAR : 0U;

  // tets of ten nodes and solids bend, and lock far less
  const bool linear = mesh->midsides == NULL && mesh->solid_count == 0;
  const bool thin = (double)e->shallow_tets > SHALLOW_SHARE * (double)mesh->tet_count;
  flags |= linear && e->poisson_max > POISSON_LOCKS ? THRUM_EXAMINE_LOCKING : 0U;
  flags |= linear && thin ? THRUM_EXAMINE_THIN : 0U;
  flags |= e->ratio_min < RATIO_SLIVER ? THRUM_EXAMINE_SLIVERS : 0U;

  // middle nodes of quadratic tets, and centres of what was cut, are dropped as a matter of course
  const bool dropped =
      mesh->dropped_vertices > 0 && mesh->cornered_tets == 0 && mesh->cut_elements == 0;
  flags |= mesh->flipped_tets > 0 || dropped ? THRUM_EXAMINE_REPAIRED : 0U;
  return flags;
}

const char *thrum_mesh_flag_line(const thrum_mesh *mesh, const thrum_mesh_examined *e,
                                 thrum_examine_flag flag, char line[300]) {
  // each line says what is there, why it matters, and what to do
  enum { SIZE = 300 };

  switch (flag) {
  // what the body is made of
  case THRUM_EXAMINE_PIECES:
    snprintf(line, SIZE,
             "%lld pieces that share no vertex (the largest has %lld of %lld tets); each must be "
             "held, or the parts joined in the mesher",
             (long long)e->pieces, (long long)e->largest_piece, (long long)mesh->tet_count);
    break;
  case THRUM_EXAMINE_COINCIDENT:
    snprintf(line, SIZE,
             "%lld vertices lie exactly on another one; where parts should hold together, merge "
             "them (Gmsh: Mesh > Remove duplicate nodes)",
             (long long)e->coincident_vertices);
    break;
  case THRUM_EXAMINE_HINGES:
    snprintf(line, SIZE,
             "%lld edges of the surface have more than two triangles: parts of the body hang "
             "together by an edge only, as on a hinge",
             (long long)e->hinges);
    break;

  // sizes and materials that a wrong unit explains
  case THRUM_EXAMINE_UNITS:
    snprintf(line, SIZE, "the body is %.3g m long: %s; --unit m-kg-s says that it is in metres",
             e->extent, length_advice(mesh, e->extent));
    break;
  case THRUM_EXAMINE_MODULUS: {
    const int64_t odd = thrum_mesh_odd_modulus(mesh);
    const thrum_material none = {0}, *of = odd >= 0 ? &mesh->materials[odd] : &none;
    snprintf(line, SIZE, "no material has a Young's modulus of %.3g Pa at %.3g kg/m^3; %s",
             of->young, of->density,
             is_odd_modulus(&(thrum_material){1e6 * of->young, 0.3, of->density})
                 ? "materials are in Pa and kg/m^3 unless --unit says otherwise"
                 : "is it in MPa? options are in Pa, and a file in millimetres, tonnes and seconds "
                   "needs --unit mm-t-s");
    break;
  }
  case THRUM_EXAMINE_DENSITY: {
    const int64_t odd = thrum_mesh_odd_density(mesh);
    const double density = odd >= 0 ? mesh->materials[odd].density : 0;
    snprintf(line, SIZE, "a density is %.3g kg/m^3, outside %g to %g; %s", density, DENSITY_LIGHT,
             DENSITY_HEAVY, density_advice(density));
    break;
  }
  case THRUM_EXAMINE_FAR:
    snprintf(line, SIZE,
             "the body lies %.3g m from the origin but is %.3g m long: positions lose digits; move "
             "it near the origin in the mesher",
             distance(e), e->extent);
    break;

  // meshes whose linear tetrahedra are too stiff
  case THRUM_EXAMINE_LOCKING:
    snprintf(line, SIZE,
             "Poisson's ratio %g is above %g: linear tetrahedra lock, and the body will be too "
             "stiff; ten nodes (--order 2) lock far less",
             e->poisson_max, POISSON_LOCKS);
    break;
  case THRUM_EXAMINE_THIN:
    snprintf(line, SIZE,
             "%lld of %lld tets reach the surface with all corners, so there is one element "
             "through the thickness: bending will be too stiff; refine, or give --order 2",
             (long long)e->shallow_tets, (long long)mesh->tet_count);
    break;
  case THRUM_EXAMINE_SLIVERS:
    snprintf(line, SIZE,
             "the worst %s of %.2g (1 is regular, below %g is a sliver); optimise the mesh in the "
             "mesher",
             mesh->solid_count > 0 ? "element has a scaled Jacobian" : "tet has a mean ratio",
             e->ratio_min, RATIO_SLIVER);
    break;

  // what reading has changed already
  case THRUM_EXAMINE_REPAIRED:
    snprintf(line, SIZE,
             "%lld inverted tets were flipped and %lld vertices of no tet dropped while reading",
             (long long)mesh->flipped_tets, (long long)mesh->dropped_vertices);
    break;
  }
  return line;
}
