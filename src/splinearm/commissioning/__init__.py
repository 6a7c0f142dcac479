"""From servos fresh out of the box to an arm that is ready: ports, settings, backups, calibration.

Nothing here moves a joint or gives a servo torque.
"""
