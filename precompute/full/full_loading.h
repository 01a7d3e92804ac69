/* The loads under which a full-order body is brought to rest: loads that keep their direction,
 * loads that turn with a group of vertices, and groups that are moved and turned.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_LOADING_H
#define THRUM_PRECOMPUTE_FULL_FULL_LOADING_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/model.h"

/* A force and a moment that turn with a group: with the rotation that takes its vertices at rest
 * nearest to where they are, in the sense of least squares. */
typedef struct thrum_full_follower {
  const int32_t *vertices; /* NULL: all of them */
  int64_t count;
  double force[3]; /* its direction at rest [N], shared equally by the vertices */
  double
      moment[3]; /* about the mean of the vertices [N m], as forces that grow with the distance */
} thrum_full_follower;

/* A group that is held and turned as a rigid whole about the mean of its vertices. */
typedef struct thrum_full_turn {
  const int32_t *vertices; /* NULL: all of them */
  int64_t count;
  double by[3]; /* axis times angle [rad], counted from where the group is at the start */
  bool moved;   /* `to` says where the mean goes; else it stays */
  double to[3]; /* displacement of the mean from its place at rest [m] */
} thrum_full_turn;

/* An equilibrium of the path to a load. */
typedef struct thrum_full_point {
  double factor; /* of the load [1] */
  double energy; /* V [J] */
  double least;  /* least eigenvalue of the tangent [1/s^2], to 1 %; NaN: the path is not watched */
  bool jumped;   /* the body fell to it from where its branch ended */
} thrum_full_point;

typedef struct thrum_full_loading {
  const double *forces; /* 3 vertex_count [N], NULL: none */
  const double *moves;  /* 3 vertex_count: displacements [m] that held components are brought to;
                           NULL: they stay at zero */
  const thrum_full_follower *followers;
  int64_t follower_count;
  const thrum_full_turn *turns; /* of held vertices */
  int64_t turn_count;
  /* Called at each equilibrium of the path, from the start on; NULL: nobody looks. The
   * displacements are those of the body then: thrum_full_mean. */
  void (*visit)(void *context, const thrum_full_point *point);
  void *visit_context;
  bool watch; /* the path keeps to its branch, and tells where that loses its stability; without
                 followers */
} thrum_full_loading;

/* Followers of a body as its search uses them. */
typedef struct full_followers {
  const thrum_full_loading *loading;
  const double *rest; /* vertices at rest, 3 a vertex [m] */
  double *at_rest;    /* the forces of each follower's vertices at rest, one after the other */
} full_followers;

/* THRUM_INVALID_ARGUMENT where the vertices of a follower lie on a line, so that no rotation is
 * told by them. An empty one is fine to free. */
thrum_status full_followers_make(const thrum_full_loading *loading, const double *rest,
                                 full_followers *followers, thrum_error *error);
void full_followers_free(full_followers *followers);

/* forces (all components) += scale times the followers where the body is displaced by `place`. */
void full_followers_add(const full_followers *followers, const double *place, double scale,
                        double *forces);

/* One of the 3 follower_count products of which their derivative by `place` is the sum, turn x
 * feel^T: turn, the change of the forces by a rotation about axis k; feel, how that rotation
 * changes with the place. Fields of all components, zeroed here. */
void full_followers_product(const full_followers *followers, const double *place, int64_t n,
                            double *turn, double *feel);

/* Where held and turned components are at `share` of the way: displacements of all components that
 * turned groups have, into `held`; `start`: all components at the start. */
void full_turns_place(const thrum_full_loading *loading, const double *rest, const double *start,
                      double share, double *held);

#endif
