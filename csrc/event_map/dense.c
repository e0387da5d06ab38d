#include "dense.h"

#include <math.h>
#include <string.h>

#include "clones.h"

/* Four rows at a time: each row of S is read once for all of them. */
BM_CLONES static void four_rows(
    int inner, int columns, const double *restrict a0,
    const double *restrict a1, const double *restrict a2,
    const double *restrict a3, const double *restrict S, double *restrict o0,
    double *restrict o1, double *restrict o2, double *restrict o3) {
  for (int j = 0; j < inner; j++, S += columns) {
    double x0 = a0[j], x1 = a1[j], x2 = a2[j], x3 = a3[j];
    for (int c = 0; c < columns; c++) {
      o0[c] += x0 * S[c];
      o1[c] += x1 * S[c];
      o2[c] += x2 * S[c];
      o3[c] += x3 * S[c];
    }
  }
}

BM_CLONES static void add_scaled(int n, double a, const double *restrict x,
                                 double *restrict out) {
  for (int i = 0; i < n; i++) {
    out[i] += a * x[i];
  }
}

void bm_multiply(int rows, int inner, int columns, const double *A,
                 const double *S, double *out) {
  int i = 0;
  memset(out, 0, (size_t)rows * (size_t)columns * sizeof(double));
  for (; i + 4 <= rows; i += 4) {
    const double *a = A + (size_t)i * inner;
    double *o = out + (size_t)i * columns;
    four_rows(inner, columns, a, a + inner, a + 2 * inner, a + 3 * inner, S, o,
              o + columns, o + 2 * columns, o + 3 * columns);
  }
  for (; i < rows; i++) {
    for (int j = 0; j < inner; j++) {
      add_scaled(columns, A[(size_t)i * inner + j], S + (size_t)j * columns,
                 out + (size_t)i * columns);
    }
  }
}

void bm_row_times(int inner, int columns, const double *a, const double *S,
                  double *out) {
  bm_multiply(1, inner, columns, a, S, out);
}

void bm_add_outer(int rows, int columns, const double *a, const double *b,
                  double *S) {
  for (int i = 0; i < rows; i++) {
    add_scaled(columns, a[i], b, S + (size_t)i * columns);
  }
}

/* Place of the entry of largest modulus. */
static int peak_of(int n, const double *x) {
  int at = 0;
  for (int k = 1; k < n; k++) {
    at = fabs(x[k]) > fabs(x[at]) ? k : at;
  }
  return at;
}

static void exchange_rows(int n, double *A, int *row, int i, int k) {
  for (int j = 0; j < n && i != k; j++) {
    double hold = A[(size_t)i * n + j];
    A[(size_t)i * n + j] = A[(size_t)k * n + j];
    A[(size_t)k * n + j] = hold;
  }
  int hold = row[i];
  row[i] = row[k];
  row[k] = hold;
}

static void exchange_columns(int n, double *A, int *column, int j, int k) {
  for (int i = 0; i < n && j != k; i++) {
    double hold = A[(size_t)i * n + j];
    A[(size_t)i * n + j] = A[(size_t)i * n + k];
    A[(size_t)i * n + k] = hold;
  }
  int hold = column[j];
  column[j] = column[k];
  column[k] = hold;
}

int bm_factor(int n, double least, double *A, int *row, int *column) {
  double most = fabs(A[peak_of(n * n, A)]);
  for (int i = 0; i < n; i++) {
    row[i] = column[i] = i;
  }
  for (int k = 0; k < n; k++) {
    int i = k, j = k;
    for (; i < n; i++) { /* rows that depend on those above go last */
      j = k + peak_of(n - k, A + (size_t)i * n + k);
      if (fabs(A[(size_t)i * n + j]) > least * most) {
        break;
      }
    }
    if (i == n) {
      return k;
    }
    exchange_rows(n, A, row, i, k);
    exchange_columns(n, A, column, j, k);
    const double *top = A + (size_t)k * n;
    for (i = k + 1; i < n; i++) {
      double *below = A + (size_t)i * n;
      below[k] /= top[k];
      add_scaled(n - k - 1, -below[k], top + k + 1, below + k + 1);
    }
  }
  return n;
}

void bm_solve(int n, int rank, const double *LU, const int *row,
              const int *column, double *b, double *x) {
  for (int i = 0; i < rank; i++) {
    x[i] = b[row[i]];
    for (int j = 0; j < i; j++) {
      x[i] -= LU[(size_t)i * n + j] * x[j];
    }
  }
  memcpy(b, x, (size_t)rank * sizeof(double));
  memset(x, 0, (size_t)n * sizeof(double));
  for (int i = rank - 1; i >= 0; i--) {
    double sum = b[i];
    for (int j = i + 1; j < rank; j++) {
      sum -= LU[(size_t)i * n + j] * b[j];
    }
    b[i] = sum / LU[(size_t)i * n + i];
    x[column[i]] = b[i];
  }
}
