"""`python -m bearingsim` is `bearingsim`."""

from bearingsim.cli import main

if __name__ == "__main__":
    main()
