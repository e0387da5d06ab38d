"""Resonances of the free arm, by what moves in them."""

from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, by_kind


def compute() -> list[tuple[str, float, float]]:
    rows = []
    for series in SERIES:
        found = by_kind(series, 1.5, 9.7)
        for name, expected in printed(__file__).items():
            kind, rank = name.split(", ")
            got = found[kind][int(rank[0]) - 1].Omega
            rows.append((f"{name}, {series}", got, expected))
    return rows
