"""Derivations a teacher accepts: numbered steps in letters, every line compared with the compiled robot."""

from mafsil.derivation.document import Derivation as Derivation
from mafsil.derivation.fk import derive_fk as derive_fk
from mafsil.derivation.html import to_html as to_html
from mafsil.derivation.jacobian import derive_jacobian as derive_jacobian
from mafsil.derivation.latex import to_latex as to_latex
from mafsil.derivation.text import to_text as to_text
from mafsil.derivation.verification import DerivationError as DerivationError
