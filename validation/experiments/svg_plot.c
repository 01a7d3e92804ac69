/* Curves as inline SVG: axes with round ticks, and curves thinned so that a report stays small.
 *
 * A bucket of points becomes its least and its largest one, so that a swing keeps its envelope.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/svg_plot.h"

#include <math.h>
#include <stddef.h>

#define BUCKETS 110
#define LEFT 56
#define RIGHT 10
#define TOP 22
#define BOTTOM 32

/* Data to pixels along one axis. */
typedef struct axis {
  double least, most; /* of the data, logarithms if log */
  double begin, end;  /* pixels */
  bool log;
} axis;

static double data_of(const axis *a, double value) {
  return a->log ? (value > 0 ? log10(value) : NAN) : value;
}

static double pixel(const axis *a, double value) {
  return a->begin + (data_of(a, value) - a->least) / (a->most - a->least) * (a->end - a->begin);
}

static void widen(axis *a, const double *values, int64_t count) {
  for (int64_t n = 0; n < count; n++) {
    const double value = data_of(a, values[n]);
    if (isfinite(value)) {
      a->least = fmin(a->least, value);
      a->most = fmax(a->most, value);
    }
  }
}

static void settle(axis *a, bool from_zero) {
  if (!(a->least <= a->most)) {
    a->least = 0;
    a->most = 1;
  }
  if (from_zero && !a->log)
    a->least = fmin(a->least, 0);
  if (a->log) {
    a->least = floor(a->least);
    a->most = ceil(a->most);
  }
  // a curve that is flat up to rounding is shown flat, and ticks stay apart from each other
  const double size = fmax(fabs(a->least), fabs(a->most)), flat = size > 0 ? 1e-6 * size : 1;
  if (!a->log && !(a->most - a->least > flat)) {
    const double middle = 0.5 * a->least + 0.5 * a->most;
    a->least = middle - 0.5 * flat;
    a->most = middle + 0.5 * flat;
  } else if (!(a->most > a->least)) {
    a->most = a->least + 1;
  }
}

/* A step of 1, 2 or 5 times a power of ten that gives a tick each 40 pixels or so. */
static double tick_step(const axis *a) {
  const double rough = (a->most - a->least) * 40 / fabs(a->end - a->begin);
  const double unit = pow(10, floor(log10(rough)));
  const double share = rough / unit;
  if (a->log)
    return fmax(1, ceil((a->most - a->least) / 6));
  return unit * (share < 1.5 ? 1 : share < 3.5 ? 2 : share < 7.5 ? 5 : 10);
}

static void add_ticks(experiment_text *text, const axis *a, bool vertical,
                      const experiment_plot *plot) {
  const double step = tick_step(a);
  for (double k = ceil(a->least / step - 1e-9); k * step <= a->most + 1e-9 * step; k++) {
    const double at = a->begin + (k * step - a->least) / (a->most - a->least) * (a->end - a->begin);
    // + 0 turns -0 into 0
    const double value = a->log ? pow(10, k * step) : k * step + 0.0;
    if (vertical) {
      experiment_text_add(text,
                          "<path class=g d='M%d %.1fH%d'/><text class=y x=%d y=%.1f>%.4g</text>",
                          LEFT, at, plot->width - RIGHT, LEFT - 4, at + 3, value);
    } else {
      experiment_text_add(text,
                          "<path class=g d='M%.1f %dV%d'/><text class=x x=%.1f y=%d>%.4g</text>",
                          at, TOP, plot->height - BOTTOM, at, plot->height - BOTTOM + 12, value);
    }
  }
}

static void add_point(experiment_text *text, const axis *x, const axis *y,
                      const experiment_series *series, int64_t n, bool *open) {
  const double px = pixel(x, series->x[n]), py = pixel(y, series->y[n]);
  if (!isfinite(px) || !isfinite(py)) {
    *open = false;
    return;
  }
  experiment_text_add(text, "%c%.1f %.1f", *open ? 'L' : 'M', px, py);
  *open = true;
}

