"""Every threshold of the package with its reason. Lengths are compared over the size of the mechanism."""

LENGTH = 1e-12
"""Error of a leg over the size of the platform that ends Newton's method: a few thousand roundings."""
RANK = 1e-8
"""Singular values below this share of the largest count as zero: what nine typed digits of a geometry leave."""
SAME = 1e-6
"""Poses whose entries differ by less, lengths over the size, are one: a double solution in float64 splits by 1e-8."""
REAL = 1e-5
"""Imaginary parts below it are tried as real poses by Newton's method, which decides."""
FEASIBLE = 1e-9
"""Residual of a leg up to which a requested pose is accepted, lengths over the size."""
OPEN = 1e-6
"""Gap, lengths over the size, up to which a configuration that somebody typed closes the loops."""
DEFINITE = 1e-7
"""Second order forms of unit vectors below it vanish: a few times what RANK leaves of a vanishing form."""
POSSIBLE = 1e-7
"""Share of the forces that passive joints may seem to carry: RANK times what a least squares solution loses."""
