"""``python -m implicitrt`` is the command line."""

import sys

from implicitrt.cli import main

sys.exit(main())
