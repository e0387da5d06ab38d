/* Derivative of the state after a walk with respect to the state before it.
 *
 * Within a phase it is the flow itself. At an event it jumps (saltation): with
 * the watched quantity g reaching its threshold,
 *
 *   S+ = S- + (f+ - f-) (grad g S-) / (dg/dt)-
 *
 *   slip to stick          the others receive the joint's momentum, and the
 *                          joint's velocity is lost;
 *   slip to opposite slip  the torque jumps by 2 Q_m, or Q_m + Q_m;
 *   release                nothing jumps for Q_s = Q_m, otherwise the joint's
 *                          acceleration does.
 *
 * It starts and ends in amplitudes of the free flow, whatever the mode. */
#include "derivative.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cells.h"
#include "clones.h"
#include "dense.h"

int64_t bm_changes_reals(int n, int Nh) {
  int64_t N = 2 * (int64_t)n;
  return 2 * N * N + 2 * N * Nh + 5 * N + 2 * (int64_t)Nh + 2;
}

void bm_changes_unpack(bm_changes *changes, const double *packed, int n,
                       int Nh) {
  int N = 2 * n;
  const double **parts[] = {
      &changes->into,     &changes->out,    &changes->stick,
      &changes->release,  &changes->place,  &changes->velocity,
      &changes->position, &changes->impact, &changes->push,
      &changes->kick,     &changes->grip};
  int sizes[] = {N * N, N * N, Nh * N, N * Nh, N, N, N, Nh, N, N, Nh};
  for (int i = 0; i < 11; packed += sizes[i++]) {
    *parts[i] = packed;
  }
  changes->grip_c = packed[0];
  changes->mass = packed[1];
}

/* Reals of the extended state of a flow in cells. */
static size_t extended(const bm_flow *flow) {
  return (size_t)(flow->N + 2 + 2 * flow->H);
}

int bm_carrier_create(bm_carrier *it, const bm_run *run) {
  size_t N = (size_t)run->free->N, Na = extended(run->free);
  memset(it, 0, sizeof(*it));
  it->S = calloc(2 * N * N + 3 * N + 1, sizeof(double));
  if (!it->S || !bm_watch_create(&it->held, run->held)) {
    return 0;
  }
  it->next = it->S + N * N;
  it->place = it->next + N * N;
  it->row = it->place + N;
  it->rest = it->row + N;
  if (run->free->m == BM_CELLS || run->held->m == BM_CELLS) {
    it->cells = calloc(2 * N * Na + 2 * Na * Na + 3 * Na, sizeof(double));
    return it->cells != NULL;
  }
  return 1;
}

void bm_carrier_free(bm_carrier *it) {
  bm_watch_free(&it->held);
  free(it->S);
  free(it->cells);
}

/* (x + i y) (n) *= er + i ei */
BM_CLONES static void rotate(int n, double er, double ei, double *restrict x,
                             double *restrict y) {
  for (int c = 0; c < n; c++) {
    double real = er * x[c] - ei * y[c];
    y[c] = er * y[c] + ei * x[c];
    x[c] = real;
  }
}

static void through_modes(const bm_flow *flow, double tau, int columns,
                          double *S) {
  for (int k = 0; k < flow->m; k++) {
    double growth = exp(flow->lambda_re[k] * tau);
    double angle = flow->lambda_im[k] * tau;
    if (flow->lambda_im[k] != 0.0) {
      rotate(columns, growth * cos(angle), growth * sin(angle), S, S + columns);
      S += 2 * (size_t)columns;
      continue;
    }
    for (int c = 0; c < columns; c++) {
      S[c] *= growth;
    }
    S += columns;
  }
}

/* Rows of y (columns, Na), each an extended state, over a time tau: whole cells
 * by squaring, the rest by series. */
