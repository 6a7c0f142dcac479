"""The Python of the page on trajectories runs as it stands, block after block."""


def test_the_python_of_the_page_runs(run_page, tmp_path, monkeypatch):
    # what the page writes is written here
    monkeypatch.chdir(tmp_path)
    assert run_page("trajectories.md") > 10
