/* The passes of a step of many bodies (accelerator/README.md says in which order). An entry i of a
 * body c of a part lies at i * PART + c, and of a body n of all at i * count + n: neighbours in a
 * work-group read neighbours in memory.
 *
 *   T(q) = omega^2 + [A3' q + A4' m],  m = (q_k q_l, k <= l),  columns (a, b), a <= b
 *   R(q) = omega^2 q + (A3' q) q / 2 + (A4' m) q / 3,   V likewise with 1/6 and 1/12
 *
 * RANK r, PAIRS r (r + 1) / 2, PART bodies of a part; ROWS3, ROWS4 and COLUMNS are r, PAIRS and
 * PAIRS rounded up to a tile.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#pragma OPENCL FP_CONTRACT OFF
#ifdef WITH_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
#else
typedef float real;
#endif

#define TILE 64 /* entries of a tile of `multiply`, by columns and by bodies */
#define DEEP 16 /* rows that a tile takes at a time */
#define SIDE 16 /* work-items along each side: each has 4 x 4 entries */

// where the forces are taken: q + share d
real place(global const real *q, global const real *d, real share, int i, int c, long at,
           long count) {
  return q[i * count + at + c] + share * d[i * PART + c];
}

/* The rows that the coefficients are multiplied with: q, then the products of its pairs. */
kernel void products(global const real *q, global const real *d, real share,
                     global const ushort2 *pairs, global float *x, long at, long count) {
  const int c = get_global_id(0), row = get_global_id(1);
  float value = 0;
  if (at + c < count) {
    if (row < RANK)
      value = (float)place(q, d, share, row, c, at, count);
    else if (row >= ROWS3 && row < ROWS3 + PAIRS) {
      const ushort2 pair = pairs[row - ROWS3];
      value = (float)(place(q, d, share, pair.x, c, at, count) *
                      place(q, d, share, pair.y, c, at, count));
    }
  }
  x[row * PART + c] = value;
}

