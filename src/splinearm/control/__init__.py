"""Following a motion cycle by cycle, on any arm: clock, guard, loop, stop along the path, record.

Knows drivers and trajectories, nothing of serial ports, servos or simulators.
"""
