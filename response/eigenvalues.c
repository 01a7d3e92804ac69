/* Eigenvalues of a real matrix: reduction to Hessenberg form by reflections, then QR steps with two
 * shifts at once, which stay real for a conjugate pair.
 *
 * A step of QR makes a bulge of 3 x 3 at the top of the active block and chases it down. Blocks of
 * one and two that fall off at the bottom are the eigenvalues. Cost: about 10 n^3 operations.
 * Source: Golub and Van Loan 2013, Matrix computations, sections 7.4 and 7.5.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/eigenvalues.h"

#include <float.h>
#include <math.h>

#define STEPS_MAX 60   /* QR steps for one eigenvalue; most take two or three */
#define SWEEPS_MAX 20  /* of scaling */
#define STEPS_STUCK 10 /* after so many in vain other shifts are tried */

/* A reflection 1 - beta v v^T of three coordinates that takes x to a multiple of the first of them.
 */
typedef struct reflection {
  double v[3], beta;
} reflection;

static reflection reflection_of(double x, double y, double z) {
  const double scale = fabs(x) + fabs(y) + fabs(z);
  reflection made = {{1, 0, 0}, 0};
  if (!(scale > 0))
    return made;
  x /= scale;
  y /= scale;
  z /= scale;
  const double length = copysign(sqrt(x * x + y * y + z * z), x);
  const double head = x + length;
  made = (reflection){{1, y / head, z / head}, head / length};
  return made;
}

/* Reflects two rows of h, in the columns from .. to. */
static void reflect_two(double *restrict a, double *restrict b, const reflection *by, int64_t from,
                        int64_t to) {
  const double v = by->v[1], beta = by->beta;
  for (int64_t j = from; j <= to; j++) {
    const double sum = (a[j] + v * b[j]) * beta;
    a[j] -= sum;
    b[j] -= sum * v;
  }
}

static void reflect_three(double *restrict a, double *restrict b, double *restrict c,
                          const reflection *by, int64_t from, int64_t to) {
  const double v = by->v[1], w = by->v[2], beta = by->beta;
  for (int64_t j = from; j <= to; j++) {
    const double sum = (a[j] + v * b[j] + w * c[j]) * beta;
    a[j] -= sum;
    b[j] -= sum * v;
    c[j] -= sum * w;
  }
}

/* Reflects rows or columns `at` .. at + size - 1 of h, in the columns or rows from .. to. */
static void reflect_rows(double *h, int64_t n, const reflection *by, int64_t at, int64_t size,
                         int64_t from, int64_t to) {
  double *a = h + at * n;
  if (size == 2)
    reflect_two(a, a + n, by, from, to);
  else
    reflect_three(a, a + n, a + 2 * n, by, from, to);
}

static void reflect_columns(double *h, int64_t n, const reflection *by, int64_t at, int64_t size,
                            int64_t from, int64_t to) {
  const double v = by->v[1], w = by->v[2], beta = by->beta;
  for (int64_t i = from; i <= to; i++) {
    double *row = h + i * n + at;
    const double sum = (row[0] + v * row[1] + (size == 3 ? w * row[2] : 0)) * beta;
    row[0] -= sum;
    row[1] -= sum * v;
    if (size == 3)
      row[2] -= sum * w;
  }
}

/* Scales rows and columns by powers of two until those of each coordinate are of one size, which
 * changes no eigenvalue and no digit (Parlett and Reinsch 1969, doi:10.1007/BF02165404). */
static void balance(double *a, int64_t n) {
  for (int sweep = 0, changed = 1; changed && sweep < SWEEPS_MAX; sweep++) {
    changed = 0;
    for (int64_t i = 0; i < n; i++) {
      double row = 0, column = 0;
      for (int64_t j = 0; j < n; j++)
        if (j != i) {
          row += fabs(a[i * n + j]);
          column += fabs(a[j * n + i]);
        }
      if (!(row > 0 && column > 0 && isfinite(row + column)))
        continue;

      // worth it where the sum of both falls by a twentieth
      int exponent = 0;
      frexp(sqrt(row / column), &exponent);
      const double by = ldexp(1, exponent);
      if (column * by + row / by > 0.95 * (column + row))
        continue;
      changed = 1;
      for (int64_t j = 0; j < n; j++) {
        a[i * n + j] /= by;
        a[j * n + i] *= by;
      }
    }
  }
}

/* Hessenberg form, a column at a time; the reflection lies in the column that it clears. */
static void make_hessenberg(double *a, int64_t n) {
  for (int64_t k = 0; k + 2 < n; k++) {
    double length = 0;
    for (int64_t i = k + 1; i < n; i++)
      length = thrum_magnitude(length, a[i * n + k]);
    if (!(length > 0))
      continue;

    // v has 1 in its first place
    length = copysign(length, a[(k + 1) * n + k]);
    const double head = a[(k + 1) * n + k] + length, beta = head / length;
    for (int64_t i = k + 2; i < n; i++)
      a[i * n + k] /= head;

    // from the left and from the right
    for (int64_t j = k + 1; j < n; j++) {
      double sum = a[(k + 1) * n + j];
      for (int64_t i = k + 2; i < n; i++)
        sum += a[i * n + k] * a[i * n + j];
      sum *= beta;
      a[(k + 1) * n + j] -= sum;
      for (int64_t i = k + 2; i < n; i++)
        a[i * n + j] -= sum * a[i * n + k];
    }
    for (int64_t i = 0; i < n; i++) {
      double *row = a + i * n, sum = row[k + 1];
      for (int64_t j = k + 2; j < n; j++)
        sum += row[j] * a[j * n + k];
      sum *= beta;
      row[k + 1] -= sum;
      for (int64_t j = k + 2; j < n; j++)
        row[j] -= sum * a[j * n + k];
    }
    a[(k + 1) * n + k] = -length;
    for (int64_t i = k + 2; i < n; i++)
      a[i * n + k] = 0;
  }
}

