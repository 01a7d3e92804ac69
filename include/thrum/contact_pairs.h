/* Contact between bodies: their surfaces meet, with thickness and friction (docs/contact.md).
 *
 * A skin is the surface of a reduced model: its triangles, their edges, and a tree of spheres that
 * moves with the reduced coordinates (James & Pai 2004, BD-tree, doi:10.1145/1015706.1015735). It
 * is const and shared by all bodies of one model. Vertices meet triangles and edges meet edges
 * where they come nearer than a thickness, now or on their way through the step (conservative
 * advancement, Li et al. 2021, doi:10.1145/3450626.3459767). Each such pair is a row of the same
 * implicit solve as contact with obstacles (thrum/contact.h), with one force on both bodies, so
 * momentum is kept to rounding, and the same account of energy, so contact gives back only what it
 * took.
 *
 *   thrum_contact_pairs_begin(pairs);                                       once a step
 *   thrum_contact_pairs_step(pairs, members, count, &error);                for bodies that are
 * near
 *
 * Memory: skins and pairs are planned, then laid into the caller's memory, aligned to 64 bytes.
 * Neither holds a pointer. A step allocates nothing; what does not fit is counted in the report.
 *
 * Threads: a skin is only read after its init. Pairs, and all that its members point to, belong to
 * one thread at a time; groups that are far from each other may step on several threads
 * (thrum_contact_pairs_step_beside). Units are SI, coordinates are those of the world unless a
 * field says otherwise. No function here prints or keeps a global.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONTACT_PAIRS_H
#define THRUM_CONTACT_PAIRS_H

#include "thrum/api.h"
#include "thrum/contact.h"
#include "thrum/link.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Opaque: the surface of a model. */
typedef struct thrum_skin thrum_skin;

/* Bytes of the skin of a model whose mesh is the surface: vertices and basis (vertex_count x 3 rows
 * of its rank), triangles (triangle_count x 3 0-based vertices, counter-clockwise from outside).
 * THRUM_MISSING for a model without a basis or a material, THRUM_INVALID_ARGUMENT for triangles
 * that name no vertex or none at all. */
THRUM_API thrum_status thrum_skin_size(const thrum_model *model, const int32_t *triangles,
                                       int64_t triangle_count, size_t *size, thrum_error *error);

/* Lays a skin into `memory`, which is the caller's; *skin points into it. It copies what it needs.
 * THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, or the failures of thrum_skin_size. */
THRUM_API thrum_status thrum_skin_init(void *memory, size_t memory_size, const thrum_model *model,
                                       const int32_t *triangles, int64_t triangle_count,
                                       thrum_skin **skin, thrum_error *error);

/* The same for the surface of a solid that does not deform: vertices (vertex_count x 3) [m] and
 * triangles as above; open ones, such as a height field, are touched from their outside alone.
 * THRUM_INVALID_ARGUMENT as thrum_skin_size, THRUM_BAD_VALUE for a vertex beyond 1e30 m. */
THRUM_API thrum_status thrum_skin_solid_size(const double *vertices, int64_t vertex_count,
                                             const int32_t *triangles, int64_t triangle_count,
                                             size_t *size, thrum_error *error);
THRUM_API thrum_status thrum_skin_solid_init(void *memory, size_t memory_size,
                                             const double *vertices, int64_t vertex_count,
                                             const int32_t *triangles, int64_t triangle_count,
                                             thrum_skin **skin, thrum_error *error);

/* Finds how near the places of a skin are to each other at rest, so that the search of a body which
 * touches itself is made where it is deformed alone: without it each step searches the whole
 * surface. It writes to the skin, which no other thread may use meanwhile. NULL does nothing. Cost:
 * some 0.2 million instructions a triangle. */
THRUM_API void thrum_skin_prepare_own(thrum_skin *skin);

/* Vertices and nodes of a skin, which pairs need room for; diagonal of its box at rest [m]. */
THRUM_API int64_t thrum_skin_vertex_count(const thrum_skin *skin);
THRUM_API int64_t thrum_skin_node_count(const thrum_skin *skin);
THRUM_API double thrum_skin_diagonal(const thrum_skin *skin);

/* How bodies meet. Start from thrum_default_contact_pairs_def and set the first three. */
typedef struct thrum_contact_pairs_def {
  /* Set by thrum_default_contact_pairs_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* Largest number of members of a step, 1 to 2^20; no default. Larger: more memory. */
  int64_t member_max;

  /* Largest sums of vertices and of nodes over the skins of a step's members, 1 to 2^31; no
   * default. Larger: more memory. */
  int64_t vertex_max, node_max;

  /* Largest rank of a member, 1 to THRUM_RANK_MAX; no default. Larger: more memory. */
  int64_t rank_max;

  /* Largest number of links of a step; 0 to 1024, default 0. Larger: more memory, with the square.
   */
  int64_t link_max;

  /* The rows of thrum/fields.h, which have their units, ranges and defaults. */
  THRUM_PAIRS_FIELDS(THRUM_MEMBER)
} thrum_contact_pairs_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_contact_pairs_def_init(thrum_contact_pairs_def *def, size_t size);

