"""Frequencies of the spans of the paper's drive without bending stiffness."""

import numpy as np

import beltsim
from validation.analytic.string_spans.reference import frequencies
from validation.row import Row

COUNT = 4
COARSE, FINE = 20, 40
ORDER = 3
LABEL = "frequency over closed form"


def compute() -> list[Row]:
    drive = beltsim.presets.zhu_parker_2008(epsilon=0.0)
    k = np.arange(1, COUNT + 1)
    rows, orders = [], []
    for Omega in (0.5, 6.3, 12.0):
        coarse, fine = (_of_spans(drive, Omega, n) for n in (COARSE, FINE))
        exact = frequencies(Omega, COUNT)
        extrapolated = fine + (fine - coarse) / ((FINE / COARSE) ** ORDER - 1.0)
        for i in range(3):
            name = f"span {i + 1}, Omega = {Omega}, k = 1 to {COUNT}"
            rows.append(
                Row(
                    name, extrapolated[i] / exact[i], np.ones(COUNT), k, "number of the mode", LABEL
                )
            )
        orders.append(np.log2((coarse / exact - 1.0) / (fine / exact - 1.0)))
    order = float(np.mean(orders))
    return [*rows, Row("order of convergence, mean", order, float(ORDER))]


def _of_spans(drive: beltsim.Drive, Omega: float, n: int) -> np.ndarray:
    """First frequencies of the three spans, told apart by what moves in their modes."""
    problem = beltsim.assemble(drive, Omega, n_functions=n)
    modes = beltsim.linear.modes(problem, locked=True)
    found = []
    for i in range(3):
        in_span = [label.startswith(f"span{i + 1}.") for label in problem.labels]
        size = np.abs(modes.shapes)
        own = size[:, in_span].max(axis=1) > 1e6 * size[:, np.logical_not(in_span)].max(axis=1)
        found.append(modes.frequencies[own][:COUNT])
    return np.array(found)
