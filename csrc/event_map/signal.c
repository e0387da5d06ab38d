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

/* Terms of a Taylor series, enough for |lambda| d <= SERIES_REACH. */
#define TAYLOR_TERMS 32
#define SERIES_REACH 1.0

typedef struct {
  double value, slope; /* at one end of a cell, slope times cell length */
} bm_end;

void bm_signal_tabulate(bm_signal *f) {
  double d = f->base, fastest = 0.0;
  for (int k = 0; k < f->K; k++) {
    fastest = fmax(fastest, hypot(f->lr[k], f->li[k]));
  }
  f->series_level = 0;
  while (f->series_level < BM_LEVELS - 1 &&
         fastest * ldexp(d, -f->series_level) > SERIES_REACH) {
    f->series_level++;
  }
  for (int level = 0; level < BM_LEVELS; level++, d *= 0.5) {
    double *er = f->er + level * f->K, *ei = f->ei + level * f->K;
    double *bound = f->bound + level * f->K;
    for (int k = 0; k < f->K; k++) {
      double growth = exp(f->lr[k] * d);
      double size2 = f->lr[k] * f->lr[k] + f->li[k] * f->li[k];
      double step = size2 * d * d;
      er[k] = growth * cos(f->li[k] * d);
      ei[k] = growth * sin(f->li[k] * d);
      bound[k] = step * step / 384.0 * (growth > 1.0 ? growth : 1.0);
    }
  }
}

/* Value and slope (times d) of sum_k (xr + i xi)_k. */
static bm_end end_of(const bm_signal *f, const double *xr, const double *xi,
                     double d) {
  double value[4] = {0.0}, slope[4] = {0.0};
  for (int k = 0; k < f->K; k += 4) {
    for (int l = 0; l < 4; l++) {
      value[l] += xr[k + l];
      slope[l] += f->lr[k + l] * xr[k + l] - f->li[k + l] * xi[k + l];
    }
  }
  bm_end end;
  end.value = f->offset + ((value[0] + value[1]) + (value[2] + value[3]));
  end.slope = d * ((slope[0] + slope[1]) + (slope[2] + slope[3]));
  return end;
}

/* Hermite error of the cell, and the rounding noise of a value in it. */
static void error_of(const bm_signal *f, int level, double *error,
                     double *noise) {
  const double *bound = f->bound + level * f->K;
  double sum[4] = {0.0}, size[4] = {0.0};
  for (int k = 0; k < f->K; k += 4) {
    for (int l = 0; l < 4; l++) {
      double w = fabs(f->wr[k + l]) + fabs(f->wi[k + l]);
      sum[l] += w * bound[k + l];
      size[l] += w;
    }
  }
  *error = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  *noise = 4.0 * DBL_EPSILON *
           (fabs(f->offset) + (size[0] + size[1]) + (size[2] + size[3]));
}

static void advance_to(const bm_signal *f, int level, double *xr, double *xi) {
  const double *er = f->er + level * f->K, *ei = f->ei + level * f->K;
  for (int k = 0; k < f->K; k++) {
    xr[k] = f->wr[k] * er[k] - f->wi[k] * ei[k];
    xi[k] = f->wr[k] * ei[k] + f->wi[k] * er[k];
  }
}

/* Sums the terms p, then multiplies each by scale lambda: the next derivative. */
static void derive(int K, double scale, const double *restrict lr,
                   const double *restrict li, double *restrict pr,
                   double *restrict pi, double *sum, double *size) {
  double part0 = 0.0, part1 = 0.0, mass0 = 0.0, mass1 = 0.0;
  for (int k = 0; k < K; k += 2) {
    part0 += pr[k];
    part1 += pr[k + 1];
    mass0 += fabs(pr[k]) + fabs(pi[k]);
    mass1 += fabs(pr[k + 1]) + fabs(pi[k + 1]);
  }
  for (int k = 0; k < K; k++) {
    double r = pr[k], i = pi[k];
    pr[k] = scale * (lr[k] * r - li[k] * i);
    pi[k] = scale * (lr[k] * i + li[k] * r);
  }
  *sum = part0 + part1;
  *size = mass0 + mass1;
}

/* Taylor coefficients of f at the cell start in units of d, and their rounding
 * noise; returns how many reach double precision. */
