r"""How fast the sine series of a bent belt must converge.

The curvature that the pulleys impose couples the stretch of a span to its sine k with

    A_k = k pi delta^2 (-kappa_0 + (-1)^k kappa_1) / (1 + (k pi delta)^2)  ->  const / (k pi)

beyond the bending layer, k >> 1/(pi delta). The stiffness of that sine is dominated by bending,
(k pi)^4 eps^2. What the sines above N give way is therefore

    sum_{k > N} A_k^2 / stiffness_k  ~  sum_{k > N} k^-2 k^-4  ~  N^-5.

Adding it statically (residual flexibility) leaves the inertia and the Coriolis coupling of these
sines with those kept, which is smaller but falls with the same power: the coupling of sine k with
a low sine j goes like j/k, against a stiffness like k^4, and its own excitation like k^-1.
"""

EXPONENT = -5.0
#: Claim: the residual flexibility makes the error at least this many times smaller.
GAIN = 3.0
