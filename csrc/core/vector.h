/* Optimised operations for SUNDIALS' serial vector.
 *
 * Debian compiles SUNDIALS without optimisation, and most of a CVODE step is
 * vector operations; so the ones it uses are replaced, in the vector's own
 * table of operations, by loops compiled with ours. Same arithmetic, element
 * by element. */
#ifndef BS_VECTOR_H
#define BS_VECTOR_H

#include <nvector/nvector_serial.h>

/* All vectors of one solver live in one block, allocated once: SUNDIALS 6.4
 * does not survive a clone that fails, so clones must not be able to fail. */
typedef struct bs_vector_pool bs_vector_pool;

/* Room for BS_VECTOR_ROOM vectors of `length` entries; NULL: no memory. */
enum { BS_VECTOR_ROOM = 48 };
bs_vector_pool *bs_vector_pool_create(SUNContext context, sunindextype length);
void bs_vector_pool_free(bs_vector_pool *pool);

/* A vector from the pool, zero; clones of it come from the pool too. NULL: the
 * pool is used up. Give it back by N_VDestroy, or all with the pool. */
N_Vector bs_vector_take(bs_vector_pool *pool);

/* A probe is the image of a vector under a linear functional, row.x. A linear
 * combination written into it keeps the terms: CVodeGetDky then hands out the
 * interpolating polynomial of row.y instead of its value. */
typedef struct {
  int64_t n;         /* size of row */
  const double *row; /* size n; NULL: take component `unit` */
  int64_t unit;
  int count;                   /* terms of the last combination */
  double factor[16], term[16]; /* its factors and the images of its vectors */
} bs_probe;

N_Vector bs_vector_probe(SUNContext context, bs_probe *probe);

#endif
