"""Every reader against changed files: `python -m tests.fuzz scene --seconds 600`, or `heights`, `speeds`, `study` ….

targets    the readers, each as a function of a file's content, and sound inputs to start from
mutations  inputs that stay near sound ones
__main__   the search guided by coverage (Atheris), from the command line
"""
