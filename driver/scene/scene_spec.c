/* Reads scene files, and checks what can be said without any model.
 * SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driver/record/run_entries.h"
#include "driver/scene/scene_spec.h"
#include "driver/scene/scene_words.h"
#include "driver/spec/region_material.h"
#include "mesh/formats/mesh_read.h"
#include "thrum/thrum.h"

#define NAME_MAX_BYTES 63 /* as THRUM_SCENE_NAME_MAX has room for */

bool scene_axis_angle(const double axis[3], double angle, double rotation[4]) {
  const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const double half = 0.5 * SCENE_DEGREE * fmod(angle, 720.0);
  if (!isnormal(length))
    return false;
  rotation[0] = cos(half);
  for (int n = 0; n < 3; n++)
    rotation[1 + n] = sin(half) * axis[n] / length;
  return true;
}

const char *scene_body_place(const scene_spec *spec, const scene_body_spec *body,
                             char place[SCENE_PLACE_MAX]) {
  const json_node *node = body->settings.at.node;
  snprintf(place, SCENE_PLACE_MAX, "%.150s:%lld: body '%.64s'", spec->file.name,
           node != NULL ? (long long)node->line : 1, body->name);
  return place;
}

/* --- names ------------------------------------------------------------------------------------ */

bool scene_spec_is_name(const char *text) {
  static const char others[] = "-_.";
  if (text[0] == 0 || text[0] == '.' || text[0] == '-' || strlen(text) > NAME_MAX_BYTES)
    return false;
  for (; *text != 0; text++) {
    const bool letter = (*text >= 'a' && *text <= 'z') || (*text >= 'A' && *text <= 'Z');
    if (!letter && !(*text >= '0' && *text <= '9') && strchr(others, *text) == NULL)
      return false;
  }
  return true;
}

static thrum_status check_name(const config_file *file, const config_record *record,
                               const char *name, const char *other) {
  if (!scene_spec_is_name(name))
    return config_record_refuse(
        file, record, "name", THRUM_BAD_VALUE,
        "wants letters, digits, '-', '_' and '.', at most %d, not \"%.80s\"", NAME_MAX_BYTES, name);
  if (other != NULL && strcmp(name, other) == 0)
    return config_record_refuse(file, record, "name", THRUM_BAD_VALUE, "\"%s\" is there twice",
                                name);
  return THRUM_OK;
}

/* "body3" in the memory of the spec. */
static thrum_status give_name(const scene_spec *spec, const char *kind, int64_t index, char **kept,
                              const char **name) {
  char text[40];
  if (*name != NULL)
    return THRUM_OK;
  snprintf(text, sizeof text, "%s%lld", kind, (long long)index + 1);
  *name = *kept = strdup(text);
  if (*kept == NULL)
    return thrum_error_set(spec->file.error, THRUM_OUT_OF_MEMORY, "%.150s: out of memory",
                           spec->file.name);
  return THRUM_OK;
}

static thrum_status check_names(scene_spec *spec) {
  scene_body_spec *bodies = scene_bodies(spec);
  for (int64_t n = 0; n < spec->bodies.count; n++) {
    const config_record *at = &bodies[n].settings.at;
    THRUM_TRY(give_name(spec, "body", n, &bodies[n].kept_name, &bodies[n].name));
    THRUM_TRY(check_name(&spec->file, at, bodies[n].name, NULL));
    if (run_entries_of_scene(bodies[n].name))
      return config_record_refuse(&spec->file, at, "name", THRUM_BAD_VALUE,
                                  "\"%s\" is a file of the run; choose another", bodies[n].name);
    for (int64_t k = 0; k < n; k++)
      THRUM_TRY(check_name(&spec->file, at, bodies[n].name, bodies[k].name));
  }

  // probes name columns, so that they must differ among themselves only
  scene_probe_spec *probes = scene_probes(spec);
  for (int64_t n = 0; n < spec->probes.count; n++) {
    THRUM_TRY(give_name(spec, "probe", n, &probes[n].kept_name, &probes[n].name));
    THRUM_TRY(check_name(&spec->file, &probes[n].at, probes[n].name, NULL));
    for (int64_t k = 0; k < n; k++)
      THRUM_TRY(check_name(&spec->file, &probes[n].at, probes[n].name, probes[k].name));
  }
  return THRUM_OK;
}

