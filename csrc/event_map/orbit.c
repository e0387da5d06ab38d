/* Periodic orbits by shooting.
 *
 * The unknown is the state x at t = 0, F the map over the period (over half of
 * it, with the opposite sign, where the motion is symmetric). In amplitudes of
 * the free flow, S the derivative of F,
 *
 *   x <- x + (1 - S)^-1 (F(x) - x).
 *
 * Where such a step does not help, the motion itself is followed for a while.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "derivative.h"

/* Walks before the first Newton step; forcing periods before giving up. */
#define FIRST_WALKS 3
#define MOST_PERIODS 4000.0
#define LONGEST_STRETCH 256
/* Forcing periods for the motion to settle, where that decides which orbit. */
#define SETTLING 1000.0
/* Residual below which the derivative of the last step serves the next. */
#define CLOSE 1e-5
/* Residual that no further step improves. */
#define ROUNDING 3e-15
/* Pivots of 1 - S below this, relatively, are orbits that are not isolated, as
 * of a joint without a spring. */
#define LEAST_PIVOT 1e-10

/* A state, its image and the walk between them. */
typedef struct {
  bm_walk walk;
  double *state, *image;
  double residual;
} trial;

typedef struct {
  const bm_run *run;
  const bm_changes *changes;
  bm_search *search;
  int N;
  trial now, next;
  bm_carrier carrier;
  double *LU, *step, *gap;
  int *row, *column, rank;
  int factored; /* LU belongs to a state nearby */
} shooting;

static int grow(bm_events *events, int N) {
  int64_t capacity = events->capacity > 0 ? 2 * events->capacity : 16;
  size_t integers = (size_t)capacity * BM_EVENT_INTEGERS * sizeof(int64_t);
  size_t reals =
      (size_t)capacity * (size_t)(BM_EVENT_REALS + N) * sizeof(double);
  int64_t *more = realloc(events->integers, integers);
  if (!more) {
    return 0;
  }
  events->integers = more;
  double *wide = realloc(events->reals, reals);
  if (!wide) {
    return 0;
  }
  events->reals = wide;
  events->capacity = capacity;
  return 1;
}

/* Walks on from `state`, which is moved, over `periods`. Events are kept, or
 * forgotten whenever the buffer is full. */
static bm_status follow(const shooting *it, bm_walk *walk, double *state,
                        double periods, int keep) {
  bm_run run = *it->run;
  double whole = floor(periods), T = 6.283185307179586 / run.free->Omega;
  run.state = state;
  run.started = 0;
  run.periods = 0;
  run.time = 0.0;
  run.reaction_scale = run.Q_s;
  walk->events.count = 0;
  for (;;) {
    bm_status status = bm_propagate(&run, (int64_t)whole, (periods - whole) * T,
                                    &walk->events);
    if (status != BM_FULL) {
      walk->first_mode = run.first_mode;
      walk->last_mode = run.mode;
      walk->length = periods * T;
      return status;
    }
    if (!keep) {
      walk->events.count = 0;
    } else if (!grow(&walk->events, it->N)) {
      return BM_NO_MEMORY;
    }
  }
}

/* Largest change over the largest entry, velocities over Omega. */
static double gap_of(const shooting *it, const double *x, const double *y) {
  double size = 0.0, gap = 0.0, Omega = it->run->free->Omega;
  for (int j = 0; j < it->N; j++) {
    double weight = j < it->N / 2 ? 1.0 : 1.0 / Omega;
    double whole = weight * fabs(y[j]), part = weight * fabs(y[j] - x[j]);
    size = whole > size ? whole : size;
    gap = part > gap ? part : gap;
  }
  return size > 0.0 ? gap / size : gap;
}

/* Fills a trial from its state. */
static bm_status try_state(shooting *it, trial *at) {
  bm_search *search = it->search;
  memcpy(at->image, at->state, (size_t)it->N * sizeof(double));
  bm_status status = follow(it, &at->walk, at->image, search->periods, 1);
  if (status != BM_OK) {
    return status;
  }
  for (int j = 0; j < it->N; j++) {
    at->image[j] *= search->sign;
  }
  at->residual = gap_of(it, at->state, at->image);
  search->followed += search->periods;
  int64_t last = search->capacity - 1;
  search->history[search->steps < last ? search->steps : last] = at->residual;
  search->steps++;
  return BM_OK;
}

