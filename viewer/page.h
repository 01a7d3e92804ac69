/* The models of a page, shared by its files; its scene is that of javascript/bridge_scene.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VIEWER_PAGE_H
#define THRUM_VIEWER_PAGE_H

#include "javascript/bridge.h"

#define CORNERS 4

/* A model as the page has it: its shown vertices, then the four corners of a tetrahedron, from
 * which the inertia of a free body is taken. */
typedef struct page_model {
  thrum_model model;
  const thrum_surface *surface;
  const int32_t *triangles; /* triangle_count x 3 */
  int64_t triangle_count;
  int32_t *touch; /* vertices that may touch obstacles: those that are not held */
  int64_t touch_count;
  int32_t corners[CORNERS];
  double material[3]; /* of model: Young's modulus, which the stiffness of contact follows */
  float *positions;   /* vertex_count x 3, scratch of picking */
} page_model;

/* NULL for a number that names none. */
const page_model *page_model_at(int32_t number);

/* Takes a model as one of the page's. Returns its number, or a status below 0. */
int32_t page_model_add(const page_model *made);

/* page_file.c: the model that was opened last (NULL: none), and that its memory is to stay. */
const thrum_model *page_opened_model(void);
void page_keep_opened(void);

/* The model of a body of the page's one scene; NULL for a number that names none. */
const page_model *page_body_model(const thrum_scene *scene, int32_t body);

#endif
