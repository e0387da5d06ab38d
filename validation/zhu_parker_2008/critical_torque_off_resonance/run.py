"""Critical torque over the crank's torque on the arm, between the resonances."""

from validation.reference import printed
from validation.zhu_parker_2008.critical_torque_off_resonance.reference import crank_torque
from validation.zhu_parker_2008.paper import SHORT, critical_torque


def compute() -> list[tuple[str, float, float]]:
    rows = []
    for Omega, expected in printed(__file__).items():
        ratio = critical_torque(float(Omega), SHORT) / crank_torque(0.01, float(Omega))
        rows.append((f"Omega = {Omega}", ratio, expected))
    return rows
