import string
from decimal import Decimal
from fractions import Fraction
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.config.reader import Table, read_file
from splinearm.errors import ConfigError
from splinearm.joints import JointKind

PI = Fraction("3.1415926535897932384626433832795028841971693993751058")
SI = {
    "_mm": Fraction(1, 1000),
    "_mm_s": Fraction(1, 1000),
    "_mm_s2": Fraction(1, 1000),
    "_deg": PI / 180,
    "_deg_s": PI / 180,
    "_deg_s2": PI / 180,
    "_percent": Fraction(1, 100),
    "_s": Fraction(1),
    "_hz": Fraction(1),
    "_kg": Fraction(1),
    "_kg_m2": Fraction(1),
    "_nm": Fraction(1),
    "": Fraction(1),
}
KEYS = st.text(string.ascii_lowercase + "_", min_size=1, max_size=12)
DECIMALS = st.decimals(allow_nan=False, allow_infinity=False, min_value=-(10**9), max_value=10**9)
TURNS, SLIDES = JointKind.REVOLUTE, JointKind.PRISMATIC


def table(**values: object) -> Table:
    return Table(values, "some.toml", "joint[2]")


def refused(ask) -> ConfigError:
    with pytest.raises(ConfigError) as caught:
        ask()
    assert caught.value.file == "some.toml"
    return caught.value


@pytest.mark.property
@given(value=DECIMALS | st.integers(-(10**12), 10**12), unit=st.sampled_from(sorted(SI)))
def test_a_number_becomes_the_float_nearest_to_what_is_written(value, unit):
    assert table(**{f"x{unit}": value}).number(f"x{unit}") == float(Fraction(value) * SI[unit])


@pytest.mark.property
@given(st.lists(DECIMALS, min_size=3, max_size=3))
def test_many_numbers_are_converted_like_one(values):
    together = table(xyz_mm=values).numbers("xyz_mm", 3)
    assert together.tolist() == [table(x_mm=value).number("x_mm") for value in values]


@pytest.mark.property
@given(keys=st.sets(KEYS, min_size=1, max_size=6), data=st.data())
def test_a_key_that_nobody_asked_for_is_refused(keys, data):
    unread = data.draw(st.sampled_from(sorted(keys)))
    read = Table(dict.fromkeys(sorted(keys), 1), "some.toml")
    for key in keys - {unread}:
        read.integer(key)
    with pytest.raises(ConfigError) as caught:
        read.finish()
    assert caught.value.key == unread
    read.integer(unread)
    read.finish()


def test_a_misspelt_key_gets_the_key_that_was_meant():
    read = table(a_mm=1, alpa_deg=2)
    read.number("a_mm")
    assert "alpha_deg" not in read
    error = refused(read.finish)
    assert error.key == "joint[2].alpa_deg"
    assert error.reason == "is not known here; did you mean 'alpha_deg'?"


def test_an_unlike_key_gets_the_keys_there_are():
    read = table(a_mm=1, colour="red")
    read.number("a_mm")
    assert refused(read.finish).reason == "is not known here; known are a_mm"


@pytest.mark.parametrize("key", ["a_cm", "a_m", "a", "a_inch", "a_deg"])
def test_a_known_key_in_another_unit_is_told_the_unit(key):
    asked = table(**{key: 1})
    error = refused(lambda: asked.number("a_mm"))
    assert error.key == f"joint[2].{key}"
    assert error.reason == "is not known here; this wants millimetres: a_mm"
    optional = table(**{key: 1})
    assert "a_mm" not in optional
    assert refused(optional.finish).reason == error.reason


def test_a_missing_key_is_named_with_what_it_wants():
    error = refused(lambda: table().number("max_speed_deg_s"))
    assert error.key == "joint[2].max_speed_deg_s"
    assert error.reason == "is missing; give a number in degrees per second"


