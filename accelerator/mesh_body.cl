/* The passes of a step of a whole mesh (accelerator/README.md says in which order). Numbers of a
 * tetrahedron t lie at k * TETS + t, those of a vertex at 3 v + axis. A tetrahedron of NODES nodes
 * with straight edges has POINTS points; the gradient of its node a at point p is the sum over the
 * corners k = 1, 2, 3 of slopes[p][a][k] times the gradient of that corner's barycentric coordinate.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifdef WITH_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
typedef double3 real3;
#define TINY 1e-280 /* product of two residuals below which the body is at rest */
#else
typedef float real;
typedef float3 real3;
#define TINY 1e-26f
#endif

/* A 3 x 3 matrix by its rows. */
typedef struct matrix {
  real3 row[3];
} matrix;

real3 times(const matrix *a, real3 x) {
  return (real3)(dot(a->row[0], x), dot(a->row[1], x), dot(a->row[2], x));
}

// a' x
real3 across(const matrix *a, real3 x) {
  return x.x * a->row[0] + x.y * a->row[1] + x.z * a->row[2];
}

real component(real3 x, int i) {
  return i == 0 ? x.x : i == 1 ? x.y : x.z;
}

// row i of 1
real3 unit(int i) {
  return (real3)(i == 0 ? 1 : 0, i == 1 ? 1 : 0, i == 2 ? 1 : 0);
}

// row i of a b
real3 product_row(const matrix *a, const matrix *b, int i) {
  return across(b, a->row[i]);
}

// lambda tr(e) 1 + 2 mu e for the symmetric part e of x
matrix hooke(const matrix *x, real lambda, real mu) {
  const real trace = x->row[0].x + x->row[1].y + x->row[2].z;
  matrix out;
  for (int i = 0; i < 3; i++) {
    const real3 column = (real3)(component(x->row[0], i), component(x->row[1], i),
                                 component(x->row[2], i));
    out.row[i] = lambda * trace * unit(i) + mu * (x->row[i] + column);
  }
  return out;
}

// F' x, whose symmetric part is how Green's strain changes with x = dF
matrix pulled(const matrix *f, const matrix *x) {
  matrix out;
  for (int i = 0; i < 3; i++) {
    const real3 column =
        (real3)(component(f->row[0], i), component(f->row[1], i), component(f->row[2], i));
    out.row[i] = across(x, column);
  }
  return out;
}

/* The first Piola-Kirchhoff stress P at the displacement gradient g, and, where dg is not 0, its
 * change with dg in place of it. Saint Venant-Kirchhoff, or the stable neo-Hookean law. */
matrix stress(const matrix *g, const matrix *dg, real lambda, real mu) {
  matrix f, out;
  for (int i = 0; i < 3; i++)
    f.row[i] = g->row[i] + unit(i);
#if LAW == 0
  // E is the symmetric part of g + g' g / 2
  matrix strain = pulled(g, g);
  for (int i = 0; i < 3; i++)
    strain.row[i] = g->row[i] + strain.row[i] / 2;
  const matrix s = hooke(&strain, lambda, mu);
  if (!dg) {
    for (int i = 0; i < 3; i++)
      out.row[i] = product_row(&f, &s, i);
    return out;
  }
  const matrix change = pulled(&f, dg), ds = hooke(&change, lambda, mu);
  for (int i = 0; i < 3; i++)
    out.row[i] = product_row(dg, &s, i) + product_row(&f, &ds, i);
#else
  const real shear = 4 * mu / 3, bulk = lambda + 5 * mu / 6;
  matrix cofactor, small;
  for (int i = 0; i < 3; i++) {
    cofactor.row[i] = cross(f.row[(i + 1) % 3], f.row[(i + 2) % 3]);
    small.row[i] = cross(g->row[(i + 1) % 3], g->row[(i + 2) % 3]);
  }
  const real trace = g->row[0].x + g->row[1].y + g->row[2].z;
  const real norm = dot(g->row[0], g->row[0]) + dot(g->row[1], g->row[1]) + dot(g->row[2], g->row[2]);
  const real grown = 2 * trace + norm, square = 4 + grown;
  const real volume = trace + small.row[0].x + small.row[1].y + small.row[2].z +
                      dot(g->row[0], small.row[0]);
  if (!dg) {
    for (int i = 0; i < 3; i++) {
      const real3 column =
          (real3)(component(g->row[0], i), component(g->row[1], i), component(g->row[2], i));
      out.row[i] = (real)0.75 * shear * (g->row[i] + column - trace * unit(i) - small.row[i]) +
                   shear * grown / (4 * square) * f.row[i] + bulk * volume * cofactor.row[i];
    }
    return out;
  }
  const real along = shear * (1 - 1 / square), pressure = bulk * volume - (real)0.75 * shear;
  real turned = 0, opened = 0;
  for (int i = 0; i < 3; i++) {
    turned += dot(f.row[i], dg->row[i]);
    opened += dot(cofactor.row[i], dg->row[i]);
  }
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out.row[i] = 2 * shear / (square * square) * turned * f.row[i] + along * dg->row[i] +
                 bulk * opened * cofactor.row[i] +
                 pressure * (cross(dg->row[j], f.row[k]) + cross(f.row[j], dg->row[k]));
  }
