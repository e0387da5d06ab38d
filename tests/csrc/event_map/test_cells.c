/* Cells of one mass against its closed form. */
#include "mass.h"

static void advance_is_the_exponential(void) {
  mass it = {.c = 0.0, .k = 1.0, .F = 0.0, .Omega = 2.0};
  mass_create(&it, 1);
  double y[] = {0.3, -0.2, 1.0, 0.0, 1.0, 0.0}, after[6], term[12];
  for (double u = 0.0; u <= 1.0; u += 0.125) {
    double t = u * it.free.cells.d;
    bm_cells_advance(&it.free.cells, 6, u, y, after, term);
    NEAR(after[0], 0.3 * cos(t) - 0.2 * sin(t), 1e-15);
    NEAR(after[1], -0.3 * sin(t) - 0.2 * cos(t), 1e-15);
    NEAR(after[2], 1.0, 0.0);
    NEAR(after[4], cos(2.0 * t), 1e-15);
    NEAR(after[5], sin(2.0 * t), 1e-15);
  }
  mass_free(&it);
}

static void taylor_rows_are_derivatives(void) {
  mass it = {.c = 0.0, .k = 1.0, .Omega = 2.0};
  mass_create(&it, 1);
  double y[] = {0.3, -0.2, 1.0, 0.0, 1.0, 0.0}, size, d = it.free.cells.d;
  double wanted[] = {-0.2, -0.3, 0.2, 0.3}, scale = 1.0;
  for (int j = 0; j < 8; j++) { /* v = -0.3 sin - 0.2 cos */
    NEAR(bm_cells_taylor(&it.free.cells, 6, j, y, &size),
         wanted[j % 4] * scale, 1e-16);
    CHECK(size >= fabs(wanted[j % 4] * scale) * (1.0 - 1e-12));
    scale *= d / (j + 1);
  }
  mass_free(&it);
}

static void apply_is_the_product(void) {
  double A[] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, x[] = {7.0, -1.0}, out[3];
  bm_cells_apply(3, 2, A, x, out);
  CHECK(out[0] == 3.0 && out[1] == 9.0 && out[2] == 15.0);
}

int main(void) {
  advance_is_the_exponential();
  taylor_rows_are_derivatives();
  apply_is_the_product();
  return failures != 0;
}
