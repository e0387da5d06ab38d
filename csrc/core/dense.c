#include "dense.h"

#include <math.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "clones.h"

static SUNLinearSolverContent_Dense content_of(SUNLinearSolver solver) {
  return (SUNLinearSolverContent_Dense)solver->content;
}

/* y -= a x */
BS_CLONES static void subtract_scaled(sunindextype n, double a,
                                      const double *restrict x,
                                      double *restrict y) {
  for (sunindextype i = 0; i < n; i++) {
    y[i] -= a * x[i];
  }
}

static sunindextype largest_below(const double *column, sunindextype k,
                                  sunindextype n) {
  sunindextype best = k;
  for (sunindextype i = k + 1; i < n; i++) {
    if (fabs(column[i]) > fabs(column[best])) {
      best = i;
    }
  }
  return best;
}

static void swap_rows(double **column, sunindextype n, sunindextype a,
                      sunindextype b) {
  for (sunindextype j = 0; j < n && a != b; j++) {
    const double kept = column[j][a];
    column[j][a] = column[j][b];
    column[j][b] = kept;
  }
}

/* A = P L U in place, L with unit diagonal. Returns 0, or the number of the
 * column without a pivot, from 1, which CVODE takes for a reason to retry. */
static int setup(SUNLinearSolver solver, SUNMatrix A) {
  SUNLinearSolverContent_Dense content = content_of(solver);
  const sunindextype n = SUNDenseMatrix_Rows(A);
  double **column = SUNDenseMatrix_Cols(A);
  content->last_flag = 0;
  for (sunindextype k = 0; k < n; k++) {
    const sunindextype pivot = largest_below(column[k], k, n);
    content->pivots[k] = pivot;
    if (!(fabs(column[k][pivot]) > 0.0)) {
      content->last_flag = k + 1;
      return (int)(k + 1);
    }
    swap_rows(column, n, k, pivot);
    const double inverse = 1.0 / column[k][k];
    for (sunindextype i = k + 1; i < n; i++) {
      column[k][i] *= inverse;
    }
    for (sunindextype j = k + 1; j < n; j++) {
      subtract_scaled(n - k - 1, column[j][k], column[k] + k + 1,
                      column[j] + k + 1);
    }
  }
  return 0;
}

static int solve(SUNLinearSolver solver, SUNMatrix A, N_Vector x, N_Vector b,
                 sunrealtype tolerance) {
  const sunindextype n = SUNDenseMatrix_Rows(A);
  double **column = SUNDenseMatrix_Cols(A);
  double *y = N_VGetArrayPointer(x);
  (void)tolerance;
  N_VScale(1.0, b, x);
  for (sunindextype k = 0; k < n; k++) {
    const sunindextype pivot = content_of(solver)->pivots[k];
    const double kept = y[k];
    y[k] = y[pivot];
    y[pivot] = kept;
  }
  for (sunindextype k = 0; k < n; k++) {
    subtract_scaled(n - k - 1, y[k], column[k] + k + 1, y + k + 1);
  }
  for (sunindextype k = n - 1; k >= 0; k--) {
    y[k] /= column[k][k];
    subtract_scaled(k, y[k], column[k], y);
  }
  return 0;
}

void bs_dense_speed_up(SUNLinearSolver solver) {
  solver->ops->setup = setup;
  solver->ops->solve = solve;
}
