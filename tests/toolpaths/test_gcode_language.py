"""The language of NC programs: values, parameters, comments and control words."""

from math import isclose

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.errors import GcodeError
from splinearm.toolpaths.gcode_block import read_block
from splinearm.toolpaths.gcode_expression import NoValueError, Reader
from splinearm.toolpaths.gcode_flow import Runner, beside, read_program
from splinearm.toolpaths.gcode_memory import Memory, ParameterError


def value(text, memory=None):
    reader = Reader("".join(text.split()).lower())
    work = reader.value()
    assert not reader.rest
    return work(Memory() if memory is None else memory)


def run(text, memory=None, load=None):
    """Give the values of X words in the order in which they are reached."""
    memory = Memory() if memory is None else memory
    runner = Runner(read_program(text, "part.ngc"), memory, load)
    found = []
    for file, block in runner.blocks():
        found += [
            runner.value(file, block, word.value) for word in block.words if word.letter == "x"
        ]
        for setting in block.settings:
            given = runner.value(file, block, setting.value)
            if isinstance(setting.target, str):
                memory.set_named(setting.target, given)
            else:
                memory.set_numbered(runner.value(file, block, setting.target), given)
    return found


# the values are those that LinuxCNC's rs274 (2.9) gives for the same words
@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("[1+2**3*2]", 17), ("[7 mod 2]", 1), ("[-7 mod 3]", 2), ("[-7 mod -3]", 2),
        ("[7 MOD -3]", 1), ("round[2.5]", 3), ("round[-2.5]", -3), ("fix[-2.5]", -3),
        ("fix[2.5]", 2), ("fup[-2.5]", -2), ("[2**3**2]", 64), ("[-2**2]", 4),
        ("[1 eq 1 and 0]", 0), ("atan[1]/[-1]", 135), ("[1--1]", 2), ("[1 or 0 and 0]", 0),
        ("[2*3/4*2]", 3), ("[1 gt 0 eq 1]", 1), ("[2 + 3 gt 4]", 1), ("-[3]", -3), ("+.5", 0.5),
        ("-.5", -0.5), ("[5-3-1]", 1), ("[2 eq 2.00001]", 1), ("exists[#<q>]", 0),
        ("-sin[30]", -0.5), ("--5", 5), ("1 2. 5", 12.5), ("[1 xor 1]", 0), ("[3 ne 3]", 0),
        ("[2 le 2]", 1),
    ],
)  # fmt: skip
def test_values_are_those_of_linuxcnc(text, wanted):
    assert isclose(value(text), wanted, abs_tol=1e-12)


@pytest.mark.property
@given(st.integers(-99, 99), st.integers(-99, 99), st.integers(1, 99))
def test_the_usual_rules_of_arithmetic_hold(a, b, c):
    assert isclose(value(f"[{a}+{b}*{c}-{a}/{c}]"), a + b * c - a / c, abs_tol=1e-9)
    assert value(f"[[{a}] gt [{b}]]") == (a > b)


@pytest.mark.parametrize(
    "text", ["[1/0]", "sqrt[-1]", "ln[0]", "acos[2]", "[-8**.5]", "exp[9999]", "[0**-1]"]
)
def test_what_has_no_value_is_refused(text):
    with pytest.raises(NoValueError):
        value(text)


def test_parameters_are_local_global_named_and_indirect():
    memory = Memory({"_line": lambda: 7.0})
    memory.set_numbered(100, 3)
    memory.set_numbered(3, 8)
    memory.set_named("_depth", 2)
    memory.set_named("near", 1)
    assert value("##100", memory) == 8
    assert value("#[97+3]", memory) == 3
    memory.enter([5])
    assert value("#1", memory) == 5
    assert value("#3", memory) == 0
    assert value("#100", memory) == 3
    assert value("#<_depth>", memory) == 2
    assert value("#<_line>", memory) == 7
    with pytest.raises(ParameterError, match="near"):
        value("#<near>", memory)
    memory.leave()
    assert value("#<near>", memory) == 1
    for wrong in (0, 5603, 1.5):
        with pytest.raises(ParameterError):
            memory.numbered(wrong)
    for number in (5400, 5420):
        with pytest.raises(ParameterError, match="only be read"):
            memory.set_numbered(number, 1)


