#include "friction.h"

#include <math.h>

double bs_friction_level(const bs_friction *friction, bs_mode mode) {
  if (mode == BS_SLIP_POS) {
    return friction->Q_m;
  }
  return mode == BS_SLIP_NEG ? -friction->Q_m : 0.0;
}

bs_mode bs_friction_mode_at_rest(const bs_friction *friction,
                                 const double *series, const double *noise,
                                 int order, int on_limit) {
  const double excess = fabs(series[0]) - friction->Q_s;
  if (!on_limit && excess > noise[0]) {
    return series[0] > 0.0 ? BS_SLIP_POS : BS_SLIP_NEG;
  }
  if (!on_limit && excess < -noise[0]) {
    return BS_STICK;
  }
  /* without static friction both limits are zero: any growth is a release */
  const int no_limit = friction->Q_s <= noise[0];
  const double side = series[0] > 0.0 ? 1.0 : -1.0;
  for (int k = 1; k <= order; k++) {
    if (fabs(series[k]) > noise[k]) {
      if (no_limit) {
        return series[k] > 0.0 ? BS_SLIP_POS : BS_SLIP_NEG;
      }
      if (side * series[k] < 0.0) {
        return BS_STICK;
      }
      return side > 0.0 ? BS_SLIP_POS : BS_SLIP_NEG;
    }
  }
  return BS_STICK;
}

int bs_friction_kind(bs_mode from, bs_mode to, bs_kind *kind) {
  if (from == to) {
    return -1;
  }
  if (to == BS_STICK) {
    *kind = BS_EVENT_STICK;
  } else if (from == BS_STICK) {
    *kind = to == BS_SLIP_POS ? BS_EVENT_SLIP_POS : BS_EVENT_SLIP_NEG;
  } else {
    *kind = BS_EVENT_REVERSE;
  }
  return 0;
}