/* --- records ---------------------------------------------------------------------------------- */

/* Refuses what says how imexv splits the modes where imexv does not step. */
static thrum_status check_split(const scene_spec *spec, const config_record *at,
                                thrum_integrator integrator) {
  static const char *const of_imexv[] = {"split", "safety", "split_form"};
  for (size_t n = 0; n < sizeof of_imexv / sizeof of_imexv[0]; n++)
    if (config_record_member(&spec->file, at, of_imexv[n]) != NULL)
      return config_record_refuse(&spec->file, at, of_imexv[n], THRUM_BAD_VALUE,
                                  "is of imexv, and %s steps; add \"integrator\": \"imexv\"",
                                  thrum_integrator_name(integrator));
  return THRUM_OK;
}

/* The keys of the scene itself serve the bodies that imexv steps. */
static thrum_status check_scene_split(const scene_spec *spec) {
  for (int64_t n = 0; n < spec->bodies.count; n++)
    if (scene_bodies(spec)[n].settings.def.integrator == THRUM_INTEGRATOR_IMEXV)
      return THRUM_OK;
  return check_split(spec, &spec->settings.at, spec->settings.def.integrator);
}

/* Materials of regions, each by itself; whether there are such regions the mesh says. */
static thrum_status check_regions(const scene_spec *spec, const scene_material_spec *material) {
  const config_texts *regions = &material->regions;
  if (regions->count > MESH_MODEL_MATERIALS_MAX)
    return config_record_refuse(&spec->file, &material->at, "regions", THRUM_BAD_VALUE,
                                "more than %d texts", MESH_MODEL_MATERIALS_MAX);
  for (int64_t n = 0; n < regions->count; n++) {
    thrum_error detail = {0};
    if (region_material_check(regions->texts[n], &detail) < 0)
      return config_record_refuse_text(&spec->file, &material->at, "regions", regions, n, "%s",
                                       detail.message);
  }
  return THRUM_OK;
}

/* A model has its own moduli and law, and may flow where its points do. */
static thrum_status check_material(const scene_spec *spec, const scene_body_spec *body, bool mesh) {
  const scene_material_spec *material = &body->material;
  static const char *const of_mesh[] = {"young", "poisson", "density", "law", "regions"};

  // a model was made with these, so a scene cannot change them
  for (int n = 0; n < 5 && !mesh && material->at.node != NULL; n++)
    if (config_record_member(&spec->file, &material->at, of_mesh[n]) != NULL)
      return config_record_refuse(&spec->file, &material->at, of_mesh[n], THRUM_BAD_VALUE,
                                  "is of a mesh; use \"stiffness\" and \"density\" of a model");
  THRUM_TRY(check_regions(spec, material));

  // nothing flows without a yield, which a region may have as well, nor in a polynomial
  const thrum_plastic *plastic = &material->plastic;
  const bool rate = !isinf(plastic->creep) || !isinf(plastic->largest);
  if (mesh && rate && isinf(plastic->yield) &&
      !region_materials_flow(material->regions.texts, material->regions.count))
    return config_record_refuse(&spec->file, &material->at, "yield", THRUM_MISSING,
                                "is needed: beyond it the material flows");

  // a yield needs points that flow, and stresses are those of elastic material
  if (!isinf(plastic->yield) && mesh && material->law == THRUM_LAW_STVK &&
      !region_materials_need_points(material->regions.texts, material->regions.count))
    return config_record_refuse(
        &spec->file, &material->at, "yield", THRUM_BAD_VALUE,
        "needs \"law\": \"corotational\" or \"neo-hookean\", or a region of "
        "one, whose points flow");
  if (!isinf(plastic->yield) && spec->outputs.stress)
    return config_record_refuse(&spec->file, &material->at, "yield", THRUM_BAD_VALUE,
                                "is not there with \"stress\", which is of a material that does "
                                "not flow");
  return THRUM_OK;
}

