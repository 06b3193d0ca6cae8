"""Rigid motion as CasADi expressions: written once, compiled by `mafsil.kernels`; knows no robot and no arrays."""
