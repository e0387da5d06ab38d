/* Products and the factorisation, of full and of lesser rank. */
#include "dense.h"

#include "check.h"

enum { MOST = 9 };

static double noise(void) {
  static unsigned long long seed = 1;
  seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(seed >> 33) / 2147483648.0 - 1.0;
}

static void fill(int count, double *x) {
  for (int i = 0; i < count; i++) {
    x[i] = noise();
  }
}

static void products(void) {
  double A[MOST * MOST], S[MOST * MOST], out[MOST * MOST];
  for (int rows = 1; rows <= MOST; rows++) {
    int inner = 1 + rows % 5, columns = 1 + (rows * 3) % MOST;
    fill(rows * inner, A);
    fill(inner * columns, S);
    bm_multiply(rows, inner, columns, A, S, out);
    for (int i = 0; i < rows; i++) {
      for (int c = 0; c < columns; c++) {
        double sum = 0.0;
        for (int j = 0; j < inner; j++) {
          sum += A[i * inner + j] * S[j * columns + c];
        }
        NEAR(out[i * columns + c], sum, 1e-15 * inner);
      }
    }
    bm_row_times(inner, columns, A, S, out + 0);
    bm_add_outer(1, columns, (double[]){-1.0}, out, out);
    for (int c = 0; c < columns; c++) {
      CHECK(out[c] == 0.0);
    }
  }
}

static void solutions(void) {
  double A[MOST * MOST], LU[MOST * MOST], x[MOST], b[MOST], found[MOST];
  int row[MOST], column[MOST];
  for (int n = 1; n <= MOST; n++) {
    fill(n * n, A);
    fill(n, x);
    A[0] = 0.0; /* needs an exchange */
    if (n == 1) {
      A[0] = 2.0;
    }
    for (int i = 0; i < n * n; i++) {
      LU[i] = A[i];
    }
    bm_multiply(n, n, 1, A, x, b);
    CHECK(bm_factor(n, 1e-12, LU, row, column) == n);
    bm_solve(n, n, LU, row, column, b, found);
    for (int i = 0; i < n; i++) {
      NEAR(found[i], x[i], 1e-11);
    }
  }
}

/* Row 1 is twice row 0 plus row 3: rank n - 1, and a solution all the same. */
static void lesser_rank(void) {
  enum { n = 6 };
  double A[n * n], LU[n * n], x[n], b[n], kept[n], found[n], again[n];
  int row[n], column[n];
  fill(n * n, A);
  fill(n, x);
  for (int j = 0; j < n; j++) {
    A[n + j] = 2.0 * A[j] + A[3 * n + j];
  }
  bm_multiply(n, n, 1, A, x, b);
  for (int i = 0; i < n * n; i++) {
    LU[i] = A[i];
  }
  for (int i = 0; i < n; i++) {
    kept[i] = b[i];
  }
  int rank = bm_factor(n, 1e-10, LU, row, column);
  CHECK(rank == n - 1);
  bm_solve(n, rank, LU, row, column, b, found);
  bm_multiply(n, n, 1, A, found, again);
  for (int i = 0; i < n; i++) {
    NEAR(again[i], kept[i], 1e-13);
  }
  CHECK(found[column[n - 1]] == 0.0);
}

static void nothing_to_solve(void) {
  double LU[4] = {0.0}, b[2] = {1.0, 1.0}, x[2] = {5.0, 5.0};
  int row[2], column[2];
  CHECK(bm_factor(2, 1e-10, LU, row, column) == 0);
  bm_solve(2, 0, LU, row, column, b, x);
  CHECK(x[0] == 0.0 && x[1] == 0.0);
}

int main(void) {
  products();
  solutions();
  lesser_rank();
  nothing_to_solve();
  return failures != 0;
}