static thrum_status check_body(const scene_spec *spec, const scene_body_spec *body) {
  const config_record *at = &body->settings.at;
  const bool mesh = thrum_mesh_is_named(body->model);
  if (body->fix.count > MESH_MODEL_FIXES_MAX)
    return config_record_refuse(&spec->file, at, "fix", THRUM_BAD_VALUE, "more than %d texts",
                                MESH_MODEL_FIXES_MAX);
  if (!mesh && body->fix.count > 0)
    return config_record_refuse(&spec->file, at, "fix", THRUM_BAD_VALUE,
                                "is of a mesh; a model has its own");
  if (!mesh && body->order != 0)
    return config_record_refuse(&spec->file, at, "order", THRUM_BAD_VALUE,
                                "is of a mesh; a model has its own");
  if (mesh && body->free && body->fix.count > 0)
    return config_record_refuse(&spec->file, at, "fix", THRUM_BAD_VALUE,
                                "holds the body, and \"free\" lets it go: leave one of them out");
  THRUM_TRY(check_material(spec, body, mesh));
  if (body->settings.def.integrator != THRUM_INTEGRATOR_IMEXV)
    THRUM_TRY(check_split(spec, at, body->settings.def.integrator));

  // these are of the rigid motion, which a held body has not
  static const char *const of_free[] = {"velocity", "spin", "coupled"};
  for (int n = 0; n < 3 && !body->free; n++)
    if (config_record_member(&spec->file, at, of_free[n]) != NULL)
      return config_record_refuse(&spec->file, at, of_free[n], THRUM_BAD_VALUE,
                                  "is of a body that is free");

  // what steps fewer coordinates has no inertia of the deformed shape
  static const char *const of_apart[] = {"condense", "error", "budget", "detail"};
  for (int n = 0; n < 4 && body->coupled; n++)
    if (config_record_member(&spec->file, at, of_apart[n]) != NULL)
      return config_record_refuse(&spec->file, at, of_apart[n], THRUM_BAD_VALUE,
                                  "is not of a body that is coupled, which steps all of its "
                                  "coordinates");

  // condensed bodies do not touch with their surface
  for (int n = 0; n < 3 && body->self_contact; n++)
    if (config_record_member(&spec->file, at, of_apart[n]) != NULL)
      return config_record_refuse(&spec->file, at, of_apart[n], THRUM_BAD_VALUE,
                                  "is not of a body with \"self_contact\", which steps all of its "
                                  "coordinates");
  return THRUM_OK;
}

/* A key of one shape alone. */
static thrum_status check_key(const scene_spec *spec, const scene_obstacle_spec *obstacle,
                              const char *key, bool of_shape, bool needed, const char *shapes) {
  const config_record *at = &obstacle->at;
  const bool there = config_record_member(&spec->file, at, key) != NULL;
  if (there && !of_shape)
    return config_record_refuse(&spec->file, at, key, THRUM_BAD_VALUE, "is of a %s", shapes);
  if (!there && of_shape && needed)
    return config_record_refuse(&spec->file, at, NULL, THRUM_MISSING, "a %s needs \"%s\"",
                                scene_shape_names[obstacle->shape], key);
  return THRUM_OK;
}

/* The places of a path come one after the other. */
static thrum_status check_way(const scene_spec *spec, const scene_obstacle_spec *obstacle) {
  const scene_waypoint_spec *way = obstacle->way.items;
  for (int64_t n = 1; n < obstacle->way.count; n++)
    if (!(way[n].time > way[n - 1].time))
      return config_record_refuse(&spec->file, &way[n].at, "time", THRUM_BAD_VALUE,
                                  "must be after the %g s before it", way[n - 1].time);
  return THRUM_OK;
}

