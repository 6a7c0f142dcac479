"""Jobs of more than one motion: pieces, what a gripper does between them, and loops.

Everything is planned and checked before anything moves, also the slow ways between pieces whose
ends differ. Knows no ports and no files but job files.
"""

from .carrying import carry_out_sequence as carry_out_sequence
from .carrying import resume_sequence as resume_sequence
from .planning import is_sequence as is_sequence
from .planning import plan_sequence as plan_sequence
from .result import SequenceResult as SequenceResult
from .result import StepRun as StepRun
from .step import PlannedSequence as PlannedSequence
from .step import Step as Step
from .step import StepKind as StepKind