/* The joint exactly at rest, when the period ends in stick. Whether that is
 * news. */
static int rest_joint(const shooting *it, const trial *of, double *state) {
  double *v = &state[it->N / 2 + it->run->joint];
  if (of->walk.last_mode != BM_STICK || it->run->sigma > 0.0 || *v == 0.0) {
    return 0;
  }
  *v = 0.0;
  return 1;
}

static void accept(shooting *it) {
  trial hold = it->now;
  it->now = it->next;
  it->next = hold;
}

/* it->carrier.S: derivative of the present image. */
static void derive(shooting *it) {
  size_t size = (size_t)it->N * (size_t)it->N;
  bm_carry(&it->carrier, it->run, it->changes, &it->now.walk);
  for (size_t i = 0; i < size && it->search->sign < 0.0; i++) {
    it->carrier.S[i] = -it->carrier.S[i];
  }
}

/* A Newton step, tried in it->next. 0 when it leads nowhere. */
static int newton(shooting *it) {
  int N = it->N;
  if (!it->factored) {
    derive(it);
    for (int i = 0; i < N * N; i++) {
      it->LU[i] = (i % (N + 1) == 0) - it->carrier.S[i];
    }
    it->rank = bm_factor(N, LEAST_PIVOT, it->LU, it->row, it->column);
  }
  for (int j = 0; j < N; j++) {
    it->gap[j] = it->now.image[j] - it->now.state[j];
  }
  double *amplitudes = it->next.image;
  bm_multiply(N, N, 1, it->changes->into, it->gap, amplitudes);
  bm_solve(N, it->rank, it->LU, it->row, it->column, amplitudes, it->step);
  bm_multiply(N, N, 1, it->changes->out, it->step, it->gap);
  for (int j = 0; j < N; j++) {
    it->next.state[j] = it->now.state[j] + it->gap[j];
    if (!isfinite(it->next.state[j])) {
      return 0;
    }
  }
  rest_joint(it, &it->now, it->next.state);
  if (try_state(it, &it->next) != BM_OK) {
    return 0;
  }
  it->factored = it->next.residual <= CLOSE &&
                 it->next.residual <= 0.01 * it->now.residual;
  return 1;
}

/* Follows the motion over some of its walks. */
static bm_status follow_on(shooting *it, int walks) {
  bm_search *search = it->search;
  double length = walks * search->periods;
  bm_status status = follow(it, &it->next.walk, it->now.state, length, 0);
  if (status != BM_OK) {
    return status;
  }
  for (int j = 0; j < it->N && search->sign < 0.0 && walks % 2; j++) {
    it->now.state[j] = -it->now.state[j];
  }
  search->followed += length;
  it->factored = 0;
  return try_state(it, &it->now);
}

/* What comes before the first Newton step from a state that is not near. */
static bm_status approach(shooting *it) {
  bm_search *search = it->search;
  bm_status status = BM_OK;
  int walks = FIRST_WALKS;
  if (search->settle == 0.0) {
    return it->now.residual > search->tolerance ? follow_on(it, walks) : BM_OK;
  }
  while (status == BM_OK && it->now.residual > search->settle &&
         search->followed < SETTLING) {
    status = follow_on(it, walks);
    walks = walks < LONGEST_STRETCH ? 2 * walks : LONGEST_STRETCH;
  }
  return status;
}