/* The same as a value. */
static inline thrum_contact_pairs_def thrum_default_contact_pairs_def(void) {
  thrum_contact_pairs_def def;
  thrum_contact_pairs_def_init(&def, sizeof def);
  return def;
}

/* Opaque: lives at the start of the memory given to thrum_contact_pairs_init. */
typedef struct thrum_contact_pairs thrum_contact_pairs;

/* Where a solid is at the start and at the end of a step, and how it is touched. It moves from one
 * to the other along a straight way and about one axis, by less than half a turn. */
typedef struct thrum_contact_solid {
  thrum_placement now, next; /* axes are rotations */
  double friction;           /* as in the def of the pairs, in its place [1] */
  double restitution;        /* the same [1] */
} thrum_contact_solid;

/* A body in a step. The caller owns all that it points to; skin, model and environment as in
 * thrum_contact_step, where the skin is of a model with the same coordinates. Or a solid, which no
 * force moves: it has `solid`, a skin of thrum_skin_solid_init, and a number; model, state, contact
 * and environment are NULL. */
typedef struct thrum_contact_member {
  const thrum_model *model;
  thrum_state *state;
  thrum_contact *contact;
  const thrum_contact_environment *environment;
  const thrum_skin *skin;
  const thrum_contact_solid *solid; /* NULL: a body */
  int32_t number;         /* of the body, the same in all steps; ascending over the members */
  int32_t touches_itself; /* 1: its surface touches itself too; of a solid without effect */
  int32_t passes_bodies;  /* 1: it touches solids, and itself, but no other body of the group */
  thrum_status status;    /* of its step, set by thrum_contact_pairs_step */
} thrum_contact_member;

/* Counters and energies since init or reset. What contact between the bodies did on them is
 *
 *   work on the bodies = driven - stored - lost,    stored >= 0, lost >= 0 up to rounding. */
typedef struct thrum_contact_pairs_report {
  int64_t steps;        /* calls of thrum_contact_pairs_begin */
  int64_t redone;       /* attempts after the first of a group */
  int64_t declined;     /* groups that stepped without contact, because no attempt kept the bound */
  int64_t dropped;      /* touches for which touch_max was too small */
  int64_t sweeps;       /* of the solver */
  int64_t impacts;      /* places at which bodies struck each other as a whole */
  int64_t touching;     /* touches in the last step */
  int64_t struck;       /* impacts in the last step that are listed behind its touches */
  double distance;      /* least distance between surfaces that touch, after the last step [m] */
  double depth;         /* largest depth below the thickness after the last step [m] */
  double deepest;       /* and after any step [m] */
  double deepest_share; /* the largest share of its thickness that any touch was deep after any
                           step, also one that was declined: below 1 no surface has met another; of
                           a thickness near 0 the largest number that there is [1] */
  double normal;        /* sum of the normal forces in the last step [N] */
  double stored;        /* energy in the contact springs now [J] */
  double lost;          /* energy lost to restitution and friction [J] */
  double driven;        /* work of solids that move, on the bodies [J] */
} thrum_contact_pairs_report;

/* One touch of the last step, or one place of an impact in it. */
typedef struct thrum_pair_touch {
  int32_t bodies[2];  /* numbers of the members; the same twice: a body that touches itself */
  double position[3]; /* where the force acts [m] */
  double force[3];   /* on the first body, or on its first place; the second has its negative [N] */
  double normal[3];  /* unit vector from the second body to the first */
  double distance;   /* between the surfaces after the step, or at the impact [m] */
  double impulse[3]; /* of an impact, on the first body; its force is 0 [N s] */
} thrum_pair_touch;

/* Bytes of pairs, into *size. THRUM_UNINITIALISED_DEF, or THRUM_INVALID_ARGUMENT with the field. */
THRUM_API thrum_status thrum_contact_pairs_size(const thrum_contact_pairs_def *def, size_t *size,
                                                thrum_error *error);

/* Lays pairs that touch nothing into `memory`, which is the caller's. THRUM_MISALIGNED,
 * THRUM_BUFFER_TOO_SMALL, or the failures of thrum_contact_pairs_size. */
THRUM_API thrum_status thrum_contact_pairs_init(void *memory, size_t memory_size,
                                                const thrum_contact_pairs_def *def,
                                                thrum_contact_pairs **pairs, thrum_error *error);

/* Opens a step: the touches of the last one are what new ones go on from. */
THRUM_API void thrum_contact_pairs_begin(thrum_contact_pairs *pairs);

/* Makes the step of `count` bodies that may touch each other, with their obstacles and pulls. A
 * member whose step fails keeps its state and what belongs to it, has the failure as its status,
 * and the others step without it. Returns the first failure, else the least status above 0, else
 * THRUM_OK. THRUM_INVALID_ARGUMENT, with nothing done, for members beyond the def or out of order.
 * Allocates nothing. */
THRUM_API thrum_status thrum_contact_pairs_step(thrum_contact_pairs *pairs,
                                                thrum_contact_member *members, int64_t count,
                                                thrum_error *error);

