/* A test is a function; CHECK says where it went wrong and goes on. */
#ifndef BM_CHECK_H
#define BM_CHECK_H

#include <math.h>
#include <stdio.h>

static int failures = 0;

#define CHECK(condition)                                              \
  do {                                                                \
    if (!(condition)) {                                               \
      fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      failures++;                                                     \
    }                                                                 \
  } while (0)

#define NEAR(got, wanted, tolerance)                                           \
  do {                                                                         \
    const double got_ = (got), wanted_ = (wanted);                             \
    if (!(fabs(got_ - wanted_) <= (tolerance))) {                              \
      fprintf(stderr, "%s:%d: %s = %.17g, wanted %.17g\n", __FILE__, __LINE__, \
              #got, got_, wanted_);                                            \
      failures++;                                                              \
    }                                                                          \
  } while (0)

#endif
