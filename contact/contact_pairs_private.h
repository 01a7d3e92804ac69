/* Contact between bodies in memory and a step of it in the making, private to the runtime: one
 * header, then arrays at offsets that follow from the sizes in the header; no pointer is stored
 * (thrum/contact_pairs.h, docs/contact.md).
 *
 * What persists from step to step are the touches, which lie in front; all else is scratch.
 *
 * A step goes through these files: contact_pairs_search.c finds the candidates, by lists of
 * contact_pairs_list.c that hold for several steps where bodies are slow,
 * contact_pairs_rows.c makes rows of them but for those that contact_pairs_idle.c has wait,
 * contact_pairs_solve.c solves them with the rows of the bodies' obstacles, contact_pairs_energy.c
 * looks at what the step did; contact_pairs_step.c calls them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_PRIVATE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_PAIRS_PRIVATE_H

#include "contact/contact_newton.h"
#include "contact/contact_row.h"
#include "contact/contact_skin.h"
#include "thrum/contact_pairs.h"

#define THRUM_NEAR 2.0             /* thicknesses within which two places are near each other */
#define THRUM_PAIRS_THICKNESS 4e-3 /* of the smaller body's diagonal (docs/tuning.md) */
#define THRUM_SURE 0.99            /* of a bound: the rest is for rounding */

/* Kind of a touch: what touches what. The first side is a vertex of the first or of the second
 * body, or an edge of the first. A body that touches itself is both, by the first and the last
 * kind. */
typedef enum thrum_pair_kind {
  THRUM_PAIR_VERTEX = 0,  /* vertex of body a, triangle of body b */
  THRUM_PAIR_REVERSE = 1, /* vertex of body b, triangle of body a */
  THRUM_PAIR_EDGES = 2    /* edge of body a, edge of body b */
} thrum_pair_kind;

/* Names a touch from step to step. */
typedef struct thrum_pair_key {
  int32_t bodies[2]; /* a < b, or a = b: a body that touches itself */
  int32_t kind, first, second;
} thrum_pair_key;

/* An entry that is sorted: its key as two numbers in the same order, and where it is. */
typedef struct thrum_pair_sorted {
  uint64_t bodies, places;
  int32_t at;
} thrum_pair_sorted;

/* A touch that persists. */
typedef struct thrum_pair_touching {
  thrum_pair_key key;
  int32_t towards; /* as in thrum_touching, and all below */
  double normal[3], force, friction[3], approach, stored;
  double distance;    /* between the surfaces after the step [m] */
  double thickness;   /* that it kept [m] */
  double position[3]; /* where the force acted [m] */
} thrum_pair_touching;

/* Two places that may touch in this step, before any force. */
typedef struct thrum_pair_candidate {
  thrum_pair_key key;
  int32_t members[2];  /* of the first and the second side */
  int32_t vertices[4]; /* in their skins */
  double weights[4];
  double normal[3]; /* from the second side to the first */
  double apart;     /* distance along it at the start of the step [m] */
  double least;     /* least distance in the step, or that at the start [m] */
  int32_t inside;   /* 1: the closest point is not on a rim */
  int32_t pruned;   /* 1: another candidate of its vertex speaks for it */
  int32_t slow;     /* 1: its bodies move by little in the step, as those that have lists do */
} thrum_pair_candidate;

/* A row of the solve: the same law as that of an obstacle, with two bodies. Between two places of
 * one body it has no lever, and the rows of U of its first side are the difference of those of both
 * places: what moves or turns the body as a whole leaves their distance as it is. */
typedef struct thrum_pair_row {
  thrum_contact_row row; /* its lever is that of the first side */
  thrum_pair_key key;
  int32_t members[2];
  int32_t known;          /* 1: it goes on from a touch of the last step */
  int32_t bears;          /* 1: it had a force when all rows were last solved */
  const double *basis[2]; /* rows of U of the two points: of a vertex, or in row_basis */
  double starts[2][3];    /* of the two points [m] */
  double lever[3];        /* of the second side [m] */
  double thickness;       /* [m] */
  double position[3];     /* where the force acts [m] */
} thrum_pair_row;

/* One condition of a link, on one place or direction of either side: the displacements along
 * `along` add up to the target less the compliance times the force (docs/links.md). */
typedef struct thrum_link_row {
  int32_t of[2];       /* 0 the place, 1 to 3 a direction */
  double along[2][3];  /* what a unit of force is on either side */
  double compliance;   /* [m/N] of places, [rad/(N m)] of directions; 0 of joints */
  double target;       /* [m], [rad] */
  double force;        /* [N], [N m] */
  double displacement; /* in the step that was made [m], [rad] */
} thrum_link_row;

