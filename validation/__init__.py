"""Is it right? Cases that compare beltsim with sources outside itself.

A case is a folder `<family>/<case>/` with `case.toml` (what is claimed, by whom, how closely and
why that closely), `run.py` (what beltsim computes) and `reference.csv` or `reference.py` (what it
should be, from a source that shares no code with beltsim). The harness compares and gives a
verdict; `python -m validation.run --list` names the cases.
"""
