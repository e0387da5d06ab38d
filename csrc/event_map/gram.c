/* Integrals of products of exponentials, in closed form.
 *
 * With u = Re z exp(mu tau) and, as its partner, -Im z exp(mu tau),
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

#include "flow.h"

typedef struct {
  int L;
  double *mr, *mi; /* exponents (L)                                     */
  double *zr, *zi; /* coefficients at the start of the stretch          */
  double *er, *ei; /* exp(mu d)                                         */
} functions;

/* (exp(s d) - 1)/s of s = a + ib, exp(s d) = er + i ei */
static void integral(double a, double b, double d, double er, double ei,
                     double *re, double *im) {
  double size = a * a + b * b;
  if (size * d * d > 0.01) {
    er -= 1.0;
  } else if (size > 0.0) { /* without cancellation */
    double half = sin(0.5 * b * d);
    er = expm1(a * d) * cos(b * d) - 2.0 * half * half;
    ei = exp(a * d) * sin(b * d);
  } else {
    *re = d;
    *im = 0.0;
    return;
  }
  *re = (er * a + ei * b) / size;
  *im = (ei * a - er * b) / size;
}

static void add_products(const functions *f, double d, double *gram) {
  int L = f->L, wide = 2 * L;
  for (int k = 0; k < L; k++) {
    double *re = gram + (size_t)k * wide, *im = gram + (size_t)(L + k) * wide;
    for (int l = k; l < L; l++) {
      double pr, pi, qr, qi;
      double rr = f->er[k] * f->er[l], ii = f->ei[k] * f->ei[l];
      double ri = f->er[k] * f->ei[l], ir = f->ei[k] * f->er[l];
      double a = f->mr[k] + f->mr[l];
      integral(a, f->mi[k] + f->mi[l], d, rr - ii, ir + ri, &pr, &pi);
      integral(a, f->mi[k] - f->mi[l], d, rr + ii, ir - ri, &qr, &qi);
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
static void begin(bm_watch *watch, functions *f, const bm_stretches *all,
                  int64_t i) {
  const bm_flow *flow = watch->flow;
  int m = flow->m, L = f->L;
  double start = all->begin[i], from = all->from[i], d = all->to[i] - from;
  bm_watch_begin(watch, start, all->load[i], all->states + i * flow->N);
  for (int k = 0; k < L; k++) {
    double zr = k < m ? watch->ar[k] : 1.0, zi = k < m ? watch->ai[k] : 0.0;
    double growth = exp(f->mr[k] * from), angle = f->mi[k] * from;
    if (k > m && k < L - 1) { /* harmonics turn from the period's start */
      angle = f->mi[k] * (start + from);
    }
    double er = growth * cos(angle), ei = growth * sin(angle);
    f->zr[k] = zr * er - zi * ei;
    f->zi[k] = zr * ei + zi * er;
    growth = exp(f->mr[k] * d);
    f->er[k] = growth * cos(f->mi[k] * d);
    f->ei[k] = growth * sin(f->mi[k] * d);
  }
  f->zr[L - 1] = all->load[i];
}

bm_status bm_gram(const bm_flow *flow, bm_stretches *all) {
  int m = flow->m, L = m + flow->H + 2;
  bm_watch watch;
  double *memory = calloc(6 * (size_t)L, sizeof(double));
  if (!memory || !bm_watch_create(&watch, flow)) {
    free(memory);
    return BM_NO_MEMORY;
  }
  functions f = {L, memory, memory + L, NULL, NULL, NULL, NULL};
  f.zr = f.mi + L;
  f.zi = f.zr + L;
  f.er = f.zi + L;
  f.ei = f.er + L;
  memcpy(f.mr, flow->lambda_re, (size_t)m * sizeof(double));
  memcpy(f.mi, flow->lambda_im, (size_t)m * sizeof(double));
  for (int h = 0; h <= flow->H; h++) {
    f.mi[m + h] = h * flow->Omega;
  }
  for (int64_t i = 0; i < all->count; i++) {
    begin(&watch, &f, all, i);
    add_products(&f, all->to[i] - all->from[i], all->gram);
  }
  mirror(L, all->gram);
  bm_watch_free(&watch);
  free(memory);
  return BM_OK;
}
