/* The linear system in first-order form, one set of matrices per kind of mode.
 *
 *     y = (q, v),   q' = v,   v' = F(t) - A y - level*u
 *
 * free: the joint moves; `level` is its constant friction torque.
 * held: the joint's acceleration is zero (Coulomb stick), or the joint carries
 *       the extra damping Q_m/sigma (inside the band of the saturated law).
 * The reaction that holds the joint is R(t) = row.y + r(t). */
#ifndef BS_SYSTEM_H
#define BS_SYSTEM_H

#include "beltsim_core.h"
#include "forcing.h"
#include "friction.h"

typedef struct {
  double *A;          /* size 2n*n: column k holds the factors of y[k] */
  bs_forcing forcing; /* F(t), n channels */
} bs_dynamics;

typedef struct {
  int32_t n, joint; /* joint = -1: none */
  bs_friction friction;
  bs_dynamics free, held;
  double *u;           /* size n: accelerations per unit of joint torque */
  double *row;         /* size 2n: reaction per unit of state */
  bs_forcing reaction; /* r(t), one channel */
  bs_forcing load;     /* f(t) itself, n channels: for the work done */
  double *C;           /* size n*n: for the viscous loss */
  double period;
  int32_t harmonics; /* highest harmonic of f that is not zero */
} bs_system;

bs_status bs_system_init(bs_system *system, const bs_problem *problem);
void bs_system_clear(bs_system *system);

/* Matrices that hold in `mode`. */
const bs_dynamics *bs_system_dynamics(const bs_system *system, bs_mode mode);

/* y_dot (size 2n) in `mode` at time t. */
void bs_system_rhs(const bs_system *system, bs_mode mode, double t,
                   const double *y, double *y_dot);

/* out (size n) = -A y: the part of the accelerations that follows the state.
 * Used by the right-hand side and by the local series. */
void bs_system_apply(const bs_system *system, const bs_dynamics *dynamics,
                     const double *y, double *out);

/* Torque that would hold the joint at time t; counts no velocity of it. */
double bs_system_reaction(const bs_system *system, double t, const double *y);

/* Friction torque of the joint in `mode`. */
double bs_system_torque(const bs_system *system, bs_mode mode, double t,
                        const double *y);

/* f.v and v'C v at time t; `work` is scratch of size n. */
double bs_system_power(const bs_system *system, double t, const double *y,
                       double *work);
double bs_system_viscous_power(const bs_system *system, const double *y);

#endif
