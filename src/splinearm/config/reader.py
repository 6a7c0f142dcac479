"""TOML files as typed values in SI, with nothing in them left unread.

The end of a key says its unit (``a_mm``, ``alpha_deg``, ``speed_mm_s``). A `Table` hands out each
value in SI and remembers what was asked for; `Table.finish` then refuses every key that nobody
asked for, so that a misspelt or misunderstood key never passes in silence.
"""

import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from decimal import Decimal, InvalidOperation
from difflib import get_close_matches
from math import isfinite
from os import PathLike
from pathlib import Path

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ConfigError
from splinearm.joints import JointKind

from .unit import Unit, joint_units, positions_key, same_but_for_unit, unit_of

_KEYS_SHOWN = 16


class Table:
    """The typed values of one TOML table, each handed out in SI.

    Every method that takes a key remembers it as known. A missing or wrong value is a
    `ConfigError` with the file, the full path of the key (entries count from 0) and the remedy.
    """

    def __init__(self, values: Mapping[str, object], file: str, path: str = "") -> None:
        self.file = file
        self.path = path
        self._values = values
        self._known: dict[str, None] = {}

    def __contains__(self, key: str) -> bool:
        """Whether the file gives the key."""
        self._known[key] = None
        return key in self._values

    def __iter__(self) -> Iterator[str]:
        """The keys that the file gives, in its order."""
        return iter(self._values)

    def is_list(self, key: str) -> bool:
        """Whether the file gives a list there."""
        return key in self and isinstance(self._values[key], list)

    def is_text(self, key: str) -> bool:
        """Whether the file gives a text there."""
        return key in self and isinstance(self._values[key], str)

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        above: float | None = None,
        low: float | None = None,
        high: float | None = None,
    ) -> float:
        """Give a finite number in SI; ``default`` (in SI) if the file does not give it.

        Args:
            key: The key; its end says the unit.
            default: What to give for a missing key; without it the key must be there.
            above: What the number must be above, in SI.
            low: The lowest that it may be, in SI.
            high: The highest that it may be, in SI.

        Raises:
            ConfigError: If it is missing, no finite number, or out of bounds.
        """
        if key not in self and default is not None:
            return default
        unit = unit_of(key)
        value = self._si(key, self._value(key, f"a number{unit}"), unit)
        if above is not None and value <= above:
            wanted = f"above {unit.of_si(above):g}"
        elif low is not None and value < low:
            wanted = f"of {unit.of_si(low):g} or more"
        elif high is not None and value > high:
            wanted = f"of at most {unit.of_si(high):g}"
        else:
            return value
        raise self.refuse(key, f"wants a number{unit} {wanted}, got {self._shown(key)}")

    def numbers(self, key: str, length: int) -> FloatArray:
        """Give ``length`` finite numbers in SI, shape (length,)."""
        unit = unit_of(key)
        listed = self._list(key, f"{length} numbers{unit}", length)
        return np.array([self._si(key, value, unit, i) for i, value in enumerate(listed)])

    def positions(self, stem: str, names: Sequence[str], kinds: Sequence[JointKind]) -> FloatArray:
        """Give one position a joint, rad or m, shape (n,).

        The key is ``stem_deg``, or ``stem_deg_mm`` if the arm has sliding joints, whose positions
        then are in millimetres.
        """
        key = positions_key(stem, kinds)
        listed = self._list(
            key, f"{len(names)} numbers, one a joint ({', '.join(names)})", len(names)
        )
        units = joint_units(kinds)
        return np.array([self._si(key, listed[i], unit, i) for i, unit in enumerate(units)])

    def every_number(self, key: str) -> FloatArray:
        """Give a list of finite numbers, however many, in SI, shape (k,)."""
        unit = unit_of(key)
        listed = self._any_list(key, f"numbers{unit}")
        return np.array([self._si(key, value, unit, i) for i, value in enumerate(listed)])

    def every_position(
        self, stem: str, names: Sequence[str], kinds: Sequence[JointKind]
    ) -> FloatArray:
        """Give a list of lists with one position a joint, however many, rad or m, shape (k, n).

        The key is as for ``positions``.
        """
        key = positions_key(stem, kinds)
        wanted = f"lists of {len(names)} numbers, one a joint ({', '.join(names)})"
        units, rows = joint_units(kinds), []
        for k, row in enumerate(self._any_list(key, wanted)):
            if not isinstance(row, list) or len(row) != len(names):
                raise self.refuse(f"{key}[{k}]", f"wants {wanted}, got {_shown(row)}")
            each = zip(row, units, strict=True)
            rows.append([self._si(f"{key}[{k}]", value, u, i) for i, (value, u) in enumerate(each)])
        return np.array(rows).reshape(-1, len(names))

    def integer(
        self,
        key: str,
        default: int | None = None,
        *,
        low: int | None = None,
        high: int | None = None,
    ) -> int:
        """Give a whole number from ``low`` to ``high``, both included."""
        if key not in self and default is not None:
            return default
        value = self._value(key, "a whole number")
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.refuse(key, f"wants a whole number, got {self._shown(key)}")
        if (low is not None and value < low) or (high is not None and value > high):
            bounds = f"from {low} to {high}" if high is not None else f"of {low} or more"
            raise self.refuse(key, f"wants a whole number {bounds}, got {self._shown(key)}")
        return value

    def integer_or(self, key: str, word: str, *, low: int, high: int) -> int | None:
        """Give a whole number from ``low`` to ``high``, or None if the file says ``word``."""
        value = self._value(key, f'a whole number or "{word}"')
        if value == word:
            return None
        if isinstance(value, str):
            raise self.refuse(key, f'wants a whole number or "{word}", got {self._shown(key)}')
        return self.integer(key, low=low, high=high)

    def text(self, key: str, default: str | None = None) -> str:
        """Give a text that is not empty; an empty ``default`` is allowed."""
        if key not in self and default is not None:
            return default
        value = self._value(key, "a text in quotes")
        if not isinstance(value, str) or not value.strip():
            raise self.refuse(key, f"wants a text in quotes, not empty, got {self._shown(key)}")
        return value

    def choice(self, key: str, options: Collection[str], default: str | None = None) -> str:
        """Give one of the texts in ``options``."""
        if key not in self and default is not None:
            return default
        listed = ", ".join(f'"{option}"' for option in options)
        wanted = f"one of {listed}" if len(options) > 1 else listed
        value = self._value(key, wanted)
        if isinstance(value, str) and value in options:
            return value
        near = self._near(str(value), options)
        hint = f'; did you mean "{near}"?' if near else ""
        raise self.refuse(key, f"wants {wanted}, got {self._shown(key)}{hint}")

    def flag(self, key: str, *, default: bool = False) -> bool:
        """Give true or false."""
        if key not in self:
            return default
        value = self._value(key, "true or false")
        if not isinstance(value, bool):
            raise self.refuse(key, f"wants true or false, got {self._shown(key)}")
        return value

    def table(self, key: str) -> "Table":
        """Give the table ``[key]``; an empty one if the file does not have it."""
        value = self._values[key] if key in self else {}
        if not isinstance(value, dict):
            raise self.refuse(key, f"wants a table [{key}], got {self._shown(key)}")
        return Table(value, self.file, self._full(key))

    def tables(self, key: str) -> list["Table"]:
        """Give the tables ``[[key]]``; none if the file does not have any."""
        value = self._values[key] if key in self else []
        if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
            raise self.refuse(key, f"wants tables [[{key}]], got {self._shown(key)}")
        path = self._full(key)
        return [Table(entry, self.file, f"{path}[{i}]") for i, entry in enumerate(value)]

    def finish(self, reason: str = "is not known here") -> None:
        """Refuse the first key that nobody asked for, for that ``reason``.

        Raises:
            ConfigError: With what was probably meant.
        """
        for key in self._values:
            if key not in self._known:
                raise self.refuse(key, f"{reason}; {self._meant(key)}")

    def refuse(self, key: str, reason: str) -> ConfigError:
        """Give the error that blames ``key`` of this table (the table itself if it is empty)."""
        name = self._values.get("name")
        whose = f" (in {name!r})" if self.path and isinstance(name, str) and key != "name" else ""
        return ConfigError(self.file, self._full(key) if key else self.path, f"{reason}{whose}")

    @contextmanager
    def blaming(self, key: str) -> Iterator[None]:
        """Turn a value error inside the with-block into the `ConfigError` that blames ``key``."""
        try:
            yield
        except (ValueError, TypeError) as error:
            raise self.refuse(key, str(error)) from error

    def _full(self, key: str) -> str:
        return f"{self.path}.{key}" if self.path else key

    def _value(self, key: str, wanted: str) -> object:
        if key in self:
            return self._values[key]
        for present in self._values:
            if present not in self._known and same_but_for_unit(present, key):
                raise self.refuse(present, f"is not known here; {_wants(key)}")
        near = self._near(key, [k for k in self._values if k not in self._known])
        hint = f"; is {near!r} meant to be it?" if near else ""
        raise self.refuse(key, f"is missing; give {wanted}{hint}")

    def _any_list(self, key: str, wanted: str) -> list[object]:
        value = self._value(key, wanted)
        if not isinstance(value, list):
            raise self.refuse(key, f"wants {wanted}, got {self._shown(key)}")
        return value

    def _list(self, key: str, wanted: str, length: int) -> list[object]:
        value = self._any_list(key, wanted)
        if len(value) != length:
            raise self.refuse(key, f"wants {wanted}, got {len(value)}: {self._shown(key)}")
        return value

    def _si(self, key: str, value: object, unit: Unit, index: int | None = None) -> float:
        if index is not None:
            key = f"{key}[{index}]"
        if isinstance(value, bool) or not isinstance(value, int | Decimal):
            raise self.refuse(key, f"wants a number{unit}, got {_shown(value)}")
        converted = unit.to_si(value)
        if not isfinite(converted):
            raise self.refuse(key, f"wants a number{unit} that is finite, got {_shown(value)}")
        return converted

    def _shown(self, key: str) -> str:
        return _shown(self._values[key])

    def _meant(self, key: str) -> str:
        for known in self._known:
            if same_but_for_unit(key, known):
                return _wants(known)
        missing = [known for known in self._known if known not in self._values]
        near = self._near(key, missing) or self._near(key, self._known)
        if near:
            return f"did you mean {near!r}?"
        keys = list(self._known)
        shown = ", ".join(keys[:_KEYS_SHOWN]) + (", ..." if len(keys) > _KEYS_SHOWN else "")
        return f"known are {shown}" if keys else "take it out"

    @staticmethod
    def _near(key: str, others: Collection[str]) -> str | None:
        return next(iter(get_close_matches(key, others, n=1)), None)


