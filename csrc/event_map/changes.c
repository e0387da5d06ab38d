/* How a small change of the state passes from one flow to the other.
 *
 * With x_r the state without the joint, a stop gives the others the joint's
 * momentum, x_r' += M_qq^-1 M_qt q_t', and a held place moves the held flow's
 * equilibrium by X_c.
 */
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "flow.h"

/* Indices of the state without the joint. */
static void rest_of(const bm_joint *joint, int n, int *rest) {
  int k = 0;
  for (int j = 0; j < 2 * n; j++) {
    if (j != joint->index && j != n + joint->index) {
      rest[k++] = j;
    }
  }
}

/* State to real amplitudes and back, (N, N) each. */
static void amplitudes(const bm_flow *flow, double *into, double *out) {
  int N = flow->N, m = flow->m, c = 0;
  for (int i = 0; i < N && m == BM_CELLS; i++) {
    for (int j = 0; j < N; j++) {
      into[(size_t)i * N + j] = flow->cells.into[(size_t)j * N + i];
      out[(size_t)i * N + j] = flow->cells.out[(size_t)j * N + i];
    }
  }
  for (int a = 0; a < m; a++) {
    int pair = flow->lambda_im[a] != 0.0;
    for (int j = 0; j < N; j++) {
      into[(size_t)c * N + j] = flow->W_re[(size_t)j * m + a];
      out[(size_t)j * N + c] = flow->V_re[(size_t)a * N + j];
      if (pair) {
        into[(size_t)(c + 1) * N + j] = flow->W_im[(size_t)j * m + a];
        out[(size_t)j * N + c + 1] = -flow->V_im[(size_t)a * N + j];
      }
    }
    c += 1 + pair;
  }
}

/* Columns or rows `rest` of free matrices, for products with held ones. */
typedef struct {
  double *into, *out; /* of the inner flow (Nh, Nh)      */
  double *columns;    /* into without the joint (N, Nh)  */
  double *rows;       /* out without the joint (Nh, N)   */
  double *vector;     /* scratch (N)                     */
  int *rest;
} scratch;

static void set_valued(const bm_flow *held, const bm_joint *joint, int n,
                       scratch *it, bm_changes *to) {
  int N = 2 * n, Nh = N - 2, k = n - 1;
  const double *X_c = held->m == BM_CELLS ? NULL : held->X_c;
  double *x = it->vector;
  rest_of(joint, n, it->rest);
  for (int r = 0; r < Nh; r++) {
    const double *out = to->out + (size_t)it->rest[r] * N;
    for (int c = 0; c < N; c++) {
      it->rows[(size_t)r * N + c] =
          out[c] - (X_c ? X_c[r] * to->place[c] : 0.0);
      it->columns[(size_t)c * Nh + r] = to->into[(size_t)c * N + it->rest[r]];
    }
  }
  bm_multiply(Nh, Nh, N, it->into, it->rows, (double *)to->stick);
  bm_multiply(N, Nh, Nh, it->columns, it->out, (double *)to->release);
  memset(x, 0, (size_t)N * sizeof(double));
  x[joint->index] = 1.0;
  for (int r = 0; r < Nh && X_c; r++) {
    x[it->rest[r]] = X_c[r];
  }
  bm_multiply(N, N, 1, to->into, x, (double *)to->position);
  memset(x, 0, (size_t)N * sizeof(double));
  for (int r = 0; r < k; r++) {
    x[k + r] = joint->m_t[r];
  }
  bm_multiply(Nh, Nh, 1, it->into, x, (double *)to->impact);
  memset(x, 0, (size_t)N * sizeof(double));
  memcpy(x + n, joint->push, (size_t)n * sizeof(double));
  bm_multiply(N, N, 1, to->into, x, (double *)to->push);
  memset(x, 0, (size_t)N * sizeof(double));
  x[n + joint->index] = 1.0;
  for (int r = 0; r < k; r++) {
    x[it->rest[k + r]] = -joint->m_t[r];
  }
  bm_multiply(N, N, 1, to->into, x, (double *)to->kick);
  bm_row_times(Nh, Nh, held->row, it->out, (double *)to->grip);
}

bm_status bm_changes_fill(const bm_flow *free_flow, const bm_flow *inner,
                          const bm_joint *joint, double *packed) {
  int N = free_flow->N, n = N / 2, Nh = inner->N;
  size_t wide = (size_t)N, held = (size_t)Nh;
  double *memory =
      calloc(2 * held * held + 2 * wide * held + wide + 1, sizeof(double));
  int *rest = calloc(wide, sizeof(int));
  if (!memory || !rest) {
    free(memory);
    free(rest);
    return BM_NO_MEMORY;
  }
  scratch it = {.into = memory, .rest = rest};
  it.out = it.into + held * held;
  it.columns = it.out + held * held;
  it.rows = it.columns + wide * held;
  it.vector = it.rows + wide * held;
  bm_changes to;
  bm_changes_unpack(&to, packed, n, Nh);
  memset(packed, 0, (size_t)bm_changes_reals(n, Nh) * sizeof(double));
  amplitudes(free_flow, (double *)to.into, (double *)to.out);
  amplitudes(inner, it.into, it.out);
  memcpy((double *)to.place, to.out + (size_t)joint->index * N,
         wide * sizeof(double));
  memcpy((double *)to.velocity, to.out + (size_t)(n + joint->index) * N,
         wide * sizeof(double));
  double *numbers = packed + bm_changes_reals(n, Nh) - 2;
  numbers[1] = 1.0;
  if (Nh == N) { /* the band: nothing jumps, and it holds the whole state */
    bm_multiply(N, N, N, it.into, to.out, (double *)to.stick);
    bm_multiply(N, N, N, to.into, it.out, (double *)to.release);
  } else {
    set_valued(inner, joint, n, &it, &to);
    numbers[0] = inner->d_c;
    for (int r = 0; r < Nh && inner->m != BM_CELLS; r++) {
      numbers[0] += inner->row[r] * inner->X_c[r];
    }
    numbers[1] = joint->mass;
  }
  free(memory);
  free(rest);
  return BM_OK;
}
