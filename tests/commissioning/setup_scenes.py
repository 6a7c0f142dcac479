"""Servos in memory in the states in which setup may find them."""

from memory_line import MemoryLine, load_cell, set_up

from splinearm.sim.line import speak_protocol_1

KOCH = load_cell("koch_v1_1")
WX250S = load_cell("wx250s")
PLANAR = load_cell("planar_2r")


def fresh(cell=KOCH):
    return MemoryLine(cell)


def ready(cell=KOCH):
    """An arm that is set up, with everything connected."""
    line = MemoryLine(cell)
    set_up(line, cell)
    line.connect()
    line.writes = 0
    return line


def with_registers(cell, **by_name):
    """An arm that was set up and whose registers were changed: name=((register, value), ...)."""
    line = ready(cell)
    for name, registers in by_name.items():
        for register, value in registers:
            line.servos[name].memory[register] = value
    return line


def disordered():
    """An arm with whatever can be wrong and be told without a person's help."""
    line = with_registers(
        KOCH,
        shoulder_pan=(("Drive Mode", 1), ("Return Delay Time", 250)),
        shoulder_lift=(("ID", 3), ("Baud Rate", 1)),
        elbow_flex=(("ID", 2), ("Secondary(Shadow) ID", 4)),
        wrist_flex=(("Baud Rate", 2), ("Operating Mode", 1), ("Max Position Limit", 2000)),
        wrist_roll=(("Homing Offset", 100), ("Status Return Level", 1)),
        gripper=(("PWM Limit", 0), ("Operating Mode", 3), ("Baud Rate", 1)),
    )
    line.servos["wrist_roll"].fail("overload")
    speak_protocol_1(line.servos["shoulder_pan"])
    return line


def swapped():
    """Two servos of different models have each other's ids."""
    return with_registers(KOCH, shoulder_lift=(("ID", 3),), elbow_flex=(("ID", 2),))


def half_fresh():
    """Two servos are set up, the others come out of the box."""
    line = ready()
    for name in ("shoulder_pan", "wrist_flex", "gripper"):
        line.servos[name].swap()
    line.connect("shoulder_lift", "elbow_flex", "wrist_roll")
    return line


SCENES = {
    "fresh": (KOCH, fresh),
    "disordered": (KOCH, disordered),
    "swapped": (KOCH, swapped),
    "half fresh": (KOCH, half_fresh),
    "planar": (PLANAR, lambda: fresh(PLANAR)),
}
