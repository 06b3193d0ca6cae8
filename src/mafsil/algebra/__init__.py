"""Rigid motion as expressions: written once, compiled by `mafsil.kernels`; knows no robot and no arrays."""

__all__ = ()
