"""Families of exercises for chapters 5 to 8 beside those of planar arms: frames of links, closed chains, structure."""
