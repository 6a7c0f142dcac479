"""How the servos of an arm fare, sample by sample: only looked at, never written to.

One group read a cycle brings what changes quickly, another now and then what changes slowly. What a
sample says goes to tables, JSON lines, CSV and UDP in the same numbers.
"""

from .monitor import Monitor as Monitor
from .sample import Level as Level
from .sample import Sample as Sample
from .sample import ServoSample as ServoSample
