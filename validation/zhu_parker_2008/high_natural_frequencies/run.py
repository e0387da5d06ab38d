"""Two high natural frequencies, in three series."""

import beltsim
from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES

OMEGA = {"13th": 4.5, "15th": 4.2}


def compute() -> list[tuple[str, float, float]]:
    shorter = {"n_functions": (3, 5, 5), "residual_flexibility": False}
    drive = beltsim.presets.zhu_parker_2008()
    rows = []
    for series, options in (SERIES | {"N = (3, 5, 5)": shorter}).items():
        for name, expected in printed(__file__).items():
            at = beltsim.assemble(drive, OMEGA[name], **options)
            got = beltsim.linear.modes(at).frequencies[int(name[:2]) - 1]
            rows.append((f"{name}, {series}", float(got), expected))
    return rows
