#include "forcing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int32_t highest_harmonic(int32_t width, int32_t H, const double *f_cos,
                                const double *f_sin) {
  for (int32_t k = H; k > 0; k--) {
    for (int32_t i = 0; i < width; i++) {
      if (f_cos[k * width + i] != 0.0 || f_sin[k * width + i] != 0.0) {
        return k;
      }
    }
  }
  return 0;
}

int bs_forcing_init(bs_forcing *forcing, int32_t width, int32_t H, double Omega,
                    const double *f_cos, const double *f_sin) {
  H = highest_harmonic(width, H, f_cos, f_sin);
  size_t count = (size_t)(H + 1) * (size_t)width;
  forcing->width = width;
  forcing->harmonics = H;
  forcing->Omega = Omega;
  forcing->cos = calloc(count + 1, sizeof(double));
  forcing->sin = calloc(count + 1, sizeof(double));
  if (!forcing->cos || !forcing->sin) {
    return -1;
  }
  memcpy(forcing->cos, f_cos, count * sizeof(double));
  memcpy(forcing->sin, f_sin, count * sizeof(double));
  return 0;
}

void bs_forcing_clear(bs_forcing *forcing) {
  free(forcing->cos);
  free(forcing->sin);
  forcing->cos = forcing->sin = NULL;
}

void bs_forcing_at(const bs_forcing *forcing, double t, double *out) {
  const int32_t width = forcing->width;
  memcpy(out, forcing->cos, (size_t)width * sizeof(double));
  if (forcing->harmonics == 0) {
    return;
  }
  const double c1 = cos(forcing->Omega * t), s1 = sin(forcing->Omega * t);
  double c = c1, s = s1;
  for (int32_t k = 1; k <= forcing->harmonics; k++) {
    const double *fc = forcing->cos + (size_t)k * (size_t)width;
    const double *fs = forcing->sin + (size_t)k * (size_t)width;
    for (int32_t i = 0; i < width; i++) {
      out[i] += fc[i] * c + fs[i] * s;
    }
    const double next = c * c1 - s * s1;
    s = s * c1 + c * s1;
    c = next;
  }
}

void bs_forcing_series(const bs_forcing *forcing, double t, int order,
                       double *out) {
  const int32_t width = forcing->width;
  memset(out, 0, (size_t)(order + 1) * (size_t)width * sizeof(double));
  memcpy(out, forcing->cos, (size_t)width * sizeof(double));
  for (int32_t h = 1; h <= forcing->harmonics; h++) {
    const double *fc = forcing->cos + (size_t)h * (size_t)width;
    const double *fs = forcing->sin + (size_t)h * (size_t)width;
    const double w = h * forcing->Omega;
    /* (c, s) are the k-th derivatives of cos(w t), sin(w t), over k! */
    double c = cos(w * t), s = sin(w * t);
    for (int k = 0; k <= order; k++) {
      double *row = out + (size_t)k * (size_t)width;
      for (int32_t i = 0; i < width; i++) {
        row[i] += fc[i] * c + fs[i] * s;
      }
      const double next = -s * w / (k + 1);
      s = c * w / (k + 1);
      c = next;
    }
  }
}
