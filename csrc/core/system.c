#include "system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clones.h"

/* Cholesky factor of the n*n matrix L in place (lower triangle). */
static int cholesky(int32_t n, double *L) {
  for (int32_t j = 0; j < n; j++) {
    double pivot = L[j * n + j];
    const double diagonal = pivot;
    for (int32_t k = 0; k < j; k++) {
      pivot -= L[j * n + k] * L[j * n + k];
    }
    if (!(pivot > 1e-14 * diagonal)) {
      return -1;
    }
    pivot = sqrt(pivot);
    L[j * n + j] = pivot;
    for (int32_t i = j + 1; i < n; i++) {
      double sum = L[i * n + j];
      for (int32_t k = 0; k < j; k++) {
        sum -= L[i * n + k] * L[j * n + k];
      }
      L[i * n + j] = sum / pivot;
    }
  }
  return 0;
}

/* Solve L L' x = x in place, x of size n. */
static void solve(int32_t n, const double *L, double *x) {
  for (int32_t i = 0; i < n; i++) {
    for (int32_t k = 0; k < i; k++) {
      x[i] -= L[i * n + k] * x[k];
    }
    x[i] /= L[i * n + i];
  }
  for (int32_t i = n - 1; i >= 0; i--) {
    for (int32_t k = i + 1; k < n; k++) {
      x[i] -= L[k * n + i] * x[k];
    }
    x[i] /= L[i * n + i];
  }
}

/* A and F of v' = F - A y from a factorised mass matrix. With pinned >= 0 that
 * row of every right-hand side is zero, and its velocity does not act. */
static bs_status dynamics_init(bs_dynamics *dynamics, const bs_problem *p,
                               const double *L, const double *damping,
                               int32_t pinned) {
  const int32_t n = p->n, H = p->harmonics;
  const size_t rows = (size_t)(H + 1) * (size_t)n;
  double *f_cos = malloc(rows * sizeof(double));
  double *f_sin = malloc(rows * sizeof(double));
  dynamics->A = calloc((size_t)n * (size_t)n * 2, sizeof(double));
  bs_status status = BS_NO_MEMORY;
  if (f_cos && f_sin && dynamics->A) {
    for (int32_t k = 0; k < 2 * n; k++) {
      const double *matrix = k < n ? p->K : damping;
      double *column = dynamics->A + (size_t)k * (size_t)n;
      if (pinned >= 0 && k == n + pinned) {
        continue;
      }
      for (int32_t i = 0; i < n; i++) {
        column[i] = i == pinned ? 0.0 : matrix[i * n + k % n];
      }
      solve(n, L, column);
    }
    memcpy(f_cos, p->f_cos, rows * sizeof(double));
    memcpy(f_sin, p->f_sin, rows * sizeof(double));
    for (int32_t h = 0; h <= H; h++) {
      if (pinned >= 0) {
        f_cos[h * n + pinned] = f_sin[h * n + pinned] = 0.0;
      }
      solve(n, L, f_cos + (size_t)h * (size_t)n);
      solve(n, L, f_sin + (size_t)h * (size_t)n);
    }
    if (bs_forcing_init(&dynamics->forcing, n, H, p->Omega, f_cos, f_sin) ==
        0) {
      status = BS_OK;
    }
  }
  free(f_cos);
  free(f_sin);
  return status;
}

/* Reaction R = f_t - [M_tq a + (C+G)_tq v + K_t q], a the held accelerations:
 * model equations of the joint's own row. */
