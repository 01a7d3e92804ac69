/* The passes of a step of many bodies (accelerator/README.md says in which order). An entry i of a
 * body c of a part lies at i * PART + c, and of a body n of all at i * count + n: neighbours lie
 * side by side in memory.
 *
 *   T(q) = omega^2 + [A3' q + A4' m],  m = (q_k q_l, k <= l),  columns (a, b), a <= b
 *   R(q) = omega^2 q + (A3' q) q / 2 + (A4' m) q / 3,   V likewise with 1/6 and 1/12
 *
 * With POINTS cubature points V is a sum over these (core/polynomial/points.h), A has the gradients of
 * the coordinates at them, nine numbers a point, and T - omega^2 goes where A4' m is above.
 *
 * RANK r, PAIRS r (r + 1) / 2, PART bodies of a part, COLUMNS PAIRS rounded up to whole groups. A
 * work-item of `multiply` has WIDE bodies, one of the others LANES: as many as a processor has in a
 * vector, or one, where the work-items are the lanes. Counts are multiples of both.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifdef WITH_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
#define TINY 1e-290
#else
typedef float real;
#define TINY 1e-36f
#endif

/* Squares of shares of q: what the products of single precision cannot tell apart, and an increment
 * along which the rounding of two forces is more than how their difference bends. */
#define ROUNDING 1e-14f
#define SHORT 1e-8f

#define JOIN(a, b) a##b
#define VECTOR(type, width) JOIN(type, width)
#if LANES == 1
typedef float floats;
typedef real reals;
typedef long counts;
#define LOAD(at) (*(at))
#define STORE(value, at) (*(at) = (value))
#define TO_FLOATS(x) ((float)(x))
#define TO_REALS(x) ((real)(x))
#define ZERO_WHERE(condition, value) ((condition) ? (reals)0 : (value))
#else
typedef VECTOR(float, LANES) floats;
typedef VECTOR(long, LANES) counts;
#define LOAD(at) VECTOR(vload, LANES)(0, at)
#define STORE(value, at) VECTOR(vstore, LANES)(value, 0, at)
#define TO_FLOATS(x) VECTOR(convert_float, LANES)(x)
#define ZERO_WHERE(condition, value) select(value, (reals)0, condition)
#ifdef WITH_DOUBLE
typedef VECTOR(double, LANES) reals;
#define TO_REALS(x) VECTOR(convert_double, LANES)(x)
#else
typedef VECTOR(float, LANES) reals;
#define TO_REALS(x) VECTOR(convert_float, LANES)(x)
#endif
#endif

#define GROUP 8 /* columns of a work-item of `multiply` */

/* A work-item's bodies: c of the part, n of all. */
#define BODIES                                                                                     \
  const int c = get_global_id(0) * LANES;                                                          \
  const long n = at + c

// where the forces are taken: q + share d
reals place(global const real *q, global const real *d, real share, int i, int c, long n,
            long count) {
  return LOAD(q + i * count + n) + share * LOAD(d + i * PART + c);
}

/* The rows that the coefficients are multiplied with: q, then the products of its pairs. */
kernel void products(global const real *q, global const real *d, real share,
                     global const ushort2 *pairs, global float *x, long at, long count) {
  BODIES;
  const int row = get_global_id(1);
  if (row < RANK) {
    STORE(TO_FLOATS(place(q, d, share, row, c, n, count)), x + row * PART + c);
    return;
  }
  const ushort2 pair = pairs[row - RANK];
  const reals product =
      place(q, d, share, pair.x, c, n, count) * place(q, d, share, pair.y, c, n, count);
  STORE(TO_FLOATS(product), x + row * PART + c);
}

/* y = A' x over these rows, each entry a sum in ascending order. */
kernel void multiply(global const float *a, global const float *x, int first, int rows,
                     global float *y) {
  const int c = get_global_id(0) * WIDE, column = get_global_id(1) * GROUP;
  VECTOR(float, WIDE) sum[GROUP];
  for (int i = 0; i < GROUP; i++)
    sum[i] = 0;
  a += first * COLUMNS + column;
  x += first * PART + c;
  for (int row = 0; row < rows; row++, a += COLUMNS, x += PART) {
    const VECTOR(float, WIDE) there = VECTOR(vload, WIDE)(0, x);
    for (int i = 0; i < GROUP; i++)
      sum[i] = mad((VECTOR(float, WIDE))(a[i]), there, sum[i]);
  }
  for (int i = 0; i < GROUP; i++)
    VECTOR(vstore, WIDE)(sum[i], 0, y + (column + i) * PART + c);
}

