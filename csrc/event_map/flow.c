#include "flow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cells.h"
#include "clones.h"

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

/* Reals in the extended state of a flow in cells. */
static int extended(int N, int H) {
  return N + 2 + 2 * H;
}

int64_t bm_flow_inputs(int N, int m, int H) {
  if (m == BM_CELLS) {
    int64_t Na = extended(N, H);
    return 2 * (int64_t)N * N + 2 * Na * Na + BM_TERMS * Na + N +
           2 * (int64_t)(H + 1) + 2;
  }
  int64_t modal = 2 * (int64_t)m + 4 * (int64_t)m * N;
  int64_t forced = 2 * (int64_t)(H + 1) * N + 2 * (int64_t)(H + 1);
  return modal + forced + 2 * (int64_t)N + 1;
}

/* Exponentials of the signal, filled up to a multiple of four. */
static int exponentials(int m, int H) {
  return (m + H + 3) / 4 * 4;
}

/* The tables of a prepared flow. */
typedef struct {
  double *lr, *li, *er, *ei, *bound, *gr, *gi, *sr, *si, *rest;
} table_parts;

static table_parts parts_of(double *tables, int m, int H) {
  int K = exponentials(m, H);
  int sizes[] = {K, K, BM_LEVELS * K, BM_LEVELS * K, BM_LEVELS * K,
                 m, m, H + 1,         H + 1,         2};
  table_parts parts;
  double **each[] = {&parts.lr, &parts.li, &parts.er, &parts.ei, &parts.bound,
                     &parts.gr, &parts.gi, &parts.sr, &parts.si, &parts.rest};
  for (int i = 0; i < 10; tables += sizes[i++]) {
    *each[i] = tables;
  }
  return parts;
}

int64_t bm_flow_reals(int N, int m, int H) {
  if (m == BM_CELLS) {
    return bm_flow_inputs(N, m, H);
  }
  int64_t K = exponentials(m, H);
  return bm_flow_inputs(N, m, H) + (2 + 3 * BM_LEVELS) * K + 2 * (int64_t)m +
         2 * (int64_t)(H + 1) + 2;
}

static void unpack_cells(bm_flow *flow, const double *packed, int N, int H) {
  int Na = extended(N, H);
  bm_cells *cells = &flow->cells;
  const double **parts[] = {&cells->into, &cells->out,  &cells->A,
                            &cells->E,    &cells->rows, &flow->row,
                            &flow->D_re,  &flow->D_im};
  int sizes[] = {N * N,         N * N, Na * Na, Na * Na,
                 BM_TERMS * Na, N,     H + 1,   H + 1};
  for (int i = 0; i < 8; packed += sizes[i++]) {
    *parts[i] = packed;
  }
  flow->d_c = packed[0];
  cells->d = packed[1];
}

void bm_flow_unpack(bm_flow *flow, const double *packed, int N, int m, int H,
                    double Omega) {
  flow->N = N;
  flow->m = m;
  flow->H = H;
  flow->Omega = Omega;
  if (m == BM_CELLS) {
    unpack_cells(flow, packed, N, H);
    return;
  }
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
  flow->d_c = *packed;
  flow->tables = packed + 1;
}

int bm_flow_amplitudes(const bm_flow *flow) {
  int count = flow->m == BM_CELLS ? flow->N : 0;
  for (int k = 0; k < flow->m; k++) {
    count += flow->lambda_im[k] != 0.0 ? 2 : 1;
  }
  return count;
}

static double base_of(double Omega) {
  return 0.25 * 6.283185307179586 / Omega;
}

void bm_flow_prepare(double *packed, int N, int m, int H, double Omega) {
  bm_flow flow;
  if (m == BM_CELLS) {
    return;
  }
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

/* The signal of a flow in cells: wr and pr hold extended states, pi scratch. */
static int create_cells(bm_watch *watch, const bm_flow *flow) {
  bm_signal *f = &watch->signal;
  int Na = extended(flow->N, flow->H);
  watch->memory = calloc((size_t)Na * 5, sizeof(double));
  if (!watch->memory) {
    return 0;
  }
  f->cells = &flow->cells;
  f->K = Na;
  f->base = flow->cells.d;
  f->offset = 0.0;
  f->series_level = 0;
  f->wr = watch->memory;
  f->pr = f->wr + Na;
  f->pi = f->pr + Na;
  watch->ar = f->pi + 2 * Na;
  watch->flow = flow;
  return 1;
}

int bm_watch_create(bm_watch *watch, const bm_flow *flow) {
  if (flow->m == BM_CELLS) {
    return create_cells(watch, flow);
  }
  int m = flow->m, H = flow->H, K = exponentials(m, H);
  bm_signal *f = &watch->signal;
  watch->memory = calloc((size_t)(4 * K + 2 * m + flow->N + 1), sizeof(double));
  if (!watch->memory) {
    return 0;
  }
  table_parts t = parts_of((double *)flow->tables, m, H);
  f->cells = NULL;
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

static void begin_cells(bm_watch *watch, double time, double c,
                        const double *x) {
  const bm_flow *flow = watch->flow;
  int N = flow->N, H = flow->H;
  double *y = watch->ar;
  bm_cells_apply(N, N, flow->cells.into, x, y);
  y[N] = 1.0;
  y[N + 1] = c;
  for (int h = 1; h <= H; h++) {
    y[N + 1 + h] = cos(h * flow->Omega * time);
    y[N + 1 + H + h] = sin(h * flow->Omega * time);
  }
  memcpy(watch->signal.wr, y, (size_t)watch->signal.K * sizeof(double));
}

/* Whole cells by the table, the rest by series. Uses the signal's scratch: the
 * phase has ended. */
static void state_of_cells(const bm_watch *watch, double tau, double *x) {
  const bm_flow *flow = watch->flow;
  const bm_signal *f = &watch->signal;
  double *now = f->wr, *next = f->pr, whole = floor(tau / f->base);
  memcpy(now, watch->ar, (size_t)f->K * sizeof(double));
  for (double i = 0.0; i < whole; i += 1.0) {
    bm_cells_advance(&flow->cells, f->K, 1.0, now, next, f->pi);
    double *hold = now;
    now = next;
    next = hold;
  }
  double u = tau / f->base - whole;
  bm_cells_advance(&flow->cells, f->K, u < 1.0 ? u : 0.0, now, next, f->pi);
  bm_cells_apply(flow->N, flow->N, flow->cells.out, next, x);
}

void bm_watch_begin(bm_watch *watch, double time, double c, const double *x) {
  const bm_flow *flow = watch->flow;
  bm_signal *f = &watch->signal;
  if (f->cells) {
    begin_cells(watch, time, c, x);
    return;
  }
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
  if (watch->signal.cells) {
    state_of_cells(watch, tau, x);
    return;
  }
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

void bm_without_joint(int n, int joint, const double *x, double *rest) {
  for (int j = 0, k = 0; j < 2 * n; j++) {
    if (j != joint && j != n + joint) {
      rest[k++] = x[j];
    }
  }
}
