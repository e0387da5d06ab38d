/* First exit of a sum of exponentials from an interval, with a certificate.
 *
 * On a cell of length d the cubic Hermite polynomial through the values and
 * slopes at both ends differs from f by at most max|f''''| d^4 / 384, and
 *
 *   max|f''''| <= sum_k |w_k| |lambda_k|^4 max(1, |exp(lambda_k d)|).
 *
 * The cubic lies within its Bernstein coefficients. So either the cell is
 * proved free of exits, or f is proved monotone with one exit, or the cell is
 * halved. No exit can be stepped over, however close together two of them lie.
 */
#include "signal.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "cells.h"
#include "clones.h"

/* Terms of a Taylor series, enough for |lambda| d <= SERIES_REACH. */
#define TAYLOR_TERMS BM_TERMS
#define SERIES_REACH 1.0

typedef struct {
  double value, slope; /* at one end of a cell */
} bm_end;

typedef struct {
  int terms; /* until double precision is reached */
  double c[TAYLOR_TERMS], noise[TAYLOR_TERMS]; /* and their rounding */
} bm_taylor;

int bm_signal_series_level(int K, double base, const double *lr,
                           const double *li) {
  double fastest = 0.0;
  int level = 0;
  for (int k = 0; k < K; k++) {
    fastest = fmax(fastest, hypot(lr[k], li[k]));
  }
  while (level < BM_LEVELS - 1 &&
         fastest * ldexp(base, -level) > SERIES_REACH) {
    level++;
  }
  return level;
}

void bm_signal_tabulate(int K, double base, const double *lr, const double *li,
                        double *er, double *ei, double *bound) {
  double d = base;
  for (int level = 0; level < BM_LEVELS; level++, d *= 0.5) {
    for (int k = 0; k < K; k++) {
      double growth = exp(lr[k] * d);
      double step = (lr[k] * lr[k] + li[k] * li[k]) * d * d;
      *er++ = growth * cos(li[k] * d);
      *ei++ = growth * sin(li[k] * d);
      *bound++ = step * step / 384.0 * (growth > 1.0 ? growth : 1.0);
    }
  }
}

/* Value and slope of sum_k (xr + i xi)_k. Four sums side by side:
 * the same bits whatever the width of the vectors. */
BM_CLONES static void end_sums(int K, const double *restrict lr,
                               const double *restrict li,
                               const double *restrict xr,
                               const double *restrict xi, double *sums) {
  double value[4] = {0.0}, slope[4] = {0.0};
  for (int k = 0; k < K; k += 4) {
    for (int l = 0; l < 4; l++) {
      value[l] += xr[k + l];
      slope[l] += lr[k + l] * xr[k + l] - li[k + l] * xi[k + l];
    }
  }
  sums[0] = (value[0] + value[1]) + (value[2] + value[3]);
  sums[1] = (slope[0] + slope[1]) + (slope[2] + slope[3]);
}

static bm_end end_of(const bm_signal *f, const double *xr, const double *xi) {
  double sums[2];
  if (f->cells) {
    bm_end end = {bm_cells_taylor(f->cells, f->K, 0, xr, sums), 0.0};
    end.slope = bm_cells_taylor(f->cells, f->K, 1, xr, sums) / f->base;
    return end;
  }
  end_sums(f->K, f->lr, f->li, xr, xi, sums);
  bm_end end = {f->offset + sums[0], sums[1]};
  return end;
}

double bm_signal_slope(const bm_signal *f) {
  return end_of(f, f->wr, f->wi).slope;
}

/* Hermite error of the cell, and the rounding noise of a value in it. */
BM_CLONES static void error_sums(int K, const double *restrict wr,
                                 const double *restrict wi,
                                 const double *restrict bound, double *sums) {
  double sum[4] = {0.0}, size[4] = {0.0};
  for (int k = 0; k < K; k += 4) {
    for (int l = 0; l < 4; l++) {
      double w = fabs(wr[k + l]) + fabs(wi[k + l]);
      sum[l] += w * bound[k + l];
      size[l] += w;
    }
  }
  sums[0] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  sums[1] = (size[0] + size[1]) + (size[2] + size[3]);
}

/* The same for cells: the Taylor series bounds the fourth derivative. */
static void cell_error(const bm_signal *f, int level, double *error,
                       double *noise) {
  double size, sum = 0.0, scale = ldexp(1.0, -4 * level) / 384.0;
  bm_cells_taylor(f->cells, f->K, 0, f->wr, &size);
  *noise = 4.0 * DBL_EPSILON * size;
  for (int j = 4; j < TAYLOR_TERMS; j++, scale = ldexp(scale, -level)) {
    double c = fabs(bm_cells_taylor(f->cells, f->K, j, f->wr, &size));
    sum += (c + 4.0 * DBL_EPSILON * size) * scale *
           ((double)j * (j - 1) * (j - 2) * (j - 3));
  }
  *error = sum;
}