/* The least and the largest point of a bucket, in their order. */
static void add_bucket(experiment_text *text, const axis *x, const axis *y,
                       const experiment_series *series, int64_t begin, int64_t end, bool *open) {
  int64_t least = begin, most = begin;
  for (int64_t n = begin; n < end; n++) {
    if (series->y[n] < series->y[least])
      least = n;
    if (series->y[n] > series->y[most])
      most = n;
  }
  add_point(text, x, y, series, least < most ? least : most, open);
  if (least != most)
    add_point(text, x, y, series, least < most ? most : least, open);
}

static void add_line(experiment_text *text, const axis *x, const axis *y,
                     const experiment_series *series) {
  const int64_t count = series->count;
  bool open = false;
  experiment_text_add(text, "<path class=c stroke='%s' d='", series->color);
  if (count <= 2 * BUCKETS) {
    for (int64_t n = 0; n < count; n++)
      add_point(text, x, y, series, n, &open);
  } else {
    for (int64_t b = 0; b < BUCKETS; b++)
      add_bucket(text, x, y, series, b * count / BUCKETS, (b + 1) * count / BUCKETS, &open);
  }
  experiment_text_add(text, "'/>");
}

static void add_curve(experiment_text *text, const axis *x, const axis *y,
                      const experiment_series *series) {
  if (series->marks < 2)
    add_line(text, x, y, series);
  for (int64_t n = 0; series->marks > 0 && n < series->count; n++) {
    const double px = pixel(x, series->x[n]), py = pixel(y, series->y[n]);
    if (isfinite(px) && isfinite(py))
      experiment_text_add(text, "<circle fill='%s' cx=%.1f cy=%.1f r=2.5 />", series->color, px,
                          py);
  }
}

void experiment_plot_add(experiment_text *text, const experiment_plot *plot) {
  axis x = {INFINITY, -INFINITY, LEFT, plot->width - RIGHT, plot->log_x};
  axis y = {INFINITY, -INFINITY, plot->height - BOTTOM, TOP, plot->log_y};
  for (int64_t n = 0; n < plot->series_count; n++) {
    widen(&x, plot->series[n].x, plot->series[n].count);
    widen(&y, plot->series[n].y, plot->series[n].count);
  }
  settle(&x, false);
  settle(&y, plot->from_zero);
  experiment_text_add(text, "<svg viewBox='0 0 %d %d' width=%d height=%d role=img>", plot->width,
                      plot->height, plot->width, plot->height);
  experiment_text_add(text, "<text class=t x=%d y=13>", LEFT);
  experiment_text_escape(text, plot->title);
  experiment_text_add(text, "</text>");
  add_ticks(text, &x, false, plot);
  add_ticks(text, &y, true, plot);
  // the first on top
  for (int64_t n = plot->series_count - 1; n >= 0; n--)
    add_curve(text, &x, &y, &plot->series[n]);
  experiment_text_add(text, "<text class=x x=%d y=%d>", (LEFT + plot->width - RIGHT) / 2,
                      plot->height - 5);
  experiment_text_escape(text, plot->x_label);
  experiment_text_add(text, "</text><text class=x transform='translate(10 %d) rotate(-90)'>",
                      (TOP + plot->height - BOTTOM) / 2);
  experiment_text_escape(text, plot->y_label);
  experiment_text_add(text, "</text>");
  double at = plot->width - RIGHT;
  for (int64_t n = plot->series_count - 1; n >= 0; n--) {
    if (plot->series[n].label == NULL)
      continue;
    experiment_text_add(text, "<text class=y style='fill:%s' x=%.0f y=13>", plot->series[n].color,
                        at);
    experiment_text_escape(text, plot->series[n].label);
    experiment_text_add(text, "</text>");
    at -= 52;
  }
  experiment_text_add(text, "</svg>\n");
}