/* y = A' x, each entry a sum over the rows in ascending order. */
kernel __attribute__((reqd_work_group_size(SIDE, SIDE, 1))) void
multiply(global const float *a, global const float *x, int first, int rows, global float *y) {
  local float as[DEEP][TILE], xs[DEEP][TILE];
  const int left = get_local_id(0), top = get_local_id(1), item = top * SIDE + left;
  const int body = get_group_id(0) * TILE, column = get_group_id(1) * TILE;
  float sum[4][4] = {{0}};
  for (int row = first; row < first + rows; row += DEEP) {
    for (int k = item; k < DEEP * TILE; k += SIDE * SIDE) {
      as[k / TILE][k % TILE] = a[(row + k / TILE) * COLUMNS + column + k % TILE];
      xs[k / TILE][k % TILE] = x[(row + k / TILE) * PART + body + k % TILE];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int k = 0; k < DEEP; k++)
      for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
          sum[i][j] += as[k][top + SIDE * i] * xs[k][left + SIDE * j];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      y[(column + top + SIDE * i) * PART + body + left + SIDE * j] = sum[i][j];
}

// the column of the pair (i, j) of a symmetric matrix
int column_of(int i, int j) {
  const int a = min(i, j), b = max(i, j);
  return a * RANK - a * (a - 1) / 2 + b - a;
}

/* R at q + share d into f, and, where `along` is not NULL, the part of T d that is not linear. */
kernel void force(global const real *q, global const real *d, real share, global const real *omega2,
                  global const float *y3, global const float *y4, global real *f,
                  global real *along, long at, long count) {
  const int c = get_global_id(0), i = get_global_id(1);
  if (at + c >= count)
    return;
  real sum = 0, product = 0;
  for (int j = 0; j < RANK; j++) {
    const int entry = column_of(i, j) * PART + c;
    const real cubic = y3[entry], quartic = y4[entry];
    sum += (cubic / 2 + quartic / 3) * place(q, d, share, j, c, at, count);
    product += (cubic + quartic) * d[j * PART + c];
  }
  f[i * PART + c] = omega2[i] * place(q, d, share, i, c, at, count) + sum;
  along[i * PART + c] = product;
}

/* The first increment of a step: where the body goes without forces. */
kernel void begin(global const real *p, global const real *length, global real *d, long at,
                  long count) {
  const int c = get_global_id(0), i = get_global_id(1);
  d[i * PART + c] = at + c < count ? length[i] * p[i * count + at + c] : 0;
}

// a symmetric matrix by L D L', in place: entry (a, b), b <= a, at a (a + 1) / 2 + b
void factor(global float *j, int c) {
  for (int a = 0; a < RANK; a++) {
    for (int b = 0; b < a; b++) {
      float sum = j[(a * (a + 1) / 2 + b) * PART + c];
      for (int k = 0; k < b; k++)
        sum -= j[(a * (a + 1) / 2 + k) * PART + c] * j[(b * (b + 1) / 2 + k) * PART + c];
      j[(a * (a + 1) / 2 + b) * PART + c] = sum;
    }
    float pivot = j[(a * (a + 1) / 2 + a) * PART + c];
    for (int b = 0; b < a; b++) {
      const float entry = j[(a * (a + 1) / 2 + b) * PART + c];
      const float low = entry / j[(b * (b + 1) / 2 + b) * PART + c];
      pivot -= entry * low;
      j[(a * (a + 1) / 2 + b) * PART + c] = low;
    }
    j[(a * (a + 1) / 2 + a) * PART + c] = pivot;
  }
}

void solve(global const float *j, float *x, int c) {
  for (int a = 0; a < RANK; a++)
    for (int b = 0; b < a; b++)
      x[a] -= j[(a * (a + 1) / 2 + b) * PART + c] * x[b];
  for (int a = 0; a < RANK; a++)
    x[a] /= j[(a * (a + 1) / 2 + a) * PART + c];
  for (int a = RANK - 1; a >= 0; a--)
    for (int b = 0; b < a; b++)
      x[b] -= j[(a * (a + 1) / 2 + b) * PART + c] * x[a];
}

/* One Newton iteration for the increment d of a body, with G over half the square of the time step:
 *
 *   G = (2/l^2) (d - l p) + M + D d - F,   J = 2/l^2 + D + T/2 [+ sigma + d s'],   d := d - J^-1 G
 *
 * l the time step of each mode, D its damping over the increment. With `mean` M is the trapezoidal
 * discrete gradient 1/2 [R(q) + R(q')] + sigma d, sigma = -d' [T(q') - T(q)] d / (12 |d|^2), and s
 * the derivative of sigma by d; else M is R in the middle. The last correction over the increment
 * goes into `worst`. */
kernel void iterate(global const real *p, global const real *load, global const real *length,
                    global const real *drag, global const real *omega2, global const real *before,
                    global const real *f, global const real *along_before,
                    global const real *along, global const float *y3, global const float *y4,
                    int mean, global float *j, global real *d, global float *worst, long at,
                    long count) {
  const int c = get_global_id(0);
  if (at + c >= count)
    return;

  // sigma, and how it changes with d
  real square = 0, turned = 0;
  for (int i = 0; i < RANK; i++) {
    square += d[i * PART + c] * d[i * PART + c];
    turned += d[i * PART + c] * (along[i * PART + c] - along_before[i * PART + c]);
  }
  const real sigma = mean && square > 0 ? -turned / (12 * square) : 0;
  float step[RANK], across[RANK], slope[RANK];
  for (int i = 0; i < RANK; i++) {
    const int at_i = i * PART + c;
    const real stiff = 2 / (length[i] * length[i]);
    const real force = mean ? (before[at_i] + f[at_i]) / 2 + sigma * d[at_i] : f[at_i];
    step[i] = (float)(stiff * (d[at_i] - length[i] * p[i * count + at + c]) + force +
                      drag[i] * d[at_i] - load[i * count + at + c]);
    for (int b = 0; b <= i; b++) {
      const int entry = column_of(i, b) * PART + c;
      j[(i * (i + 1) / 2 + b) * PART + c] = (y3[entry] + y4[entry]) / 2;
    }
    j[(i * (i + 1) / 2 + i) * PART + c] += (float)(stiff + drag[i] + omega2[i] / 2 + sigma);

    // the linear parts of both forces and of T d cancel here
    across[i] = (float)d[at_i];
    const real rest = (f[at_i] - before[at_i]) - omega2[i] * d[at_i] - along[at_i];
    slope[i] = mean && square > 0 ? (float)((rest / 2 - 2 * sigma * d[at_i]) / square) : 0;
  }
  factor(j, c);
  solve(j, step, c);

  // what d s' adds, by Sherman and Morrison
  if (mean) {
    solve(j, across, c);
    float above = 0, below = 1;
    for (int i = 0; i < RANK; i++) {
      above += slope[i] * step[i];
      below += slope[i] * across[i];
    }
    for (int i = 0; i < RANK; i++)
      step[i] -= across[i] * (above / below);
  }
  real moved = 0, all = 0;
  for (int i = 0; i < RANK; i++) {
    const real next = d[i * PART + c] - step[i];
    moved += (real)step[i] * step[i];
    all += next * next;
    d[i * PART + c] = next;
  }
  worst[c] = all == 0 ? 0 : (float)sqrt(moved / all);
}

/* The end of an implicit step; a body whose last correction is too large stays, now and later. */
kernel void commit(global real *q, global real *p, global const real *d, global const real *length,
                   global const float *worst, float tolerance, global long *stopped, long made,
                   long at, long count) {
  const int c = get_global_id(0);
  if (at + c >= count || stopped[at + c] >= 0)
    return;
  if (!(worst[c] <= tolerance)) {
    stopped[at + c] = made;
    return;
  }
  for (int i = 0; i < RANK; i++) {
    const long n = i * count + at + c;
    q[n] += d[i * PART + c];
    p[n] = 2 * d[i * PART + c] / length[i] - p[n];
  }
}

/* A step of Stoermer and Verlet, whose p is half a step before q and f is that at q; it takes the
 * mean of the loads of the step before and of this one. */
kernel void kick(global real *q, global real *p, global const real *f, global const real *load,
                 global real *load_before, global const real *drag, real h, global long *stopped,
                 long made, long at, long count) {
  const int c = get_global_id(0);
  if (at + c >= count || stopped[at + c] >= 0)
    return;

  // what would leave the range of numbers
  bool finite = true;
  for (int i = 0; i < RANK; i++)
    finite = finite && isfinite(f[i * PART + c]);
  if (!finite) {
    stopped[at + c] = made;
    return;
  }
  for (int i = 0; i < RANK; i++) {
    const long n = i * count + at + c;
    const real damping = drag[i] * h * h / 2, mean = (load_before[n] + load[n]) / 2;
    p[n] = ((1 - damping) * p[n] - h * (f[i * PART + c] - mean)) / (1 + damping);
    q[n] += h * p[n];
    load_before[n] = load[n];
  }
}

/* Its p half a step before q, from that of the time of q; and back, into `timed`. */
kernel void shift_back(global real *p, global const real *f, global const real *load_before,
                       global const real *drag, real h, long at, long count) {
  const int c = get_global_id(0), i = get_global_id(1);
  const long n = i * count + at + c;
  if (at + c < count)
    p[n] += h / 2 * (f[i * PART + c] + drag[i] * h * p[n] - load_before[n]);
}

kernel void shift_on(global const real *p, global const real *f, global const real *load_before,
                     global const real *drag, real h, global real *timed, long at, long count) {
  const int c = get_global_id(0), i = get_global_id(1);
  const long n = i * count + at + c;
  if (at + c < count)
    timed[n] = (p[n] - h / 2 * (f[i * PART + c] - load_before[n])) / (1 + drag[i] * h * h / 2);
}

/* Kinetic and strain energy. */
kernel void energies(global const real *q, global const real *p, global const real *omega2,
                     global const float *y3, global const float *y4, global real *kinetic,
                     global real *strain, long at, long count) {
  const int c = get_global_id(0);
  if (at + c >= count)
    return;
  real half_square = 0, potential = 0;
  for (int i = 0; i < RANK; i++) {
    const real q_i = q[i * count + at + c], p_i = p[i * count + at + c];
    half_square += p_i * p_i / 2;
    potential += omega2[i] * q_i * q_i / 2;
    real sum = 0;
    for (int j = 0; j < RANK; j++) {
      const int entry = column_of(i, j) * PART + c;
      sum += ((real)y3[entry] / 6 + (real)y4[entry] / 12) * q[j * count + at + c];
    }
    potential += q_i * sum;
  }
  kinetic[at + c] = half_square;
  strain[at + c] = potential;
}
