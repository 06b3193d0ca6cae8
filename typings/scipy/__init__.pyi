"""What this package uses of SciPy, which carries no types."""
