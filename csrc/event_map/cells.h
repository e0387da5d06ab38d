/* A signal of a linear system on short cells, without eigenvectors. */
#ifndef BM_CELLS_H
#define BM_CELLS_H

#include "beltsim_map.h"

/* y (Na) a time u d later, 0 <= u <= 1: by the table for u = 1, else by series;
 * `term` (Na) is scratch. */
void bm_cells_advance(const bm_cells *cells, int Na, double u, const double *y,
                      double *after, double *term);

/* Taylor coefficient j of the signal at y in units of d, and the sum of its
 * terms' sizes. */
double bm_cells_taylor(const bm_cells *cells, int Na, int j, const double *y,
                       double *size);

/* out (rows) = A x, A transposed (columns, rows) */
void bm_cells_apply(int rows, int columns, const double *A, const double *x,
                    double *out);

#endif