def test_a_missing_key_is_told_of_a_key_that_looks_like_it():
    error = refused(lambda: table(max_sped_deg_s=3).number("max_speed_deg_s"))
    assert "is 'max_sped_deg_s' meant to be it?" in error.reason


def test_an_entry_with_a_name_is_called_by_it():
    error = refused(lambda: table(name="elbow", d_mm="x").number("d_mm"))
    assert error.reason == "wants a number in millimetres, got \"x\" (in 'elbow')"


@pytest.mark.parametrize(
    ("value", "shown"),
    [(True, "true"), ("12", '"12"'), ([1], r"[1]"), ({}, "a table")],
)
def test_what_is_no_number_is_shown(value, shown):
    assert refused(lambda: table(x_mm=value).number("x_mm")).reason == (
        f"wants a number in millimetres, got {shown}"
    )


@pytest.mark.parametrize("value", [Decimal("NaN"), Decimal("Infinity"), Decimal("1e400"), 10**400])
def test_a_number_that_is_not_finite_is_refused(value):
    assert "finite" in refused(lambda: table(x_mm=value).number("x_mm")).reason
    error = refused(lambda: table(xyz_mm=[0, value, 0]).numbers("xyz_mm", 3))
    assert error.key == "joint[2].xyz_mm[1]"


def test_bounds_are_said_in_the_unit_of_the_key():
    read = table(x_mm=-5, share_percent=130, y_mm=0)
    error = refused(lambda: read.number("x_mm", low=-0.001))
    assert error.reason == "wants a number in millimetres of -1 or more, got -5"
    error = refused(lambda: read.number("share_percent", high=1.0))
    assert error.reason == "wants a number in percent of at most 100, got 130"
    assert "above 0, got 0" in refused(lambda: read.number("y_mm", above=0.0)).reason


def test_a_default_is_for_a_missing_key_only():
    read = table(rate_hz=50)
    assert read.number("rate_hz", 100.0) == 50.0
    assert read.number("x_mm", 0.25) == 0.25
    assert read.text("title", "") == ""
    assert read.integer("baud", 9) == 9
    assert read.flag("closed") is False
    assert read.choice("kind", ["a", "b"], "b") == "b"


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1, 2], "wants 3 numbers in millimetres, got 2: [1, 2]"),
        (5, "wants 3 numbers in millimetres, got 5"),
        ([1, True, 3], "wants a number in millimetres, got true"),
        ([1, "2", 3], 'wants a number in millimetres, got "2"'),
    ],
)
def test_a_list_must_have_its_length_and_numbers_only(value, message):
    assert refused(lambda: table(xyz_mm=value).numbers("xyz_mm", 3)).reason == message


def test_positions_are_one_a_joint_in_the_unit_of_the_joint():
    both = table(home_deg_mm=[180, 250]).positions("home", ["a", "b"], [TURNS, SLIDES])
    assert both.tolist() == [float(PI), 0.25]
    error = refused(lambda: table(home_deg=[1, 2, 3]).positions("home", ["a", "b"], [TURNS] * 2))
    assert error.reason == "wants 2 numbers, one a joint (a, b), got 3: [1, 2, 3]"
    error = refused(lambda: table(home_rad=[1, 2]).positions("home", ["a", "b"], [TURNS] * 2))
    assert error.reason == "is not known here; this wants degrees: home_deg"
    error = refused(lambda: table(home_deg=[1, 2]).positions("home", ["a", "b"], [TURNS, SLIDES]))
    assert error.reason.endswith("millimetres (sliding joints): home_deg_mm")


def test_a_whole_number_is_no_truth_value_and_has_no_point():
    for value in (True, Decimal("2.0"), "2"):
        assert "wants a whole number" in refused(lambda v=value: table(id=v).integer("id")).reason
    assert table(id=0).integer("id", low=0, high=252) == 0
    error = refused(lambda: table(id=300).integer("id", low=0, high=252))
    assert error.reason == "wants a whole number from 0 to 252, got 300"