static void error_of(const bm_signal *f, int level, double *error,
                     double *noise) {
  double sums[2];
  if (f->cells) {
    cell_error(f, level, error, noise);
    return;
  }
  error_sums(f->K, f->wr, f->wi, f->bound + level * f->K, sums);
  *error = sums[0];
  *noise = 4.0 * DBL_EPSILON * (fabs(f->offset) + sums[1]);
}

BM_CLONES static void turn(int K, const double *restrict wr,
                           const double *restrict wi, const double *restrict er,
                           const double *restrict ei, double *restrict xr,
                           double *restrict xi) {
  for (int k = 0; k < K; k++) {
    xr[k] = wr[k] * er[k] - wi[k] * ei[k];
    xi[k] = wr[k] * ei[k] + wi[k] * er[k];
  }
}

static void advance_to(const bm_signal *f, int level, double *xr, double *xi) {
  if (f->cells) {
    bm_cells_advance(f->cells, f->K, ldexp(1.0, -level), f->wr, xr, xi);
    return;
  }
  turn(f->K, f->wr, f->wi, f->er + level * f->K, f->ei + level * f->K, xr, xi);
}

/* Sums the terms p, then multiplies each by scale lambda: the next derivative.
 */
BM_CLONES static void derive(int K, double scale, const double *restrict lr,
                             const double *restrict li, double *restrict pr,
                             double *restrict pi, double *restrict sums) {
  double part[4] = {0.0}, mass[4] = {0.0};
  for (int k = 0; k < K; k += 4) {
    for (int l = 0; l < 4; l++) {
      double r = pr[k + l], i = pi[k + l];
      part[l] += r;
      mass[l] += fabs(r) + fabs(i);
      pr[k + l] = scale * (lr[k + l] * r - li[k + l] * i);
      pi[k + l] = scale * (lr[k + l] * i + li[k + l] * r);
    }
  }
  sums[0] = (part[0] + part[1]) + (part[2] + part[3]);
  sums[1] = (mass[0] + mass[1]) + (mass[2] + mass[3]);
}

/* Taylor coefficients of f at the cell start in units of d. */
static bm_taylor taylor(bm_signal *f, double d) {
  bm_taylor t;
  double first = 0.0, sums[2];
  if (f->cells) {
    double scale = 1.0;
    for (int j = 0; j < TAYLOR_TERMS; j++, scale *= d / f->base) {
      t.c[j] = scale * bm_cells_taylor(f->cells, f->K, j, f->wr, sums);
      t.noise[j] = 4.0 * DBL_EPSILON * scale * sums[0];
    }
    t.terms = TAYLOR_TERMS;
    return t;
  }
  memcpy(f->pr, f->wr, (size_t)f->K * sizeof(double));
  memcpy(f->pi, f->wi, (size_t)f->K * sizeof(double));
  for (int j = 0; j < TAYLOR_TERMS; j++) {
    derive(f->K, d / (j + 1), f->lr, f->li, f->pr, f->pi, sums);
    t.c[j] = sums[0];
    t.noise[j] = 4.0 * DBL_EPSILON * sums[1];
    if (j == 0) {
      first = fabs(f->offset) + sums[1];
      t.c[0] += f->offset;
    } else if (j > 4 && sums[1] <= 0.01 * DBL_EPSILON * first) {
      t.terms = j + 1;
      return t;
    }
  }
  t.terms = TAYLOR_TERMS;
  return t;
}

/* The same coefficients in units of half the length. */
static void halve(bm_taylor *t) {
  double scale = 1.0;
  for (int j = 0; j < t->terms; j++, scale *= 0.5) {
    t->c[j] *= scale;
    t->noise[j] *= scale;
  }
}

static double polynomial(const double *c, int terms, double x, double *slope) {
  double value = 0.0, derivative = 0.0;
  for (int j = terms - 1; j >= 0; j--) {
    derivative = derivative * x + value;
    value = value * x + c[j];
  }
  *slope = derivative;
  return value;
}

/* Moves to the end of the cell, whose coefficients stand in the scratch. */
static void step(bm_signal *f) {
  double *hold = f->wr;
  f->wr = f->pr;
  f->pr = hold;
  if (f->cells) {
    return;
  }
  hold = f->wi;
  f->wi = f->pi;
  f->pi = hold;
}

