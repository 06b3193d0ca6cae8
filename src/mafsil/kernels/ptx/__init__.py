"""A batch as one kernel for graphics processors: PTX text, checked without a device."""

__all__ = ()
