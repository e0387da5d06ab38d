#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clones.h"

#define DATA(v) N_VGetArrayPointer_Serial(v)
#define LENGTH(v) (((N_VectorContent_Serial)(v)->content)->length)

/* Elements do not depend on each other, also where z is x. */
#if defined(__GNUC__) && !defined(__clang__)
#define BS_INDEPENDENT _Pragma("GCC ivdep")
#else
#define BS_INDEPENDENT
#endif

/* Pointers may be equal (z = x is common), never partly overlapping. */
BS_CLONES static void linear_sum(sunindextype n, double a, const double *x,
                                 double b, const double *y, double *z) {
  BS_INDEPENDENT
  for (sunindextype i = 0; i < n; i++) {
    z[i] = a * x[i] + b * y[i];
  }
}

static void op_linear_sum(sunrealtype a, N_Vector x, sunrealtype b, N_Vector y,
                          N_Vector z) {
  linear_sum(LENGTH(z), a, DATA(x), b, DATA(y), DATA(z));
}

static void op_const(sunrealtype c, N_Vector z) {
  double *out = DATA(z);
  for (sunindextype i = 0; i < LENGTH(z); i++) {
    out[i] = c;
  }
}

static void op_prod(N_Vector x, N_Vector y, N_Vector z) {
  const double *a = DATA(x), *b = DATA(y);
  double *out = DATA(z);
  for (sunindextype i = 0; i < LENGTH(z); i++) {
    out[i] = a[i] * b[i];
  }
}

static void op_div(N_Vector x, N_Vector y, N_Vector z) {
  const double *a = DATA(x), *b = DATA(y);
  double *out = DATA(z);
  for (sunindextype i = 0; i < LENGTH(z); i++) {
    out[i] = a[i] / b[i];
  }
}

BS_CLONES static void scale(sunindextype n, double c, const double *x,
                            double *z) {
  BS_INDEPENDENT
  for (sunindextype i = 0; i < n; i++) {
    z[i] = c * x[i];
  }
}

static void op_scale(sunrealtype c, N_Vector x, N_Vector z) {
  scale(LENGTH(z), c, DATA(x), DATA(z));
}

static void op_abs(N_Vector x, N_Vector z) {
  const double *a = DATA(x);
  double *out = DATA(z);
  for (sunindextype i = 0; i < LENGTH(z); i++) {
    out[i] = fabs(a[i]);
  }
}

static void op_inv(N_Vector x, N_Vector z) {
  const double *a = DATA(x);
  double *out = DATA(z);
  for (sunindextype i = 0; i < LENGTH(z); i++) {
    out[i] = 1.0 / a[i];
  }
}

static void op_add_const(N_Vector x, sunrealtype b, N_Vector z) {
  const double *a = DATA(x);
  double *out = DATA(z);
  for (sunindextype i = 0; i < LENGTH(z); i++) {
    out[i] = a[i] + b;
  }
}

static sunrealtype op_max_norm(N_Vector x) {
  const double *a = DATA(x);
  double largest = 0.0;
  for (sunindextype i = 0; i < LENGTH(x); i++) {
    largest = fmax(largest, fabs(a[i]));
  }
  return largest;
}

static sunrealtype op_min(N_Vector x) {
  const double *a = DATA(x);
  double smallest = a[0];
  for (sunindextype i = 1; i < LENGTH(x); i++) {
    smallest = a[i] < smallest ? a[i] : smallest;
  }
  return smallest;
}

/* Four partial sums in a fixed order: the same bits on every run. */
static sunrealtype op_wrms_norm(N_Vector x, N_Vector w) {
  const double *a = DATA(x), *b = DATA(w);
  const sunindextype n = LENGTH(x);
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  sunindextype i = 0;
  for (; i + 4 <= n; i += 4) {
    for (int k = 0; k < 4; k++) {
      const double term = a[i + k] * b[i + k];
      sum[k] += term * term;
    }
  }
  for (; i < n; i++) {
    const double term = a[i] * b[i];
    sum[0] += term * term;
  }
  return sqrt(((sum[0] + sum[1]) + (sum[2] + sum[3])) / (double)n);
}

BS_CLONES static void add_scaled(sunindextype n, double c, const double *x,
                                 double *z) {
  BS_INDEPENDENT
  for (sunindextype i = 0; i < n; i++) {
    z[i] += c * x[i];
  }
}

/* z = sum c_k X_k; CVODE passes z = X_0 at most. */
static int op_linear_combination(int count, sunrealtype *c, N_Vector *X,
                                 N_Vector z) {
  double *out = DATA(z);
  for (int k = 1; k < count; k++) {
    if (X[k] == z) {
      return -1;
    }
  }
  scale(LENGTH(z), c[0], DATA(X[0]), out);
  for (int k = 1; k < count; k++) {
    add_scaled(LENGTH(z), c[k], DATA(X[k]), out);
  }
  return 0;
}