static bs_status reaction_init(bs_system *system, const bs_problem *p,
                               const double *damping) {
  const int32_t n = p->n, joint = system->joint, H = p->harmonics;
  const double *M_t = p->M + (size_t)joint * (size_t)n;
  double *r_cos = calloc((size_t)H + 1, sizeof(double));
  double *r_sin = calloc((size_t)H + 1, sizeof(double));
  bs_status status = BS_NO_MEMORY;
  if (r_cos && r_sin) {
    for (int32_t k = 0; k < 2 * n; k++) {
      const double *column = system->held.A + (size_t)k * (size_t)n;
      double sum = k < n ? -p->K[joint * n + k] : -damping[joint * n + k - n];
      for (int32_t i = 0; i < n; i++) {
        sum += i == joint ? 0.0 : M_t[i] * column[i];
      }
      system->row[k] = k == n + joint ? 0.0 : sum;
    }
    const bs_forcing *held = &system->held.forcing;
    for (int32_t h = 0; h <= H; h++) {
      r_cos[h] = p->f_cos[h * n + joint];
      r_sin[h] = p->f_sin[h * n + joint];
      for (int32_t i = 0; h <= held->harmonics && i < n; i++) {
        if (i != joint) {
          r_cos[h] -= M_t[i] * held->cos[h * n + i];
          r_sin[h] -= M_t[i] * held->sin[h * n + i];
        }
      }
    }
    if (bs_forcing_init(&system->reaction, 1, H, p->Omega, r_cos, r_sin) == 0) {
      status = BS_OK;
    }
  }
  free(r_cos);
  free(r_sin);
  return status;
}

/* `held` for a Coulomb joint: the joint's row and column of M made those of the
 * unit matrix. For a saturated one: the damping of the band added. */
static bs_status joint_init(bs_system *system, const bs_problem *p, double *L,
                            double *damping) {
  const int32_t n = p->n, joint = system->joint;
  const size_t square = (size_t)n * (size_t)n;
  int32_t pinned = -1;
  memcpy(L, p->M, square * sizeof(double));
  if (system->friction.law == BS_COULOMB) {
    pinned = joint;
    for (int32_t i = 0; i < n; i++) {
      L[i * n + joint] = L[joint * n + i] = 0.0;
    }
    L[joint * n + joint] = 1.0;
  }
  if (cholesky(n, L) != 0) {
    return BS_NOT_DEFINITE;
  }
  if (system->friction.law == BS_COULOMB) {
    bs_status status = dynamics_init(&system->held, p, L, damping, pinned);
    return status == BS_OK ? reaction_init(system, p, damping) : status;
  }
  const double band = system->friction.Q_m / system->friction.sigma;
  damping[joint * n + joint] += band;
  bs_status status = dynamics_init(&system->held, p, L, damping, pinned);
  damping[joint * n + joint] -= band;
  return status;
}

bs_status bs_system_init(bs_system *system, const bs_problem *p) {
  const int32_t n = p->n;
  const size_t square = (size_t)n * (size_t)n;
  system->n = n;
  system->joint = p->law == BS_NO_FRICTION ? -1 : p->joint;
  system->friction.law = (bs_law)p->law;
  system->friction.Q_m = p->Q_m;
  system->friction.Q_s = p->Q_s;
  system->friction.sigma = p->sigma;
  system->period = 2.0 * acos(-1.0) / p->Omega;
  system->u = calloc((size_t)n, sizeof(double));
  system->row = calloc((size_t)n * 2, sizeof(double));
  system->C = malloc(square * sizeof(double));
  double *L = malloc(square * sizeof(double));
  double *damping = malloc(square * sizeof(double));
  bs_status status = BS_NO_MEMORY;
  if (system->u && system->row && system->C && L && damping &&
      bs_forcing_init(&system->load, n, p->harmonics, p->Omega, p->f_cos,
                      p->f_sin) == 0) {
    system->harmonics = system->load.harmonics;
    memcpy(system->C, p->C, square * sizeof(double));
    for (size_t i = 0; i < square; i++) {
      damping[i] = p->C[i] + p->G[i];
    }
    memcpy(L, p->M, square * sizeof(double));
    status = cholesky(n, L) == 0 ? BS_OK : BS_NOT_DEFINITE;
    if (status == BS_OK) {
      status = dynamics_init(&system->free, p, L, damping, -1);
    }
    if (status == BS_OK && system->joint >= 0) {
      system->u[system->joint] = 1.0;
      solve(n, L, system->u);
      status = joint_init(system, p, L, damping);
    }
  }
  free(L);
  free(damping);
  return status;
}

