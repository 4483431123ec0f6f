"""`python -m fem` is `run-fem`, where the commands' folder is on no path."""

from fem.commands.entry import run_fem

if __name__ == "__main__":
    run_fem()
