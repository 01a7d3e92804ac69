/* The tables of published answers: all rows, and a page with a line for each quantity.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "precompute/build_info.h"
#include "validation/published/published.h"

/* Relative error. */
static double error_of(const published_row *row) {
  return row->computed / row->published - 1;
}

/* Whether two rows are of one quantity. */
static bool is_same(const published_row *a, const published_row *b) {
  return strcmp(a->problem, b->problem) == 0 && strcmp(a->quantity, b->quantity) == 0;
}

/* The order between this row and the one that it refines; NaN: there is none. */
static double order_of(const published_rows *all, int n) {
  const published_row *row = &all->row[n];
  for (int m = n - 1; m >= 0 && row->size > 0; m--) {
    const published_row *before = &all->row[m];
    if (is_same(before, row))
      return log(fabs(error_of(before) / error_of(row))) / log(row->size / before->size);
  }
  return NAN;
}

void published_write_csv(const published_rows *all, FILE *file) {
  fprintf(file, "problem,quantity,setting,size,published,computed,relative_error,order\n");
  for (int n = 0; n < all->count; n++) {
    const published_row *row = &all->row[n];
    const double order = order_of(all, n);
    fprintf(file, "%s,\"%s\",\"%s\",%.17g,%.17g,%.17g,%.17g,", row->problem, row->quantity,
            row->mesh, row->size, row->published, row->computed, error_of(row));
    if (isfinite(order))
      fprintf(file, "%.17g", order);
    fputs("\n", file);
  }
}

/* Is row n the first of its quantity? */
static bool is_first(const published_rows *all, int n) {
  for (int m = 0; m < n; m++)
    if (is_same(&all->row[m], &all->row[n]))
      return false;
  return true;
}

/* One line a quantity: what is published, the finest answer, the errors from coarse to fine. */
static void write_line(const published_rows *all, int first, FILE *file) {
  const published_row *row = &all->row[first];
  int last = first;
  fprintf(file, "| %s | %.6g |", row->quantity, row->published);

  // the finest answer is the last of this quantity
  for (int n = first; n < all->count; n++)
    if (is_same(row, &all->row[n]))
      last = n;
  fprintf(file, " %.6g |", all->row[last].computed);

  for (int n = first; n < all->count; n++)
    if (is_same(row, &all->row[n]))
      fprintf(file, "%s%+.2g", n > first ? ", " : " ", 100 * error_of(&all->row[n]));
  if (isfinite(order_of(all, last)))
    fprintf(file, " | %.1f", order_of(all, last));
  else
    fputs(" | ", file);
  fputs(" |\n", file);
}

void published_write_tables(const published_rows *all, FILE *file) {
  const char *problem = "";
  for (int n = 0; n < all->count; n++) {
    const published_row *row = &all->row[n];

    // a heading and the meshes of each problem
    if (strcmp(problem, row->problem) != 0) {
      fprintf(file, "%s### %s\n\nFrom ", n > 0 ? "\n" : "", row->problem);
      const char *settings = "";
      for (int m = n; m < all->count && strcmp(all->row[m].problem, row->problem) == 0; m++)
        if (is_same(row, &all->row[m])) {
          fprintf(file, "%s%s", settings, all->row[m].mesh);
          settings = ", ";
        }
      fputs("\n\n| quantity | published | finest | errors, % | order |\n|---|---|---|---|---|\n",
            file);
    }

    problem = row->problem;
    if (is_first(all, n))
      write_line(all, n, file);
  }
  fprintf(file, "\n%s, BLAS core %s\n", thrum_build_compiler(), thrum_build_blas_core());
}