void bs_system_clear(bs_system *system) {
  free(system->free.A);
  free(system->held.A);
  free(system->u);
  free(system->row);
  free(system->C);
  bs_forcing_clear(&system->free.forcing);
  bs_forcing_clear(&system->held.forcing);
  bs_forcing_clear(&system->reaction);
  bs_forcing_clear(&system->load);
}

const bs_dynamics *bs_system_dynamics(const bs_system *system, bs_mode mode) {
  return mode == BS_STICK ? &system->held : &system->free;
}

/* Four columns at a time: the accumulators stay in cache, the order of sums in
 * each element is fixed. */
BS_CLONES static void subtract_product(int32_t n, const double *restrict A,
                                       const double *restrict y,
                                       double *restrict out) {
  const int32_t blocks = 2 * n / 4 * 4;
  for (int32_t k = 0; k < blocks; k += 4) {
    const double *restrict a = A + (size_t)k * (size_t)n;
    const double *restrict b = a + n, *restrict c = b + n, *restrict d = c + n;
    const double y0 = y[k], y1 = y[k + 1], y2 = y[k + 2], y3 = y[k + 3];
    for (int32_t i = 0; i < n; i++) {
      out[i] -= (a[i] * y0 + b[i] * y1) + (c[i] * y2 + d[i] * y3);
    }
  }
  for (int32_t k = blocks; k < 2 * n; k++) {
    const double *restrict a = A + (size_t)k * (size_t)n;
    for (int32_t i = 0; i < n; i++) {
      out[i] -= a[i] * y[k];
    }
  }
}

void bs_system_apply(const bs_system *system, const bs_dynamics *dynamics,
                     const double *y, double *out) {
  memset(out, 0, (size_t)system->n * sizeof(double));
  subtract_product(system->n, dynamics->A, y, out);
}

void bs_system_rhs(const bs_system *system, bs_mode mode, double t,
                   const double *y, double *y_dot) {
  const int32_t n = system->n;
  const bs_dynamics *dynamics = bs_system_dynamics(system, mode);
  memcpy(y_dot, y + n, (size_t)n * sizeof(double));
  bs_forcing_at(&dynamics->forcing, t, y_dot + n);
  subtract_product(n, dynamics->A, y, y_dot + n);
  const double level = bs_friction_level(&system->friction, mode);
  if (level != 0.0) {
    for (int32_t i = 0; i < n; i++) {
      y_dot[n + i] -= level * system->u[i];
    }
  }
}

double bs_system_reaction(const bs_system *system, double t, const double *y) {
  double sum;
  bs_forcing_at(&system->reaction, t, &sum);
  for (int32_t k = 0; k < 2 * system->n; k++) {
    sum += system->row[k] * y[k];
  }
  return sum;
}

double bs_system_torque(const bs_system *system, bs_mode mode, double t,
                        const double *y) {
  const bs_friction *friction = &system->friction;
  if (mode != BS_STICK) {
    return bs_friction_level(friction, mode);
  }
  if (friction->law == BS_COULOMB) {
    return bs_system_reaction(system, t, y);
  }
  return friction->Q_m * (y[system->n + system->joint] / friction->sigma);
}

double bs_system_power(const bs_system *system, double t, const double *y,
                       double *work) {
  double sum = 0.0;
  bs_forcing_at(&system->load, t, work);
  for (int32_t i = 0; i < system->n; i++) {
    sum += work[i] * y[system->n + i];
  }
  return sum;
}

double bs_system_viscous_power(const bs_system *system, const double *y) {
  const int32_t n = system->n;
  const double *v = y + n;
  double sum = 0.0;
  for (int32_t i = 0; i < n; i++) {
    double row = 0.0;
    for (int32_t k = 0; k < n; k++) {
      row += system->C[i * n + k] * v[k];
    }
    sum += v[i] * row;
  }
  return sum;
}
