/* Links: springs, ball joints, hinges and welds between places of two bodies, or of a body and a
 * frame that moves as it is told (docs/links.md).
 *
 * A place and three directions on each side are weighted sums of a mesh's vertices, so they have
 * rows of U of their own. What a link asks of them is linear or bilinear in positions, and its
 * force is the discrete gradient of that over the step: a joint does no work, a spring gives back
 * what it took, and neither changes the momentum of the bodies together, at any time step (Gonzalez
 * 1996, doi:10.1007/BF02440162; Betsch & Leyendecker 2006, doi:10.1002/nme.1639).
 *
 * Links are stepped with the bodies by thrum_contact_pairs_step_beside (thrum/contact_pairs.h).
 * Units are SI, vectors are in the world unless a field says otherwise.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_LINK_H
#define THRUM_LINK_H

#include <stdint.h>

#include "thrum/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The condition that a link puts on its two sides. */
typedef enum thrum_link_kind {
  THRUM_LINK_SPRING = 0, /* a spring and a damper between the two places */
  THRUM_LINK_BALL = 1,   /* the places stay together */
  THRUM_LINK_HINGE = 2,  /* the same, and the first directions stay parallel */
  THRUM_LINK_WELD = 3    /* the same, and all directions stay parallel */
} thrum_link_kind;

/* One side of a link. */
typedef struct thrum_link_side {
  int64_t member; /* of the step, 0-based */

  /* 4 x 3, in the axes of the member's mesh: the place at rest [m], and three directions at right
   * angles [1], which are those of the other side in the world as the link begins. */
  const double *rest;

  /* 4 x 3 x rank of the member's model: the rows of U of the place [kg^-1/2] and of the directions
   * [kg^-1/2 m^-1]. NULL: a solid, which has none. */
  const double *rows;
} thrum_link_side;

/* The forces and the account of a link. The work of its forces on the bodies is driven - stored -
 * lost. */
typedef struct thrum_link_report {
  double force[3];      /* mean over the last step, on the place of the first side [N] */
  double torque[3];     /* the same about it, of hinges and welds [N m] */
  double drift;         /* distance of the places of a joint after the last step [m] */
  double largest_drift; /* after any step but the first two, in which a joint closes [m] */
  double stored;        /* energy in the spring now [J] */
  double lost;          /* energy that the damper took, and what a joint takes as it closes [J] */
  double driven;        /* work of solids that move, on the bodies [J] */
} thrum_link_report;

/* A link in a step. */
typedef struct thrum_link {
  thrum_link_kind kind;
  thrum_link_side sides[2];

  /* Spring: stiffness [N/m] and damping [N s/m]; finite and >= 0. Larger: stiffer, and slower. The
   * length without force [m]; finite and >= 0. With length 0 a damper between two bodies acts along
   * the spring, and one that ends at a solid in every direction. */
  double stiffness, damping, length;

  int64_t steps;            /* that it was in; set 0 at its beginning, counted by the step */
  thrum_link_report report; /* set zero at its beginning, updated by the step */
} thrum_link;

#ifdef __cplusplus
}
#endif
#endif