def read_file(file: str | PathLike[str], schema: str) -> Table:
    """Give the root table of a TOML file after checking what kind of file it says it is.

    Args:
        file: The file.
        schema: What its key ``schema`` must say.

    Raises:
        ConfigError: If it cannot be read, is not TOML, or says that it is something else.
    """
    path = Path(file)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ConfigError(file, "", "is not UTF-8 text; save it as UTF-8") from error
    except (OSError, ValueError) as error:  # no name may hold a NUL
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(file, "", f"cannot be read ({reason}); check its name") from error
    try:
        values = tomllib.loads(text, parse_float=_exact)
    except (ValueError, RecursionError) as error:
        reason = str(error) if isinstance(error, ValueError) else "tables are nested too deeply"
        raise ConfigError(file, "", f"is not TOML: {reason}; put that line right") from error
    root = Table(values, str(file))
    root.choice("schema", [schema])
    return root


def _exact(text: str) -> Decimal:
    try:
        return Decimal(text)
    except InvalidOperation as error:
        raise ValueError(f"{text[:40]} is too large for a number") from error


def _wants(key: str) -> str:
    return f"this wants {unit_of(key).name}: {key}"


def _shown(value: object) -> str:
    """Show a value as the file has it, shortened."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        shown = f'"{value}"'
    elif isinstance(value, list):
        shown = f"[{', '.join(_shown(entry) for entry in value[:8])}]"
    elif isinstance(value, dict):
        shown = "a table"
    else:
        shown = str(value)
    return shown if len(shown) <= 80 else f"{shown[:77]}..."
