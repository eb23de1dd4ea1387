"""``python -m impedraw``: the command ``impedraw``."""

import sys

from ._program import main

sys.exit(main())
