"""Where a user's own files lie."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from splinearm.config.folder import _configuration_folder, is_there, user_folder
from splinearm.errors import ConfigError


@pytest.fixture
def nothing_set(monkeypatch):
    for name in ("SPLINEARM_HOME", "XDG_CONFIG_HOME", "APPDATA"):
        monkeypatch.delenv(name, raising=False)


def test_tests_never_see_the_folder_of_whoever_runs_them(tmp_path_factory):
    assert user_folder().is_relative_to(tmp_path_factory.getbasetemp())
    code = "from splinearm.config.folder import user_folder; print(user_folder())"
    printed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert printed.stdout.strip() == os.environ["SPLINEARM_HOME"]


def test_the_variable_comes_first_and_may_begin_at_home(monkeypatch):
    monkeypatch.setenv("SPLINEARM_HOME", "~/arms")
    assert user_folder() == Path.home() / "arms"


def test_what_is_relative_is_relative_to_where_one_stands(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SPLINEARM_HOME", "mine")
    assert user_folder() == tmp_path / "mine"


@pytest.mark.parametrize(
    ("platform", "variable", "inside"),
    [
        ("linux", "XDG_CONFIG_HOME", ".config"),
        ("win32", "APPDATA", "AppData/Roaming"),
    ],
)
def test_each_system_has_its_place(nothing_set, monkeypatch, tmp_path, platform, variable, inside):
    assert _configuration_folder(platform) == Path.home() / inside
    monkeypatch.setenv(variable, str(tmp_path))
    assert _configuration_folder(platform) == tmp_path


def test_a_relative_xdg_folder_is_ignored(nothing_set, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", "here")
    assert _configuration_folder("linux") == Path.home() / ".config"


def test_macos_knows_no_variable(nothing_set):
    assert _configuration_folder("darwin") == Path.home() / "Library/Application Support"
    assert user_folder().name == "splinearm"


@pytest.mark.parametrize("own", ["~nobody-of-that-name", "~nobody-of-that-name/arms"])
def test_a_home_that_is_nobody_s_is_refused_in_a_line(monkeypatch, own):
    monkeypatch.setenv("SPLINEARM_HOME", own)
    with pytest.raises(ConfigError, match="no such home folder; set SPLINEARM_HOME"):
        user_folder()


def test_a_name_that_no_file_can_have_is_refused(tmp_path):
    assert not is_there(tmp_path / "a")
    with pytest.raises(ConfigError, match="cannot be looked at"):
        is_there(tmp_path / ("x" * 300))
