"""All relations. What must hold of every run without knowing its right values; each returns sentences, one per violation."""
import balances  # noqa: F401  (each enters its relations into the register)
import invariance  # noqa: F401
import numerics  # noqa: F401
import outputs  # noqa: F401
import similar  # noqa: F401
from case import RELATIONS, Case, last_line  # noqa: F401
