"""The ten lines of README: the paper's drive at one operating point, its friction lock, one run.

Run: python examples/first_run.py
"""

import beltsim

drive = beltsim.load_drive("examples/zhu_parker_2008.toml")
problem = beltsim.assemble(drive, Omega=6.3, friction=beltsim.Coulomb(Q_m=3.5))
print(f"{problem.n} coordinates; {drive.rpm(6.3):.0f} rpm at the crank")
print("lowest frequencies, arm free:  ", beltsim.linear.modes(problem).frequencies[:4].round(3))
print("lowest frequencies, arm locked:", beltsim.linear.modes(problem, locked=True).frequencies[:4].round(3))
print(f"the arm locks for good from Q_m = {beltsim.linear.critical_torque(problem):.2f}")
response = beltsim.transient.integrate(problem, periods=100)
print(f"it sticks {response.stick_fraction:.1%} of each period, dissipating {response.dissipated_energy:.4f} P0 r_t")
print("last events:", ", ".join(f"{kind} at {t:.4f}" for t, kind in zip(response.events.t[-4:], response.events.kind[-4:])))
print(f"change over the last period: {response.period_residual:.1e}")
