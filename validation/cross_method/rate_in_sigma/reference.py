"""Why the difference between the two laws is linear in sigma.

A crossing of zero takes the velocity through the band. The joint's acceleration is a- before and a+
after it, which differ, because the torque changes sign: the saturated torque lags Coulomb's for
about sigma/a- before and leads it for sigma/a+ after, so an impulse of about
Q_m sigma (1/a- - 1/a+)/2 is left. A joint that sticks for a time T_s under Coulomb's law creeps
with up to sigma meanwhile and so moves by up to sigma T_s. Both are of first order in sigma.
"""

EXPONENT = 1.0
