"""Every routine of a robot compared with independent methods for the same numbers, in one call."""

from mafsil.verification.verification import Check as Check
from mafsil.verification.verification import Verification as Verification
from mafsil.verification.verify import verify as verify
