/* Finite Fourier series of `width` channels, and their local Taylor series. */
#ifndef BS_FORCING_H
#define BS_FORCING_H

#include <stdint.h>

typedef struct {
  int32_t width;
  int32_t harmonics; /* highest harmonic that is not zero */
  double Omega;
  double *cos, *sin; /* size (harmonics + 1)*width each, owned */
} bs_forcing;

/* Copies (H + 1)*width coefficients and drops trailing zero rows. Returns 0,
 * or -1 when there is no memory. */
int bs_forcing_init(bs_forcing *forcing, int32_t width, int32_t H, double Omega,
                    const double *f_cos, const double *f_sin);
void bs_forcing_clear(bs_forcing *forcing);

/* out[width] = f(t). */
void bs_forcing_at(const bs_forcing *forcing, double t, double *out);

/* out[(order + 1)*width]: row k is the k-th derivative over k! at time t. */
void bs_forcing_series(const bs_forcing *forcing, double t, int order,
                       double *out);

#endif
