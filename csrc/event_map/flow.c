#include "flow.h"

#include "clones.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* x (N) += br vr - bi vi */
BM_CLONES static void out_of_mode(int N, double br, double bi,
                                  const double *restrict vr,
                                  const double *restrict vi,
                                  double *restrict x) {
  for (int j = 0; j < N; j++) {
    x[j] += br * vr[j] - bi * vi[j];
  }
}

/* x += sign Re sum_h P_h exp(i h Omega time) + sign X_c c */
static void add_forced(const bm_flow *flow, double time, double c, double sign,
                       double *x) {
  int N = flow->N;
  for (int j = 0; j < N; j++) {
    x[j] += sign * flow->P_re[j];
  }
  for (int h = 1; h <= flow->H; h++) {
    double cr = sign * cos(h * flow->Omega * time);
    double ci = sign * sin(h * flow->Omega * time);
    out_of_mode(N, cr, ci, flow->P_re + h * N, flow->P_im + h * N, x);
  }
  if (c != 0.0) {
    for (int j = 0; j < N; j++) {
      x[j] += sign * c * flow->X_c[j];
    }
  }
}

static double dot(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int j = 0; j < n; j++) {
    sum += a[j] * b[j];
  }
  return sum;
}

int64_t bm_flow_inputs(int N, int m, int H) {
  int64_t modal = 2 * (int64_t)m + 4 * (int64_t)m * N;
  int64_t forced = 2 * (int64_t)(H + 1) * N + 2 * (int64_t)(H + 1);
  return modal + forced + 2 * (int64_t)N + 1;
}

/* Exponentials of the signal, filled up to a multiple of four. */
static int exponentials(int m, int H) { return (m + H + 3) / 4 * 4; }

/* The tables of a prepared flow. */
typedef struct {
  double *lr, *li, *er, *ei, *bound, *gr, *gi, *sr, *si, *rest;
} table_parts;

static table_parts parts_of(double *tables, int m, int H) {
  int K = exponentials(m, H);
  int sizes[] = {K, K, BM_LEVELS * K, BM_LEVELS * K, BM_LEVELS * K,
                 m, m, H + 1, H + 1, 2};
  table_parts parts;
  double **each[] = {&parts.lr, &parts.li, &parts.er, &parts.ei, &parts.bound,
                     &parts.gr, &parts.gi, &parts.sr, &parts.si, &parts.rest};
  for (int i = 0; i < 10; tables += sizes[i++]) {
    *each[i] = tables;
  }
  return parts;
}

int64_t bm_flow_reals(int N, int m, int H) {
  int64_t K = exponentials(m, H);
  return bm_flow_inputs(N, m, H) + (2 + 3 * BM_LEVELS) * K + 2 * (int64_t)m +
         2 * (int64_t)(H + 1) + 2;
}

void bm_flow_unpack(bm_flow *flow, const double *packed, int N, int m, int H,
                    double Omega) {
  const double **parts[] = {&flow->lambda_re, &flow->lambda_im, &flow->V_re,
                            &flow->V_im,      &flow->W_re,      &flow->W_im,
                            &flow->P_re,      &flow->P_im,      &flow->X_c,
                            &flow->row,       &flow->D_re,      &flow->D_im};
  int modal = m * N, forced = (H + 1) * N;
  int sizes[] = {m,      m,      modal, modal, modal, modal,
                 forced, forced, N,     N,     H + 1, H + 1};
  for (int i = 0; i < 12; packed += sizes[i++]) {
    *parts[i] = packed;
  }
  flow->N = N;
  flow->m = m;
  flow->H = H;
  flow->Omega = Omega;
  flow->d_c = *packed;
  flow->tables = packed + 1;
}

static double base_of(double Omega) { return 0.25 * 6.283185307179586 / Omega; }

void bm_flow_prepare(double *packed, int N, int m, int H, double Omega) {
  bm_flow flow;
  bm_flow_unpack(&flow, packed, N, m, H, Omega);
  int K = exponentials(m, H);
  table_parts t = parts_of(packed + bm_flow_inputs(N, m, H), m, H);
  memset(t.lr, 0, 2 * (size_t)K * sizeof(double));
  for (int k = 0; k < m; k++) {
    t.lr[k] = flow.lambda_re[k];
    t.li[k] = flow.lambda_im[k];
    t.gr[k] = dot(flow.row, flow.V_re + k * N, N);
    t.gi[k] = dot(flow.row, flow.V_im + k * N, N);
  }
  for (int h = 0; h <= H; h++) {
    t.sr[h] = flow.D_re[h] + dot(flow.row, flow.P_re + h * N, N);
    t.si[h] = flow.D_im[h] + dot(flow.row, flow.P_im + h * N, N);
    if (h > 0) {
      t.li[m + h - 1] = h * Omega;
    }
  }
  t.rest[0] = flow.d_c + dot(flow.row, flow.X_c, N);
  t.rest[1] = bm_signal_series_level(K, base_of(Omega), t.lr, t.li);
  bm_signal_tabulate(K, base_of(Omega), t.lr, t.li, t.er, t.ei, t.bound);
}

