"""Derivations a teacher accepts: numbered steps in letters, every line compared with the compiled robot."""

from mafsil.derivation.check_dh import check_dh as check_dh
from mafsil.derivation.check_jacobian import check_jacobian as check_jacobian
from mafsil.derivation.check_screws import check_screws as check_screws
from mafsil.derivation.document import Derivation as Derivation
from mafsil.derivation.dynamics import derive_dynamics as derive_dynamics
from mafsil.derivation.fk import derive_fk as derive_fk
from mafsil.derivation.html import to_html as to_html
from mafsil.derivation.ik import derive_ik as derive_ik
from mafsil.derivation.jacobian import derive_jacobian as derive_jacobian
from mafsil.derivation.lagrange import derive_lagrange as derive_lagrange
from mafsil.derivation.latex import to_latex as to_latex
from mafsil.derivation.review import Finding as Finding
from mafsil.derivation.review import Mistake as Mistake
from mafsil.derivation.review import Review as Review
from mafsil.derivation.text import to_text as to_text
from mafsil.derivation.verification import DerivationError as DerivationError
