import pytest

from splinearm.drivers.bus import Loss, Reply, loss_error
from splinearm.errors import BusTimeoutError, PacketError, ServoError


@pytest.mark.parametrize(
    ("reply", "kind", "message"),
    [
        (
            Reply(b"", 0, Loss.SILENT),
            BusTimeoutError,
            r"2 \(elbow\) does not answer .*on tty",
        ),
        (
            Reply(b"", 0, Loss.DAMAGED),
            PacketError,
            r"damaged packet where .* 2 \(elbow\)",
        ),
        (Reply(b"", 0x87, Loss.REFUSED), ServoError, r"Goal refused: .*access error"),
        (Reply(b"", 0x09, Loss.REFUSED), ServoError, r"refused: error 9"),
    ],
)
def test_each_loss_has_its_error(reply, kind, message):
    error = loss_error(reply, 2, "Goal", port="tty", name="elbow")
    assert type(error) is kind
    with pytest.raises(kind, match=message):
        raise error


def test_a_refusal_keeps_number_and_alert():
    error = loss_error(Reply(b"", 0x87, Loss.REFUSED), 2, "Goal", port="tty", name="elbow")
    assert isinstance(error, ServoError)
    assert (error.code, error.alert, error.name) == (7, True, "elbow")
