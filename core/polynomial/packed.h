/* The coefficients of a model laid out for the passes of a kernel (thrum_model_pack). Private to
 * libthrum.
 *
 * In V each monomial of degree 3 and 4 is q_d q_c m, n > d >= c >= b >= a >= -1, with m = q_b q_a
 * and q_{-1} = 1: so cubic terms are quartic ones with a = -1. Columns are the pairs (b, a), b
 * outermost: run b has b + 2 columns and begins at thrum_pack_first(b). Block c has the rows d =
 * n-1 .. c, whose columns are all those of the runs 0..c: a prefix, so that every row begins at
 * column 0. The highest coordinates come first among the rows: with the first s held, what a
 * restriction to the others needs of block c are its first rows.
 *
 * Rows are taken in groups of 8, the last of a block may be smaller. In a group vector v (8
 * columns, zeros behind the last) of row r of `size` is at 8 (v size + r): one stream of whole
 * cache lines.
 *
 * Behind them the same terms lie once more, "mirrored": in coordinates z_k = q_{n-1-k}, with the
 * rows of block c ascending, d = c .. n-1. There the implicit modes come first whatever the split,
 * so that what a step does with them, and all that is left of a term with s of its coordinates
 * explicit, is a run of blocks, rows and columns too.
 *
 * Small models have their terms a third time, by pairs. With P = (d, c) and Q = (b, a) the pairs of
 * columns, in their order,
 *   V = 1/6 sum B_P,Q m_P m_Q,  B_P,Q = s_P s_Q V_dcba,
 * V_dcba the fourth derivative, s_P = 1, or 1/2 where d = c. So the Hessian is T_dc = (B m)_dc /
 * s_dc, and the gradient 1/3 of that of sum m_P y_P with y = B m held: V is of degree 4 in q_{-1} =
 * 1 and the others (Euler). T v is the whole of that gradient at v, with v_{-1} = 0. B is
 * symmetric; of its rows, in groups of 8 as above, those columns are kept that begin with the
 * group's own. From n = 5 on it has 2 to 2.7 times the numbers of one order; but a tangent is one
 * product with it, where the others need a sum over columns for each coordinate.
 *
 * V with the explicit modes held is, in n implicit ones,
 *   sum_c l_c z_c + sum_c z_c (sum_d z_d y_dc + sum_ba r_c,ba m_ba),
 * y from the mirrored coefficients: each block has one more row r_c, a state's own, with its
 * quadratic terms (a = -1) and what the explicit modes add to its cubic ones
 * (thrum_restricted_first).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_POLYNOMIAL_PACKED_H
#define THRUM_CORE_POLYNOMIAL_PACKED_H

#include <stdbool.h>
#include <stdint.h>

#include "core/polynomial/kernel_private.h"
#include "core/polynomial/points.h"
#include "thrum/model.h"

#define THRUM_PACK_ROWS 8

/* Packed coefficients of more bytes than this are single ones where they can be: below, widening
 * them costs more than reading fewer bytes saves. */
#define THRUM_PACK_SINGLE_BYTES (1 << 20)

/* Are the coefficients that the model has now packed? */
static inline bool thrum_is_packed(const thrum_model *model) {
  return model->c3 && (model->packed || model->packed_single) && model->packed_c3 == model->c3 &&
         model->packed_c4 == model->c4;
}

/* Column (b, -1): where run b begins. */
static inline int64_t thrum_pack_first(int64_t b) {
  return b * (b + 3) / 2;
}

/* Columns of block c, and vectors of 8 that hold them. */
static inline int64_t thrum_pack_columns(int64_t c) {
  return thrum_pack_first(c + 1);
}

static inline int64_t thrum_pack_vectors(int64_t c) {
  return (thrum_pack_columns(c) + 7) / 8;
}

/* Rows of the group that begins at row `first` of a block of so many rows. */
static inline int64_t thrum_pack_size(int64_t rows, int64_t first) {
  return rows - first < THRUM_PACK_ROWS ? rows - first : THRUM_PACK_ROWS;
}

/* Numbers in all blocks. */
static inline int64_t thrum_pack_count(int64_t n) {
  int64_t count = 0;
  for (int64_t c = 0; c < n; c++)
    count += 8 * (n - c) * thrum_pack_vectors(c);
  return count;
}