static int taylor(bm_signal *f, double d, double *c, double *noise) {
  double first = 0.0;
  for (int k = 0; k < f->K; k++) {
    f->pr[k] = f->wr[k];
    f->pi[k] = f->wi[k];
  }
  for (int j = 0; j < TAYLOR_TERMS; j++) {
    double size;
    derive(f->K, d / (j + 1), f->lr, f->li, f->pr, f->pi, &c[j], &size);
    noise[j] = 4.0 * DBL_EPSILON * size;
    if (j == 0) {
      first = fabs(f->offset) + size;
      c[0] += f->offset;
    } else if (j > 4 && size <= 0.01 * DBL_EPSILON * first) {
      return j + 1;
    }
  }
  return TAYLOR_TERMS;
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
  hold = f->wi;
  f->wi = f->pi;
  f->pi = hold;
}

/* The one root of f - value in the cell, on which f - value changes sign once:
 * its time after the cell start. Halves the cell by the tables until the Taylor
 * series is short, then solves that. */
static double polish(bm_signal *f, int level, double value, int falling) {
  double c[TAYLOR_TERMS], noise[TAYLOR_TERMS], low = 0.0, high = 1.0, slope;
  double start = 0.0;
  while (level < f->series_level + 1 && level < BM_LEVELS - 1) {
    level++;
    advance_to(f, level, f->pr, f->pi);
    double middle = end_of(f, f->pr, f->pi, 1.0).value - value;
    if (falling ? middle > 0.0 : middle < 0.0) {
      step(f);
      start += ldexp(f->base, -level);
    }
  }
  double d = ldexp(f->base, -level);
  int terms = taylor(f, d, c, noise);
  c[0] -= value;
  double at_low = polynomial(c, terms, low, &slope);
  double x = at_low / (at_low - polynomial(c, terms, high, &slope));
  if (!(x > 0.0 && x < 1.0)) {
    x = 0.5;
  }
  for (int i = 0; i < 100; i++) {
    double found = polynomial(c, terms, x, &slope);
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

/* Bernstein coefficients of the Hermite cubic. */
static void bernstein(bm_end left, bm_end right, double *b) {
  b[0] = left.value;
  b[1] = left.value + left.slope / 3.0;
  b[2] = right.value - right.slope / 3.0;
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
static bm_start leave(bm_signal *f, double d, int *order, int sign) {
  double c[TAYLOR_TERMS], noise[TAYLOR_TERMS], against = 0.0;
  int terms = taylor(f, d, c, noise), p = *order;
  while (p < terms && fabs(c[p]) <= noise[p]) {
    p++;
  }
  if (p >= terms) {
    return FLAT;
  }
  *order = p;
  if (sign * c[p] < 0.0) {
    return OUTWARD;
  }
  for (int j = p + 1; j < terms; j++) {
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
  int dips = b[1] < b[0] && b[2] < b[3], peaks = b[1] > b[0] && b[2] > b[3];
  if (!dips && !peaks) {
    return;
  }
  double nearest = dips ? least(b) - lo : hi - most(b);
  if (nearest >= out->margin) {
    return;
  }
  double x = extremum(b), y = 1.0 - x;
  double value = y * y * (y * b[0] + 3.0 * x * b[1]) +
                 x * x * (3.0 * y * b[2] + x * b[3]);
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
  for (; level < BM_LEVELS; level++) {
    double d = ldexp(f->base, -level);
    int order = multiplicity;
    bm_start way = leave(f, d, &order, -side);
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
      bm_end left = end_of(f, f->wr, f->wi, d);
      advance_to(f, level, f->pr, f->pi);
      bernstein(left, end_of(f, f->pr, f->pi, d), b);
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
  while (out.tau < limit) {
    double d = ldexp(f->base, -level), b[4], error, noise;
    bm_end left = end_of(f, f->wr, f->wi, d);
    advance_to(f, level, f->pr, f->pi);
    bm_end right = end_of(f, f->pr, f->pi, d);
    bernstein(left, right, b);
    error_of(f, level, &error, &noise);
    double reach = error + noise;
    if (!isfinite(reach)) {
      break; /* the state is not finite: the caller will see */
    }
    if (least(b) - reach > lo && most(b) + reach < hi) {
      note_margin(&out, b, lo, hi, d);
      step(f);
      out.tau += d;
      level -= level > 0 && error < 0.02 * (least(b) - lo) &&
               error < 0.02 * (hi - most(b));
      continue;
    }
    int trend = monotone(b, error, noise);
    int down = trend < 0 && right.value <= lo, up = trend > 0 && right.value >= hi;
    int flat = hugs(b, lo, error, noise) || hugs(b, hi, error, noise);
    if (down || up || flat || level == BM_LEVELS - 1) {
      int leaves = down || up ||
                   (!flat && (right.value <= lo || right.value >= hi));
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
