"""Toolpaths: contours in the work plane, their offsets, what a cutter makes of them, and G-code.

Knows curves and motions, nothing of servos, simulators or arm files. Lengths are in m here too;
files say what unit they speak.
"""
