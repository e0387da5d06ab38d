/* A flow in its modes, from the matrices of its system.
 *
 *   M q'' + D q' + K q = Re sum_h F_h exp(i h Omega t) + load c
 *
 * Matrices that LAPACK reads are stored by columns.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flow.h"

typedef struct {
  const bm_lapack *lapack;
  const bm_system *of;
  int k, N, m;
  double *A, *V, *solved; /* (N, N)                                          */
  double *wr, *wi;        /* exponents, pairs next to each other (N)         */
  double *Z, *q;          /* complex: (k, k) and (k)                         */
  double *work;           /* of dgeev                                        */
  int room, *pivots;
  bm_flow flow;
} modes;

/* solved := A^-1 solved; A is overwritten. 0 when A is singular. */
static int solve(modes *it, int n, int columns, double *A, double *solved) {
  int info = 0;
  if (n > 0) {
    it->lapack->dgesv(&n, &columns, A, &n, it->pivots, solved, &n, &info);
  }
  return info == 0;
}

static void identity(int n, double *A) {
  memset(A, 0, (size_t)n * (size_t)n * sizeof(double));
  for (int i = 0; i < n; i++) {
    A[(size_t)i * n + i] = 1.0;
  }
}

static int eigen(modes *it, double *work, int room) {
  int N = it->N, one = 1, info = 0;
  char no = 'N', yes = 'V';
  double none;
  it->lapack->dgeev(&no, &yes, &N, it->A, &N, it->wr, it->wi, &none, &one,
                    it->V, &N, work, &room, &info);
  return info == 0;
}

static int create(modes *it) {
  size_t N = (size_t)it->N, k = (size_t)it->k;
  double best = 0.0;
  it->room = 1;
  if (N > 0) {
    eigen(it, &best, -1); /* asks for its best workspace */
    it->room = (int)best;
  }
  it->pivots = calloc(N + 1, sizeof(int));
  it->A = calloc(3 * N * N + 2 * N + 2 * k * k + 2 * k + (size_t)it->room,
                 sizeof(double));
  if (!it->pivots || !it->A) {
    return 0;
  }
  it->V = it->A + N * N;
  it->solved = it->V + N * N;
  it->wr = it->solved + N * N;
  it->wi = it->wr + N;
  it->Z = it->wi + N;
  it->q = it->Z + 2 * k * k;
  it->work = it->q + 2 * k;
  return 1;
}

/* A of x' = A x, x = (q, q'). 0 when M is singular. */
static int first_order(modes *it) {
  int k = it->k, N = it->N;
  const bm_system *of = it->of;
  double *right = it->V, *M = it->solved;
  memcpy(M, of->M, (size_t)k * (size_t)k * sizeof(double));
  for (int i = 0; i < k; i++) {
    for (int j = 0; j < k; j++) {
      right[i + (size_t)k * j] = of->K[(size_t)i * k + j];
      right[i + (size_t)k * (k + j)] = of->D[(size_t)i * k + j];
    }
  }
  if (!solve(it, k, N, M, right)) {
    return 0;
  }
  memset(it->A, 0, (size_t)N * (size_t)N * sizeof(double));
  for (int j = 0; j < N; j++) {
    if (j >= k) {
      it->A[j - k + (size_t)N * j] = 1.0;
    }
    for (int i = 0; i < k; i++) {
      it->A[k + i + (size_t)N * j] = -right[i + (size_t)k * j];
    }
  }
  return 1;
}

