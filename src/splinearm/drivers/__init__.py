"""Arms that move: registers and packets of servos, the bus, and the arm made of servos.

Knows joints in SI and servos in ticks, and is the only place where one becomes the other. Knows
nothing of poses, curves or files about arms.
"""

from .base import ArmDriver as ArmDriver
from .chain import ServoChain as ServoChain
from .chain import ServoRole as ServoRole
from .chain import ServoSpec as ServoSpec
from .model import ServoModel as ServoModel
from .model import servo_model as servo_model
from .registers import ControlTable as ControlTable
from .registers import Register as Register
from .registers import load_table as load_table
