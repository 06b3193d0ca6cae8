from mafsil.verification.verification import Check as Check
from mafsil.verification.verification import Verification as Verification
from mafsil.verification.verify import verify as verify
