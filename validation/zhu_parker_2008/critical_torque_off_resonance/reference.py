"""Eq. (27): see the case torque_of_crank_on_arm."""

from validation.zhu_parker_2008.torque_of_crank_on_arm.reference import amplitude as crank_torque

__all__ = ["crank_torque"]
