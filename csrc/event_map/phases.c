#include "phases.h"

#include <math.h>
#include <string.h>

int bm_coordinates(const bm_flow *flow, const bm_phases *phases) {
  return flow->N / 2 + (phases->role == BM_HELD);
}

static double time_of(const bm_events *events, int n, double period,
                      int64_t i) {
  int64_t width = BM_EVENT_REALS + 2 * (int64_t)n;
  double whole = (double)events->integers[i * BM_EVENT_INTEGERS + BM_PERIODS];
  return whole * period + events->reals[i * width + BM_TIME];
}

/* Phase i: its start, mode, load and the window's part. */
static void look_at(const bm_walk *walk, const bm_phases *phases, int n,
                    double period, int64_t i, bm_stretch *at) {
  const bm_events *events = &walk->events;
  int64_t width = BM_EVENT_REALS + 2 * (int64_t)n;
  at->end = walk->length;
  at->x = phases->state;
  at->start = at->begin = 0.0;
  if (i == 0) {
    at->mode = walk->first_mode;
  } else {
    const double *event = events->reals + (i - 1) * width;
    int64_t kind = events->integers[(i - 1) * BM_EVENT_INTEGERS + BM_KIND];
    at->x = event + BM_EVENT_REALS;
    at->begin = event[BM_TIME];
    at->start = time_of(events, n, period, i - 1);
    at->mode = kind == 0   ? BM_STICK
               : kind == 1 ? -at->mode
               : kind == 2 ? BM_SLIP_POS
                           : BM_SLIP_NEG;
  }
  if (i < events->count) {
    at->end = time_of(events, n, period, i);
  }
  at->from = phases->start > at->start ? phases->start - at->start : 0.0;
  at->to = (phases->end < at->end ? phases->end : at->end) - at->start;
}

int bm_next_stretch(const bm_walk *walk, const bm_phases *phases, int n,
                    double Omega, bm_stretch *at) {
  while (at->next <= walk->events.count) {
    look_at(walk, phases, n, 6.283185307179586 / Omega, at->next++, at);
    int slips = at->mode != BM_STICK;
    int last = at->next > walk->events.count; /* it may have no length */
    if (at->to < at->from || (at->to == at->from && !last) ||
        slips != (phases->role == BM_FREE)) {
      continue;
    }
    at->load = slips ? at->mode * phases->Q_m : 0.0;
    if (phases->role == BM_HELD) {
      const double *x = at->x;
      at->load = x[phases->joint];
      bm_without_joint(n, phases->joint, x, at->rest);
      at->x = at->rest;
    }
    return 1;
  }
  return 0;
}

void bm_whole_state(const bm_phases *phases, const bm_stretch *at, int n,
                    const double *x, double *whole) {
  if (phases->role != BM_HELD) {
    memcpy(whole, x, 2 * (size_t)n * sizeof(double));
    return;
  }
  for (int j = 0, k = 0; j < 2 * n; j++) {
    whole[j] = j == phases->joint       ? at->load
               : j == n + phases->joint ? 0.0
                                        : x[k++];
  }
}

void bm_integral(double a, double b, double d, double er, double ei, double *re,
                 double *im) {
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
