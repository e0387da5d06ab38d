/* Products and one factorisation of small dense matrices, row-major. */
#ifndef BM_DENSE_H
#define BM_DENSE_H

/* out (rows, columns) = A (rows, inner) S (inner, columns) */
void bm_multiply(int rows, int inner, int columns, const double *A,
                 const double *S, double *out);

/* out (columns) = a (inner) S (inner, columns) */
void bm_row_times(int inner, int columns, const double *a, const double *S,
                  double *out);

/* S (rows, columns) += a (rows) b (columns) */
void bm_add_outer(int rows, int columns, const double *a, const double *b,
                  double *S);

/* L U = A with both rows and columns exchanged: L and U replace A (n, n), `row`
 * and `column` (n) receive the order. Returns the rank: pivots below `least`
 * times the largest entry of A count as zero. */
int bm_factor(int n, double least, double *A, int *row, int *column);

/* One solution x (n) of A x = b; unknowns without a pivot are zero. `b` is
 * overwritten. */
void bm_solve(int n, int rank, const double *LU, const int *row,
              const int *column, double *b, double *x);

#endif
