"""One transient of the paper's drive by three solvers."""

import beltsim
from validation.cross_method.agreement import rows
from validation.cross_method.full_slip.reference import exact_modal
from validation.row import Row

PERIODS = 10


def compute() -> list[Row]:
    drive = beltsim.presets.zhu_parker_2008()
    problem = beltsim.assemble(drive, 6.3, friction=beltsim.Coulomb(0.5), n_functions=8)
    others = {"exact": exact_modal.run(problem, PERIODS)}
    return [row for rtol in (1e-8, 1e-10) for row in rows(problem, PERIODS, others, rtol)]
