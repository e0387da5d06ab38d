/* What LAPACK would do for one mass: enough for a flow of two states. */
#ifndef BM_TEST_LAPACK_H
#define BM_TEST_LAPACK_H

#include <complex.h>
#include <math.h>

#include "beltsim_map.h"

/* Real A (2, 2) by columns with complex eigenvalues. */
static void small_dgeev(char *left, char *right, int *n, double *A, int *lda,
                        double *wr, double *wi, double *vl, int *ldvl,
                        double *vr, int *ldvr, double *work, int *room,
                        int *info) {
  (void)left, (void)lda, (void)vl, (void)ldvl, (void)ldvr;
  *info = 0;
  if (*room == -1) {
    work[0] = 4.0 * *n;
    return;
  }
  double half = 0.5 * (A[0] + A[3]), rest = A[0] * A[3] - A[1] * A[2];
  double complex root = csqrt(half * half - rest);
  double complex values[2] = {half + root, half - root};
  if (cimag(values[0]) < 0.0) {
    values[0] = half - root;
    values[1] = half + root;
  }
  for (int i = 0; i < 2; i++) {
    wr[i] = creal(values[i]);
    wi[i] = cimag(values[i]);
  }
  if (*right == 'V') { /* (A01, lambda - A00), real and imaginary part */
    vr[0] = A[2];
    vr[1] = wr[0] - A[0];
    vr[2] = 0.0;
    vr[3] = wi[0];
  }
}

static void small_dgesv(int *n, int *columns, double *A, int *lda, int *pivots,
                        double *B, int *ldb, int *info) {
  (void)lda, (void)ldb;
  int N = *n;
  *info = 0;
  for (int k = 0; k < N; k++) {
    int p = k;
    for (int i = k + 1; i < N; i++) {
      p = fabs(A[i + k * N]) > fabs(A[p + k * N]) ? i : p;
    }
    pivots[k] = p + 1;
    if (A[p + k * N] == 0.0) {
      *info = k + 1;
      return;
    }
    for (int j = 0; j < N + *columns; j++) {
      double *column = j < N ? A + j * N : B + (j - N) * N, hold = column[k];
      column[k] = column[p];
      column[p] = hold;
    }
    for (int i = k + 1; i < N; i++) {
      double factor = A[i + k * N] / A[k + k * N];
      for (int j = 0; j < N + *columns; j++) {
        double *column = j < N ? A + j * N : B + (j - N) * N;
        column[i] -= factor * column[k];
      }
    }
  }
  for (int j = 0; j < *columns; j++) {
    for (int i = N - 1; i >= 0; i--) {
      for (int k = i + 1; k < N; k++) {
        B[i + j * N] -= A[i + k * N] * B[k + j * N];
      }
      B[i + j * N] /= A[i + i * N];
    }
  }
}

static void small_zgesv(int *n, int *columns, double *A, int *lda, int *pivots,
                        double *B, int *ldb, int *info) {
  (void)n, (void)columns, (void)lda, (void)ldb;
  double complex answer = (B[0] + B[1] * I) / (A[0] + A[1] * I);
  pivots[0] = 1;
  B[0] = creal(answer);
  B[1] = cimag(answer);
  *info = 0;
}

static const bm_lapack small_lapack = {small_dgeev, small_dgesv, small_zgesv};

#endif
