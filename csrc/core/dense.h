/* Optimised factorisation and solution for SUNDIALS' dense linear solver, for
 * the reason given in vector.h: most of a BDF run is spent in them. */
#ifndef BS_DENSE_H
#define BS_DENSE_H

#include <sunlinsol/sunlinsol_dense.h>

/* Replace set-up and solution of a SUNLinSol_Dense object. */
void bs_dense_speed_up(SUNLinearSolver solver);

#endif
