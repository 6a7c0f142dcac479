"""Units that people use, as multiples of SI. For the borders only: files, messages, servos."""

from math import pi

MM = 1e-3
"""Metres in a millimetre."""

DEG = pi / 180.0
"""Radians in a degree."""

RPM = 2.0 * pi / 60.0
"""Radians per second in a revolution per minute."""
