#include "flow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* x += sign Re sum_h P_h exp(i h Omega time) + sign X_c c */
static void add_forced(const bm_flow *flow, double time, double c, double sign,
                       double *x) {
  for (int h = 0; h <= flow->H; h++) {
    double cr = sign * cos(h * flow->Omega * time);
    double ci = sign * sin(h * flow->Omega * time);
    const double *pr = flow->P_re + h * flow->N, *pi = flow->P_im + h * flow->N;
    for (int j = 0; j < flow->N; j++) {
      x[j] += cr * pr[j] - ci * pi[j];
    }
  }
  for (int j = 0; j < flow->N; j++) {
    x[j] += sign * c * flow->X_c[j];
  }
}

static double dot(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int j = 0; j < n; j++) {
    sum += a[j] * b[j];
  }
  return sum;
}

int64_t bm_flow_reals(int N, int m, int H) {
  int64_t modal = 2 * (int64_t)m + 4 * (int64_t)m * N;
  int64_t forced = 2 * (int64_t)(H + 1) * N + 2 * (int64_t)(H + 1);
  return modal + forced + 2 * (int64_t)N + 1;
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
}

int bm_watch_create(bm_watch *watch, const bm_flow *flow) {
  int m = flow->m, H = flow->H, K = (m + H + 3) / 4 * 4;
  bm_signal *f = &watch->signal;
  size_t reals = (size_t)(6 * K + 3 * BM_LEVELS * K + 4 * m + 2 * (H + 1));
  watch->memory = calloc(reals ? reals : 1, sizeof(double));
  if (!watch->memory) {
    return 0;
  }
  double *next = watch->memory;
  double **parts[] = {&f->lr, &f->li, &f->wr, &f->wi, &f->pr, &f->pi};
  for (int i = 0; i < 6; i++, next += K) {
    *parts[i] = next;
  }
  double **tables[] = {&f->er, &f->ei, &f->bound};
  for (int i = 0; i < 3; i++, next += BM_LEVELS * K) {
    *tables[i] = next;
  }
  double **modal[] = {&watch->ar, &watch->ai, &watch->gr, &watch->gi};
  for (int i = 0; i < 4; i++, next += m) {
    *modal[i] = next;
  }
  watch->sr = next;
  watch->si = next + H + 1;
  watch->flow = flow;
  f->K = K;
  f->base = 0.25 * 6.283185307179586 / flow->Omega;
  for (int k = 0; k < m; k++) {
    f->lr[k] = flow->lambda_re[k];
    f->li[k] = flow->lambda_im[k];
    watch->gr[k] = dot(flow->row, flow->V_re + k * flow->N, flow->N);
    watch->gi[k] = dot(flow->row, flow->V_im + k * flow->N, flow->N);
  }
  for (int h = 0; h <= H; h++) {
    const double *pr = flow->P_re + h * flow->N, *pi = flow->P_im + h * flow->N;
    watch->sr[h] = flow->D_re[h] + dot(flow->row, pr, flow->N);
    watch->si[h] = flow->D_im[h] + dot(flow->row, pi, flow->N);
    if (h > 0) {
      f->li[m + h - 1] = h * flow->Omega;
    }
  }
  watch->s_c = flow->d_c + dot(flow->row, flow->X_c, flow->N);
  bm_signal_tabulate(f);
  return 1;
}

void bm_watch_free(bm_watch *watch) {
  free(watch->memory);
  watch->memory = NULL;
}

void bm_watch_begin(bm_watch *watch, double time, double c, const double *x) {
  const bm_flow *flow = watch->flow;
  bm_signal *f = &watch->signal;
  int m = flow->m, N = flow->N;
  double *ar = watch->ar, *ai = watch->ai;
  double rest[N > 0 ? N : 1];
  memcpy(rest, x, (size_t)N * sizeof(double));
  add_forced(flow, time, c, -1.0, rest);
  memset(ar, 0, (size_t)m * sizeof(double));
  memset(ai, 0, (size_t)m * sizeof(double));
  for (int j = 0; j < N; j++) {
    const double *wr = flow->W_re + j * m, *wi = flow->W_im + j * m;
    for (int k = 0; k < m; k++) {
      ar[k] += wr[k] * rest[j];
      ai[k] += wi[k] * rest[j];
    }
  }
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
    const double *vr = flow->V_re + k * N, *vi = flow->V_im + k * N;
    for (int j = 0; j < N; j++) {
      x[j] += br * vr[j] - bi * vi[j];
    }
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
