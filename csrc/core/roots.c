#include "roots.h"

#include <math.h>
#include <string.h>

enum { DEEPEST = 44 }; /* halvings: x is then known to 6e-14 */

void bs_roots_bernstein(int degree, const double *power, double *bernstein) {
  /* b_k = sum_{i<=k} C(k,i)/C(d,i) a_i, built by differences: the table of
   * forward differences of b starts with a_i / C(d,i) */
  double difference[BS_ROOTS_DEGREE + 1];
  double choose = 1.0;
  for (int i = 0; i <= degree; i++) {
    difference[i] = power[i] / choose;
    choose = choose * (degree - i) / (i + 1);
  }
  for (int k = 0; k <= degree; k++) {
    bernstein[k] = difference[0];
    for (int i = 0; i < degree - k; i++) {
      difference[i] += difference[i + 1];
    }
  }
}

void bs_roots_shift(int degree, double *power, double at, double width) {
  for (int i = 0; i < degree; i++) {
    for (int k = degree - 1; k >= i; k--) {
      power[k] += at * power[k + 1];
    }
  }
  double scale = 1.0;
  for (int k = 0; k <= degree; k++) {
    power[k] *= scale;
    scale *= width;
  }
}

/* Split b at 1/2 by de Casteljau: b becomes the right half. */
static void halve(int degree, double *b, double *left) {
  for (int k = 0; k <= degree; k++) {
    left[k] = b[0];
    for (int i = 0; i < degree - k; i++) {
      b[i] = 0.5 * (b[i] + b[i + 1]);
    }
  }
  /* b now holds the last value of each level: the right half in order */
}

/* Sign changes of the coefficients, zeros skipped. */
static int variations(int degree, const double *b) {
  int count = 0, sign = 0;
  for (int i = 0; i <= degree; i++) {
    const int now = (b[i] > 0.0) - (b[i] < 0.0);
    if (now != 0) {
      count += sign != 0 && now != sign;
      sign = now;
    }
  }
  return count;
}

static double value(int degree, const double *b, double x) {
  double work[BS_ROOTS_DEGREE + 1];
  memcpy(work, b, (size_t)(degree + 1) * sizeof(double));
  for (int k = degree; k > 0; k--) {
    for (int i = 0; i < k; i++) {
      work[i] += x * (work[i + 1] - work[i]);
    }
  }
  return work[0];
}

/* The one root of b in [0, 1], b(0) > 0 >= b(1): regula falsi with Illinois
 * weights, guarded by bisection. */
static double single_root(int degree, const double *b) {
  double low = 0.0, high = 1.0, at_low = b[0], at_high = b[degree];
  int side = 0;
  for (int i = 0; i < 200 && high - low > 4e-17 * (low + high) && at_high < 0.0;
       i++) {
    double x = (low * at_high - high * at_low) / (at_high - at_low);
    if (!(x > low && x < high) || i % 8 == 7) {
      x = 0.5 * (low + high);
      if (x <= low || x >= high) {
        break;
      }
    }
    const double p = value(degree, b, x);
    if (p > 0.0) {
      low = x;
      at_low = p;
      at_high *= side == 1 ? 0.5 : 1.0;
      side = 1;
    } else {
      high = x;
      at_high = p;
      at_low *= side == -1 ? 0.5 : 1.0;
      side = -1;
    }
  }
  return high;
}

static int first_from(int degree, double *b, int depth, double low, double high,
                      double *x) {
  if (b[0] <= 0.0) {
    *x = low;
    return 1;
  }
  const int changes = variations(degree, b);
  if (changes == 0) {
    if (b[degree] == 0.0) {
      *x = high;
      return 1;
    }
    return 0;
  }
  if (changes == 1 && b[degree] < 0.0) {
    *x = low + (high - low) * single_root(degree, b);
    return 1;
  }
  if (depth == DEEPEST) {
    return 0;
  }
  double left[BS_ROOTS_DEGREE + 1];
  const double middle = 0.5 * (low + high);
  halve(degree, b, left);
  return first_from(degree, left, depth + 1, low, middle, x) ||
         first_from(degree, b, depth + 1, middle, high, x);
}

int bs_roots_first(int degree, const double *bernstein, double *x) {
  double b[BS_ROOTS_DEGREE + 1];
  int alive = 0;
  for (int i = 0; i <= degree; i++) {
    b[i] = bernstein[i];
    alive |= b[i] != 0.0;
  }
  return alive && first_from(degree, b, 0, 0.0, 1.0, x);
}

/* Places where -b falls through zero, i.e. where b rises: minima of the
 * polynomial whose derivative b is. */
static int rises(int degree, double *b, int depth, double low, double high,
                 int capacity, double *x) {
  const int changes = variations(degree, b);
  if (capacity == 0 || changes == 0) {
    return 0;
  }
  if (changes == 1 && b[0] != 0.0 && b[degree] != 0.0) {
    if (b[0] > 0.0) {
      return 0;
    }
    double flipped[BS_ROOTS_DEGREE + 1];
    for (int i = 0; i <= degree; i++) {
      flipped[i] = -b[i];
    }
    x[0] = low + (high - low) * single_root(degree, flipped);
    return 1;
  }
  if (depth == DEEPEST) {
    return 0;
  }
  double left[BS_ROOTS_DEGREE + 1];
  const double middle = 0.5 * (low + high);
  halve(degree, b, left);
  const int joined =
      left[degree] == 0.0 && degree > 0 && left[degree - 1] < 0.0 && b[1] > 0.0;
  int found = rises(degree, left, depth + 1, low, middle, capacity, x);
  if (joined && found < capacity) {
    x[found++] = middle; /* the minimum lies exactly on the cut */
  }
  return found +
         rises(degree, b, depth + 1, middle, high, capacity - found, x + found);
}

int bs_roots_minima(int degree, const double *bernstein, double limit,
                    int capacity, double *x, double *minimum) {
  double slope[BS_ROOTS_DEGREE + 1];
  int low = 0;
  for (int i = 0; i <= degree; i++) {
    low |= bernstein[i] < limit;
  }
  if (!low || degree < 2) {
    return 0; /* the hull stays above the limit */
  }
  for (int i = 0; i < degree; i++) {
    slope[i] = degree * (bernstein[i + 1] - bernstein[i]);
  }
  int found = rises(degree - 1, slope, 0, 0.0, 1.0, capacity, x), kept = 0;
  for (int i = 0; i < found; i++) {
    const double p = value(degree, bernstein, x[i]);
    if (p < limit && x[i] > 0.0 && x[i] < 1.0) {
      x[kept] = x[i];
      minimum[kept++] = p;
    }
  }
  return kept;
}

void bs_roots_value(int degree, const double *bernstein, double x, double *p,
                    double *slope, double *curvature) {
  double first[BS_ROOTS_DEGREE + 1], second[BS_ROOTS_DEGREE + 1];
  for (int i = 0; i < degree; i++) {
    first[i] = degree * (bernstein[i + 1] - bernstein[i]);
  }
  for (int i = 0; i + 1 < degree; i++) {
    second[i] = (degree - 1) * (first[i + 1] - first[i]);
  }
  *p = value(degree, bernstein, x);
  *slope = degree > 0 ? value(degree - 1, first, x) : 0.0;
  *curvature = degree > 1 ? value(degree - 2, second, x) : 0.0;
}
