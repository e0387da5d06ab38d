/* A walk at given times, and its Fourier integrals in closed form. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clones.h"
#include "phases.h"

/* Friction torque in a state of the flow, tau after the phase's start. */
static double torque_of(const bm_flow *flow, const bm_phases *phases,
                        const bm_stretch *at, double tau, const double *x) {
  switch (phases->role) {
    case BM_FREE: return at->load;
    case BM_BAND: return phases->slope * x[flow->N / 2 + phases->joint];
    default: return bm_flow_signal(flow, at->begin + tau, at->load, x);
  }
}

bm_status bm_sample(const bm_flow *flow, const bm_walk *walk,
                    const bm_phases *phases, bm_samples *to) {
  int n = bm_coordinates(flow, phases);
  bm_watch watch;
  double *memory = calloc(4 * (size_t)n, sizeof(double));
  if (!memory || !bm_watch_create(&watch, flow)) {
    free(memory);
    return BM_NO_MEMORY;
  }
  double *x = memory + 2 * n;
  bm_stretch at = {.rest = memory};
  int64_t i = 0;
  while (bm_next_stretch(walk, phases, n, flow->Omega, &at)) {
    int last = at.next > walk->events.count; /* it takes what is left */
    for (; i < to->count && to->t[i] < at.start; i++) {
    }
    if (i < to->count && (last || to->t[i] < at.end)) {
      bm_watch_begin(&watch, at.begin, at.load, at.x);
    }
    for (; i < to->count && (last || to->t[i] < at.end); i++) {
      double tau = to->t[i] - at.start;
      bm_watch_state(&watch, at.begin, at.load, tau, x);
      bm_whole_state(phases, &at, n, x, to->x + (size_t)i * 2 * (size_t)n);
      to->torque[i] = torque_of(flow, phases, &at, tau, x);
    }
  }
  bm_watch_free(&watch);
  free(memory);
  return BM_OK;
}

/* xr (N) += p vr - q vi, xi (N) += r vr + s vi */
BM_CLONES static void add_vectors(int N, double p, double q, double r, double s,
                                  const double *restrict vr,
                                  const double *restrict vi,
                                  double *restrict xr, double *restrict xi) {
  for (int j = 0; j < N; j++) {
    xr[j] += p * vr[j] - q * vi[j];
    xi[j] += r * vr[j] + s * vi[j];
  }
}

/* One order of the Fourier integrals of one stretch. */
typedef struct {
  int N;
  double d;         /* length of the stretch                            */
  double k, er, ei; /* order times Omega, and exp(-i k d)                */
  double *re, *im;  /* the integral of the state so far (N)             */
} order;

/* Adds the integral of Re(V z exp(mu tau)) exp(-i k tau), `growth` = exp(mu d):
 * with I of mu - ik and J of mu* - ik it is (V z I + V* z* J)/2. */
static void add_exponential(order *it, const double mu[2],
                            const double growth[2], const double z[2],
                            const double *V_re, const double *V_im) {
  double Ir, Ii, Jr, Ji;
  bm_integral(mu[0], mu[1] - it->k, it->d,
              growth[0] * it->er - growth[1] * it->ei,
              growth[0] * it->ei + growth[1] * it->er, &Ir, &Ii);
  bm_integral(mu[0], -mu[1] - it->k, it->d,
              growth[0] * it->er + growth[1] * it->ei,
              growth[0] * it->ei - growth[1] * it->er, &Jr, &Ji);
  double cr = 0.5 * (z[0] * Ir - z[1] * Ii), ci = 0.5 * (z[0] * Ii + z[1] * Ir);
  double er = 0.5 * (z[0] * Jr + z[1] * Ji), ei = 0.5 * (z[0] * Ji - z[1] * Jr);
  add_vectors(it->N, cr + er, ci - ei, ci + ei, cr - er, V_re, V_im, it->re,
              it->im);
}

/* Exponentials of a stretch: modes, then harmonics; coefficients where it
 * begins and growth over it. */
typedef struct {
  int L;
  double (*mu)[2], (*growth)[2], (*z)[2];
} exponentials;

static void turn(double re, double angle, double z[2]) {
  z[0] = exp(re) * cos(angle);
  z[1] = exp(re) * sin(angle);
}

static void begin(const bm_flow *flow, const bm_watch *watch,
                  const bm_stretch *at, exponentials *of) {
  double d = at->to - at->from;
  for (int l = 0; l < of->L; l++) {
    int h = l - flow->m;
    double *mu = of->mu[l], *z = of->z[l], now[2];
    mu[0] = h < 0 ? flow->lambda_re[l] : 0.0;
    mu[1] = h < 0 ? flow->lambda_im[l] : h * flow->Omega;
    turn(mu[0] * d, mu[1] * d, of->growth[l]);
    if (h < 0) {
      turn(mu[0] * at->from, mu[1] * at->from, now);
      z[0] = watch->ar[l] * now[0] - watch->ai[l] * now[1];
      z[1] = watch->ar[l] * now[1] + watch->ai[l] * now[0];
    } else {
      turn(0.0, mu[1] * (at->begin + at->from), z);
    }
  }
}