/* Z_k = a_k x + Y_k. */
static int op_scale_add_multi(int count, sunrealtype *a, N_Vector x,
                              N_Vector *Y, N_Vector *Z) {
  for (int k = 0; k < count; k++) {
    linear_sum(LENGTH(x), a[k], DATA(x), 1.0, DATA(Y[k]), DATA(Z[k]));
  }
  return 0;
}

static int op_scale_array(int count, sunrealtype *c, N_Vector *X, N_Vector *Z) {
  for (int k = 0; k < count; k++) {
    scale(LENGTH(Z[k]), c[k], DATA(X[k]), DATA(Z[k]));
  }
  return 0;
}

/* --- the pool ------------------------------------------------------------- */

typedef struct {
  struct _generic_N_Vector vector; /* first: an N_Vector points here */
  struct _N_VectorContent_Serial content;
  bs_vector_pool *pool;
  int used;
} pool_entry;

struct bs_vector_pool {
  struct _generic_N_Vector_Ops ops; /* shared by all */
  SUNContext context;
  double *data;
  pool_entry entry[BS_VECTOR_ROOM];
};

static N_Vector op_clone(N_Vector w) {
  return bs_vector_take(((pool_entry *)w)->pool);
}

static void op_destroy(N_Vector v) {
  ((pool_entry *)v)->used = 0;
}

static void set_operations(N_Vector_Ops ops) {
  ops->nvclone = op_clone;
  ops->nvdestroy = op_destroy;
  ops->nvlinearsum = op_linear_sum;
  ops->nvconst = op_const;
  ops->nvprod = op_prod;
  ops->nvdiv = op_div;
  ops->nvscale = op_scale;
  ops->nvabs = op_abs;
  ops->nvinv = op_inv;
  ops->nvaddconst = op_add_const;
  ops->nvmaxnorm = op_max_norm;
  ops->nvmin = op_min;
  ops->nvwrmsnorm = op_wrms_norm;
  ops->nvlinearcombination = op_linear_combination;
  ops->nvscaleaddmulti = op_scale_add_multi;
  ops->nvscalevectorarray = op_scale_array;
}

bs_vector_pool *bs_vector_pool_create(SUNContext context, sunindextype length) {
  N_Vector model = N_VNewEmpty_Serial(length, context);
  bs_vector_pool *pool = calloc(1, sizeof *pool);
  double *data = calloc((size_t)length * BS_VECTOR_ROOM, sizeof *data);
  if (model == NULL || pool == NULL || data == NULL) {
    free(pool);
    free(data);
    pool = NULL;
  } else {
    pool->ops = *model->ops;
    set_operations(&pool->ops);
    pool->context = context;
    pool->data = data;
    for (int i = 0; i < BS_VECTOR_ROOM; i++) {
      pool_entry *entry = &pool->entry[i];
      entry->content.length = length;
      entry->content.own_data = SUNFALSE;
      entry->content.data = data + (size_t)i * (size_t)length;
      entry->vector.content = &entry->content;
      entry->vector.ops = &pool->ops;
      entry->vector.sunctx = context;
      entry->pool = pool;
    }
  }
  if (model != NULL) {
    N_VDestroy(model);
  }
  return pool;
}

void bs_vector_pool_free(bs_vector_pool *pool) {
  if (pool != NULL) {
    free(pool->data);
    free(pool);
  }
}

N_Vector bs_vector_take(bs_vector_pool *pool) {
  for (int i = 0; i < BS_VECTOR_ROOM; i++) {
    pool_entry *entry = &pool->entry[i];
    if (!entry->used) {
      entry->used = 1;
      op_const(0.0, &entry->vector);
      return &entry->vector;
    }
  }
  return NULL;
}

/* --- the probe ------------------------------------------------------------ */

static int probe_combination(int count, sunrealtype *c, N_Vector *X,
                             N_Vector z) {
  bs_probe *probe = z->content;
  if (count < 1 || count > 16) {
    return -1;
  }
  probe->count = count;
  for (int k = 0; k < count; k++) {
    const double *x = DATA(X[k]);
    double sum = 0.0;
    if (probe->row == NULL) {
      sum = x[probe->unit];
    } else {
      for (int64_t i = 0; i < probe->n; i++) {
        sum += probe->row[i] * x[i];
      }
    }
    probe->factor[k] = c[k];
    probe->term[k] = sum;
  }
  return 0;
}

N_Vector bs_vector_probe(SUNContext context, bs_probe *probe) {
  N_Vector v = N_VNewEmpty(context);
  if (v != NULL) {
    memset(probe, 0, sizeof *probe);
    v->content = probe;
    v->ops->nvlinearcombination = probe_combination;
  }
  return v;
}