/* Models up to this rank have their terms by pairs too: measured, steps are faster so. Beyond it B
 * and one order, which is what they read, no longer fit well into 1 MiB. None so small is packed in
 * single precision. */
#define THRUM_PAIRS_RANK_MOST 26

/* Up to this rank T v comes by them as well; it reads one order once otherwise, so that less is to
 * be gained than for T. Measured. */
#define THRUM_PAIRS_VECTOR_RANK_MOST 18
_Static_assert(THRUM_PAIRS_VECTOR_RANK_MOST <= THRUM_PAIRS_RANK_MOST, "they must be there");

/* Rows of B, with those of zeros that fill up the last vector. */
static inline int64_t thrum_pairs_rows(int64_t n) {
  return thrum_whole(thrum_pack_first(n));
}

/* Numbers of it that are kept; none of a large model. */
static inline int64_t thrum_pairs_count(int64_t n) {
  const int64_t groups = thrum_pairs_rows(n) / 8;
  return n <= THRUM_PAIRS_RANK_MOST ? 32 * groups * (groups + 1) : 0;
}

/* First number of the pairs, and number of all packed numbers. */
static inline int64_t thrum_pairs_at(int64_t n) {
  return 2 * thrum_pack_count(n);
}

static inline int64_t thrum_pack_all(int64_t n) {
  return thrum_pairs_at(n) + thrum_pairs_count(n);
}

/* First number of the rows r_c of a restricted polynomial, in whole vectors, one after the other; l
 * is at 0.
 */
static inline int64_t thrum_restricted_first(int64_t n) {
  return thrum_whole(n);
}

/* Numbers in one. */
static inline int64_t thrum_restricted_count(int64_t n) {
  int64_t count = thrum_restricted_first(n);
  for (int64_t c = 0; c < n; c++)
    count += 8 * thrum_pack_vectors(c);
  return count;
}

/* Doubles of V restricted to n coordinates: of a polynomial those of packed.h; of points their
 * gradients from the held coordinates, block by block, component by component, and the nonlinear
 * part of V there. */
static inline int64_t thrum_restriction_count(const thrum_model *model, int64_t n) {
  if (thrum_has_points(model))
    return THRUM_POINT_BLOCK * thrum_point_blocks(model) + 1;
  return thrum_restricted_count(n);
}

/* The same with the held coordinates behind them, which what acts on a state is evaluated with. */
static inline int64_t thrum_restriction_room(const thrum_model *model, int64_t n) {
  return thrum_restriction_count(model, n) + (model->actuator_kind ? model->rank : 0);
}

/* Scratch of a pass, in doubles; the pass may also be at two points. The tangent has a list for
 * each coordinate besides. */
#define THRUM_PACK_VECTORS 9
#define THRUM_PACK_COLUMNS 2

static inline int64_t thrum_pack_work(int64_t n) {
  const int64_t vector = thrum_padded(n + 1), columns = thrum_padded(thrum_pack_first(n));
  // one more list of columns for the rows of the reference
  return 8 * vector + 2 * ((THRUM_PACK_VECTORS + 8) * vector + THRUM_PACK_COLUMNS * columns) +
         columns;
}

static inline int64_t thrum_pack_work_tangent(int64_t n) {
  int64_t lists = 0;
  for (int64_t d = 0; d < n; d++)
    lists += 8 * thrum_pack_vectors(d);
  return thrum_pack_work(n) + lists;
}

/* The columns of row d of block c, thrum_pack_columns(c) of them, out of the packed coefficients
 * or, where there are none, of c3 and c4. `at` is where the block begins in its order. */
void thrum_pack_row(const thrum_model *model, int64_t c, int64_t d, int64_t at, double *row);

/* The same of the mirrored ones. */
void thrum_pack_row_mirrored(const thrum_model *model, int64_t c, int64_t d, int64_t at,
                             double *row);

/* Block b of the gradients of cubature points, as it is packed (core/polynomial/points.h), from
 * the file's order. */
void thrum_points_gather(const thrum_model *model, int64_t b, double *to);

/* Row k of B, thrum_pairs_rows(rank) columns, of which those before its group are zero, out of the
 * packed coefficients or of c3 and c4. */
void thrum_pairs_row(const thrum_model *model, int64_t k, double *row);

#endif