/* Integral of the friction torque, from that of the state and of the load. */
static void add_torque(const bm_flow *flow, const bm_phases *phases,
                       const order *it, const exponentials *of,
                       const double load[2], double torque[2]) {
  if (phases->role == BM_FREE) {
    torque[0] = load[0];
    torque[1] = load[1];
    return;
  }
  if (phases->role == BM_BAND) {
    int v = flow->N / 2 + phases->joint;
    torque[0] = phases->slope * it->re[v];
    torque[1] = phases->slope * it->im[v];
    return;
  }
  order direct = *it;
  direct.N = 1;
  direct.re = &torque[0];
  direct.im = &torque[1];
  torque[0] = flow->d_c * load[0];
  torque[1] = flow->d_c * load[1];
  for (int h = 0; h <= flow->H; h++) {
    int l = flow->m + h;
    add_exponential(&direct, of->mu[l], of->growth[l], of->z[l], flow->D_re + h,
                    flow->D_im + h);
  }
  for (int j = 0; j < flow->N; j++) {
    torque[0] += flow->row[j] * it->re[j];
    torque[1] += flow->row[j] * it->im[j];
  }
}

/* One order of one stretch, into a row of the result. `whole` is scratch (4n).
 */
static void add_order(const bm_flow *flow, const bm_phases *phases,
                      const bm_stretch *at, const exponentials *of, order *it,
                      int n, double *whole, double *row) {
  double load[2], torque[2], now[2], size = 2.0 * n;
  memset(it->re, 0, 2 * (size_t)it->N * sizeof(double));
  bm_integral(0.0, -it->k, it->d, it->er, it->ei, &load[0], &load[1]);
  load[0] *= at->load;
  load[1] *= at->load;
  for (int l = 0; l < of->L; l++) {
    int h = l - flow->m;
    const double *V_re = h < 0 ? flow->V_re + (size_t)l * (size_t)it->N
                               : flow->P_re + (size_t)h * (size_t)it->N;
    const double *V_im = h < 0 ? flow->V_im + (size_t)l * (size_t)it->N
                               : flow->P_im + (size_t)h * (size_t)it->N;
    add_exponential(it, of->mu[l], of->growth[l], of->z[l], V_re, V_im);
  }
  for (int j = 0; j < it->N; j++) {
    it->re[j] += load[0] * flow->X_c[j];
    it->im[j] += load[1] * flow->X_c[j];
  }
  add_torque(flow, phases, it, of, load, torque);
  bm_stretch part = *at; /* the held joint's share is that of the load */
  part.load = load[0];
  bm_whole_state(phases, &part, n, it->re, whole);
  part.load = load[1];
  bm_whole_state(phases, &part, n, it->im, whole + 2 * n);
  turn(0.0, -it->k * (at->begin + at->from), now);
  for (int j = 0; j <= 2 * n; j++) {
    double re = j < size ? whole[j] : torque[0];
    double im = j < size ? whole[2 * n + j] : torque[1];
    row[2 * j] += re * now[0] - im * now[1];
    row[2 * j + 1] += re * now[1] + im * now[0];
  }
}

bm_status bm_fourier(const bm_flow *flow, const bm_walk *walk,
                     const bm_phases *phases, bm_coefficients *to) {
  int n = bm_coordinates(flow, phases), L = flow->m + flow->H + 1;
  size_t wide = 2 * (size_t)n;
  bm_watch watch;
  double *memory = calloc(5 * wide + 6 * (size_t)L, sizeof(double));
  if (!memory || !bm_watch_create(&watch, flow)) {
    free(memory);
    return BM_NO_MEMORY;
  }
  order it = {.N = flow->N, .re = memory, .im = memory + flow->N};
  double *whole = memory + 2 * wide;
  exponentials of = {.L = L, .mu = (double (*)[2])(whole + 2 * wide)};
  of.growth = of.mu + L;
  of.z = of.growth + L;
  bm_stretch at = {.rest = (double *)(of.z + L)};
  while (bm_next_stretch(walk, phases, n, flow->Omega, &at)) {
    bm_watch_begin(&watch, at.begin, at.load, at.x);
    begin(flow, &watch, &at, &of);
    it.d = at.to - at.from;
    for (int i = 0; i < to->count; i++) {
      double growth[2];
      it.k = (to->first + i * to->step) * flow->Omega;
      turn(0.0, -it.k * it.d, growth);
      it.er = growth[0];
      it.ei = growth[1];
      add_order(flow, phases, &at, &of, &it, n, whole,
                to->values + (size_t)i * 2 * (wide + 1));
    }
  }
  bm_watch_free(&watch);
  free(memory);
  return BM_OK;
}