def test_a_line_is_read_whatever_its_spaces_and_capitals():
    block = read_block("/ N10 g0X +1 0 Y#<A b> (up) #3=#1 ; end", 4, "part.ngc")
    assert [word.letter for word in block.words] == ["g", "x", "y"]
    assert block.words[1].value(Memory()) == 10
    assert block.comments == ("up", "end")
    assert block.optional
    assert [setting.text for setting in block.settings] == ["#3=#1"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("g1 x", "got the end of the line"),
        ("g1 x[1+", "got the end of the line"),
        ("g1 x1 (no end", "does not end"),
        ("g1 (a (b) c)", "comment within a comment"),
        ("g1 x1 5 y&", "want"),
        ("x" + "9" * 400, "too large"),
        ("x" + "[" * 1000 + "1" + "]" * 1000, "deep"),
        ("x" + "-" * 1000 + "1", "deep"),
        ("x" + "#" * 1000 + "1", "deep"),
        ("o1 jump", "want one of sub"),
        ("o1 if [1] x", "end of the line"),
        ("g0 o1 sub", "first of its line"),
        ("x" * 5000, "characters long"),
        ("#<>=1", "name"),
        ("xnan", "want a number"),
        ("g1 x1\x00", "want"),
    ],
)
def test_what_is_no_line_names_line_and_word(text, reason):
    with pytest.raises(GcodeError, match=reason) as caught:
        read_block(text, 12, "part.ngc")
    assert str(caught.value).startswith("part.ngc:12: ")
    assert caught.value.line == 12


def test_subroutines_take_arguments_and_give_values_back():
    text = """
    o<twice> sub
      x#1
      o<twice> return [#1 * 2]
      x99
    o<twice> endsub
    x0
    o<twice> call [4]
    x[5]
    """
    assert run(text) == [0, 4, 5]
    runner = Runner(read_program(text, "part.ngc"), Memory())
    assert [block.line for _, block in runner.blocks()] == [7, 3, 9]
    assert runner.returned == (8.0, True)


def test_branches_and_loops_run_as_they_say():
    assert run("""
    #100 = 0
    o1 while [#100 lt 5]
      #100 = [#100 + 1]
      o2 if [#100 eq 2]
        o1 continue
      o2 elseif [#100 eq 4]
        o1 break
      o2 else
        x#100
      o2 endif
    o1 endwhile
    o3 do
      x[10 + #100]
      #100 = [#100 - 1]
    o3 while [#100 gt 2]
    o4 repeat [2]
      x7
    o4 endrepeat
    """) == [1, 3, 14, 13, 7, 7]


def test_a_subroutine_calls_itself_to_a_depth_and_then_is_refused():
    text = "o1 sub\n o2 if [#1 gt 0]\n x#1\n o1 call [#1-1]\n o2 endif\no1 endsub\no1 call [{}]"
    assert run(text.format(3)) == [3, 2, 1]
    with pytest.raises(GcodeError, match="more than 10 calls"):
        run(text.format(30))


def test_subroutines_are_found_in_files_beside_the_program(tmp_path):
    (tmp_path / "hole.ngc").write_text("o<hole> sub\nx#1\no<hole> endsub\nm2\n")
    assert run("o<hole> call [3]\no<hole> call [4]", load=beside(tmp_path / "part.ngc")) == [3, 4]
    with pytest.raises(GcodeError, match="no subroutine other"):
        run("o<other> call", load=beside(tmp_path / "part.ngc"))
    with pytest.raises(GcodeError, match="no subroutine"):
        run("o<../hole> call", load=beside(tmp_path / "part.ngc"))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("o1 sub\nx1", "no endsub"),
        ("x1\no1 endif", "nothing that this endif ends"),
        ("o1 while [1]\no2 endwhile", "nothing that this endwhile ends"),
        ("o1 if\no1 endif", "wants 1 value"),
        ("o1 call", "no subroutine 1"),
        ("o1 break", "no loop"),
        ("o1 sub\no1 endsub\no1 sub\no1 endsub", "two subroutines"),
        ("".join(f"o{i} if [1]\n" for i in range(1000)), "deep"),
        ("o1 while [1]\no1 endwhile", "has it an end"),
    ],
)
def test_control_words_that_do_not_belong_together_are_refused(monkeypatch, text, reason):
    monkeypatch.setattr("splinearm.toolpaths.gcode_flow.MOST_BLOCKS", 1000)
    with pytest.raises(GcodeError, match=reason) as caught:
        run(text)
    assert "\n" not in str(caught.value)


def test_what_stands_outside_of_percent_signs_is_left_out():
    assert run("%\nx1\n%\nx2") == [1]
    assert run("x1\nx2") == [1, 2]
