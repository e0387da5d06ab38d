/* Exact integrals over a walk: squares, work and losses.
 *
 * In a phase the state is x = R u(tau), u (2L) the real parts, then the
 * imaginary parts, of L = m + H + 2 exponentials: modes, harmonics from 0,
 * load. With the Gram matrix of u over all phases of one flow every quadratic
 * figure is a contraction. With u = Re z exp(mu tau) and, as its partner, -Im z
 * exp(mu tau),
 *
 *   I(s) = integral of exp(s tau),   T = z_k z_l I(mu_k + mu_l),
 *                                    T' = z_k z_l* I(mu_k + mu_l*),
 *
 *   Re Re:  Re(T + T')/2     Re(-Im): -Im(T - T')/2
 *   (-Im)(-Im): Re(T' - T)/2 (-Im) Re: -Im(T + T')/2 .
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "phases.h"

typedef struct {
  int L;
  double *mr, *mi; /* exponents (L)                                     */
  double *zr, *zi; /* coefficients at the start of the stretch          */
  double *er, *ei; /* exp(mu d)                                         */
} functions;

static void add_products(const functions *f, double d, double *gram) {
  int L = f->L, wide = 2 * L;
  for (int k = 0; k < L; k++) {
    double *re = gram + (size_t)k * wide, *im = gram + (size_t)(L + k) * wide;
    for (int l = k; l < L; l++) {
      double pr, pi, qr, qi;
      double rr = f->er[k] * f->er[l], ii = f->ei[k] * f->ei[l];
      double ri = f->er[k] * f->ei[l], ir = f->ei[k] * f->er[l];
      double a = f->mr[k] + f->mr[l];
      bm_integral(a, f->mi[k] + f->mi[l], d, rr - ii, ir + ri, &pr, &pi);
      bm_integral(a, f->mi[k] - f->mi[l], d, rr + ii, ir - ri, &qr, &qi);
      rr = f->zr[k] * f->zr[l];
      ii = f->zi[k] * f->zi[l];
      ri = f->zr[k] * f->zi[l];
      ir = f->zi[k] * f->zr[l];
      double Tr = (rr - ii) * pr - (ir + ri) * pi;
      double Ti = (rr - ii) * pi + (ir + ri) * pr;
      double Vr = (rr + ii) * qr - (ir - ri) * qi;
      double Vi = (rr + ii) * qi + (ir - ri) * qr;
      re[l] += 0.5 * (Tr + Vr);
      re[L + l] += 0.5 * (Vi - Ti);
      im[l] += 0.5 * (-Ti - Vi);
      im[L + l] += 0.5 * (Vr - Tr);
    }
  }
}

/* The lower triangle of each block from the upper one. */
static void mirror(int L, double *gram) {
  int wide = 2 * L;
  for (int k = 0; k < L; k++) {
    for (int l = k + 1; l < L; l++) {
      gram[(size_t)l * wide + k] = gram[(size_t)k * wide + l];
      gram[(size_t)(L + l) * wide + L + k] =
          gram[(size_t)(L + k) * wide + L + l];
      gram[(size_t)l * wide + L + k] = gram[(size_t)(L + k) * wide + l];
      gram[(size_t)(L + l) * wide + k] = gram[(size_t)k * wide + L + l];
    }
  }
}

/* Coefficients of one stretch at its start, exponentials over its length. */
static void begin(bm_watch *watch, functions *f, const bm_stretch *of) {
  int m = watch->flow->m, L = f->L;
  double d = of->to - of->from;
  bm_watch_begin(watch, of->begin, of->load, of->x);
  for (int k = 0; k < L; k++) {
    double zr = k < m ? watch->ar[k] : 1.0, zi = k < m ? watch->ai[k] : 0.0;
    double growth = exp(f->mr[k] * of->from), angle = f->mi[k] * of->from;
    if (k > m && k < L - 1) { /* harmonics turn from the period's start */
      angle = f->mi[k] * (of->begin + of->from);
    }
    double er = growth * cos(angle), ei = growth * sin(angle);
    f->zr[k] = zr * er - zi * ei;
    f->zi[k] = zr * ei + zi * er;
    growth = exp(f->mr[k] * d);
    f->er[k] = growth * cos(f->mi[k] * d);
    f->ei[k] = growth * sin(f->mi[k] * d);
  }
  f->zr[L - 1] = of->load;
}

