"""An independent evaluation of the belt model, to compare `beltsim.model` with.

It shares no code and no closed form with the package. The nonlinear equations are written down as
they stand, in the frame of the drive file and for either sense of travel (`way` = +1 when the belt
travels along x, -1 against it), in dimensional ratios to the mean span length:

* a span's steady shape solves its boundary-value problem with the four functions 1, x and two
  decaying exponentials; its integrals are Gauss sums on panels graded towards the ends;
* the steady state is Newton's on all tensions, pulley angles and the arm, with a complex-step
  Jacobian;
* M, G and K are complex-step Jacobians of the nonlinear residual, tested with the sine functions
  and, for the arm, with the shape that its rotation gives the neighbouring spans.

Coordinates: sines of span 1, 2, ..., all pulleys, arm (if any), as listed in the drive file.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.optimize

STEP = 1e-30


class Span:
    """One span: numbers, quadrature nodes, and its steady shape for any tension."""

    def __init__(self, length, s, eps2, ends, n_sines):
        self.length, self.s, self.eps2, self.ends = length, s, eps2, ends
        self.k = np.arange(1, n_sines + 1)

    def panels(self, T):
        """Nodes and weights on [0, 1], graded where the belt bends."""
        edges = set(np.linspace(0.0, 1.0, 2 + 2 * int(self.k[-1] // 6)))
        width = np.sqrt(self.eps2 / T)
        while 0.0 < width < 0.5:
            edges |= {0.5 * width, 1.0 - 0.5 * width}
            width *= 2.0
        edges = np.array(sorted(edges))
        nodes, weights = np.polynomial.legendre.leggauss(20)
        half = 0.5 * np.diff(edges)[:, None]
        x = edges[:-1, None] + half * (1.0 + nodes)
        self.x, self.weights = x.ravel(), (half * weights).ravel()
        angle = np.pi * np.multiply.outer(self.x, self.k)
        wave = np.pi * self.k
        self.sine = np.sin(angle)
        self.sine_x = wave * np.cos(angle)
        self.sine_xx = -(wave**2) * self.sine
        self.sine_xxxx = wave**4 * self.sine

    def shape(self, T, w_0, w_1, x):
        """Steady deflection and its first four derivatives at x, shape (5, nx)."""
        zero, one = np.zeros_like(x), np.ones_like(x)
        if self.eps2 == 0.0:
            return np.array([w_0 + (w_1 - w_0) * x, (w_1 - w_0) * one, zero, zero, zero])
        rate = np.sqrt(T / self.eps2)
        far = np.exp(-rate)
        left, right = np.exp(-rate * x), np.exp(-rate * (1.0 - x))
        matrix = np.array(
            [
                [1.0, 0.0, 1.0, far],
                [1.0, 1.0, far, 1.0],
                [0.0, 0.0, rate**2, rate**2 * far],
                [0.0, 0.0, rate**2 * far, rate**2],
            ]
        )
        c = np.linalg.solve(matrix, np.array([w_0, w_1, *self.ends]))
        derivatives = [c[0] + c[1] * x, c[1] * one, zero, zero, zero]
        return np.array(
            [
                line + c[2] * (-rate) ** order * left + c[3] * rate**order * right
                for order, line in enumerate(derivatives)
            ]
        )

    def stretch(self, T, w_0, w_1):
        """Half the integral of the squared slope of the steady shape."""
        return 0.5 * np.sum(self.weights * self.shape(T, w_0, w_1, self.x)[1] ** 2)

    def end_pull(self, T, w_0, w_1, end):
        """T w_x - eps2 w_xxx of the steady shape at x = 0 or 1."""
        found = self.shape(T, w_0, w_1, np.array([float(end)]))[:, 0]
        return T * found[1] - self.eps2 * found[3]


class StrongForm:
    """The drive at one operating point: steady state and Jacobians."""

    def __init__(self, drive, Omega, counts, residual_flexibility=True):
        layout = drive.layout
        self.drive, self.layout, self.Omega = drive, layout, Omega
        self.n = n = layout.n
        self.scale = scale = float(np.mean(layout.span_length_m))
        self.P0 = P0 = drive.belt.initial_tension_N
        self.unit = unit = drive.belt.mass_per_length_kg_m * scale**2
        self.way = 1.0 if layout.travel == "ccw" else -1.0
        self.r, self.l = layout.radius_m / scale, layout.span_length_m / scale
        self.m = layout.inertia_kg_m2 / (unit * layout.radius_m)
        self.alpha = drive.excitation.firing_order
        self.s = s = self.r[layout.crank] * Omega / self.alpha
        self.gamma = drive.belt.EA_N / P0
        self.torque = -layout.accessory_torque_N_m / (P0 * layout.radius_m)
        eps2 = drive.bending_stiffness_N_m2 / (P0 * scale**2)
        bend = layout.side / self.r if eps2 else 0.0 * self.r
        self.spans = [
            Span(l, s * l, eps2 / l**2, (l * bend[i], l * bend[(i + 1) % n]), counts[i])
            for i, l in enumerate(self.l)
        ]
        self._set_arm()
        self._find_steady_state()
        self.stiff = np.full(n, self.gamma)
        if residual_flexibility:
            for i, span in enumerate(self.spans):
                self.stiff[i] = self.gamma / (1.0 + self.gamma * self._left_out(i, span))
        self._differentiate()

    def _set_arm(self):
        layout, n = self.layout, self.n
        self.arm = layout.arm
        self.start, self.end, self.pull = np.zeros((3, n))  # deflections and stretch per angle
        self.m_t = self.k_s = self.preload = 0.0
        self.r_t = 1.0
        if self.arm is None:
            return
        tensioner, T = self.drive.tensioner, self.arm
        self.r_t = layout.arm_length_m / self.scale
        self.m_t = tensioner.arm_inertia_kg_m2 / (self.unit * layout.arm_length_m)
        self.k_s = tensioner.spring_rate_N_m_per_rad / (self.P0 * layout.arm_length_m)
        self.pull[T - 1] -= self.r_t * np.sin(layout.beta_1)
        self.pull[T] += self.r_t * np.sin(layout.beta_2)
        self.end[T - 1] = self.r_t / self.l[T - 1] * np.cos(layout.beta_1)
        self.start[T] = self.r_t / self.l[T] * np.cos(layout.beta_2)
        self.preload = np.sin(layout.beta_1) - np.sin(layout.beta_2)

    # --- steady state: unknowns p (n), pulley angles (n, the crank's is zero), arm angle ---

    def _balance(self, z):
        n, s = self.n, self.s
        p, theta, arm = z[:n], z[n : 2 * n], z[-1]
        wound = -self.way * (self.r * theta - np.roll(self.r * theta, -1))
        found = np.zeros(2 * n + 1, dtype=z.dtype)
        for i, span in enumerate(self.spans):
            bent = span.stretch(p[i] - s**2, self.start[i] * arm, self.end[i] * arm)
            strain = (wound[i] + self.pull[i] * arm) / self.l[i] + bent
            found[i] = p[i] - 1.0 - self.gamma * strain
        found[n : 2 * n] = -self.way * (p - np.roll(p, 1)) - self.torque
        found[n + self.layout.crank] = theta[self.layout.crank]
        found[-1] = arm if self.arm is None else self.k_s * arm + self.preload
        if self.arm is not None:
            found[-1] -= self._steady_moment(p, arm)
        return found

    def _steady_moment(self, p, arm):
        T, (b1, b2) = self.arm, (self.layout.beta_1, self.layout.beta_2)
        before, after = p[T - 1] - self.s**2, p[T] - self.s**2
        first = self.spans[T - 1].end_pull(
            before, self.start[T - 1] * arm, self.end[T - 1] * arm, 1
        )
        last = self.spans[T].end_pull(after, self.start[T] * arm, self.end[T] * arm, 0)
        return np.sin(b1) * before - np.cos(b1) * first - np.sin(b2) * after + np.cos(b2) * last

    def _find_steady_state(self):
        n = self.n
        z = np.concatenate([np.full(n, 1.0 + self.s**2), np.zeros(n + 1)])
        for _ in range(100):
            for i, span in enumerate(self.spans):
                span.panels(z[i] - self.s**2)
            step = np.linalg.solve(jacobian(self._balance, z), -self._balance(z))
            while np.any(z[:n] + step[:n] - self.s**2 <= 0.05 * (z[:n] - self.s**2)):
                step *= 0.5
            z = z + step
            if np.abs(step).max() < 1e-13:
                break
        assert np.abs(step).max() < 1e-11
        self.p, self.theta_t = z[:n], z[-1]
        self.w_0, self.w_1 = self.start * self.theta_t, self.end * self.theta_t
        self.steady = [
            span.shape(self.p[i] - self.s**2, self.w_0[i], self.w_1[i], span.x)
            for i, span in enumerate(self.spans)
        ]

    def _left_out(self, i, span):
        """Static flexibility of the sines beyond those kept."""
        T = self.p[i] - self.s**2
        total = -span.stretch(T + 1j * STEP, self.w_0[i], self.w_1[i]).imag / STEP
        work = span.weights * self.steady[i][1] @ span.sine_x
        stiff = T * (span.weights @ span.sine_x**2) + span.eps2 * (span.weights @ span.sine_xx**2)
        return total - np.sum(work**2 / stiff)

    # --- the nonlinear residual about the steady state, and its Jacobians ---

    def _residual(self, q, q_dot, q_ddot):
        n, way, s = self.n, self.way, self.s
        P = sum(len(span.k) for span in self.spans)
        theta, theta_ddot = q[P : P + n], q_ddot[P : P + n]
        arm, arm_dot, arm_ddot = (
            v[-1] if self.arm is not None else 0.0 for v in (q, q_dot, q_ddot)
        )
        wound = -way * (self.r * theta - np.roll(self.r * theta, -1))
        found = np.zeros(len(q), dtype=complex)
        p = np.zeros(n, dtype=complex)
        moment, first = 0.0, 0
        for i, span in enumerate(self.spans):
            at = slice(first, first + len(span.k))
            first = at.stop
            ramp = self.start[i] * (1.0 - span.x) + self.end[i] * span.x
            chord = self.end[i] - self.start[i]
            w_x = self.steady[i][1] + span.sine_x @ q[at] + chord * arm
            w_xx = self.steady[i][2] + span.sine_xx @ q[at]
            w_xxxx = self.steady[i][4] + span.sine_xxxx @ q[at]
            w_tt = span.sine @ q_ddot[at] + ramp * arm_ddot
            w_xt = span.sine_x @ q_dot[at] + chord * arm_dot
            bent = 0.5 * np.sum(span.weights * (w_x**2 - self.steady[i][1] ** 2))
            p[i] = self.p[i] + self.stiff[i] * (
                (wound[i] + self.pull[i] * arm) / span.length + bent
            )
            force = span.length**2 * w_tt + 2.0 * way * span.s * w_xt - (p[i] - s**2) * w_xx
            force = span.weights * (force + span.eps2 * w_xxxx)
            found[at] = span.length * (force @ span.sine)
            if self.arm is not None:
                found[-1] += span.length * (force @ ramp)
                moment += self._moment_of(i, span, p[i], q[at], arm, arm_dot)
        found[P : P + n] += self.r * (
            self.m * theta_ddot - way * (p - np.roll(p, 1)) - self._held_torque()
        )
        if self.arm is not None:
            spring = self.k_s * (self.theta_t + arm) + self.preload
            found[-1] += self.r_t * (self.m_t * arm_ddot + spring - moment)
        return found / self.r_t

    def _moment_of(self, i, span, p, a, arm, arm_dot):
        """What span i adds to the moment on the arm, straight from its end forces."""
        T, total = p - self.s**2, 0.0
        for end, angle, sign, index in (
            (1, self.layout.beta_1, 1.0, (self.arm - 1) % self.n),
            (0, self.layout.beta_2, -1.0, self.arm),
        ):
            if i != index:
                continue
            rest = span.shape(
                self.p[i] - self.s**2, self.w_0[i], self.w_1[i], np.array([float(end)])
            )[:, 0]
            wave, turn = np.pi * span.k, (-1.0) ** span.k if end else np.ones(len(span.k))
            w_x = rest[1] + np.sum(wave * turn * a) + (self.end[i] - self.start[i]) * arm
            w_xxx = rest[3] - np.sum(wave**3 * turn * a)
            w_t = (self.end[i] if end else self.start[i]) * arm_dot
            pull = T * w_x - span.eps2 * w_xxx - self.way * span.s * w_t
            total = total + sign * (np.sin(angle) * T - np.cos(angle) * pull)
        return total

    def _held_torque(self):
        return -self.way * (self.p - np.roll(self.p, 1))  # accessories, and the crank's reaction

    def _differentiate(self):
        P = sum(len(span.k) for span in self.spans)
        size = P + self.n + (self.arm is not None)
        zero = np.zeros(size)
        self.residual_at_rest = self._residual(zero, zero, zero)
        self.K = jacobian(lambda q: self._residual(q, zero, zero), zero)
        self.G = jacobian(lambda v: self._residual(zero, v, zero), zero)
        self.M = jacobian(lambda a: self._residual(zero, zero, a), zero)
        self.crank = P + self.layout.crank
        self.moving = np.delete(np.arange(size), self.crank)

    # --- what the comparisons need ---

    def reduced(self, name):
        """M, G or K without the crank."""
        return getattr(self, name)[np.ix_(self.moving, self.moving)]

    def damping(self):
        """Modal damping of the free-arm system."""
        M, K = self.reduced("M"), self.reduced("K")
        squares, modes = scipy.linalg.eigh(0.5 * (K + K.T), M)
        rates = 2.0 * self.drive.damping.ratio * np.sqrt(squares)
        return M @ (modes * rates) @ modes.T @ M

    def frequencies(self, locked=False):
        """Undamped gyroscopic frequencies from the general quadratic eigenproblem."""
        keep = slice(None, -1) if locked else slice(None)
        M, G, K = (self.reduced(name)[keep, keep] for name in "MGK")
        n = len(M)
        right = np.linalg.solve(M, np.hstack([K, G]))
        first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-right]])
        values = scipy.linalg.eigvals(first_order)
        return np.sort(values.imag)[n:]

    def reaction(self):
        """Torque that holds the arm, as a function of the crank's mean angle (rad)."""
        M, G, K = (self.reduced(name) for name in "MGK")
        C = self.damping()
        parts = []
        for order in self.drive.orders:
            rate = order.order * self.Omega / self.alpha
            angle = order.angle_amplitude_rad * np.exp(1j * (order.phase_rad - np.pi / 2.0))
            column = (
                self.K[:, self.crank]
                + 1j * rate * self.G[:, self.crank]
                - rate**2 * self.M[:, self.crank]
            )
            force = -angle * column[self.moving]
            dynamic = K + 1j * rate * (C + G) - rate**2 * M
            q = np.linalg.solve(dynamic[:-1, :-1], force[:-1])
            parts.append((order.order, force[-1] - dynamic[-1, :-1] @ q))
        return lambda turn: sum((c * np.exp(1j * order * turn)).real for order, c in parts)

    def critical_torque(self):
        """Half the peak-to-peak of the reaction, by sampling and minimising."""
        reaction = self.reaction()
        turn = np.linspace(0.0, 4.0 * np.pi, 4001)
        values = np.array([reaction(x) for x in turn])

        def peak(sign):
            best = turn[np.argmax(sign * values)]
            step = 2.0 * (turn[1] - turn[0])
            found = scipy.optimize.minimize_scalar(
                lambda x: -sign * reaction(x),
                bounds=(best - step, best + step),
                method="bounded",
                options={"xatol": 1e-12},
            )
            return -found.fun

        return 0.5 * (peak(1.0) + peak(-1.0))


def jacobian(function, z):
    """Complex-step Jacobian of `function` at `z`."""
    columns = []
    for i in range(len(z)):
        moved = z.astype(complex)
        moved[i] += 1j * STEP
        columns.append(function(moved).imag / STEP)
    return np.array(columns).T