#define THRUM_LINK_ROWS 6
#define THRUM_LINK_PLACES 4 /* a place and three directions */

/* A link in a step in the making. */
typedef struct thrum_link_run {
  thrum_link *link;
  int32_t row_count;                        /* 0: it has let go */
  thrum_link_row rows[THRUM_LINK_ROWS];     /* the first ones */
  double start[2][THRUM_LINK_PLACES][3];    /* arms about the centre of mass, and directions */
  double end[2][THRUM_LINK_PLACES][3];      /* the same after the step */
  double lever[2][THRUM_LINK_PLACES][3];    /* their means */
  double velocity[2][THRUM_LINK_PLACES][3]; /* at the start [m/s], [1/s] */
  double work[2];                           /* of the forces on either side in the step made [J] */
} thrum_link_run;

/* Rows that are solved for at once (contact_pairs_newton.c). */
#define THRUM_NEWTON_ROWS 2048   /* at most */
#define THRUM_NEWTON_COLUMNS 256 /* coordinates of all bodies, at most */
#define THRUM_NEWTON_LEAST(a, b) ((a) < (b) ? (a) : (b))
#define THRUM_NEWTON_BODY(rank) THRUM_NEWTON_STRIDE((rank) + 6)
#define THRUM_NEWTON_WIDTH(members, rank)                                                          \
  THRUM_NEWTON_LEAST((members)*THRUM_NEWTON_BODY(rank), THRUM_NEWTON_COLUMNS)

/* The coordinates of a body among those of all; none of a solid. */
typedef struct thrum_newton_body {
  int64_t first, count;
  double turn_root[9]; /* of the weights of its rotation */
} thrum_newton_body;

typedef struct thrum_newton_row {
  thrum_contact_row *row; /* of the step, between bodies or on an obstacle */
  thrum_newton_columns columns;
  double *ways;       /* displacement under scaled ones of its bodies: three rows, in the world */
  double at[3];       /* displacement against the other place [m] */
  double drift[3];    /* of an obstacle, which that is less by [m] */
  double way[3];      /* under a step of the iteration [m] */
  double force;       /* along the normal, that the row goes on from [N] */
  double friction[3]; /* the same across it [N] */
  double most;        /* bound of friction [N] */
  double rate[9]; /* by which the force falls with the displacement, as it is in the sum [N/m] */
} thrum_newton_row;

/* Bodies as a whole that are (contact_impact_newton.c): six coordinates each. */
#define THRUM_IMPACT_COLUMNS 192 /* at most */
#define THRUM_IMPACT_WIDTH(members)                                                                \
  THRUM_NEWTON_LEAST(THRUM_NEWTON_STRIDE(6 * (members)), THRUM_IMPACT_COLUMNS)

typedef double thrum_turn[3];

/* A box along the axes of the world that holds points over the step [m]. */
typedef struct thrum_pair_box {
  double least[3], most[3];
} thrum_pair_box;

/* A triangle in the step: its box, and what it has to try and may touch (thrum_skin_triangle). */
typedef struct thrum_pair_triangle {
  thrum_pair_box box;
  const double *places[3]; /* of its corners */
  int32_t tried;           /* its edges that are not flat, of those that are known */
  int32_t flat_known;      /* edges of which it is known */
  int32_t faces;           /* 1: `normal` is known, 0: it has no area, -1: not known yet */
  double normal[3];        /* at the start of the step */
} thrum_pair_triangle;

/* Two places that may be near in this step and the next ones: what a key of theirs would say. */
typedef struct thrum_pair_entry {
  int32_t kind, first, second;
  int32_t alike; /* entries from this one on that have its first place */
} thrum_pair_entry;

#define THRUM_PAIR_LISTS 256  /* that are kept: of so many pairs of members */
#define THRUM_PAIR_ENTRIES 48 /* a touch, of all lists together */

/* The places of two members that were near each other when it was made, within a wider reach than
 * that of a search. As long as no place has moved by more than the difference, a search that looks
 * at these alone finds the same as one that looks at all (contact_pairs_list.c). */
typedef struct thrum_pair_list {
  int32_t numbers[2];               /* of the members */
  int32_t valid;                    /* 0: it is to be made again */
  uint64_t seals[2];                /* of their skins */
  double thickness;                 /* [m] */
  double middles[2][3], axes[2][9]; /* of the members as it was made */
  int64_t from, count, room;        /* of its entries */
} thrum_pair_list;