static void through_cells(bm_carrier *it, const bm_flow *flow, double tau,
                          int columns) {
  const bm_cells *cells = &flow->cells;
  int N = flow->N, Na = (int)extended(flow);
  size_t size = (size_t)columns * (size_t)Na, square = (size_t)Na * (size_t)Na;
  double *y = it->cells, *after = y + size, *power = after + size;
  double *doubled = power + square, *term = doubled + square;
  double whole = floor(tau / cells->d), u = tau / cells->d - whole;
  memset(y, 0, size * sizeof(double));
  for (int c = 0; c < columns; c++) {
    for (int i = 0; i < N; i++) {
      y[c * Na + i] = it->S[i * columns + c];
    }
    y[c * Na + N + 1] = it->place[c];
  }
  memcpy(power, cells->E, square * sizeof(double));
  while (whole >= 1.0) {
    if (fmod(whole, 2.0) >= 1.0) {
      bm_multiply(columns, Na, Na, y, power, after);
      memcpy(y, after, size * sizeof(double));
    }
    whole = floor(0.5 * whole);
    if (whole >= 1.0) {
      bm_multiply(Na, Na, Na, power, power, doubled);
      memcpy(power, doubled, square * sizeof(double));
    }
  }
  for (int c = 0; c < columns; c++) {
    bm_cells_advance(cells, Na, u < 1.0 ? u : 0.0, y + c * Na, term, term + Na);
    for (int i = 0; i < N; i++) {
      it->S[i * columns + c] = term[i];
    }
  }
}

static void through(bm_carrier *it, const bm_flow *flow, double tau,
                    int columns) {
  if (it->fresh) {
    it->moved += tau;
  } else if (flow->m == BM_CELLS) {
    through_cells(it, flow, tau, columns);
  } else {
    through_modes(flow, tau, columns, it->S);
  }
}

/* out (rows, N) = A (rows, N) times the modes of a free flow over tau. */
static void before_modes(const bm_flow *flow, double tau, int rows,
                         const double *A, double *out) {
  int N = flow->N;
  for (int k = 0, c = 0; k < flow->m; k++) {
    double growth = exp(flow->lambda_re[k] * tau);
    double angle = flow->lambda_im[k] * tau;
    double er = growth * cos(angle), ei = growth * sin(angle);
    if (flow->lambda_im[k] == 0.0) {
      for (int i = c; i < rows * N; i += N) {
        out[i] = er * A[i];
      }
      c++;
      continue;
    }
    for (int i = c; i < rows * N; i += N) {
      double x = A[i], y = A[i + 1];
      out[i] = er * x + ei * y;
      out[i + 1] = er * y - ei * x;
    }
    c += 2;
  }
}

/* out (rows, N) = A (rows, N) S, S of the free flow. */
static void before(const bm_carrier *it, const bm_run *run, int rows,
                   const double *A, double *out) {
  if (it->fresh) {
    before_modes(run->free, it->moved, rows, A, out);
  } else {
    bm_multiply(rows, run->free->N, run->free->N, A, it->S, out);
  }
}

/* Into the held flow. `stops`: an impact, not a start in stick. */
static void hold(bm_carrier *it, const bm_run *run, const bm_changes *changes,
                 int stops) {
  int N = run->free->N, Nh = run->held->N;
  before(it, run, 1, changes->place, it->place);
  before(it, run, Nh, changes->stick, it->next);
  if (stops) {
    before(it, run, 1, changes->velocity, it->row);
    bm_add_outer(Nh, N, changes->impact, it->row, it->next);
  }
  memcpy(it->S, it->next, (size_t)Nh * (size_t)N * sizeof(double));
  it->fresh = 0;
}

/* Back into the free flow, without a jump. */
static void let_go(bm_carrier *it, const bm_run *run,
                   const bm_changes *changes) {
  int N = run->free->N, Nh = run->held->N;
  bm_multiply(N, Nh, N, changes->release, it->S, it->next);
  bm_add_outer(N, N, changes->position, it->place, it->next);
  memcpy(it->S, it->next, (size_t)N * (size_t)N * sizeof(double));
  memset(it->place, 0, (size_t)N * sizeof(double));
}