#endif
  return out;
}

real3 at_vertex(global const real *u, int v) {
  return (real3)(u[3 * v], u[3 * v + 1], u[3 * v + 2]);
}

// the gradient of node a at point p, from those of the corners 1, 2, 3
real3 slope_of(constant real *slopes, int p, int a, const real3 corner[3]) {
  constant real *s = slopes + 3 * (NODES * p + a);
  return s[0] * corner[0] + s[1] * corner[1] + s[2] * corner[2];
}

/* The forces of each tetrahedron on its nodes at the place u, or, with `change` 1, how they change
 * along x. */
kernel void elements(global const real *u, global const real *x, int change,
                     global const int *nodes, global const real *gradients,
                     global const real *volume, global const real *moduli,
                     constant real *slopes, constant real *shares, global real *forces) {
  const int t = get_global_id(0);
  const real3 corner[3] = {
      (real3)(gradients[t], gradients[TETS + t], gradients[2 * TETS + t]),
      (real3)(gradients[3 * TETS + t], gradients[4 * TETS + t], gradients[5 * TETS + t]),
      (real3)(gradients[6 * TETS + t], gradients[7 * TETS + t], gradients[8 * TETS + t])};
  real3 force[NODES];
  for (int a = 0; a < NODES; a++)
    force[a] = (real3)(0);
  for (int p = 0; p < POINTS; p++) {
    matrix g, dg;
    for (int i = 0; i < 3; i++)
      g.row[i] = dg.row[i] = (real3)(0);
    for (int a = 0; a < NODES; a++) {
      const real3 slope = slope_of(slopes, p, a, corner);
      const int v = nodes[a * TETS + t];
      const real3 here = at_vertex(u, v);
      g.row[0] += here.x * slope;
      g.row[1] += here.y * slope;
      g.row[2] += here.z * slope;
      if (change) {
        const real3 moved = at_vertex(x, v);
        dg.row[0] += moved.x * slope;
        dg.row[1] += moved.y * slope;
        dg.row[2] += moved.z * slope;
      }
    }
    const matrix pull = stress(&g, change ? &dg : 0, moduli[t], moduli[TETS + t]);
    for (int a = 0; a < NODES; a++) {
      const real3 slope = slope_of(slopes, p, a, corner);
      force[a] += shares[p] * volume[t] * times(&pull, slope);
    }
  }
  for (int a = 0; a < NODES; a++) {
    forces[(3 * a) * TETS + t] = force[a].x;
    forces[(3 * a + 1) * TETS + t] = force[a].y;
    forces[(3 * a + 2) * TETS + t] = force[a].z;
  }
}

// the sum of what the tetrahedra around a vertex do to it, in the order of their numbers
real3 gathered(global const real *forces, global const int *around_ends,
               global const int *around, int v) {
  real3 sum = (real3)(0);
  for (int k = v == 0 ? 0 : around_ends[v - 1]; k < around_ends[v]; k++) {
    const int a = around[k] / TETS, t = around[k] % TETS;
    sum += (real3)(forces[(3 * a) * TETS + t], forces[(3 * a + 1) * TETS + t],
                   forces[(3 * a + 2) * TETS + t]);
  }
  return sum;
}

real3 massed(global const int *mass_ends, global const int *mass_columns,
             global const real *mass, global const real *x, int v) {
  real3 sum = (real3)(0);
  for (int k = v == 0 ? 0 : mass_ends[v - 1]; k < mass_ends[v]; k++)
    sum += mass[k] * at_vertex(x, mass_columns[k]);
  return sum;
}

void put(global real *out, global const uchar *fixed, int v, real3 x) {
  const uchar held = fixed[v];
  out[3 * v] = held & 1 ? 0 : x.x;
  out[3 * v + 1] = held & 2 ? 0 : x.y;
  out[3 * v + 2] = held & 4 ? 0 : x.z;
}

