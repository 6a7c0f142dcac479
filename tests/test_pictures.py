"""The pictures of the pages: each script draws one, and a page shows it."""

import importlib.util
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

DOCS = Path(__file__).parents[1] / "docs"
PICTURES = DOCS / "pictures"
SHARED = ("style", "motion")
SCRIPTS = sorted(file for file in PICTURES.glob("*.py") if file.stem not in SHARED)
SHOWN = {
    name
    for page in DOCS.glob("*.md")
    for name in re.findall(r"!\[[^\]]+\]\(pictures/([^)]+)\)", page.read_text("utf-8"))
}

LONG = ("arc_length", "arc_move", "facing", "fit", "meeting", "motion_limits", "pace", "surface")
"""Pictures of motions and searches: what they call is compiled for many seconds."""

each_script = pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
each_drawn = pytest.mark.parametrize(
    "script",
    [
        pytest.param(file, id=file.stem, marks=[pytest.mark.slow] * (file.stem in LONG))
        for file in SCRIPTS
    ],
)


def run(script, name):
    spec = importlib.util.spec_from_file_location(name, script)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def save():
    """Draws the picture of a script into a folder, with what the scripts find beside them."""
    before = dict(sys.modules)
    shared = {name: run(PICTURES / f"{name}.py", name) for name in SHARED}

    def drawn(script, folder):
        figure = run(script, f"picture_{script.stem}").draw()
        return shared["style"].save(figure, str(script), folder)

    yield drawn
    for name in (*SHARED, *(f"picture_{script.stem}" for script in SCRIPTS)):
        sys.modules.pop(name, None)
        if name in before:
            sys.modules[name] = before[name]


@each_drawn
def test_a_script_draws_its_picture(script, save, tmp_path):
    file = save(script, tmp_path)
    assert file.name == f"{script.stem}.svg"
    svg = "{http://www.w3.org/2000/svg}"
    paths = ElementTree.parse(file).getroot().iterfind(f".//{svg}g[@id='figure_1']//{svg}path")
    assert max(path.get("d", "").count("L") for path in paths) > 20, "there is no curve in it"


@each_script
def test_a_page_shows_the_picture_of_a_script(script):
    assert f"{script.stem}.svg" in SHOWN
    assert 1000 < script.with_suffix(".svg").stat().st_size < 80_000


def test_every_picture_of_a_page_has_its_script():
    assert {name.removesuffix(".svg") for name in SHOWN} <= {script.stem for script in SCRIPTS}


def test_the_same_picture_is_the_same_file(save, tmp_path):
    files = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        files.append(save(PICTURES / "conic_equation.py", tmp_path / name))
    assert files[0].read_bytes() == files[1].read_bytes()