/* One of each pair, twice: the other one is its conjugate. */
static void take_modes(modes *it, double *packed) {
  const bm_system *of = it->of;
  int N = it->N, a = 0;
  for (int j = 0; j < N; j++) {
    it->m += it->wi[j] >= 0.0;
  }
  bm_flow_unpack(&it->flow, packed, N, it->m, of->H, of->Omega);
  double *lr = (double *)it->flow.lambda_re, *li = (double *)it->flow.lambda_im;
  double *V_re = (double *)it->flow.V_re, *V_im = (double *)it->flow.V_im;
  for (int j = 0; j < N; j++) {
    if (it->wi[j] < 0.0) {
      continue;
    }
    int pair = it->wi[j] > 0.0;
    const double *re = it->V + (size_t)j * N, *im = re + N;
    lr[a] = it->wr[j];
    li[a] = it->wi[j];
    for (int i = 0; i < N; i++) {
      V_re[(size_t)a * N + i] = pair ? 2.0 * re[i] : re[i];
      V_im[(size_t)a * N + i] = pair ? 2.0 * im[i] : 0.0;
    }
    a++;
  }
}

/* W, by way of real amplitudes. 0 when eigenvectors coincide. */
static int invert_modes(modes *it) {
  int N = it->N, m = it->m, column = 0;
  const bm_flow *flow = &it->flow;
  double *W_re = (double *)flow->W_re, *W_im = (double *)flow->W_im;
  for (int a = 0; a < m; a++) {
    memcpy(it->A + (size_t)N * column, flow->V_re + (size_t)a * N,
           (size_t)N * sizeof(double));
    column++;
    for (int i = 0; i < N && flow->lambda_im[a] != 0.0; i++) {
      it->A[i + (size_t)N * column] = -flow->V_im[(size_t)a * N + i];
    }
    column += flow->lambda_im[a] != 0.0;
  }
  identity(N, it->solved);
  if (column != N || !solve(it, N, N, it->A, it->solved)) {
    return 0;
  }
  for (int a = 0, c = 0; a < m; a++) {
    int pair = flow->lambda_im[a] != 0.0;
    for (int j = 0; j < N; j++) {
      W_re[(size_t)j * m + a] = it->solved[c + (size_t)N * j];
      W_im[(size_t)j * m + a] = pair ? it->solved[c + 1 + (size_t)N * j] : 0.0;
    }
    c += 1 + pair;
  }
  return 1;
}

/* Worst condition number of an eigenvalue, the state scaled to about the root
 * of its energy. */
static double condition_of(const modes *it) {
  const bm_system *of = it->of;
  const bm_flow *flow = &it->flow;
  int k = it->k, N = it->N, m = it->m;
  double worst = N > 0 ? 0.0 : 1.0;
  for (int a = 0; a < m; a++) {
    double right = 0.0, left = 0.0;
    for (int i = 0; i < N; i++) {
      size_t d = (size_t)(i % k) * (size_t)(k + 1);
      size_t v = (size_t)a * N + i, w = (size_t)i * m + a;
      double scale = of->M[d];
      if (i < k) {
        scale = fmax(fabs(of->K[d]), of->Omega * of->Omega * scale);
      }
      right += scale *
               (flow->V_re[v] * flow->V_re[v] + flow->V_im[v] * flow->V_im[v]);
      left += (flow->W_re[w] * flow->W_re[w] + flow->W_im[w] * flow->W_im[w]) /
              scale;
    }
    double both = sqrt(right) * sqrt(left);
    both *= flow->lambda_im[a] != 0.0 ? 0.5 : 1.0;
    if (!(both <= worst)) { /* NaN counts as worst */
      worst = both;
    }
  }
  return worst == worst ? worst : HUGE_VAL;
}

static double column_norm(int n, const double *A) {
  double most = 0.0;
  for (int j = 0; j < n; j++) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
      sum += fabs(A[(size_t)j * n + i]);
    }
    most = fmax(most, sum);
  }
  return most;
}

/* Response to a unit constant load; infinite when K is singular. Returns the
 * condition of K. */
static double constant_response(modes *it) {
  const bm_system *of = it->of;
  int k = it->k;
  double *X_c = (double *)it->flow.X_c, *inverse = it->solved;
  size_t bytes = (size_t)k * (size_t)k * sizeof(double);
  memset(X_c, 0, (size_t)it->N * sizeof(double));
  memcpy(it->A, of->K, bytes); /* symmetric: rows are columns */
  identity(k, inverse);
  if (!solve(it, k, k, it->A, inverse)) {
    for (int i = 0; i < k; i++) {
      X_c[i] = HUGE_VAL;
    }
    return HUGE_VAL;
  }
  for (int j = 0; j < k; j++) {
    for (int i = 0; i < k; i++) {
      X_c[i] += inverse[i + (size_t)k * j] * of->load[j];
    }
  }
  return column_norm(k, of->K) * column_norm(k, inverse);
}