/* d as the rows that the gradients are multiplied with. */
kernel void increments(global const real *d, global float *x) {
  const int c = get_global_id(0) * LANES, i = get_global_id(1);
  STORE(TO_FLOATS(LOAD(d + i * PART + c)), x + i * PART + c);
}

// the column of the pair (i, j) of a symmetric matrix
int column_of(int i, int j) {
  const int a = min(i, j), b = max(i, j);
  return a * RANK - a * (a - 1) / 2 + b - a;
}

/* R at q + share d into f, and the part of T d that is not linear into `along`. */
kernel void force(global const real *q, global const real *d, real share, global const real *omega2,
                  global const float *y3, global const float *y4, global real *f,
                  global real *along, long at, long count) {
  BODIES;
  const int i = get_global_id(1);
  reals sum = omega2[i] * place(q, d, share, i, c, n, count), product = 0;
  for (int j = 0; j < RANK; j++) {
    const int entry = column_of(i, j) * PART + c;
    const reals cubic = TO_REALS(LOAD(y3 + entry)), quartic = TO_REALS(LOAD(y4 + entry));
    sum += (cubic / 2 + quartic / 3) * place(q, d, share, j, c, n, count);
    product += (cubic + quartic) * LOAD(d + j * PART + c);
  }
  STORE(sum, f + i * PART + c);
  STORE(product, along + i * PART + c);
}

#ifdef POINTS
/* What the energy of a point adds to that of small strains, Saint Venant-Kirchhoff material: with
 * N = G'G/2, E = sym G + N, S = C:E and T = C:N, the energy N:(S - T/2), its derivative P = T + G S
 * by G, and along D, with dN = sym(G'D) and dE = sym D + dN, dP = C:dN + D S + G C:dE. */
typedef struct point {
  floats g[9], s[9], t[9]; /* rows of G, S, T */
  float lambda, mu;
} point;

// lambda tr(e) 1 + 2 mu e of a symmetric e
void hooke(float lambda, float mu, const floats *e, floats *out) {
  const floats trace = lambda * (e[0] + e[4] + e[8]);
  for (int k = 0; k < 9; k++)
    out[k] = 2 * mu * e[k] + (k % 4 == 0 ? trace : (floats)0);
}

// the symmetric part of a' b
void pulled(const floats *a, const floats *b, floats *out) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      out[3 * i + j] = 0;
      for (int k = 0; k < 3; k++)
        out[3 * i + j] += (a[3 * k + i] * b[3 * k + j] + a[3 * k + j] * b[3 * k + i]) / 2;
    }
}

floats symmetric(const floats *a, int k) {
  return (a[k] + a[3 * (k % 3) + k / 3]) / 2;
}

void take_point(global const float *g, global const float *moduli, int p, int c, point *at) {
  floats n[9], e[9];
  at->lambda = moduli[p];
  at->mu = moduli[POINTS + p];
  for (int k = 0; k < 9; k++)
    at->g[k] = LOAD(g + (9 * p + k) * PART + c);
  pulled(at->g, at->g, n);
  for (int k = 0; k < 9; k++) {
    n[k] /= 2;
    e[k] = symmetric(at->g, k) + n[k];
  }
  hooke(at->lambda, at->mu, n, at->t);
  hooke(at->lambda, at->mu, e, at->s);
}