typedef struct thrum_pair_lists {
  int64_t count, entry_count;
  int64_t searches; /* since all lists were thrown away */
  thrum_pair_list lists[THRUM_PAIR_LISTS];
} thrum_pair_lists;

/* Steps leave this behind: touches, energies since init, and counters. */
typedef struct thrum_pairs_history {
  int64_t touch_count;  /* of the step that was made last, or is being made */
  int64_t before_count; /* of the step before it */
  double stored, lost, flow, budget, driven;
  double owed; /* of touches that take none and have ended: it goes back in the next one [J] */
  double depth, deepest, deepest_share, distance, normal;
  int64_t steps, redone, declined, dropped, sweeps, impacts;
  int64_t struck; /* impacts of the step, at the end of the touches, backwards */
} thrum_pairs_history;

struct thrum_contact_pairs {
  uint64_t magic;
  uint64_t bytes;
  uint64_t kept_bytes;
  int64_t member_max, vertex_max, node_max, rank_max, touch_max, link_max;
  double thickness, friction, restitution, tolerance;
  int64_t sweeps_max;
  thrum_pairs_history history;
  int64_t filled, listed; /* touches and impacts in this block, of groups that stepped beside others
                             in this step */
};

/* X(type, name, count) */
#define THRUM_PAIRS_ARRAYS(X)                                                                      \
  X(thrum_pair_touching, touches, touch_max)   /* of the last step; the last that is kept */       \
  X(thrum_pair_touching, before, touch_max)    /* of the step before, ascending by their keys */   \
  X(thrum_pair_touching, struck, touch_max)    /* impacts, whose forces are impulses [N s] */      \
  X(int32_t, order, touch_max * 2)             /* of what is being sorted */                       \
  X(thrum_pair_sorted, sorting, touch_max * 4) /* room for that */                                 \
  X(int32_t, taken, touch_max)                 /* 1: a row goes on from this touch before */       \
  X(thrum_pair_candidate, candidates, touch_max * 2)                                               \
  X(int32_t, idle, touch_max * 2) /* candidates that have no row yet */                            \
  X(thrum_pair_row, rows, touch_max)                                                               \
  X(double, row_basis, touch_max * 6 * rank_max) /* three rows of U of either side */              \
  X(thrum_newton_row, newton_rows, THRUM_NEWTON_ROWS)                                              \
  X(double, newton_ways, THRUM_NEWTON_ROWS * 6 * THRUM_NEWTON_BODY(rank_max))                      \
  X(double, newton_room,                                                                           \
    (2 * THRUM_NEWTON_WIDTH(member_max, rank_max) + 9) * THRUM_NEWTON_WIDTH(member_max, rank_max)) \
  X(thrum_newton_body, newton_bodies, member_max)                                                  \
  X(double, impact_room, (THRUM_IMPACT_WIDTH(member_max) + 3) * THRUM_IMPACT_WIDTH(member_max))    \
  X(thrum_contact_run, runs, member_max)                                                           \
  X(thrum_contact, contacts, member_max) /* as the step began; of solids, without rows */          \
  X(thrum_contact_environment, environments, member_max) /* of solids */                           \
  X(thrum_contact_whole, wholes, member_max) /* of solids; of bodies as the step began */          \
  X(thrum_turn, turns, member_max)           /* rotation that the levers are made for [rad] */     \
  X(int64_t, first_vertex, member_max + 1)   /* of each member among those below */                \
  X(int64_t, first_node, member_max + 1)                                                           \
  X(double, places, vertex_max * 9) /* of vertices: position, displacement, shift in it [m] */     \
  X(int32_t, place_known, vertex_max)                                                              \
  X(double, solved_ways, vertex_max * 3) /* of vertices: displacement as solved [m] */             \
  X(int32_t, solved_way_known, vertex_max)                                                         \
  X(double, spheres, node_max * 8)   /* of nodes: middle, displacement, radius, its length [m] */  \
  X(thrum_pair_box, boxes, node_max) /* of leaves */                                               \
  X(int32_t, sphere_known, node_max)                                                               \
  X(thrum_pair_triangle, triangles, (node_max + member_max) * 2) /* at most two a node, and two */ \
  X(int32_t, triangle_known, (node_max + member_max) * 2)                                          \
  X(thrum_pair_lists, lists, 1)                                                                    \
  X(double, list_q, rank_max * 2 * THRUM_PAIR_LISTS) /* of either member as a list was made */     \
  X(thrum_pair_entry, entries, touch_max *THRUM_PAIR_ENTRIES)                                      \
  X(thrum_link_run, links, link_max)                                                               \
  X(double, link_basis, link_max * 24 * rank_max) /* rows of U of all places, as the body turns */ \
  X(double, link_response, link_max *link_max * 36) /* of all conditions to all, as its factors */ \
  X(double, link_room, link_max * 6)                                                               \
  X(int32_t, link_pivots, link_max * 6)

