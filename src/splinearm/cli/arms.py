"""``splinearm arms``: the arms that are shipped."""

import argparse


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "arms", help="list the shipped arms", description="List the shipped arms."
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print a row for each shipped arm."""
    from splinearm.config import load_cell, shipped_arms

    from .output import console, table

    rows = []
    for name in shipped_arms():
        cell = load_cell(name)
        servos = cell.chain.servos if cell.chain is not None else ()
        models = sorted({servo.model for servo in servos})
        convention = cell.arm.convention.value if cell.arm.convention is not None else "frames"
        rows.append(
            (name, cell.title, str(cell.arm.n), str(len(servos)), ", ".join(models), convention)
        )
    console.print(
        table(("arm", "what it is", "joints", "servos", "servo models", "described by"), rows)
    )
    console.print("An arm of your own is one more TOML file: give its path where a name is asked.")
    return 0
