#include "series.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rounding errors are taken as this many units in the last place of the sum of
 * the absolute values that were added. */
static const double NOISE = 256.0 * DBL_EPSILON;

int bs_series_init(bs_series *series, int32_t n) {
  const size_t rows = BS_SERIES_ORDER + 1;
  series->n = n;
  series->c = calloc(rows * 2 * (size_t)n, sizeof(double));
  series->f = calloc(rows * (size_t)n, sizeof(double));
  return series->c && series->f ? 0 : -1;
}

void bs_series_clear(bs_series *series) {
  free(series->c);
  free(series->f);
  series->c = series->f = NULL;
}

void bs_series_expand(bs_series *series, const bs_system *system, bs_mode mode,
                      double t0, const double *y0) {
  const int32_t n = series->n;
  const bs_dynamics *dynamics = bs_system_dynamics(system, mode);
  const double level = bs_friction_level(&system->friction, mode);
  series->t0 = t0;
  bs_forcing_series(&dynamics->forcing, t0, BS_SERIES_ORDER, series->f);
  memcpy(series->c, y0, 2 * (size_t)n * sizeof(double));
  for (int k = 0; k < BS_SERIES_ORDER; k++) {
    const double *now = series->c + (size_t)k * 2 * (size_t)n;
    double *next = series->c + (size_t)(k + 1) * 2 * (size_t)n;
    const double *f = series->f + (size_t)k * (size_t)n;
    const double share = 1.0 / (k + 1);
    bs_system_apply(system, dynamics, now, next + n);
    for (int32_t i = 0; i < n; i++) {
      double force = f[i];
      if (k == 0 && level != 0.0) {
        force -= level * system->u[i];
      }
      next[i] = now[n + i] * share;
      next[n + i] = (next[n + i] + force) * share;
    }
  }
}

/* Largest |c[k][i]| over the error allowed in component i. */
static double weighted_size(const bs_series *series, int k, double rtol,
                            const double *atol) {
  double size = 0.0;
  for (int32_t i = 0; i < 2 * series->n; i++) {
    const double allowed = rtol * fabs(series->c[i]) + atol[i];
    const double entry =
        fabs(series->c[(size_t)k * 2 * (size_t)series->n + (size_t)i]);
    size = fmax(size, entry / allowed);
  }
  return size;
}

double bs_series_reach(const bs_series *series, double rtol, const double *atol,
                       double share, double longest) {
  double reach = longest;
  for (int k = BS_SERIES_ORDER - 1; k <= BS_SERIES_ORDER; k++) {
    const double size = weighted_size(series, k, rtol, atol);
    if (size > 0.0) {
      reach = fmin(reach, pow(share / size, 1.0 / k));
    }
  }
  return reach;
}

void bs_series_at(const bs_series *series, double t, double *y) {
  const size_t width = 2 * (size_t)series->n;
  const double x = t - series->t0;
  memcpy(y, series->c + BS_SERIES_ORDER * width, width * sizeof(double));
  for (int k = BS_SERIES_ORDER - 1; k >= 0; k--) {
    const double *c = series->c + (size_t)k * width;
    for (size_t i = 0; i < width; i++) {
      y[i] = y[i] * x + c[i];
    }
  }
}

void bs_series_velocity(const bs_series *series, const bs_system *system,
                        bs_mode mode, double *value, double *noise) {
  const int32_t n = series->n, row = n + system->joint;
  const bs_dynamics *dynamics = bs_system_dynamics(system, mode);
  const double level = bs_friction_level(&system->friction, mode);
  for (int k = 0; k <= BS_SERIES_ORDER; k++) {
    value[k] = series->c[(size_t)k * 2 * (size_t)n + (size_t)row];
    noise[k] = 0.0; /* k = 0: the velocity itself is what it is */
    if (k > 0) {
      const double *before = series->c + (size_t)(k - 1) * 2 * (size_t)n;
      double sum =
          fabs(series->f[(size_t)(k - 1) * (size_t)n + (size_t)system->joint]);
      if (k == 1) {
        sum += fabs(level * system->u[system->joint]);
      }
      for (int32_t i = 0; i < 2 * n; i++) {
        const size_t at = (size_t)i * (size_t)n + (size_t)system->joint;
        sum += fabs(dynamics->A[at] * before[i]);
      }
      noise[k] = NOISE * sum / k;
    }
  }
}

void bs_series_reaction(const bs_series *series, const bs_system *system,
                        double *value, double *noise) {
  const int32_t n = series->n;
  bs_forcing_series(&system->reaction, series->t0, BS_SERIES_ORDER, value);
  for (int k = 0; k <= BS_SERIES_ORDER; k++) {
    const double *c = series->c + (size_t)k * 2 * (size_t)n;
    double sum = fabs(value[k]);
    for (int32_t i = 0; i < 2 * n; i++) {
      const double term = system->row[i] * c[i];
      value[k] += term;
      sum += fabs(term);
    }
    noise[k] = NOISE * sum;
  }
}
