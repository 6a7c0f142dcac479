"""Arms moved by wishes as they come: joint by joint, or the tool along its axes."""

from .drive import JogState as JogState
from .hindrance import Broken as Broken
from .hindrance import Hindrance as Hindrance
from .jogger import Jogger as Jogger

__all__ = ["Broken", "Hindrance", "JogState", "Jogger"]