/* The one root of f - value in the cell, on which f - value changes sign once:
 * its time after the cell start. Halves the cell by the tables until the Taylor
 * series is short, then solves that. */
static double polish(bm_signal *f, int level, double value, int falling) {
  double low = 0.0, high = 1.0, slope, start = 0.0;
  while (level < f->series_level + 1 && level < BM_LEVELS - 1) {
    level++;
    advance_to(f, level, f->pr, f->pi);
    double middle = end_of(f, f->pr, f->pi).value - value;
    if (falling ? middle > 0.0 : middle < 0.0) {
      step(f);
      start += ldexp(f->base, -level);
    }
  }
  double d = ldexp(f->base, -level);
  bm_taylor t = taylor(f, d);
  t.c[0] -= value;
  double at_low = polynomial(t.c, t.terms, low, &slope);
  double x = at_low / (at_low - polynomial(t.c, t.terms, high, &slope));
  if (!(x > 0.0 && x < 1.0)) {
    x = 0.5;
  }
  for (int i = 0; i < 100; i++) {
    double found = polynomial(t.c, t.terms, x, &slope);
    if (falling ? found > 0.0 : found < 0.0) {
      low = x;
    } else {
      high = x;
    }
    double next = x - found / slope;
    if (!(next > low && next < high)) {
      next = 0.5 * (low + high);
    }
    if (fabs(next - x) <= 2.0 * DBL_EPSILON * x) {
      return start + d * next;
    }
    x = next;
  }
  return start + d * x;
}

/* Bernstein coefficients of the Hermite cubic on a cell of length d. */
static void bernstein(bm_end left, bm_end right, double d, double *b) {
  b[0] = left.value;
  b[1] = left.value + d * left.slope / 3.0;
  b[2] = right.value - d * right.slope / 3.0;
  b[3] = right.value;
}

static double least(const double *b) {
  double x = b[0];
  for (int i = 1; i < 4; i++) {
    x = b[i] < x ? b[i] : x;
  }
  return x;
}

static double most(const double *b) {
  double x = b[0];
  for (int i = 1; i < 4; i++) {
    x = b[i] > x ? b[i] : x;
  }
  return x;
}

/* +1 or -1 when the slope keeps that sign over the cell, else 0. */
static int monotone(const double *b, double error, double noise) {
  double slack = 3.08 * error + noise;
  double s[3] = {3.0 * (b[1] - b[0]), 3.0 * (b[2] - b[1]), 3.0 * (b[3] - b[2])};
  if (s[0] > slack && s[1] > slack && s[2] > slack) {
    return 1;
  }
  return s[0] < -slack && s[1] < -slack && s[2] < -slack ? -1 : 0;
}

typedef enum { INWARD = 1, UNDECIDED = 0, OUTWARD = -1, FLAT = 2 } bm_start;

/* Which way f leaves a zero of order *order of f - at, over the first cell:
 * inward (sign) when f = at + sign tau^p g with g > 0 on the whole cell. The
 * Taylor series gives g without cancellation. Coefficients within rounding of
 * zero raise the order; when all are, f stays where it is: FLAT. */
static bm_start leave(const bm_taylor *t, int *order, int sign) {
  const double *c = t->c, *noise = t->noise;
  double against = 0.0;
  int p = *order;
  while (p < t->terms && fabs(c[p]) <= noise[p]) {
    p++;
  }
  if (p >= t->terms) {
    return FLAT;
  }
  *order = p;
  if (sign * c[p] < 0.0) {
    return OUTWARD;
  }
  for (int j = p + 1; j < t->terms; j++) {
    against += sign * c[j] < 0.0 ? fabs(c[j]) + noise[j] : noise[j];
  }
  return sign * c[p] > against + noise[p] ? INWARD : UNDECIDED;
}

/* Place in [0, 1] of the extremum of a cubic whose slopes at both ends differ
 * in sign. */
static double extremum(const double *b) {
  double first = b[1] - b[0], last = b[3] - b[2], middle = b[2] - b[1];
  double square = first - 2.0 * middle + last, linear = 2.0 * (middle - first);
  double root = sqrt(fmax(linear * linear - 4.0 * square * first, 0.0));
  double q = -0.5 * (linear + (linear < 0.0 ? -root : root));
  double x = q != 0.0 ? first / q : 0.5;
  if (!(x >= 0.0 && x <= 1.0)) {
    x = q / square;
  }
  return x >= 0.0 && x <= 1.0 ? x : 0.5;
}

