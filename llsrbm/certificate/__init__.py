"""The certificate of a motion: what an outside checker finds of it, at 1 kHz, on the plain URDF.

Nothing of the planner or its models enters. Each check is a small class with a name, listed in
`certificate.CHECKS`; it gives a `Finding`.
"""

from llsrbm.certificate.certificate import CHECKS, Certificate, certified, certify, stated
from llsrbm.certificate.finding import Check, Finding

__all__ = ["CHECKS", "Certificate", "Check", "Finding", "certified", "certify", "stated"]