def test_a_word_may_stand_for_a_whole_number():
    assert (
        table(zero_ticks="calibrate").integer_or("zero_ticks", "calibrate", low=0, high=9) is None
    )
    assert table(zero_ticks=5).integer_or("zero_ticks", "calibrate", low=0, high=9) == 5
    error = refused(
        lambda: table(zero_ticks="later").integer_or("zero_ticks", "calibrate", low=0, high=9)
    )
    assert error.reason == 'wants a whole number or "calibrate", got "later"'


def test_texts_choices_and_flags_refuse_other_types():
    assert "not empty" in refused(lambda: table(name=" ").text("name")).reason
    assert "wants a text" in refused(lambda: table(name=3).text("name")).reason
    assert "true or false, got 1" in refused(lambda: table(closed=1).flag("closed")).reason
    error = refused(lambda: table(role="leder").choice("role", ["leader", "shadow"]))
    assert error.reason == ('wants one of "leader", "shadow", got "leder"; did you mean "leader"?')


def test_tables_know_their_paths():
    root = Table({"joint": [{}, {"a_mm": "x"}], "base": {"b_mm": "y"}}, "some.toml")
    error = refused(lambda: root.tables("joint")[1].number("a_mm"))
    assert error.key == "joint[1].a_mm"
    assert refused(lambda: root.table("base").number("b_mm")).key == "base.b_mm"
    assert root.tables("servo") == []
    assert list(root.table("tool")) == []


def test_a_table_is_no_list_of_tables():
    assert "wants tables [[joint]]" in refused(lambda: table(joint={}).tables("joint")).reason
    assert "wants a table [base]" in refused(lambda: table(base=[{}]).table("base")).reason


def test_a_value_error_inside_becomes_the_file_s():
    read = table(q=3)

    def ask() -> None:
        with read.blaming("q"):
            raise ValueError("q: want more")

    error = refused(ask)
    assert (error.key, error.reason) == ("joint[2].q", "q: want more")


def test_a_file_is_read_exactly(tmp_path):
    path = tmp_path / "x.toml"
    path.write_bytes(b'\xef\xbb\xbfschema = "s/1"\r\na_mm = 65.66\r\nb_mm = 1_000\r\n')
    root = read_file(path, "s/1")
    assert root.number("a_mm") == 0.06566
    assert root.number("b_mm") == 1.0
    root.finish()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('schema = "s/1"\na_mm = \n', r"is not TOML: .*\(at line 2, column 8\)"),
        ('schema = "s/1"\na_mm = 1\na_mm = 2\n', r"is not TOML: .*line 3"),
        (f"x = 1e{'9' * 30}\n", "too large"),
        (f"x = {'9' * 5000}\n", "is not TOML"),
        (f"x = {'[' * 5000}\n", "nested too deeply"),
    ],
)
def test_a_file_that_is_not_toml_is_told_the_line(tmp_path, text, reason):
    path = tmp_path / "x.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=reason) as caught:
        read_file(path, "s/1")
    assert caught.value.file == str(path)
    assert "put that line right" in caught.value.reason


def test_a_file_that_cannot_be_read_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"cannot be read .*; check its name"):
        read_file(tmp_path / "none.toml", "s/1")
    path = tmp_path / "latin.toml"
    path.write_bytes(b"title = '\xe4'\n")
    with pytest.raises(ConfigError, match="save it as UTF-8"):
        read_file(path, "s/1")


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text('schema = "s/2"\n')
    with pytest.raises(ConfigError, match='schema: wants "s/1", got "s/2"'):
        read_file(path, "s/1")
    path.write_text("")
    with pytest.raises(ConfigError, match="schema: is missing"):
        read_file(path, "s/1")


def test_floats_that_bypass_toml_are_refused():
    for value in (nan, inf, 1.5):
        assert "wants a number" in refused(lambda v=value: table(x_mm=v).number("x_mm")).reason
