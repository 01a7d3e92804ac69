/* The loops of block_rows.c over numbers of the kind REAL. SPDX-License-Identifier: Apache-2.0 */

// sums of one block row, a line of them for each of its three rows
INLINE void NAME(sum)(const block_rows *m, const REAL *value, int64_t i, const REAL *x,
                      REAL sums[3][BLOCK_COLUMNS]) {
  REAL first[BLOCK_COLUMNS] = {0}, second[BLOCK_COLUMNS] = {0}, third[BLOCK_COLUMNS] = {0};
  const REAL *ghost = m->ghost;
  for (int64_t b = m->begin[i]; b < m->begin[i + 1]; b++) {
    const int64_t column = m->column[b];
    const REAL *v = value + 9 * b;
    const REAL *from = column < m->columns ? x + BLOCK_NUMBERS * column
                                           : ghost + BLOCK_NUMBERS * (column - m->columns);
    for (int k = 0; k < 3; k++)
      for (int c = 0; c < BLOCK_COLUMNS; c++) {
        const REAL number = from[k * BLOCK_COLUMNS + c];
        first[c] += v[k] * number;
        second[c] += v[3 + k] * number;
        third[c] += v[6 + k] * number;
      }
  }
  for (int c = 0; c < BLOCK_COLUMNS; c++) {
    sums[0][c] = first[c];
    sums[1][c] = second[c];
    sums[2][c] = third[c];
  }
}

INLINE void NAME(product)(const block_rows *m, const REAL *value, const REAL *x, REAL *restrict y) {
  for (int64_t i = 0; i < m->rows; i++) {
    REAL sums[3][BLOCK_COLUMNS];
    NAME(sum)(m, value, i, x, sums);
    for (int k = 0; k < 3; k++)
      for (int c = 0; c < BLOCK_COLUMNS; c++)
        y[i * BLOCK_NUMBERS + k * BLOCK_COLUMNS + c] = sums[k][c];
  }
}

INLINE void NAME(step)(const block_rows *m, const REAL *value, const REAL *d, REAL along,
                       REAL across, REAL *restrict x, REAL *restrict r, REAL *restrict next) {
  for (int64_t i = 0; i < m->rows; i++) {
    REAL sums[3][BLOCK_COLUMNS];
    NAME(sum)(m, value, i, d, sums);

    // the residual and the solution follow, then the next direction
    for (int k = 0; k < 3; k++) {
      const int64_t at = i * BLOCK_NUMBERS + k * BLOCK_COLUMNS;
      for (int c = 0; c < BLOCK_COLUMNS; c++) {
        r[at + c] -= sums[k][c];
        x[at + c] += d[at + c];
      }
      if (next != NULL)
        for (int c = 0; c < BLOCK_COLUMNS; c++)
          next[at + c] = along * d[at + c] + across * r[at + c];
    }
  }
}