static thrum_status check_obstacle(const scene_spec *spec, const scene_obstacle_spec *obstacle) {
  const config_record *at = &obstacle->at;
  const scene_shape shape = obstacle->shape;
  const double *n = obstacle->normal;

  // keys that a shape needs, and keys of other shapes
  THRUM_TRY(check_key(spec, obstacle, "normal", shape == SCENE_PLANE, false, "plane"));
  const bool round = shape == SCENE_CYLINDER || shape == SCENE_CAPSULE;
  const bool field = shape == SCENE_HEIGHT_FIELD, solid = scene_obstacle_is_solid(obstacle);
  THRUM_TRY(check_key(spec, obstacle, "radius", shape == SCENE_SPHERE || round, true,
                      "sphere, cylinder or capsule"));
  THRUM_TRY(check_key(spec, obstacle, "height", round, true, "cylinder or capsule"));
  THRUM_TRY(check_key(spec, obstacle, "size", shape == SCENE_BOX, true, "box"));
  THRUM_TRY(check_key(spec, obstacle, "file", shape == SCENE_MESH, true, "mesh"));
  THRUM_TRY(check_key(spec, obstacle, "scale", shape == SCENE_MESH, false, "mesh"));
  THRUM_TRY(check_key(spec, obstacle, "heights", field, true, "height field"));
  THRUM_TRY(check_key(spec, obstacle, "spacing", field, true, "height field"));
  THRUM_TRY(check_key(spec, obstacle, "rotation", shape >= SCENE_BOX, false,
                      "box, cylinder, capsule, height field or mesh"));
  THRUM_TRY(check_key(spec, obstacle, "inside", shape == SCENE_SPHERE || shape == SCENE_BOX, false,
                      "sphere or box"));

  // what is touched by its faces has a law of its own, and may move along a path
  THRUM_TRY(check_key(spec, obstacle, "path", solid, false,
                      "box that is solid, cylinder, capsule, height field or mesh"));
  THRUM_TRY(check_key(spec, obstacle, "stiffness", !solid, false, "plane, a sphere or a room"));
  THRUM_TRY(check_key(spec, obstacle, "damping", !solid, false, "plane, a sphere or a room"));
  if (shape == SCENE_CYLINDER && !(obstacle->height > 0))
    return config_record_refuse(&spec->file, at, "height", THRUM_BAD_VALUE,
                                "a cylinder needs a height above 0 m");
  if (obstacle->way.count > 0 && config_record_member(&spec->file, at, "velocity") != NULL)
    return config_record_refuse(&spec->file, at, "velocity", THRUM_BAD_VALUE,
                                "is there already by the path");
  THRUM_TRY(check_way(spec, obstacle));

  // a normal may have any length but none
  if (!isnormal(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]))
    return config_record_refuse(&spec->file, at, "normal", THRUM_BAD_VALUE, "has no length");
  return THRUM_OK;
}

/* A key that names a body. */
static thrum_status check_body_name(const scene_spec *spec, const config_record *at,
                                    const char *key, const char *name) {
  for (int64_t n = 0; n < spec->bodies.count; n++)
    if (strcmp(scene_bodies(spec)[n].name, name) == 0)
      return THRUM_OK;
  return config_record_refuse(&spec->file, at, key, THRUM_BAD_VALUE, "there is no body \"%.60s\"",
                              name);
}

/* A key that names vertices. */
static thrum_status check_target(const scene_spec *spec, const config_record *at, const char *key,
                                 const char *text) {
  load_target target;
  thrum_error detail = {0};
  if (load_target_parse(text, key, &target, &detail) < 0)
    return config_record_refuse(&spec->file, at, key, THRUM_BAD_VALUE, "%s", detail.message);
  return THRUM_OK;
}

static thrum_status check_probe(const scene_spec *spec, const scene_probe_spec *probe) {
  THRUM_TRY(check_body_name(spec, &probe->at, "body", probe->body));
  return check_target(spec, &probe->at, "at", probe->target);
}

/* Refuses a key of a link that is of no use to it. */
static thrum_status check_link_key(const scene_spec *spec, const scene_link_spec *link,
                                   const char *key, bool of_use, const char *only) {
  if (of_use || config_record_member(&spec->file, &link->at, key) == NULL)
    return THRUM_OK;
  return config_record_refuse(&spec->file, &link->at, key, THRUM_BAD_VALUE, "is of %s", only);
}

