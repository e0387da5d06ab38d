"""The ten lines of README: the paper's drive at one operating point, from the file to the events.

Run from the root of the repository: python examples/first_run.py
"""

import beltsim

drive = beltsim.load_drive("examples/zhu_parker_2008.toml")
problem = beltsim.assemble(drive, Omega=6.3, friction=beltsim.Coulomb(Q_m=3.5))
print(f"{problem.n} coordinates, crank at {drive.rpm(6.3):.0f} rpm")
print("lowest frequencies:", beltsim.linear.frequencies(problem)[:5].round(3))
print(f"locked for good from Q_m = {beltsim.linear.critical_torque(problem):.2f}")
response = beltsim.transient.integrate(problem, periods=100)
print(f"sticks {response.stick_fraction:.1%} of a period, loses {response.dissipated_energy:.4f}")
for i in range(-4, 0):
    print(f"t = {response.events.t[i]:.4f}: {response.events.kind[i]}")
