"""What the model number says by which a servo calls itself."""

from splinearm.drivers.model import ServoModel, servo_model_by_number


def model_of(number: int) -> ServoModel | None:
    """Give the model of a number; None: it is not known."""
    try:
        return servo_model_by_number(number)
    except ValueError:
        return None


def model_words(number: int) -> str:
    """Give what a servo is called to people by its model number."""
    model = model_of(number)
    return f"servo of model number {number}" if model is None else model.name
