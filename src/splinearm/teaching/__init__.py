"""Motions taught by hand: recorded while a hand leads the arm, made into curves, kept as jobs."""