static bm_status look(shooting *it, int near) {
  bm_search *search = it->search;
  int stretch = 4;
  bm_status status = try_state(it, &it->now);
  if (status == BM_OK && !near) {
    status = approach(it);
  }
  while (status == BM_OK && it->now.residual > search->tolerance &&
         search->followed < MOST_PERIODS) {
    int reused = it->factored;
    if (newton(it) && it->next.residual < 0.9 * it->now.residual) {
      accept(it);
    } else if (reused) {
      it->factored = 0;
    } else {
      status = follow_on(it, stretch);
      stretch = stretch < LONGEST_STRETCH ? 2 * stretch : LONGEST_STRETCH;
    }
  }
  if (status == BM_OK && search->followed < MOST_PERIODS &&
      it->now.residual > ROUNDING && newton(it) &&
      it->next.residual < it->now.residual) {
    accept(it); /* below the tolerance: down to rounding by one more step */
  }
  if (status == BM_OK && rest_joint(it, &it->now, it->now.state)) {
    status = try_state(it, &it->now);
  }
  return status;
}

static int create(shooting *it, double **memory, int **order) {
  size_t N = (size_t)it->N;
  *memory = calloc(N * N + 6 * N, sizeof(double));
  *order = calloc(2 * N, sizeof(int));
  if (!*memory || !*order || !bm_carrier_create(&it->carrier, it->run) ||
      !grow(&it->now.walk.events, it->N) ||
      !grow(&it->next.walk.events, it->N)) {
    return 0;
  }
  it->LU = *memory;
  double **parts[] = {&it->step,      &it->gap,        &it->now.state,
                      &it->now.image, &it->next.state, &it->next.image};
  for (int i = 0; i < 6; i++) {
    *parts[i] = it->LU + N * N + (size_t)i * N;
  }
  it->row = *order;
  it->column = it->row + N;
  return 1;
}

/* Eigenvalues of the derivative, transposed: the same ones. */
static bm_status multipliers(shooting *it) {
  bm_search *search = it->search;
  int N = it->N, one = 1, info = 0, room = 4 * N;
  double *values = calloc((size_t)(6 * N), sizeof(double)), none;
  char no = 'N';
  if (!values) {
    return BM_NO_MEMORY;
  }
  search->lapack->dgeev(&no, &no, &N, it->carrier.S, &N, values, values + N,
                        &none, &one, &none, &one, values + 2 * N, &room, &info);
  for (int i = 0; i < N; i++) {
    search->multipliers[2 * i] = values[i];
    search->multipliers[2 * i + 1] = values[N + i];
  }
  free(values);
  return info ? BM_NO_MODES : BM_OK;
}

/* Hands over what was found. */
static bm_status report(shooting *it) {
  bm_search *search = it->search;
  const bm_events *from = &it->now.walk.events;
  size_t size = (size_t)it->N * sizeof(double);
  search->residual = it->now.residual;
  memcpy(it->run->state, it->now.state, size);
  memcpy(search->image, it->now.image, size);
  derive(it);
  memcpy(search->derivative, it->carrier.S, size * (size_t)it->N);
  search->first_mode = it->now.walk.first_mode;
  search->last_mode = it->now.walk.last_mode;
  search->events.count = from->count;
  if (from->count <= search->events.capacity) {
    size_t rows = (size_t)from->count;
    memcpy(search->events.integers, from->integers,
           rows * BM_EVENT_INTEGERS * sizeof(int64_t));
    memcpy(search->events.reals, from->reals,
           rows * (size_t)(BM_EVENT_REALS + it->N) * sizeof(double));
  }
  return search->lapack ? multipliers(it) : BM_OK;
}

static void discard(bm_walk *walk) {
  free(walk->events.integers);
  free(walk->events.reals);
}

bm_status bm_orbit(const bm_run *run, const bm_changes *changes,
                   bm_search *search) {
  shooting it = {.run = run, .changes = changes, .search = search};
  double *memory = NULL;
  int *order = NULL, near = search->residual > 0.0;
  bm_status status = BM_NO_MEMORY;
  it.N = run->free->N;
  search->followed = 0.0;
  search->steps = 0;
  if (create(&it, &memory, &order)) {
    memcpy(it.now.state, run->state, (size_t)it.N * sizeof(double));
    status = look(&it, near);
  }
  if (status == BM_OK) {
    status = report(&it);
  }
  discard(&it.now.walk);
  discard(&it.next.walk);
  bm_carrier_free(&it.carrier);
  free(memory);
  free(order);
  return status;
}
