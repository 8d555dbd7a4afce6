"""The robot on a board: what it needs, in one archive that installs without a network."""