/* Reads which bodies a link ties, and where. */
static thrum_status check_link_ends(const scene_spec *spec, const scene_link_spec *link) {
  const config_record *at = &link->at;
  THRUM_TRY(check_body_name(spec, at, "body", link->body));
  if (link->other != NULL)
    THRUM_TRY(check_body_name(spec, at, "other", link->other));
  if (link->other != NULL && strcmp(link->body, link->other) == 0)
    return config_record_refuse(&spec->file, at, "other", THRUM_BAD_VALUE,
                                "is the same body; leave it out for the world");

  // a link needs a place, and its targets must have the right form
  if (link->target == NULL && isnan(link->place[0]))
    return config_record_refuse(&spec->file, at, NULL, THRUM_MISSING,
                                "a link needs \"at\" or \"place\"");
  if (link->target != NULL)
    THRUM_TRY(check_target(spec, at, "at", link->target));
  return link->other_target == NULL ? THRUM_OK
                                    : check_target(spec, at, "other_at", link->other_target);
}

static thrum_status check_link_path(const scene_spec *spec, const scene_link_spec *link) {
  const scene_link_waypoint_spec *way = link->way.items;
  for (int64_t n = 1; n < link->way.count; n++)
    if (!(way[n].time > way[n - 1].time))
      return config_record_refuse(&spec->file, &way[n].at, "time", THRUM_BAD_VALUE,
                                  "must be after the %g s before it", way[n - 1].time);
  if (link->way.count > 0 && link->path != NULL)
    return config_record_refuse(&spec->file, &link->at, "file", THRUM_BAD_VALUE,
                                "is there already by the path");
  return THRUM_OK;
}

static thrum_status check_link(const scene_spec *spec, const scene_link_spec *link) {
  const bool spring = link->kind == THRUM_LINK_SPRING, world = link->other == NULL;
  THRUM_TRY(check_link_ends(spec, link));

  // keys of one kind, and of one end
  THRUM_TRY(check_link_key(spec, link, "stiffness", spring, "a spring"));
  THRUM_TRY(check_link_key(spec, link, "damping", spring, "a spring"));
  THRUM_TRY(check_link_key(spec, link, "length", spring, "a spring"));
  THRUM_TRY(check_link_key(spec, link, "other_place", spring, "a spring"));
  THRUM_TRY(check_link_key(spec, link, "axis", link->kind == THRUM_LINK_HINGE, "a hinge"));
  THRUM_TRY(check_link_key(spec, link, "other_at", !world, "another body"));
  THRUM_TRY(check_link_key(spec, link, "path", world, "a link with the world"));
  THRUM_TRY(check_link_key(spec, link, "file", world, "a link with the world"));

  // a spring that never pulls is one whose stiffness was forgotten
  if (spring && link->stiffness == 0 && link->damping == 0)
    return config_record_refuse(&spec->file, &link->at, NULL, THRUM_MISSING,
                                "a spring needs \"stiffness\" or \"damping\"");
  return check_link_path(spec, link);
}

static bool has_free_body(const scene_spec *spec) {
  bool any = false;
  for (int64_t n = 0; n < spec->bodies.count; n++)
    any = any || scene_bodies(spec)[n].free;
  return any;
}

/* Refuses what no single key shows to be wrong, and fills in defaults that follow from the rest. */
static thrum_status check(scene_spec *spec) {
  if (spec->bodies.count == 0)
    return config_record_refuse(&spec->file, &spec->settings.at, "bodies", THRUM_MISSING,
                                "a scene needs a body");

  // names first: the messages of the others use them
  THRUM_TRY(check_names(spec));
  THRUM_TRY(check_scene_split(spec));
  for (int64_t n = 0; n < spec->bodies.count; n++)
    THRUM_TRY(check_body(spec, &scene_bodies(spec)[n]));
  for (int64_t n = 0; n < spec->obstacles.count; n++)
    THRUM_TRY(check_obstacle(spec, &scene_obstacles(spec)[n]));
  for (int64_t n = 0; n < spec->probes.count; n++)
    THRUM_TRY(check_probe(spec, &scene_probes(spec)[n]));
  for (int64_t n = 0; n < spec->links.count; n++)
    THRUM_TRY(check_link(spec, &scene_links(spec)[n]));

  // plots of few bodies, contact where something can move away
  if (config_record_member(&spec->file, &spec->outputs.at, "plots") == NULL)
    spec->outputs.plots = spec->bodies.count <= SCENE_PLOTS_MAX;
  if (config_record_member(&spec->file, &spec->settings.at, "collide") == NULL)
    spec->collide = has_free_body(spec);
  return THRUM_OK;
}