/* Writes out the flow that S still stands for. */
static void settle(bm_carrier *it, const bm_flow *flow) {
  if (it->fresh) {
    it->fresh = 0;
    through_modes(flow, it->moved, flow->N, it->S);
  }
}

/* A reversal: the acceleration jumps with the torque. */
static void reverse(bm_carrier *it, const bm_run *run,
                    const bm_changes *changes, const double *event) {
  const double *x = event + BM_EVENT_REALS;
  double before = event[BM_TORQUE_BEFORE], after = event[BM_TORQUE_AFTER];
  int N = run->free->N;
  settle(it, run->free);
  bm_without_joint(N / 2, run->joint, x, it->rest);
  double reaction =
      bm_flow_signal(run->held, event[BM_TIME], x[run->joint], it->rest);
  double jump = (before - after) * changes->mass / (reaction - before);
  bm_row_times(N, N, changes->velocity, it->S, it->row);
  for (int c = 0; c < N; c++) {
    it->row[c] *= jump;
  }
  bm_add_outer(N, N, changes->push, it->row, it->S);
}

/* A release. With Q_s > Q_m the acceleration jumps when the reaction reaches
 * the static level. */
static void release(bm_carrier *it, const bm_run *run,
                    const bm_changes *changes, const double *event) {
  const double *x = event + BM_EVENT_REALS;
  double drop = event[BM_TORQUE_BEFORE] - event[BM_TORQUE_AFTER];
  int N = run->free->N, Nh = run->held->N;
  if (run->sigma > 0.0 || drop == 0.0) {
    let_go(it, run, changes);
    return;
  }
  bm_without_joint(N / 2, run->joint, x, it->rest);
  bm_watch_begin(&it->held, event[BM_TIME], x[run->joint], it->rest);
  double rate = bm_signal_slope(&it->held.signal);
  double jump = drop / changes->mass / rate;
  bm_row_times(Nh, N, changes->grip, it->S, it->row);
  for (int c = 0; c < N; c++) {
    it->row[c] = jump * (it->row[c] + changes->grip_c * it->place[c]);
  }
  let_go(it, run, changes);
  bm_add_outer(N, N, changes->kick, it->row, it->S);
}

void bm_carry(bm_carrier *it, const bm_run *run, const bm_changes *changes,
              const bm_walk *walk) {
  int N = run->free->N, mode = walk->first_mode;
  double now = 0.0, period = 6.283185307179586 / run->free->Omega;
  memset(it->S, 0, (size_t)N * (size_t)N * sizeof(double));
  memset(it->place, 0, (size_t)N * sizeof(double));
  it->fresh = run->free->m != BM_CELLS;
  it->moved = 0.0;
  for (int i = 0; i < N; i++) {
    it->S[(size_t)i * N + i] = 1.0;
  }
  if (mode == BM_STICK) {
    hold(it, run, changes, 0);
  }
  for (int64_t i = 0; i < walk->events.count; i++) {
    const double *event = walk->events.reals + i * (BM_EVENT_REALS + N);
    const int64_t *whole = walk->events.integers + i * BM_EVENT_INTEGERS;
    double t = (double)whole[BM_PERIODS] * period + event[BM_TIME];
    through(it, mode ? run->free : run->held, t - now, N);
    now = t;
    switch (whole[BM_KIND]) {
      case 0:
        hold(it, run, changes, 1);
        mode = BM_STICK;
        break;
      case 1:
        reverse(it, run, changes, event);
        mode = -mode;
        break;
      default:
        release(it, run, changes, event);
        mode = whole[BM_KIND] == 2 ? BM_SLIP_POS : BM_SLIP_NEG;
    }
  }
  through(it, mode ? run->free : run->held, walk->length - now, N);
  settle(it, run->free);
  if (mode == BM_STICK) {
    let_go(it, run, changes);
  }
}
