"""Rigid-body dynamics as Python calls them for one state; see `direct.bind`.

Each is bound to the model A of `dynamics_kernel` and answers whether it has.
"""

from splinearm.direct import MODEL, WRITE, answer, matrix, vector

from .dynamics_kernel import coriolis_into, forward_into, inverse_into, mass_matrix_into


def inverse_call(model: int, arguments: int, count: int) -> int:
    """Do as `inverse_into` does with (q, qd, qdd, tau)."""
    given = model, arguments
    return answer(
        count == 4
        and inverse_into(
            matrix(given, MODEL),
            vector(given, 0),
            vector(given, 1),
            vector(given, 2),
            vector(given, 3, WRITE),
        )
    )


def mass_matrix_call(model: int, arguments: int, count: int) -> int:
    """Do as `mass_matrix_into` does with (q, M)."""
    given = model, arguments
    return answer(
        count == 2
        and mass_matrix_into(matrix(given, MODEL), vector(given, 0), matrix(given, 1, WRITE))
    )


def coriolis_call(model: int, arguments: int, count: int) -> int:
    """Do as `coriolis_into` does with (q, qd, C)."""
    given = model, arguments
    return answer(
        count == 3
        and coriolis_into(
            matrix(given, MODEL), vector(given, 0), vector(given, 1), matrix(given, 2, WRITE)
        )
    )


def forward_call(model: int, arguments: int, count: int) -> int:
    """Do as `forward_into` does with (q, qd, tau, qdd)."""
    given = model, arguments
    return answer(
        count == 4
        and forward_into(
            matrix(given, MODEL),
            vector(given, 0),
            vector(given, 1),
            vector(given, 2),
            vector(given, 3, WRITE),
        )
    )