/* --- files ------------------------------------------------------------------------------------ */

/* The defaults of a scene. */
static void begin_scene(scene_spec *spec) {
  *spec = (scene_spec){
      .settings = {.def = thrum_default_state_def()},
      .time = 10,
      .wind = {THRUM_WIND_FIELDS(SCENE_VALUE)},
      .outputs = {.record_every = 1,
                  .monitor = true,
                  .basis = {.accepted = BASIS_ACCEPTED},
                  .plots = true},
      .collisions = {THRUM_PAIRS_FIELDS(SCENE_VALUE)},
  };
}

/* What a run of one model has, and a scene has not. */
static thrum_status refuse_ratios(const scene_spec *spec) {
  const json_document *document = &spec->file.document;
  for (int64_t n = 0; n < document->count; n++) {
    const char *key = document->nodes[n].key;
    if (key != NULL && (strcmp(key, "damping_ratio") == 0 || strcmp(key, "q") == 0))
      return thrum_error_set(
          spec->file.error, THRUM_UNSUPPORTED,
          "%.150s:%lld: \"%s\" is of the modes of one model, thrum simulate MODEL; in a scene give "
          "a "
          "body \"damping\": A in 1/s, twice the ratio and the angular frequency of the mode that "
          "swings",
          spec->file.name, (long long)document->nodes[n].line, key);
  }
  return THRUM_OK;
}

static thrum_status read_scene(scene_spec *spec) {
  const json_node *root = &spec->file.document.nodes[0];
  if (root->type != JSON_OBJECT)
    return thrum_error_set(spec->file.error, THRUM_BAD_FORMAT,
                           "%.150s:%lld: a scene stands in { }, with its \"bodies\" in [ ]",
                           spec->file.name, (long long)root->line);
  THRUM_TRY(refuse_ratios(spec));
  THRUM_TRY(config_record_read(&spec->file, scene_keys, spec));
  return check(spec);
}

thrum_status scene_spec_read_text(const char *name, const char *bytes, size_t length,
                                  scene_spec *spec, thrum_error *error) {
  begin_scene(spec);
  THRUM_TRY(config_file_parse(name, bytes, length, &spec->file, error));
  spec->file.words = scene_words;
  return read_scene(spec);
}

/* A surface shown in place of a body's own is of use to viewers alone, but must be there. */
static thrum_status check_surface(const scene_spec *spec, const scene_body_spec *body) {
  if (body->surface == NULL || access(body->surface, R_OK) == 0)
    return THRUM_OK;
  return config_record_refuse(&spec->file, &body->settings.at, "surface", THRUM_IO, "%.200s: %s",
                              body->surface, strerror(errno));
}

thrum_status scene_spec_read(const char *path, scene_spec *spec, thrum_error *error) {
  begin_scene(spec);
  THRUM_TRY(config_file_open(path, "scene file", &spec->file, error));
  spec->file.words = scene_words;
  THRUM_TRY(read_scene(spec));
  for (int64_t n = 0; n < spec->bodies.count; n++)
    THRUM_TRY(check_surface(spec, &scene_bodies(spec)[n]));
  return THRUM_OK;
}

void scene_spec_free(scene_spec *spec) {
  for (int64_t n = 0; n < spec->bodies.count; n++)
    free(scene_bodies(spec)[n].kept_name);
  for (int64_t n = 0; n < spec->probes.count; n++)
    free(scene_probes(spec)[n].kept_name);
  config_record_free(scene_keys, spec);
  config_file_free(&spec->file);
  *spec = (scene_spec){0};
}
