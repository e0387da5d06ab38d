"""After `compile_kernels` a solution compiles nothing."""

from __future__ import annotations

from support.problems import random_problem

from beltsim.friction import SaturatedCoulomb
from beltsim.harmonic_balance import (
    Settings,
    _bands,
    _impedances,
    _switching,
    compile_kernels,
    solve,
)

KERNELS = (_impedances.condensed, _impedances.coordinates, _switching.searched, _bands.projected)


def signatures():
    return [kernel.signatures for kernel in KERNELS if hasattr(kernel, "signatures")]


def test_no_kernel_is_compiled_afterwards():
    compile_kernels()
    before = signatures()
    problem = random_problem(3, 4, static=False, share=0.4)
    solve(problem, 9)
    band = problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, 0.01))
    solve(band, 9, Settings(projection="exact", start="set_valued", estimate=False))
    assert signatures() == before
