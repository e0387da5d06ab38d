/* One rubbing mass, q'' + c q' + k q + h = F cos(Omega t), packed for the map in
 * modes or in cells. */
#ifndef BM_MASS_H
#define BM_MASS_H

#include <stdlib.h>
#include <string.h>

#include "beltsim_map.h"
#include "cells.h"
#include "check.h"

#define TURN 6.283185307179586

typedef struct {
  double c, k, F, Omega, Q_m, Q_s;
  double *free_packed, *held_packed, *changes_packed;
  bm_flow free, held;
  bm_changes changes;
  double state[2];
  bm_run run;
} mass;

static double *put(double *to, int count, const double *from) {
  memcpy(to, from, (size_t)count * sizeof(double));
  return to + count;
}

static void mass_free(mass *it) {
  free(it->free_packed);
  free(it->held_packed);
  free(it->changes_packed);
}

/* x = Re V a of one complex mode, a = W x, H = 1 */
static void pack_free_modes(mass *it, double *into, double *out) {
  double lr = -0.5 * it->c, li = sqrt(it->k - 0.25 * it->c * it->c);
  double V_re[] = {2.0, 2.0 * lr}, V_im[] = {0.0, 2.0 * li};
  double W_re[] = {0.5, 0.0}, W_im[] = {0.5 * lr / li, -0.5 / li};
  double w = it->Omega, re = it->k - w * w, im = w * it->c;
  double size = re * re + im * im;
  double qr = it->F * re / size, qi = -it->F * im / size;
  double P_re[] = {0.0, 0.0, qr, -w * qi}, P_im[] = {0.0, 0.0, qi, w * qr};
  double X_c[] = {-1.0 / it->k, 0.0}, row[] = {0.0, 1.0}, D[4] = {0.0};
  it->free_packed = calloc((size_t)bm_flow_reals(2, 1, 1), sizeof(double));
  double *p = put(put(it->free_packed, 1, &lr), 1, &li);
  p = put(put(put(put(p, 2, V_re), 2, V_im), 2, W_re), 2, W_im);
  p = put(put(put(put(p, 4, P_re), 4, P_im), 2, X_c), 2, row);
  put(p, 4, D); /* and d_c = 0 */
  bm_flow_prepare(it->free_packed, 2, 1, 1, w);
  bm_flow_unpack(&it->free, it->free_packed, 2, 1, 1, w);
  for (int j = 0; j < 2; j++) {
    into[j] = W_re[j];
    into[2 + j] = W_im[j];
    out[2 * j] = V_re[j];
    out[2 * j + 1] = -V_im[j];
  }
}

/* The extended state (q, v, 1, c, cos, sin), unscaled. */
static void pack_free_cells(mass *it, double *into, double *out) {
  enum { NA = 6 };
  double d = 0.25, w = it->Omega, A[NA * NA] = {0.0}, E[NA * NA] = {0.0};
  double rows[BM_TERMS * NA] = {0.0}, unit[4] = {1.0, 0.0, 0.0, 1.0};
  A[0 * NA + 1] = d;
  A[1 * NA + 0] = -it->k * d;
  A[1 * NA + 1] = -it->c * d;
  A[1 * NA + 3] = -d;
  A[1 * NA + 4] = it->F * d;
  A[4 * NA + 5] = -w * d;
  A[5 * NA + 4] = w * d;
  double At[NA * NA], term[NA * NA] = {0.0}, next[NA * NA];
  for (int i = 0; i < NA; i++) {
    term[i * NA + i] = 1.0;
    for (int j = 0; j < NA; j++) {
      At[j * NA + i] = A[i * NA + j];
    }
  }
  for (int k = 1; k < BM_TERMS; k++) { /* E' = sum (A')^k / k! */
    for (int i = 0; i < NA * NA; i++) {
      E[i] += term[i];
      next[i] = 0.0;
    }
    for (int i = 0; i < NA; i++) {
      for (int j = 0; j < NA; j++) {
        for (int l = 0; l < NA; l++) {
          next[i * NA + j] += At[i * NA + l] * term[l * NA + j] / k;
        }
      }
    }
    memcpy(term, next, sizeof term);
  }
  rows[1] = 1.0; /* the velocity */
  for (int k = 1; k < BM_TERMS; k++) {
    for (int j = 0; j < NA; j++) {
      for (int l = 0; l < NA; l++) {
        rows[k * NA + j] += rows[(k - 1) * NA + l] * A[l * NA + j] / k;
      }
    }
  }
  double row[] = {0.0, 1.0}, D[4] = {0.0}, last[] = {0.0, d};
  it->free_packed =
      calloc((size_t)bm_flow_reals(2, BM_CELLS, 1), sizeof(double));
  double *p = put(put(it->free_packed, 4, unit), 4, unit);
  p = put(put(put(p, NA * NA, At), NA * NA, E), BM_TERMS * NA, rows);
  put(put(put(p, 2, row), 4, D), 2, last);
  bm_flow_prepare(it->free_packed, 2, BM_CELLS, 1, w);
  bm_flow_unpack(&it->free, it->free_packed, 2, BM_CELLS, 1, w);
  memcpy(into, unit, sizeof unit);
  memcpy(out, unit, sizeof unit);
}

/* Held, nothing moves: the reaction is F cos(Omega t) - k q. */
static void pack_held(mass *it) {
  double D[] = {0.0, it->F, 0.0, 0.0}, d_c = -it->k;
  it->held_packed = calloc((size_t)bm_flow_reals(0, 0, 1), sizeof(double));
  put(put(it->held_packed, 4, D), 1, &d_c);
  bm_flow_prepare(it->held_packed, 0, 0, 1, it->Omega);
  bm_flow_unpack(&it->held, it->held_packed, 0, 0, 1, it->Omega);
}

static void pack_changes(mass *it, const double *into, const double *out) {
  double position[2], velocity[2]; /* columns of `into` */
  for (int i = 0; i < 2; i++) {
    position[i] = into[2 * i];
    velocity[i] = into[2 * i + 1];
  }
  double last[] = {-it->k, 1.0};
  it->changes_packed = calloc((size_t)bm_changes_reals(1, 0), sizeof(double));
  double *p = put(put(it->changes_packed, 4, into), 4, out);
  p = put(put(put(p, 2, out), 2, out + 2), 2, position);
  put(put(put(p, 2, velocity), 2, velocity), 2, last);
  bm_changes_unpack(&it->changes, it->changes_packed, 1, 0);
}

static void mass_create(mass *it, int cells) {
  double into[4], out[4];
  (cells ? pack_free_cells : pack_free_modes)(it, into, out);
  pack_held(it);
  pack_changes(it, into, out);
  bm_run run = {&it->free, &it->held, 0.0, 0,   it->Q_m, it->Q_s, 1e3,
                0,         0.0,       0,   0,   0,       0,       it->Q_s,
                it->state};
  it->run = run;
  it->state[0] = it->state[1] = 0.0;
}

#endif