/* Tells what the step of a group did, of groups that step beside each other. */
typedef struct thrum_contact_group {
  const thrum_contact_pairs *room;   /* that holds its touches; NULL: it did not step */
  int64_t first_touch, first_struck; /* of those in the room */
  thrum_contact_pairs_report report; /* of this group in this step alone */
  double budget, flow;               /* by which those of the bound on energy change [J] */
  double owed;                       /* what it will give back [J] */
} thrum_contact_group;

/* Links between members of a step. */
typedef struct thrum_contact_links {
  thrum_link *links;
  int64_t count;
} thrum_contact_links;

/* Makes the step of one of `group_count` groups of bodies, no two of which are near each other, as
 * thrum_contact_pairs_step does; steps of several groups may be made at once, on threads of the
 * caller's. `pairs` is only read. `room` is pairs of the same def, or `pairs` itself, whose scratch
 * this step has for itself and which thrum_contact_pairs_begin opened in this step; a room takes
 * its groups one after the other, in the order that gather has them in. Fills *group. Bodies end
 * with the same bits whatever the rooms are.
 *
 * links (NULL: none) are between members, solved for with the touches; their reports are updated.
 * With links, members without a skin (NULL) touch nothing, and bodies that are linked meet others
 * by springs alone (docs/contact.md); two that a joint ties do not touch. A link of a member that
 * fails lets go for the step. THRUM_INVALID_ARGUMENT for NULL, no groups, or a room of another def,
 * and for links beyond the def or of members that are none; *group is then of none. */
THRUM_API thrum_status thrum_contact_pairs_step_beside(
    const thrum_contact_pairs *pairs, thrum_contact_pairs *room, int64_t group_count,
    thrum_contact_member *members, int64_t count, const thrum_contact_links *links,
    thrum_contact_group *group, thrum_error *error);

/* Closes a step whose groups stepped beside each other: books what they did, in the order given,
 * and takes their touches out of their rooms. NULL does nothing. */
THRUM_API void thrum_contact_pairs_gather(thrum_contact_pairs *pairs,
                                          const thrum_contact_group *groups, int64_t count);

/* What holds a body's surface: a sphere, middle [m] and radius [m], and about its middle the box
 * with these half sides at rest [m], along the columns of `axes`, that it is deformed out of by at
 * most `deformed` [m]; and how far any of it may move in the step to come [m].
 * thrum_contact_pairs_near needs it. */
typedef struct thrum_skin_bound {
  double middle[3], radius, motion;
  double axes[9], half[3], deformed;
} thrum_skin_bound;

/* The bound of a member; it evaluates no vertex. */
THRUM_API thrum_skin_bound thrum_contact_member_bound(const thrum_contact_member *member);

/* May the two bodies touch in the step to come? */
THRUM_API int32_t thrum_contact_pairs_near(const thrum_skin_bound *a, const thrum_skin_bound *b);

/* Lets pairs that have made no step yet continue from the touches, counters and energies of `from`.
 * They may have less room than `from`: touches beyond touch_max are left out and counted as
 * dropped. NULL for either does nothing. */
THRUM_API void thrum_contact_pairs_continue(thrum_contact_pairs *pairs,
                                            const thrum_contact_pairs *from);

/* Forgets touches and energies, as after init. NULL does nothing. */
THRUM_API void thrum_contact_pairs_reset(thrum_contact_pairs *pairs);

/* The report; all zero for NULL. */
THRUM_API thrum_contact_pairs_report
thrum_contact_pairs_report_get(const thrum_contact_pairs *pairs);

/* Touch `index` (0-based, below the report's touching) of the last step, behind them the impacts
 * (as many as the report's struck); THRUM_INVALID_ARGUMENT beyond the last. Impacts are listed
 * where touches leave room below touch_max. */
THRUM_API thrum_status thrum_contact_pairs_touch_get(const thrum_contact_pairs *pairs,
                                                     int64_t index, thrum_pair_touch *touch,
                                                     thrum_error *error);

/* Distance of a point from a closed surface [m], negative inside: `count` x 3 0-based vertices of
 * the triangles, counter-clockwise from outside. Inside is where the triangles wind about the point
 * (Jacobson et al. 2013, doi:10.1145/2461912.2461916). Cost: some 150 operations a triangle. Any
 * thread. */
THRUM_API double thrum_triangles_distance(const double *vertices, const int32_t *triangles,
                                          int64_t count, const double point[3]);

/* Bytes at the start of pairs that steps change and that have to be copied to keep a step; the rest
 * is scratch. */
THRUM_API size_t thrum_contact_pairs_kept_bytes(const thrum_contact_pairs *pairs);

/* Would the thrum_contact_pairs_kept_bytes bytes at `copy` be these pairs when copied over them?
 * THRUM_MODEL_MISMATCH for another def, THRUM_BAD_VALUE for numbers that no pairs can have. */
THRUM_API thrum_status thrum_contact_pairs_copy_check(const thrum_contact_pairs *pairs,
                                                      const void *copy, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