/* The first row of the block that ends at `last`: what couples it to the rows above is rounding. */
static int64_t block_begin(double *h, int64_t n, int64_t last, double norm) {
  int64_t first = last;
  for (; first > 0; first--) {
    double beside = fabs(h[(first - 1) * n + first - 1]) + fabs(h[first * n + first]);
    if (beside == 0)
      beside = norm;
    if (fabs(h[first * n + first - 1]) <= DBL_EPSILON * beside) {
      h[first * n + first - 1] = 0;
      break;
    }
  }
  return first;
}

/* The two eigenvalues of (a b; c d). */
static void solve_pair(double a, double b, double c, double d, double *values) {
  const double half = 0.5 * (a - d), square = half * half + b * c, root = sqrt(fabs(square));
  values[0] = values[2] = d + half;
  values[1] = values[3] = 0;
  if (square < 0) {
    values[1] = root;
    values[3] = -root;
  } else {
    // the larger one without cancellation, the other by the product
    const double z = half + copysign(root, half);
    values[0] = d + z;
    values[2] = z != 0 ? d - b * c / z : d;
  }
}

/* One step of QR on rows first .. last with the shifts of trace and determinant. */
static void step(double *h, int64_t n, int64_t first, int64_t last, double trace,
                 double determinant) {
  // first column of H^2 - trace H + determinant
  const double *r0 = h + first * n + first, *r1 = r0 + n, *r2 = r1 + n;
  double x = r0[0] * (r0[0] - trace) + determinant + r0[1] * r1[0];
  double y = r1[0] * (r0[0] + r1[1] - trace), z = r1[0] * r2[1];
  for (int64_t k = first; k < last; k++) {
    const int64_t size = k + 2 <= last ? 3 : 2;
    const reflection by = reflection_of(x, y, size == 3 ? z : 0);
    reflect_rows(h, n, &by, k, size, k > first ? k - 1 : first, last);
    reflect_columns(h, n, &by, k, size, first, k + 3 < last ? k + 3 : last);

    // what the reflection cleared, and the column of the next
    for (int64_t i = 1; k > first && i < size; i++)
      h[(k + i) * n + k - 1] = 0;
    x = h[(k + 1) * n + k];
    y = k + 2 <= last ? h[(k + 2) * n + k] : 0;
    z = k + 3 <= last ? h[(k + 3) * n + k] : 0;
  }
}

static bool iterate(double *h, int64_t n, double *values) {
  double norm = 0;
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = i > 0 ? i - 1 : 0; j < n; j++)
      norm += fabs(h[i * n + j]);
  if (!isfinite(norm))
    return false;

  for (int64_t last = n - 1, steps = 0; last >= 0; steps++) {
    const int64_t first = block_begin(h, n, last, norm);
    const double *low = h + last * n + last;
    if (first == last) {
      values[2 * last] = low[0];
      values[2 * last + 1] = 0;
      last--;
      steps = -1;
    } else if (first == last - 1) {
      solve_pair(low[-n - 1], low[-n], low[-1], low[0], values + 2 * (last - 1));
      last -= 2;
      steps = -1;
    } else if (steps >= STEPS_MAX) {
      return false;
    } else if (steps % STEPS_STUCK == STEPS_STUCK - 1) {
      const double s = fabs(low[-1]) + fabs(low[-n - 2]);
      step(h, n, first, last, 1.5 * s, s * s);
    } else {
      step(h, n, first, last, low[-n - 1] + low[0], low[-n - 1] * low[0] - low[-n] * low[-1]);
    }
  }
  return true;
}

static void sort(double *values, int64_t n) {
  // pairs have one magnitude and stay side by side, for the sort is stable
  for (int64_t i = 1; i < n; i++) {
    const double real = values[2 * i], imaginary = values[2 * i + 1];
    const double size = thrum_magnitude(real, imaginary);
    int64_t at = i;
    for (; at > 0 && thrum_magnitude(values[2 * at - 2], values[2 * at - 1]) < size; at--) {
      values[2 * at] = values[2 * at - 2];
      values[2 * at + 1] = values[2 * at - 1];
    }
    values[2 * at] = real;
    values[2 * at + 1] = imaginary;
  }
}

bool thrum_eigenvalues(double *matrix, int64_t n, double *values) {
  balance(matrix, n);
  make_hessenberg(matrix, n);
  if (!iterate(matrix, n, values))
    return false;
  sort(values, n);
  return true;
}
