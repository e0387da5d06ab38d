/* A flow from its matrices, and the changes between flows, for one mass whose
 * flows mass.h packs by hand. */
#include "flow.h"
#include "lapack.h"
#include "mass.h"

static const double one = 1.0, minus = -1.0, velocity[2] = {0.0, 1.0};

static bm_system system_of(const mass *it, double F[4], double direct[4]) {
  F[0] = F[1] = F[3] = 0.0;
  F[2] = it->F;
  for (int i = 0; i < 4; i++) {
    direct[i] = 0.0;
  }
  bm_system of = {1,  1, it->Omega, &one, &it->c, &it->k, F, &minus, velocity,
                  direct, 0.0};
  return of;
}

static void modes_are_those_by_hand(void) {
  mass it = {.c = 0.3, .k = 2.0, .F = 0.7, .Omega = 0.9, .Q_m = 0.4, .Q_s = 0.4};
  mass_create(&it, 0);
  double F[4], direct[4];
  bm_system of = system_of(&it, F, direct);
  double *packed = calloc((size_t)bm_flow_reals(2, 2, 1), sizeof(double));
  int m = 0;
  bm_soundness sound;
  CHECK(bm_modes(&small_lapack, &of, packed, &m, &sound) == BM_OK);
  CHECK(m == 1);
  bm_flow flow;
  bm_flow_unpack(&flow, packed, 2, 1, 1, it.Omega);
  NEAR(flow.lambda_re[0], it.free.lambda_re[0], 1e-14);
  NEAR(flow.lambda_im[0], it.free.lambda_im[0], 1e-14);
  for (int i = 0; i < 4; i++) {
    NEAR(flow.P_re[i], it.free.P_re[i], 1e-14);
    NEAR(flow.P_im[i], it.free.P_im[i], 1e-14);
  }
  NEAR(flow.X_c[0], it.free.X_c[0], 1e-14);
  CHECK(sound.condition >= 1.0 && sound.condition < 1.1);
  NEAR(sound.stiffness, 1.0, 1e-14);
  CHECK(sound.nearest > 0.4 && sound.nearest_mean >= sound.nearest);
  bm_watch watches[2]; /* the same motion, whatever the scale of the modes */
  CHECK(bm_watch_create(&watches[0], &flow));
  CHECK(bm_watch_create(&watches[1], &it.free));
  double start[2] = {0.3, -0.2}, x[2][2];
  for (int i = 0; i < 2; i++) {
    bm_watch_begin(&watches[i], 0.4, 0.2, start);
    bm_watch_state(&watches[i], 0.4, 0.2, 1.7, x[i]);
    bm_watch_free(&watches[i]);
  }
  NEAR(x[0][0], x[1][0], 1e-13);
  NEAR(x[0][1], x[1][1], 1e-13);
  double changes[64], *kept = it.changes_packed;
  bm_joint joint = {0, 1.0, NULL, &one};
  CHECK(bm_changes_reals(1, 0) <= 64);
  CHECK(bm_changes_fill(&it.free, &it.held, &joint, changes) == BM_OK);
  for (int i = 0; i < (int)bm_changes_reals(1, 0); i++) {
    NEAR(changes[i], kept[i], 1e-14);
  }
  free(packed);
  mass_free(&it);
}

/* Without stiffness a constant load has no answer, and that is told. */
static void no_answer_is_infinite(void) {
  mass it = {.c = 0.3, .k = 2.0, .F = 0.7, .Omega = 0.9, .Q_m = 0.4, .Q_s = 0.4};
  double F[4], direct[4], nothing = 0.0;
  bm_system of = system_of(&it, F, direct);
  double *packed = calloc((size_t)bm_flow_reals(2, 2, 1), sizeof(double));
  int m = 0;
  bm_soundness sound;
  of.K = &nothing;
  CHECK(bm_modes(&small_lapack, &of, packed, &m, &sound) == BM_OK);
  CHECK(sound.stiffness == HUGE_VAL);
  of.M = &nothing;
  CHECK(bm_modes(&small_lapack, &of, packed, &m, &sound) == BM_NO_MODES);
  free(packed);
}

/* A held joint of one mass leaves nothing that moves. */
static void nothing_left_has_no_modes(void) {
  double none[1] = {0.0}, direct[4] = {0.1, 0.0, 0.5, -0.5}, packed[1024];
  bm_system of = {0,    1,    0.9,  none,   none, none,
                  none, none, none, direct, -2.0};
  int m = 7;
  bm_soundness sound;
  CHECK(bm_flow_reals(0, 0, 1) <= 1024);
  CHECK(bm_modes(&small_lapack, &of, packed, &m, &sound) == BM_OK);
  CHECK(m == 0 && sound.condition == 1.0);
  bm_flow flow;
  bm_flow_unpack(&flow, packed, 0, 0, 1, 0.9);
  CHECK(flow.d_c == -2.0 && flow.D_re[1] == 0.5 && flow.D_im[1] == -0.5);
}

int main(void) {
  modes_are_those_by_hand();
  no_answer_is_infinite();
  nothing_left_has_no_modes();
  return failures != 0;
}