/* An extremum inside a cleared cell: how near did the cubic come to lo, hi? */
static void note_margin(bm_exit *out, const double *b, double lo, double hi,
                        double d) {
  int dips = b[1] < b[0] && b[2]<b[3], peaks = b[1]> b[0] && b[2] > b[3];
  if (!dips && !peaks) {
    return;
  }
  double nearest = dips ? least(b) - lo : hi - most(b);
  if (nearest >= out->margin) {
    return;
  }
  double x = extremum(b), y = 1.0 - x;
  double value =
      y * y * (y * b[0] + 3.0 * x * b[1]) + x * x * (3.0 * y * b[2] + x * b[3]);
  double gap = fmax(dips ? value - lo : hi - value, 0.0);
  if (gap < out->margin) {
    out->margin = gap;
    out->margin_tau = out->tau + x * d;
  }
}

/* Whether the whole cell lies within rounding of `at`: no halving can decide
 * more there. */
static int hugs(const double *b, double at, double error, double noise) {
  double reach = error + 2.0 * noise;
  return error <= noise && most(b) - at <= reach && at - least(b) <= reach;
}

/* First cells: shrink until the start is left inward for certain. Returns the
 * level, or -1 with `out` filled when f goes outward at once or never. */
static int first_level(bm_signal *f, double lo, double hi, double limit,
                       int multiplicity, int side, bm_exit *out) {
  int level = 0;
  while (level < BM_LEVELS - 1 && ldexp(f->base, -level) > limit) {
    level++;
  }
  if (multiplicity == 0) {
    return level;
  }
  double other = side < 0 ? hi : lo, error, noise;
  if (level < f->series_level) {
    level = f->series_level;
  }
  bm_taylor t = taylor(f, ldexp(f->base, -level));
  for (; level < BM_LEVELS; level++, halve(&t)) {
    double d = ldexp(f->base, -level);
    int order = multiplicity;
    bm_start way = leave(&t, &order, -side);
    out->multiple |= order > multiplicity;
    if (way == FLAT) {
      out->tau = limit;
      return -1;
    }
    if (way == OUTWARD) {
      out->tau = 0.0;
      out->side = side;
      return -1;
    }
    if (way == INWARD) {
      double b[4];
      bm_end left = end_of(f, f->wr, f->wi);
      advance_to(f, level, f->pr, f->pi);
      bernstein(left, end_of(f, f->pr, f->pi), d, b);
      error_of(f, level, &error, &noise);
      double reach = error + noise;
      if (side < 0 ? most(b) + reach < other : least(b) - reach > other) {
        step(f);
        out->tau = d;
        return level;
      }
    }
  }
  return BM_LEVELS - 1;
}

bm_exit bm_signal_exit(bm_signal *f, double lo, double hi, double limit,
                       int multiplicity, int side) {
  bm_exit out = {0.0, 0, 0, HUGE_VAL, 0.0};
  int level = first_level(f, lo, hi, limit, multiplicity, side, &out);
  if (level < 0) {
    return out;
  }
  bm_end left = end_of(f, f->wr, f->wi);
  while (out.tau < limit) {
    double d = ldexp(f->base, -level), b[4], error, noise;
    advance_to(f, level, f->pr, f->pi);
    bm_end right = end_of(f, f->pr, f->pi);
    bernstein(left, right, d, b);
    error_of(f, level, &error, &noise);
    double reach = error + noise;
    if (!isfinite(reach)) {
      break; /* the state is not finite: the caller will see */
    }
    if (least(b) - reach > lo && most(b) + reach < hi) {
      note_margin(&out, b, lo, hi, d);
      step(f);
      left = right;
      out.tau += d;
      level -= level > 0 && error < 0.02 * (least(b) - lo) &&
               error < 0.02 * (hi - most(b));
      continue;
    }
    int trend = monotone(b, error, noise);
    int down = trend < 0 && right.value <= lo,
        up = trend > 0 && right.value >= hi;
    int flat = hugs(b, lo, error, noise) || hugs(b, hi, error, noise);
    if (down || up || flat || level == BM_LEVELS - 1) {
      int leaves =
          down || up || (!flat && (right.value <= lo || right.value >= hi));
      if (leaves) {
        out.side = down || right.value <= lo ? -1 : 1;
        out.tau += polish(f, level, out.side < 0 ? lo : hi, out.side < 0);
        out.multiple |= !(down || up);
        break;
      }
      /* a touch that working precision cannot tell from an exit */
      if (out.margin > 0.0) {
        out.margin = 0.0;
        out.margin_tau = out.tau;
      }
      step(f);
      left = right;
      out.tau += d;
      continue;
    }
    level++;
  }
  if (out.side == 0 || out.tau > limit) {
    out.side = 0;
    out.tau = limit;
  }
  return out;
}