/* Row r of R for component i of the flow's state. */
static void put_row(const bm_flow *flow, int i, int L, double *r) {
  int m = flow->m, N = flow->N;
  for (int k = 0; k < m; k++) {
    r[k] = flow->V_re[(size_t)k * N + i];
    r[L + k] = flow->V_im[(size_t)k * N + i];
  }
  for (int h = 0; h <= flow->H; h++) {
    r[m + h] = flow->P_re[(size_t)h * N + i];
    r[L + m + h] = flow->P_im[(size_t)h * N + i];
  }
  r[L - 1] = flow->X_c[i];
}

/* R (2n, 2L) of all coordinates and velocities. */
static void put_rows(const bm_flow *flow, const bm_phases *of, int n, int L,
                     double *R) {
  int k = 0;
  for (int j = 0; j < 2 * n; j++) {
    double *r = R + (size_t)j * 2 * (size_t)L;
    if (of->role != BM_HELD || (j != of->joint && j != n + of->joint)) {
      put_row(flow, k++, L, r);
    } else if (j < n) {
      r[L - 1] = 1.0;
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

/* Work of the forcing and viscous loss. `moved` (n, 2L) = R_v gram, `damped`
 * scratch of that size. */
static void add_energies(const bm_flow *flow, bm_integrals *of, int n, int L,
                         const double *velocity, const double *moved,
                         double *damped) {
  int wide = 2 * L, m = flow->m;
  bm_multiply(n, n, wide, of->C, velocity, damped);
  of->loss += dot(moved, damped, n * wide);
  for (int h = 0; h <= flow->H; h++) {
    for (int i = 0; i < n; i++) {
      const double *F = of->F + 2 * ((size_t)h * n + i);
      const double *at = moved + (size_t)i * wide + m + h;
      of->work += F[0] * at[0] + F[1] * at[L];
    }
  }
}

/* `R` (2n, 2L) and as much scratch `moved`. */
static void contract(const bm_flow *flow, const bm_phases *phases,
                     bm_integrals *of, int n, int L, const double *gram,
                     double *R, double *moved) {
  int wide = 2 * L, j = phases->joint;
  size_t half = (size_t)n * (size_t)wide;
  double *velocity = R + half;
  put_rows(flow, phases, n, L, R);
  bm_multiply(n, wide, wide, R, gram, moved);
  for (int i = 0; i < n; i++) {
    size_t at = (size_t)i * (size_t)wide;
    of->squares[i] += dot(moved + at, R + at, wide);
  }
  if (of->C) {
    bm_multiply(n, wide, wide, velocity, gram, moved);
    add_energies(flow, of, n, L, velocity, moved, moved + half);
  } else {
    bm_row_times(wide, wide, velocity + (size_t)j * wide, gram,
                 moved + (size_t)j * wide);
  }
  const double *fast = moved + (size_t)j * wide;
  of->speed += dot(fast, velocity + (size_t)j * wide, wide);
  of->slipped += fast[L - 1]; /* with the load, the constant torque */
}

bm_status bm_integrate(const bm_flow *flow, const bm_walk *walk,
                       const bm_phases *phases, bm_integrals *of) {
  int m = flow->m, L = m + flow->H + 2, wide = 2 * L, met = 0;
  int n = bm_coordinates(flow, phases);
  size_t square = (size_t)wide * (size_t)wide, rows = 2 * (size_t)(n * wide);
  bm_watch watch;
  double *memory =
      calloc(6 * (size_t)L + square + 2 * rows + 2 * (size_t)n, sizeof(double));
  if (!memory || !bm_watch_create(&watch, flow)) {
    free(memory);
    return BM_NO_MEMORY;
  }
  functions f = {L, memory, memory + L, NULL, NULL, NULL, NULL};
  f.zr = f.mi + L;
  f.zi = f.zr + L;
  f.er = f.zi + L;
  f.ei = f.er + L;
  double *gram = f.ei + L, *R = gram + square;
  memcpy(f.mr, flow->lambda_re, (size_t)m * sizeof(double));
  memcpy(f.mi, flow->lambda_im, (size_t)m * sizeof(double));
  for (int h = 0; h <= flow->H; h++) {
    f.mi[m + h] = h * flow->Omega;
  }
  bm_stretch at = {.rest = R + 2 * rows};
  while (bm_next_stretch(walk, phases, n, flow->Omega, &at)) {
    begin(&watch, &f, &at);
    add_products(&f, at.to - at.from, gram);
    met = 1;
  }
  if (met) {
    mirror(L, gram);
    contract(flow, phases, of, n, L, gram, R, R + rows);
  }
  bm_watch_free(&watch);
  free(memory);
  return BM_OK;
}
