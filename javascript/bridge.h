/* What the files of the bridge share: those of the package, and those that the viewer adds.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_JAVASCRIPT_BRIDGE_H
#define THRUM_JAVASCRIPT_BRIDGE_H

#include "thrum/scene.h"

#define EXPORT(name) __attribute__((export_name(#name))) name
#define NUMBERS THRUM_RANK_MAX /* doubles that a call may hand to JavaScript, or take */

extern double js_number[NUMBERS];
extern thrum_error js_failure; /* of the last call that failed */

void *js_alloc(size_t bytes);

/* def_bridge.c: the def that JavaScript fills in, of the record that js_def made last. */
void *js_def_made(void);

/* scene_bridge.c: add what the def says, and return its number or a status below 0. */
int32_t js_scene_add_body(thrum_scene *scene, const thrum_model *model, int32_t integrator,
                          double alpha, double beta, const double *q, const double *p);
int32_t js_scene_add_link(thrum_scene *scene, int32_t body, int32_t other);

#endif
