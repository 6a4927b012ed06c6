"""Entry point of `python -m bearingsim`, which is equivalent to `bearingsim`."""

from bearingsim.cli import main

if __name__ == "__main__":
    main()
