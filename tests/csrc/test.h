/* A test is a function; CHECK says where it went wrong and goes on. */
#ifndef BS_TEST_H
#define BS_TEST_H

#include <math.h>
#include <stdio.h>

static int test_failures = 0;

#define CHECK(condition)                                              \
  do {                                                                \
    if (!(condition)) {                                               \
      fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      test_failures++;                                                \
    }                                                                 \
  } while (0)

#define CHECK_CLOSE(got, wanted, tolerance)                                    \
  do {                                                                         \
    const double got_ = (got), wanted_ = (wanted);                             \
    if (!(fabs(got_ - wanted_) <= (tolerance))) {                              \
      fprintf(stderr, "%s:%d: %s = %.17g, wanted %.17g\n", __FILE__, __LINE__, \
              #got, got_, wanted_);                                            \
      test_failures++;                                                         \
    }                                                                          \
  } while (0)

#define RUN(test)                                                         \
  do {                                                                    \
    const int before_ = test_failures;                                    \
    test();                                                               \
    printf("%s %s\n", #test, test_failures == before_ ? "ok" : "FAILED"); \
  } while (0)

#define TEST_RESULT (test_failures != 0)

#endif