int bm_watch_create(bm_watch *watch, const bm_flow *flow) {
  int m = flow->m, H = flow->H, K = exponentials(m, H);
  bm_signal *f = &watch->signal;
  watch->memory = calloc((size_t)(4 * K + 2 * m + flow->N + 1), sizeof(double));
  if (!watch->memory) {
    return 0;
  }
  table_parts t = parts_of((double *)flow->tables, m, H);
  f->K = K;
  f->base = base_of(flow->Omega);
  f->series_level = (int)t.rest[1];
  f->lr = t.lr;
  f->li = t.li;
  f->er = t.er;
  f->ei = t.ei;
  f->bound = t.bound;
  f->wr = watch->memory;
  f->wi = f->wr + K;
  f->pr = f->wi + K;
  f->pi = f->pr + K;
  watch->ar = f->pi + K;
  watch->ai = watch->ar + m;
  watch->rest = watch->ai + m;
  watch->gr = t.gr;
  watch->gi = t.gi;
  watch->sr = t.sr;
  watch->si = t.si;
  watch->s_c = t.rest[0];
  watch->flow = flow;
  return 1;
}

void bm_watch_free(bm_watch *watch) {
  free(watch->memory);
  watch->memory = NULL;
}

/* (ar + i ai) (m) = W rest, W transposed (N, m) */
BM_CLONES static void into_modes(int N, int m, const double *restrict wr,
                                 const double *restrict wi,
                                 const double *restrict rest,
                                 double *restrict ar, double *restrict ai) {
  for (int k = 0; k < m; k++) {
    ar[k] = 0.0;
    ai[k] = 0.0;
  }
  for (int j = 0; j < N; j++, wr += m, wi += m) {
    double x = rest[j];
    for (int k = 0; k < m; k++) {
      ar[k] += wr[k] * x;
      ai[k] += wi[k] * x;
    }
  }
}

void bm_watch_begin(bm_watch *watch, double time, double c, const double *x) {
  const bm_flow *flow = watch->flow;
  bm_signal *f = &watch->signal;
  int m = flow->m, N = flow->N;
  double *ar = watch->ar, *ai = watch->ai, *rest = watch->rest;
  memcpy(rest, x, (size_t)N * sizeof(double));
  add_forced(flow, time, c, -1.0, rest);
  into_modes(N, m, flow->W_re, flow->W_im, rest, ar, ai);
  for (int k = 0; k < m; k++) {
    f->wr[k] = watch->gr[k] * ar[k] - watch->gi[k] * ai[k];
    f->wi[k] = watch->gr[k] * ai[k] + watch->gi[k] * ar[k];
  }
  f->offset = watch->sr[0] + watch->s_c * c;
  for (int h = 1; h <= flow->H; h++) {
    double cr = cos(h * flow->Omega * time), ci = sin(h * flow->Omega * time);
    f->wr[m + h - 1] = watch->sr[h] * cr - watch->si[h] * ci;
    f->wi[m + h - 1] = watch->sr[h] * ci + watch->si[h] * cr;
  }
  for (int k = m + flow->H; k < f->K; k++) {
    f->wr[k] = 0.0;
    f->wi[k] = 0.0;
  }
}

void bm_watch_state(const bm_watch *watch, double time, double c, double tau,
                    double *x) {
  const bm_flow *flow = watch->flow;
  int N = flow->N;
  memset(x, 0, (size_t)N * sizeof(double));
  add_forced(flow, time + tau, c, 1.0, x);
  for (int k = 0; k < flow->m; k++) {
    double growth = exp(flow->lambda_re[k] * tau);
    double er = growth * cos(flow->lambda_im[k] * tau);
    double ei = growth * sin(flow->lambda_im[k] * tau);
    double br = watch->ar[k] * er - watch->ai[k] * ei;
    double bi = watch->ar[k] * ei + watch->ai[k] * er;
    out_of_mode(N, br, bi, flow->V_re + k * N, flow->V_im + k * N, x);
  }
}

double bm_flow_signal(const bm_flow *flow, double time, double c,
                      const double *x) {
  double sum = dot(flow->row, x, flow->N) + flow->d_c * c;
  for (int h = 0; h <= flow->H; h++) {
    sum += flow->D_re[h] * cos(h * flow->Omega * time) -
           flow->D_im[h] * sin(h * flow->Omega * time);
  }
  return sum;
}
