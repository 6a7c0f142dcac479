"""``python -m splinearm``: the command line."""

import sys

from splinearm.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