/* The residual of a step, r = load - R - M (a d - b v), of what is free. */
kernel void residual(global const real *forces, global const int *around_ends,
                     global const int *around, global const int *mass_ends,
                     global const int *mass_columns, global const real *mass,
                     global const uchar *fixed, global const real *load, global const real *d,
                     global const real *v, real a, real b, global real *r) {
  const int n = get_global_id(0);
  const real3 inertia = a * massed(mass_ends, mass_columns, mass, d, n) -
                        b * massed(mass_ends, mass_columns, mass, v, n);
  put(r, fixed, n,
      at_vertex(load, n) - gathered(forces, around_ends, around, n) - inertia);
}

/* y = (a M + b K) x from what the tetrahedra give for K x. */
kernel void apply(global const real *forces, global const int *around_ends,
                  global const int *around, global const int *mass_ends,
                  global const int *mass_columns, global const real *mass,
                  global const uchar *fixed, global const real *x, real a, real b,
                  global real *y) {
  const int n = get_global_id(0);
  put(y, fixed, n,
      a * massed(mass_ends, mass_columns, mass, x, n) +
          b * gathered(forces, around_ends, around, n));
}

/* out = x + share y. */
kernel void blend(global const real *x, global const real *y, real share, global real *out) {
  const int i = get_global_id(0);
  out[i] = x[i] + share * y[i];
}

kernel void scale(global const real *x, real share, global real *out) {
  const int i = get_global_id(0);
  out[i] = share * x[i];
}

/* out = x where it may move, else 0. */
kernel void hold(global const real *x, global const uchar *fixed, global real *out) {
  const int n = get_global_id(0);
  put(out, fixed, n, at_vertex(x, n));
}

/* --- conjugate gradients ------------------------------------------------------------------------
 *
 * numbers: 0 r z, 1 p A p, 2 r z of the start, 3 not 0: it has ended, 4 iterations, 5 its step,
 * 7 not 0: it ended by its tolerance */

kernel void partial_sums(global const real *x, global const real *y, int count, global real *sums) {
  const int i = get_global_id(0);
  real sum = 0;
  for (int k = i; k < count; k += SUMS)
    sum += x[k] * y[k];
  sums[i] = sum;
}

real sum_of(global const real *sums) {
  real sum = 0;
  for (int i = 0; i < SUMS; i++)
    sum += sums[i];
  return sum;
}

/* Begins with z = r / diagonal in p, and the answer 0. */
kernel void first_direction(global const real *r, global const real *diagonal, global real *z,
                            global real *p, global real *answer) {
  const int i = get_global_id(0);
  z[i] = p[i] = r[i] / diagonal[i];
  answer[i] = 0;
}

kernel void first_numbers(global const real *sums, global real *numbers) {
  numbers[0] = numbers[2] = sum_of(sums);
  numbers[7] = numbers[0] <= TINY ? 1 : 0;
  numbers[3] = numbers[0] > TINY ? 0 : 1;
  numbers[4] = 0;
}

/* How far along p; where the matrix is not positive there, the answer so far stays, or z. */
kernel void step_length(global const real *sums, global real *numbers) {
  if (numbers[3] != 0)
    return;
  numbers[1] = sum_of(sums);
  numbers[5] = numbers[0] / numbers[1];
  if (!(numbers[1] > 0)) {
    numbers[5] = numbers[4] == 0 ? 1 : 0;
    numbers[3] = 2;
  }
}

kernel void go(global const real *p, global const real *product, global const real *diagonal,
               global const real *numbers, global real *answer, global real *r, global real *z) {
  const int i = get_global_id(0);
  if (numbers[3] == 1)
    return;
  answer[i] += numbers[5] * p[i];
  r[i] -= numbers[5] * product[i];
  z[i] = r[i] / diagonal[i];
}

kernel void next_numbers(global const real *sums, real tolerance, global real *numbers) {
  if (numbers[3] != 0) {
    numbers[3] = 1;
    return;
  }
  const real next = sum_of(sums);
  numbers[6] = next / numbers[0];
  numbers[0] = next;
  numbers[4] += 1;
  numbers[7] = next <= tolerance * tolerance * numbers[2] ? 1 : 0;
  numbers[3] = next > tolerance * tolerance * numbers[2] ? 0 : 1;
}

kernel void next_direction(global const real *z, global const real *numbers, global real *p) {
  const int i = get_global_id(0);
  if (numbers[3] == 0)
    p[i] = z[i] + numbers[6] * p[i];
}