/* Response to harmonic h of the forcing; infinite when nothing limits it. */
static void harmonic_response(modes *it, int h) {
  const bm_system *of = it->of;
  int k = it->k, one = 1, info = 0, active = 0;
  double w = h * of->Omega;
  double *re = (double *)it->flow.P_re + (size_t)h * it->N;
  double *im = (double *)it->flow.P_im + (size_t)h * it->N;
  const double *force = of->F + 2 * (size_t)h * k;
  memcpy(it->q, force, 2 * (size_t)k * sizeof(double));
  for (int i = 0; i < 2 * k; i++) {
    active |= force[i] != 0.0;
  }
  if (active) {
    for (int j = 0; j < k; j++) {
      for (int i = 0; i < k; i++) {
        size_t from = (size_t)i * k + j, to = 2 * (i + (size_t)k * j);
        it->Z[to] = of->K[from] - w * w * of->M[from];
        it->Z[to + 1] = w * of->D[from];
      }
    }
    it->lapack->zgesv(&k, &one, it->Z, &k, it->pivots, it->q, &k, &info);
  }
  for (int i = 0; i < k; i++) {
    double qr = info ? HUGE_VAL : it->q[2 * i], qi = it->q[2 * i + 1];
    re[i] = qr;
    im[i] = qi;
    re[k + i] = -w * qi;
    im[k + i] = w * qr;
  }
}

/* Least distance of an exponent from a harmonic of the forcing, over Omega.
 * Slow modes of a sound K are creep, as in a narrow band, and no resonance with
 * the mean. */
static double nearest(const modes *it, int first) {
  double Omega = it->of->Omega, least = HUGE_VAL;
  for (int a = 0; a < it->m; a++) {
    for (int h = first; h <= it->of->H; h++) {
      double gap =
          hypot(it->flow.lambda_re[a], it->flow.lambda_im[a] - h * Omega);
      least = fmin(least, gap / Omega);
    }
  }
  return least;
}

static void copy_signal(modes *it) {
  const bm_system *of = it->of;
  memcpy((double *)it->flow.row, of->row, (size_t)it->N * sizeof(double));
  double *D_re = (double *)it->flow.D_re, *D_im = (double *)it->flow.D_im;
  for (int h = 0; h <= of->H; h++) {
    D_re[h] = of->direct[2 * h];
    D_im[h] = of->direct[2 * h + 1];
  }
  D_im[of->H + 1] = of->d_c; /* the last input of a packed flow */
}

static bm_status fill(modes *it, double *packed, bm_soundness *sound) {
  if (!first_order(it) || (it->N > 0 && !eigen(it, it->work, it->room))) {
    return BM_NO_MODES;
  }
  take_modes(it, packed);
  sound->condition = invert_modes(it) ? condition_of(it) : HUGE_VAL;
  sound->stiffness = constant_response(it);
  for (int h = 0; h <= it->of->H; h++) {
    harmonic_response(it, h);
  }
  sound->nearest_mean = nearest(it, 0);
  sound->nearest = nearest(it, 1);
  copy_signal(it);
  bm_flow_prepare(packed, it->N, it->m, it->of->H, it->of->Omega);
  return BM_OK;
}

bm_status bm_modes(const bm_lapack *lapack, const bm_system *of, double *packed,
                   int *m, bm_soundness *sound) {
  modes it = {.lapack = lapack, .of = of, .k = of->k, .N = 2 * of->k};
  bm_status status = BM_NO_MEMORY;
  if (create(&it)) {
    status = fill(&it, packed, sound);
  }
  *m = it.m;
  free(it.A);
  free(it.pivots);
  return status;
}
