"""The Python of the page on curves runs as it stands, block after block."""


def test_the_python_of_the_page_runs(run_page):
    assert run_page("curves.md") > 10
