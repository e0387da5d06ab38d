"""Drives known by name.

Depends on: schema.
"""

from __future__ import annotations

from beltsim.drive.schema import Drive


def zhu_parker_2008(
    epsilon: float = 0.01, zeta: float = 0.05, mu: float = 0.10, alpha: float = 3
) -> Drive:
    """The example drive of Zhu & Parker (2008), Table 1.

    Three pulleys, the second on the tensioner arm and on the belt's back, the crank first; the
    belt travels clockwise. Span lengths, alignment angles and arm length are the table's own
    figures, which differ from those of its coordinates in the last digit. The table's "tensioner
    rotation" is not used: the spring is taken to balance the initial tension.

    Chosen here, since the paper varies both: the friction torque 14.55 N m, which is Q_m = 0.5
    in units of P0 r_t, and the operating point Omega = 6.3.

    Parameters
    ----------
    epsilon : float, default 0.01
        Bending number of the belt, dimensionless.
    zeta : float, default 0.05
        Damping ratio of every mode.
    mu : float, default 0.10
        Amplitude of the crank speed over the mean speed.
    alpha : float, default 3
        Firing order, a multiple of 1/2.

    Returns
    -------
    Drive

    Raises
    ------
    InvalidDriveError
        When an argument is out of range.

    Notes
    -----
    Zhu, F., and Parker, R. G., 2008, J. Vib. Acoust. 130(1), 011002, Table 1,
    doi 10.1115/1.2775510.

    Examples
    --------
    >>> drive = zhu_parker_2008()
    >>> [pulley.side for pulley in drive.pulleys]
    ['inside', 'back', 'inside']
    """
    return Drive(
        name="Zhu & Parker 2008, Table 1",
        crank_rotation="cw",
        pulleys=[
            {
                "name": "1",
                "role": "crank",
                "side": "inside",
                "center_m": [0.5525, 0.0556],
                "radius_m": 0.0889,
                "inertia_kg_m2": 0.07248,
            },
            {
                "name": "2",
                "role": "arm",
                "side": "back",
                "center_m": [0.3477, 0.0572],
                "radius_m": 0.0452,
                "inertia_kg_m2": 0.000292,
            },
            {
                "name": "3",
                "role": "fixed",
                "side": "inside",
                "center_m": [0.0, 0.0],
                "radius_m": 0.0270,
                "inertia_kg_m2": 0.000292,
            },
        ],
        belt={
            "EA_N": 120000.0,
            "epsilon": epsilon,
            "mass_per_length_kg_m": 0.1029,
            "initial_tension_N": 300.0,
        },
        tensioner={
            "pivot_m": [0.2508, 0.0635],
            "arm_inertia_kg_m2": 0.001165,
            "spring_rate_N_m_per_rad": 28.25,
            "friction_torque_N_m": 14.55,
        },
        damping={"ratio": zeta},
        operating_point={"Omega": 6.3},
        excitation={"firing_order": alpha, "speed_fluctuation": mu},
        overrides={
            "span_lengths_m": [0.1548, 0.3449, 0.5518],
            "beta_1_deg": 135.79,
            "beta_2_deg": 178.74,
            "arm_length_m": 0.0970,
        },
    )