typedef struct thrum_pairs_view {
#define X(type, name, count) type *name;
  THRUM_PAIRS_ARRAYS(X)
#undef X
} thrum_pairs_view;

/* A group's step in the making. */
typedef struct thrum_pairs_run {
  const thrum_contact_pairs *pairs; /* whose scratch the view is of */
  thrum_pairs_history *history;     /* that the step is booked in */
  int64_t first_touch;              /* where its touches begin, less those of the history */
  int64_t first_struck;             /* where its impacts begin in the scratch */
  int64_t impacts, struck;          /* of the step, and those of them that are listed */
  thrum_contact_member *members;
  int64_t count;
  thrum_pairs_view view;
  int64_t candidate_count, row_count;
  int64_t idle_count;            /* candidates that wait without a row */
  int64_t link_count, link_rows; /* links, and their conditions that hold */
  bool moved; /* the search goes by displacements that were solved for, not those without contact */
  bool solved;          /* there are such */
  bool closing;         /* touches keep their forces: the links alone are solved for */
  bool own;             /* the search is of a body with itself, in the axes that it turns with */
  bool again;           /* an attempt has failed: forces have to be more exact */
  double excess;        /* share of their depth that springs are too deep (thrum_rows_excess) */
  double taken, driven; /* lost in impacts of this step, and done by solids in them [J] */
  double flow;          /* that went through them: impulses times speeds before [J] */
} thrum_pairs_run;

/* The rows between the bodies of the group, by what they have in common with those on obstacles,
 * which stands first in them. */
static inline thrum_row_list thrum_pairs_rows_of(const thrum_pairs_run *run) {
  const thrum_row_list list = {
      .count = run->row_count, .stride = sizeof(thrum_pair_row), .first = run->view.rows};
  return list;
}

/* A member that steps: a body, whose step has not failed. */
static inline bool thrum_pairs_steps(const thrum_pairs_run *run, int64_t member) {
  return run->members[member].solid == NULL && run->members[member].status >= 0;
}

/* A row with a force. */
static inline bool thrum_pairs_pushes(const thrum_pair_row *row) {
  const double *friction = row->row.touch.friction;
  return row->row.touch.force != 0.0 || friction[0] != 0.0 || friction[1] != 0.0 ||
         friction[2] != 0.0;
}

/* A row between two places of one body. */
static inline bool thrum_pairs_is_own(const thrum_pair_row *row) {
  return row->members[0] == row->members[1];
}

/* Impact n of the last step: they lie behind its touches, which begin at the other end, as far as
 * these leave room. */
static inline thrum_pair_touching *thrum_pairs_impact_at(const thrum_contact_pairs *pairs,
                                                         const thrum_pairs_view *view, int64_t n) {
  return view->touches + (pairs->touch_max - 1 - n);
}

/* The three rows of U of a side of a row; of one body with itself, their difference and their mean.
 */
static inline const double *thrum_pairs_basis(const thrum_pair_row *row, int side) {
  return row->basis[side];
}

/* Pointers into the block. */
thrum_pairs_view thrum_pairs_view_of(const thrum_contact_pairs *pairs);

/* The report of a history. */
thrum_contact_pairs_report thrum_pairs_report_of(const thrum_pairs_history *history);

/* Are both of one def? */
bool thrum_pairs_is_same_def(const thrum_contact_pairs *a, const thrum_contact_pairs *b);

/* Order of two keys: below 0, 0, above 0. */
int thrum_pair_compare(const thrum_pair_key *a, const thrum_pair_key *b);

/* The thickness between two bodies [m]. */
double thrum_pairs_thickness(const thrum_contact_pairs *pairs, const thrum_skin *a,
                             const thrum_skin *b);

/* The place in view.before of the first touch that does not come before a
 * key. */
int64_t thrum_pairs_find_before(const thrum_pairs_run *run, const thrum_pair_key *key);

#endif
