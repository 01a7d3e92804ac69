/* Prints every published answer beside what is computed: `thrum_verification OUT`, where OUT
 * is a folder that gets verification.csv and tables.md. Optional second argument: how often to
 * refine beyond what the tests do (default 2). Single-threaded; some minutes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/build_info.h"
#include "validation/published/published.h"

#define ROWS_MAX 400

typedef struct collection {
  published_row rows[ROWS_MAX];
  int count;
} collection;

static void collect(void *context, const published_row *row) {
  collection *all = context;
  if (all->count < ROWS_MAX)
    all->rows[all->count++] = *row;
}

/* Relative error. */
static double error_of(const published_row *row) {
  return row->computed / row->published - 1;
}

/* The order between this row and the one that it refines; NaN: there is none. */
static double order_of(const collection *all, int n) {
  const published_row *row = &all->rows[n];
  for (int m = n - 1; m >= 0 && row->size > 0; m--) {
    const published_row *before = &all->rows[m];
    if (strcmp(before->problem, row->problem) == 0 && strcmp(before->quantity, row->quantity) == 0)
      return log(fabs(error_of(before) / error_of(row))) / log(row->size / before->size);
  }
  return NAN;
}

static bool write_csv(const collection *all, FILE *file) {
  fprintf(file, "problem,quantity,setting,size,published,computed,relative_error,order\n");
  for (int n = 0; n < all->count; n++) {
    const published_row *row = &all->rows[n];
    const double order = order_of(all, n);
    fprintf(file, "%s,\"%s\",\"%s\",%.17g,%.17g,%.17g,%.17g,", row->problem, row->quantity,
            row->mesh, row->size, row->published, row->computed, error_of(row));
    if (isfinite(order))
      fprintf(file, "%.17g", order);
    fputs("\n", file);
  }
  return ferror(file) == 0;
}

/* Is row n the first of its quantity? */
static bool is_first(const collection *all, int n) {
  for (int m = 0; m < n; m++)
    if (strcmp(all->rows[m].problem, all->rows[n].problem) == 0 &&
        strcmp(all->rows[m].quantity, all->rows[n].quantity) == 0)
      return false;
  return true;
}

static bool is_same(const published_row *a, const published_row *b) {
  return strcmp(a->problem, b->problem) == 0 && strcmp(a->quantity, b->quantity) == 0;
}

/* One line a quantity: what is published, the finest answer, the errors from coarse to fine. */
static void write_line(const collection *all, int first, FILE *file) {
  const published_row *row = &all->rows[first];
  int last = first;
  fprintf(file, "| %s | %.6g |", row->quantity, row->published);

  // the finest answer is the last of this quantity
  for (int n = first; n < all->count; n++)
    if (is_same(row, &all->rows[n]))
      last = n;
  fprintf(file, " %.6g |", all->rows[last].computed);

  for (int n = first; n < all->count; n++)
    if (is_same(row, &all->rows[n]))
      fprintf(file, "%s%+.2g", n > first ? ", " : " ", 100 * error_of(&all->rows[n]));
  if (isfinite(order_of(all, last)))
    fprintf(file, " | %.1f", order_of(all, last));
  else
    fputs(" | ", file);
  fputs(" |\n", file);
}

static bool write_tables(const collection *all, FILE *file) {
  const char *problem = "";
  for (int n = 0; n < all->count; n++) {
    const published_row *row = &all->rows[n];

    // a heading and the meshes of each problem
    if (strcmp(problem, row->problem) != 0) {
      fprintf(file, "%s### %s\n\nFrom ", n > 0 ? "\n" : "", row->problem);
      const char *settings = "";
      for (int m = n; m < all->count && strcmp(all->rows[m].problem, row->problem) == 0; m++)
        if (is_same(row, &all->rows[m])) {
          fprintf(file, "%s%s", settings, all->rows[m].mesh);
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
  return ferror(file) == 0;
}

static int put(const char *folder, const char *name, const collection *all,
               bool (*write)(const collection *all, FILE *file)) {
  char path[1024];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "w");
  const bool written = file != NULL && write(all, file);
  if (file == NULL || fclose(file) != 0 || !written) {
    fprintf(stderr, "thrum_verification: %s could not be written\n", path);
    return 1;
  }
  return 0;
}

int main(int argc, char **argv) {
  static collection all;
  thrum_error error = {0};
  if (argc < 2 || argc > 3) {
    fprintf(stderr, "usage: thrum_verification FOLDER [REFINEMENTS]\n");
    return 2;
  }
  const published_sink sink = {collect, &all, argc > 2 ? atoi(argv[2]) : 2};

  static const struct {
    const char *text;
    published_problem *solve;
  } problems[] = {
#define X(name, text) {text, published_##name},
      VERIFY_PROBLEMS(X)
#undef X
  };

  // the first problem that fails ends the program
  for (size_t n = 0; n < sizeof problems / sizeof problems[0]; n++) {
    fprintf(stderr, "%s\n", problems[n].text);
    if (problems[n].solve(&sink, &error) < 0) {
      fprintf(stderr, "thrum_verification: %s: %s\n", problems[n].text, error.message);
      return 1;
    }
  }
  return put(argv[1], "verification.csv", &all, write_csv) |
         put(argv[1], "tables.md", &all, write_tables);
}
