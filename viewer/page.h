/* The models and the one scene of a page, shared by the files of the bridge.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VIEWER_BRIDGE_H
#define THRUM_VIEWER_BRIDGE_H

#include "thrum/scene.h"

#define EXPORT(name) __attribute__((export_name(#name))) name

#define CORNERS 4
#define NUMBERS THRUM_RANK_MAX /* doubles that a call may hand to JavaScript, or take */

/* A model as the page has it: its shown vertices, then the four corners of a tetrahedron, from
 * which the inertia of a free body is taken. */
typedef struct bridge_model {
  thrum_model model;
  const thrum_surface *surface;
  const int32_t *triangles; /* triangle_count x 3 */
  int64_t triangle_count;
  int32_t *touch; /* vertices that may touch obstacles: those that are not held */
  int64_t touch_count;
  int32_t corners[CORNERS];
  double material[3]; /* of model: Young's modulus, which the stiffness of contact follows */
  float *positions;   /* vertex_count x 3, scratch of picking */
} bridge_model;

extern thrum_scene *bridge_scene;
extern double bridge_number[NUMBERS];
extern thrum_error bridge_error; /* of the last call that failed */

void *bridge_alloc(size_t bytes);

/* NULL for a number that names none. */
const bridge_model *bridge_model_at(int32_t number);

/* Takes a model as one of the page's. Returns its number, or a status below 0. */
int32_t bridge_model_add(const bridge_model *made);

/* bridge_file.c: the model that was opened last (NULL: none), and that its memory is to stay. */
const thrum_model *bridge_opened_model(void);
void bridge_keep_opened(void);

/* bridge_effects.c: the motions of a scene that is gone. */
void bridge_forget_motions(void);

/* The model of a body; NULL for a number that names none. */
const bridge_model *bridge_body_model(int32_t body);

#endif
