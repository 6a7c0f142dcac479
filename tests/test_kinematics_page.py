"""The Python of the page on kinematics runs as it stands, block after block."""


def test_the_python_of_the_page_runs(run_page):
    assert run_page("kinematics.md") > 5
