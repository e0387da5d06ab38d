#include "cells.h"

#include <math.h>
#include <string.h>

#include "clones.h"

BM_CLONES static void add_scaled(int n, double a, const double *restrict x,
                                 double *restrict out) {
  for (int i = 0; i < n; i++) {
    out[i] += a * x[i];
  }
}

void bm_cells_apply(int rows, int columns, const double *A, const double *x,
                    double *out) {
  memset(out, 0, (size_t)rows * sizeof(double));
  for (int j = 0; j < columns; j++) {
    add_scaled(rows, x[j], A + j * rows, out);
  }
}

void bm_cells_advance(const bm_cells *cells, int Na, double u, const double *y,
                      double *after, double *term) {
  if (u == 1.0) {
    bm_cells_apply(Na, Na, cells->E, y, after);
    return;
  }
  double factor = 1.0;
  double *now = term, *next = term + Na;
  memcpy(now, y, (size_t)Na * sizeof(double));
  memcpy(after, y, (size_t)Na * sizeof(double));
  for (int k = 1; k < BM_TERMS && factor > 1e-20; k++) {
    factor *= u / k;
    bm_cells_apply(Na, Na, cells->A, now, next);
    add_scaled(Na, factor, next, after);
    double *hold = now;
    now = next;
    next = hold;
  }
}

double bm_cells_taylor(const bm_cells *cells, int Na, int j, const double *y,
                       double *size) {
  const double *row = cells->rows + j * Na;
  double sum = 0.0, mass = 0.0;
  for (int i = 0; i < Na; i++) {
    sum += row[i] * y[i];
    mass += fabs(row[i] * y[i]);
  }
  *size = mass;
  return sum;
}