// entry (i, j) of a product of two
floats entry_of(const floats *a, const floats *b, int i, int j) {
  return a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

void along_of(const point *at, const floats *d, floats *out) {
  floats n[9], e[9], cn[9], ce[9];
  pulled(at->g, d, n);
  for (int k = 0; k < 9; k++)
    e[k] = symmetric(d, k) + n[k];
  hooke(at->lambda, at->mu, n, cn);
  hooke(at->lambda, at->mu, e, ce);
  for (int k = 0; k < 9; k++)
    out[k] = cn[k] + entry_of(d, at->s, k / 3, k % 3) + entry_of(at->g, ce, k / 3, k % 3);
}

/* The weight times P at each point, and times dP along gd. */
kernel void points(global const float *g, global const float *gd, global const float *moduli,
                   global const float *weights, global float *pull, global float *pull_along) {
  const int c = get_global_id(0) * LANES, p = get_global_id(1);
  point at;
  floats d[9], change[9];
  take_point(g, moduli, p, c, &at);
  for (int k = 0; k < 9; k++)
    d[k] = LOAD(gd + (9 * p + k) * PART + c);
  along_of(&at, d, change);
  for (int k = 0; k < 9; k++) {
    const floats stress = at.t[k] + entry_of(at.g, at.s, k / 3, k % 3);
    STORE(weights[p] * stress, pull + (9 * p + k) * PART + c);
    STORE(weights[p] * change[k], pull_along + (9 * p + k) * PART + c);
  }
}

/* R and the part of T d that is not linear, as `force` has them. */
kernel void point_force(global const real *q, global const real *d, real share,
                        global const real *omega2, global const float *a,
                        global const float *pull, global const float *pull_along, global real *f,
                        global real *along, long at, long count) {
  BODIES;
  const int i = get_global_id(1);
  reals sum = 0, product = 0;
  for (int k = 0; k < 9 * POINTS; k++) {
    sum += TO_REALS(a[i * COLUMNS + k] * LOAD(pull + k * PART + c));
    product += TO_REALS(a[i * COLUMNS + k] * LOAD(pull_along + k * PART + c));
  }
  STORE(omega2[i] * place(q, d, share, i, c, n, count) + sum, f + i * PART + c);
  STORE(product, along + i * PART + c);
}

/* Row i of T - omega^2 up to the diagonal into y4, and 0 into y3. */
kernel void point_tangent(global const float *a, global const float *g,
                          global const float *moduli, global const float *weights,
                          global float *y3, global float *y4) {
  const int c = get_global_id(0) * LANES, i = get_global_id(1);
  floats row[RANK];
  for (int j = 0; j <= i; j++)
    row[j] = 0;
  for (int p = 0; p < POINTS; p++) {
    point at;
    floats d[9], change[9];
    take_point(g, moduli, p, c, &at);
    for (int k = 0; k < 9; k++)
      d[k] = weights[p] * a[i * COLUMNS + 9 * p + k];
    along_of(&at, d, change);
    for (int j = 0; j <= i; j++)
      for (int k = 0; k < 9; k++)
        row[j] += a[j * COLUMNS + 9 * p + k] * change[k];
  }
  for (int j = 0; j <= i; j++) {
    STORE(row[j], y4 + column_of(j, i) * PART + c);
    STORE((floats)0, y3 + column_of(j, i) * PART + c);
  }
}

/* Kinetic and strain energy. */
kernel void point_energies(global const real *q, global const real *p, global const real *omega2,
                           global const float *g, global const float *moduli,
                           global const float *weights, global real *kinetic, global real *strain,
                           long at, long count) {
  BODIES;
  reals half_square = 0, potential = 0;
  for (int i = 0; i < RANK; i++) {
    const reals q_i = LOAD(q + i * count + n), p_i = LOAD(p + i * count + n);
    half_square += p_i * p_i / 2;
    potential += omega2[i] * q_i * q_i / 2;
  }
  for (int k = 0; k < POINTS; k++) {
    point here;
    floats small[9], energy = 0;
    take_point(g, moduli, k, c, &here);
    pulled(here.g, here.g, small);
    for (int e = 0; e < 9; e++)
      energy += small[e] / 2 * (here.s[e] - here.t[e] / 2);
    potential += TO_REALS(weights[k] * energy);
  }
  STORE(half_square, kinetic + n);
  STORE(potential, strain + n);
}
#endif

/* The first increment of a step: where the body goes without forces. */
kernel void begin(global const real *p, global const real *length, global real *d, long at,
                  long count) {
  BODIES;
  const int i = get_global_id(1);
  STORE(length[i] * LOAD(p + i * count + n), d + i * PART + c);
}

// entry (a, b), b <= a, of a factor
#define ENTRY(a, b) (j + ((a) * ((a) + 1) / 2 + (b)) * PART + c)

// a symmetric matrix by L D L', in place
void factor(global float *j, int c) {
  for (int a = 0; a < RANK; a++) {
    for (int b = 0; b < a; b++) {
      floats sum = LOAD(ENTRY(a, b));
      for (int k = 0; k < b; k++)
        sum -= LOAD(ENTRY(a, k)) * LOAD(ENTRY(b, k));
      STORE(sum, ENTRY(a, b));
    }
    floats pivot = LOAD(ENTRY(a, a));
    for (int b = 0; b < a; b++) {
      const floats entry = LOAD(ENTRY(a, b)), low = entry / LOAD(ENTRY(b, b));
      pivot -= entry * low;
      STORE(low, ENTRY(a, b));
    }
    STORE(pivot, ENTRY(a, a));
  }
}

void solve(global const float *j, floats *x, int c) {
  for (int a = 0; a < RANK; a++)
    for (int b = 0; b < a; b++)
      x[a] -= LOAD(ENTRY(a, b)) * x[b];
  for (int a = 0; a < RANK; a++)
    x[a] /= LOAD(ENTRY(a, a));
  for (int a = RANK - 1; a >= 0; a--)
    for (int b = 0; b < a; b++)
      x[b] -= LOAD(ENTRY(a, b)) * x[a];
}

/* One Newton iteration for the increment d of a body, with G over half the square of the time step:
 *
 *   G = (2/l^2) (d - l p) + M + D d - F,   J = 2/l^2 + D + T/2 [+ sigma + d s'],   d := d - J^-1 G
 *
 * l the time step of each mode, D its damping over the increment. With `mean` M is the trapezoidal
 * discrete gradient 1/2 [R(q) + R(q')] + sigma d, sigma = -d' [T(q') - T(q)] d / (12 |d|^2), and s
 * the derivative of sigma by d; else M is R in the middle. The last correction over the increment
 * goes into `worst`, or 0 for one that is rounding beside q, as of a body that has come to rest. */
kernel void iterate(global const real *q, global const real *p, global const real *load, global const real *length,
                    global const real *drag, global const real *omega2, global const real *before,
                    global const real *f, global const real *along_before,
                    global const real *along, global const float *y3, global const float *y4,
                    int mean, global float *j, global real *d, global float *worst, long at,
                    long count) {
  BODIES;

  // sigma, and how it changes with d; a body that does not move has none, and without `mean` the
  // arrays of the start hold anything
  reals square = 0, size = 0, turned = 0;
  for (int i = 0; i < RANK; i++) {
    const reals d_i = LOAD(d + i * PART + c), end = LOAD(q + i * count + n) + d_i;
    square += d_i * d_i;
    size += end * end;
    turned += d_i * (LOAD(along + i * PART + c) - LOAD(along_before + i * PART + c));
  }
  const reals inverse = mean ? ZERO_WHERE(square <= TINY, 1 / square) : (reals)0;
  const reals sigma = mean ? -turned * inverse / 12 : (reals)0;
  const reals bent = ZERO_WHERE(square <= SHORT * size, inverse);
  floats step[RANK], across[RANK], slope[RANK];
  for (int i = 0; i < RANK; i++) {
    const int at_i = i * PART + c;
    const real stiff = 2 / (length[i] * length[i]);
    const reals d_i = LOAD(d + at_i), f_i = LOAD(f + at_i), before_i = LOAD(before + at_i);
    const reals force = mean ? (before_i + f_i) / 2 + sigma * d_i : f_i;
    step[i] = TO_FLOATS(stiff * (d_i - length[i] * LOAD(p + i * count + n)) + force +
                        drag[i] * d_i - LOAD(load + i * count + n));
    for (int b = 0; b <= i; b++) {
      const int entry = column_of(i, b) * PART + c;
      STORE((LOAD(y3 + entry) + LOAD(y4 + entry)) / 2, ENTRY(i, b));
    }
    STORE(LOAD(ENTRY(i, i)) + TO_FLOATS(sigma + (stiff + drag[i] + omega2[i] / 2)), ENTRY(i, i));

    // the linear parts of both forces and of T d cancel here
    across[i] = TO_FLOATS(d_i);
    const reals rest = (f_i - before_i) - omega2[i] * d_i - LOAD(along + at_i);
    slope[i] = TO_FLOATS((rest / 2 - 2 * sigma * d_i) * bent);
  }
  factor(j, c);
  solve(j, step, c);

  // what d s' adds, by Sherman and Morrison
  if (mean) {
    solve(j, across, c);
    floats above = 0, below = 1;
    for (int i = 0; i < RANK; i++) {
      above += slope[i] * step[i];
      below += slope[i] * across[i];
    }
    for (int i = 0; i < RANK; i++)
      step[i] -= across[i] * (above / below);
  }
  reals moved = 0, all = 0;
  for (int i = 0; i < RANK; i++) {
    const reals correction = TO_REALS(step[i]), next = LOAD(d + i * PART + c) - correction;
    moved += correction * correction;
    all += next * next;
    STORE(next, d + i * PART + c);
  }
  STORE(TO_FLOATS(ZERO_WHERE(moved <= ROUNDING * size + TINY, sqrt(moved / all))), worst + c);
}

/* The end of an implicit step, one work-item a body; a body whose last correction is too large
 * stays, now and later. */
kernel void commit(global real *q, global real *p, global const real *d, global const real *length,
                   global const float *worst, float tolerance, global long *stopped, long made,
                   long at, long count) {
  const int c = get_global_id(0);
  const long n = at + c;
  if (stopped[n] >= 0)
    return;
  if (!(worst[c] <= tolerance)) {
    stopped[n] = made;
    return;
  }
  for (int i = 0; i < RANK; i++) {
    const real moved = d[i * PART + c];
    q[i * count + n] += moved;
    p[i * count + n] = 2 * moved / length[i] - p[i * count + n];
  }
}

/* A step of Stoermer and Verlet, whose p is half a step before q and f is that at q; it takes the
 * mean of the loads of the step before and of this one. */
kernel void kick(global real *q, global real *p, global const real *f, global const real *load,
                 global real *load_before, global const real *drag, real h, global long *stopped,
                 long made, long at, long count) {
  const int c = get_global_id(0);
  const long n = at + c;
  if (stopped[n] >= 0)
    return;

  // what would leave the range of numbers
  bool finite = true;
  for (int i = 0; i < RANK; i++)
    finite = finite && isfinite(f[i * PART + c]);
  if (!finite) {
    stopped[n] = made;
    return;
  }
  for (int i = 0; i < RANK; i++) {
    const long k = i * count + n;
    const real damping = drag[i] * h * h / 2, mean = (load_before[k] + load[k]) / 2;
    p[k] = ((1 - damping) * p[k] - h * (f[i * PART + c] - mean)) / (1 + damping);
    q[k] += h * p[k];
    load_before[k] = load[k];
  }
}

/* Its p half a step before q, from that of the time of q; and back, into `timed`. A force beyond the
 * range of numbers, at which the body stops, changes neither. */
kernel void shift_back(global real *p, global const real *f, global const real *load_before,
                       global const real *drag, real h, long at, long count) {
  const int c = get_global_id(0), i = get_global_id(1);
  const long k = i * count + at + c;
  if (isfinite(f[i * PART + c]))
    p[k] += h / 2 * (f[i * PART + c] + drag[i] * h * p[k] - load_before[k]);
}

kernel void shift_on(global const real *p, global const real *f, global const real *load_before,
                     global const real *drag, real h, global real *timed, long at, long count) {
  const int c = get_global_id(0), i = get_global_id(1);
  const long k = i * count + at + c;
  timed[k] = isfinite(f[i * PART + c])
                 ? (p[k] - h / 2 * (f[i * PART + c] - load_before[k])) / (1 + drag[i] * h * h / 2)
                 : p[k];
}

/* Kinetic and strain energy. */
kernel void energies(global const real *q, global const real *p, global const real *omega2,
                     global const float *y3, global const float *y4, global real *kinetic,
                     global real *strain, long at, long count) {
  BODIES;
  reals half_square = 0, potential = 0;
  for (int i = 0; i < RANK; i++) {
    const reals q_i = LOAD(q + i * count + n), p_i = LOAD(p + i * count + n);
    half_square += p_i * p_i / 2;
    reals sum = omega2[i] * q_i / 2;
    for (int j = 0; j < RANK; j++) {
      const int entry = column_of(i, j) * PART + c;
      sum += (TO_REALS(LOAD(y3 + entry)) / 6 + TO_REALS(LOAD(y4 + entry)) / 12) *
             LOAD(q + j * count + n);
    }
    potential += q_i * sum;
  }
  STORE(half_square, kinetic + n);
  STORE(potential, strain + n);
}
