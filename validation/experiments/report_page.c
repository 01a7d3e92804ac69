/* The page around a report. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "validation/experiments/report.h"

const char *const experiment_colors[EXPERIMENT_INTEGRATOR_COUNT] = {"#1769aa", "#d2691e",
                                                                    "#2e8b57"};

void experiment_page_begin(experiment_text *text, const char *title,
                           const experiment_place *place) {
  experiment_text_add(text, "<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8>\n<title>");
  experiment_text_escape(text, title);
  experiment_text_add(
      text,
      "</title>\n<style>\n"
      "body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1180px;"
      "padding:0 1em;color:#222;background:#fff}\n"
      "table{border-collapse:collapse;margin:1em 0;font-size:13px}\n"
      "th,td{padding:2px 8px;text-align:right;border-bottom:1px solid #ddd}td{white-space:nowrap}\n"
      "th{border-bottom:2px solid #888;vertical-align:bottom}\n"
      "td:first-child,th:first-child,.l{text-align:left}\n"
      ".bad{color:#b00020;font-weight:600}.dim{color:#777}\n"
      "svg{margin:2px}svg text{font:10px sans-serif;fill:#444}\n"
      "svg .t{font-weight:600;font-size:11px}svg .x{text-anchor:middle}\n"
      "svg .y{text-anchor:end}svg .g{stroke:#e4e4e4;fill:none}\n"
      "svg .c{fill:none;stroke-width:1.1;stroke-linejoin:round}\n"
      "</style></head><body>\n<h1>");
  experiment_text_escape(text, title);
  experiment_text_add(text, "</h1>\n<p class=dim>Thrum %s, ", thrum_version());
  experiment_text_escape(text, place->compiler);
  experiment_text_add(text, ", ");
  experiment_text_escape(text, place->machine);
  experiment_text_add(text, ", BLAS core ");
  experiment_text_escape(text, place->blas_core);
  experiment_text_add(text, ". <code>");
  experiment_text_escape(text, place->command);
  experiment_text_add(text, "</code></p>\n");
}

void experiment_page_end(experiment_text *text) {
  experiment_text_add(text, "</body></html>\n");
}

void experiment_cell(experiment_text *text, const char *format, double value) {
  experiment_text_add(text, "<td>");
  if (isfinite(value)) {
    experiment_text_add(text, format, value);
  } else {
    experiment_text_add(text, "–");
  }
}
