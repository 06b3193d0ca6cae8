"""Object files for processors that LLVM knows, and what stands in them."""

__all__ = ()
