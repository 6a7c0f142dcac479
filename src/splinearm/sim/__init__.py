"""Arms and servos that exist only here: an arm in MuJoCo, and servos on a pseudo terminal.

This room knows what arms weigh, what motors can give, and how servos answer byte for byte. It knows
nothing of curves and plans, and nothing of the bus client: the double checks the client and must
not share its mistakes.

- ``mujoco_arm``: ``MujocoArm``, an arm driver stepped by whoever holds it;
- ``virtual_bus``: ``VirtualBus``, the servos of an arm on a port of their own;
- ``virtual_servo``: ``VirtualServo``, one servo without a port.

Import from those; MuJoCo is loaded only with them.
"""

from .motor import Motor as Motor
from .motor import motors_for as motors_for
