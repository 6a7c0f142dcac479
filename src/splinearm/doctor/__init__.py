"""What is wrong with an arm, its line, its port and this computer, before anything moves.

Every check looks and changes nothing: no servo is written to, nothing moves. What is found is a
``Finding`` with a code, a cause and what mends it; ``catalogue`` has all codes. Loads nothing but
the standard library until a port is to be looked at, so that it works where a library is missing.
"""

from .finding import Finding as Finding
from .finding import Severity as Severity
