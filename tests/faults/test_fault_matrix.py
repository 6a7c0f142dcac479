"""Every fault of the table, struck in the middle of a motion: what was promised holds."""

import numpy as np
import pytest
from fault_scene import DUE, Scene, Witness, require_setpoints_within_limits, torque_lost
from fault_table import FAULTS, Fault, Outcome

from splinearm.control import ending
from splinearm.errors import SplinearmError
from splinearm.units import DEG, MM

pytestmark = pytest.mark.sim

NAMED_WITHIN = 3
OFF, TOOL_OFF = 0.1 * DEG, 0.1 * MM
"""By how much more a stopping arm may be off its path than it was before."""
ARRIVED = 0.5 * DEG
STILL, SETTLES = 0.1, 0.5 * DEG
"""Below which speed a joint rests, rad/s, and by how much it may settle yet, rad."""


def words(scene: Scene, caplog, error: Exception | None) -> str:
    """Give all that was said."""
    logged = [record.getMessage() for record in caplog.records]
    return "\n".join([*(text for _, text in scene.said), *logged, str(error or "")])


def healthy(scene: Scene, fault: Fault) -> list[int]:
    return [k for k, number in enumerate(scene.joints) if number not in fault.astray]


class Usual:
    """The same motion of the same arm with nothing wrong."""

    def __init__(self, scene: Scene) -> None:
        scene.enter()
        motion, begun = scene.motion(), scene.virtual.rig.now
        assert scene.follow(motion).outcome is ending.Outcome.FINISHED
        self.goals = {
            cycle.index: goals for cycle, goals in zip(scene.cycles, scene.goals, strict=True)
        }
        witness = Witness(scene, motion, begun, scene.virtual.rig.now)
        self.off = witness.off_path(range(len(scene.joints))).max()
        self.tool_off = witness.tool_off_path().max()
        scene.leave()


@pytest.fixture
def usual(scene):
    """Give how an arm goes when nothing is wrong."""

    def give(fault: Fault) -> Usual:
        key = (fault.arm, str(fault.options))
        if key not in _KNOWN:
            _KNOWN[key] = Usual(scene(fault.arm, **fault.options))
        return _KNOWN[key]

    return give


_KNOWN: dict[tuple[str, str], Usual] = {}


def require_path(scene: Scene, fault: Fault, usual: Usual, seen: Witness) -> None:
    """Require that joints that could be told stayed on the path."""
    sound = healthy(scene, fault)
    if sound:
        off = seen.off_path(sound).max()
        assert off <= usual.off + OFF + fault.loose, f"{off / DEG:.3f}, {usual.off / DEG:.3f} deg"
    if not fault.astray:
        off = seen.tool_off_path().max()
        assert off <= usual.tool_off + TOOL_OFF + fault.tool_loose, (
            f"{off / MM:.3f}, {usual.tool_off / MM:.3f} mm"
        )


def require_naming(scene: Scene, usual: Usual, dead: int) -> None:
    """Require that one servo was named in time, and that the others were served in every cycle."""
    joint = scene.joints.index(dead)
    naming = next(index for index, text in scene.said if f"servo {dead} " in text)
    assert naming <= DUE + NAMED_WITHIN
    others = [k for k in range(len(scene.joints)) if k != joint]
    for k, cycle in enumerate(scene.cycles[: DUE + NAMED_WITHIN + 1]):
        assert cycle.index == k
        assert [scene.goals[k][j] for j in others] == [usual.goals[k][j] for j in others]
    heard = np.diff(np.array(scene.heard)[DUE:, others], axis=0) > 0.0
    assert heard[1:].all()  # in the first cycle a fast answer ends at the one that is missing


def require_rest(scene: Scene, since: float) -> None:
    """Require that every joint has rested since then: it only settles under its load."""
    for number in scene.joints:
        after = scene.servo(number).trace.motion().after(since)
        assert np.abs(after.speed).max(initial=0.0) < STILL
        assert len(after.t) == 0 or np.ptp(after.angle) < SETTLES  # no rows: nothing moves


def mend(scene: Scene, fault: Fault) -> None:
    """Do what the person does."""
    for deed in fault.mend:
        deed(scene)


def enter(scene: Scene, fault: Fault) -> None:
    """Open the arm; what is wrong from the start is refused, or it is entered all the same."""
    if fault.early:
        fault.strike(scene)
    if fault.outcome is Outcome.REFUSES:
        before = scene.virtual.q
        with pytest.raises(SplinearmError) as caught:
            scene.enter()
        assert fault.says in str(caught.value)
        np.testing.assert_allclose(scene.virtual.q, before, atol=1e-6)
        mend(scene, fault)
    scene.enter()
    assert scene.rate == fault.rate


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_what_is_written_of_a_fault_is_so(fault, scene, usual, caplog):
    undisturbed = usual(fault)
    caplog.clear()
    here = scene(fault.arm, **fault.options)
    enter(here, fault)
    motion, begun = here.motion(), here.virtual.rig.now
    found = here.follow(motion, None if fault.early else lambda: fault.strike(here))
    struck, rested = begun + DUE / here.rate, here.virtual.rig.now
    goes_on = fault.outcome in (Outcome.GOES_ON, Outcome.REFUSES)
    assert (found.outcome is ending.Outcome.FINISHED) is goes_on
    assert fault.says in words(here, caplog, found.fault) or fault.outcome is Outcome.REFUSES
    require_path(here, fault, undisturbed, Witness(here, motion, begun, rested))
    if fault.outcome is Outcome.HALTS:
        here.wait(1.0)
        require_rest(here, struck + fault.settles)
    if fault.dead is not None:
        require_naming(here, undisturbed, fault.dead)
    assert torque_lost(here) == set(fault.limp)
    if found.stopped is not None:
        mend(here, fault)
        assert here.go_on(found).outcome is ending.Outcome.FINISHED
    here.wait(0.5)
    assert np.abs(here.virtual.q - motion.q_goal).max() < ARRIVED + fault.off
    assert all(here.servo(number).torque_on for number in here.joints)
    require_setpoints_within_limits(here)
    loose = {*fault.limp, *fault.wild}
    whole = Witness(here, motion, begun, here.virtual.rig.now)
    whole.require_limits([k for k, number in enumerate(here.joints) if number not in loose])
