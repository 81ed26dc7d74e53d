"""``python -m gemrender``."""

from gemrender.cli import main

main()
